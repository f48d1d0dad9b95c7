// Tests that the picture shows the tick with the most chips in the air, and that later ticks do not change it.
#include "session/run/chips_picture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "cut/hand_sim/internals.h"
#include "kerf/simulation.h"
#include "support/cuts.h"
#include "test_paths.h"

namespace kerf {
namespace {

TEST(ChipsPicture, ShowsTheTickWithTheMost) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  SimulationParams params;
  SetEffect(params.effects, "chips", "life_s", 0.05);
  const auto at = [](int tick) { return test::DiscPose({}, {0, 0.03, 5 + 11 + 0.2 - 0.005 * std::min(tick, 300)}); };
  Simulation simulation(test::MakeBox(Pose{}, {30, 4, 10}, 0.2), params, at(0));
  const EffectPlan& plan = EffectsOf(std::as_const(simulation));
  const auto& chips = dynamic_cast<const ChipsEffect&>(*plan.Find("chips"));
  ChipsTrack track(plan);
  std::size_t most = 0;
  double max_s = 0, thrown_mm3 = 0;
  for (int tick = 1; tick <= 400; ++tick) {
    simulation.Tick({at(tick), 0.001, 7500});
    track.Take(0.001 * tick, at(tick));
    if (chips.pool().size() <= most) continue;
    most = chips.pool().size();
    max_s = 0.001 * tick;
    thrown_mm3 = chips.thrown_mm3();
  }
  track.Detach();
  EXPECT_TRUE(chips.pool().empty());  // no chips are in the air at the end
  ASSERT_TRUE(track.peak().has_value());
  const ChipsTrack::Moment& moment = *track.peak();
  EXPECT_GT(most, 20u);
  EXPECT_EQ(moment.pool.size(), most);
  EXPECT_EQ(moment.time_s, max_s);
  EXPECT_EQ(moment.emitted_mm3, thrown_mm3);

  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("kerf_chips_" + std::to_string(getpid()) + ".png");
  EXPECT_TRUE(WriteChipsPicture(track, simulation.UpdateBone(), params.tool, false, "test", file.string()));
  EXPECT_GT(std::filesystem::file_size(file), 1000u);
  std::filesystem::remove(file);
}

TEST(ChipsPicture, IsNotDrawnWithoutChips) {
  Simulation simulation(test::MakeBox(Pose{}, {4, 4, 4}, 0.5), {}, test::DiscPose({}, {0, 0, 30}));
  ChipsTrack track(EffectsOf(simulation));
  track.Take(0.001, Pose{});
  EXPECT_FALSE(track.peak().has_value());
  EXPECT_FALSE(WriteChipsPicture(track, simulation.UpdateBone(), DiscSaw{}, false, "test", "/nonexistent/chips.png"));
}

}  // namespace
}  // namespace kerf
