// Tests of the sums of the costs of a tick's parts.
#include "session/run/stage_costs.h"

#include <gtest/gtest.h>

#include "cut/hand_sim/internals.h"
#include "session/run/make_bone.h"
#include "session/run/run.h"
#include "session/scene/scene.h"
#include "support/block_scene.h"

namespace kerf {
namespace {

const std::string kStageCostsScene = test::BlockToml({12, 4, 6}, 0.2) +
                                     test::StrokeToml({-16, 0, 10}, {-8, 0, 10}, 20, {0, 1, 0}) +
                                     "[simulation]\nrate_hz = 500\n";

RunResult RunWith(const std::string& effects, const CostOptions& costs) {
  const Scene scene = ParseScene(kStageCostsScene + effects, "costs.toml");
  return RunPath(MakeSceneBone(scene, {}), MakeSimulationParams(scene), MakePath(scene), scene.simulation.rate_hz,
                 scene.tool.rpm, {}, costs);
}

std::uint64_t HashOf(const RunResult& run) {
  return run.bone.CalcHash();
}

TEST(StageCosts, StagesAddUpToTheTickAndIncludeEffects) {
  const RunResult run = RunWith("[effects.kerf_friction]\n[effects.tangential_force]\n[effects.heat]\n", {true, {}});
  ASSERT_TRUE(run.costs);
  const StageCosts& costs = *run.costs;
  EXPECT_EQ(costs.budget_us, 2000);
  EXPECT_EQ(costs.tick.count, run.ticks.size());
  double stages_us = 0;
  for (const PartTimes& part : costs.stages) {
    stages_us += part.mean_us;
    EXPECT_LE(part.p50_us, part.p99_us);
    EXPECT_LE(part.p99_us, part.max_us);
  }
  // The tick's own time is measured outside the stages, so it is longer. The difference is a call and some reads of the
  // clock. It has no bound, because the machine may interrupt them.
  EXPECT_LE(stages_us, costs.tick.mean_us * (1 + 1e-9));
  EXPECT_GT(stages_us, 0);
  ASSERT_EQ(costs.effects.size(), 2u);  // friction needs a hand
  double effects_us = 0;
  for (const PartTimes& part : costs.effects) {
    EXPECT_GT(part.mean_us, 0) << part.name;
    effects_us += part.mean_us;
  }
  EXPECT_EQ(costs.effects[1].name, "heat");
  EXPECT_LE(effects_us, stages_us);
}

TEST(StageCosts, TimingIsOffByDefaultAndDoesNotChangeResults) {
  const RunResult plain = RunWith("[effects.tangential_force]\n[effects.heat]\n", {});
  const RunResult watched = RunWith("[effects.tangential_force]\n[effects.heat]\n", {true, {}});
  EXPECT_FALSE(plain.costs);
  EXPECT_EQ(HashOf(plain), HashOf(watched));
  ASSERT_EQ(plain.ticks.size(), watched.ticks.size());
  for (std::size_t i = 0; i < plain.ticks.size(); ++i) {
    EXPECT_EQ(plain.ticks[i].out.f_T_W_N, watched.ticks[i].out.f_T_W_N);
  }
}

/// Each read of the clock is one microsecond after the previous one.
class CountingClock final : public LoopClock {
 public:
  std::int64_t Now() noexcept override { return now_ns_ += 1000; }
  void SleepUntil(std::int64_t) noexcept override {}
  void Burn(std::int64_t) noexcept override {}

 private:
  std::int64_t now_ns_ = 0;
};

TEST(StageCosts, TimeOfATickIsAssignedToItsStages) {
  CountingClock clock;
  StageTimer timer(clock);
  LogHistogram ticks;
  for (int i = 0; i < 4; ++i) {
    timer.Enter(TickStage::kAccept);                  // 1 us until the next
    timer.Enter(TickStage::kEngage);                  // 1 us
    timer.Enter(TickStage::kRemove);                  // 1 us
    if (i % 2 == 0) timer.Enter(TickStage::kEngage);  // again, in every other tick: 1 us
    timer.Enter(TickStage::kEnd);
    timer.Finish();
    ticks.Add(i % 2 == 0 ? 4000 : 3000);
  }
  timer.Enter(TickStage::kAccept);
  timer.Finish(false);  // this tick does not count
  const Scene scene = ParseScene(kStageCostsScene, "costs.toml");
  const Simulation simulation(MakeSceneBone(scene, {}), MakeSimulationParams(scene), MakePath(scene).CalcPose(0, 0));
  const StageCosts costs = MakeStageCosts(ticks, timer, EffectsOf(simulation), 3.5);
  EXPECT_EQ(costs.over, 2u);
  ASSERT_EQ(costs.stages.size(), 3u);
  EXPECT_NEAR(costs.stages[0].mean_us, 1, 1e-9);
  EXPECT_NEAR(costs.stages[1].mean_us, 1.5, 1e-9);
  EXPECT_NEAR(costs.stages[1].max_us, 2, 1e-9);
  EXPECT_NEAR(costs.stages[2].mean_us, 1, 1e-9);
  EXPECT_EQ(FormatCostLine(costs), "tick 4 us, p99 4 of 4: accept 1 engage 2 remove 1");
  EXPECT_NE(FormatCostTable(costs).find("2 took longer"), std::string::npos);
}

}  // namespace
}  // namespace kerf
