#include "session/run/check_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/files/files.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
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

/// Throws kerf::Error if no point of a wanted cut, in the middle of its width, is in the bone. `distance` returns the
/// distance of a point from the bone, negative inside; it need be right only within a voxel of the surface.
template <typename Distance>
void CheckWantedCutsMeetBone(const Scene& scene, const Distance& distance) {
  if (!scene.exercise.given) return;
  const std::vector<WantedCut> cuts = MakeWantedCuts(scene.exercise, MakeTool(scene));
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const WantedCut& cut = cuts[i];
    const auto count = [](double mm) { return std::clamp(static_cast<int>(std::ceil(mm / 0.2)), 1, 250); };
    const int steps = count(cut.length_mm);
    const int steps_down = count(cut.depth_mm);
    const double step_mm = std::hypot(cut.length_mm / steps, cut.depth_mm / steps_down);
    bool meets = false;
    for (int k = 0; k <= steps && !meets; ++k) {
      for (int j = 0; j <= steps_down && !meets; ++j) {
        const Vec3 p_W = cut.ToWorld({k * cut.length_mm / steps, j * cut.depth_mm / steps_down, 0});
        // No point between two of them is further from both than half of their distance.
        meets = distance(p_W) <= 0.5 * step_mm;
      }
    }
    if (meets) continue;
    const bool hole = cut.length_mm == 0;
    throw Error(fmt::format("{}: the {} lies beside the bone: no point of it, {}, is in bone",
                            i == 0 ? scene.exercise.place : scene.exercise.further[i - 1].place,
                            hole ? "hole" : "wanted cut",
                            hole ? "from start_mm along into to depth_mm"
                                 : "from the line between start_mm and end_mm along into to depth_mm"));
  }
}

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
      CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return bone.SignedDistance(p_W); });
      const Vec3 size = bone.CalcBounds().size();
      return {fmt::format("{}, {:.1f} x {:.1f} x {:.1f} mm, voxels of {} mm", scene.bone.file, size.x, size.y, size.z,
                          bone.voxel_mm()),
              bone.voxel_mm(), material};
    }
    case BoneSource::kMandible: {
      const MandibleParams& mandible = scene.bone.mandible;
      const MandibleShape shape(mandible);  // throws if the parameters do not fit together
      CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return shape.Value(p_W); });
      const Vec3 room = shape.bounds().size();
      return {fmt::format("generic mandible, within {:.0f} x {:.0f} x {:.0f} mm, voxels of {} mm", room.x, room.y,
                          room.z, mandible.voxel_mm),
              mandible.voxel_mm, generated};
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate: {
      const BlockParams& block = scene.bone.block;
      CheckBlock(block, table);
      CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return CalcBlockDistance(block, p_W); });
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
