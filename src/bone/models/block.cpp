#include "bone/models/block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/files/memory.h"
#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kDefaultRegion = 24;

}  // namespace

void CheckBlock(const BlockParams& params, const MaterialTable& materials) {
  CheckParameters(params, "block");
  if (!IsValid(params.X_WB))
    throw Error("block: its pose contains a number that is not finite or a quaternion that is not of unit length");
  double top = 0;
  for (std::size_t i = 0; i < params.layers.size(); ++i) {
    const MaterialLayer& layer = params.layers[i];
    CheckParameters(layer, fmt::format("block: layer {}", i + 1));
    if (!materials.Contains(layer.region)) {
      throw Error(fmt::format("block: layer {} has region {}, which is not in the region table", i + 1, layer.region));
    }
    if (top >= params.size_mm.z) {
      throw Error(fmt::format("block: layer {} would begin {} mm below the top of a block {} mm high", i + 1, top,
                              params.size_mm.z));
    }
    top += layer.thickness_mm;
  }
  if (params.layers.empty() && !materials.Contains(kDefaultRegion)) {
    throw Error(fmt::format("block: the region table has no region {}; specify the layers", kDefaultRegion));
  }
}

BlockParams MakePlateParams() {
  BlockParams plate;
  plate.size_mm = {40, 30, 13.5};
  plate.layers = {{2.2, kDefaultRegion}, {9.3, kCancellousRegion}, {2.0, kDefaultRegion}};
  return plate;
}

double CalcBlockDistance(const BlockParams& params, const Vec3& p_W) {
  const Vec3 half = 0.5 * params.size_mm;
  const Vec3 q = glm::abs(params.X_WB.InversePoint(p_W) + Vec3{0, 0, half.z}) - half;
  const double outside = glm::length(glm::max(q, Vec3{0}));
  return outside + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

int CalcBlockRegion(const BlockParams& params, const Vec3& p_W) {
  if (params.layers.empty()) return kDefaultRegion;
  const double depth = -params.X_WB.InversePoint(p_W).z;
  double bottom = 0;
  for (const MaterialLayer& layer : params.layers) {
    bottom += layer.thickness_mm;
    if (depth < bottom) return layer.region;
  }
  return params.layers.back().region;
}

Bone MakeBlock(const BlockParams& params, const MaterialTable& materials, const std::function<void(double)>& progress) {
  CheckBlock(params, materials);
  SolidField solid;
  solid.value = [&params](const Vec3& p_W) { return CalcBlockDistance(params, p_W); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [&params](const Vec3& p_W) { return CalcBlockRegion(params, p_W); };
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    box.Include(params.X_WB.Point({(corner & 1 ? 0.5 : -0.5) * params.size_mm.x,
                                   (corner & 2 ? 0.5 : -0.5) * params.size_mm.y, corner & 4 ? -params.size_mm.z : 0}));
  }
  BuildOptions options;
  options.voxel_mm = params.voxel_mm;
  options.region_voxel_mm = params.voxel_mm;
  options.max_bytes = static_cast<double>(ReadAvailableBytes());
  options.progress = progress;
  Bone bone = MakeBone(solid, box.Grown(5 * params.voxel_mm), options, materials);
  bone.set_note("made_by", "kerf model block");
  bone.set_note("block_size_mm", fmt::format("{} {} {}", params.size_mm.x, params.size_mm.y, params.size_mm.z));
  const Pose& X = params.X_WB;
  bone.set_note("block_origin_mm", fmt::format("{} {} {}", X.p_AB.x, X.p_AB.y, X.p_AB.z));
  bone.set_note("block_rotation_wxyz", fmt::format("{} {} {} {}", X.R_AB.w, X.R_AB.x, X.R_AB.y, X.R_AB.z));
  for (std::size_t i = 0; i < params.layers.size(); ++i) {
    bone.set_note(fmt::format("block_layer_{}", i + 1),
                  fmt::format("{} mm of region {}", params.layers[i].thickness_mm, params.layers[i].region));
  }
  return bone;
}

}  // namespace kerf
