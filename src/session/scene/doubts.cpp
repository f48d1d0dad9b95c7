#include "session/scene/doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cut/force/measured.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

/// Below this many voxels the kerf between two faces of a level set comes out too narrow.
constexpr double kResolvedVoxels = 2;
/// Points of the rim further apart make a noise that a hand feels: 33 mN at 2.9 mm in a held cut, 1.7 mN at 0.2 mm.
constexpr double kMostApart_mm = 1;
constexpr double kPi = 3.14159265358979323846;

void FindVoxelDoubts(const Scene& scene, double voxel_mm, std::vector<std::string>& doubts) {
  const bool disc = scene.tool.kind == ToolKind::kDisc;
  const int points = scene.tool.teeth * scene.simulation.rim_samples_per_pitch;
  if (const double apart_mm = kPi * scene.tool.diameter_mm / points; disc && apart_mm > kMostApart_mm) {
    doubts.push_back(fmt::format(
        "the rim looks for bone every {:.3g} mm only (teeth = {} times rim_samples_per_pitch = {}): the force "
        "comes in steps; give rim_samples_per_pitch = {}",
        apart_mm, scene.tool.teeth, scene.simulation.rim_samples_per_pitch,
        std::min(256.0, std::ceil(kPi * scene.tool.diameter_mm / scene.tool.teeth / kMostApart_mm))));
  }
  const double voxels = disc && voxel_mm > 0 ? scene.tool.thickness_mm / voxel_mm : kResolvedVoxels;
  if (voxels < 1) {
    doubts.push_back(
        fmt::format("the disc is thinner than a voxel (thickness_mm = {}, voxels of {} mm): its kerf comes out a voxel "
                    "wide, and the removed volume is 0.75 to 1 voxels times the area; use voxels of at most {:.3g} mm",
                    scene.tool.thickness_mm, voxel_mm, scene.tool.thickness_mm / kResolvedVoxels));
  } else if (voxels < kResolvedVoxels) {
    doubts.push_back(fmt::format(
        "the disc is {:.3g} voxels thick (thickness_mm = {}, voxels of {} mm): below {} voxels the kerf comes out "
        "up to some percent too narrow; use voxels of at most {:.3g} mm",
        voxels, scene.tool.thickness_mm, voxel_mm, kResolvedVoxels, scene.tool.thickness_mm / kResolvedVoxels));
  }
}

/// What slab mode leaves out of this scene.
void FindSlabDoubts(const Scene& scene, std::vector<std::string>& doubts) {
  if (scene.tool.rpm == 0) doubts.emplace_back("rpm = 0: a stopped tool cuts nothing");
  if (&scene.force.info() != &ForceLaw().info()) {
    doubts.push_back(fmt::format("[force] law = \"{}\" is not used in slab mode, whose law is \"{}\" of [slab]",
                                 scene.force.name(), ToString(scene.slab.params.reading)));
  }
  if (!scene.effects.empty()) {
    std::string names;
    for (const EffectChoice& choice : scene.effects)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", choice.name());
    doubts.push_back(fmt::format("slab mode simulates no effects, and leaves out those of [effects]: {}", names));
  }
  const Path path = MakePath(scene);
  const Vec3 d = glm::normalize(scene.slab.direction);
  double across_mm = 0;
  double along_mm = 0;
  constexpr int kLooks = 200;  // at the path, in each segment
  for (std::size_t i = 0; i < path.segments().size(); ++i) {
    const PathSegment& segment = path.segments()[i];
    Vec3 before = path.CalcPose(i, segment.start_s).p_AB;
    for (int k = 1; k <= kLooks; ++k) {
      const Vec3 at = path.CalcPose(i, segment.start_s + (segment.end_s - segment.start_s) * k / kLooks).p_AB;
      const double along = glm::dot(at - before, d);
      along_mm += std::abs(along);
      across_mm += glm::length(at - before - along * d);
      before = at;
    }
  }
  if (across_mm > 0.05 * (along_mm + across_mm)) {
    doubts.push_back(fmt::format(
        "the path moves {:.3g} mm along the cut direction and {:.3g} mm across it: in slab mode only motion along "
        "direction = [{:g}, {:g}, {:g}] is felt",
        along_mm, across_mm, scene.slab.direction.x, scene.slab.direction.y, scene.slab.direction.z));
  }
  if (scene.slab.hold != SlabBody::kSlice) {
    doubts.push_back(
        fmt::format("hold = \"{0}\": the path moves the {0} segment, and the blade stays where the path starts",
                    scene.slab.hold == SlabBody::kLeft ? "left" : "right"));
  }
  if (scene.slab.params.friction_coefficient > 0 && scene.slab.params.normal_force_N == 0) {
    doubts.emplace_back("friction_coefficient is given and normal_force_N is 0: there is no friction");
  } else if (scene.slab.params.friction_coefficient == 0 && scene.slab.params.normal_force_N > 0) {
    doubts.emplace_back("normal_force_N is given and friction_coefficient is 0: there is no friction");
  }
}

}  // namespace

double CalcTopBite(const Scene& scene) {
  const int passes_per_turn = scene.tool.kind == ToolKind::kDisc ? scene.tool.teeth : scene.tool.flutes;
  const double passes_per_s = passes_per_turn * scene.tool.rpm / 60;
  return passes_per_s > 0 ? MakePath(scene).CalcTopSpeed() / passes_per_s : std::numeric_limits<double>::infinity();
}

std::vector<std::string> FindDoubts(const Scene& scene, double voxel_mm) {
  std::vector<std::string> doubts;
  if (scene.simulation.mode == SceneMode::kSlab) {
    FindSlabDoubts(scene, doubts);
    return doubts;
  }
  FindVoxelDoubts(scene, voxel_mm, doubts);
  const bool disc = scene.tool.kind == ToolKind::kDisc;
  if (scene.tool.rpm == 0) {
    doubts.emplace_back("rpm = 0: a stopped tool cuts nothing");
  } else {
    const ForceLawInfo& law = scene.force.info();
    const double bite_mm = CalcTopBite(scene);
    const double to_mm = FindTopValidBite(scene.force, MakeTool(scene));
    if (IsNowhereMeasured(law.validity)) {
      doubts.push_back(
          fmt::format("{} {}: {}", law.name, law.validity.beyond, DescribeAccuracy(scene.force, MakeTool(scene))));
    } else if (bite_mm > to_mm) {
      doubts.push_back(fmt::format("the bite reaches {:.3g} um: {} holds up to about {:.2g} um, {}", 1000 * bite_mm,
                                   law.name, 1000 * to_mm, law.validity.beyond));
    } else if (bite_mm < law.validity.from_mm) {
      doubts.push_back(fmt::format("the bite stays at or below {:.3g} um: {} holds from about {:.3g} um, {}",
                                   1000 * bite_mm, law.name, 1000 * law.validity.from_mm, law.validity.below));
    }
  }
  for (std::size_t i = 0; i < scene.path.strokes.size(); ++i) {
    const SceneStroke& stroke = scene.path.strokes[i];
    const Vec3 travel = stroke.end_mm - stroke.start_mm;
    const Vec3 nhat = glm::normalize(stroke.disc_normal);
    if (disc && glm::length(travel) > 0 && std::abs(glm::dot(travel, nhat)) > 0.05 * glm::length(travel)) {
      doubts.push_back(fmt::format(
          "stroke {} moves {:.3g} degrees out of the disc's plane: the flanks sweep bone away, and only the "
          "teeth have a force",
          i + 1, std::asin(std::abs(glm::dot(travel, nhat)) / glm::length(travel)) * 57.29577951308232));
    }
  }
  return doubts;
}

std::vector<std::string> FindToolDoubts(const Scene& scene, double voxel_mm) {
  std::vector<std::string> doubts;
  FindVoxelDoubts(scene, voxel_mm, doubts);
  if (scene.tool.rpm == 0) doubts.emplace_back("rpm = 0: a stopped tool cuts nothing");
  return doubts;
}

}  // namespace kerf
