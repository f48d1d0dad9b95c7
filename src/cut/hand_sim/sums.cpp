// What a tick gives: forces, energies and material, added up over its substeps.
#include <algorithm>
#include <cmath>

#include "cut/hand_sim/state.h"

namespace kerf {

/// Adds the forces, the energies and the material in contact, for a substep with motion `u` over `time_s`.
void CoupledSimulation::State::AddUp(double time_s, Sums& sums, CoupledOutput& out) {
  sums.f_damper_W = sums.tau_damper_W = Vec3(0);
  sums.time_s += time_s;
  if (problem.empty()) return;
  sums.touched = true;
  double teeth_now = 0;
  Vec3 f_edge_T(0);
  Vec3 f_face_T(0);
  Vec3 f_friction_T(0);
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const CuttingPoint& p = problem.cutting[i];
    const double speed = Dot(p.row, u);
    sums.teeth.teeth += time_s * p.teeth;
    teeth_now += p.teeth;
    sums.teeth.E_MPa += time_s * p.teeth * p.cut.E_MPa;
    const double along = problem.arc_rad > 0 ? Dot(p.along, u) : 0;
    const ToothMean mean = problem.MeanToothForce(p, speed, along);
    if (!(speed > 0) && !(mean.radial_N > 0)) continue;
    const double force = p.teeth * mean.radial_N;
    f_edge_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    double magnitude = force, work_mJ = time_s * force * speed;
    if (mean.along_N != 0) {
      magnitude = p.teeth * std::hypot(mean.radial_N, mean.along_N);
      f_edge_T -= p.teeth * mean.along_N * Vec3(p.along[0], p.along[1], p.along[2]);
      work_mJ += time_s * p.teeth * mean.along_N * along;
    }
    sums.teeth.thrust_N += time_s * magnitude;
    sums.teeth.AddThrustPower(magnitude, time_s, p.cut.speed_mm_per_s);
    if (problem.law.HasCutting()) {
      const double cutting = p.teeth * problem.MeanCuttingForce(p, speed, mean);
      sums.teeth.AddCutting(cutting, time_s, p.cut.speed_mm_per_s);
    }
    const auto region = static_cast<std::size_t>(edge.contacts()[i].region);
    sums.teeth.thrust_by_region_N[region] += time_s * magnitude;
    out.regions_cut[region / 64] |= std::uint64_t{1} << (region % 64);
    sums.teeth.bite_mm += time_s * p.teeth * std::max(speed, 0.0) / problem.passes_per_s;
    out.cut_mJ += std::max(0.0, work_mJ);  // < 0 only by rounding: the potential is convex and minimal at rest
  }
  for (const FlatPoint& p : problem.flats) {
    const double speed = p.side * (u[2] + u[3] * p.y - u[4] * p.x);
    const double force = problem.flat_stiffness_N_per_mm * std::max(0.0, p.depth_mm + problem.tau_s * speed);
    f_face_T.z -= force * p.side;
    sums.given_mJ -= time_s * force * speed;
  }
  for (std::size_t i = 0; i < problem.solids.size(); ++i) {
    const SolidPoint& p = problem.solids[i];
    const double speed = Dot(p.row, u);
    const double force = p.stiffness_N_per_mm * std::max(0.0, p.depth_mm + problem.tau_s * speed);
    if (i < first_of_effects) f_face_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    if (i < edge.found_count() && edge.is_tooth(i) && force > 0 && (out.status & kCoupledSpindleStopped) == 0) {
      out.status |= kCoupledTouchesMetal;
    }
    sums.given_mJ -= time_s * force * speed;
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  for (const FrictionPoint& p : problem.frictions) {
    const double own_a = Dot(p.row_a, u);
    const double own_b = Dot(p.row_b, u);
    const double a = own_a + p.slip_a_mm_per_s;
    const double b = own_b + p.slip_b_mm_per_s;
    const double factor = p.limit_N / std::sqrt(a * a + b * b + creep2);
    f_friction_T -=
        factor * (a * Vec3(p.row_a[0], p.row_a[1], p.row_a[2]) + b * Vec3(p.row_b[0], p.row_b[1], p.row_b[2]));
    // If friction drives the tool, the spindle does the work.
    const double power = factor * (a * own_a + b * own_b);
    (power >= 0 ? out.friction_mJ : out.spindle_mJ) += time_s * std::abs(power);
  }
  if (bone_fraction == 1) {
    f_cut_T = f_edge_T;
    teeth = teeth_now;
  }
  for (const YieldPoint& p : problem.yields) {
    const double speed = Dot(p.row, u);
    if (!(speed > 0)) continue;
    const double force = p.Force(speed, problem.creep_mm_per_s);
    f_edge_T -= force * Vec3(p.row[0], p.row[1], p.row[2]);
    sums.teeth.thrust_N += time_s * force;
    out.cut_mJ += time_s * force * speed;
  }
  sums.f_cut_W += time_s * X_WT.Vector(f_edge_T);
  sums.f_face_W += time_s * X_WT.Vector(f_face_T);
  sums.f_friction_W += time_s * X_WT.Vector(f_friction_T);
  const StepCoupling& c = problem.coupling;
  const Vec3 v(u[0], u[1], u[2]);
  const Vec3 w(u[3], u[4], u[5]);
  sums.given_mJ += time_s * (glm::dot(c.CalcSpringForce(problem.tau_s * v), v) +
                             glm::dot(c.torsion.Force(c.theta_rad - problem.tau_s * w), w));
  const Vec3 slip = c.v_H_mm_per_s - v;
  const Vec3 turn = c.w_H_rad_per_s - w;
  const Vec3 f = c.CalcDamperForce(v);
  const Vec3 tau = c.torsion_damper.Force(turn);
  out.hand_mJ += time_s * (glm::dot(f, c.v_H_mm_per_s) + glm::dot(tau, c.w_H_rad_per_s));
  out.damping_mJ += time_s * (glm::dot(f, slip) + glm::dot(tau, turn));
  sums.f_damper_W = -X_WT.Vector(f);
  sums.tau_damper_W = -X_WT.Vector(tau);
}

/// Sets the output: means over the completed time, and the load on the hand.
void CoupledSimulation::State::Publish(const Sums& sums, CoupledOutput& out) const {
  out.X_WT = World(X_WT);
  const Coupling::Load load = coupling.CalcLoadOnHand(X_WT, X_WH);
  out.f_H_W_N = load.f_W_N + sums.f_damper_W;
  out.tau_H_W_Nmm = load.tau_W_Nmm + sums.tau_damper_W;
  if (load.limited) out.status |= kCoupledForceLimited;
  if (sums.time_s > 0) {
    out.f_cut_W_N = sums.f_cut_W / sums.time_s;
    out.f_face_W_N = sums.f_face_W / sums.time_s;
    out.f_friction_W_N = sums.f_friction_W / sums.time_s;
    sums.teeth.Report(sums.time_s, out);
  }
}

}  // namespace kerf
