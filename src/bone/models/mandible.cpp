#include "bone/models/mandible.h"

#include <fmt/format.h>

#include "base/files/memory.h"
#include "bone/material/region_table.h"
#include "kerf/error.h"

namespace kerf {

void CheckMandibleRegions(const MaterialTable& materials) {
  for (int id = 1; id <= kCanalRegion; ++id) {
    if (!materials.Contains(id)) {
      throw Error(
          fmt::format("mandible: the region table has no region {}; the mandible needs 1 to {}", id, kCanalRegion));
    }
  }
}

void DescribeMandible(const MandibleParams& params, Bone& bone) {
  bone.set_note("made_by", "kerf model mandible");
  MandibleParams described = params;
  Describe(described, [&bone](const char* key, const auto& value, Range, const char*) {
    bone.set_note(fmt::format("mandible_{}", key), fmt::format("{}", value));
  });
}

Bone MakeMandible(const MandibleParams& params, const MaterialTable& materials,
                  const std::function<void(double)>& progress) {
  CheckMandibleRegions(materials);
  const MandibleShape shape(params);
  SolidField solid;
  solid.value = [&shape](const Vec3& p_W) { return shape.Value(p_W); };
  solid.classify = [&shape](const Vec3& p_W, double radius_mm) { return shape.Classify(p_W, radius_mm); };
  solid.near = [&shape](const Vec3& centre_W, double radius_mm) {
    SolidField near;
    const MandibleParts parts = shape.FindParts(centre_W, radius_mm);
    near.value = [&shape, parts](const Vec3& p_W) { return shape.Value(p_W, parts); };
    near.classify = [&shape, parts](const Vec3& p_W, double r) { return shape.Classify(p_W, r, parts); };
    near.is_distance = false;
    return near;
  };
  solid.leaf_regions = [&shape](const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) {
    shape.SetRegions(leaf, wanted, ids);
  };
  solid.region_at_place = [&shape](const Vec3& p_W) { return shape.CortexRegionAt(p_W); };
  solid.is_distance = false;  // smooth joints and tapers distort the value
  solid.is_mirrored = true;
  BuildOptions options;
  options.voxel_mm = params.voxel_mm;
  options.region_voxel_mm = std::max(params.voxel_mm, 0.2);
  options.progress = progress;
  options.max_bytes = static_cast<double>(ReadAvailableBytes());
  Bone bone = MakeBone(solid, shape.bounds().Grown(5 * params.voxel_mm), options, materials);
  DescribeMandible(params, bone);
  return bone;
}

}  // namespace kerf
