// Tests of the settings that a sweep tries and of its report.
#include "experiment/stability_study/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "experiment/stability_study/sweep_keys.h"
#include "kerf/error.h"
#include "support/block_scene.h"

namespace kerf {
namespace {

using testing::HasSubstr;

const std::string kSweepBlock = test::BlockToml({20, 4, 10}, 0.25) + "[effects.kerf_friction]\ncoefficient = 0.2\n" +
                                test::StrokeToml({0, 0, 12}, {0, 0, 4}, 3, {0, 1, 0});

Scene MakeScene(const std::string& more = "") {
  return ParseScene(kSweepBlock + more, "s.toml");
}

TEST(SweepKeys, AreTheNumbersOfTheSceneWithTheirRanges) {
  const Scene scene = MakeScene("[coupling]\nstiffness_N_per_mm = 3.0\n");
  const std::vector<SweepKey> keys = ListSweepKeys(scene);
  std::set<std::string> names;
  for (const SweepKey& key : keys) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_LE(key.least, key.default_value) << key.name;
    EXPECT_LE(key.default_value, key.greatest) << key.name;
    EXPECT_LE(key.least, key.own) << key.name;
    EXPECT_LE(key.own, key.greatest) << key.name;
    // The value that was set is read back, and nothing else changes.
    Scene changed = scene;
    SetSweepKey(changed, key.name, key.greatest);
    const std::vector<SweepKey> again = ListSweepKeys(changed);
    ASSERT_EQ(again.size(), keys.size()) << key.name;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      EXPECT_EQ(again[i].own, keys[i].name == key.name ? key.greatest : keys[i].own) << key.name << " " << keys[i].name;
    }
  }
  const auto stiffness =
      std::find_if(keys.begin(), keys.end(), [](const SweepKey& k) { return k.name == "coupling.stiffness_N_per_mm"; });
  ASSERT_NE(stiffness, keys.end());
  EXPECT_EQ(stiffness->own, 3);
  EXPECT_EQ(stiffness->default_value, 1);
  EXPECT_EQ(stiffness->least, 1e-3);
  EXPECT_EQ(stiffness->greatest, 1000);
  for (const char* name : {"bone.block.voxel_mm", "tool.teeth", "path.stroke[0].feed_mm_per_s", "simulation.substeps",
                           "effects.kerf_friction.coefficient", "device.delay_ticks", "hand.push_N", "loop.rate_hz"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
  EXPECT_THROW(
      {
        Scene copy = scene;
        SetSweepKey(copy, "tool.colour", 1);
      },
      Error);
}

TEST(SweepCases, ContainEachEndOfEachKeyOnceAndSeededPairs) {
  const Scene scene = MakeScene();
  SweepOptions options;
  options.pairs = 40;
  const std::vector<SweepCase> cases = MakeSweepCases(scene, options);
  EXPECT_TRUE(cases.front().settings.empty());
  std::size_t pairs = 0;
  for (const SweepKey& key : ListSweepKeys(scene)) {
    for (const double end : {key.least, key.greatest}) {
      const std::vector<SweepSetting> alone{{key.name, end}};
      const auto count =
          std::count_if(cases.begin(), cases.end(), [&](const SweepCase& c) { return c.settings == alone; });
      EXPECT_EQ(count, end == key.own ? 0 : 1) << key.name << " " << end;
    }
  }
  for (const SweepCase& c : cases) {
    if (c.settings.size() != 2) continue;
    ++pairs;
    EXPECT_NE(c.settings[0].key, c.settings[1].key);
  }
  EXPECT_EQ(pairs, 40U);
  const auto settings = [](const std::vector<SweepCase>& of) {
    std::vector<std::vector<SweepSetting>> all;
    for (const SweepCase& c : of) all.push_back(c.settings);
    return all;
  };
  EXPECT_EQ(settings(MakeSweepCases(scene, options)), settings(cases));
  options.seed = 2;
  EXPECT_NE(settings(MakeSweepCases(scene, options)), settings(cases));
  options.only = {"loop."};
  options.pairs = 0;
  for (const SweepCase& c : MakeSweepCases(scene, options)) {
    for (const SweepSetting& s : c.settings) EXPECT_THAT(s.key, testing::StartsWith("loop."));
  }
  options.only = {"lop."};
  EXPECT_THROW(MakeSweepCases(scene, options), Error);
}

SweepRow Try(const Scene& scene, std::vector<SweepSetting> settings) {
  SweepOptions options;
  options.case_s = 60;
  return TryCase(scene, {std::move(settings)}, options);
}

TEST(SweepRows, ReportTheOutcomeOfACase) {
  const Scene scene = MakeScene();
  const SweepRow as_it_is = Try(scene, {});
  EXPECT_EQ(as_it_is.verdict, SweepVerdict::kPass) << as_it_is.reason;
  const SweepRow refused = Try(scene, {{"loop.rate_hz", 100}});
  EXPECT_EQ(refused.verdict, SweepVerdict::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("rate_hz"));
  const SweepRow large = Try(scene, {{"bone.block.voxel_mm", 0.02}});
  EXPECT_EQ(large.verdict, SweepVerdict::kNotRun);
  EXPECT_THAT(large.reason, HasSubstr("voxels"));
  const SweepRow away = Try(scene, {{"tool.diameter_mm", 1}});
  EXPECT_EQ(away.verdict, SweepVerdict::kNotJudged);
  EXPECT_THAT(away.reason, HasSubstr("never touches the bone"));
}

// With a cutting force of five times the thrust, the saw would drive itself around the bone.
TEST(SweepRows, RatioBelowTheRangeIsRefusedAndTheMinimumDoesNotFail) {
  const Scene scene = MakeScene("[force]\nlaw = \"hertz_chip\"\n[effects.tangential_force]\n");
  const SweepRow below = Try(scene, {{"effects.tangential_force.ratio", 0.2}});
  EXPECT_EQ(below.verdict, SweepVerdict::kRefused);
  EXPECT_THAT(below.reason, HasSubstr("ratio"));
  const SweepRow lowest = Try(scene, {{"effects.tangential_force.ratio", 0.6}});
  EXPECT_NE(lowest.verdict, SweepVerdict::kFail) << lowest.reason;
  EXPECT_THAT(lowest.warnings, testing::Contains(HasSubstr("below the measured 1.4 to 1.8")));
}

// Tests both ends of each key of hand, device, coupling and loop: the loop starts with every setting that passes the
// check.
TEST(SweepRows, LoopStartsEverythingThatPassesTheCheck) {
  const Scene scene = MakeScene();
  SweepOptions options;
  options.pairs = 20;
  options.begin_only = true;
  options.only = {"coupling.", "device.", "hand.", "loop."};
  int begun = 0;
  for (const SweepCase& c : MakeSweepCases(scene, options)) {
    const SweepRow row = TryCase(scene, c, options);
    EXPECT_NE(row.verdict, SweepVerdict::kFail) << DescribeSettings(c.settings) << ": " << row.reason;
    begun += row.verdict == SweepVerdict::kPass;
  }
  EXPECT_GT(begun, 40);
}

// Regression: kerf itself raised the coupling's damping beyond its range, which the check did not detect.
TEST(SweepRows, LoopStartsWithAStiffCouplingAtALowRate) {
  const Scene scene = MakeScene();
  for (const double peak_N : {28.0, 1000.0, 10000.0}) {
    const SweepRow row =
        Try(scene, {{"coupling.stiffness_N_per_mm", 1000}, {"loop.rate_hz", 250}, {"device.expected_peak_N", peak_N}});
    EXPECT_THAT(row.reason, testing::Not(HasSubstr("refuse"))) << peak_N;
  }
}

// The interruption comes while the last case runs, so that no case is left to begin.
TEST(SweepScene, InterruptedCaseIsLeftOut) {
  std::atomic<bool> stop{false};
  SweepOptions options;
  options.only = {"loop.rate_hz"};
  options.pairs = 0;
  options.threads = 1;
  options.stop = &stop;
  const std::size_t cases = MakeSweepCases(MakeScene(), options).size();
  std::size_t calls = 0;  // two per case: when it begins and when it has ended
  const SweepStudy study = SweepScene(MakeScene(), options, [&](const std::string&, double) {
    if (++calls == 2 * cases - 1) stop = true;
  });
  EXPECT_FALSE(study.complete);
  EXPECT_EQ(study.rows.size(), cases - 1);
}

TEST(SweepFiles, HaveARowForEachCase) {
  SweepStudy study;
  study.scene = "s";
  study.rows = {{{}, SweepVerdict::kPass, "", {}, 0.5},
                {{{"tool.teeth", 1}}, SweepVerdict::kFail, "cut_5N: noise, much of it", {}, 0.25},
                {{{"tool.teeth", 1}, {"loop.rate_hz", 250}}, SweepVerdict::kRefused, "why", {}, 0}};
  const std::string csv = FormatCsv(SweepColumns(), study.rows);
  EXPECT_EQ(csv,
            "verdict,key_1,value_1,key_2,value_2,wall_s,reason\n"
            "pass,,,,,0.500,\n"
            "fail,tool.teeth,1,,,0.250,\"cut_5N: noise, much of it\"\n"
            "refused,tool.teeth,1,loop.rate_hz,250,0.000,why\n");
  const auto json = nlohmann::json::parse(FormatSweepJson(study));
  EXPECT_EQ(json["counts"]["fail"], 1);
  EXPECT_EQ(json["rows"].size(), 3U);
  EXPECT_EQ(json["rows"][1]["settings"]["tool.teeth"], 1);
  EXPECT_THAT(FormatSweepTable(study), HasSubstr("FAIL       tool.teeth = 1: cut_5N"));
}

}  // namespace
}  // namespace kerf
