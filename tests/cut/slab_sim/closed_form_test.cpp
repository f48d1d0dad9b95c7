// The slice compared with closed forms: equilibrium at depth, friction with stick and slip, oscillation, separation.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "slab_setup.h"

namespace kerf {
namespace {

using test::Against;
using test::HandAt;
using test::kRpm;
using test::kTick_s;

constexpr double kE24_MPa = 19300;
constexpr double kNu24 = 0.28;

TEST(SlabBalance, ForceOfASlowPushIsLawPlusSpringPlusFriction) {
  for (const PaperReading reading : {PaperReading::kAsComputed, PaperReading::kCorrected}) {
    SlabParams params;
    params.reading = reading;
    params.stiffness_N_per_mm = 0.3;
    params.friction_coefficient = 0.4;
    params.normal_force_N = 0.5;
    params.damping_Ns_per_mm = 0.02;
    SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 40), params, HandAt(-0.5, params));
    constexpr double kFeed = 2;
    double settled_until = -1;  // after a step of the staircase the coupling oscillates for a few ticks
    double teeth = -1;
    double worst_N = 0;
    int compared = 0;
    test::Move(simulation, params, -0.5, 30, kFeed, [&](const TickOutput& out) {
      const double depth = simulation.state().depth_mm;
      if (reading == PaperReading::kAsComputed ? out.engaged_teeth != teeth : teeth < 0) settled_until = depth + 0.1;
      teeth = out.engaged_teeth;
      if (depth < std::max(0.2, settled_until)) return;
      const double law_N = CalcPaperForce(params.saw, 0.01, depth, kE24_MPa, kNu24, reading);
      const double expected_N = law_N + 0.3 * depth + 2 * 0.4 * 0.5 + 0.02 * kFeed;
      worst_N = std::max(worst_N, std::abs(Against(out, params) - expected_N));
      ++compared;
    });
    EXPECT_GT(compared, 10000);
    // The mean over a tick differs from the value at its end by half a tick's increase, 0.001 mm x (0.3 + dF/dh up to
    // 2) N/mm. With `corrected` the table's error is added, below 1e-4 N; with `as_computed` the oscillation has
    // decayed to less than that.
    EXPECT_LT(worst_N, 0.002) << ToString(reading);
  }
}

TEST(SlabBalance, WithoutFrictionTheCouplingBalancesTheSlicesSpringAtRest) {
  SlabParams params;
  params.stiffness_N_per_mm = 0.5;
  SlabSimulation simulation(test::UniformProfile(0, 0, 40), params, HandAt(-0.1, params));
  for (const double hand_mm : {4.0, 9.0, 2.0}) {
    double force_N = 0;
    for (int i = 0; i < 500; ++i) force_N = Against(simulation.Tick({HandAt(hand_mm, params), kTick_s, kRpm}), params);
    // At rest, k h = K (hand - h); the coupling's damper has stopped all motion by then.
    const double depth = params.coupling_N_per_mm * hand_mm / (params.coupling_N_per_mm + 0.5);
    EXPECT_NEAR(simulation.state().depth_mm, depth, 1e-9);
    EXPECT_NEAR(force_N, 0.5 * depth, 1e-7);
  }
}

TEST(SlabBalance, FrictionHoldsTheSpringUpToItsLimitWithoutCreep) {
  SlabParams params;
  params.stiffness_N_per_mm = 0.5;
  params.friction_coefficient = 0.5;
  params.normal_force_N = 0.6;  // friction is 0.6 N on both faces together
  for (const auto& [depth_mm, holds] : {std::pair(1.18, true), std::pair(1.22, false)}) {
    SlabSimulation simulation(test::UniformProfile(0, 0, 40), params, HandAt(-0.1, params));
    // The slice is pushed from above against spring and friction, 0.6 N + 0.5 N/mm h, which stretches the coupling
    // accordingly.
    const double hand_mm = depth_mm + (0.6 + 0.5 * depth_mm) / params.coupling_N_per_mm;
    test::Move(simulation, params, -0.1, std::round(1000 * hand_mm) / 1000, 0.5, [](const TickOutput&) {});
    simulation.Hold(SlabBody::kNone);
    // When the slice is released, friction holds it up to 1.2 mm: 0.5 N/mm x 1.2 mm = 0.6 N.
    for (int i = 0; i < 10; ++i) simulation.Tick({HandAt(0, params), kTick_s, kRpm});
    const double start_mm = simulation.state().depth_mm;
    for (int i = 0; i < 2000; ++i) {
      simulation.Tick({HandAt(0, params), kTick_s, kRpm});
      ASSERT_EQ(simulation.state().depth_mm, start_mm) << "tick " << i;
      ASSERT_TRUE(simulation.state().sticking);
      ASSERT_EQ(simulation.state().kinetic_mJ, 0);
    }
    if (holds) {
      EXPECT_NEAR(start_mm, depth_mm, 0.005);
    } else {
      // The slice slid up and, because it had gained speed, overshot the limit by about as much as it had started
      // beyond it.
      EXPECT_LT(start_mm, 1.2);
      EXPECT_GT(start_mm, 1.17);
    }
  }
}

TEST(SlabBalance, SetDownInsideTheBoneStartsWithASlackSpring) {
  SlabParams params;
  params.stiffness_N_per_mm = 1;
  for (const bool later : {false, true}) {
    SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 30), params, HandAt(later ? -3 : 5, params));
    if (later) {
      ASSERT_TRUE(simulation.SetDown(HandAt(5, params)));
    }
    EXPECT_EQ(simulation.state().deepest_mm, simulation.state().depth_mm);
    double force_N = 0;
    for (int i = 0; i < 300; ++i) force_N = Against(simulation.Tick({HandAt(5, params), kTick_s, kRpm}), params);
    EXPECT_EQ(force_N, 0);
    EXPECT_NEAR(simulation.state().depth_mm, 5, 1e-12);
    EXPECT_EQ(simulation.state().elastic_mJ, 0);
    test::Move(simulation, params, 5, 3, 2, [](const TickOutput&) {});
    test::Move(simulation, params, 3, 4.99, 2, [](const TickOutput&) {});
    EXPECT_LT(simulation.state().cutting_mJ, 1e-12) << "what lies above counts as cut";
    // From there on the spring is stretched by the blade's motion.
    test::Move(simulation, params, 4.99, 6, 2, [&](const TickOutput& out) { force_N = Against(out, params); });
    const double depth = simulation.state().depth_mm;
    EXPECT_NEAR(force_N, CalcPaperForce(params.saw, 0.01, depth, kE24_MPa, kNu24, params.reading) + (depth - 5), 0.002);
    EXPECT_NEAR(test::CalcImbalance(simulation.state()), 0, 1e-9);
  }
}

TEST(SlabBalance, BeforeTheBoneNothingHoldsTheBlade) {
  SlabParams params;
  params.stiffness_N_per_mm = 2;
  params.damping_Ns_per_mm = 0.5;
  params.friction_coefficient = 1;
  params.normal_force_N = 5;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 30), params, HandAt(-8, params));
  double force_N = 1;
  test::Move(simulation, params, -8, -1, 4, [&](const TickOutput& out) { force_N = Against(out, params); });
  EXPECT_NEAR(force_N, 0, 1e-9);
}

TEST(SlabBalance, MovingSegmentsChangeTheDepthButNotTheForce) {
  SlabParams params;
  params.reading = PaperReading::kCorrected;
  params.segments_move = true;
  params.segment_stiffness_N_per_mm = 2;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 30), params, HandAt(-1, params));
  double force_N = 0;
  test::Move(simulation, params, -1, 6, 0.5, [&](const TickOutput& out) { force_N = Against(out, params); });
  const SlabState& s = simulation.state();
  const double law_N = CalcPaperForce(params.saw, 0.01, s.depth_mm, kE24_MPa, kNu24, params.reading);
  // The tolerance is half a tick's increase and the table's error, as above.
  EXPECT_NEAR(force_N, law_N, 1e-3);
  EXPECT_NEAR(s.left_mm, 0.5 * law_N / 2, 1e-3);
  EXPECT_EQ(s.left_mm, s.right_mm);
  EXPECT_NEAR(s.depth_mm, s.blade_mm - 1 - 0.5 * (s.left_mm + s.right_mm), 1e-12);

  // If the hand moves one segment alone, only half of its motion counts.
  SlabSimulation still(test::UniformProfile(0, 0, 30), params, HandAt(5, params));
  still.Hold(SlabBody::kRight);
  test::Move(still, params, 5, 7, 1, [](const TickOutput&) {});
  EXPECT_NEAR(still.state().right_mm, 2, 0.1);
  EXPECT_EQ(still.state().left_mm, 0);
  EXPECT_NEAR(still.state().depth_mm, 5 - 0.5 * still.state().right_mm, 1e-12);
}

TEST(SlabFriction, SticksUpToTheLimitOfBothFacesThenSlidesAtThatForce) {
  SlabParams params;
  params.friction_coefficient = 0.3;
  params.normal_force_N = 2;
  params.coupling_N_per_mm = 2;
  const double limit_N = 2 * 0.3 * 2;
  SlabSimulation simulation(test::UniformProfile(0, 0, 100), params, HandAt(10, params));
  // The blade is set down in the bone at rest, so no spring is stretched; the hand moves by limit / K before the slice
  // moves.
  double last_stuck_mm = 10;
  double hand_mm = 10;
  int slips = 0;
  int returns_to_stick = 0;
  bool was_sticking = true;
  for (int i = 1; i <= 4000; ++i) {
    hand_mm = 10 + 0.001 * i;
    const TickOutput out = simulation.Tick({HandAt(hand_mm, params), kTick_s, kRpm});
    const bool sticking = simulation.state().sticking;
    if (sticking) {
      last_stuck_mm = hand_mm;
      EXPECT_EQ(simulation.state().depth_mm, 10);
    } else {
      ++slips;
      if (i > 1000) {
        EXPECT_NEAR(Against(out, params), limit_N, 1e-6);
      }
    }
    returns_to_stick += sticking && !was_sticking ? 1 : 0;
    was_sticking = sticking;
  }
  // The coupling's damper (0.01 N s/mm at 1 mm/s: 0.01 N) adds to the pull while the slice sticks.
  EXPECT_NEAR(last_stuck_mm - 10, (limit_N - 0.01) / 2, 0.0011);
  EXPECT_GT(slips, 3000);
  EXPECT_EQ(returns_to_stick, 0) << "chatter";
}

TEST(SlabFriction, ReversalChangesTheSignOfTheVelocityOnce) {
  SlabParams params;
  params.friction_coefficient = 0.3;
  params.normal_force_N = 2;
  params.coupling_N_per_mm = 2;
  SlabSimulation simulation(test::UniformProfile(0, 0, 100), params, HandAt(10, params));
  std::vector<double> at;
  const auto note = [&](const TickOutput&) { at.push_back(simulation.state().blade_mm); };
  test::Move(simulation, params, 10, 14, 5, note);
  test::Move(simulation, params, 14, 10, 5, note);
  int sign_changes = 0;
  int sign = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const double step = at[i] - at[i - 1];
    if (step == 0) continue;
    const int now = step > 0 ? 1 : -1;
    sign_changes += sign != 0 && now != sign ? 1 : 0;
    sign = now;
  }
  EXPECT_EQ(sign_changes, 1);
  EXPECT_EQ(sign, -1);
}

/// Returns the largest difference between a simulated damped oscillation and the analytic one, for ticks of dt_s.
double OscillationError(double dt_s) {
  SlabParams params;
  params.mass_g = 50;
  params.stiffness_N_per_mm = 0.2;
  params.damping_Ns_per_mm = 2e-4;
  params.coupling_N_per_mm = 0.3;
  params.coupling_damping_Ns_per_mm = 1e-4;
  constexpr double kDepth_mm = 5;
  SlabSimulation simulation(test::UniformProfile(0, 0, 500), params, HandAt(kDepth_mm, params));
  // The blade is set down 5 mm deep, where the slice's spring is slack, and the hand then moves at V: m x'' = -k x - c
  // x' + K (V t - x) + C (V - x'), x(0) = x'(0) = 0. The solution is a straight line plus a damped oscillation.
  const double V = 100;  // 0.1 mm per tick: eight substeps for each tick length tested
  const double m = 50e-6;
  const double k = 0.2 + 0.3;
  const double c = 3e-4;
  const double slope = 0.3 * V / k;
  const double offset = (1e-4 * V - c * slope) / k;
  const double decay = c / (2 * m);
  const double omega = std::sqrt(k / m - decay * decay);
  double worst = 0;
  const int count = static_cast<int>(std::round(0.25 / dt_s));
  for (int i = 1; i <= count; ++i) {
    const double t = i * dt_s;
    simulation.Tick({HandAt(kDepth_mm + V * t, params), dt_s, kRpm});
    const double x =
        offset + slope * t -
        std::exp(-decay * t) * (offset * std::cos(omega * t) + (slope + decay * offset) / omega * std::sin(omega * t));
    worst = std::max(worst, std::abs(simulation.state().depth_mm - kDepth_mm - x));
  }
  return worst;
}

TEST(SlabOscillation, FollowsTheDampedMassSpringAndConvergesInFirstOrder) {
  const double coarse = OscillationError(0.001);
  const double middle = OscillationError(0.0005);
  const double fine = OscillationError(0.00025);
  // The amplitude is 2 mm at omega = 100/s. The error of implicit Euler is at most about omega^2 h t / 2 of the
  // amplitude, with h an eighth of a tick. With the decay of 3/s this is below 0.15 mm.
  EXPECT_LT(coarse, 0.15);
  EXPECT_NEAR(coarse / middle, 2, 0.3);
  EXPECT_NEAR(middle / fine, 2, 0.15);
}

TEST(SlabSeparation, SlicePastItsEndIsFreeAndCoastsWhenReleased) {
  SlabParams params;
  params.friction_coefficient = 0.3;
  params.normal_force_N = 1;
  params.stiffness_N_per_mm = 0.1;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 8), params, HandAt(-1, params));
  bool freed = false;
  double before_N = 0;
  double after_N = 1;
  test::Move(simulation, params, -1, 9, 4, [&](const TickOutput& out) {
    if (!simulation.state().free) before_N = Against(out, params);
    after_N = Against(out, params);
    if (simulation.state().free && !freed) {
      freed = true;
      // The hand moves 0.0005 mm in a substep; the slice may move ahead by the coupling's stretch, below 0.05 mm.
      EXPECT_NEAR(simulation.state().depth_mm, 8, 0.1);
    }
  });
  ASSERT_TRUE(freed);
  EXPECT_GT(before_N, 1);
  // After another millimetre nothing holds the slice, and the coupling's oscillation (damped by 0.01 N s/mm on 1 g) has
  // decayed.
  EXPECT_NEAR(after_N, 0, 1e-9);
  EXPECT_EQ(simulation.Tick({HandAt(9, params), kTick_s, kRpm}).engaged_teeth, 0);

  // If the slice is released while it moves, it keeps its velocity exactly, whatever the hand does.
  test::Move(simulation, params, 9, 10, 4, [](const TickOutput&) {});
  simulation.Hold(SlabBody::kNone);
  const double start = simulation.state().blade_mm;
  const double kinetic = simulation.state().kinetic_mJ;
  EXPECT_NEAR(kinetic, 0.5 * 1e-6 * 16, 1e-9);
  for (int i = 1; i <= 500; ++i) {
    const TickOutput out = simulation.Tick({HandAt(-50, params), kTick_s, kRpm});
    ASSERT_EQ(glm::length(out.f_T_W_N), 0);
    ASSERT_NEAR(simulation.state().blade_mm, start + 0.004 * i, 1e-6);
    ASSERT_NEAR(simulation.state().kinetic_mJ, kinetic, 1e-15);
  }
}

TEST(SlabSeparation, HeldFreeSliceFollowsTheHandInAllDirections) {
  SlabParams params;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 3), params, HandAt(-1, params));
  test::Move(simulation, params, -1, 4, 4, [](const TickOutput&) {});
  ASSERT_TRUE(simulation.state().free);
  // The hand moves across the rail with a constant acceleration a; once the coupling has settled, the force is -m a.
  double force_N = 0;
  const double a = 20;
  for (int i = 1; i <= 1000; ++i) {
    Pose X = HandAt(4, params);
    const double t = i * kTick_s;
    X.p_AB.x = 0.5 * a * t * t;
    force_N = simulation.Tick({X, kTick_s, kRpm}).f_T_W_N.x;
  }
  EXPECT_NEAR(force_N, -1e-6 * a, 1e-9);

  // The slice is released and grasped again elsewhere, without a jolt in any direction.
  simulation.Hold(SlabBody::kNone);
  Pose X = HandAt(9, params);
  X.p_AB += Vec3(3, 0, -2);
  simulation.Tick({X, kTick_s, kRpm});
  const double energy_mJ = simulation.state().kinetic_mJ + simulation.state().elastic_mJ;
  simulation.Hold(SlabBody::kSlice);
  EXPECT_NEAR(simulation.state().kinetic_mJ + simulation.state().elastic_mJ, energy_mJ, 1e-12);
}

TEST(SlabSegments, FrictionConservesMomentumAndEqualizesTheVelocities) {
  SlabParams params;
  params.mass_g = 2;
  params.friction_coefficient = 0.5;
  params.normal_force_N = 0.01;
  params.segments_move = true;
  params.segment_mass_g = 5;
  params.segment_stiffness_N_per_mm = 0;
  params.segment_damping_Ns_per_mm = 0;
  SlabSimulation simulation(test::UniformProfile(0, 0, 1e4), params, HandAt(-20, params));
  // The hand gives the slice a velocity outside the bone, then releases it.
  test::Move(simulation, params, -20, -0.05, 100, [](const TickOutput&) {});
  simulation.Hold(SlabBody::kNone);
  const double momentum = 2e-6 * std::sqrt(2 * simulation.state().kinetic_mJ / 2e-6);
  double before_left = 0;
  double before_blade = 0;
  double left_v = 0;
  double blade_v = 0;
  for (int i = 0; i < 200; ++i) {
    before_left = simulation.state().left_mm;
    before_blade = simulation.state().blade_mm;
    simulation.Tick({HandAt(0, params), kTick_s, kRpm});
    EXPECT_EQ(simulation.state().left_mm, simulation.state().right_mm);
    left_v = (simulation.state().left_mm - before_left) / kTick_s;
    blade_v = (simulation.state().blade_mm - before_blade) / kTick_s;
  }
  const double common = momentum / (2e-6 + 2 * 5e-6);
  EXPECT_GT(common, 10);
  EXPECT_NEAR(left_v, common, 1e-9 * common + 1e-10 / kTick_s);
  EXPECT_NEAR(blade_v, common, 1e-9 * common + 1e-10 / kTick_s);
  EXPECT_TRUE(simulation.state().sticking);
}

TEST(SlabSegments, AHeldSegmentMovesAgainstItsSpringAndDragsTheSliceAlong) {
  SlabParams params;
  params.segments_move = true;
  params.segment_stiffness_N_per_mm = 0.5;
  params.friction_coefficient = 0.5;
  params.normal_force_N = 1;
  SlabSimulation simulation(test::UniformProfile(0, 0, 50), params, HandAt(5, params));
  simulation.Hold(SlabBody::kLeft);
  double force_N = 0;
  test::Move(simulation, params, 5, 6.5, 0.05, [&](const TickOutput& out) { force_N = Against(out, params); });
  for (int i = 0; i < 1000; ++i) force_N = Against(simulation.Tick({HandAt(6.5, params), kTick_s, kRpm}), params);
  const SlabState& s = simulation.state();
  // The right segment (spring 0.5 N/mm) is dragged until its spring balances the friction of 0.5 N on its face: 1 mm.
  // When the hand stops, the coupling's damper (0.01 N s/mm at 0.05 mm/s) and the inertia move the segment back by less
  // than 1e-4 mm.
  EXPECT_NEAR(s.right_mm, 1, 1e-4);
  EXPECT_NEAR(s.left_mm, 1.5 - force_N / params.coupling_N_per_mm, 1e-6);
  EXPECT_NEAR(force_N, 0.5 * s.left_mm + 0.5, 1e-3);
}

TEST(SlabSpindle, AStoppedBladeGoesNoDeeperAndComesBackFreely) {
  SlabParams params;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 30), params, HandAt(-1, params));
  test::Move(simulation, params, -1, 5, 5, [](const TickOutput&) {});
  for (int i = 0; i < 100; ++i) simulation.Tick({HandAt(5, params), kTick_s, kRpm});
  const double deepest = simulation.state().deepest_mm;
  TickOutput out;
  test::Move(
      simulation, params, 5, 5.5, 5, [&](const TickOutput& o) { out = o; }, 0);
  EXPECT_NEAR(simulation.state().deepest_mm, deepest, 1e-9);
  // The slice is wedged, so the hand feels the full stretch of the coupling.
  EXPECT_NEAR(Against(out, params), params.coupling_N_per_mm * (5.5 - deepest) + 0.01 * 5, 0.3);
  EXPECT_TRUE(out.status & kTickSpindleStopped);
  test::Move(
      simulation, params, 5.5, 2, 5, [&](const TickOutput& o) { out = o; }, 0);
  EXPECT_NEAR(Against(out, params), 0, 1e-6);
}

TEST(SlabCut, BoneIsNotCutTwice) {
  SlabParams params;
  SlabSimulation simulation(test::UniformProfile(kE24_MPa, kNu24, 30), params, HandAt(-1, params));
  test::Move(simulation, params, -1, 6, 5, [](const TickOutput&) {});
  test::Move(simulation, params, 6, 0, 5, [](const TickOutput&) {});
  const double cutting_mJ = simulation.state().cutting_mJ;
  double worst_N = 0;
  test::Move(simulation, params, 0, 5.9, 5,
             [&](const TickOutput& out) { worst_N = std::max(worst_N, std::abs(Against(out, params))); });
  EXPECT_EQ(simulation.state().cutting_mJ, cutting_mJ);
  // Only inertia and the coupling's damper act. When the hand reverses abruptly, the force is at most m v / dt.
  EXPECT_LT(worst_N, 0.2);
}

}  // namespace
}  // namespace kerf
