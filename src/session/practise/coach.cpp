#include "session/practise/coach.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "kerf/describe.h"

namespace kerf {
namespace {

/// A blade further beside the wanted plane than this multiple of the margin is a reason to stop.
constexpr double kFarBeside = 2;

/// Returns true if the wanted cut is a planned plane rather than a line on the surface. It crosses the nerve canal.
bool IsPlanned(ExerciseKind kind) {
  return kind == ExerciseKind::kOsteotomy;
}

std::size_t IndexOf(CoachTopic topic) {
  return static_cast<std::size_t>(topic);
}

/// Returns how far each topic's value is, as a multiple of its limit; above 1 it is due.
std::array<double, kCoachTopics> CalcExcess(const WantedCut& cut, const CoachInput& input) {
  std::array<double, kCoachTopics> excess{};
  if (input.nerve_mm) {
    const bool spares = !IsPlanned(input.kind);
    excess[IndexOf(CoachTopic::kInNerve)] = spares && *input.nerve_mm <= 0 ? 2 : 0;
    // The limit is a minimum: at kCoachNerve_mm it is due, and it ends at kCoachNerve_mm / kCoachRelease.
    excess[IndexOf(spares ? CoachTopic::kNearNerve : CoachTopic::kCrossesNerve)] =
        kCoachNerve_mm / std::max(*input.nerve_mm, 1e-6);
  }
  // Far beside the line there is no depth.
  const bool in_bone = input.touches && (!input.depth || input.depth->depth_mm > 0);
  if (!in_bone) return excess;
  const ToolDeviation deviation = CalcDeviation(cut, input.X_WT);
  if (input.depth) excess[IndexOf(CoachTopic::kTooDeep)] = std::max(-input.depth->to_goal_mm, 0.0) / kCoachTooDeep_mm;
  excess[IndexOf(CoachTopic::kBeyondEnd)] = deviation.beyond_mm / cut.margin_mm;
  excess[IndexOf(CoachTopic::kBesideLine)] = std::abs(deviation.beside_mm) / cut.margin_mm;
  excess[IndexOf(CoachTopic::kTilted)] = deviation.tilt_deg / kCoachTilt_deg;
  return excess;
}

}  // namespace

ToolDeviation CalcDeviation(const WantedCut& cut, const Pose& X_WT) {
  ToolDeviation deviation;
  const Vec3 z_W = X_WT.R_AB * Vec3(0, 0, 1);
  Vec3 lowest_W = X_WT.p_AB + cut.radius_mm * cut.into_W;
  if (cut.is_disc) {
    // The point of the rim that is furthest in the direction into the bone.
    const Vec3 down = cut.into_W - glm::dot(cut.into_W, z_W) * z_W;
    if (glm::length(down) > 1e-6) lowest_W = X_WT.p_AB + cut.radius_mm * glm::normalize(down);
    const double cosine = std::min(std::abs(glm::dot(z_W, cut.across_W)), 1.0);
    deviation.tilt_deg = std::acos(cosine) * kDegreesPerRad;
  }
  const Vec3 p = cut.ToCut(lowest_W);
  deviation.beside_mm = p.z;
  deviation.beyond_mm = std::max({-p.x, p.x - cut.length_mm, 0.0});
  return deviation;
}

CoachState UpdateCoach(const CoachState& state, const WantedCut& cut, const CoachInput& input) {
  CoachState next = state;
  const std::array<double, kCoachTopics> excess = CalcExcess(cut, input);
  std::optional<CoachTopic> first;
  for (std::size_t i = 0; i < kCoachTopics; ++i) {
    next.on[i] = excess[i] > (state.on[i] ? kCoachRelease : 1);
    if (next.on[i] && !first) first = static_cast<CoachTopic>(i);
  }
  if (first == state.shown) return next;
  const bool more_urgent = first && state.shown && *first < *state.shown;
  const bool held = state.shown && input.time_s < state.shown_since_s + kCoachHold_s;
  if (held && !more_urgent) return next;
  next.shown = first;
  next.shown_since_s = input.time_s;
  return next;
}

std::optional<CoachLine> MakeCoachLine(const CoachState& state, const WantedCut& cut, const CoachInput& input) {
  if (!state.shown) return {};
  const ToolDeviation deviation = CalcDeviation(cut, input.X_WT);
  const auto line = [&](bool urgent, Message message) { return CoachLine{*state.shown, urgent, std::move(message)}; };
  switch (*state.shown) {
    case CoachTopic::kInNerve:
      return line(true, {MarkMessage("Stop: the blade is in the nerve canal. Lift it out."), {}});
    case CoachTopic::kNearNerve:
      return line(true, {MarkMessage("The nerve canal is {} away: do not go deeper."),
                         {Quantity{std::max(input.nerve_mm.value_or(0), 0.0), 1, "mm"}}});
    case CoachTopic::kTooDeep:
      return line(true, {MarkMessage("Too deep by {}: lift the blade."),
                         {Quantity{std::max(input.depth ? -input.depth->to_goal_mm : 0.0, 0.0), 1, "mm"}}});
    case CoachTopic::kBeyondEnd:
      return line(false, {IsPlanned(input.kind) ? MarkMessage("You are {} beyond the edge of the planned cut.")
                                                : MarkMessage("The line ends here: you are {} beyond its end."),
                          {Quantity{deviation.beyond_mm, 1, "mm"}}});
    case CoachTopic::kBesideLine:
      return line(std::abs(deviation.beside_mm) > kFarBeside * cut.margin_mm,
                  {IsPlanned(input.kind) ? MarkMessage("You leave the planned plane: the blade is {} beside it.")
                                         : MarkMessage("You leave the line: the blade is {} beside it."),
                   {Quantity{std::abs(deviation.beside_mm), 1, "mm"}}});
    case CoachTopic::kTilted:
      return line(false, {MarkMessage("The blade is tilted by {}: turn it into the wanted plane."),
                          {Quantity{deviation.tilt_deg, 0, "°"}}});
    case CoachTopic::kCrossesNerve:
      if (input.nerve_mm.value_or(0) <= 0) {
        return line(false, {MarkMessage("The blade is in the nerve canal, which the planned plane crosses."), {}});
      }
      return line(false, {MarkMessage("The planned plane crosses the nerve canal, which is {} away."),
                          {Quantity{*input.nerve_mm, 1, "mm"}}});
  }
  return {};
}

ExerciseStep FindStep(const CoachInput& input, bool spindle_on, double line_done) {
  if (line_done >= kStepLineDone) return ExerciseStep::kFinish;
  if (!spindle_on) return ExerciseStep::kSwitchOn;
  if (!input.depth || input.depth->depth_mm <= 0) return ExerciseStep::kLower;
  return input.depth->to_goal_mm > kStepDepth_mm ? ExerciseStep::kDeepen : ExerciseStep::kFollow;
}

Message DescribeStep(ExerciseStep step, ExerciseKind kind, const WantedCut& cut, double line_done) {
  const bool planned = IsPlanned(kind);
  switch (step) {
    case ExerciseStep::kSwitchOn:
      return {MarkMessage("Switch the spindle on."), {}};
    case ExerciseStep::kLower:
      if (planned) return {MarkMessage("Lower the blade into the bone in the planned plane."), {}};
      return {MarkMessage("Lower the blade into the bone at one end of the line."), {}};
    case ExerciseStep::kDeepen:
      if (planned) return {MarkMessage("Go on slowly in the planned plane until the bone is cut through."), {}};
      return {MarkMessage("Go on slowly to the depth of {}."), {Quantity{cut.depth_mm, 1, "mm"}}};
    case ExerciseStep::kFollow:
      if (planned) {
        return {MarkMessage("Deep enough: move along the planned plane to its other edge. {} of it is done."),
                {Quantity{100 * line_done, 0, "%"}}};
      }
      return {MarkMessage("Deep enough: move along the line to its other end. {} of it is done."),
              {Quantity{100 * line_done, 0, "%"}}};
    case ExerciseStep::kFinish:
      break;
  }
  if (planned) return {MarkMessage("The planned cut is made: lift the blade out and finish the exercise."), {}};
  return {MarkMessage("The whole line is cut: lift the blade out and finish the exercise."), {}};
}

double CalcLineDone(const DepthGauge& gauge, const std::vector<double>& deepest_mm) {
  const std::vector<CutColumn>& columns = gauge.columns();
  int places = 0;
  int done = 0;
  for (std::size_t i = 0; i < columns.size() && i < deepest_mm.size(); ++i) {
    if (columns[i].s_mm < 0 || columns[i].s_mm > gauge.cut().length_mm) continue;
    const double wanted_mm = std::min(gauge.cut().depth_mm, columns[i].far_mm - columns[i].near_mm);
    ++places;
    if (deepest_mm[i] >= wanted_mm - kStepDepth_mm) ++done;
  }
  return places == 0 ? 0 : static_cast<double>(done) / places;
}

}  // namespace kerf
