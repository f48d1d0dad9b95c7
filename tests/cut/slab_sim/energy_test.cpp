// No energy is created, for any motion of the hand, and each step solves its equation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "cut/slab_sim/monotone.h"
#include "kerf/error.h"
#include "slab_setup.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::HandAt;
using test::kRpm;
using test::kTick_s;

double Draw(std::mt19937& random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}
double DrawDecades(std::mt19937& random, double lower, double upper) {
  return std::exp(Draw(random, std::log(lower), std::log(upper)));
}

SlabParams RandomParams(std::mt19937& random) {
  SlabParams p;
  p.direction_W = glm::normalize(Vec3(Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, 0.1, 1)));
  p.reading = random() % 2 ? PaperReading::kAsComputed : PaperReading::kCorrected;
  p.mass_g = DrawDecades(random, 0.01, 100);
  p.stiffness_N_per_mm = random() % 3 ? DrawDecades(random, 1e-3, 100) : 0;
  p.damping_Ns_per_mm = random() % 3 ? DrawDecades(random, 1e-5, 1) : 0;
  p.friction_coefficient = random() % 3 ? Draw(random, 0, 1) : 0;
  p.normal_force_N = DrawDecades(random, 0.01, 50);
  p.coupling_N_per_mm = DrawDecades(random, 0.1, 1e4);
  p.coupling_damping_Ns_per_mm = random() % 3 ? DrawDecades(random, 1e-5, 1) : 0;
  p.segments_move = random() % 2;
  p.segment_mass_g = DrawDecades(random, 0.1, 100);
  p.segment_stiffness_N_per_mm = random() % 3 ? DrawDecades(random, 1e-3, 100) : 0;
  p.segment_damping_Ns_per_mm = random() % 3 ? DrawDecades(random, 1e-5, 1) : 0;
  return p;
}

TEST(SlabEnergy, BalancesToRoundingAndLossesOnlyGrowForAnyHand) {
  int freed = 0;
  int stuck = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const SlabParams params = RandomParams(random);
    SlabProfile profile = test::UniformProfile(Draw(random, 300, 20000), 0.3, Draw(random, 2, 30));
    profile.layers.push_back({Draw(random, 0.5, 1.9), 0, 0, 0});
    double hand = random() % 2 ? -1 : 1.95;  // the hand starts outside the bone or is set down inside it
    SlabSimulation simulation(profile, params, HandAt(hand, params));
    SlabState before = simulation.state();
    double v = 0;
    double largest = 0;
    for (int i = 0; i < 1500; ++i) {
      // A random hand that at times stops, jumps, lets go or grasps another body, and a spindle that sometimes stops.
      if (i % 50 == 0) v = random() % 5 ? Draw(random, -20, 40) : 0;
      hand += v * kTick_s + (random() % 400 == 0 ? Draw(random, -5, 5) : 0);
      Pose X = HandAt(hand, params);
      X.p_AB += Vec3(Draw(random, -0.01, 0.01), Draw(random, -0.01, 0.01), 0);
      if (random() % 300 == 0) simulation.Hold(static_cast<SlabBody>(random() % (params.segments_move ? 4 : 1)));
      if (random() % 700 == 0) simulation.SetDown(X);
      const TickOutput out = simulation.Tick({X, kTick_s * Draw(random, 0.2, 1.5), random() % 20 ? kRpm : 0});
      const SlabState& s = simulation.state();
      ASSERT_TRUE(std::isfinite(out.f_T_W_N.x + s.kinetic_mJ + s.elastic_mJ)) << "seed " << seed << " tick " << i;
      largest = std::max({largest, s.kinetic_mJ + s.elastic_mJ, std::abs(s.hand_work_mJ), s.numerical_mJ});
      // The sums have up to 1e6 terms of that size, each rounded to 1e-16.
      ASSERT_NEAR(test::CalcImbalance(s), 0, 1e-9 * largest + 1e-12) << "seed " << seed << " tick " << i;
      ASSERT_GE(s.friction_mJ, before.friction_mJ);
      ASSERT_GE(s.cutting_mJ, before.cutting_mJ);
      ASSERT_GE(s.damping_mJ, before.damping_mJ);
      ASSERT_GE(s.released_mJ, before.released_mJ);
      ASSERT_GE(s.numerical_mJ, before.numerical_mJ - 1e-12 * largest);
      before = s;
      stuck += s.sticking;
    }
    freed += before.free;
  }
  // The random motions must have included separation and sticking.
  EXPECT_GT(freed, 20);
  EXPECT_GT(stuck, 1000);
}

TEST(SlabEnergy, BalancesWhenASegmentOfAFixedJawIsHeld) {
  SlabParams params;
  params.coupling_N_per_mm = 1e4;
  SlabSimulation simulation(test::UniformProfile(9000, 0.3, 10), params, HandAt(-1, params));
  simulation.Hold(SlabBody::kLeft);
  TickOutput out;
  test::Move(simulation, params, -1, 1, 5, [&](const TickOutput& o) { out = o; });
  // The jaw is rigid: the hand feels the coupling's 2 mm of stretch and its damper; the mean over the tick is lower by
  // up to half a tick's motion of 0.005 mm.
  EXPECT_NEAR(test::Against(out, params), 1e4 * 2 + 0.01 * 5, 0.5 * 1e4 * 0.005);
  EXPECT_NEAR(test::CalcImbalance(simulation.state()), 0, 1e-9 * 2e4);
  EXPECT_NEAR(simulation.state().elastic_mJ, 0.5 * 1e4 * 4, 1e-6);
}

TEST(SlabEnergy, StickingFacesDissipateNothingUnderAnyPressure) {
  SlabParams params;
  params.segments_move = true;
  params.friction_coefficient = 10;
  params.normal_force_N = 1e4;
  SlabSimulation simulation(test::UniformProfile(9000, 0.3, 50), params, HandAt(5, params));
  for (int i = 1; i <= 3000; ++i) {
    simulation.Tick({HandAt(5 + 2 * std::sin(0.01 * i), params), kTick_s, kRpm});
    ASSERT_TRUE(simulation.state().sticking);
    ASSERT_EQ(simulation.state().friction_mJ, 0);
    ASSERT_EQ(simulation.state().left_mm, simulation.state().right_mm);
  }
  EXPECT_GT(std::abs(simulation.state().left_mm), 0.1);
}

TEST(SlabEnergy, NeverGrowsWithoutTheHand) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    SlabParams params = RandomParams(random);
    SlabSimulation simulation(test::UniformProfile(5000, 0.3, 20), params, HandAt(-1, params));
    test::Move(simulation, params, -1, 10, 60, [](const TickOutput&) {});
    simulation.Tick({HandAt(10, params), kTick_s, kRpm});
    double before = simulation.state().kinetic_mJ + simulation.state().elastic_mJ;
    const double start = before;
    for (int i = 0; i < 1000; ++i) {
      simulation.Tick({HandAt(10, params), kTick_s, kRpm});  // a hand at rest does no work
      const double now = simulation.state().kinetic_mJ + simulation.state().elastic_mJ;
      ASSERT_LE(now, before + 1e-12 * start) << "trial " << trial << " tick " << i;
      before = now;
    }
  }
}

TEST(SlabEnergy, CuttingThroughCostsTheIntegralOfTheLawAlsoInOneJump) {
  SlabParams params;
  params.reading = PaperReading::kCorrected;
  params.mass_g = 0.01;
  const double depth = 9;
  // The integral of n(h) F_1 over the depth, by the midpoint rule with 1e5 steps.
  double expected = 0;
  for (int i = 0; i < 100000; ++i) {
    expected +=
        CalcPaperForce(params.saw, 0.01, (i + 0.5) * depth / 1e5, 19300, 0.28, PaperReading::kCorrected) * depth / 1e5;
  }
  for (const bool jump : {false, true}) {
    SlabSimulation simulation(test::UniformProfile(19300, 0.28, depth), params, HandAt(-1, params));
    if (jump) {
      simulation.Tick({HandAt(12, params), kTick_s, kRpm});
    } else {
      test::Move(simulation, params, -1, 12, 10, [](const TickOutput&) {});
    }
    ASSERT_TRUE(simulation.state().free);
    // With slow motion the error is 1e-3. A jump is split into substeps of 0.02 mm, each with the law at its start.
    EXPECT_NEAR(simulation.state().cutting_mJ, expected, (jump ? 0.02 : 0.002) * expected) << jump;
  }
}

TEST(SlabStep, SolvesTheMonotoneEquationAsBisectionDoes) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<MonotoneGraph, 2> graphs;
    for (MonotoneGraph& graph : graphs) {
      std::array<double, 4> v;
      std::array<double, 4> f;
      for (int i = 0; i < 4; ++i) {
        v[i] = Draw(random, -1, 1);
        f[i] = Draw(random, -1, 1);
      }
      if (random() % 2) v[1] = v[0];
      if (random() % 2) v[3] = v[2];
      if (random() % 4 == 0) v[2] = v[1];
      std::sort(v.begin(), v.end());
      std::sort(f.begin(), f.end());
      for (int i = 0; i < 4; ++i) graph.corners[i] = {v[i], f[i]};
    }
    const double a = DrawDecades(random, 0.01, 10);
    const double b = Draw(random, -3, 3);
    double fraction = 0;
    const double solved = SolveMonotone(a, b, graphs, &fraction);
    double lower = -1000;
    double upper = 1000;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (lower + upper);
      (a * middle + graphs[0].Above(middle) + graphs[1].Above(middle) < b ? lower : upper) = middle;
    }
    // Bisection ends at adjacent doubles; slopes are at least 0.01, values up to 10.
    ASSERT_NEAR(solved, upper, 1e-10) << "trial " << trial;
    double sum = a * solved;
    for (const MonotoneGraph& graph : graphs) {
      sum += graph.Below(solved) + fraction * (graph.Above(solved) - graph.Below(solved));
    }
    ASSERT_NEAR(sum, b, 1e-10) << "trial " << trial;
  }
}

TEST(SlabTick, IsReproducibleBitForBit) {
  const auto run = [] {
    std::mt19937 random(9);
    SlabParams params = RandomParams(random);
    params.segments_move = true;
    SlabSimulation simulation(test::UniformProfile(9000, 0.3, 10), params, HandAt(-1, params));
    test::Move(simulation, params, -1, 8, 30, [](const TickOutput&) {});
    return simulation.state();
  };
  const SlabState a = run();
  const SlabState b = run();
  EXPECT_EQ(a.blade_mm, b.blade_mm);
  EXPECT_EQ(a.hand_work_mJ, b.hand_work_mJ);
  EXPECT_EQ(a.numerical_mJ, b.numerical_mJ);
}

TEST(SlabTick, KeepsTheLastGoodPoseOverABadOne) {
  SlabParams params;
  SlabSimulation simulation(test::UniformProfile(9000, 0.3, 10), params, HandAt(-1, params));
  SlabSimulation twin(test::UniformProfile(9000, 0.3, 10), params, HandAt(-1, params));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 1000; ++i) {
    const Pose X = HandAt(-1 + 0.005 * i, params);
    if (i % 7 == 0) {
      Pose bad = X;
      bad.p_AB.y = nan;
      EXPECT_EQ(simulation.Tick({bad, kTick_s, kRpm}).status, kTickBadPose);
      EXPECT_EQ(simulation.Tick({X, i % 2 ? nan : -1.0, kRpm}).status, kTickBadPose);
    }
    simulation.Tick({X, kTick_s, kRpm});
    twin.Tick({X, kTick_s, kRpm});
  }
  EXPECT_EQ(simulation.state().blade_mm, twin.state().blade_mm);
  EXPECT_EQ(simulation.state().cutting_mJ, twin.state().cutting_mJ);
}

TEST(SlabTick, ParametersOutOfRangeAreRefusedWithAMessage) {
  const auto message = [](auto change) {
    SlabParams params;
    SlabProfile profile = test::UniformProfile(9000, 0.3, 10);
    change(params, profile);
    return test::MessageOf([&] { SlabSimulation(profile, params, test::HandAt(-1, SlabParams())); });
  };
  EXPECT_EQ(message([](SlabParams&, SlabProfile&) {}), "");
  EXPECT_EQ(message([](SlabParams& p, SlabProfile&) { p.mass_g = 0; }),
            "mass_g = 0 is below 0.001; valid range 0.001 to 10000 g");
  EXPECT_EQ(message([](SlabParams& p, SlabProfile&) { p.friction_coefficient = std::nan(""); }),
            "friction_coefficient = nan is not a finite number; valid range 0 to 10");
  EXPECT_EQ(message([](SlabParams& p, SlabProfile&) {
              p.direction_W = {0, 2, 0};
            }),
            "the cut direction is not of unit length");
  EXPECT_EQ(message([](SlabParams&, SlabProfile& p) { p.layers.clear(); }), "the slice's profile is empty");
  EXPECT_EQ(message([](SlabParams&, SlabProfile& p) {
              p.layers.push_back({-1, 24, 9000, 0.3});
            }),
            "the slice's layers must begin at depth 0 and go down to its end; one begins at -1 mm");
  EXPECT_EQ(message([](SlabParams&, SlabProfile& p) { p.layers[0].E_MPa = std::nan(""); }),
            "the slice's layer at 0 mm has E = nan MPa and nu = 0.3; E must be finite and 0 or more, and nu 0 to 0.5");
  EXPECT_EQ(
      message([](SlabParams&, SlabProfile& p) { p.entry_mm = -40; }),
      "the blade starts 39.00 mm deep, past the slice, which ends at 10.00 mm; start it before the bone along the "
      "cut direction");
}

}  // namespace
}  // namespace kerf
