#include "session/scene/warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "cut/force/measured.h"
#include "cut/tool/drive.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

/// In the kerf of a blade thinner than this many voxels, a cell of the grid may hold parts of both walls. The surface
/// then has teeth that reach the middle of the kerf (seen up to 1.7 voxels, the diagonal of a cell).
constexpr double kResolvedVoxels = 2;
/// Maximum distance between points of the rim. Larger ones cause noise that a hand feels: in a hand-held cut, 33 mN at
/// 2.9 mm, compared with 1.7 mN at 0.2 mm.
constexpr double kMaxApart_mm = 1;
/// A ball, bur or drill removes up to 9 % too little bone if it is as many voxels wide as the first, and up to 40 % if
/// it is as many as the second. Below that, it may remove none.
constexpr double kResolvedRoundVoxels = 3;
constexpr double kLostRoundVoxels = 1.5;

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
    warnings.push_back(
        fmt::format("the kerf of the blade is {:.3g} voxels wide: below {} voxels its surface may have teeth that "
                    "reach its middle, "
                    "and below 1 it is a voxel wide; use voxels of at most {:.3g} mm",
                    voxels, kResolvedVoxels, blade.kerf_mm / kResolvedVoxels));
  }
  return warnings;
}

/// Returns what is wrong with a ball, bur or drill on voxels of this size.
std::vector<std::string> FindRoundWarnings(const Tool& tool, double voxel_mm) {
  const double diameter_mm = CalcCutWidth(tool);
  const double voxels = voxel_mm > 0 ? diameter_mm / voxel_mm : kResolvedRoundVoxels;
  if (voxels >= kResolvedRoundVoxels - 1e-6) return {};
  const std::string fault =
      voxels < kLostRoundVoxels
          ? fmt::format("below {} voxels it removes only a part of the bone or none, with the force of the whole",
                        kLostRoundVoxels)
          : fmt::format("below {} voxels it removes up to 40 % too little bone", kResolvedRoundVoxels);
  // Rounded down, so that the advice is followed with the size as it is written.
  const double advice_mm = std::floor(1000 * diameter_mm / kResolvedRoundVoxels + 1e-6) / 1000;
  return {
      fmt::format("the {} is {:.3g} voxels wide (diameter_mm = {}, voxels of {} mm): {}; use voxels of at most "
                  "{:.3g} mm",
                  GetShape(tool), voxels, diameter_mm, voxel_mm, fault, advice_mm)};
}

/// A straight part of the path.
struct Move {
  std::string what;  // subject of a sentence
  Vec3 travel_mm{0};
  Vec3 axis{0, 0, 1};     // z of the tool, unit length
  bool is_first = false;  // the tool is set down before it
};

/// Returns the strokes, or, of a path file, parts of at least kFilePart_mm, so that noise has no direction.
std::vector<Move> ListMoves(const ScenePath& path) {
  constexpr double kFilePart_mm = 1;
  std::vector<Move> moves;
  for (std::size_t i = 0; i < path.strokes.size(); ++i) {
    const SceneStroke& stroke = path.strokes[i];
    moves.push_back({fmt::format("stroke {}", i + 1), stroke.end_mm - stroke.start_mm,
                     glm::normalize(stroke.disc_normal), stroke.retract});
  }
  if (path.poses.empty()) return moves;
  TimedPose from = path.poses.front();
  for (const TimedPose& to : path.poses) {
    const Vec3 travel_mm = to.X_WT.p_AB - from.X_WT.p_AB;
    if (glm::length(travel_mm) < kFilePart_mm) continue;
    moves.push_back({fmt::format("the path file, from time_s = {:g} on,", from.time_s), travel_mm,
                     from.X_WT.R_AB * Vec3(0, 0, 1), moves.empty()});
    from = to;
  }
  return moves;
}

/// Returns true if the tool is set down before moves[i], which moves it against its tip, and then does not move further
/// towards its tip: a tool that is withdrawn moves towards its tip first.
bool GoesTopFirst(const std::vector<Move>& moves, std::size_t i) {
  constexpr double kMinCosine = 0.7;
  const auto calc_up_mm = [](const Move& move) { return glm::dot(move.travel_mm, move.axis); };
  if (!moves[i].is_first || !(calc_up_mm(moves[i]) > kMinCosine * glm::length(moves[i].travel_mm))) return false;
  double up_mm = 0;
  double highest_mm = 0;
  double lowest_mm = 0;
  for (std::size_t j = i; j < moves.size() && (j == i || !moves[j].is_first); ++j) {
    up_mm += calc_up_mm(moves[j]);
    highest_mm = std::max(highest_mm, up_mm);
    lowest_mm = std::min(lowest_mm, up_mm);
  }
  return -lowest_mm < highest_mm;
}

/// Adds the warnings about moves in which a part of the tool without teeth goes first. A path file may also move the
/// tool through air, so its moves count if they are most of its length, and each kind of warning is given once, for
/// the first of them.
void FindMoveWarnings(const Scene& scene, const Tool& tool, std::vector<std::string>& warnings) {
  const bool is_file = !scene.path.poses.empty();
  const bool blade = IsBlade(tool);
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  const bool side_is_smooth = solid && !solid->side_cuts;
  if (side_is_smooth && scene.tool.reverse) {
    warnings.emplace_back(
        "[tool] reverse: a drill that turns backwards does not cut, but kerf lets its lips cut as usual");
  }
  const std::vector<Move> moves = ListMoves(scene.path);
  double length_mm = 0;
  double wrong_mm = 0;  // out of the plane, or away from the axis
  std::string first;    // warning of these
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const Move& move = moves[i];
    const double travel_mm = glm::length(move.travel_mm);
    if (!(travel_mm > 0)) continue;
    length_mm += travel_mm;
    const double along_mm = std::abs(glm::dot(move.travel_mm, move.axis));
    const double across_mm = glm::length(glm::cross(move.travel_mm, move.axis));
    if (solid && GoesTopFirst(moves, i)) {
      warnings.push_back(fmt::format("{} moves the {} with its top first: it removes bone, but without a force; {}",
                                     move.what, GetShape(tool),
                                     is_file ? "z of the tool must point from its tip to the handpiece"
                                             : "disc_normal must point from its tip to the handpiece: reverse it"));
    }
    std::string warning;
    if (blade && along_mm > 0.05 * travel_mm) {
      warning = fmt::format(
          "{} moves {:.3g} degrees out of the {}'s plane: the flats remove bone, but only the teeth "
          "exert a force",
          move.what, std::asin(std::min(along_mm / travel_mm, 1.0)) * kDegreesPerRad,
          CalcStroke(tool) > 0 ? "blade" : "disc");
    } else if (side_is_smooth && across_mm > 0.05 * travel_mm) {
      warning = fmt::format(
          "{} moves {:.3g} degrees away from the drill's axis: its side removes bone, but only the "
          "lips exert a force",
          move.what, std::atan2(across_mm, along_mm) * kDegreesPerRad);
    }
    if (warning.empty()) continue;
    if (!is_file) warnings.push_back(warning);
    wrong_mm += travel_mm;
    if (first.empty()) first = std::move(warning);
  }
  if (is_file && wrong_mm > 0.5 * length_mm) warnings.push_back(std::move(first));
}

/// Adds the warning about a tool that a path file turns so that faces without teeth move into the bone: a drill that is
/// tilted, and a blade that leaves its plane.
void FindTurnWarnings(const Scene& scene, const Tool& tool, std::vector<std::string>& warnings) {
  constexpr double kNoTurn_rad = 0.02;
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  if (scene.path.poses.empty() || (solid ? solid->side_cuts : !FindPlanarBlade(tool))) return;
  const Vec3 first = scene.path.poses.front().X_WT.Vector({0, 0, 1});
  double most_rad = 0;
  for (const TimedPose& pose : scene.path.poses) {
    const Vec3 axis = pose.X_WT.Vector({0, 0, 1});
    most_rad = std::max(most_rad, std::atan2(glm::length(glm::cross(first, axis)), glm::dot(first, axis)));
  }
  if (most_rad < kNoTurn_rad) return;
  warnings.push_back(fmt::format("the path file turns the tool by up to {:.3g} degrees {}", most_rad * kDegreesPerRad,
                                 solid ? "away from its axis: its side removes bone, but only its lips exert a force"
                                       : "out of its plane: its flats remove bone, but only its teeth exert a force"));
}

/// Adds the warning about wanted cuts that are deeper than the tool is long. A disc and the blade of a reciprocating
/// saw may pass through the whole bone, beside what holds them.
void FindReachWarnings(const Scene& scene, const Tool& tool, std::vector<std::string>& warnings) {
  if (!scene.exercise.given) return;
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  const std::optional<PlanarBlade> blade = FindPlanarBlade(tool);
  if (!solid && GetForm(tool) != ToolForm::kBall && !(blade && !blade->has_tip)) return;
  const double length_mm = solid ? solid->top_z_mm : blade ? blade->length_mm() : 2 * CalcRadius(tool);
  double depth_mm = scene.exercise.depth_mm;
  for (const SceneCut& cut : scene.exercise.further) depth_mm = std::max(depth_mm, cut.depth_mm);
  if (depth_mm <= length_mm + 1e-6) return;
  warnings.push_back(fmt::format("the {} is {:g} mm deep, but only {:.3g} mm of the {} {}",
                                 scene.exercise.kind == ExerciseKind::kDrillHoles ? "hole" : "wanted cut", depth_mm,
                                 length_mm, blade ? "blade" : GetShape(tool),
                                 blade ? "reach into it" : "are modelled above its tip"));
}

}  // namespace

std::vector<std::string> FindVoxelWarnings(const SimulationParams& params, double voxel_mm) {
  if (const auto blade = FindPlanarBlade(params.tool)) return FindStrokeWarnings(*blade, voxel_mm);
  if (!IsBlade(params.tool)) return FindRoundWarnings(params.tool, voxel_mm);
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
        "the {} is {:.3g} voxels thick (thickness_mm = {}, voxels of {} mm): below {} voxels the surface of the kerf "
        "may have teeth that reach its middle; use voxels of at most {:.3g} mm",
        shape, voxels, thickness_mm, voxel_mm, kResolvedVoxels, thickness_mm / kResolvedVoxels));
  }
  return warnings;
}

std::vector<std::string> FindLawWarnings(const SimulationParams& params, double bite_mm) {
  const ForceLawInfo& law = params.law.info();
  const double from_mm = FindMinValidBite(params.law);
  const double to_mm = FindMaxValidBite(params.law, params.tool);
  std::vector<std::string> warnings;
  if (IsNowhereMeasured(law.validity)) {
    warnings.push_back(
        fmt::format("{} {}: {}", law.name, law.validity.beyond, DescribeAccuracy(params.law, params.tool)));
  } else if (bite_mm > to_mm) {
    const std::string range =
        from_mm < to_mm ? fmt::format("holds from about {:.2g} to {:.2g} um", 1000 * from_mm, 1000 * to_mm)
                        : fmt::format("holds at most up to about {:.2g} um, where measurements begin", 1000 * to_mm);
    warnings.push_back(
        fmt::format("the bite reaches {:.3g} um: {} {}, {}", 1000 * bite_mm, law.name, range, law.validity.beyond));
  } else if (bite_mm < from_mm && *law.validity.below != '\0') {
    warnings.push_back(fmt::format("the bite stays at or below {:.3g} um: {} holds from about {:.3g} um, {}",
                                   1000 * bite_mm, law.name, 1000 * from_mm, law.validity.below));
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
  FindMoveWarnings(scene, params.tool, warnings);
  FindTurnWarnings(scene, params.tool, warnings);
  FindReachWarnings(scene, params.tool, warnings);
  return warnings;
}

std::vector<std::string> FindToolWarnings(const Scene& scene, double voxel_mm) {
  std::vector<std::string> warnings = FindVoxelWarnings(MakeSimulationParams(scene), voxel_mm);
  if (scene.tool.rpm == 0) warnings.emplace_back(kStoppedWarning);
  return warnings;
}

}  // namespace kerf
