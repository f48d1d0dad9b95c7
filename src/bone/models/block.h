// Blocks and plates with layers of material, for experiments with a known answer.
#pragma once

#include <concepts>
#include <type_traits>
#include <vector>

#include "base/core/describe.h"
#include "kerf/bone.h"

namespace kerf {

/// One layer of a block, from the top face (+z) down.
struct MaterialLayer {
  double thickness_mm = 0;
  int region = 24;
};

/// A box with edges along the axes of its own frame B, origin at the middle of its top face, z up (out of the bone).
struct BlockParams {
  Vec3 size_mm{40, 20, 20};
  Pose X_WB;                          // where it stands
  std::vector<MaterialLayer> layers;  // empty: region 24 throughout; the last one fills what is left
  double voxel_mm = 0.1;
};

template <typename Params, typename Visitor>
requires std::same_as<std::remove_const_t<Params>, BlockParams>
void Describe(Params& p, Visitor&& visit) {
  visit("size_x_mm", p.size_mm.x, Range{0.1, 1000}, "length of the block along its x axis");
  visit("size_y_mm", p.size_mm.y, Range{0.1, 1000}, "length of the block along its y axis");
  visit("size_z_mm", p.size_mm.z, Range{0.1, 1000}, "height of the block, along its z axis");
  visit("voxel_mm", p.voxel_mm, Range{0.02, 4}, "edge of a voxel");
}

/// A plate of the body of the mandible laid flat: a cortical plate of 2.2 mm, cancellous bone, and a cortical plate
/// of 2.0 mm (buccal and lingual plates at the first molar, CT of 20 dry mandibles), 13.5 mm in all.
BlockParams MakePlateParams();

/// Signed distance to the block's surface, mm, exact everywhere. Tick-safe.
double CalcBlockDistance(const BlockParams& params, const Vec3& p_W);
/// The layer that a point lies in or nearest to; on a border the lower one. Tick-safe.
int CalcBlockRegion(const BlockParams& params, const Vec3& p_W);

/// Throws Error when a size is out of its range or a layer is not positive, the pose is not valid, or a layer names an
/// unknown region or lies wholly below the block.
void CheckBlock(const BlockParams& params, const MaterialTable& materials);
/// Throws Error as CheckBlock() does, and when the block would be too large.
Bone MakeBlock(const BlockParams& params, const MaterialTable& materials);

}  // namespace kerf
