// Tests of setting a scene's values line by line without any other change.
#include "session/scene/edit_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kerf/error.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

constexpr const char* kText = R"(# my scene
title = "a cut"   # keep

[bone]
model = "block"

[bone.block]
size_x_mm = 12
voxel_mm = 0.2  # coarse
size_y_mm = 4

[[path.stroke]]
start_mm = [-16, 0, 10]
end_mm = [-8, 0, 10]
feed_mm_per_s = 20
disc_normal = [0, 1, 0]
)";

const std::vector<SceneEdit> kEdits = {{"bone.block", "voxel_mm", "0.125"},
                                       {"bone.block", "size_z_mm", "7"},
                                       {"simulation", "rim_samples_per_pitch", "4"},
                                       {"simulation", "substeps", "2"}};

TEST(EditScene, SetsAddsAndKeepsTheRest) {
  const std::string edited = EditScene(kText, "a.toml", kEdits, "p99 40 us");
  const Scene scene = ParseScene(edited, "a.toml");
  EXPECT_EQ(scene.bone.block.voxel_mm, 0.125);
  EXPECT_EQ(scene.bone.block.size_mm.z, 7);
  EXPECT_EQ(scene.simulation.rim_samples_per_pitch, 4);
  EXPECT_EQ(scene.simulation.substeps, 2);
  EXPECT_THAT(edited, testing::HasSubstr("# my scene\ntitle = \"a cut\"   # keep\n"));
  EXPECT_THAT(edited, testing::HasSubstr("[bone.block]\n# kerf tune: p99 40 us\nsize_z_mm = 7\nsize_x_mm = 12\n"
                                         "voxel_mm = 0.125  # coarse\nsize_y_mm = 4\n"));
}

TEST(EditScene, NoteIsPlacedAboveAllEditedLines) {
  // New keys are added to one table, and then an existing key above them is changed.
  const std::string scene =
      "[bone]\nmodel = \"block\"\n[simulation]\n# mine\nrate_hz = 1000.0\n[bone.block]\nvoxel_mm = 0.4\n"
      "[[path.stroke]]\nstart_mm = [0.0, 0.0, 30.0]\nend_mm = [0.0, 0.0, 20.0]\nfeed_mm_per_s = 5.0\n"
      "disc_normal = [0.0, 1.0, 0.0]\n";
  const std::vector<SceneEdit> edits = {{"bone.block", "voxel_mm", "0.2"},
                                        {"simulation", "rim_samples_per_pitch", "4"},
                                        {"simulation", "substeps", "2"},
                                        {"simulation", "carve_interval_ticks", "1"}};
  EXPECT_THAT(EditScene(scene, "a.toml", edits, "p99 40 us"),
              testing::HasSubstr("[simulation]\n# kerf tune: p99 40 us\nrim_samples_per_pitch = 4\nsubsteps = 2\n"
                                 "carve_interval_ticks = 1\n# mine\nrate_hz = 1000.0\n[bone.block]\nvoxel_mm = 0.2\n"));
}

TEST(EditScene, EditingTwiceEqualsOnceAndReplacesTheNote) {
  const std::string once = EditScene(kText, "a.toml", kEdits, "first");
  const std::string twice = EditScene(once, "a.toml", kEdits, "second");
  EXPECT_EQ(twice, EditScene(kText, "a.toml", kEdits, "second"));
  EXPECT_EQ(twice.find("first"), std::string::npos);
}

TEST(EditScene, InlineTablesAndDottedKeysAreEditedOrRefusedButNeverCorrupted) {
  const std::string rest = R"(
[[path.stroke]]
start_mm = [-16, 0, 10]
end_mm = [-8, 0, 10]
feed_mm_per_s = 20
disc_normal = [0, 1, 0]
)";
  const std::vector<SceneEdit> edits = {{"bone.block", "voxel_mm", "0.1"}};
  for (const std::string& head : {std::string("bone = {model = \"block\", block = {voxel_mm = 0.2}}\n"),
                                  std::string("[bone]\nmodel = \"block\"\nblock.voxel_mm = 0.2\n"),
                                  std::string("[bone]\nmodel = \"block\"\nblock = {size_x_mm = 9}\n"),
                                  std::string("[ bone ]\nmodel = \"block\"\n[ bone . block ]\nsize_x_mm = 9\n"),
                                  std::string("[bone]\r\nmodel = \"block\"\r\n[bone.block]\r\nvoxel_mm = 0.2\r\n")}) {
    const Scene before = ParseScene(head + rest, "a.toml");
    try {
      const Scene after = ParseScene(EditScene(head + rest, "a.toml", edits, ""), "a.toml");
      EXPECT_EQ(after.bone.block.voxel_mm, 0.1) << head;
      EXPECT_EQ(after.bone.block.size_mm.x, before.bone.block.size_mm.x) << head;
    } catch (const Error& error) {
      EXPECT_STREQ(
          error.what(),
          "a.toml: these values can't be set automatically; edit the file to set:\n  [bone.block] voxel_mm = 0.1");
    }
  }
}

TEST(EditScene, AValueOutOfRangeOrAnUnknownKeyIsRefused) {
  EXPECT_THROW(EditScene(kText, "a.toml", {{"bone.block", "voxel_mm", "-1"}}, ""), Error);
  EXPECT_THROW(EditScene(kText, "a.toml", {{"bone.block", "voxel_m", "1"}}, ""), Error);
  EXPECT_THROW(EditScene("no = scene", "a.toml", kEdits, ""), Error);
}

}  // namespace
}  // namespace kerf
