// Chips: the thrown volume equals the removed volume, chips start where the teeth leave the bone and fly like balls.
#include "cut/effects/chips.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/cuts.h"

namespace kerf {
namespace {

using test::DiscPose;

constexpr double kG_mm_per_s2 = 9810;

bool IsFinite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Returns a reference solution, computed in small steps with the fourth-order Runge-Kutta method.
ChipMotion Reference(const ChipFlight& flight, ChipMotion m, const Vec3& g, double age_s) {
  const int steps = 20000;
  const double h = age_s / steps;
  const auto slope = [&](const Vec3& v) { return g - flight.CalcDragRate(glm::length(v)) * v; };
  for (int i = 0; i < steps; ++i) {
    const Vec3 v1 = m.v_mm_per_s, a1 = slope(v1);
    const Vec3 v2 = v1 + 0.5 * h * a1, a2 = slope(v2);
    const Vec3 v3 = v1 + 0.5 * h * a2, a3 = slope(v3);
    const Vec3 v4 = v1 + h * a3, a4 = slope(v4);
    m.p_mm += h / 6 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    m.v_mm_per_s += h / 6 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return m;
}

TEST(ChipFlight, WithoutDragIsAParabola) {
  const Vec3 g(0, 0, -kG_mm_per_s2);
  const ChipFlight flight(0.15, 0, g);
  const ChipMotion start{{1, 2, 3}, {4000, -500, 2500}};
  for (const double t : {0.0, 1e-6, 0.001, 0.4, 1.0, 60.0}) {
    const ChipMotion m = flight.CalcMotion(start, t);
    const Vec3 p = start.p_mm + t * start.v_mm_per_s + 0.5 * t * t * g;
    EXPECT_LE(glm::length(m.p_mm - p), 1e-14 * (1 + glm::length(p))) << t;
    EXPECT_LE(glm::length(m.v_mm_per_s - (start.v_mm_per_s + t * g)), 1e-14 * (1e4 + t * kG_mm_per_s2)) << t;
  }
}

TEST(ChipFlight, TerminalSpeedBalancesDragAndWeight) {
  for (const double size_mm : {0.02, 0.15, 0.5, 2.0}) {
    // The weight pi/6 d^3 rho g equals the drag Cd pi/8 d^2 rho_air v^2; this is solved by bisection, in m, kg and s.
    const double d = 1e-3 * size_mm;
    const auto drag_N = [&](double v) {
      const double re = 1.2 * v * d / 1.81e-5;
      const double cd = re < 1000 ? 24 / re * (1 + 0.15 * std::pow(re, 0.687)) : 0.44;
      return cd * std::numbers::pi / 8 * d * d * 1.2 * v * v;
    };
    const double weight_N = std::numbers::pi / 6 * d * d * d * 1908 * 9.81;
    double low = 0, high = 100;
    for (int i = 0; i < 200; ++i) (drag_N(0.5 * (low + high)) < weight_N ? low : high) = 0.5 * (low + high);
    const ChipFlight flight(size_mm, 1, {0, 0, -kG_mm_per_s2});
    ChipMotion m{{0, 0, 0}, {8000, 0, 0}};
    for (int i = 0; i < 80; ++i) m = flight.CalcMotion(m, 0.5);
    // After 40 s the two differ only by rounding.
    EXPECT_NEAR(-m.v_mm_per_s.z, 1000 * low, 1e-9 * 1000 * low) << size_mm;
    EXPECT_NEAR(m.v_mm_per_s.x, 0, 1e-6) << size_mm;
  }
}

TEST(ChipFlight, FollowsTheEquationToAPercent) {
  const Vec3 g(0, 0, -kG_mm_per_s2);
  for (const double size_mm : {0.05, 0.15, 1.0}) {
    const ChipFlight flight(size_mm, 1, g);
    const ChipMotion start{{0, 0, 0}, {6000, 0, 6000}};
    for (const double t : {0.003, 0.05, 0.4}) {
      const ChipMotion m = flight.CalcMotion(start, t);
      const ChipMotion exact = Reference(flight, start, g, t);
      // The error of the 32 second-order steps is at most 0.5 %, for the smallest chip after the longest time.
      EXPECT_LE(glm::length(m.p_mm - exact.p_mm), 1e-2 * glm::length(exact.p_mm)) << size_mm << " " << t;
      EXPECT_LE(glm::length(m.v_mm_per_s - exact.v_mm_per_s), 1e-3 * glm::length(start.v_mm_per_s)) << size_mm;
    }
  }
}

TEST(ChipFlight, StaysFiniteAndDragNeverSpeedsItUp) {
  for (const double size_mm : {0.02, 0.15, 5.0}) {
    for (const double drag : {0.0, 1.0, 100.0}) {
      const ChipFlight flight(size_mm, drag, Vec3(0));
      for (const double speed : {0.0, 1e-9, 1.0, 1e4, 1e7}) {
        for (const double t : {0.0, 1e-9, 1e-6, 0.001, 1.0, 1000.0}) {
          const ChipMotion m = flight.CalcMotion({{0, 0, 0}, {0, speed, 0}}, t);
          ASSERT_TRUE(IsFinite(m.p_mm) && IsFinite(m.v_mm_per_s));
          EXPECT_LE(m.v_mm_per_s.y, speed);
          EXPECT_GE(m.v_mm_per_s.y, 0);
          EXPECT_LE(m.p_mm.y, speed * t * (1 + 1e-12));
        }
      }
    }
  }
}

// The flight is computed from its start, so it does not depend on the number of calls or ticks.
TEST(ChipPool, FlightDoesNotDependOnTheTick) {
  ChipsParams params;
  ChipPool coarse(params), fine(params);
  for (ChipPool* pool : {&coarse, &fine}) pool->Throw({{1, 2, 3}, {3000, 100, 4000}}, 0);
  coarse.Advance(0.3);
  for (int i = 0; i < 3000; ++i) fine.Advance(1e-4);
  // The clock of the pool with the shorter ticks has accumulated 3000 rounding errors.
  EXPECT_LE(glm::length(coarse.CalcChip(0).p_F_mm - fine.CalcChip(0).p_F_mm), 1e-7);
  coarse.Advance(0.1001);
  EXPECT_TRUE(coarse.empty());
}

TEST(ChipPool, FullPoolDropsTheOldest) {
  ChipsParams params;
  params.max_chips = 5;
  ChipPool pool(params);
  for (int i = 0; i < 12; ++i) {
    pool.Throw({{static_cast<double>(i), 0, 0}, {0, 0, 0}}, 0);
    EXPECT_LE(pool.size(), 5u);
  }
  EXPECT_EQ(pool.cut_short(), 7u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(pool.CalcChip(i).p_F_mm.x, static_cast<double>(7 + i));
}

// ---- in a cut

constexpr double kTop_mm = 5;

Bone Block(double h = 0.2) {
  return test::MakeBox(Pose{}, {30, 4, 10}, h);
}

/// A tool that moves down into the block at 5 mm/s.
class Plunge {
 public:
  explicit Plunge(const ChipsParams& chips, double rpm = 7500, const Tool& tool = DiscSaw{})
      : rpm_(rpm), z_mm_(kTop_mm + CalcReach(tool) + 0.2), simulation_(Block(), Params(chips, tool), At(z_mm_)) {}

  static SimulationParams Params(const ChipsParams& chips, const Tool& tool) {
    SimulationParams params;
    params.tool = tool;
    EffectChoice choice("chips");
    choice.Set("size_mm", chips.size_mm)
        .Set("spread", chips.spread)
        .Set("life_s", chips.life_s)
        .Set("max_chips", static_cast<double>(chips.max_chips))
        .Set("chips_per_tick", static_cast<double>(chips.chips_per_tick))
        .Set("drag", chips.drag)
        .Set("gravity_m_per_s2", chips.gravity_W_m_per_s2)
        .Set("seed", static_cast<double>(chips.seed));
    params.effects.push_back(choice);
    return params;
  }
  static Pose At(double z_mm) { return DiscPose({}, {0, 0.03, z_mm}); }
  TickOutput Tick(double dt_s = 0.001, double mm_per_s = -5) {
    const HeapGuard guard;
    const TickOutput out = simulation_.Tick({At(z_mm_ += mm_per_s * dt_s), dt_s, rpm_});
    removed_mm3_ += out.removed_mm3;
    return out;
  }
  void ExpectAccountsClose() const {
    const ChipsEffect& e = effect();
    EXPECT_NEAR(e.thrown_mm3() + e.dropped_mm3() + e.waiting_mm3(), removed_mm3_, 1e-9 * (1 + removed_mm3_));
  }
  const ChipsEffect& effect() const { return dynamic_cast<const ChipsEffect&>(*EffectsOf(simulation_).Find("chips")); }
  double z_mm() const { return z_mm_; }
  double removed_mm3() const { return removed_mm3_; }

 private:
  double rpm_, z_mm_;
  Simulation simulation_;
  double removed_mm3_ = 0;
};

TEST(Chips, ThrownVolumeEqualsRemovedVolume) {
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{})}) {
    Plunge cut({.chips_per_tick = 1000}, 7500, tool);
    for (int i = 0; i < 800; ++i) {
      cut.Tick();
      cut.ExpectAccountsClose();
    }
    EXPECT_GT(cut.removed_mm3(), 2);
    EXPECT_EQ(cut.effect().dropped_mm3(), 0);
    // The whole volume is thrown except for a remainder that does not yet fill a chip; on a path, the last tick may
    // remove more bone than its engaged teeth have cut.
    EXPECT_LT(cut.effect().waiting_mm3(), cut.effect().chip_mm3());
    EXPECT_GT(cut.effect().pool().size(), 100u);
  }
}

TEST(Chips, AreBoundedAndCountedUnderLoad) {
  Plunge cut({.max_chips = 40, .chips_per_tick = 3});
  for (int i = 0; i < 800; ++i) {
    const double before_mm3 = cut.effect().thrown_mm3();
    cut.Tick();
    const ChipsEffect& e = cut.effect();
    EXPECT_LE(e.pool().size(), 40u);
    EXPECT_LE(e.thrown_mm3() - before_mm3, 3.0001 * e.chip_mm3());
    cut.ExpectAccountsClose();
  }
  const ChipsEffect& e = cut.effect();
  EXPECT_GT(e.dropped_mm3(), 0.1 * cut.removed_mm3());
  EXPECT_GT(e.pool().cut_short(), 100u);
  // No chip reaches its life of 0.4 s: all chips that are gone were removed early.
  EXPECT_NEAR(e.thrown_mm3() / e.chip_mm3(), static_cast<double>(e.pool().cut_short() + e.pool().size()), 1e-6);
  EXPECT_GT(e.CalcMemoryBytes(), sizeof(ChipsEffect));
}

// Without spread, weight or air drag, a chip moves straight, at the rim's speed and tangentially to the rim, from where
// the rim leaves the block: on one side or the other, depending on the direction of rotation.
TEST(Chips, FlyOffWhereTheRimLeavesTheBone) {
  for (const double rpm : {7500.0, -7500.0, 600.0}) {
    Plunge cut({.spread = 0, .life_s = 0.01, .drag = 0, .gravity_W_m_per_s2 = Vec3(0)}, rpm);
    for (int i = 0; i < 500; ++i) cut.Tick();
    const ChipsEffect& e = cut.effect();
    ASSERT_GT(e.pool().size(), 20u);
    const Pose X_WT = Plunge::At(cut.z_mm());
    for (std::size_t i = 0; i < e.pool().size(); ++i) {
      const ChipPool::Chip chip = e.pool().CalcChip(i);
      // Starts are stored as floats.
      EXPECT_NEAR(glm::length(chip.v_F_mm_per_s), 2 * std::numbers::pi * 11 * std::abs(rpm) / 60, 1e-3);
      const Vec3 from_W = chip.p_F_mm + e.p_WF_mm() - chip.age_s * chip.v_F_mm_per_s;
      const Vec3 from_T = X_WT.InversePoint(from_W);
      // The tool has moved by 0.05 mm since then.
      EXPECT_NEAR(std::hypot(from_T.x, from_T.y), 11, 0.051);
      EXPECT_LE(std::abs(from_T.z), 0.125 + 1e-4);
      // The chip starts where the rim crosses the block's top, to within the spacing of the edge points (0.36 mm) and a
      // quarter of a voxel.
      EXPECT_NEAR(from_W.z, kTop_mm, 0.3);
      const Vec3 v_T = X_WT.InverseVector(chip.v_F_mm_per_s);
      EXPECT_GT(glm::dot(v_T, rpm * Vec3(-from_T.y, from_T.x, 0)), 0);
      EXPECT_GT(chip.v_F_mm_per_s.z, 0);
    }
  }
}

TEST(Chips, VelocitySpreadStaysWithinItsLimit) {
  Plunge cut({.spread = 0.3, .life_s = 0.05, .drag = 0, .gravity_W_m_per_s2 = Vec3(0)});
  for (int i = 0; i < 500; ++i) cut.Tick();
  const double rim = 2 * std::numbers::pi * 11 * 125;
  double smallest = 1e9, largest = 0, across = 0;
  const ChipPool& pool = cut.effect().pool();
  for (std::size_t i = 0; i < pool.size(); ++i) {
    const Vec3 v = pool.CalcChip(i).v_F_mm_per_s;
    smallest = std::min(smallest, glm::length(v)), largest = std::max(largest, glm::length(v));
    across = std::max(across, std::abs(v.y));
  }
  EXPECT_GE(smallest, 0.7 * rim - 1);
  EXPECT_LE(largest, 1.3 * rim + 1);
  EXPECT_LE(across, 0.3 * rim + 1);
  // The velocities of a few hundred chips fill most of the allowed ball.
  EXPECT_LT(smallest, 0.8 * rim);
  EXPECT_GT(largest, 1.2 * rim);
  EXPECT_GT(across, 0.2 * rim);
}

TEST(Chips, TheSameRunThrowsTheSameChips) {
  const auto run = [](std::uint64_t seed) {
    Plunge cut({.seed = seed});
    for (int i = 0; i < 300; ++i) cut.Tick();
    std::vector<double> all;
    const ChipPool& pool = cut.effect().pool();
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const ChipPool::Chip chip = pool.CalcChip(i);
      all.insert(all.end(), {chip.p_F_mm.x, chip.p_F_mm.y, chip.p_F_mm.z, chip.v_F_mm_per_s.x, chip.age_s});
    }
    return all;
  };
  const std::vector<double> first = run(1);
  ASSERT_GT(first.size(), 500u);
  EXPECT_EQ(first, run(1));
  const std::vector<double> other = run(2);
  EXPECT_EQ(first.size(), other.size());  // as many chips, at other places
  EXPECT_NE(first, other);
}

TEST(Chips, PoolIsEmptyAfterTheirLifetime) {
  Plunge cut({.life_s = 0.1});
  for (int i = 0; i < 300; ++i) cut.Tick();
  EXPECT_GT(cut.effect().pool().size(), 50u);
  const double thrown_mm3 = cut.effect().thrown_mm3();
  for (int i = 0; i < 101; ++i) cut.Tick(0.001, 50);
  EXPECT_TRUE(cut.effect().pool().empty());
  EXPECT_EQ(cut.effect().thrown_mm3(), thrown_mm3);
  std::array<double, 4> channels{};
  cut.effect().Report(channels);
  EXPECT_EQ(channels[0], 0);
  EXPECT_EQ(channels[1], thrown_mm3);
}

TEST(Chips, StopWithTheSpindle) {
  Plunge cut({}, 0);
  for (int i = 0; i < 300; ++i) cut.Tick();
  EXPECT_TRUE(cut.effect().pool().empty());
  EXPECT_EQ(cut.effect().thrown_mm3(), 0);
}

/// A hand that moves down into the block, sideways and out again, in ticks of `dt_s`.
struct HandRun {
  std::uint64_t bone = 0;
  std::vector<double> felt;
  double removed_mm3 = 0, accounted_mm3 = 0;
  std::size_t peak_chips = 0;
};
HandRun RunByHand(bool with, double dt_s, double rpm, const Tool& tool) {
  CoupledParams params;
  params.tool = tool;
  params.effects.clear();
  if (with) params.effects.emplace_back("chips");
  const auto handle = [&](double t) {
    const double deep_mm = 3 * std::clamp(std::min(t, 1.2 - t) * 2, 0.0, 1.0);
    return DiscPose({}, {4 * t, 0.2 * std::sin(5 * t), kTop_mm + CalcReach(tool) + 0.5 - deep_mm});
  };
  CoupledSimulation simulation(Block(0.4), params, handle(0));
  HandRun run;
  const int ticks = static_cast<int>(std::ceil(1.4 / dt_s));
  run.felt.reserve(12 * static_cast<std::size_t>(ticks));
  for (int tick = 1; tick <= ticks; ++tick) {
    CoupledOutput out;
    {
      const HeapGuard guard;
      out = simulation.Tick({.X_WH = handle(tick * dt_s), .dt_s = dt_s, .rpm = rpm});
      simulation.ClearChanged();
    }
    for (int axis = 0; axis < 3; ++axis) {
      run.felt.insert(run.felt.end(), {out.f_H_W_N[axis], out.tau_H_W_Nmm[axis], out.X_WT.p_AB[axis]});
    }
    run.removed_mm3 += out.removed_mm3;
    if (!with) continue;
    const auto& chips = dynamic_cast<const ChipsEffect&>(*EffectsOf(std::as_const(simulation)).Find("chips"));
    run.peak_chips = std::max(run.peak_chips, chips.pool().size());
    std::array<double, 4> channels{};
    chips.Report(channels);
    for (const double value : channels) EXPECT_TRUE(std::isfinite(value));
    for (std::size_t i = 0; i < chips.pool().size(); i += 7) {
      const ChipPool::Chip chip = chips.pool().CalcChip(i);
      EXPECT_TRUE(IsFinite(chip.p_F_mm) && IsFinite(chip.v_F_mm_per_s) && chip.age_s >= 0);
    }
    run.accounted_mm3 = chips.thrown_mm3() + chips.dropped_mm3() + chips.waiting_mm3();
  }
  run.bone = simulation.UpdateBone().CalcHash();
  return run;
}

TEST(Chips, ChangeNeitherForceNorMotionNorBone) {
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{})}) {
    for (const auto& [dt_s, rpm] : {std::pair(0.001, 7500.0), std::pair(0.001, -7500.0), std::pair(0.02, 1e6),
                                    std::pair(0.3, 7500.0), std::pair(1.0, 7500.0), std::pair(0.0002, 2.0)}) {
      SCOPED_TRACE(testing::Message() << dt_s << " s, " << rpm << " rpm");
      const HandRun plain = RunByHand(false, dt_s, rpm, tool);
      const HandRun with = RunByHand(true, dt_s, rpm, tool);
      EXPECT_EQ(with.bone, plain.bone);
      EXPECT_EQ(with.felt, plain.felt);
      EXPECT_EQ(with.removed_mm3, plain.removed_mm3);
      EXPECT_NEAR(with.accounted_mm3, with.removed_mm3, 1e-9 * (1 + with.removed_mm3));
      if (dt_s == 0.001) {
        EXPECT_GT(with.peak_chips, 100u);
      }
    }
  }
}

}  // namespace
}  // namespace kerf
