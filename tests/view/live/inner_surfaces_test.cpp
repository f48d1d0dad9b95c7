// Tests of nerve canal and teeth as surfaces: they are closed, and as large as their regions.
#include "view/live/inner_surfaces.h"

#include <gtest/gtest.h>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "support/chunks.h"

namespace kerf {
namespace {

TEST(InnerSurfaces, ACanalsSlabKeepsItsSizeAndIsClosed) {
  constexpr int kCanalRegion = 34;
  BlockParams params;
  params.size_mm = {16, 10, 10};
  params.layers = {{3, 24}, {4, kCanalRegion}, {3, 24}};
  params.voxel_mm = 0.25;
  const Bone bone = MakeBlock(params, DefaultMandibleTable());
  const InnerSurfaces inner = MakeInnerSurfaces(bone);
  ASSERT_GT(inner.canal_W.triangles.size(), 1000u);
  EXPECT_TRUE(inner.teeth_W.triangles.empty());
  EXPECT_EQ(test::CountUnpaired(inner.canal_W), 0u);
  Box3 box;
  for (const Vec3& p : inner.canal_W.points) box.Include(p);
  // The box is accurate to a voxel in each direction; the regions reach slightly beyond the bone's sides.
  EXPECT_NEAR(box.lower.z, -7, 0.25);
  EXPECT_NEAR(box.upper.z, -3, 0.25);
  EXPECT_GE(box.upper.x, 8 - 0.25);
  const Vec3 size = box.size();
  EXPECT_NEAR(CalcEnclosedVolume(inner.canal_W), size.x * size.y * size.z, 0.05 * size.x * size.y * size.z);
}

TEST(InnerSurfaces, AMandibleHasTeethAndACanalOnEachSide) {
  MandibleParams params;
  params.voxel_mm = 0.8;
  const InnerSurfaces inner = MakeInnerSurfaces(MakeMandible(params, DefaultMandibleTable()));
  for (const TriangleMesh* mesh : {&inner.canal_W, &inner.teeth_W}) {
    Box3 box;
    for (const Vec3& p : mesh->points) box.Include(p);
    EXPECT_LT(box.lower.x, -20);
    EXPECT_GT(box.upper.x, 20);
    EXPECT_NEAR(box.lower.x + box.upper.x, 0, 1.6);  // mirror-symmetric, to a voxel at each end
  }
}

}  // namespace
}  // namespace kerf
