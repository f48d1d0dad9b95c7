#include "session/practise/coach.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "kerf/describe.h"
#include "session/score/measures.h"

namespace kerf {
namespace {

/// A blade further beside the wanted plane than this multiple of the margin is a reason to stop.
constexpr double kFarBeside = 2;
/// Deviation from the wanted feed that is due, as a fraction of it: the score permits as much.
constexpr double kFeedLimit = kFeedGood;
/// Fraction of a planned cut from which it counts as begun.
constexpr double kSomeDone = 0.01;

/// Returns true if the wanted cut is a planned plane rather than a line on the surface.
bool IsPlanned(ExerciseKind kind) {
  return kind == ExerciseKind::kOsteotomy;
}

bool IsHole(const WantedCut& cut) {
  return cut.length_mm == 0;
}

std::size_t IndexOf(CoachTopic topic) {
  return static_cast<std::size_t>(topic);
}

/// Returns true if the blade is beside the line where it is about to be lowered into the bone.
bool Hovers(const CoachInput& input) {
  return input.depth && input.depth->depth_mm <= 0 && input.depth->depth_mm >= -kCoachHover_mm;
}

bool IsDeep(DepthZone zone) {
  return zone == DepthZone::kDeep || zone == DepthZone::kTooDeep;
}

/// Returns how far each topic's value is, as a multiple of its limit; above 1 it is due.
std::array<double, kCoachTopics> CalcExcess(const WantedCut& cut, const CoachInput& input, DepthZone zone) {
  std::array<double, kCoachTopics> excess{};
  if (input.nerve_mm) {
    const bool spares = !input.crosses_nerve;
    excess[IndexOf(CoachTopic::kInNerve)] = spares && *input.nerve_mm <= 0 ? 2 : 0;
    // The limit is a minimum: at kCoachNerve_mm it is due, and it ends at kCoachNerve_mm / kCoachRelease.
    excess[IndexOf(spares ? CoachTopic::kNearNerve : CoachTopic::kCrossesNerve)] =
        kCoachNerve_mm / std::max(*input.nerve_mm, 1e-6);
  }
  excess[IndexOf(CoachTopic::kTooDeep)] = IsDeep(zone) ? 2 : 0;
  // Far beside the line there is no depth.
  const bool in_bone = input.touches && (!input.depth || input.depth->depth_mm > 0);
  if (!in_bone && !Hovers(input)) return excess;
  const ToolDeviation deviation = CalcDeviation(cut, input.X_WT);
  excess[IndexOf(CoachTopic::kBesideLine)] = std::abs(deviation.beside_mm) / cut.margin_mm;
  // In its hole, a drill can no longer be turned.
  if (in_bone || IsHole(cut)) excess[IndexOf(CoachTopic::kTilted)] = deviation.tilt_deg / kCoachTilt_deg;
  if (!in_bone) return excess;
  excess[IndexOf(CoachTopic::kBeyondEnd)] = deviation.beyond_mm / cut.margin_mm;
  if (!input.feed_mm_per_s || !(input.wanted_feed_mm_per_s > 0)) return excess;
  const double deviates = (*input.feed_mm_per_s / input.wanted_feed_mm_per_s - 1) / kFeedLimit;
  excess[IndexOf(CoachTopic::kTooFast)] = deviates;
  // A blade that is not deep enough yet may take its time.
  if (zone == DepthZone::kReached) excess[IndexOf(CoachTopic::kTooSlow)] = -deviates;
  return excess;
}

/// Returns how to move the tool, against a deviation in a direction.
std::optional<Message> DescribeWay(const std::optional<KeyDirections>& keys, const Vec3& deviation_W) {
  if (!keys) return {};
  const double right = glm::dot(deviation_W, keys->right_W);
  const double up = glm::dot(deviation_W, keys->up_W);
  const double near = glm::dot(deviation_W, glm::cross(keys->right_W, keys->up_W));  // towards the eye
  if (std::abs(right) >= std::max(std::abs(up), std::abs(near))) {
    return Message{right > 0 ? MarkMessage("Left key: to the left.") : MarkMessage("Right key: to the right."), {}};
  }
  if (std::abs(up) >= std::abs(near)) {
    return Message{up > 0 ? MarkMessage("Down key: down.") : MarkMessage("Up key: up."), {}};
  }
  return Message{near > 0 ? MarkMessage("Page Up key: away from you.") : MarkMessage("Page Down key: towards you."),
                 {}};
}

/// Returns how to move a tool that is beside the wanted cut to it. In the bone it cannot move sideways.
std::optional<Message> DescribeWayToCut(const CoachInput& input, const WantedCut& cut, const Vec3& beside_W) {
  std::optional<Message> way = DescribeWay(input.keys, beside_W);
  const bool in_bone = input.touches || (input.depth && input.depth->depth_mm > 0);
  const std::optional<Message> lift = DescribeWay(input.keys, cut.into_W);
  if (!in_bone || !way || !lift) return way;
  return Message{IsHole(cut) ? MarkMessage("Pull the drill out first. {0} Then move it over. {1}")
                             : MarkMessage("Lift the blade out first. {0} Then move it over. {1}"),
                 {FormatMessage(*lift), FormatMessage(*way)}};
}

/// Returns which keys move the tool along a direction and back.
std::optional<Message> DescribeKeysAlong(const std::optional<KeyDirections>& keys, const Vec3& along_W) {
  if (!keys) return {};
  const double right = std::abs(glm::dot(along_W, keys->right_W));
  const double up = std::abs(glm::dot(along_W, keys->up_W));
  const double near = std::abs(glm::dot(along_W, glm::cross(keys->right_W, keys->up_W)));
  if (right >= std::max(up, near)) return Message{MarkMessage("Left or Right key."), {}};
  return Message{up >= near ? MarkMessage("Up or Down key.") : MarkMessage("Page Up or Page Down key."), {}};
}

/// Returns what changes a feed that is too slow or too fast. The keys move the saw at a speed that can be set.
std::optional<Message> DescribeFeedChange(const CoachInput& input) {
  constexpr double kSame = 0.02;  // fraction by which speeds may differ
  const double wanted = input.wanted_feed_mm_per_s;
  if (input.feed_mm_per_s > wanted) {
    if (input.key_feed_mm_per_s <= (1 + kSame) * wanted) return {};
    return Message{MarkMessage("Keys move the saw at {}: press the [ key."),
                   {Quantity{input.key_feed_mm_per_s, 1, "mm/s"}}};
  }
  if (input.key_feed_mm_per_s < (1 - kSame) * wanted) {
    return Message{MarkMessage("Keys move the saw at {}: press the ] key."),
                   {Quantity{input.key_feed_mm_per_s, 1, "mm/s"}}};
  }
  if (input.force_N >= kPressed_N) {
    return Message{MarkMessage("Press less: {} slow the blade. Or press the ] key."),
                   {Quantity{input.force_N, 0, "N"}}};
  }
  return Message{MarkMessage("Keep the key pressed that moves the saw along the line."), {}};
}

/// Returns that the tool is beside the wanted cut, with a place for the distance.
const char* NameBeside(const WantedCut& cut, bool planned) {
  if (IsHole(cut)) return MarkMessage("The tip of the drill is {} beside the axis of the hole.");
  return planned ? MarkMessage("The blade is {} beside the planned plane.")
                 : MarkMessage("The blade is {} beside the line.");
}

Message DescribeTilt(const WantedCut& cut, const ToolDeviation& deviation) {
  return {IsHole(cut)
              ? MarkMessage("The drill is tilted by {}: turn it into the direction of the hole (W S, A D, Q E).")
              : MarkMessage("The blade is tilted by {}: turn it into the wanted plane (W S, A D, Q E)."),
          {Quantity{deviation.tilt_deg, 0, "°"}}};
}

/// Returns the instruction for a step of a hole, or of a blade with a stroke, which plunges; none: it has no own one.
std::optional<StepLine> DescribeHoleStep(ExerciseStep step, const WantedCut& cut, const CoachInput& input) {
  switch (step) {
    case ExerciseStep::kLower:
      return StepLine{{MarkMessage("Set the tip of the drill on the place of the hole and press (Down key)."), {}}};
    case ExerciseStep::kDeepen:
      return StepLine{{MarkMessage("Drill on along the axis to the depth of {} (Down key). Press less as soon as the "
                                   "bone resists less."),
                       {Quantity{cut.depth_mm, 1, "mm"}}}};
    case ExerciseStep::kFollow:
      return StepLine{{MarkMessage("Deep enough: pull the drill out (Up key)."), {}}};
    case ExerciseStep::kFinish:
      return StepLine{
          {input.is_last_cut
               ? MarkMessage("All holes are drilled: pull the drill out (Up key) and finish the exercise (Enter).")
               : MarkMessage(
                     "This hole is drilled: pull the drill out (Up key). With the spindle off (Space), R brings "
                     "it to the next one."),
           {}}};
    default:
      return {};
  }
}
std::optional<StepLine> DescribePlungeStep(ExerciseStep step, const WantedCut& cut, const CoachInput& input,
                                           double done) {
  const Quantity percent{100 * done, 0, "%"};
  const Quantity apart{cut.length_mm / (cut.plunges - 1), 1, "mm"};
  switch (step) {
    case ExerciseStep::kLower:
      if (done < kSomeDone) {
        return StepLine{{MarkMessage("Plunge the blade straight into the bone at one end of the cut (Down key)."), {}}};
      }
      return StepLine{
          {MarkMessage("Plunge the blade in again (Down key), at most {0} beside the last plunge. {1} of the "
                       "cut is made."),
           {apart, percent}},
          DescribeKeysAlong(input.keys, cut.along_W)};
    case ExerciseStep::kDeepen:
      return StepLine{{MarkMessage("Press the blade straight down (Down key), to the depth of {0} or through the bone. "
                                   "Its sides have no teeth: do not move it along. {1} of the cut is made."),
                       {Quantity{cut.depth_mm, 1, "mm"}, percent}}};
    case ExerciseStep::kFollow:
      return StepLine{{MarkMessage("Deep enough here: lift the blade out (Up key) and plunge it in again, at most {0} "
                                   "further along the cut. {1} of the cut is made."),
                       {apart, percent}}};
    default:
      return {};
  }
}

/// Where the tool is outside of what lies in and above the wanted cut; none: it is not.
struct Outside {
  Message message;
  std::optional<Message> way;  // back to the cut
};
std::optional<Outside> FindOutside(const WantedCut& cut, const CoachInput& input, DepthZone zone) {
  const ToolDeviation deviation = CalcDeviation(cut, input.X_WT);
  const bool planned = IsPlanned(input.kind);
  if (std::abs(deviation.beside_mm) > cut.margin_mm) {
    return Outside{{NameBeside(cut, planned), {Quantity{std::abs(deviation.beside_mm), 1, "mm"}}},
                   DescribeWayToCut(input, cut, deviation.beside_W)};
  }
  // In the bone, the advice speaks of the ends and of the depth.
  if (zone != DepthZone::kAbove) return {};
  if (IsHole(cut) && deviation.tilt_deg > kCoachTilt_deg) return Outside{DescribeTilt(cut, deviation), {}};
  if (deviation.beyond_mm > cut.margin_mm) {
    return Outside{{planned ? MarkMessage("The blade is {} beyond the edge of the planned cut.")
                            : MarkMessage("The blade is {} beyond the end of the line."),
                    {Quantity{deviation.beyond_mm, 1, "mm"}}},
                   DescribeWay(input.keys, deviation.before_start ? -cut.along_W : cut.along_W)};
  }
  if (deviation.below_mm > cut.margin_mm) {
    return Outside{{IsHole(cut) ? MarkMessage("The drill is {} below the wanted hole.")
                                : MarkMessage("The blade is {} below the wanted cut."),
                    {Quantity{deviation.below_mm, 1, "mm"}}},
                   DescribeWay(input.keys, cut.into_W)};
  }
  return {};
}

}  // namespace

ToolDeviation CalcDeviation(const WantedCut& cut, const Pose& X_WT) {
  ToolDeviation deviation;
  deviation.tilt_deg = cut.CalcTilt_deg(X_WT);
  const Vec3 p = cut.ToCut(cut.FindLowest(X_WT));
  const bool hole = IsHole(cut);
  deviation.beside_mm = hole ? std::hypot(p.x, p.z) : p.z;
  deviation.beside_W = (hole ? p.x : 0) * cut.along_W + p.z * cut.across_W;
  deviation.beyond_mm = hole ? 0 : std::max({-p.x, p.x - cut.length_mm, 0.0});
  deviation.before_start = p.x < 0;
  deviation.below_mm = std::max(p.y - cut.depth_mm, 0.0);
  return deviation;
}

CoachState UpdateCoach(const CoachState& state, const WantedCut& cut, const CoachInput& input) {
  CoachState next = state;
  next.zone = input.depth ? FindDepthZone(*input.depth, state.zone) : DepthZone::kAbove;
  const std::array<double, kCoachTopics> excess = CalcExcess(cut, input, next.zone);
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
  const auto line = [&](bool urgent, Message message, std::optional<Message> way = {}) {
    return CoachLine{*state.shown, urgent, std::move(message), std::move(way)};
  };
  const std::optional<Message> lift = DescribeWay(input.keys, cut.into_W);
  switch (*state.shown) {
    case CoachTopic::kInNerve:
      return line(true,
                  {IsHole(cut) ? MarkMessage("Stop: the drill is in the nerve canal. Pull it out.")
                               : MarkMessage("Stop: the blade is in the nerve canal. Lift it out."),
                   {}},
                  lift);
    case CoachTopic::kNearNerve:
      return line(true, {MarkMessage("The nerve canal is {} away: do not go deeper."),
                         {Quantity{std::max(input.nerve_mm.value_or(0), 0.0), 1, "mm"}}});
    case CoachTopic::kTooDeep:
      if (input.depth && input.depth->bone_mm) {
        return line(true,
                    {IsHole(cut) ? MarkMessage("Drilled through: the bone is {} thick here. Pull the drill back.")
                                 : MarkMessage("Cut through: the bone is {} thick here. Lift the blade."),
                     {Quantity{*input.depth->bone_mm, 1, "mm"}}},
                    lift);
      }
      return line(true,
                  {IsHole(cut) ? MarkMessage("Too deep by {}: pull the drill back.")
                               : MarkMessage("Too deep by {}: lift the blade."),
                   {Quantity{std::max(input.depth ? -input.depth->to_goal_mm : 0.0, 0.0), 1, "mm"}}},
                  lift);
    case CoachTopic::kBeyondEnd:
      return line(false,
                  {IsPlanned(input.kind) ? MarkMessage("You are {} beyond the edge of the planned cut.")
                                         : MarkMessage("The line ends here: you are {} beyond its end."),
                   {Quantity{deviation.beyond_mm, 1, "mm"}}},
                  DescribeWay(input.keys, deviation.before_start ? -cut.along_W : cut.along_W));
    case CoachTopic::kBesideLine: {
      const Quantity beside{std::abs(deviation.beside_mm), 1, "mm"};
      const bool planned = IsPlanned(input.kind);
      const std::optional<Message> way = DescribeWayToCut(input, cut, deviation.beside_W);
      const bool far = beside.value > kFarBeside * cut.margin_mm;
      if (!input.touches || IsHole(cut)) return line(far && input.touches, {NameBeside(cut, planned), {beside}}, way);
      return line(far,
                  {planned ? MarkMessage("You leave the planned plane: the blade is {} beside it.")
                           : MarkMessage("You leave the line: the blade is {} beside it."),
                   {beside}},
                  way);
    }
    case CoachTopic::kTilted:
      return line(false, DescribeTilt(cut, deviation));
    case CoachTopic::kTooFast:
    case CoachTopic::kTooSlow:
      // A line that stays for a while must not be wrong meanwhile.
      if (!input.feed_mm_per_s ||
          (*input.feed_mm_per_s > input.wanted_feed_mm_per_s) != (*state.shown == CoachTopic::kTooFast)) {
        return {};
      }
      return line(false,
                  {*state.shown == CoachTopic::kTooFast ? MarkMessage("Slower: your feed is {0}, and {1} are wanted.")
                                                        : MarkMessage("Faster: your feed is {0}, and {1} are wanted."),
                   {Quantity{*input.feed_mm_per_s, 1, "mm/s"}, Quantity{input.wanted_feed_mm_per_s, 1, "mm/s"}}},
                  DescribeFeedChange(input));
    case CoachTopic::kCrossesNerve:
      if (input.nerve_mm.value_or(0) <= 0) {
        return line(false, {MarkMessage("The blade is in the nerve canal, which the planned plane crosses."), {}});
      }
      return line(false, {MarkMessage("The planned plane crosses the nerve canal, which is {} away."),
                          {Quantity{*input.nerve_mm, 1, "mm"}}});
  }
  return {};
}

std::size_t FindCurrentCut(const std::vector<WantedCut>& cuts, const std::vector<bool>& made, std::size_t current,
                           const Pose& X_WT, bool in_bone) {
  const auto distance_mm = [&](std::size_t i) { return cuts[i].CalcDistance(cuts[i].FindLowest(X_WT)); };
  if (in_bone && distance_mm(current) <= cuts[current].margin_mm) return current;
  std::optional<std::size_t> first;
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (made[i] && !in_bone) continue;
    if (!first) first = i;
    if (!nearest || distance_mm(i) < distance_mm(*nearest)) nearest = i;
  }
  if (!nearest) return current;
  if (in_bone || distance_mm(*nearest) <= kAtCut_mm) return *nearest;
  return made[current] ? *first : current;
}

double CalcDistanceFromCut(const WantedCut& cut, const Pose& X_WT) {
  const Vec3 p = cut.ToCut(X_WT.p_AB);
  const Vec3 nearest{std::clamp(p.x, 0.0, cut.length_mm),
                     std::clamp(p.y, -cut.below_mm, std::max(cut.depth_mm - cut.below_mm, -cut.below_mm)), 0};
  return glm::distance(p, nearest);
}

ExerciseStep FindStep(const WantedCut& cut, const CoachInput& input, DepthZone zone, bool spindle_on, double done) {
  if (done >= kWholeCut) return ExerciseStep::kFinish;
  if (CalcDistanceFromCut(cut, input.X_WT) > kStepFar_mm) return ExerciseStep::kReturn;
  if (FindOutside(cut, input, zone)) return ExerciseStep::kBeside;
  if (!spindle_on) return ExerciseStep::kSwitchOn;
  if (zone == DepthZone::kAbove) return ExerciseStep::kLower;
  return zone == DepthZone::kFar || zone == DepthZone::kNear ? ExerciseStep::kDeepen : ExerciseStep::kFollow;
}

StepLine DescribeStep(ExerciseStep step, const WantedCut& cut, const CoachInput& input, bool spindle_on, double done) {
  const Quantity percent{100 * done, 0, "%"};
  const bool planned = IsPlanned(input.kind);
  std::optional<StepLine> own;
  if (IsHole(cut)) own = DescribeHoleStep(step, cut, input);
  if (cut.plunges > 1) own = DescribePlungeStep(step, cut, input, done);
  if (own) return *std::move(own);
  switch (step) {
    case ExerciseStep::kReturn:
      return {{spindle_on ? MarkMessage("The saw is {} away from the cut. Switch the spindle off (Space) and press R: "
                                        "the saw returns to its start.")
                          : MarkMessage("The saw is {} away from the cut. Press R: the saw returns to its start."),
               {Quantity{CalcDistanceFromCut(cut, input.X_WT), 0, "mm"}}}};
    case ExerciseStep::kBeside:
      if (const std::optional<Outside> outside = FindOutside(cut, input, DepthZone::kAbove)) {
        return {outside->message, outside->way};
      }
      break;
    case ExerciseStep::kSwitchOn:
      return {{MarkMessage("The spindle is off: Space."), {}}};
    case ExerciseStep::kLower:
      if (planned && done >= kSomeDone) {
        return {
            {MarkMessage("Lower the blade into the bone again where the planned plane is not cut yet (Down key). {} "
                         "of it is cut."),
             {percent}}};
      }
      if (planned) return {{MarkMessage("Lower the blade into the bone in the planned plane (Down key)."), {}}};
      return {{MarkMessage("Lower the blade into the bone at one end of the line (Down key)."), {}}};
    case ExerciseStep::kDeepen:
      if (planned) {
        return {{MarkMessage(
                     "Go on slowly in the planned plane until the bone is cut through (Down key). {} of it is cut."),
                 {percent}}};
      }
      return {{MarkMessage("Go on slowly to the depth of {}. Press down (Down key) while you move along the line, too: "
                           "otherwise the blade climbs."),
               {Quantity{cut.depth_mm, 1, "mm"}}}};
    case ExerciseStep::kFollow: {
      const std::optional<Message> way = DescribeKeysAlong(input.keys, cut.along_W);
      // A cut that stays this far above its floor is never whole.
      const bool press = input.depth && input.depth->to_goal_mm > (1 - kWholeCut) * cut.depth_mm;
      if (planned) {
        return {
            {press ? MarkMessage("Deep enough here: go on in the planned plane to its other edge, and press down "
                                 "(Down key). {} of it is cut.")
                   : MarkMessage("Deep enough here: go on in the planned plane to its other edge. {} of it is cut."),
             {percent}},
            way};
      }
      return {
          {press ? MarkMessage("Deep enough: move along the line to its other end, and press down (Down key). {} of "
                               "it is done.")
                 : MarkMessage("Deep enough: move along the line to its other end. {} of it is done."),
           {percent}},
          way};
    }
    case ExerciseStep::kFinish:
      break;
  }
  if (!input.is_last_cut) {
    return {{MarkMessage("This cut is made: lift the blade out (Up key). With the spindle off (Space), R brings it to "
                         "the next one."),
             {}}};
  }
  if (planned)
    return {{MarkMessage("The planned cut is made: lift the blade out (Up key) and finish the exercise (Enter)."), {}}};
  return {{MarkMessage("The whole line is cut: lift the blade out (Up key) and finish the exercise (Enter)."), {}}};
}

double CalcZoneNear_mm(double goal_mm) {
  return std::clamp(0.25 * goal_mm, 0.5, 1.0);
}

DepthZone FindDepthZone(const DepthReading& reading, DepthZone before) {
  if (reading.depth_mm <= 0) return DepthZone::kAbove;
  if (reading.to_goal_mm < -kZoneBad_mm) return DepthZone::kTooDeep;
  if (reading.to_goal_mm < -kZoneReached_mm * (IsDeep(before) ? kCoachRelease : 1)) return DepthZone::kDeep;
  if (reading.to_goal_mm <= kZoneReached_mm) return DepthZone::kReached;
  const double near_mm = CalcZoneNear_mm(reading.depth_mm + reading.to_goal_mm);
  return reading.to_goal_mm < near_mm ? DepthZone::kNear : DepthZone::kFar;
}

DepthAdvice MakeDepthAdvice(const CoachState& state, bool rests) {
  DepthAdvice advice{.zone = state.zone};
  // A line stays for a while; until then, the gauge says the same.
  if (state.shown == CoachTopic::kTooDeep && !IsDeep(advice.zone)) advice.zone = DepthZone::kDeep;
  if (state.shown == CoachTopic::kInNerve || state.shown == CoachTopic::kNearNerve) {
    advice.stop = true;
    advice.text = state.shown == CoachTopic::kInNerve ? MarkMessage("stop: in the nerve canal")
                                                      : MarkMessage("no deeper: nerve canal");
    return advice;
  }
  advice.beside =
      state.on[IndexOf(CoachTopic::kBesideLine)] && advice.zone != DepthZone::kAbove && !IsDeep(advice.zone);
  if (advice.beside) {
    advice.text = MarkMessage("beside the wanted cut");
    return advice;
  }
  switch (advice.zone) {
    case DepthZone::kAbove:
      advice.text = MarkMessage("above the bone");
      break;
    case DepthZone::kFar:
      advice.text = MarkMessage("continue");
      break;
    case DepthZone::kNear:
      advice.text = rests ? MarkMessage("nearly deep enough") : MarkMessage("slow down");
      break;
    case DepthZone::kReached:
      advice.text = MarkMessage("deep enough");
      break;
    case DepthZone::kDeep:
    case DepthZone::kTooDeep:
      advice.text = MarkMessage("too deep");
      break;
  }
  return advice;
}

bool IsHoleMade(const DepthGauge& gauge, double deepest_mm) {
  const WantedCut& hole = gauge.cut();
  const std::vector<CutColumn>& columns = gauge.columns();
  const auto axis = std::min_element(columns.begin(), columns.end(), [](const CutColumn& a, const CutColumn& b) {
    return std::abs(a.s_mm) < std::abs(b.s_mm);
  });
  if (axis == columns.end()) return false;
  const double through_mm = axis->far_mm - axis->near_mm + (hole.solid ? hole.solid->corner_z_mm : 0);
  return deepest_mm >= std::min(hole.depth_mm - kStepDepth_mm, through_mm);
}

}  // namespace kerf
