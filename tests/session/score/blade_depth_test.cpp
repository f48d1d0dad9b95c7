// The depth of a blade with a stroke, below the surface of the uncut bone.
#include <gtest/gtest.h>

#include "cut/tool/edge_down.h"
#include "session/score/columns.h"
#include "support/solids.h"

namespace kerf {
namespace {

TEST(BladeDepth, IsThatOfAStraightEdgeBelowTheSurface) {
  // The block's top is at z = 4; the edge lies along x, and its teeth point down.
  const Bone block = test::MakeBox({}, {10, 6, 8}, 0.2);
  const PhiSampler before(block);
  const Quat down = CalcEdgeDown();
  for (const double x_mm : {0.0, 12.0}) {  // in the middle, and with only the handle's end over the block
    for (const double depth_mm : {0.5, 3.0, 6.0}) {
      EXPECT_NEAR(CalcBladeDepth(before, ReciprocatingBlade{}, {down, {x_mm, 0, 4 - depth_mm}}), depth_mm, 0.05);
    }
    EXPECT_EQ(CalcBladeDepth(before, ReciprocatingBlade{}, {down, {x_mm, 0, 4.3}}), 0);
  }
}

}  // namespace
}  // namespace kerf
