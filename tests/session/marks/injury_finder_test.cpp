#include "session/marks/injury_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "bone/grid/removed.h"
#include "jaw.h"

namespace kerf {
namespace {

using test::kVoxel_mm;
using test::MakeJaw;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A jaw that is cut, and the finder that follows it.
struct Followed {
  /// Sets the bone as it is now, and returns the names of the injured structures.
  std::vector<std::string> Become(const Bone& next) {
    finder.Change(next, FindChangedLeaves(now, next));
    now = next;
    std::vector<std::string> names;
    for (const StructureResult& s : finder.Find(now)) names.push_back(FormatMessage(NameStructure(s)));
    return names;
  }
  explicit Followed(const Bone& bone = MakeJaw()) : before(std::make_shared<const Bone>(bone)) {}
  std::shared_ptr<const Bone> before;
  Bone now = *before;
  InjuryFinder finder{before};
};

constexpr const char* kTooth = "tooth 1 from the middle, patient's left";
constexpr const char* kCanal = "canal of the nerve, patient's left";

TEST(InjuryFinder, FindsTheFirstRemovalFromATooth) {
  Followed jaw;
  EXPECT_THAT(jaw.finder.Find(jaw.now), IsEmpty());
  // Slots of 0.4 mm across the tooth of 4 mm: 0.008 mm^3, a voxel, is 5 um deep.
  EXPECT_THAT(jaw.Become(MakeJaw(5, 0.003)), IsEmpty());
  EXPECT_THAT(jaw.Become(MakeJaw(5, 0.06)), ElementsAre(kTooth));
  const StructureResult tooth = jaw.finder.Find(jaw.now).at(0);
  EXPECT_EQ(tooth.kind, MarkKind::kTooth);
  // Half a cell at each end of the slot, and at its walls the cells are not exact: corners of a slot are rounded.
  EXPECT_NEAR(tooth.removed_mm3, 0.4 * 4 * 0.06, 0.5 * 0.4 * 4 * 0.06);
  EXPECT_NEAR(glm::length(tooth.p_W - Vec3(5, 0, 0)), 0, kVoxel_mm);
  EXPECT_FALSE(tooth.is_severed);
  // A cut beside the tooth, but in the same leaves, is none.
  EXPECT_THAT(jaw.Become(MakeJaw(7.4, 4)), IsEmpty());
}

TEST(InjuryFinder, SeparatesWhatWasRemovedAtOtherPlaces) {
  Followed jaw;
  jaw.Become(MakeJaw(5, 4));
  const auto front = [](const Vec3& p_W) { return p_W.y < 0; };
  const auto back = [&](const Vec3& p_W) { return !front(p_W); };
  const StructureResult tooth = jaw.finder.Find(jaw.now).at(0);
  const StructureResult in_front = jaw.finder.FindAt(front).at(0);
  const StructureResult behind = jaw.finder.FindAt(back).at(0);
  EXPECT_NEAR(in_front.removed_mm3 + behind.removed_mm3, tooth.removed_mm3, 1e-9);
  EXPECT_NEAR(in_front.p_W.y, -1, kVoxel_mm);
  EXPECT_NEAR(behind.p_W.y, 1, kVoxel_mm);
  EXPECT_THAT(jaw.finder.FindAt([](const Vec3& p_W) { return p_W.x > 6; }), IsEmpty());
}

TEST(InjuryFinder, NamesTheTeethAndTheLesionOfASegmentation) {
  Followed jaw{test::MakeSegmentedJaw()};
  EXPECT_THAT(jaw.Become(test::MakeSegmentedJaw(7, 4)), ElementsAre("tooth 36"));
  EXPECT_THAT(jaw.Become(test::MakeSegmentedJaw(7.9, 4)), ElementsAre("tooth 36", "tooth 37"));
  EXPECT_THAT(jaw.Become(test::MakeSegmentedJaw(-8, 12)),
              ElementsAre("tooth 1 from the middle, patient's right", "lesion"));
}

TEST(InjuryFinder, ForgetsWhatIsUndone) {
  Followed jaw;
  EXPECT_THAT(jaw.Become(MakeJaw(5, 4)), ElementsAre(kTooth));
  EXPECT_THAT(jaw.Become(MakeJaw(5, 10)), ElementsAre(kCanal, kTooth));
  EXPECT_FALSE(jaw.finder.Find(jaw.now).at(0).is_severed);
  EXPECT_THAT(jaw.Become(MakeJaw(5, 16)), ElementsAre(kCanal, kTooth));
  EXPECT_TRUE(jaw.finder.Find(jaw.now).at(0).is_severed);
  EXPECT_THAT(jaw.Become(MakeJaw(5, 10)), ElementsAre(kCanal, kTooth));
  EXPECT_FALSE(jaw.finder.Find(jaw.now).at(0).is_severed);
  EXPECT_THAT(jaw.Become(MakeJaw(5, 4)), ElementsAre(kTooth));
  EXPECT_THAT(jaw.Become(*jaw.before), IsEmpty());
}

TEST(InjuryFinder, AgreesWithTheReport) {
  Followed jaw;
  const std::vector<Mark> marks{
      {.name = "vessel", .kind = MarkKind::kOther, .radius_mm = 0.5, .points_W = {{0, -8, -4}, {16, -8, -4}}},
      {.name = "far", .kind = MarkKind::kNerve, .radius_mm = 1, .points_W = {{-15, 0, -13}, {-8, 0, -13}}}};
  // Marks may come before the cut, and after it.
  jaw.finder.SetMarks({marks[1]});
  jaw.Become(MakeJaw(5, 9));
  jaw.finder.SetMarks(marks);
  EXPECT_THAT(jaw.Become(MakeJaw(5, 12)), ElementsAre(kCanal, kTooth, "vessel"));
  const StructureAssessment report = AssessStructures(*jaw.before, jaw.now, marks);
  for (const StructureResult& injury : jaw.finder.Find(jaw.now)) {
    const auto same = std::find_if(report.structures.begin(), report.structures.end(), [&](const StructureResult& s) {
      return FormatMessage(NameStructure(s)) == FormatMessage(NameStructure(injury));
    });
    ASSERT_NE(same, report.structures.end());
    EXPECT_TRUE(same->is_cut);
    EXPECT_EQ(same->is_severed, injury.is_severed);
    // The same sums in another order.
    EXPECT_NEAR(same->removed_mm3, injury.removed_mm3, 1e-9);
    EXPECT_NEAR(glm::length(same->p_W - injury.p_W), 0, 1e-9);
  }
  jaw.finder.SetMarks({});
  EXPECT_THAT(jaw.Become(jaw.now), ElementsAre(kCanal, kTooth));
}

}  // namespace
}  // namespace kerf
