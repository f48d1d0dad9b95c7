#include "session/run/check_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/files/files.h"
#include "bone/material/region_table.h"
#include "cut/force/laws.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/scene/schema.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

struct CheckedBone {
  std::string text;
  double voxel_mm = 0;
  MaterialSummary material;
};

/// Opens the bone's files and checks its parameters. Throws kerf::Error if either fails.
CheckedBone CheckSceneBone(const Scene& scene) {
  MaterialTable table = DefaultMandibleTable();
  if (!scene.bone.materials.empty()) table = ParseRegionTable(ReadTextFile(scene.bone.materials), scene.bone.materials);
  MaterialSummary generated;
  generated.kind = scene.material.kind;
  switch (scene.bone.source) {
    case BoneSource::kFile: {
      MaterialSummary material;
      const Bone bone = MakeSceneBone(scene, {}, &material);
      const Vec3 size = bone.CalcBounds().size();
      return {fmt::format("{}, {:.1f} x {:.1f} x {:.1f} mm, voxels of {} mm", scene.bone.file, size.x, size.y, size.z,
                          bone.voxel_mm()),
              bone.voxel_mm(), material};
    }
    case BoneSource::kMandible: {
      const MandibleParams& mandible = scene.bone.mandible;
      const Vec3 room = MandibleShape(mandible).bounds().size();  // throws if the parameters do not fit together
      return {fmt::format("generic mandible, within {:.0f} x {:.0f} x {:.0f} mm, voxels of {} mm", room.x, room.y,
                          room.z, mandible.voxel_mm),
              mandible.voxel_mm, generated};
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate: {
      const BlockParams& block = scene.bone.block;
      CheckBlock(block, table);
      // Only generating a block shows whether it is too thin to contain a voxel.
      if (std::min({block.size_mm.x, block.size_mm.y, block.size_mm.z}) < 2 * block.voxel_mm) MakeSceneBone(scene, {});
      return {fmt::format("{} {} x {} x {} mm, {} {}, voxels of {} mm", ToString(scene.bone.source), block.size_mm.x,
                          block.size_mm.y, block.size_mm.z, block.layers.size(),
                          block.layers.size() == 1 ? "layer" : "layers", block.voxel_mm),
              block.voxel_mm, generated};
    }
  }
  return {};
}

}  // namespace

CheckedScene CheckWholeScene(const Scene& scene) {
  if (scene.simulation.mode == SceneMode::kSlab) MakeSlabPlane(scene);  // throws if the direction is not in the plane
  CheckedScene checked;
  const CheckedBone bone = CheckSceneBone(scene);
  checked.bone = bone.text;
  checked.voxel_mm = bone.voxel_mm;
  checked.material = bone.material;
  if (LacksTissue(scene.force)) MakeSceneBone(scene, {});  // throws if a tissue without forces occurs
  checked.warnings = FindWarnings(scene, bone.voxel_mm);
  if (scene.coupling.given || scene.device.given || scene.hand.given || scene.loop.given) {
    checked.loop = MakeLoopSetup(scene);
    for (const std::string& warning : FindHandWarnings(scene, *checked.loop)) checked.warnings.push_back(warning);
  }
  checked.warnings.insert(checked.warnings.end(), bone.material.warnings.begin(), bone.material.warnings.end());
  return checked;
}

}  // namespace kerf
