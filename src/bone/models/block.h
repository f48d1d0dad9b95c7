// Blocks and plates with layers of material, for experiments with a known answer.
#pragma once

#include <vector>

#include "kerf/bone.h"
#include "kerf/describe.h"

namespace kerf {

/// One layer of a block; layers are listed from the top face (+z) down.
struct MaterialLayer {
  double thickness_mm = 0;
  int region = 24;
};

/// A box with edges along the axes of its frame B. The origin is at the centre of its top face, z points up (out of the
/// bone).
struct BlockParams {
  Vec3 size_mm{40, 20, 20};
  Pose X_WB;                          // pose of the block in the world
  std::vector<MaterialLayer> layers;  // empty: region 24 throughout; the last layer fills the rest
  double voxel_mm = 0.1;
};

template <typename V>
void Describe(MaterialLayer& p, V&& visit) {
  visit("thickness_mm", p.thickness_mm, Range{0.001, 1000}, "thickness of the layer; the last layer fills the rest");
  visit("region", p.region, kRegionRange, "region of the layer in the table of materials");
}

template <typename V>
void Describe(BlockParams& p, V&& visit) {
  visit("size_x_mm", p.size_mm.x, Range{0.1, 1000}, "length of the block along its x axis");
  visit("size_y_mm", p.size_mm.y, Range{0.1, 1000}, "length of the block along its y axis");
  visit("size_z_mm", p.size_mm.z, Range{0.1, 1000}, "height of the block, along its z axis");
  visit("voxel_mm", p.voxel_mm, kVoxelRange_mm, "edge of a voxel");
  visit("top_mm", p.X_WB.p_AB, kCoordinateRange_mm, "middle of the block's top face (+z), world frame");
  visit("rotation", p.X_WB.R_AB, "rotation from the block's frame to the world frame: unit quaternion [w, x, y, z]");
}

/// Returns a plate of the body of the mandible laid flat: a cortical plate of 2.2 mm, cancellous bone, and a cortical
/// plate of 2.0 mm (buccal and lingual plates at the first molar, CT of 20 dry mandibles), 13.5 mm in total.
BlockParams MakePlateParams();

/// Returns the signed distance to the block's surface, mm, exact everywhere. Tick-safe.
double CalcBlockDistance(const BlockParams& params, const Vec3& p_W);
/// Returns the region of the layer that contains the point or is nearest to it; on a border, that of the lower layer.
/// Tick-safe.
int CalcBlockRegion(const BlockParams& params, const Vec3& p_W);

/// Throws kerf::Error if a parameter is out of range, the pose is not valid, or a layer has an unknown region or lies
/// entirely below the block.
void CheckBlock(const BlockParams& params, const MaterialTable& materials);
/// Throws kerf::Error as CheckBlock() does, and if the block would be too large.
Bone MakeBlock(const BlockParams& params, const MaterialTable& materials);

}  // namespace kerf
