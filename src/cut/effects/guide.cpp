// guide: a virtual fixture that keeps the tool on a plan, like a cutting guide screwed to the bone: in the planned
// plane, above a maximum depth, and between the ends of a kerf.
//
//   Points of the disc's rim may be up to `tolerance_mm` off the plane. Beyond that, springs hold them. Each of four
//   points has a spring of stiffness k / 4, so that the springs also limit the disc's tilt; a ball has one spring of
//   stiffness k. The depth stop is one such spring at the deepest point of the tool, and an end stop is one at the
//   tool's centre. Of a blade with a stroke the four points are the nearest to the corners of its box, in the middle of
//   the stroke, and the deepest point is that at the end of the stroke: the guide does not move with the stroke.
//
// The springs are part of the step's convex problem. They are passive. A tool that is set down off the plan is not
// pulled towards it, but the wall follows each motion towards the plan, so that the progress is kept. A tool that is
// pushed away with more than `max_force_N` moves the wall along.
#include "cut/effects/guide.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/tool/along_edge.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kNear_mm = 1;     // a wall nearer than this is in the step's problem
constexpr double kNearVoxels = 4;  // the same in voxels; more than the motion in a step
constexpr double kInPlane = 0.02;  // sine of the largest angle between a depth direction and the plane
constexpr int kRimPoints = 4;
constexpr double kRounding_mm = 1e-9;

/// Returns a description of the fault; empty if there is none.
std::string FindFault(const Vec3& normal_W, const Vec3& depth_direction_W) {
  const std::string no_length = " has no direction: its length is 0";
  if (!(glm::length(normal_W) > 1e-6)) return "normal" + no_length;
  if (!(glm::length(depth_direction_W) > 1e-6)) return "depth_direction" + no_length;
  if (std::abs(glm::dot(glm::normalize(normal_W), glm::normalize(depth_direction_W))) > kInPlane) {
    return "depth_direction does not lie in the plane: it must be perpendicular to normal";
  }
  return "";
}

const GuideParams& Checked(const GuideParams& params) {
  const std::string fault = FindFault(params.normal_W, params.depth_direction_W);
  if (!fault.empty()) throw Error("effect guide: " + fault);
  return params;
}

}  // namespace

GuideEffect::GuideEffect(const GuideParams& params, const EffectSetup& setup)
    : params_(Checked(params)),
      tool_(setup.tool),
      p_F_mm_(params.point_W_mm - setup.p_WF_mm),
      n_W_(glm::normalize(params.normal_W)),
      p_TC_(setup.p_TC_mm),
      yield_mm_(params.max_force_N / params.stiffness_N_per_mm),
      outline_(MakeToolOutline(tool_)),
      half_stroke_mm_(0.5 * CalcStroke(tool_)),
      radius_mm_(outline_.empty() ? CalcRadius(tool_) : CalcReach(tool_)),
      near_mm_(std::max(kNear_mm, kNearVoxels * setup.field.voxel_mm())),
      depth_W_(glm::normalize(params.depth_direction_W)),
      is_blade_(IsBlade(tool_)),
      top_mm_(CalcRoundSolid(tool_).value_or(RoundSolid{}).top_z_mm) {
  const auto add = [&](const Vec3& n_W, const Vec3& p_T, bool deepest, double min_mm, double stiffness) {
    walls_.push_back({n_W, p_T, deepest, min_mm, stiffness, min_mm});
  };
  // Points of the rim, of a ball its centre, of a solid of revolution the ends of its axis.
  const int points = is_blade_ ? kRimPoints : top_mm_ > 0 ? 2 : 1;
  for (int i = 0; i < points; ++i) {
    Vec3 p_T =
        is_blade_ ? radius_mm_ * Vec3(i % 2 == 0 ? 1 - i : 0, i % 2 == 1 ? 2 - i : 0, 0) : Vec3(0, 0, i * top_mm_);
    if (!outline_.empty()) {
      const ConvexOutline::Point corner =
          outline_.FindNearest({i < 2 ? radius_mm_ : -radius_mm_, i % 2 == 0 ? radius_mm_ : -radius_mm_});
      p_T = {corner.x, corner.y, 0};
    }
    for (const double side : {-1.0, 1.0}) {
      add(side * n_W_, p_T, false, params.tolerance_mm, params.stiffness_N_per_mm / points);
    }
  }
  if (params.depth_mm > 0) add(depth_W_, Vec3(0), true, params.depth_mm, params.stiffness_N_per_mm);
  if (params.slot_length_mm > 0) {
    const Vec3 along_W = glm::cross(n_W_, depth_W_);
    for (const double side : {-1.0, 1.0}) {
      add(side * along_W, Vec3(0), false, 0.5 * params.slot_length_mm, params.stiffness_N_per_mm);
    }
  }
}

/// Returns the point of the edge that lies furthest along a direction at any time of the stroke, tool frame.
Vec3 GuideEffect::FindDeepestOfTool(const Vec3& n_T) const {
  Vec3 p_T = FindDeepest(tool_, n_T);
  if (!(half_stroke_mm_ > 0) || p_T == Vec3(0)) return p_T;
  // An arc may reach its furthest point before the end of the stroke.
  const EdgeMotion motion(CalcSwingRadius(tool_));
  const double to_deepest_mm =
      motion.is_straight() ? std::copysign(half_stroke_mm_, n_T.y)
                           : CalcAlongEdge(motion, {n_T.x - motion.radius_mm(), n_T.y, 0}) - CalcAlongEdge(motion, p_T);
  return motion.Move(p_T, std::clamp(to_deepest_mm, -half_stroke_mm_, half_stroke_mm_));
}

/// Returns the point that the wall limits, tool frame.
Vec3 GuideEffect::FindPoint(const Wall& wall, const Pose& X_FT) const {
  if (!wall.deepest) return wall.p_T;
  return FindDeepestOfTool(X_FT.InverseVector(wall.n_W));
}

/// Returns the position of the wall's point along the wall's normal, from the plan's point, mm.
double GuideEffect::CalcPosition(const Wall& wall, const Pose& X_FT) const {
  return glm::dot(wall.n_W, X_FT.Point(FindPoint(wall, X_FT)) - p_F_mm_);
}

/// Returns the distance to the nearest wall, mm.
double GuideEffect::CalcGap(const Pose& X_FT) const {
  double gap = 1e300;
  for (const Wall& wall : walls_) gap = std::min(gap, wall.at_mm - CalcPosition(wall, X_FT));
  return gap;
}

/// Lets walls that were pushed beyond their own position follow the tool back.
void GuideEffect::Follow(const Pose& X_FT) {
  for (Wall& wall : walls_) {
    const double position_mm = CalcPosition(wall, X_FT);
    if (fresh_ || position_mm < wall.at_mm) wall.at_mm = std::max(wall.min_mm, position_mm);
  }
  fresh_ = false;
}

bool GuideEffect::Holds(const EffectFlight& flight) {
  Follow(flight.X_FT_from);
  // During the motion the tool's points deviate from straight lines by at most the sagitta of the rotation.
  const double cos_half = std::min(1.0, std::abs(glm::dot(flight.X_FT_from.R_AB, flight.X_FT_to.R_AB)));
  const double bent_mm = std::max(radius_mm_, top_mm_) * (1 - std::max(0.0, 2 * cos_half * cos_half - 1));
  return std::min(CalcGap(flight.X_FT_from), CalcGap(flight.X_FT_to)) < near_mm_ + bent_mm;
}

void GuideEffect::Engage(const EffectStep& step, StepProblem& problem) {
  Follow(step.X_FT);
  for (Wall& wall : walls_) {
    const Vec3 p_T = FindPoint(wall, step.X_FT);
    const double depth_mm = glm::dot(wall.n_W, step.X_FT.Point(p_T) - p_F_mm_) - wall.at_mm;
    wall.near = depth_mm > -near_mm_;
    if (!wall.near) continue;
    wall.solid = problem.solids.size();
    problem.solids.push_back(
        {MakeRow(step.X_FT.InverseVector(wall.n_W), p_T - p_TC_), depth_mm, wall.stiffness_N_per_mm});
  }
}

void GuideEffect::Solved(const EffectSolved& solved) {
  Vec3 f_W_N(0);
  for (Wall& wall : walls_) {
    if (!wall.near) continue;
    const SolidPoint& p = solved.problem.solids[wall.solid];
    const double at_end_mm = p.depth_mm + solved.problem.tau_s * Dot(p.row, solved.u);
    f_W_N -= wall.stiffness_N_per_mm * std::max(0.0, at_end_mm) * wall.n_W;
    wall.at_mm = std::max(wall.at_mm, CalcPosition(wall, solved.X_FT_next) - yield_mm_);
  }
  force_N_ = glm::length(f_W_N);
  solved_ = true;
}

void GuideEffect::End(EffectEnd& end) {
  if (!solved_) force_N_ = 0;
  solved_ = false;
  at_ = end.X_FT;
  known_ = true;
}

void GuideEffect::Report(std::span<double> channels) const {
  std::fill(channels.begin(), channels.end(), 0.0);
  if (!known_) return;
  const Vec3 p_mm = at_.p_AB - p_F_mm_;
  double deviation_mm = 0;
  for (const Wall& wall : walls_) {
    if (std::abs(glm::dot(wall.n_W, n_W_)) > 0.5) deviation_mm = std::max(deviation_mm, CalcPosition(wall, at_));
  }
  Vec3 n_T = at_.InverseVector(depth_W_);
  if (is_blade_) n_T.z = 0;
  const double length = is_blade_ ? glm::length(n_T) : 1;
  channels[0] = deviation_mm > kRounding_mm ? deviation_mm : 0;
  channels[1] =
      is_blade_ ? kDegreesPerRad * std::acos(std::min(1.0, std::abs(glm::dot(at_.Vector({0, 0, 1}), n_W_)))) : 0;
  channels[2] = glm::dot(depth_W_, p_mm) +
                (top_mm_ > 0 || !outline_.empty() ? glm::dot(n_T, FindDeepestOfTool(n_T)) : radius_mm_ * length);
  channels[kForceChannel] = force_N_;
}

const EffectInfo& Guide() {
  static const EffectInfo kEffect{
      .name = "guide",
      .summary = "keeps the tool on a plan: on a plane, above a depth stop, between the ends of a slot",
      .source =
          "virtual fixture (Rosenberg 1993) with one-sided springs that yield; stiffness and maximum force are "
          "choices, not measured",
      .reads = "the tool's pose",
      .writes = "force and torque on the tool",
      .state = "positions of up to 11 walls",
      .sleeps = "while every wall is further away than a millimetre and four voxels",
      .hooks = kEffectHolds | kEffectEngage | kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<GuideParams>(),
      .channels = {{"deviation_mm",
                    "largest distance of a point of the rim, or of the axis of another tool, from the plane"},
                   {"tilt_deg", "tilt of a blade relative to the plane"},
                   {"depth_mm", "depth of the tool's deepest point below point_mm"},
                   {"force_N", "force of the guide on the tool"}},
      .find_fault =
          [](std::span<const EffectValue> values) {
            const auto params = ReadEffectParameters<GuideParams>(values);
            return FindFault(params.normal_W, params.depth_direction_W);
          },
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<GuideEffect>(ReadEffectParameters<GuideParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
