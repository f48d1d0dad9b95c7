#include "experiment/stability/invariants.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cut/contact/spring.h"
#include "cut/hand_sim/coupling.h"
#include "cut/tool/shape.h"

namespace kerf::test {
namespace {

std::string Text(const Vec3& v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}

double CalcTurnAngle(const Quat& a, const Quat& b) {
  return glm::length(LogRotation(glm::conjugate(a) * b));
}

double Sum(const std::array<double, 256>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

constexpr std::uint32_t kLagging = kCoupledSubstepsUsedUp | kCoupledLeavesUsedUp;

}  // namespace

Invariants::Invariants(CoupledSimulation& simulation, const Pose& X_WT_start, const Options& options)
    : simulation_(simulation),
      params_(simulation.params()),
      options_(options),
      h_(simulation.UpdateBone().voxel_mm()),
      watch_(std::make_unique<BoneWatch>(simulation.UpdateBone(), params_.tool, CutWith::kEdge)),
      X_WT_(X_WT_start),
      X_WH_(X_WT_start) {}

void Invariants::WatchDevice(const DeviceProfile& profile, const ForceMapParams& force_map) {
  device_ = Watched{profile, force_map, Vec3(0), Vec3(0)};
}

void Invariants::Fail(const std::string& invariant, const std::string& what) {
  const std::string text = fmt::format("{} in tick {}: {}", invariant, ticks_, what);
  if (!violations_.emplace(invariant, text).second || !options_.report) return;
  ADD_FAILURE() << text;
}

bool Invariants::CheckFinite(const CoupledOutput& out) {
  if (!IsValid(out.X_WT)) Fail("I1", "the tool's pose is invalid");
  const std::pair<const char*, Vec3> vectors[] = {{"force on the hand", out.f_H_W_N},
                                                  {"torque on the hand", out.tau_H_W_Nmm},
                                                  {"force of the edge", out.f_cut_W_N},
                                                  {"force of the faces", out.f_face_W_N},
                                                  {"friction", out.f_friction_W_N}};
  for (const auto& [name, v] : vectors) {
    if (!IsFinite(v)) Fail("I1", fmt::format("{} is {}", name, Text(v)));
  }
  const std::pair<const char*, double> numbers[] = {
      {"thrust", out.thrust_sum_N},      {"engaged teeth", out.engaged_teeth}, {"modulus", out.mean_E_MPa},
      {"bite", out.mean_bite_mm},        {"removed volume", out.removed_mm3},  {"the hand's work", out.hand_mJ},
      {"the spindle's", out.spindle_mJ}, {"stored energy", out.stored_mJ},     {"cutting's", out.cut_mJ},
      {"friction's", out.friction_mJ},   {"damping's", out.damping_mJ},        {"numerical loss", out.numerical_mJ}};
  for (const auto& [name, value] : numbers) {
    if (!std::isfinite(value)) Fail("I1", fmt::format("{} is {}", name, value));
  }
  return !violations_.contains("I1");
}

void Invariants::CheckBounds(const CoupledInput& in, const CoupledOutput& out) {
  const CouplingParams& c = params_.coupling;
  const double f = glm::length(out.f_H_W_N);
  const double tau = glm::length(out.tau_H_W_Nmm);
  const double max_f = (c.damping_Ns_per_mm > 0 ? 2 : 1) * c.max_force_N;
  const double max_tau = (c.torsion_damping_Nmms > 0 ? 2 : 1) * c.max_torque_Nmm;
  largest_force_N_ = std::max(largest_force_N_, f);
  if (!(f <= max_f * (1 + 1e-12))) Fail("I2", fmt::format("the force is {} N, at most {} allowed", f, max_f));
  if (!(tau <= max_tau * (1 + 1e-12))) {
    Fail("I2", fmt::format("the torque is {} N mm, at most {} allowed", tau, max_tau));
  }
  if (out.substeps > params_.max_substeps || out.substeps < 0) {
    Fail("I2", fmt::format("{} substeps, at most {} allowed", out.substeps, params_.max_substeps));
  }
  if (out.iterations > params_.max_iterations || out.iterations < 0) {
    Fail("I2", fmt::format("{} iterations, at most {} allowed", out.iterations, params_.max_iterations));
  }
  if (out.thrust_sum_N < 0 || out.engaged_teeth < 0 || out.mean_E_MPa < 0 || out.mean_bite_mm < 0) {
    Fail("I2", fmt::format("thrust {} N, {} teeth, {} MPa, bite {} mm: one is negative", out.thrust_sum_N,
                           out.engaged_teeth, out.mean_E_MPa, out.mean_bite_mm));
  }
  // A quaternion whose length is not exactly 1 stretches what it rotates, by up to twice the error of its square.
  const Quat& q = out.X_WT.R_AB;
  const Quat& q_before = X_WT_.R_AB;
  const double off = std::max(std::abs(glm::dot(q, q) - 1), std::abs(glm::dot(q_before, q_before) - 1));
  if (glm::length(out.f_cut_W_N) > out.thrust_sum_N * (1 + 1e-9 + 2 * off) + 1e-12) {
    Fail("I2", fmt::format("the edge's force is {} N, but its teeth's thrusts add up to {}", glm::length(out.f_cut_W_N),
                           out.thrust_sum_N));
  }
  if (!(out.removed_mm3 >= 0)) Fail("I5", fmt::format("{} mm^3 removed", out.removed_mm3));
  if (std::abs(in.rpm) < kMinRpm && !slab_ && out.removed_mm3 != 0) {
    Fail("I5", fmt::format("{} mm^3 removed with the spindle stopped", out.removed_mm3));
  }
}

void Invariants::CheckAir(const CoupledInput& in, const CoupledOutput& out) {
  const bool lags = (out.status & kLagging) != 0;
  const bool asleep = (out.status & kCoupledAsleep) != 0;
  // Bone closer than 1.5 voxels counts as near (docs/tick.md). The tick finds this with the plates of MakeToolCover(),
  // which extend to 1.07 times the disc's radius. That matters only in slab mode and in the transition from it, where
  // the guide holds a disc near bone.
  const bool has_guide = out.fidelity == Fidelity::kSlab || (out.status & kCoupledBlending) != 0;
  const double cover_mm = has_guide ? 0.08 * CalcReach(params_.tool) : 0;
  const bool clear = !watch_->MayTouch(X_WT_, in.X_WH, 2 * h_ + cover_mm) && !lags;
  if (asleep || clear) {
    if (out.f_H_W_N != Vec3(0) || out.tau_H_W_Nmm != Vec3(0)) {
      Fail("I3",
           fmt::format("in the air the force is {} N, the torque {} N mm", Text(out.f_H_W_N), Text(out.tau_H_W_Nmm)));
    }
    if (out.X_WT.p_AB != in.X_WH.p_AB || out.X_WT.R_AB != in.X_WH.R_AB) {
      Fail("I3",
           fmt::format("in the air the tool is {} mm from the handle", glm::length(out.X_WT.p_AB - in.X_WH.p_AB)));
    }
    if (out.removed_mm3 != 0 && !slab_) Fail("I3", fmt::format("in the air {} mm^3 were removed", out.removed_mm3));
    return;
  }
  // If bone was near but nothing held the tool, the remaining force is the solver's residual, 1e-8 of 1 N.
  const bool held = out.engaged_teeth > 0 || out.f_cut_W_N != Vec3(0) || out.f_face_W_N != Vec3(0) ||
                    out.f_friction_W_N != Vec3(0) || out.thrust_sum_N != 0 || lags || out.fidelity == Fidelity::kSlab ||
                    (out.status & (kCoupledBlending | kCoupledIterationsUsedUp)) != 0;
  if (!held && glm::length(out.f_H_W_N) > 1e-6) {
    Fail("I3", fmt::format("nothing holds the tool, but the force is {} N", Text(out.f_H_W_N)));
  }
}

/// Returns the bending of the blade, whose stiffness is in series with the coupling's.
Bending Invariants::FindBending(const Pose& X_WH) const {
  const double side_N_per_mm = CalcSideStiffness(params_.tool);
  if (!params_.coupling.blade_bends || side_N_per_mm == 0) return {};
  const double compliance_mm_per_N = 1 / params_.coupling.stiffness_N_per_mm + 1 / side_N_per_mm;
  return {X_WH.Vector({0, 0, 1}), 1 / std::sqrt(compliance_mm_per_N * params_.coupling.stiffness_N_per_mm)};
}

void Invariants::CheckForce(const CoupledInput& in, const CoupledOutput& out) {
  const CouplingParams& c = params_.coupling;
  const SaturatingSpring spring{c.stiffness_N_per_mm, c.max_force_N};
  const SaturatingSpring torsion{c.torsion_Nmm_per_rad, c.max_torque_Nmm};
  const Bending bending = FindBending(in.X_WH);
  const Vec3 f = bending.Scale(spring.Force(bending.Scale(out.X_WT.Point(c.p_TC_mm) - in.X_WH.Point(c.p_TC_mm))));
  const Vec3 tau = torsion.Force(-out.X_WT.Vector(LogRotation(glm::conjugate(out.X_WT.R_AB) * in.X_WH.R_AB)));
  // Relative errors of positions are 2e-16, and of angles 1e-15. They are multiplied by a stiff spring; errors of
  // speeds are multiplied by a damper.
  const double far_mm = glm::length(in.X_WH.p_AB) + glm::length(c.p_TC_mm);
  const double dt_s = in.dt_s;
  const double min_f = (1e-12 + 1e-15 * far_mm) * (c.stiffness_N_per_mm + c.damping_Ns_per_mm / dt_s) +
                       1e-12 * (c.max_force_N + c.damping_Ns_per_mm * glm::length(in.v_H_W_mm_per_s));
  const double min_tau = 1e-13 * (c.torsion_Nmm_per_rad + c.torsion_damping_Nmms / dt_s) +
                         1e-12 * (c.max_torque_Nmm + c.torsion_damping_Nmms * glm::length(in.w_H_W_rad_per_s));
  const Vec3 f_rest = out.f_H_W_N - f;
  const Vec3 tau_rest = out.tau_H_W_Nmm - tau;
  const SaturatingSpring damper{c.damping_Ns_per_mm, c.max_force_N};
  const SaturatingSpring torsion_damper{c.torsion_damping_Nmms, c.max_torque_Nmm};
  // The damper's force depends on the speed of the handle relative to the tool. In a step over the whole tick, the
  // tool's speed is its motion divided by the tick. Without contact the damper has no effect.
  const Vec3 v_T = (out.X_WT.Point(c.p_TC_mm) - X_WT_.Point(c.p_TC_mm)) / dt_s;
  const Vec3 w_T = X_WT_.Vector(LogRotation(glm::conjugate(X_WT_.R_AB) * out.X_WT.R_AB)) / dt_s;
  const Vec3 f_damper = -bending.Scale(damper.Force(bending.Scale(in.v_H_W_mm_per_s - v_T)));
  const Vec3 tau_damper = -torsion_damper.Force(in.w_H_W_rad_per_s - w_T);
  const bool whole = out.substeps == 1 && (out.status & kLagging) == 0;
  // With several substeps the speed of the last one is not known, so the bound is the damper's maximum force.
  const bool parts = out.substeps > 0 && !whole;
  const double max_f = c.damping_Ns_per_mm > 0 && parts ? c.max_force_N : 0;
  const double max_tau = c.torsion_damping_Nmms > 0 && (parts || !turning_reported_) ? c.max_torque_Nmm : 0;
  const bool f_is_damped = whole && glm::length(f_rest - f_damper) <= min_f + 1e-9 * glm::length(f_damper);
  const bool tau_is_damped = whole && glm::length(tau_rest - tau_damper) <= min_tau + 1e-9 * glm::length(tau_damper);
  if (!(glm::length(f_rest) <= max_f + min_f) && !f_is_damped) {
    Fail("I17", fmt::format("the force on the hand is {} N, but the spring between tool and handle gives {}, the "
                            "damper {}",
                            Text(out.f_H_W_N), Text(f), whole ? Text(f_damper) : fmt::format("at most {}", max_f)));
  }
  // At half a turn both directions are equally short.
  if (CalcTurnAngle(out.X_WT.R_AB, in.X_WH.R_AB) < 3.1 && !(glm::length(tau_rest) <= max_tau + min_tau) &&
      !tau_is_damped) {
    Fail("I17",
         fmt::format("the torque on the hand is {} N mm, but the spring between tool and handle gives {}, the "
                     "damper {}",
                     Text(out.tau_H_W_Nmm), Text(tau), whole ? Text(tau_damper) : fmt::format("at most {}", max_tau)));
  }
  // In a step over the whole tick, the forces are those at its end, and the tool has no mass. They were computed in the
  // frame at its start, for small rotations.
  const bool one_step = out.substeps == 1 && (out.status & (kLagging | kCoupledIterationsUsedUp)) == 0 &&
                        out.fidelity != Fidelity::kSlab && (out.status & kCoupledBlending) == 0 &&
                        out.X_WT.p_AB != in.X_WH.p_AB;
  if (!one_step) return;
  const double turned = CalcTurnAngle(X_WT_.R_AB, out.X_WT.R_AB);
  const double in_play = glm::length(out.f_H_W_N) + out.thrust_sum_N + glm::length(out.f_face_W_N) +
                         glm::length(out.f_friction_W_N) + glm::length(out.tau_H_W_Nmm) / CalcReach(params_.tool);
  // The spring of a rotated tool has a different lever arm: its attachment moves on a circle instead of along the
  // tangent.
  const double bent_mm = 0.5 * turned * turned * (glm::length(c.p_TC_mm) + CalcReach(params_.tool));
  const Vec3 left = out.f_cut_W_N + out.f_face_W_N + out.f_friction_W_N - out.f_H_W_N;
  // Bone stiffer than steel makes the cutting force so steep that the rounding of a speed shows. The slope scales with
  // E.
  const double residual = out.mean_E_MPa > 1e6 ? 1e-4 * std::max(1.0, out.mean_E_MPa / 1e7) : 1e-6;
  const double allowed = residual * (1 + in_play) + 2 * turned * in_play + c.stiffness_N_per_mm * bent_mm;
  if (!(glm::length(left) <= allowed)) {
    Fail("I17", fmt::format("the tool has no mass, but the forces on it add up to {} N (edge {}, faces {}, "
                            "friction {}, hand {})",
                            glm::length(left), Text(out.f_cut_W_N), Text(out.f_face_W_N), Text(out.f_friction_W_N),
                            Text(-out.f_H_W_N)));
  }
}

void Invariants::CheckStep(const CoupledInput& in, const CoupledOutput& out) {
  const bool held =
      out.engaged_teeth > 0 || out.f_face_W_N != Vec3(0) || out.f_friction_W_N != Vec3(0) || out.thrust_sum_N != 0;
  if (out.substeps != 1 || !held || out.X_WT.p_AB == in.X_WH.p_AB) return;
  // These are the bounds of docs/tick.md. The path of the tool's origin is slightly curved if the tool rotates.
  constexpr double kBent = 1.02;
  const Vec3 motion = X_WT_.InverseVector(out.X_WT.p_AB - X_WT_.p_AB);
  const bool is_blade = IsBlade(params_.tool);
  const double across = is_blade ? std::hypot(motion.x, motion.y) : glm::length(motion);
  if (!(across <= kBent * 0.5 * h_)) {
    Fail("I7", fmt::format("the tool moved {} voxels in one look-up of the bone", across / h_));
  }
  if (!is_blade) return;
  const double tilt = glm::length(glm::cross(X_WT_.Vector({0, 0, 1}), out.X_WT.Vector({0, 0, 1})));
  const double along = std::abs(motion.z) + tilt * CalcRadius(params_.tool);
  // With half of the tilt, motion across the spindle becomes motion along it.
  const double allowed = 0.25 * std::min(h_, CalcThickness(params_.tool)) + 0.5 * tilt * across;
  if (!(along <= kBent * allowed)) {
    Fail("I7", fmt::format("the rim moved {} mm along the spindle in one look-up, at most {} allowed", along, allowed));
  }
}

double Invariants::CalcCouplingEnergy(const Pose& X_WT, const Pose& X_WH) const {
  const CouplingParams& c = params_.coupling;
  return SaturatingSpring{c.stiffness_N_per_mm, c.max_force_N}.Energy(
             FindBending(X_WH).Scale(X_WH.Point(c.p_TC_mm) - X_WT.Point(c.p_TC_mm))) +
         SaturatingSpring{c.torsion_Nmm_per_rad, c.max_torque_Nmm}.Energy(
             LogRotation(glm::conjugate(X_WT.R_AB) * X_WH.R_AB));
}

void Invariants::CheckEnergy(const CoupledInput& in, const CoupledOutput& out) {
  const double in_play =
      std::abs(out.hand_mJ) + out.spindle_mJ + std::abs(out.stored_mJ) + out.cut_mJ + out.friction_mJ + out.damping_mJ;
  const double open =
      out.hand_mJ + out.spindle_mJ - out.stored_mJ - out.cut_mJ - out.friction_mJ - out.damping_mJ - out.numerical_mJ;
  // Each energy is summed independently. The imbalance is the work of the forces that the solver leaves unbalanced:
  // 1e-8 of all forces, which may be a thousand times those that do work, or more if it ran out of iterations.
  const double fraction = (out.status & kCoupledIterationsUsedUp) != 0 ? 1e-3 : 1e-5;
  if (!(std::abs(open) <= fraction * in_play + 1e-8)) {
    Fail("I15", fmt::format("the energy balance of the tick is off by {} mJ of {}", open, in_play));
  }
  if (out.cut_mJ < 0 || out.friction_mJ < 0 || out.damping_mJ < 0 || out.spindle_mJ < 0) {
    Fail("I15", fmt::format("cutting took {} mJ, friction {}, damping {}, the spindle gave {}: one is negative",
                            out.cut_mJ, out.friction_mJ, out.damping_mJ, out.spindle_mJ));
  }
  if (std::abs(in.rpm) < kMinRpm && (out.spindle_mJ != 0 || (out.cut_mJ != 0 && !slab_))) {
    Fail("I15", fmt::format("the spindle is stopped, but gave {} mJ; cutting took {}", out.spindle_mJ, out.cut_mJ));
  }
  // The hand does its work first: the handle moves while the tool is held. In free air both move together.
  const double was = CalcCouplingEnergy(X_WT_, X_WH_);
  const double drawn = CalcCouplingEnergy(X_WT_, in.X_WH);
  // Far from the origin, poses lose their last digits.
  const double lost_mm = 1e-15 * glm::length(in.X_WH.p_AB);
  const double tolerance = 1e-9 * (was + drawn) + 1e-9 + lost_mm * params_.coupling.max_force_N;
  const bool damped = params_.coupling.damping_Ns_per_mm > 0 || params_.coupling.torsion_damping_Nmms > 0;
  if (!damped && out.hand_mJ != 0 && !(std::abs(out.hand_mJ - (drawn - was)) <= tolerance)) {
    Fail("I15", fmt::format("the hand did {} mJ of work, but the spring gained {}", out.hand_mJ, drawn - was));
  }
  if (!damped && out.hand_mJ == 0 && std::abs(drawn - was) > tolerance && glm::length(out.f_H_W_N) > 1e-6) {
    Fail("I15", fmt::format("the hand stretched the spring by {} mJ, but no work is reported", drawn - was));
  }
  hand_mJ_ += out.hand_mJ;
  spindle_mJ_ += out.spindle_mJ;
  stored_mJ_ += out.stored_mJ;
  lost_mJ_ += out.cut_mJ + out.friction_mJ + out.numerical_mJ;
  const double put_in_mJ = hand_mJ_ + spindle_mJ_ + set_down_mJ_;
  max_mJ_ = std::max(max_mJ_, std::abs(hand_mJ_) + std::abs(spindle_mJ_) + std::abs(set_down_mJ_));
  const double rounding = 1e-7 * (1 + max_mJ_);  // the solver's residual of the forces, over the whole motion
  const double coupling_mJ = CalcCouplingEnergy(out.X_WT, in.X_WH);
  if (!(stored_mJ_ >= coupling_mJ - 1e-9 * (1 + max_mJ_))) {
    Fail("I15", fmt::format("{} mJ are stored, but the coupling's spring alone holds {}", stored_mJ_, coupling_mJ));
  }
  if (!(lost_mJ_ >= -rounding)) {
    Fail("I15", fmt::format("cut + friction + numerical add up to {} mJ since the start", lost_mJ_));
  }
  if (!(put_in_mJ >= -rounding)) {
    Fail("I15", fmt::format("the hand has put in {} mJ, the spindle {}: the sum is negative", hand_mJ_, spindle_mJ_));
  }
}

void Invariants::Tick(const CoupledInput& given, const CoupledOutput& out) {
  CoupledInput in = given;
  in.X_WH = WithUnitRotation(given.X_WH);
  ++ticks_;
  if (!CheckFinite(out)) return;
  if ((out.status & kCoupledBadPose) != 0) {
    if (out.f_H_W_N != Vec3(0) || out.tau_H_W_Nmm != Vec3(0) || out.removed_mm3 != 0 || out.hand_mJ != 0 ||
        out.X_WT.p_AB != X_WT_.p_AB || out.X_WT.R_AB != X_WT_.R_AB) {
      Fail("I3", "a bad input had an effect");
    }
    f_H_W_N_ = tau_H_W_Nmm_ = Vec3(0);
    return;
  }
  if (!IsValid(in.X_WH) || !IsFinite(in.v_H_W_mm_per_s) || !IsFinite(in.w_H_W_rad_per_s) || !std::isfinite(in.rpm) ||
      !std::isfinite(in.dt_s)) {
    Fail("I1", "an input that is not finite was accepted");
    return;
  }
  if ((out.status & kCoupledNoTime) != 0) {
    if (out.removed_mm3 != 0 || out.hand_mJ != 0 || out.X_WT.p_AB != X_WT_.p_AB || out.X_WT.R_AB != X_WT_.R_AB ||
        out.f_H_W_N != f_H_W_N_ || out.tau_H_W_Nmm != tau_H_W_Nmm_) {
      Fail("I3", "a time step that is too short had an effect");
    }
    return;
  }
  slab_ = slab_ || out.fidelity == Fidelity::kSlab || (out.status & kCoupledBlending) != 0;
  CheckBounds(in, out);
  CheckAir(in, out);
  CheckForce(in, out);
  CheckStep(in, out);
  CheckEnergy(in, out);
  removed_mm3_ += out.removed_mm3;
  removed_since_check_mm3_ += out.removed_mm3;
  if (options_.watch_bone) {
    // Substeps within a tick may deviate from a straight line, but each is at most three quarters of a voxel long.
    const double motion_mm = glm::length(out.X_WT.p_AB - X_WT_.p_AB);
    const double steps_mm = 0.75 * h_ * out.substeps;
    double stray_mm = 0;
    if (slab_) stray_mm += 0.5 * h_;
    if (out.substeps > 1) {
      stray_mm += motion_mm < steps_mm ? 0.5 * std::sqrt(steps_mm * steps_mm - motion_mm * motion_mm) : steps_mm;
    }
    const bool cut =
        out.substeps > 0 && std::abs(in.rpm) >= kMinRpm && !slab_ && (out.status & (kLagging | kCoupledAsleep)) == 0;
    // In free air the tool moves towards the handle.
    if (out.substeps > 1 && motion_mm > steps_mm) watch_->Move(X_WT_, in.X_WH, stray_mm, false);
    watch_->Move(X_WT_, out.X_WT, stray_mm, cut);
  }
  X_WT_ = out.X_WT;
  X_WH_ = in.X_WH;
  f_H_W_N_ = out.f_H_W_N;
  tau_H_W_Nmm_ = out.tau_H_W_Nmm;
}

void Invariants::Step(const HapticTick& out, double slew_dt_s) {
  const bool ticked = (out.faults & (kHapticReadFailed | kHapticBadSample)) == 0;
  if (ticked) {
    CoupledInput tick;
    tick.X_WH = out.X_WH;
    tick.v_H_W_mm_per_s = out.v_H_W_mm_per_s;
    tick.dt_s = out.in.dt_s;
    tick.rpm = out.in.rpm;
    turning_reported_ = false;
    Tick(tick, out.coupled);
  } else {
    ++ticks_;
  }
  if (!device_) return;
  Watched& d = *device_;
  const Vec3& f = out.force.f_H_W_N;
  const Vec3& tau = out.force.tau_H_W_Nmm;
  const double peak = d.profile.peak_force_N;
  const bool turns = d.profile.degrees_of_freedom == 6;
  const double peak_tau = turns ? d.profile.peak_torque_Nmm : 0;
  if (!IsFinite(f) || !IsFinite(tau)) {
    Fail("I1", fmt::format("the device gets {} N, {} N mm", Text(f), Text(tau)));
    return;
  }
  if (!(std::hypot(f.x, f.y, f.z) <= peak) || !(glm::length(f) <= peak)) {
    Fail("I2", fmt::format("the device gets {} N, but its peak is {}", glm::length(f), peak));
  }
  if (!(std::hypot(tau.x, tau.y, tau.z) <= peak_tau)) {
    Fail("I2", fmt::format("the device gets {} N mm, but its peak is {}", glm::length(tau), peak_tau));
  }
  const double dt_s = std::min({out.in.dt_s, slew_dt_s, 0.1});
  const double slew = d.force_map.slew_N_per_s > 0 ? d.force_map.slew_N_per_s : peak / 0.005;
  const double slew_tau = d.force_map.slew_Nmm_per_s > 0 ? d.force_map.slew_Nmm_per_s : peak_tau / 0.005;
  if (out.faults != kHapticOk) {
    if (f != Vec3(0) || tau != Vec3(0)) {
      Fail("I3", fmt::format("the device gets {} N despite a fault ({})", Text(f), out.faults));
    }
  } else if ((out.force.status & kForceMapThermalLimited) == 0) {
    const double step = glm::length(f - d.f_N);
    const double step_tau = glm::length(tau - d.tau_Nmm);
    if (!(step <= slew * dt_s * (1 + 1e-9)) || !(step_tau <= slew_tau * dt_s * (1 + 1e-9))) {
      Fail("I2", fmt::format("the device force changes by {} N, {} N mm in {} s; the slew is {} N/s, {} N mm/s", step,
                             step_tau, dt_s, slew, slew_tau));
    }
  }
  const double scale = std::min(1.0, peak / d.force_map.expected_peak_N);
  const Vec3& asked = out.coupled.f_H_W_N;
  if (!(glm::length(f) <= std::max(glm::length(d.f_N), scale * glm::length(asked)) * (1 + 1e-12))) {
    Fail("I2", fmt::format("the device gets {} N for a requested {} N, at a scale of {}", glm::length(f),
                           glm::length(asked), scale));
  }
  if (out.faults == kHapticOk && (out.force.status & (kForceMapSlewLimited | kForceMapThermalLimited)) == 0) {
    const double off = glm::length(glm::cross(f, asked));
    if (!(off <= 1e-9 * glm::length(f) * glm::length(asked)) || glm::dot(f, asked) < 0) {
      Fail("I2", fmt::format("the device gets {} N for a requested {} N: the direction differs", Text(f), Text(asked)));
    }
    if (out.force.ramp == 1 && (out.force.status & kForceMapForceLimited) == 0 &&
        !(glm::length(f - scale * asked) <= 1e-12 * peak)) {
      Fail("I2",
           fmt::format("the device gets {} N for a requested {} N, at a scale of {}", Text(f), Text(asked), scale));
    }
  }
  d.f_N = f;
  d.tau_Nmm = tau;
}

void Invariants::SetDown(const Pose& X_WT) {
  X_WT_ = WithUnitRotation(X_WT);
  f_H_W_N_ = tau_H_W_Nmm_ = Vec3(0);
  // The springs' energy is that of the new pose, without work by the hand.
  const double stored_mJ = CalcCouplingEnergy(X_WT_, X_WH_);
  set_down_mJ_ += stored_mJ - stored_mJ_;
  stored_mJ_ = stored_mJ;
}

void Invariants::CheckBone() {
  if (!options_.watch_bone) return;
  const double exact_mm3 = Sum(simulation_.CalcRemovedByRegion());
  BoneWatch::Removed removed{removed_since_check_mm3_, exact_mm3};
  if (slab_) removed.by_ticks_mm3 = -1;
  for (const std::string& text : watch_->Check(simulation_.UpdateBone(), removed))
    Fail(text.substr(0, 2), text.substr(4));
  removed_since_check_mm3_ = 0;
}

PathInvariants::PathInvariants(Simulation& simulation, const SimulationParams& params, const Pose& X_WT_start,
                               bool report)
    : simulation_(simulation),
      params_(params),
      report_(report),
      watch_(simulation.UpdateBone(), params.tool, CutWith::kWholeTool),
      X_WT_(X_WT_start) {}

void PathInvariants::Fail(const std::string& invariant, const std::string& what) {
  const std::string text = fmt::format("{} in tick {}: {}", invariant, ticks_, what);
  if (!violations_.emplace(invariant, text).second || !report_) return;
  ADD_FAILURE() << text;
}

void PathInvariants::Tick(const TickInput& in, const TickOutput& out) {
  ++ticks_;
  if (!IsFinite(out.f_T_W_N) || !IsFinite(out.tau_TG_W_Nmm) || !std::isfinite(out.thrust_sum_N) ||
      !std::isfinite(out.engaged_teeth) || !std::isfinite(out.mean_E_MPa) || !std::isfinite(out.mean_bite_mm) ||
      !std::isfinite(out.removed_mm3)) {
    Fail("I1", fmt::format("force {}, torque {}, thrust {}, teeth {}, E {}, bite {}, removed {}", Text(out.f_T_W_N),
                           Text(out.tau_TG_W_Nmm), out.thrust_sum_N, out.engaged_teeth, out.mean_E_MPa,
                           out.mean_bite_mm, out.removed_mm3));
    return;
  }
  const bool nothing = out.f_T_W_N == Vec3(0) && out.tau_TG_W_Nmm == Vec3(0) && out.removed_mm3 == 0;
  if (out.status & (kTickBadPose | kTickSpindleStopped)) {
    if (!nothing) Fail("I3", "a stopped spindle or a bad pose had an effect");
    if (out.status & kTickSpindleStopped) X_WT_ = in.X_WT;
    return;
  }
  if (glm::length(out.f_T_W_N) > out.thrust_sum_N * (1 + 1e-9)) {
    Fail("I2", fmt::format("the force is {} N, but the teeth's thrusts add up to {}", glm::length(out.f_T_W_N),
                           out.thrust_sum_N));
  }
  if (out.removed_mm3 < 0) Fail("I5", fmt::format("{} mm^3 removed", out.removed_mm3));
  const double h = watch_.before().voxel_mm();
  if (!watch_.MayTouch(X_WT_, in.X_WT, 2 * h) && !nothing) {
    Fail("I3", fmt::format("in the air the force is {} N, {} mm^3 are removed", Text(out.f_T_W_N), out.removed_mm3));
  }
  // In a straight motion at constant rotational speed, the force must act against the feed.
  if (in.X_WT.R_AB == X_WT_.R_AB && glm::dot(out.f_T_W_N, in.X_WT.p_AB - X_WT_.p_AB) > 1e-9 * out.thrust_sum_N) {
    Fail("I15", fmt::format("the force {} N pulls along the feed", Text(out.f_T_W_N)));
  }
  removed_mm3_ += out.removed_mm3;
  removed_since_check_mm3_ += out.removed_mm3;
  watch_.Move(X_WT_, in.X_WT, 0, (out.status & kTickSubstepsLimited) == 0);
  X_WT_ = in.X_WT;
}

void PathInvariants::CheckBone() {
  const BoneWatch::Removed removed{removed_since_check_mm3_, Sum(simulation_.CalcRemovedByRegion())};
  for (const std::string& text : watch_.Check(simulation_.UpdateBone(), removed))
    Fail(text.substr(0, 2), text.substr(4));
  removed_since_check_mm3_ = 0;
}

}  // namespace kerf::test
