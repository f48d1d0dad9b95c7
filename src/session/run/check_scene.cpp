#include "session/run/check_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

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
  std::vector<std::string> warnings;  // about the wanted cuts
};

/// Least fraction of a wanted cut, in the middle of its width, that is expected in bone.
constexpr double kMinInBone = 0.1;
/// Height of bone above the line of a wanted cut from which the line counts as inside the bone. A straight line on a
/// curved surface has a little bone above it.
constexpr double kMaxRise_mm = 2;

/// Where a wanted cut lies, in the middle of its width.
struct CutInBone {
  bool meets = false;   // some point of it is in bone
  double fraction = 0;  // of it in bone
  double rise_mm = 0;   // greatest height of the bone above its line, or above the place of a hole
};

/// `distance`: as below.
template <typename Distance>
CutInBone FindCutInBone(const WantedCut& cut, const Distance& distance) {
  constexpr double kStep_mm = 0.2;
  constexpr double kMaxSearch_mm = 50;
  constexpr double kOnSurface_mm = 1e-6;
  const auto count = [](double mm) { return std::clamp(static_cast<int>(std::ceil(mm / kStep_mm)), 1, 250); };
  const int steps = count(cut.length_mm);
  const int steps_down = count(cut.depth_mm);
  const double along_mm = cut.length_mm / steps;
  const double down_mm = cut.depth_mm / steps_down;
  CutInBone found;
  for (int k = 0; k <= steps && !found.meets; ++k) {
    for (int j = 0; j <= steps_down && !found.meets; ++j) {
      // No point between two of them is further from both than half of their distance.
      found.meets = distance(cut.ToWorld({k * along_mm, j * down_mm, 0})) <= 0.5 * std::hypot(along_mm, down_mm);
    }
  }
  if (!found.meets) return found;
  int in_bone = 0;
  for (int k = 0; k < steps; ++k) {
    for (int j = 0; j < steps_down; ++j) {
      in_bone += distance(cut.ToWorld({(k + 0.5) * along_mm, (j + 0.5) * down_mm, 0})) <= 0 ? 1 : 0;
    }
  }
  found.fraction = static_cast<double>(in_bone) / (steps * steps_down);
  for (int k = 0; k <= steps; ++k) {
    double up_mm = 0;
    while (up_mm < kMaxSearch_mm && distance(cut.ToWorld({k * along_mm, -up_mm, 0})) < -kOnSurface_mm)
      up_mm += kStep_mm;
    found.rise_mm = std::max(found.rise_mm, up_mm);
  }
  return found;
}

/// Throws kerf::Error if no point of a wanted cut, in the middle of its width, is in the bone. Returns warnings about
/// cuts of which little is in the bone, or which begin inside it. `distance` returns the distance of a point from the
/// bone, negative inside; it need be right only within a voxel of the surface.
template <typename Distance>
std::vector<std::string> CheckWantedCutsMeetBone(const Scene& scene, const Distance& distance) {
  std::vector<std::string> warnings;
  if (!scene.exercise.given) return warnings;
  const std::vector<WantedCut> cuts = MakeWantedCuts(scene.exercise, MakeTool(scene));
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const WantedCut& cut = cuts[i];
    const std::string& place = i == 0 ? scene.exercise.place : scene.exercise.further[i - 1].place;
    const bool hole = cut.length_mm == 0;
    const char* const what = hole ? "hole" : "wanted cut";
    const CutInBone found = FindCutInBone(cut, distance);
    if (!found.meets) {
      throw Error(fmt::format("{}: the {} lies beside the bone: no point of it, {}, is in bone", place, what,
                              hole ? "from start_mm along into to depth_mm"
                                   : "from the line between start_mm and end_mm along into to depth_mm"));
    }
    if (found.fraction < kMinInBone) {
      warnings.push_back(fmt::format("{} {}: only {:.0f} % of it is in bone; into must point into the bone", what,
                                     i + 1, 100 * found.fraction));
    } else if (found.rise_mm > kMaxRise_mm) {
      warnings.push_back(fmt::format("{} {}: bone rises up to {:.1f} mm above {}: the tool begins inside the bone",
                                     what, i + 1, found.rise_mm,
                                     hole ? "start_mm, which is to be on the surface"
                                          : "the line between start_mm and end_mm, which are to be on the surface"));
    }
  }
  return warnings;
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
      std::vector<std::string> warnings =
          CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return bone.SignedDistance(p_W); });
      const Vec3 size = bone.CalcBounds().size();
      return {fmt::format("{}, {:.1f} x {:.1f} x {:.1f} mm, voxels of {} mm", scene.bone.file, size.x, size.y, size.z,
                          bone.voxel_mm()),
              bone.voxel_mm(), material, std::move(warnings)};
    }
    case BoneSource::kMandible: {
      const MandibleParams& mandible = scene.bone.mandible;
      const MandibleShape shape(mandible);  // throws if the parameters do not fit together
      std::vector<std::string> warnings =
          CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return shape.Value(p_W); });
      const Vec3 room = shape.bounds().size();
      return {fmt::format("generic mandible, within {:.0f} x {:.0f} x {:.0f} mm, voxels of {} mm", room.x, room.y,
                          room.z, mandible.voxel_mm),
              mandible.voxel_mm, generated, std::move(warnings)};
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate: {
      const BlockParams& block = scene.bone.block;
      CheckBlock(block, table);
      std::vector<std::string> warnings =
          CheckWantedCutsMeetBone(scene, [&](const Vec3& p_W) { return CalcBlockDistance(block, p_W); });
      // Only generating a block shows whether it is too thin to contain a voxel.
      if (std::min({block.size_mm.x, block.size_mm.y, block.size_mm.z}) < 2 * block.voxel_mm) MakeSceneBone(scene, {});
      const std::size_t layers = block.layers.size();
      const std::string divided =
          layers == 0 ? "one region" : fmt::format("{} {}", layers, layers == 1 ? "layer" : "layers");
      return {fmt::format("{} {} x {} x {} mm, {}, voxels of {} mm", ToString(scene.bone.source), block.size_mm.x,
                          block.size_mm.y, block.size_mm.z, divided, block.voxel_mm),
              block.voxel_mm, generated, std::move(warnings)};
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
  checked.warnings.insert(checked.warnings.end(), bone.warnings.begin(), bone.warnings.end());
  if (scene.coupling.given || scene.device.given || scene.hand.given || scene.loop.given) {
    checked.loop = MakeLoopSetup(scene);
    for (const std::string& warning : FindHandWarnings(scene, *checked.loop)) checked.warnings.push_back(warning);
  }
  checked.warnings.insert(checked.warnings.end(), bone.material.warnings.begin(), bone.material.warnings.end());
  return checked;
}

}  // namespace kerf
