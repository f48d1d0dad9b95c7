// Rows of the tables that runs and simulations return: the columns of forces.csv (docs/formats.md).
#pragma once

#include <cstdint>
#include <glm/geometric.hpp>

#include "kerf/run.h"
#include "kerf/slab.h"

namespace kerf::python {

/// `visit` is a ColumnLister or a Table.
template <typename V>
void VisitPose(const char* position, const char* w, const char* x, const char* y, const char* z, const Pose& X,
               V&& visit) {
  visit(position, X.p_AB);
  visit(w, X.R_AB.w);
  visit(x, X.R_AB.x);
  visit(y, X.R_AB.y);
  visit(z, X.R_AB.z);
}

template <typename V>
void VisitTeeth(const TeethOutput& out, double removed_total_mm3, V&& visit) {
  visit("thrust_sum_N", out.thrust_sum_N);
  visit("thrust_W", out.thrust_W);
  visit("cutting_sum_N", out.cutting_sum_N);
  visit("cutting_W", out.cutting_W);
  visit("engaged_teeth", out.engaged_teeth);
  visit("mean_bite_um", 1000 * out.mean_bite_mm);
  visit("mean_E_GPa", out.mean_E_MPa / 1000);
  visit("main_region", static_cast<std::int64_t>(out.main_region));
  visit("removed_mm3", out.removed_mm3);
  visit("removed_total_mm3", removed_total_mm3);
  visit("status", static_cast<std::int64_t>(out.status));
}

/// A tick of a tool on a path.
template <typename V>
void VisitTick(double time_s, const Pose& X_WT, const TickOutput& out, double removed_total_mm3, V&& visit) {
  visit("time_s", time_s);
  VisitPose("{}_mm", "qw", "qx", "qy", "qz", X_WT, visit);
  visit("force_{}_N", out.f_T_W_N);
  visit("torque_{}_Nmm", out.tau_TG_W_Nmm);
  VisitTeeth(out, removed_total_mm3, visit);
}

/// A tick of a tool in a hand.
template <typename V>
void VisitHandTick(double time_s, const Pose& X_WH, const CoupledOutput& out, double removed_total_mm3, V&& visit) {
  visit("time_s", time_s);
  VisitPose("handle_{}_mm", "handle_qw", "handle_qx", "handle_qy", "handle_qz", X_WH, visit);
  VisitPose("tool_{}_mm", "tool_qw", "tool_qx", "tool_qy", "tool_qz", out.X_WT, visit);
  visit("hand_{}_N", out.f_H_W_N);
  visit("hand_torque_{}_Nmm", out.tau_H_W_Nmm);
  visit("cut_{}_N", out.f_cut_W_N);
  visit("face_{}_N", out.f_face_W_N);
  visit("friction_{}_N", out.f_friction_W_N);
  VisitTeeth(out, removed_total_mm3, visit);
  visit("hand_mJ", out.hand_mJ);
  visit("spindle_mJ", out.spindle_mJ);
  visit("stored_mJ", out.stored_mJ);
  visit("cut_mJ", out.cut_mJ);
  visit("friction_mJ", out.friction_mJ);
  visit("damping_mJ", out.damping_mJ);
  visit("numerical_mJ", out.numerical_mJ);
  visit("substeps", static_cast<std::int64_t>(out.substeps));
  visit("iterations", static_cast<std::int64_t>(out.iterations));
  visit("fidelity", static_cast<std::int64_t>(out.fidelity));
}

template <typename V>
void VisitSlabState(const SlabState& s, V&& visit) {
  visit("blade_mm", s.blade_mm);
  visit("left_mm", s.left_mm);
  visit("right_mm", s.right_mm);
  visit("depth_mm", s.depth_mm);
  visit("deepest_mm", s.deepest_mm);
  visit("free", static_cast<std::int64_t>(s.free));
  visit("sticking", static_cast<std::int64_t>(s.sticking));
  visit("kinetic_mJ", s.kinetic_mJ);
  visit("elastic_mJ", s.elastic_mJ);
  visit("hand_work_mJ", s.hand_work_mJ);
  visit("friction_mJ", s.friction_mJ);
  visit("cutting_mJ", s.cutting_mJ);
  visit("damping_mJ", s.damping_mJ);
  visit("released_mJ", s.released_mJ);
  visit("numerical_mJ", s.numerical_mJ);
}

/// A tick of a slab.
template <typename V>
void VisitSlabTick(double time_s, const Pose& X, const TickOutput& out, const SlabState& state, V&& visit) {
  visit("time_s", time_s);
  VisitPose("{}_mm", "qw", "qx", "qy", "qz", X, visit);
  visit("force_{}_N", out.f_T_W_N);
  visit("thrust_sum_N", out.thrust_sum_N);
  visit("thrust_W", out.thrust_W);
  visit("engaged_teeth", out.engaged_teeth);
  visit("mean_E_GPa", out.mean_E_MPa / 1000);
  visit("main_region", static_cast<std::int64_t>(out.main_region));
  visit("status", static_cast<std::int64_t>(out.status));
  VisitSlabState(state, visit);
}

}  // namespace kerf::python
