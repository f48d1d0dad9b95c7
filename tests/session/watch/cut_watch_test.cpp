#include "session/watch/cut_watch.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <numbers>

#include "bone/grid/grids.h"
#include "bone/grid/set_leaf.h"
#include "kerf/surface.h"
#include "session/plan/perfect_cut.h"

namespace kerf {
namespace {

constexpr double kVoxel = 0.2;

/// A bar of 16 x 10 x 8 mm with a plane at x = 4, which separates 4 x 10 x 8 mm.
struct Bar {
  Bar() : before(std::make_shared<const Bone>(test::MakeBox({}, {16, 10, 8}, kVoxel))), now(*before) {
    plane = {.name = "end",
             .plane = {{4, 0, 0}, {1, 0, 0}},
             .margin_mm = 1,
             .width_mm = 20,
             .height_mm = 20,
             .up_W = {0, 0, 1}};
  }
  /// Cuts a kerf of 0.4 mm at x = 4 down to z.
  void CutDownTo(double z) {
    CutAway(now, now.CalcBounds(), [z](const Vec3& p) { return -std::max(std::abs(p.x - 4) - 0.2, z - p.z); });
  }
  /// Offers all leaves of the bone that were ever cut.
  void OfferAll(CutWatch& watch, const Bone& bone) const {
    std::array<float, 512> values, uncut;
    for (int x = -7; x <= 6; ++x) {
      for (int y = -5; y <= 4; ++y) {
        for (int z = -4; z <= 3; ++z) {
          GetCut(now, {x, y, z}, values);
          GetCut(*before, {x, y, z}, uncut);
          if (values == uncut) continue;
          GetCut(bone, {x, y, z}, values);
          watch.Offer({x, y, z}, values);
        }
      }
    }
    watch.WaitIdle();
  }
  std::shared_ptr<const Bone> before;
  Bone now;
  PlannedPlane plane;
};

TEST(CutWatch, ReportsThePieceThatComesFreeOnce) {
  Bar bar;
  CutWatch watch(bar.before, bar.now, {.period_s = 1e-3});
  watch.SetPlanes({bar.plane});
  watch.WaitIdle();
  EXPECT_TRUE(watch.TakeFreed().empty());
  const auto start = watch.Fetch();
  ASSERT_TRUE(start);
  EXPECT_EQ(start->piece_count, 1u);
  ASSERT_EQ(start->planes.size(), 1u);
  EXPECT_EQ(start->planes[0].name, "end");
  EXPECT_EQ(start->planes[0].state.fraction(), 0);

  EXPECT_TRUE(start->measured.empty());

  watch.SetMeasure([](const Bone& before, const Bone& now) {
    return std::vector{before.CalcVolume() - now.CalcVolume(), 1.0};
  });
  bar.CutDownTo(-2);
  bar.OfferAll(watch, bar.now);
  EXPECT_TRUE(watch.TakeFreed().empty());
  const auto part = watch.Fetch();
  ASSERT_TRUE(part);
  ASSERT_EQ(part->measured.size(), 2u);
  EXPECT_NEAR(part->measured[0], bar.before->CalcVolume() - bar.now.CalcVolume(), 1e-6);
  // Half a step of 0.25 mm along the border of the cut, 10 mm, and of the bone, 36 mm, over 80 mm^2.
  EXPECT_NEAR(part->planes[0].state.fraction(), 0.75, 0.125 * 46 / 80);

  bar.CutDownTo(-5);
  bar.OfferAll(watch, bar.now);
  const std::vector<FreedPiece> freed = watch.TakeFreed();
  ASSERT_EQ(freed.size(), 1u);
  const Pieces expected = SplitPieces(bar.now);
  ASSERT_EQ(expected.pieces.size(), 2u);
  // The same figure as in the list of pieces and in the report. The sum of the voxels would differ from it by up to
  // half a voxel at each face.
  EXPECT_EQ(freed[0].volume_mm3, expected.pieces[1].CalcVolume());
  // The box is exact for plane faces; phi is stored as float.
  EXPECT_NEAR(freed[0].volume_mm3, 3.8 * 10 * 8, 0.01 * 3.8 * 10 * 8);
  EXPECT_NEAR(freed[0].bounds_W.lower.x, 4.2, kVoxel);
  EXPECT_NEAR(freed[0].bounds_W.upper.x, 8, kVoxel);
  EXPECT_EQ(freed[0].main_region, 24);
  const auto end = watch.Fetch();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->planes[0].state.fraction(), 1);
  EXPECT_EQ(end->piece_count, 2u);

  // Nothing new: neither a report nor a piece.
  bar.OfferAll(watch, bar.now);
  EXPECT_TRUE(watch.TakeFreed().empty());
  EXPECT_EQ(watch.Fetch()->piece_count, 2u);
  EXPECT_FALSE(watch.Fetch());
}

TEST(CutWatch, ReportsThePieceAgainAfterAnUndo) {
  Bar bar;
  CutWatch watch(bar.before, bar.now, {.period_s = 1e-3});
  bar.CutDownTo(-5);
  bar.OfferAll(watch, bar.now);
  EXPECT_EQ(watch.TakeFreed().size(), 1u);
  bar.OfferAll(watch, *bar.before);
  EXPECT_TRUE(watch.TakeFreed().empty());
  EXPECT_EQ(watch.Fetch()->piece_count, 1u);
  bar.OfferAll(watch, bar.now);
  EXPECT_EQ(watch.TakeFreed().size(), 1u);
}

TEST(CutWatch, ReportsInjuriesUntilTheyAreUndone) {
  Bar bar;
  const std::vector<Mark> marks{
      {.name = "nerve", .kind = MarkKind::kNerve, .radius_mm = 0.5, .points_W = {{-6, 0, 0}, {6, 0, 0}}}};
  CutWatch watch(bar.before, bar.now, {.period_s = 1e-3});
  watch.SetMarks(marks);
  watch.WaitIdle();
  EXPECT_TRUE(watch.Fetch().value().injuries.empty());
  bar.CutDownTo(0);
  bar.OfferAll(watch, bar.now);
  std::vector<StructureResult> injuries = watch.Fetch().value().injuries;
  ASSERT_EQ(injuries.size(), 1u);
  EXPECT_EQ(injuries[0].name, "nerve");
  EXPECT_FALSE(injuries[0].is_severed);
  // Half of a tube of 0.5 mm radius over 0.4 mm; a cell at its border belongs to it or not as a whole.
  EXPECT_NEAR(injuries[0].removed_mm3, 0.4 * 0.5 * std::numbers::pi * 0.25, 0.4 * 0.5 * kVoxel * std::numbers::pi);
  bar.CutDownTo(-2);
  bar.OfferAll(watch, bar.now);
  injuries = watch.Fetch().value().injuries;
  ASSERT_EQ(injuries.size(), 1u);
  EXPECT_TRUE(injuries[0].is_severed);
  {
    // A watch that begins with a bone that was cut before, as in a project that is opened.
    CutWatch later(bar.before, bar.now, {.period_s = 1e-3});
    later.SetMarks(marks);
    later.WaitIdle();
    injuries = later.Fetch().value().injuries;
    ASSERT_EQ(injuries.size(), 1u);
    EXPECT_TRUE(injuries[0].is_severed);
  }
  bar.OfferAll(watch, *bar.before);
  EXPECT_TRUE(watch.Fetch().value().injuries.empty());
}

TEST(CutWatch, SeparatesWhatWasRemovedOutsideTheWantedCut) {
  Bar bar;
  CutWatch watch(bar.before, bar.now, {.period_s = 1e-3});
  watch.SetMarks({{.name = "nerve", .kind = MarkKind::kNerve, .radius_mm = 0.5, .points_W = {{-6, 0, 0}, {6, 0, 0}}}});
  // Two equal kerfs of 0.4 mm through the nerve, at x = 4 and at x = -2.
  for (const double x : {4.0, -2.0}) {
    CutAway(bar.now, bar.now.CalcBounds(), [x](const Vec3& p) { return 0.2 - std::abs(p.x - x); });
  }
  bar.OfferAll(watch, bar.now);
  const PlanesReport all = watch.Fetch().value();
  ASSERT_EQ(all.injuries.size(), 1u);
  EXPECT_TRUE(all.beside.empty());

  watch.SetWanted([](const Vec3& p_W) { return p_W.x > 1; });
  watch.WaitIdle();
  const PlanesReport split = watch.Fetch().value();
  ASSERT_EQ(split.injuries.size(), 1u);
  ASSERT_EQ(split.beside.size(), 1u);
  EXPECT_EQ(split.beside[0].name, "nerve");
  EXPECT_TRUE(split.injuries[0].is_severed);
  EXPECT_FALSE(split.beside[0].is_severed);  // also if the kerf that was wanted went through it
  const double whole_mm3 = all.injuries[0].removed_mm3;
  EXPECT_NEAR(split.injuries[0].removed_mm3 + split.beside[0].removed_mm3, whole_mm3, 1e-6 * whole_mm3);
  EXPECT_NEAR(split.injuries[0].removed_mm3, split.beside[0].removed_mm3, 0.01 * whole_mm3);
  EXPECT_NEAR(split.injuries[0].p_W.x, 4, kVoxel);
  EXPECT_NEAR(split.beside[0].p_W.x, -2, kVoxel);

  watch.SetWanted(nullptr);
  watch.WaitIdle();
  const PlanesReport again = watch.Fetch().value();
  ASSERT_EQ(again.injuries.size(), 1u);
  EXPECT_EQ(again.injuries[0].removed_mm3, whole_mm3);
  EXPECT_TRUE(again.beside.empty());
}

TEST(CutWatch, DoesNotReportDust) {
  Bar bar;
  CutWatch watch(bar.before, bar.now, {.period_s = 1e-3, .min_piece_mm3 = 400});  // more than 3.8 x 10 x 8 mm
  bar.CutDownTo(-5);
  bar.OfferAll(watch, bar.now);
  EXPECT_TRUE(watch.TakeFreed().empty());
}

TEST(CutWatch, EndsWhileItWorks) {
  Bar bar;
  CutWatch watch(bar.before, bar.now, {.period_s = 1e6});
  watch.SetPlanes(std::vector<PlannedPlane>(20, bar.plane));
}

}  // namespace
}  // namespace kerf
