// Heat: a fraction of the cutting power enters the remaining bone, all of it is accounted for, and nothing else
// changes.
#include "cut/effects/heat/heat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/core/heap_guard.h"
#include "cut/effects/effects.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "cut/removal/cutter.h"
#include "kerf/coupled.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr double kRpm = 7500;
constexpr double kRimSpeed = 2 * std::numbers::pi * kRpm / 60 * 11;  // mm/s

/// A disc that moves down through a block, with a prescribed force along the motion of each tooth. Does what a tick
/// does, except that the tangential forces are prescribed.
class HeatedCut {
 public:
  explicit HeatedCut(const HeatParams& params, double feed_mm_per_s = 3)
      : feed_(feed_mm_per_s),
        bone_(test::MakeBox(Pose{}, {8, 5, 6}, 0.2)),
        field_(bone_),
        shape_(MakeToolShape(tool_, {8, 1e3, 0, 0})),
        edge_(field_, bone_, tool_, shape_, Vec3(0)),
        cutter_(field_, tool_, CutWith::kWholeTool),
        heat(params, {bone_, field_, tool_, shape_, edge_, problem_.law, nullptr, Vec3(0), field_.p_WF_mm()}) {
    problem_.law = MakeToothForce(ForceLaw{}, tool_);
    problem_.passes_per_s = 24 * kRpm / 60;
    problem_.cutting.reserve(shape_.edge.size());
    teeth_.reserve(shape_.edge.size());
  }

  /// Moves down by the feed, with 2 N along the motion of each tooth. Deterministic and free of allocation.
  void Tick(double dt_s) {
    const Pose X_a = At(time_s_);
    time_s_ += dt_s;
    const Pose X_b = At(time_s_);
    edge_.FindTeeth(Probe(field_, X_a), problem_);
    teeth_.clear();
    for (std::size_t i = 0; i < problem_.cutting.size(); ++i) {
      const CuttingPoint& point = problem_.cutting[i];
      const EdgePoint& place = shape_.edge[static_cast<std::size_t>(edge_.contacts()[i].point)];
      ToothLoad load;
      load.p_T = place.p_T;
      load.e_T = place.e_T;
      load.teeth = point.teeth;
      load.speed_mm_per_s = std::max(0.0, glm::dot(place.e_T, X_a.InverseVector({0, 0, -feed_})));
      load.thrust_N = 3 * point.teeth;
      load.tangential_N = 2 * point.teeth;
      teeth_.push_back(load);
      work_mJ += dt_s * (load.tangential_N * kRimSpeed + load.thrust_N * load.speed_mm_per_s);
    }
    cutter_.Cut(X_a, X_b);
    const Twist u{};
    const EffectSolved solved{X_a, X_b, edge_, nullptr, problem_, u, 1, dt_s, kRpm, teeth_};
    heat.Solved(solved);
    EffectEnd end{dt_s, kRpm, kRpm, X_b, problem_.cutting.empty(), 0, 0, 0};
    heat.End(end);
  }
  void Run(double seconds, double rate_hz) {
    const auto ticks = static_cast<int>(std::lround(seconds * rate_hz));
    for (int i = 0; i < ticks; ++i) Tick(1 / rate_hz);
  }
  /// Runs ticks without cutting.
  void Rest(double seconds, double rate_hz, double rpm = 0) {
    const Pose X = At(time_s_);
    const auto ticks = static_cast<int>(std::lround(seconds * rate_hz));
    for (int i = 0; i < ticks; ++i) {
      EffectEnd end{1 / rate_hz, rpm, rpm, X, true, 0, 0, 0};
      heat.End(end);
    }
  }

  double work_mJ = 0;

 private:
  Pose At(double time_s) const { return test::DiscPose(Pose{}, {0, 0.03, 3 + 11 - feed_ * time_s}); }

  double feed_;
  Tool tool_ = DiscSaw{};
  Bone bone_;
  BoneField field_;
  ToolShape shape_;
  Edge edge_;
  Cutter cutter_;
  StepProblem problem_;
  std::vector<ToothLoad> teeth_;
  double time_s_ = 0;

 public:
  HeatEffect heat;
};

TEST(Heat, ReceivesItsFractionOfThePowerWithoutLoss) {
  for (const double irrigation : {0.0, 2000.0}) {
    HeatParams params;
    params.share_into_bone = 0.2;
    params.grid.irrigation_W_per_m2K = irrigation;
    HeatedCut cut(params);
    cut.Run(1.5, 1000);
    const HeatBalance b = cut.heat.CalcBalance();
    ASSERT_GT(cut.work_mJ, 1000);
    EXPECT_NEAR(b.put_in, 0.2 * cut.work_mJ, 1e-9 * cut.work_mJ);
    // The nodes' values are floats, which are rounded in each of about 15 frames.
    EXPECT_NEAR(b.CalcRest(), 0, 1e-6 * b.put_in);
    EXPECT_EQ(b.no_room, 0);
    EXPECT_GT(b.chips, 0);
    EXPECT_GT(b.air, 0);
    EXPECT_GT(b.perfusion, 0);
    // Most of the heat that is put in stays in the walls.
    EXPECT_LT(b.chips, 0.2 * b.put_in);
    if (irrigation > 0) {
      EXPECT_GT(b.irrigation, 0.01 * b.put_in);
    } else {
      EXPECT_EQ(b.irrigation, 0);
    }
    cut.Rest(20, 1000);
    EXPECT_NEAR(cut.heat.CalcBalance().CalcRest(), 0, 1e-5 * b.put_in);
  }
}

TEST(Heat, CoolantKeepsTheBoneCooler) {
  HeatParams params;
  HeatedCut dry(params);
  params.grid.irrigation_W_per_m2K = 2000;
  HeatedCut wet(params);
  for (HeatedCut* cut : {&dry, &wet}) {
    cut->Run(1.8, 1000);
    cut->Rest(2, 1000, kRpm);
  }
  EXPECT_LT(wet.heat.figures().peak_C, dry.heat.figures().peak_C);
  EXPECT_LT(wet.heat.figures().hottest_C, dry.heat.figures().hottest_C - 1);
  EXPECT_LT(wet.heat.figures().cem43_min, dry.heat.figures().cem43_min);
}

// Frames have a fixed length of 0.1 s. The tick rate affects which of two frames the heat of a tick is added to (a tick
// at 250 Hz has 4 % of a frame's heat), and from which frame on removed bone is missing. The tolerances allow for one
// frame in 60 s of cooling, and for two frames in the time above 47 C.
TEST(Heat, DoesNotDependOnTheTickRate) {
  std::vector<HeatFigures> figures;
  std::vector<double> stored;
  for (const double rate_hz : {250.0, 1000.0, 4000.0}) {
    HeatedCut cut(HeatParams{});
    cut.Run(1.8, rate_hz);
    cut.Rest(60, 250);
    figures.push_back(cut.heat.figures());
    stored.push_back(cut.heat.CalcBalance().stored / cut.heat.CalcBalance().put_in);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_GT(figures[2].peak_C, 45);
    EXPECT_NEAR((figures[i].peak_C - 37) / (figures[2].peak_C - 37), 1, 0.04);
    EXPECT_NEAR((figures[i].hottest_C - 37) / (figures[2].hottest_C - 37), 1, 0.005);
    EXPECT_NEAR(figures[i].above_47_s, figures[2].above_47_s, 0.21);
    EXPECT_NEAR(stored[i] / stored[2], 1, 0.005);
  }
}

TEST(Heat, DoesNotAllocateAndIsReproducible) {
  std::vector<double> first;
  for (int round = 0; round < 2; ++round) {
    HeatedCut cut(HeatParams{});
    std::vector<double> channels(Heat().channels.size());
    {
      const HeapGuard guard;
      cut.Run(1, 1000);
      cut.heat.Report(channels);
    }
    EXPECT_GT(channels[1], 40);
    if (round == 0) first = channels;
    EXPECT_EQ(channels, first);
  }
}

// The tool makes a long motion in one tick, as after it was set down far away.
TEST(Heat, BalanceClosesForLongTicks) {
  HeatedCut cut(HeatParams{}, 0.5);
  cut.Run(10, 1);
  const HeatBalance b = cut.heat.CalcBalance();
  ASSERT_GT(b.put_in, 0);
  EXPECT_NEAR(b.CalcRest(), 0, 1e-5 * b.put_in);
  EXPECT_TRUE(std::isfinite(cut.heat.figures().peak_C));
}

TEST(Heat, SectionShowsTheWarmKerfAndTheColdBone) {
  HeatedCut cut(HeatParams{});
  cut.Run(1.5, 1000);
  // A section across the kerf, 1 mm below the block's top; the kerf is at y = 0.03.
  const HeatSection section = CalcHeatSection(cut.heat, {0, -2.4, 2}, {0, 1, 0}, {0, 0, -1}, 0.1, 49, 2);
  ASSERT_EQ(section.C.size(), 98u);
  EXPECT_TRUE(std::isnan(section.C[24]));  // in the kerf
  EXPECT_GT(section.C[22], 40);            // next to it
  EXPECT_GT(section.C[27], 40);
  EXPECT_LT(section.C[0], 38);
  EXPECT_LT(section.C[48], 38);
}

// ---- in a simulation

template <typename Out>
bool IsSame(const Out& a, const Out& b) {
  return a.thrust_sum_N == b.thrust_sum_N && a.removed_mm3 == b.removed_mm3 && a.engaged_teeth == b.engaged_teeth;
}

TEST(Heat, OnAPathOnlyObserves) {
  SimulationParams params;
  for (const char* needed : Heat().needs) params.effects.emplace_back(needed);
  const Bone bone = test::MakeBox(Pose{}, {8, 5, 6}, 0.2);
  Simulation without(bone, params, test::DiscPose(Pose{}, {0, 0.03, 14.5}));
  SetEffect(params.effects, "heat", "share_into_bone", 1);
  Simulation with(bone, params, test::DiscPose(Pose{}, {0, 0.03, 14.5}));
  const auto a = test::Stroke(without, Pose{}, {0, 0.03, 14.5}, {0, 0.03, 11}, 3);
  const auto b = test::Stroke(with, Pose{}, {0, 0.03, 14.5}, {0, 0.03, 11}, 3);
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(IsSame(a[i], b[i])) << i;
  EXPECT_EQ(without.UpdateBone().CalcHash(), with.UpdateBone().CalcHash());
  const auto* heat = dynamic_cast<const HeatEffect*>(EffectsOf(with).Find("heat"));
  ASSERT_NE(heat, nullptr);
  EXPECT_GT(heat->CalcBalance().put_in, 0);
}

TEST(Heat, InAHandOnlyObserves) {
  CoupledParams params;
  params.coupling.p_TC_mm = Vec3(0, 0, 80);
  for (const char* needed : Heat().needs) params.effects.emplace_back(needed);
  const Bone bone = test::MakeBox(Pose{}, {8, 5, 6}, 0.2);
  const Pose start = test::DiscPose(Pose{}, {0, 0.03, 14.5});
  CoupledSimulation without(bone, params, start);
  SetEffect(params.effects, "heat", "share_into_bone", 1);
  CoupledSimulation with(bone, params, start);
  for (int i = 0; i < 1500; ++i) {
    const CoupledInput in{.X_WH = test::DiscPose(Pose{}, {0, 0.03, 14.5 - 0.004 * i})};
    const CoupledOutput a = without.Tick(in), b = with.Tick(in);
    ASSERT_TRUE(IsSame(a, b)) << i;
    ASSERT_TRUE(a.X_WT.p_AB == b.X_WT.p_AB && a.X_WT.R_AB == b.X_WT.R_AB && a.f_H_W_N == b.f_H_W_N) << i;
  }
  EXPECT_EQ(without.UpdateBone().CalcHash(), with.UpdateBone().CalcHash());
  EXPECT_GT(dynamic_cast<const HeatEffect*>(EffectsOf(with).Find("heat"))->CalcBalance().put_in, 0);
}

}  // namespace
}  // namespace kerf
