#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/core/heap_guard.h"
#include "cut/contact/motion.h"
#include "cut/removal/cutter.h"
#include "experiment/stability/fuzz_run.h"
#include "experiment/stability/invariants.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"

namespace kerf::test {
namespace {

constexpr double kMaxSteps = 12;

bool IsGood(const TickInput& in) {
  return IsValid(in.X_WT) && IsInWorld(in.X_WT.p_AB) && in.dt_s >= 0 && std::isfinite(in.dt_s) && std::isfinite(in.rpm);
}

std::string CheckNumbers(const TickOutput& out) {
  if (!IsFinite(out.f_T_W_N) || !IsFinite(out.tau_TG_W_Nmm)) return "I1: a force is not finite";
  for (const double x : {out.thrust_sum_N, out.engaged_teeth, out.mean_E_MPa, out.mean_bite_mm, out.removed_mm3}) {
    if (!(x >= 0) || !std::isfinite(x)) return fmt::format("I1: {} is not 0 or more", x);
  }
  return "";
}

std::string CheckRefused(const TickOutput& out) {
  if (out.status != kTickBadPose) return fmt::format("bad input, but status {}", out.status);
  if (out.f_T_W_N != Vec3(0) || out.tau_TG_W_Nmm != Vec3(0) || out.removed_mm3 != 0) return "bad input has an effect";
  return "";
}

}  // namespace

FuzzResult FuzzPath(std::uint64_t seed, int calls, FuzzTools tools, long& ticks) {
  Dice dice(seed);
  const FuzzScene scene = MakeFuzzScene(dice, tools);
  // A path is followed to its end in one tick, however many steps that takes, so the leaps are limited.
  FuzzHand hand(dice, scene, 15 * scene.voxel_mm);
  Simulation simulation(scene.bone, {scene.params.tool, scene.params.law, {}, scene.params.rim_samples_per_pitch},
                        scene.start);
  const double volume_mm3 = scene.bone.CalcVolume();
  BoneWitness witness(scene.bone);
  Pose X_WT = scene.start;
  FuzzResult result;
  const auto account = [&]() -> std::string {
    double removed = 0;
    for (const double r : simulation.CalcRemovedByRegion()) removed += r;
    const double left = simulation.UpdateBone().CalcVolume();
    if (!(std::abs(volume_mm3 - left - removed) <= 1e-9 * volume_mm3)) {
      return fmt::format("I4: {} mm3 at the start, {} left, {} removed", volume_mm3, left, removed);
    }
    return witness.Compare(simulation.UpdateBone());
  };
  const auto tick = [&](const TickInput& in) -> std::string {
    const TickOutput out = simulation.Tick(in);
    ++ticks;
    if (!IsGood(in)) return CheckRefused(out);
    if (in.dt_s < kMinTick_s) return out.status == kTickNoTime && out.removed_mm3 == 0 ? "" : "wrong no-time status";
    std::string wrong = CheckNumbers(out);
    if (!wrong.empty()) return wrong;
    const Vec3 motion = in.X_WT.p_AB - X_WT.p_AB;
    // Work on the tool. The lever of the grip turns during the tick, so that of a step's force is known to |turn|.
    const Vec3 turn_W = X_WT.Vector(CalcAngularVelocity(X_WT.R_AB, in.X_WT.R_AB, 1));
    const Vec3 lever_W = X_WT.Vector(CalcGrip(scene.params.tool));
    const Vec3 torque_W = out.tau_TG_W_Nmm + glm::cross(lever_W, out.f_T_W_N);
    const double work = glm::dot(out.f_T_W_N, motion) + glm::dot(torque_W, turn_W);
    const double turn = glm::length(turn_W);
    const double most_Nmm = out.thrust_sum_N * (glm::length(motion) + glm::length(lever_W) * turn);
    if (work > 1e-9 * most_Nmm + out.thrust_sum_N * glm::length(lever_W) * turn * turn) {
      return fmt::format("teeth pull by {} N mm", work);
    }
    if (glm::length(out.f_T_W_N) > out.thrust_sum_N * (1 + 1e-9)) return "the force exceeds the sum of its parts";
    if (in.rpm == 0 && (out.f_T_W_N != Vec3(0) || out.removed_mm3 != 0)) return "a stopped spindle cuts";
    if (in.rpm != 0) witness.Allow(CalcCutBox(scene.params.tool, X_WT, in.X_WT, 1, scene.voxel_mm));
    X_WT = in.X_WT;
    return "";
  };
  for (; result.tick < calls && result.wrong.empty(); ++result.tick) {
    const FuzzCall call = hand.Next(X_WT);
    switch (call.kind) {
      case FuzzCall::Kind::kTick:
        // A path is followed to its end, however many steps that takes, so long motions are rare.
        if (IsGood({call.in.X_WH, 1, 0}) &&
            CountSubsteps(X_WT, call.in.X_WH, scene.params.tool, scene.voxel_mm) > kMaxSteps && !dice.OneIn(200)) {
          if (simulation.SetDown(call.in.X_WH)) X_WT = call.in.X_WH;
          break;
        }
        result.wrong = tick({call.in.X_WH, call.in.dt_s, call.in.rpm});
        break;
      case FuzzCall::Kind::kSetDown:
        if (simulation.SetDown(call.in.X_WH)) X_WT = call.in.X_WH;
        break;
      case FuzzCall::Kind::kRefill:
        simulation.Refill();
        break;
      case FuzzCall::Kind::kAccount:
        result.wrong = account();
        break;
      case FuzzCall::Kind::kFidelity:
        break;
    }
  }
  if (result.wrong.empty()) result.wrong = account();
  return result;
}

FuzzResult FuzzSlab(std::uint64_t seed, int calls, long& ticks) {
  Dice dice(seed);
  SlabParams p;
  p.direction_W = dice.OneIn(2) ? Vec3(0, 1, 0) : dice.Direction();
  p.reading = dice.One({PaperReading::kCorrected, PaperReading::kAsComputed});
  p.contact_share_of_pitch = dice.LogUniform(1e-6, 0.5);
  const auto extreme = [&](double lower, double usual, double upper) {
    return dice.OneIn(3)   ? usual
           : dice.OneIn(6) ? lower
           : dice.OneIn(5) ? upper
                           : dice.LogUniform(std::max(lower, 1e-3), upper);
  };
  p.mass_g = extreme(1e-3, 1, 1e4);
  p.stiffness_N_per_mm = extreme(0, 0, 1e6);
  p.damping_Ns_per_mm = extreme(0, 0, 1e3);
  p.friction_coefficient = extreme(0, 0.2, 10);
  p.normal_force_N = extreme(0, 1, 1e4);
  p.coupling_N_per_mm = extreme(1e-3, 100, 1e6);
  p.coupling_damping_Ns_per_mm = extreme(0, 0.01, 1e3);
  p.segments_move = dice.OneIn(2);
  p.segment_mass_g = extreme(1e-3, 20, 1e4);
  p.segment_stiffness_N_per_mm = extreme(0, 1, 1e6);
  p.segment_damping_Ns_per_mm = extreme(0, 0.01, 1e3);
  p.saw.teeth = dice.One({1, 24, 1000});
  SlabProfile profile;
  for (double top = 0; profile.layers.size() < 5; top += dice.LogUniform(0.01, 10)) {
    profile.layers.push_back({top, 24, dice.OneIn(5) ? 0 : dice.LogUniform(1, 1e7), dice.One({0.0, 0.28, 0.5})});
    profile.end_mm = top + 0.5;
  }
  profile.entry_mm = dice.One({0.0, 11.0, -4000.0});
  const double first_mm = profile.entry_mm - p.saw.radius_mm();
  FuzzScene scene;
  scene.params.tool = p.saw;
  scene.start.p_AB = (first_mm - dice.Uniform(-0.4, 3)) * p.direction_W;
  scene.box = {scene.start.p_AB - Vec3(2), scene.start.p_AB + Vec3(2) + p.direction_W * profile.end_mm};
  scene.box.lower = glm::min(scene.box.lower, scene.box.upper);
  FuzzHand hand(dice, scene, 100);
  SlabSimulation simulation(profile, p, scene.start);
  Pose X_WT = scene.start;
  double rounding_mJ = 0;
  FuzzResult result;

  const auto tick = [&](const TickInput& in) -> std::string {
    const SlabState before = simulation.state();
    const HeapUseCounter heap;
    TickOutput out;
    {
      const HeapGuard guard;
      out = simulation.Tick(in);
    }
    ++ticks;
    const SlabState& s = simulation.state();
    if (heap.count() != 0) return fmt::format("{} heap calls in the tick", heap.count());
    if (!IsGood(in)) return CheckRefused(out);
    if (in.dt_s < kMinTick_s) return out.status == kTickNoTime && out.removed_mm3 == 0 ? "" : "wrong no-time status";
    std::string wrong = CheckNumbers(out);
    if (!wrong.empty()) return wrong;
    for (const double x : {s.blade_mm, s.left_mm, s.right_mm, s.depth_mm, s.deepest_mm, s.hand_work_mJ}) {
      if (!std::isfinite(x)) return "I1: the state is not finite";
    }
    // Each loss only grows, except for rounding in the numerical loss, which is a difference of large numbers.
    const double moved = std::abs(s.hand_work_mJ) + s.kinetic_mJ + s.elastic_mJ + s.friction_mJ + s.cutting_mJ +
                         s.damping_mJ + s.released_mJ + std::abs(s.numerical_mJ);
    if (s.friction_mJ < before.friction_mJ || s.cutting_mJ < before.cutting_mJ || s.damping_mJ < before.damping_mJ) {
      return "a dissipated energy decreases";
    }
    if (s.numerical_mJ < before.numerical_mJ - 1e-9 * (1 + moved)) {
      return fmt::format("the step created {} mJ of {}", before.numerical_mJ - s.numerical_mJ, moved);
    }
    const double open = s.kinetic_mJ + s.elastic_mJ - s.hand_work_mJ + s.friction_mJ + s.cutting_mJ + s.damping_mJ +
                        s.released_mJ + s.numerical_mJ;
    // Relative errors of positions and velocities are 1e-16. They are multiplied by the force of a stiff coupling along
    // the motion.
    const double motion_mm = glm::length(in.X_WT.p_AB - X_WT.p_AB);
    rounding_mJ +=
        1e-13 * motion_mm *
        (p.coupling_N_per_mm * (1 + glm::length(in.X_WT.p_AB)) + p.coupling_damping_Ns_per_mm * motion_mm / in.dt_s);
    if (!(std::abs(open) <= 1e-8 * (1 + moved) + rounding_mJ)) {
      return fmt::format("the energy balance is off by {} of {} mJ, rounding {}", open, moved, rounding_mJ);
    }
    if (s.deepest_mm < before.deepest_mm) return "I5: removed bone grows back";
    if (in.rpm == 0 && s.deepest_mm > before.deepest_mm + 1e-6 && !s.free) return "a stopped disc goes deeper";
    X_WT = in.X_WT;
    return "";
  };
  for (; result.tick < calls && result.wrong.empty(); ++result.tick) {
    const FuzzCall call = hand.Next(X_WT);
    switch (call.kind) {
      case FuzzCall::Kind::kTick:
        result.wrong = tick({call.in.X_WH, call.in.dt_s, call.in.rpm});
        break;
      case FuzzCall::Kind::kSetDown:
        if (simulation.SetDown(call.in.X_WH)) X_WT = call.in.X_WH;
        break;
      case FuzzCall::Kind::kFidelity:
        simulation.Hold(
            dice.One({SlabBody::kSlice, SlabBody::kSlice, SlabBody::kLeft, SlabBody::kRight, SlabBody::kNone}));
        break;
      case FuzzCall::Kind::kRefill:
      case FuzzCall::Kind::kAccount:
        break;
    }
  }
  return result;
}

}  // namespace kerf::test
