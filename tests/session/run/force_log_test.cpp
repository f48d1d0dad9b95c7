// Tests that a log written during the loop has the same bytes and figures as one from rows in memory.
#include "session/run/force_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/core/high_pass.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "session/run/force_noise.h"
#include "session/run/run_loop.h"
#include "support/block_scene.h"
#include "support/message_of.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

const std::string kScene =
    test::kBarToml + test::StrokeToml({0, 0, 6.5}, {0, 0, 0.5}, 3, {1, 0, 0}) + "[effects.sound]\n";

using LoopLogs = test::ResultFolderTest;

TEST_F(LoopLogs, FolderAndMemoryGiveTheSameBytes) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const std::string kept = folder_ + "/kept", grown = folder_ + "/grown";
  for (const int every : {1, 7}) {
    Scene scene = ParseScene(kScene, "s.toml");
    scene.output.forces_every_ticks = every;
    LoopOptions options;
    options.virtual_time = true;
    options.seconds = 3;
    LoopSummary a = RunLoop(scene, options, {});
    WriteLoopReport(scene, a, kept);
    MakeFolder(grown);
    options.output.log = LoopLog::kFolder;
    options.output.folder = grown;
    LoopSummary b = RunLoop(scene, options, {});
    EXPECT_TRUE(b.rows.empty());
    EXPECT_TRUE(b.effects.rows.empty());
    WriteLoopReport(scene, b, grown);
    for (const char* name : {"forces.csv", "force.png", "sound.wav", "report.md"}) {
      EXPECT_EQ(ReadTextFile(kept + "/" + name), ReadTextFile(grown + "/" + name)) << name << every;
    }
    EXPECT_EQ(a.files, b.files);
    auto ja = nlohmann::json::parse(FormatLoopJson(scene, a)), jb = nlohmann::json::parse(FormatLoopJson(scene, b));
    for (auto* json : {&ja, &jb}) (*json)["ticks"].erase("wall_s");
    EXPECT_EQ(ja, jb);
    // The folder contains nothing but the results.
    for (const auto& file : fs::directory_iterator(grown)) {
      EXPECT_FALSE(file.path().filename().string().starts_with(".")) << file.path();
    }
  }
}

TEST_F(LoopLogs, NowhereKeepsNoRows) {
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = 0.5;
  options.output.log = LoopLog::kNone;
  const LoopSummary s = RunLoop(ParseScene(kScene, "s.toml"), options, {});
  EXPECT_TRUE(s.rows.empty());
  EXPECT_TRUE(s.effects.rows.empty());
  EXPECT_EQ(s.force_log, nullptr);
  EXPECT_EQ(s.effects.ticks, 500U);
  EXPECT_NE(s.force_hash, 0U);
}

TEST_F(LoopLogs, DeletedFolderIsReportedAndOtherResultsAreWritten) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  MakeFolder(folder_);
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = 0.5;
  options.output.log = LoopLog::kFolder;
  options.output.folder = folder_;
  const Scene scene = ParseScene(kScene, "s.toml");
  LoopSummary s = RunLoop(scene, options, {});
  fs::remove_all(folder_);
  EXPECT_EQ(test::MessageOf([&] { WriteLoopReport(scene, s, folder_); }),
            folder_ + "/forces.csv: can't be written: No such file or directory; also lost: the sounds");
  for (const char* name : {"report.md", "loop.json", "scene.toml", "force.png"}) {
    EXPECT_TRUE(fs::exists(folder_ + "/" + name)) << name;
  }
}

TEST(ForceNoiseTest, EqualsTheNoiseOfTheWholeArrays) {
  // The saw cuts from 1.5 to 4.2 s and from 6 s on, so the whole seconds 2, 3, 6 and 7 count.
  const double dt_s = 0.001;
  ForceNoise noise(dt_s);
  std::vector<double> axes[3];
  for (int i = 0; i < 8500; ++i) {
    const double t = dt_s * i;
    const bool cuts = (t >= 1.5 && t < 4.2) || t >= 6;
    const Vec3 f(std::sin(300 * t) * (cuts ? t : 0.1), std::cos(3 * t), 0.3 * std::sin(400 * t * t));
    noise.Take(f, cuts);
    for (int axis = 0; axis < 3; ++axis) axes[axis].push_back(f[axis]);
  }
  const auto calc = [&](std::size_t begin, std::size_t count) {
    double square = 0;
    for (const auto& axis : axes)
      square += std::pow(CalcHighPassRms(std::span(axis).subspan(begin, count), dt_s, 20), 2);
    return 1000 * std::sqrt(square);
  };
  // The sums have 8500 terms in a different order.
  EXPECT_NEAR(noise.Finish_mN(), calc(0, 8500), 1e-12 * calc(0, 8500));
  ASSERT_TRUE(noise.cutting_mN().has_value());
  EXPECT_EQ(*noise.cutting_mN(), std::max({calc(2000, 1000), calc(3000, 1000), calc(6000, 1000), calc(7000, 1000)}));
  ForceNoise none(dt_s);
  EXPECT_EQ(none.Finish_mN(), 0);
  EXPECT_FALSE(none.cutting_mN().has_value());
}

}  // namespace
}  // namespace kerf
