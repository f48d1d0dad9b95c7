// A bone and its cut as a segmentation, read back by kerf and by teem, which is independent of it.
#include "session/export/segments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"
#include "session/marks/jaw.h"
#include "support/folder.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::Folder;
using test::kVoxel_mm;
using test::MakeSegmentedJaw;
using ::testing::HasSubstr;

const Segment& Find(const Segmentation& all, const std::string& name) {
  for (const Segment& segment : all.segments) {
    if (segment.name == name) return segment;
  }
  ADD_FAILURE() << "no segment " << name;
  static const Segment kNone;
  return kNone;
}

class Segments : public ::testing::Test {
 protected:
  // A slot through the whole block, and one in tooth 36.
  void Write() {
    const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
    written_ = WriteSegments(after, &before, kVoxel_mm, path_);
    read_ = ReadSegmentation(path_);
  }
  int LabelAt(int layer, const Vec3& p_W) const {
    const Vec3 at = glm::round(read_.lattice.VoxelFromWorld(p_W));
    return read_.layers[static_cast<std::size_t>(layer)]
                       [read_.lattice.Index(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))];
  }
  bool IsIn(const std::string& name, const Vec3& p_W) const {
    const Segment& segment = Find(read_, name);
    return LabelAt(segment.layer, p_W) == segment.label;
  }

  const Folder folder_;
  const std::string path_ = folder_.file("cut.seg.nrrd");
  SegmentationWriting written_;
  Segmentation read_;
};

TEST_F(Segments, HoldTheBoneItsPiecesTheCutAndTheStructures) {
  Write();
  EXPECT_TRUE(read_.warnings.empty());
  ASSERT_EQ(read_.segments.size(), written_.segments.size());
  for (std::size_t i = 0; i < read_.segments.size(); ++i) {
    EXPECT_EQ(read_.segments[i].name, written_.segments[i].name);
    EXPECT_EQ(read_.segments[i].voxels, written_.segments[i].voxels);
  }
  // Volumes: a voxel whose centre is in the bone counts; the block's faces are planes of voxels' centres, which are
  // not.
  const double area_mm2 = 2 * (40 * 20 + 40 * 16 + 20 * 16);
  EXPECT_NEAR(Find(read_, "bone before the cut").volume_mm3, 40 * 20 * 16, 0.5 * kVoxel_mm * area_mm2);
  EXPECT_NEAR(Find(read_, "removed").volume_mm3, 0.4 * 20 * 16, kVoxel_mm * 20 * 16);
  EXPECT_NEAR(Find(read_, "tooth 37").volume_mm3, 4 * 4 * 6, 0.5 * kVoxel_mm * (2 * 16 + 4 * 24));
  EXPECT_NEAR(Find(read_, "lesion").volume_mm3, 4.0 / 3 * std::numbers::pi * 8, 3);
  EXPECT_NEAR(Find(read_, "metal").volume_mm3, 4 * 20 * 16, 0.5 * kVoxel_mm * area_mm2);
  // Places, in the patient's frame. The larger piece is on the patient's right.
  EXPECT_TRUE(IsIn("piece 1", {-10, 0, -12}));
  EXPECT_TRUE(IsIn("piece 2", {10, 0, -12}));
  EXPECT_TRUE(IsIn("removed", {6, 0, -12}));
  EXPECT_TRUE(IsIn("tooth 36", {5, 0, -3}) && IsIn("tooth 37", {9, 0, -3}));
  EXPECT_TRUE(IsIn("tooth 36", {6, 0, -3})) << "structures are those before the cut";
  EXPECT_TRUE(IsIn("metal", {18, 5, -5}));
  EXPECT_FALSE(IsIn("bone before the cut", {0, 0, 0.4}));
  // kerf's own import understands the names of the structures.
  EXPECT_EQ(FindMeaning("tooth 36")->fdi, 36);
  EXPECT_EQ(FindMeaning("canal of the nerve, patient's left")->side, JawSide::kLeft);
  EXPECT_EQ(FindMeaning("metal")->role, SegmentRole::kMetal);
}

TEST_F(Segments, OfABoneWithoutACutAreTheBoneAndItsStructures) {
  const Bone bone = MakeSegmentedJaw();
  WriteSegments(bone, nullptr, 0.4, path_);
  read_ = ReadSegmentation(path_);
  std::vector<std::string> names;
  for (const Segment& segment : read_.segments) names.push_back(segment.name);
  EXPECT_THAT(names, ::testing::ElementsAre("bone", "tooth 1 from the middle, patient's right", "tooth 36", "tooth 37",
                                            "lesion", "metal"));
  EXPECT_EQ(test::MessageOf([&] { WriteSegments(Bone(), nullptr, 0.4, path_); }),
            "there is no bone to write as a segmentation");
}

TEST_F(Segments, OfACutNeedTheBoneBeforeIt) {
  const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
  EXPECT_THAT(test::MessageOf([&] { WriteSegments(before, &after, 0.4, path_); }),
              HasSubstr("1.0 % of the bone is outside the bone before the cut; they are swapped"));
}

// Runs a command in the folder; returns whether it succeeded.
bool RunIn(const std::string& command, const Folder& folder) {
  return std::system(fmt::format("cd '{}' && {}", folder.path(), command).c_str()) == 0;
}

TEST_F(Segments, AreReadAlikeByTeem) {
  if (std::system("teem-unu about >/dev/null 2>&1") != 0) GTEST_SKIP() << "teem-apps (teem-unu) is not installed";
  Write();
  for (std::size_t layer = 0; layer < read_.layers.size(); ++layer) {
    ASSERT_TRUE(
        RunIn(fmt::format("teem-unu slice -i cut.seg.nrrd -a 0 -p {} | teem-unu save -f nrrd -e raw -o a.nrrd && "
                          "teem-unu data a.nrrd >a.raw && teem-unu head a.nrrd >a.txt",
                          layer),
              folder_));
    const std::string bytes = test::ReadBytes(folder_.file("a.raw"));
    ASSERT_EQ(bytes.size(), read_.layers[layer].size());
    std::size_t different = 0;
    for (std::size_t v = 0; v < bytes.size(); ++v) {
      different += static_cast<unsigned char>(bytes[v]) != read_.layers[layer][v] ? 1 : 0;
    }
    EXPECT_EQ(different, 0u) << layer;
    const std::string header = test::ReadBytes(folder_.file("a.txt"));
    EXPECT_THAT(header, HasSubstr("space: left-posterior-superior"));
    EXPECT_THAT(header, HasSubstr("space directions: (0.2"));
  }
}

}  // namespace
}  // namespace kerf
