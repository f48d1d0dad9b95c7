// Tests of a released handle that is thrown at the bone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "experiment/stability/held_block.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched_loop.h"

namespace kerf {
namespace {

using test::HeldBlock;
using test::Verdict;
using test::WatchedLoop;

struct Impact {
  double approach_mm_per_s = 0;  // just before the force begins
  double rebound_mm_per_s = 0;   // maximum on the way out
  double largest_N = 0;
  double deepest_mm = 0;  // of the tool's rim below the top
};

/// Releases the handle 6 mm above the block with a push that accelerates it to about `speed_mm_per_s`.
Impact Throw(const ClosedLoopSetup& setup, double speed_mm_per_s) {
  constexpr double kAbove_mm = 6;
  WatchedLoop saw(test::BlockOfBone(0.2, Vec3(26, 6, 26)), setup, test::OverBlock(kAbove_mm));
  Intention free;
  free.X_WH = test::OverBlock(kAbove_mm);
  saw.loop.device().SetIntention(free);
  for (int i = 0; i < 600; ++i) saw.Step(0);
  // The push acts over half of the distance, with the force that this speed requires.
  const double force_N =
      setup.profile.friction_N + 1e-3 * setup.profile.mass_kg * speed_mm_per_s * speed_mm_per_s / (2 * 0.5 * kAbove_mm);
  Impact impact;
  bool touched = false;
  for (int i = 0; i < 4000; ++i) {
    Intention intention = free;
    const bool pushes = !touched && saw.loop.device().p_WC_mm().z > 11 + 0.5 * kAbove_mm;
    // On the way to the bone, the push compensates friction.
    if (!touched) intention.push_W_N = Vec3(0, 0, pushes ? -force_N : -setup.profile.friction_N);
    saw.loop.device().SetIntention(intention);
    const double before = -saw.loop.device().v_WC_mm_per_s().z;
    const ClosedLoopTick tick = saw.Step(0);
    if (!touched && tick.out.force.f_H_W_N != Vec3{0}) {
      touched = true;
      impact.approach_mm_per_s = before;
    }
    if (!touched) continue;
    impact.rebound_mm_per_s = std::max(impact.rebound_mm_per_s, tick.v_WC_mm_per_s.z);
    impact.deepest_mm = std::max(impact.deepest_mm, 11 - tick.out.coupled.X_WT.p_AB.z);
    impact.largest_N = std::max(impact.largest_N, glm::length(saw.loop.device().force_N()));
  }
  EXPECT_TRUE(touched);
  return impact;
}

// The device alone is the hardest case, because a hand would reduce the speed. It is tested with the stiffest coupling
// and with the default.
TEST(ClosedLoopST6, ThrownHandleReboundsNoFasterThanItArrived) {
  Verdict verdict("holds");
  double restitution = 0;
  double deepest_mm = 0;
  double largest = 0;
  std::string table;
  for (const char* profile : {"omni", "omega_6", "premium_1_5_hf", "virtuose_6d"}) {
    for (const bool stiff : {false, true}) {
      CouplingParams asked;
      if (stiff) asked.stiffness_N_per_mm = 1000;
      // The coupling is fitted for a firm grip, and then the handle is released.
      ClosedLoopSetup setup = HeldBlock(profile, "H4", asked);
      setup.hand = FindHandModel("H0");
      for (const double speed : {50.0, 200.0, 500.0, 1000.0}) {
        const Impact impact = Throw(setup, speed);
        EXPECT_GT(impact.approach_mm_per_s, 0.6 * speed) << profile;
        EXPECT_GT(impact.largest_N, 0) << profile;
        EXPECT_LE(impact.largest_N, setup.profile.peak_force_N) << profile;
        restitution = std::max(restitution, impact.rebound_mm_per_s / impact.approach_mm_per_s);
        deepest_mm = std::max(deepest_mm, impact.deepest_mm);
        largest = std::max(largest, impact.largest_N / setup.profile.peak_force_N);
        table += fmt::format("{} {:.2f} N/mm {:.0f} mm/s: back {:.0f} mm/s, {:.2f} N, rim {:.3f} mm in\n", profile,
                             setup.coupled.coupling.stiffness_N_per_mm, impact.approach_mm_per_s,
                             impact.rebound_mm_per_s, impact.largest_N, impact.deepest_mm);
      }
    }
  }
  std::puts(table.c_str());
  verdict.AtMost("rebound speed relative to approach speed, worst", restitution, 1);
  verdict.AtMost("largest force relative to the device's peak", largest, 1);
  // The stopped edge is a spring of 2000 N/mm per point, and the level set is exact to some hundredths of a voxel.
  verdict.AtMost("penetration of the tool's rim", deepest_mm, 0.05, "mm");
}

}  // namespace
}  // namespace kerf
