// Tests of a scene in slab mode from beginning to end.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "bone/mesh/meshfile.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "session/run/make_bone.h"
#include "session/run/run_slab_scene.h"
#include "session/scene/warnings.h"
#include "support/block_scene.h"
#include "support/far_apart.h"
#include "support/message_of.h"
#include "support/result_folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// A block of 8 x 4 x 6 mm with two layers, through which a slice is pushed straight down and out.
const std::string kSlabRunScene = test::BlockToml({8, 4, 6}, 0.1) + test::LayerToml(2.5, 24) + test::LayerToml(3.5, 6) +
                                  test::StrokeToml({0, 0, 11.5}, {0, 0, 3}, 10, {0, 1, 0}) +
                                  "[simulation]\nmode = \"slab\"\n[slab]\ndirection = [0.0, 0.0, -2.0]\n";

using SlabRunTest = test::ResultFolderTest;

TEST_F(SlabRunTest, CutsTheBlockIntoThreePartsWithConsistentFiles) {
  const Scene scene = ParseScene(kSlabRunScene + "[output]\npictures = false\n", "scene.toml");
  const SlabSummary summary = RunSlabScene(scene, folder_, {});
  ASSERT_EQ(summary.parts.size(), 3u);
  const double whole = MakeSceneBone(scene, {}).CalcVolume();
  double sum = 0;
  for (const SlabPartSummary& part : summary.parts) {
    const TriangleMesh mesh = ReadMesh(folder_ + "/" + part.name + ".stl");
    EXPECT_EQ(CountOpenEdges(mesh), 0u) << part.name;
    // The surface rounds edges differently from the cells, by less than h^2 / 2 along 56 mm of edges.
    EXPECT_NEAR(CalcEnclosedVolume(mesh), part.volume_mm3, 0.01 * part.volume_mm3 + 0.3) << part.name;
    EXPECT_NEAR(ReadBone(folder_ + "/" + part.name + ".vdb").CalcVolume(), part.volume_mm3, 1e-9 * whole);
    sum += part.volume_mm3;
  }
  EXPECT_NEAR(sum, whole, 1e-3 * whole);
  EXPECT_NEAR(summary.parts[1].volume_mm3, 8 * 6 * 0.25, 0.02 * 12);
  EXPECT_NEAR(summary.profile.slice_mm3, 8 * 6 * 0.25, 0.03 * 12);

  EXPECT_TRUE(summary.end.free);
  EXPECT_EQ(summary.ticks, 850u);
  EXPECT_EQ(summary.ticks_with_status, 0u);
  // The blade's edge moves from 0.5 mm above the block to 2 mm below it at 10 mm/s.
  EXPECT_NEAR(summary.free_at_s.value_or(0), 0.65, 0.02);
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"));
  EXPECT_EQ(json["mode"], "slab");
  EXPECT_EQ(json["slab"]["layers"][0]["region"], 24);
  EXPECT_EQ(json["energy_mJ"]["cutting"], summary.end.cutting_mJ);
  for (const std::string& file : summary.files) EXPECT_TRUE(fs::exists(folder_ + "/" + file)) << file;
  // The work of the log's forces is the hand's, except for the first tick, which has no preceding pose. In that tick
  // the hand accelerates 1 g to 10 mm/s, which is 1e-4 mJ.
  EXPECT_NEAR(summary.force.work_Nmm, summary.end.hand_work_mJ, 2e-4);
  EXPECT_NEAR(summary.end.hand_work_mJ, summary.end.cutting_mJ, 0.05 * summary.end.hand_work_mJ);
}

TEST_F(SlabRunTest, ReducedPartsAreSmallerAndWithinTheStatedError) {
  const Scene scene = ParseScene(kSlabRunScene + "[output]\npictures = false\nbone = false\n", "scene.toml");
  const SlabSummary reduced = RunSlabScene(scene, folder_ + "/reduced", {});
  const SlabSummary full = RunSlabScene(scene, folder_ + "/full", {}, {}, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string file = "/" + reduced.parts[i].file;
    const TriangleMesh small = ReadMesh(folder_ + "/reduced" + file);
    const TriangleMesh large = ReadMesh(folder_ + "/full" + file);
    EXPECT_EQ(small.triangles.size(), reduced.parts[i].triangles);
    EXPECT_EQ(large.triangles.size(), full.parts[i].triangles);
    EXPECT_LT(small.triangles.size(), large.triangles.size() / 2) << file;
    EXPECT_EQ(CountOpenEdges(small), 0u) << file;
    EXPECT_LE(test::CalcLargestDistance(large, small, 0.05), 0.02 + 1e-5) << file;
    EXPECT_LE(test::CalcLargestDistance(small, large, 0.05), 0.02 + 1e-5) << file;
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/reduced/summary.json"));
  EXPECT_EQ(json["surface_error_mm"], 0.02);
  EXPECT_EQ(json["parts"][1]["triangles"], reduced.parts[1].triangles);
  EXPECT_EQ(json["warnings"], reduced.warnings);
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/full/summary.json"))["surface_error_mm"], 0);
}

TEST_F(SlabRunTest, FollowsThePapersTable2OnRequest) {
  const Scene scene = ParseScene(kSlabRunScene + "depth_by = \"paper_table_2\"\n", "scene.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const SlabProfile profile = MakeSlabProfile(scene, bone);
  ASSERT_EQ(profile.layers.size(), 4u);
  EXPECT_EQ(profile.end_mm, 32.5);
  EXPECT_NEAR(profile.entry_mm, 0, 0.03);
  const SlabRun run = RunSlab(scene, profile, {});
  EXPECT_FALSE(run.states.back().free);
  // At a depth of 8 mm in the second band, five teeth cut: 125 F_1 of region 21, 0.46107 / 8 N, printed to 5 digits.
  EXPECT_EQ(run.ticks.back().out.main_region, 21);
  EXPECT_NEAR(run.ticks.back().out.thrust_sum_N, std::pow(run.ticks.back().out.engaged_teeth, 3) * 0.46107 / 8, 1e-3);
}

TEST_F(SlabRunTest, RefusesDirectionOutOfTheDiscsPlaneAndWarnsOfPathAcrossIt) {
  std::string text = kSlabRunScene;
  text.replace(text.find("[0.0, 0.0, -2.0]"), 16, "[0.0, 1.0, -1.0]");
  const Scene skew = ParseScene(text, "scene.toml");
  EXPECT_EQ(test::MessageOf([&] { MakeSlabPlane(skew); }),
            "[slab] direction = [0, 1, -1] lies 45.0 degrees out of the disc's plane at the start of the path, whose "
            "normal is [0, 1, 0]; the slice can only slide in that plane");
  EXPECT_THROW(RunSlabScene(skew, folder_, {}), Error);
  EXPECT_FALSE(fs::exists(folder_));

  text = kSlabRunScene;
  text.replace(text.find("[0.0, 0.0, -2.0]"), 16, "[-1.0, 0.0, 0.0]");
  const std::vector<std::string> warnings = FindWarnings(ParseScene(text, "scene.toml"), 0.1);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("8.5 mm across it"), std::string::npos) << warnings[0];
  EXPECT_TRUE(FindWarnings(ParseScene(kSlabRunScene, "scene.toml"), 0.1).empty());
  const auto of_law = FindWarnings(ParseScene(kSlabRunScene + "[force]\nlaw = \"edge_plus_chip\"\n", "s.toml"), 0.1);
  ASSERT_EQ(of_law.size(), 1u);
  EXPECT_EQ(of_law[0],
            "[force] law = \"edge_plus_chip\" is not used in slab mode, whose law is \"as_computed\" of [slab]");
  const auto of_effects =
      FindWarnings(ParseScene(kSlabRunScene + "[effects.guide]\n[effects.tangential_force]\n", "s.toml"), 0.1);
  ASSERT_EQ(of_effects.size(), 1u);
  EXPECT_EQ(of_effects[0], "slab mode simulates no effects; it ignores [effects]: tangential_force, guide");
}

TEST_F(SlabRunTest, RefusesAPathThatLeavesTheSlice) {
  const auto message = [](const std::string& stroke) {
    std::string text = kSlabRunScene;
    text.insert(text.find("[simulation]"), "[[path.stroke]]\nfeed_mm_per_s = 10\n" + stroke);
    const Scene scene = ParseScene(text, "scene.toml");
    return test::MessageOf([&] { RunSlab(scene, MakeSlabProfile(scene, MakeSceneBone(scene, {})), {}); });
  };
  EXPECT_EQ(message("start_mm = [0.5, 0.1, 13]\nend_mm = [0.5, 0.1, 4]\ndisc_normal = [0, 1, 0.01]\n"), "");
  EXPECT_EQ(
      message("start_mm = [300, 100, 12]\nend_mm = [300, 100, 4]\ndisc_normal = [0, 1, 0]\n"),
      "at the start of stroke 2 the disc is 100.0 mm from the plane of the slab and rotated 0.0 degrees out of it; "
      "slab mode has one slice, in the disc's plane where the path starts");
  EXPECT_EQ(
      message("start_mm = [0, 0, 12]\nend_mm = [0, 0, 4]\ndisc_normal = [0, 0, 1]\n"),
      "at the start of stroke 2 the disc is 0.0 mm from the plane of the slab and rotated 90.0 degrees out of it; "
      "slab mode has one slice, in the disc's plane where the path starts");
  EXPECT_EQ(message("start_mm = [12, 0, 12]\nend_mm = [12, 0, 4]\ndisc_normal = [0, 1, 0]\n"),
            "at the start of stroke 2 the disc is 12.0 mm beside the line along which the slice slides, more than its "
            "radius; slab mode has one slice, in front of the disc where the path starts");
  EXPECT_EQ(message("start_mm = [0, 0, -1]\nend_mm = [0, 0, -2]\ndisc_normal = [0, 1, 0]\n"),
            "stroke 2 sets the blade down 12.00 mm deep, past the slice, which ends at 6.00 mm");
}

TEST_F(SlabRunTest, ReportsABladeSetDownInsideTheBone) {
  std::string text = kSlabRunScene;
  text.replace(text.find("11.5]"), 5, "7.0]");
  const std::string quiet = "[output]\npictures = false\npieces = false\nbone = false\n";
  EXPECT_TRUE(RunSlabScene(ParseScene(text + quiet, "scene.toml"), folder_, {}).starts_in_bone);
  EXPECT_FALSE(RunSlabScene(ParseScene(kSlabRunScene + quiet, "scene.toml"), folder_, {}).starts_in_bone);
}

TEST_F(SlabRunTest, TheTicksNeedKilobytesNotTheBone) {
  const Scene scene = ParseScene(kSlabRunScene, "scene.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const SlabRun run = RunSlab(scene, MakeSlabProfile(scene, bone), {});
  EXPECT_LT(run.memory_bytes, 20'000u);
  EXPECT_GT(bone.CalcMemoryBytes(), 100 * run.memory_bytes);
}

}  // namespace
}  // namespace kerf
