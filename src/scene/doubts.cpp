#include "scene/doubts.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "scene/path.h"

namespace kerf {
namespace {

/// Below this many voxels the kerf between two faces of a level set comes out too narrow.
constexpr double kResolvedVoxels = 2;
/// The chip law holds up to about here (include/kerf/force.h).
constexpr double kValidBite_mm = 0.005;

}  // namespace

double CalcTopBite(const Scene& scene) {
  const double passes_per_s = scene.tool.teeth * scene.tool.rpm / 60;
  return passes_per_s > 0 ? MakePath(scene).CalcTopSpeed() / passes_per_s : std::numeric_limits<double>::infinity();
}

std::vector<std::string> FindDoubts(const Scene& scene, double voxel_mm) {
  std::vector<std::string> doubts;
  const double voxels = voxel_mm > 0 ? scene.tool.thickness_mm / voxel_mm : kResolvedVoxels;
  if (voxels < 1) {
    doubts.push_back(
        fmt::format("the disc is thinner than a voxel (thickness_mm = {}, voxels of {} mm): removed volume and kerf "
                    "width can be off by "
                    "half and more; use voxels of at most {:.3g} mm",
                    scene.tool.thickness_mm, voxel_mm, scene.tool.thickness_mm / kResolvedVoxels));
  } else if (voxels < kResolvedVoxels) {
    doubts.push_back(fmt::format(
        "the disc is {:.3g} voxels thick (thickness_mm = {}, voxels of {} mm): below {} voxels the kerf comes out "
        "up to some percent too narrow; use voxels of at most {:.3g} mm",
        voxels, scene.tool.thickness_mm, voxel_mm, kResolvedVoxels, scene.tool.thickness_mm / kResolvedVoxels));
  }
  if (scene.tool.rpm == 0) {
    doubts.emplace_back("rpm = 0: a stopped saw cuts nothing");
  } else if (scene.force.kind == ForceLawKind::kHertzChip && CalcTopBite(scene) > kValidBite_mm) {
    doubts.push_back(fmt::format(
        "the bite reaches {:.3g} um: hertz_chip holds up to about {:.3g} um, beyond it gives too much force; feed "
        "more slowly or turn faster",
        1000 * CalcTopBite(scene), 1000 * kValidBite_mm));
  }
  for (std::size_t i = 0; i < scene.path.strokes.size(); ++i) {
    const SceneStroke& stroke = scene.path.strokes[i];
    const Vec3 travel = stroke.end_mm - stroke.start_mm;
    const Vec3 nhat = glm::normalize(stroke.disc_normal);
    if (glm::length(travel) > 0 && std::abs(glm::dot(travel, nhat)) > 0.05 * glm::length(travel)) {
      doubts.push_back(fmt::format(
          "stroke {} moves {:.3g} degrees out of the disc's plane: the flanks sweep bone away, and only the "
          "teeth have a force",
          i + 1, std::asin(std::abs(glm::dot(travel, nhat)) / glm::length(travel)) * 57.29577951308232));
    }
  }
  return doubts;
}

}  // namespace kerf
