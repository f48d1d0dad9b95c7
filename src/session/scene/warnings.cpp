#include "session/scene/warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "cut/force/measured.h"
#include "cut/tool/drive.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

/// For a blade thinner than this many voxels, the level set makes the kerf up to a few percent too narrow.
constexpr double kResolvedVoxels = 2;
/// Maximum distance between points of the rim. Larger ones cause noise that a hand feels: in a hand-held cut, 33 mN at
/// 2.9 mm, compared with 1.7 mN at 0.2 mm.
constexpr double kMaxApart_mm = 1;

/// Adds warnings about the parts of the scene that slab mode ignores.
void FindSlabWarnings(const Scene& scene, std::vector<std::string>& warnings) {
  if (scene.tool.rpm == 0) warnings.emplace_back(kStoppedWarning);
  if (&scene.force.info() != &ForceLaw().info()) {
    warnings.push_back(fmt::format("[force] law = \"{}\" is not used in slab mode, whose law is \"{}\" of [slab]",
                                   scene.force.name(), ToString(scene.slab.params.reading)));
  }
  if (!scene.effects.empty()) {
    std::string names;
    for (const EffectChoice& choice : scene.effects)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", choice.name());
    warnings.push_back(fmt::format("slab mode simulates no effects; it ignores [effects]: {}", names));
  }
  const Path path = MakePath(scene);
  const Vec3 d = glm::normalize(scene.slab.direction);
  double across_mm = 0;
  double along_mm = 0;
  constexpr int kPathSamples = 200;  // samples of the path in each segment
  for (std::size_t i = 0; i < path.segments().size(); ++i) {
    const PathSegment& segment = path.segments()[i];
    Vec3 before = path.CalcPose(i, segment.start_s).p_AB;
    for (int k = 1; k <= kPathSamples; ++k) {
      const Vec3 at = path.CalcPose(i, segment.start_s + (segment.end_s - segment.start_s) * k / kPathSamples).p_AB;
      const double along = glm::dot(at - before, d);
      along_mm += std::abs(along);
      across_mm += glm::length(at - before - along * d);
      before = at;
    }
  }
  if (across_mm > 0.05 * (along_mm + across_mm)) {
    warnings.push_back(fmt::format(
        "the path moves {:.3g} mm along the cut direction and {:.3g} mm across it: in slab mode only motion along "
        "direction = [{:g}, {:g}, {:g}] is felt",
        along_mm, across_mm, scene.slab.direction.x, scene.slab.direction.y, scene.slab.direction.z));
  }
  if (scene.slab.hold != SlabBody::kSlice) {
    warnings.push_back(
        fmt::format("hold = \"{0}\": the path moves the {0} segment, and the blade stays where the path starts",
                    scene.slab.hold == SlabBody::kLeft ? "left" : "right"));
  }
  if (scene.slab.params.friction_coefficient > 0 && scene.slab.params.normal_force_N == 0) {
    warnings.emplace_back("friction_coefficient is given, but normal_force_N is 0: there is no friction");
  } else if (scene.slab.params.friction_coefficient == 0 && scene.slab.params.normal_force_N > 0) {
    warnings.emplace_back("normal_force_N is given, but friction_coefficient is 0: there is no friction");
  }
}

/// Returns what is wrong with a blade that has a stroke, on voxels of this size.
std::vector<std::string> FindStrokeWarnings(const PlanarBlade& blade, double voxel_mm) {
  std::vector<std::string> warnings;
  if (blade.stroke_mm < blade.pitch_mm) {
    warnings.push_back(
        fmt::format("the stroke is shorter than the pitch ({:.3g} mm, pitch_mm = {}): no tooth passes the places "
                    "between the strokes "
                    "of two teeth, but the cut is made there too",
                    blade.stroke_mm, blade.pitch_mm));
  }
  if (const double voxels = blade.kerf_mm / voxel_mm; voxel_mm > 0 && voxels < kResolvedVoxels) {
    warnings.push_back(fmt::format(
        "the kerf of the blade is {:.3g} voxels wide: below {} voxels it is up to a few percent too narrow, "
        "and below 1 it is a voxel wide; use voxels of at most {:.3g} mm",
        voxels, kResolvedVoxels, blade.kerf_mm / kResolvedVoxels));
  }
  return warnings;
}

}  // namespace

std::vector<std::string> FindVoxelWarnings(const SimulationParams& params, double voxel_mm) {
  if (const auto blade = FindPlanarBlade(params.tool)) return FindStrokeWarnings(*blade, voxel_mm);
  if (!IsBlade(params.tool)) return {};
  const double pitch_mm = CalcTooth(params.tool).pitch_mm;
  const double thickness_mm = CalcThickness(params.tool);
  const std::string_view shape = GetShape(params.tool);
  std::vector<std::string> warnings;
  if (const double apart_mm = pitch_mm / params.rim_samples_per_pitch; apart_mm > kMaxApart_mm) {
    warnings.push_back(fmt::format(
        "the rim samples the bone only every {:.3g} mm (teeth = {} times rim_samples_per_pitch = {}): the force "
        "changes in steps; give rim_samples_per_pitch = {}",
        apart_mm, CountPassesPerTurn(params.tool), params.rim_samples_per_pitch,
        std::min(256.0, std::ceil(pitch_mm / kMaxApart_mm))));
  }
  const double voxels = voxel_mm > 0 ? thickness_mm / voxel_mm : kResolvedVoxels;
  if (voxels < 1) {
    warnings.push_back(
        fmt::format("the {} is thinner than a voxel (thickness_mm = {}, voxels of {} mm): its kerf is one voxel "
                    "wide, and the removed volume is 0.75 to 1 voxels times the area; use voxels of at most {:.3g} mm",
                    shape, thickness_mm, voxel_mm, thickness_mm / kResolvedVoxels));
  } else if (voxels < kResolvedVoxels) {
    warnings.push_back(fmt::format(
        "the {} is {:.3g} voxels thick (thickness_mm = {}, voxels of {} mm): below {} voxels the kerf is up to a few "
        "percent too narrow; use voxels of at most {:.3g} mm",
        shape, voxels, thickness_mm, voxel_mm, kResolvedVoxels, thickness_mm / kResolvedVoxels));
  }
  return warnings;
}

std::vector<std::string> FindLawWarnings(const SimulationParams& params, double bite_mm) {
  const ForceLawInfo& law = params.law.info();
  const double to_mm = FindMaxValidBite(params.law, params.tool);
  std::vector<std::string> warnings;
  if (IsNowhereMeasured(law.validity)) {
    warnings.push_back(
        fmt::format("{} {}: {}", law.name, law.validity.beyond, DescribeAccuracy(params.law, params.tool)));
  } else if (bite_mm > to_mm) {
    warnings.push_back(fmt::format("the bite reaches {:.3g} um: {} holds up to about {:.2g} um, {}", 1000 * bite_mm,
                                   law.name, 1000 * to_mm, law.validity.beyond));
  } else if (bite_mm < FindMinValidBite(params.law)) {
    warnings.push_back(fmt::format("the bite stays at or below {:.3g} um: {} holds from about {:.3g} um, {}",
                                   1000 * bite_mm, law.name, 1000 * FindMinValidBite(params.law), law.validity.below));
  }
  constexpr double kMeasuredRake_deg = -10;
  constexpr double kRakeTolerance_deg = 10;  // rakes of 0 to -10 degrees differ little (docs/validation.md, rake_1987)
  const double rake_deg = CalcRake(params.tool);
  if (FindCaveat(law).by_width && !params.law.has_own_table() &&
      std::abs(rake_deg - kMeasuredRake_deg) > kRakeTolerance_deg) {
    warnings.push_back(fmt::format("rake_deg = {:g} is not used: the forces of {} were measured at about {:g} degrees",
                                   rake_deg, law.name, kMeasuredRake_deg));
  }
  return warnings;
}

std::string DescribeUnusedDirection(const ForceLaw& law) {
  return fmt::format("osteon_direction is not used: the law {} is isotropic", law.name());
}

double CalcMaxBite(const Scene& scene) {
  const double passes_per_s = CalcLeastPassRate(MakeTool(scene), scene.tool.rpm);
  return passes_per_s > 0 ? MakePath(scene).CalcMaxSpeed() / passes_per_s : std::numeric_limits<double>::infinity();
}

std::vector<std::string> FindWarnings(const Scene& scene, double voxel_mm) {
  std::vector<std::string> warnings;
  if (scene.simulation.mode == SceneMode::kSlab) {
    FindSlabWarnings(scene, warnings);
    return warnings;
  }
  const SimulationParams params = MakeSimulationParams(scene);
  warnings = FindVoxelWarnings(params, voxel_mm);
  if (scene.tool.rpm == 0) {
    warnings.emplace_back(kStoppedWarning);
  } else {
    for (const std::string& warning : FindLawWarnings(params, CalcMaxBite(scene))) warnings.push_back(warning);
    if (scene.material.osteon_direction && (MakeToothForce(scene.force, params.tool).reads & kReadsOsteons) == 0) {
      warnings.push_back(DescribeUnusedDirection(scene.force));
    }
  }
  const bool blade = IsBlade(params.tool);
  const std::optional<RoundSolid> solid = CalcRoundSolid(params.tool);
  const bool side_is_smooth = solid && !solid->side_cuts;
  for (std::size_t i = 0; i < scene.path.strokes.size(); ++i) {
    const SceneStroke& stroke = scene.path.strokes[i];
    const Vec3 travel = stroke.end_mm - stroke.start_mm;
    const Vec3 nhat = glm::normalize(stroke.disc_normal);
    if (blade && glm::length(travel) > 0 && std::abs(glm::dot(travel, nhat)) > 0.05 * glm::length(travel)) {
      warnings.push_back(
          fmt::format("stroke {} moves {:.3g} degrees out of the {}'s plane: the flanks remove bone, but only the "
                      "teeth exert a force",
                      i + 1, std::asin(std::abs(glm::dot(travel, nhat)) / glm::length(travel)) * kDegreesPerRad,
                      CalcStroke(params.tool) > 0 ? "blade" : "disc"));
    }
    const double across_mm = glm::length(glm::cross(travel, nhat));
    if (side_is_smooth && across_mm > 0.05 * glm::length(travel)) {
      warnings.push_back(
          fmt::format("stroke {} moves {:.3g} degrees away from the drill's axis: its side removes bone, but only the "
                      "lips exert a force",
                      i + 1, std::atan2(across_mm, std::abs(glm::dot(travel, nhat))) * kDegreesPerRad));
    }
  }
  return warnings;
}

std::vector<std::string> FindToolWarnings(const Scene& scene, double voxel_mm) {
  std::vector<std::string> warnings = FindVoxelWarnings(MakeSimulationParams(scene), voxel_mm);
  if (scene.tool.rpm == 0) warnings.emplace_back(kStoppedWarning);
  return warnings;
}

}  // namespace kerf
