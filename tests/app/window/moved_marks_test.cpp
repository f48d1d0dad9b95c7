#include "app/window/moved_marks.h"

#include <gtest/gtest.h>

#include "kerf/models.h"

namespace kerf {
namespace {

/// A bar along x that is cut in two at x = 0.
PieceSet MakeTwoPieces() {
  PieceSet pieces;
  for (const double x : {-6.0, 6.0}) {
    BlockParams half;
    half.size_mm = {10, 6, 6};
    half.X_WB.p_AB = {x, 0, 0};
    half.voxel_mm = 0.25;
    pieces.Add(MakeBlock(half), x < 0 ? "piece 1" : "piece 2");
  }
  return pieces;
}

TEST(MoveMarks, EachPartMovesWithItsPiece) {
  PieceSet pieces = MakeTwoPieces();
  const double z = pieces.CalcCentroid(0).z;
  MarkOverlay nerve{.points_W = {{-8, 0, z}, {-4, 0, z}, {4, 0, z}, {8, 0, z}}, .label = "nerve"};
  const MovedMarks before = MoveMarks(pieces, {nerve});
  ASSERT_EQ(before.marks.size(), 1u);
  EXPECT_EQ(before.marks[0], nerve);
  EXPECT_FALSE(before.left_out);
  pieces.Move(1, {0, 5, 0});
  const MovedMarks after = MoveMarks(pieces, {nerve});
  ASSERT_EQ(after.marks.size(), 2u);
  EXPECT_EQ(after.marks[0].points_W, (std::vector<Vec3>{{-8, 0, z}, {-4, 0, z}}));
  EXPECT_EQ(after.marks[1].points_W, (std::vector<Vec3>{{4, 5, z}, {8, 5, z}}));
  EXPECT_EQ(after.marks[0].label, "nerve");
  EXPECT_EQ(after.marks[1].label, "");
  EXPECT_FALSE(after.left_out);
  // What lies in no piece cannot move with one.
  nerve.points_W.push_back({30, 0, z});
  EXPECT_TRUE(MoveMarks(pieces, {nerve}).left_out);
}

}  // namespace
}  // namespace kerf
