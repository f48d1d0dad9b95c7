// Advice while a cut is made: one line at a time, without flicker, and the steps of an exercise. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/core/message.h"
#include "kerf/geometry.h"
#include "session/scene/exercise.h"
#include "session/score/columns.h"

namespace kerf {

/// What there is to say, the most urgent first.
enum class CoachTopic {
  kInNerve,
  kNearNerve,
  kTooDeep,
  kBesideLine,
  kBeyondEnd,
  kTilted,
  kTooFast,
  kTooSlow,
  kCrossesNerve
};
inline constexpr std::size_t kCoachTopics = 9;

/// Where the blade is relative to the wanted depth.
enum class DepthZone { kAbove, kFar, kNear, kReached, kDeep, kTooDeep };
/// Distance around the goal within which the depth is good, and beyond it from which the cut is bad.
inline constexpr double kZoneReached_mm = 0.3;
inline constexpr double kZoneBad_mm = 1.0;
/// Returns the distance before a goal from which the student should slow down: a quarter of the depth, 0.5 to 1 mm.
double CalcZoneNear_mm(double goal_mm);
/// Returns the zone of a depth. `before`: the zone so far; a blade that was too deep is so until it is kCoachRelease of
/// the limit deep, so that the zone does not flicker.
DepthZone FindDepthZone(const DepthReading& reading, DepthZone before = DepthZone::kAbove);

/// Directions in which the arrow keys move the saw, as the student sees them, unit length.
struct KeyDirections {
  Vec3 right_W{1, 0, 0};
  Vec3 up_W{0, 0, 1};
};

struct CoachInput {
  ExerciseKind kind = ExerciseKind::kGroove;
  double time_s = 0;
  Pose X_WT;
  std::optional<DepthReading> depth;    // none: the tool is beside the wanted cut
  std::optional<double> nerve_mm;       // distance to the nerve canal; none: unknown, or no canal
  bool crosses_nerve = false;           // the wanted cuts cross the nerve canal: RegionDistance::CalcFrom()
  bool touches = false;                 // the tool touches bone
  std::optional<KeyDirections> keys;    // to say the way back in; none: it is not said
  std::optional<double> feed_mm_per_s;  // along the line, of FeedMeter; none: it does not follow the line
  double wanted_feed_mm_per_s = 0;      // 0: any
  double key_feed_mm_per_s = 0;         // with which keys move the saw
  double force_N = 0;                   // on the hand
  bool is_last_cut = true;              // no other cut or hole of the exercise is left to make
};

/// Which topics are current. Initially none.
struct CoachState {
  std::array<bool, kCoachTopics> on{};
  std::optional<CoachTopic> shown{};  // the line that is shown
  double shown_since_s = 0;
  DepthZone zone = DepthZone::kAbove;  // of the blade's depth; kAbove also beside the wanted cut

  bool operator==(const CoachState&) const = default;
};

/// A topic begins beyond its limit and ends at kCoachRelease of it, so that a line does not flicker at the limit; a
/// line stays for at least kCoachHold_s unless a more urgent one replaces it.
inline constexpr double kCoachRelease = 0.7;
inline constexpr double kCoachHold_s = 0.6;
/// Limits. The limit beside the line is the exercise's margin.
inline constexpr double kCoachNerve_mm = 2;
inline constexpr double kCoachTilt_deg = 6;
/// Height above the surface up to which a blade beside the line is said to be so: it is about to be lowered.
inline constexpr double kCoachHover_mm = 4;

struct CoachLine {
  CoachTopic topic = CoachTopic::kInNerve;
  bool urgent = false;  // stop, rather than correct
  Message message;
  std::optional<Message>
      way;  // what to do: the way to the wanted cut, as the student sees it, or what changes the feed

  bool operator==(const CoachLine&) const = default;
};

/// How the tool lies relative to the wanted cut.
struct ToolDeviation {
  double beside_mm = 0;  // of the tool's lowest point from the wanted plane, along WantedCut::across_W, or from the
                         // axis of the hole
  Vec3 beside_W{0};      // the same as a vector; world frame
  double beyond_mm = 0;  // of the lowest point beyond an end of the line; 0 between the ends, and of a hole
  bool before_start = false;  // beyond_mm is that at the line's start
  double below_mm = 0;        // of the lowest point below the wanted depth, as if the line were on a plane; 0 above it
  double tilt_deg = 0;        // WantedCut::CalcTilt_deg()
};
ToolDeviation CalcDeviation(const WantedCut& cut, const Pose& X_WT);

/// Returns the next state.
CoachState UpdateCoach(const CoachState& state, const WantedCut& cut, const CoachInput& input);
/// Returns the line to show in a state that UpdateCoach() returned for the same input; none if all is well.
std::optional<CoachLine> MakeCoachLine(const CoachState& state, const WantedCut& cut, const CoachInput& input);

/// Steps of an exercise, for a student who does it for the first time.
enum class ExerciseStep { kReturn, kBeside, kSwitchOn, kLower, kDeepen, kFollow, kFinish };

/// An instruction for a step.
struct StepLine {
  Message message;
  std::optional<Message> way = {};  // to the wanted cut, as the student sees it
};

/// Distance from the wanted depth from which a hole counts as made.
inline constexpr double kStepDepth_mm = 0.3;
/// Distance from the wanted cut from which the saw is lost: it may be out of the picture.
inline constexpr double kStepFar_mm = 30;

/// Distance beside a cut from which the tool is at it, in the air.
inline constexpr double kAtCut_mm = 3;
/// Returns the index of the cut that the advice is about. In the bone, that is the cut so far while the tool is in it,
/// and otherwise the nearest. In the air, it is the nearest one that is not made if the tool is at it, and otherwise
/// the one so far or, if that is made, the first that is not; the one so far if all are. `cuts`: at least one; `made`:
/// for each, whether it is.
std::size_t FindCurrentCut(const std::vector<WantedCut>& cuts, const std::vector<bool>& made, std::size_t current,
                           const Pose& X_WT, bool in_bone);

/// Returns the distance of the tool's centre from the places that it takes in the wanted cut and above it, up to where
/// it leaves the bone.
double CalcDistanceFromCut(const WantedCut& cut, const Pose& X_WT);
/// Returns the step that comes next. `done`: fraction of what is to be cut, as in the score: CutArea::share(), or of a
/// hole 1 from IsHoleMade() on. `zone`: CoachState::zone.
ExerciseStep FindStep(const WantedCut& cut, const CoachInput& input, DepthZone zone, bool spindle_on, double done);
/// Returns the instruction for a step that FindStep() returned.
StepLine DescribeStep(ExerciseStep step, const WantedCut& cut, const CoachInput& input, bool spindle_on, double done);
/// Returns true if a hole is as deep as wanted, to within kStepDepth_mm, or goes through the bone over the drill's
/// whole width. `deepest_mm`: largest depth of the drill's tip below the surface.
bool IsHoleMade(const DepthGauge& gauge, double deepest_mm);

/// What the gauge says about the depth. It agrees with the line that MakeCoachLine() returns for the same state.
struct DepthAdvice {
  DepthZone zone = DepthZone::kAbove;
  bool stop = false;      // whatever the depth, the blade must not go deeper
  bool beside = false;    // the depth is not that of the wanted cut
  const char* text = "";  // in English
};
/// `rests`: the saw does not move, so that it cannot slow down.
DepthAdvice MakeDepthAdvice(const CoachState& state, bool rests);

}  // namespace kerf
