// A block from which wanted cuts are taken out exactly.
#pragma once

#include <algorithm>
#include <vector>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "session/scene/exercise.h"

namespace kerf::test {

/// Returns the block of region 24 after exact `cuts`. The regions have voxels of the same size.
inline Bone CutExactly(const BlockParams& block, const std::vector<WantedCut>& cuts) {
  SolidField solid;
  solid.value = [&](const Vec3& p_W) {
    double distance_mm = CalcBlockDistance(block, p_W);
    for (const WantedCut& cut : cuts) distance_mm = std::max(distance_mm, -cut.CalcDistance(p_W));
    return distance_mm;
  };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3&) { return 24; };
  const Vec3 half_mm = 0.5 * block.size_mm;
  Box3 box;
  for (int i = 0; i < 8; ++i) {
    box.Include(block.X_WB.Point({(i & 1) != 0 ? half_mm.x : -half_mm.x, (i & 2) != 0 ? half_mm.y : -half_mm.y,
                                  (i & 4) != 0 ? 0 : -block.size_mm.z}));
  }
  BuildOptions options;
  options.voxel_mm = block.voxel_mm;
  options.region_voxel_mm = block.voxel_mm;
  return MakeBone(solid, box.Grown(2), options, DefaultMandibleTable());
}

}  // namespace kerf::test
