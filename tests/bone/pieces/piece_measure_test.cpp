#include "bone/pieces/piece_measure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/solids.h"

namespace kerf {
namespace {

/// Two cubes of 4 mm, whose centres are 10 mm apart along x. "left" is the one at x = 5, "right" at x = -5.
PieceSet MakeTwoCubes() {
  PieceSet set;
  set.Add(test::MakeBox({.p_AB = {5, 0, 0}}, {4, 4, 4}, 0.2), "left");
  set.Add(test::MakeBox({.p_AB = {-5, 0, 0}}, {4, 4, 4}, 0.2), "right");
  return set;
}

// The points are given, not picked, so that nothing is rounded but the poses.
constexpr double kRounding_mm = 1e-9;

TEST(PieceMeasure, DistanceFollowsThePieces) {
  PieceSet set = MakeTwoCubes();
  const std::vector<PiecePoint> points{MakePiecePoint(set, {.piece = 0, .p_W_mm = {3, 0, 0}}),
                                       MakePiecePoint(set, {.piece = 1, .p_W_mm = {-3, 0, 0}})};
  EXPECT_NEAR(MeasurePieces(set, points)->value, 6, kRounding_mm);
  set.Move(0, {11, 0, 0});
  EXPECT_NEAR(MeasurePieces(set, points)->value, 17, kRounding_mm);
  EXPECT_NEAR(glm::length(MeasurePieces(set, points)->points_W[0] - Vec3(14, 0, 0)), 0, kRounding_mm);
  // A quarter turn about the cube's centre, which is now at x = 16, takes the point from x = 14 to y = -2.
  set.RotateAbout(0, {16, 0, 0}, {0, 0, 1}, 90);
  EXPECT_NEAR(MeasurePieces(set, points)->value, std::hypot(19.0, 2.0), kRounding_mm);
  // Both are moved in the same way: the distance stays.
  set.Move(0, {1, 2, 3});
  set.Move(1, {1, 2, 3});
  EXPECT_NEAR(MeasurePieces(set, points)->value, std::hypot(19.0, 2.0), kRounding_mm);
  set.ResetAll();
  EXPECT_NEAR(MeasurePieces(set, points)->value, 6, kRounding_mm);
  set.Undo();
  EXPECT_NEAR(MeasurePieces(set, points)->value, std::hypot(19.0, 2.0), kRounding_mm);
}

TEST(PieceMeasure, PointOfAMovedPieceIsWhereItWasPicked) {
  PieceSet set = MakeTwoCubes();
  set.Move(0, {0, 0, 7});
  set.RotateAbout(0, {5, 0, 7}, {1, 2, 3}, 33);
  const PiecePoint point = MakePiecePoint(set, {.piece = 0, .p_W_mm = {4, 1, 6}});
  EXPECT_NEAR(glm::length(*CalcPlace(set, point) - Vec3(4, 1, 6)), 0, kRounding_mm);
}

TEST(PieceMeasure, AngleFollowsThePieces) {
  PieceSet set = MakeTwoCubes();
  const std::vector<PiecePoint> points{MakePiecePoint(set, {.piece = 0, .p_W_mm = {3, 0, 0}}),
                                       MakePiecePoint(set, {.piece = 1, .p_W_mm = {-3, 0, 0}}),
                                       MakePiecePoint(set, {.piece = 1, .p_W_mm = {-3, 2, 0}})};
  EXPECT_NEAR(MeasurePieces(set, points)->value, 90, kRounding_mm);
  set.Move(0, {0, 6, 0});
  EXPECT_NEAR(MeasurePieces(set, points)->value, 45, kRounding_mm);
}

TEST(PieceMeasure, NeedsAllItsPieces) {
  PieceSet set = MakeTwoCubes();
  const std::vector<PiecePoint> points{MakePiecePoint(set, {.piece = 0, .p_W_mm = {3, 0, 0}}),
                                       MakePiecePoint(set, {.piece = 1, .p_W_mm = {-3, 0, 0}})};
  set.Delete(1);
  EXPECT_FALSE(MeasurePieces(set, points));
  set.Undo();
  EXPECT_TRUE(MeasurePieces(set, points));
  EXPECT_FALSE(CalcPlace(set, {.piece = "piece 7"}));
}

}  // namespace
}  // namespace kerf
