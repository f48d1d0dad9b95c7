#include "session/marks/structures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "jaw.h"

namespace kerf {
namespace {

using test::kVoxel_mm;
using test::MakeJaw;

// Half an edge of a voxel of either grid, along a diagonal.
constexpr double kPlaceError_mm = kVoxel_mm * std::numbers::sqrt3;

const StructureResult& Find(const StructureAssessment& all, const std::string& name) {
  for (const StructureResult& s : all.structures) {
    if (FormatMessage(NameStructure(s)) == name) return s;
  }
  ADD_FAILURE() << "no structure " << name;
  static const StructureResult kNone;
  return kNone;
}

TEST(Structures, AreCutOrSparedWithDistanceAndPlace) {
  const Bone before = MakeJaw();
  // The slot passes between the left teeth, 1.3 mm (1.5 mm minus half of the slot) beside the first, and ends 0.8 mm
  // above the canal.
  const StructureAssessment out = AssessStructures(before, MakeJaw(8.5, 8), {});
  EXPECT_TRUE(out.canal_known);
  EXPECT_TRUE(out.teeth_known);
  ASSERT_EQ(out.structures.size(), 5u);
  const StructureResult& canal = Find(out, "canal of the nerve, patient's left");
  EXPECT_FALSE(canal.is_cut);
  EXPECT_NEAR(canal.distance_mm.value(), 0.8, kPlaceError_mm);
  EXPECT_NEAR(glm::length(canal.p_W - Vec3(8.5, 0, -8.8)), 0, 1.0);  // the canal's top is flat to a voxel
  EXPECT_NEAR(canal.size_mm3, std::numbers::pi * 1.44 * 18, 4);
  const StructureResult& first = Find(out, "tooth 1 from the middle, patient's left");
  EXPECT_NEAR(first.distance_mm.value(), 1.3, kPlaceError_mm);
  EXPECT_NEAR(first.p_W.x, 7, kVoxel_mm);
  EXPECT_EQ(first.part, ToothPart::kRoot);
  const StructureResult& second = Find(out, "tooth 2 from the middle, patient's left");
  EXPECT_NEAR(second.distance_mm.value(), 1.3, kPlaceError_mm);
  EXPECT_NEAR(second.size_mm3, 4 * 4 * 6, 0.5 * kVoxel_mm * (2 * 16 + 4 * 24));  // half a voxel at each face
  const StructureResult& right = Find(out, "tooth 1 from the middle, patient's right");
  EXPECT_NEAR(right.distance_mm.value(), 14.3, kPlaceError_mm);
  EXPECT_NEAR(Find(out, "canal of the nerve, patient's right").distance_mm.value(), std::hypot(8.3 + 2, 0.8),
              kPlaceError_mm);
  for (std::size_t i = 1; i < out.structures.size(); ++i) {
    EXPECT_LE(*out.structures[i - 1].distance_mm, *out.structures[i].distance_mm);
  }
}

TEST(Structures, LoseTheVolumeOfTheKerf) {
  const Bone before = MakeJaw();
  const StructureAssessment out = AssessStructures(before, MakeJaw(5, 16), {});
  const StructureResult& tooth = Find(out, "tooth 1 from the middle, patient's left");
  EXPECT_TRUE(tooth.is_cut);
  EXPECT_EQ(tooth.distance_mm, 0);
  // 0.4 x 4 x 6 mm; a cell at the border belongs to the tooth or not as a whole, half a cell on each side.
  EXPECT_NEAR(tooth.removed_mm3, 9.6, 0.4 * 0.5 * kVoxel_mm * (6 + 6 + 4 + 4) + 1e-9);
  EXPECT_NEAR(glm::length(tooth.p_W - Vec3(5, 0, -3)), 0, kVoxel_mm);
  const StructureResult& canal = Find(out, "canal of the nerve, patient's left");
  EXPECT_TRUE(canal.is_cut);
  EXPECT_NEAR(canal.removed_mm3, 0.4 * std::numbers::pi * 1.44, 0.4 * 0.5 * kVoxel_mm * 2 * std::numbers::pi * 1.2);
  EXPECT_TRUE(out.structures[0].is_cut && out.structures[1].is_cut && !out.structures[2].is_cut);
}

TEST(Structures, AreSeveredIfTheirWholeCrossSectionIsCut) {
  const Bone before = MakeJaw();
  // The canal reaches from z = -8.8 to -11.2; the tube of the mark from -12.5 to -13.5.
  const std::vector<Mark> marks{
      {.name = "nerve", .kind = MarkKind::kNerve, .radius_mm = 0.5, .points_W = {{-15, 0, -13}, {15, 0, -13}}}};
  const auto assess = [&](double slot_mm) { return AssessStructures(before, MakeJaw(8.5, slot_mm), marks); };
  constexpr const char* left_canal = "canal of the nerve, patient's left";
  // The last row of voxels has its centres up to a voxel before the far side, and must be bone there.
  for (const double slot_mm : {9.0, 10.0, 11.2 - 2 * kVoxel_mm}) {
    const StructureAssessment out = assess(slot_mm);
    EXPECT_TRUE(Find(out, left_canal).is_cut) << slot_mm;
    EXPECT_FALSE(Find(out, left_canal).is_severed) << slot_mm;
    EXPECT_FALSE(Find(out, "nerve").is_cut) << slot_mm;
  }
  StructureAssessment out = assess(11.2 + kVoxel_mm);
  EXPECT_TRUE(Find(out, left_canal).is_severed);
  EXPECT_FALSE(Find(out, "canal of the nerve, patient's right").is_severed);
  EXPECT_FALSE(Find(assess(13), "nerve").is_severed);
  out = assess(13.5 + kVoxel_mm);
  EXPECT_TRUE(Find(out, "nerve").is_severed);
  // A slot along a tube takes one side of it over its whole length, but not its cross-section.
  out = AssessStructures(
      before, MakeJaw(8.5, 8),
      {{.name = "beside", .kind = MarkKind::kNerve, .radius_mm = 0.5, .points_W = {{8.9, -8, -6}, {8.9, 8, -6}}}});
  EXPECT_TRUE(Find(out, "beside").is_cut);
  EXPECT_FALSE(Find(out, "beside").is_severed);
}

TEST(Structures, OfASegmentationKeepTheirNames) {
  // The slot at x = 7 is in tooth 36, 0.8 mm beside tooth 37, which touches it.
  const StructureAssessment out = AssessStructures(test::MakeSegmentedJaw(), test::MakeSegmentedJaw(7, 4), {});
  std::vector<std::string> names;
  for (const StructureResult& s : out.structures) names.push_back(FormatMessage(NameStructure(s)));
  EXPECT_THAT(names,
              ::testing::ElementsAre("tooth 36", "tooth 37", "tooth 1 from the middle, patient's right", "lesion"));
  const StructureResult& cut = Find(out, "tooth 36");
  EXPECT_TRUE(cut.is_cut);
  EXPECT_NEAR(cut.removed_mm3, 0.4 * 4 * 4, 0.4 * 0.5 * kVoxel_mm * (4 + 4 + 4));
  const StructureResult& beside = Find(out, "tooth 37");
  EXPECT_FALSE(beside.is_cut);
  EXPECT_NEAR(beside.distance_mm.value(), 0.8, kPlaceError_mm);
  EXPECT_NEAR(beside.size_mm3, 4 * 4 * 6, 0.5 * kVoxel_mm * (2 * 16 + 4 * 24));
  EXPECT_FALSE(Find(out, "tooth 1 from the middle, patient's right").is_cut);
  // From the slot's edge at (6.8, 0, -4) to the ball of 2 mm at (-8, 0, -10).
  const StructureResult& lesion = Find(out, "lesion");
  EXPECT_FALSE(lesion.is_cut);
  EXPECT_NEAR(lesion.distance_mm.value(), std::hypot(14.8, 6) - 2, kPlaceError_mm);
  // A lesion that is cut has no margin.
  const StructureAssessment through = AssessStructures(test::MakeSegmentedJaw(), test::MakeSegmentedJaw(-8, 9), {});
  EXPECT_TRUE(Find(through, "lesion").is_cut);
  EXPECT_EQ(Find(through, "lesion").distance_mm, 0);
}

// A tooth of a row has no number, and the row hides how many teeth are before the next one.
TEST(Structures, TeethThatTouchAreARowWithoutANumber) {
  const StructureAssessment out = AssessStructures(test::MakeJawWithRow(), test::MakeJawWithRow(10, 4), {});
  std::vector<std::string> names;
  for (const StructureResult& s : out.structures) names.push_back(FormatMessage(NameStructure(s)));
  EXPECT_THAT(names,
              ::testing::ElementsAre("row of touching teeth, patient's left", "tooth behind a row, patient's left",
                                     "tooth 1 from the middle, patient's right"));
  EXPECT_TRUE(out.structures.front().is_cut);
}

TEST(Structures, IncludeMarks) {
  const Bone before = MakeJaw();
  const Bone after = MakeJaw(8.5, 8);
  const std::vector<Mark> marks{
      {.name = "lingual nerve", .kind = MarkKind::kNerve, .radius_mm = 1, .points_W = {{-15, 0, -13}, {15, 0, -13}}},
      {.name = "vessel", .kind = MarkKind::kOther, .radius_mm = 0.5, .points_W = {{0, -8, -4}, {16, -8, -4}}},
      {.name = "not placed"}};
  const StructureAssessment out = AssessStructures(before, after, marks);
  ASSERT_EQ(out.structures.size(), 7u);
  const StructureResult& nerve = Find(out, "lingual nerve");
  EXPECT_TRUE(nerve.is_mark);
  EXPECT_EQ(nerve.side, BodySide::kBoth);
  EXPECT_NEAR(nerve.distance_mm.value(), 4, kPlaceError_mm);  // from z = -8 to the tube's top at -12
  EXPECT_NEAR(nerve.p_W.x, 8.5, 0.2 + kPlaceError_mm);
  const StructureResult& vessel = Find(out, "vessel");
  EXPECT_TRUE(vessel.is_cut);
  EXPECT_EQ(vessel.side, BodySide::kLeft);
  // The kerf of 0.4 mm through a tube of 0.5 mm radius; a cell belongs to it as a whole.
  EXPECT_NEAR(vessel.removed_mm3, 0.4 * std::numbers::pi * 0.25, 0.4 * 0.5 * kVoxel_mm * std::numbers::pi);
}

TEST(Structures, SayWhatIsNotKnown) {
  SolidField solid;
  solid.value = [](const Vec3& p) { return glm::length(p) - 5; };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3&) { return 32; };
  BuildOptions options;
  options.voxel_mm = 0.4;
  const Bone plain = MakeBone(solid, Box3{Vec3(-7), Vec3(7)}, options, DefaultMandibleTable());
  const StructureAssessment out = AssessStructures(plain, plain, {});
  EXPECT_FALSE(out.canal_known);
  EXPECT_FALSE(out.teeth_known);
  EXPECT_TRUE(out.structures.empty());
  // A mark makes it known. Without a cut, there is no distance.
  const StructureAssessment marked =
      AssessStructures(plain, plain, {{.name = "n", .kind = MarkKind::kNerve, .points_W = {{0, 0, 0}}}});
  EXPECT_TRUE(marked.canal_known);
  EXPECT_FALSE(marked.teeth_known);
  EXPECT_FALSE(marked.structures.at(0).distance_mm);
  EXPECT_FALSE(marked.structures.at(0).is_cut);
}

TEST(Structures, DescribePlaces) {
  EXPECT_EQ(FormatMessage(DescribePlace({25.14, -3.2, -8.93})), "25.1 mm left, 3.2 mm front, 8.9 mm down");
  EXPECT_EQ(FormatMessage(DescribePlace({-25.14, 3.2, 8.93})), "25.1 mm right, 3.2 mm back, 8.9 mm up");
}

}  // namespace
}  // namespace kerf
