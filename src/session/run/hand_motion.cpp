#include "session/run/hand_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

/// Time constant of the changes of the hand's pace.
constexpr double kSmoothing_s = 0.1;
/// Force with which the hand presses against a resistance that it feels, as a fraction of that resistance. It must be
/// below 1, because the force against a wall would otherwise grow without limit.
constexpr double kPushFraction = 0.8;
constexpr double kPush_s = 0.3;
/// At the end of a stroke the hand waits for the tool to arrive within this fraction of `lead_mm`, for a limited time.
constexpr double kArrivalFraction = 0.03;
constexpr double kMaxWait_s = 5;
/// Within kFadeFraction times `lead_mm` (0.2 to 2 mm) of a stroke's end the hand's force fades out, and it stops there.
/// It approaches the end at most at a speed that would cover the remaining distance in kStop_s; above that speed it is
/// braked by a damper of kStopDamping * mass / kStop_s.
constexpr double kStop_s = 0.15;
constexpr double kStopDamping = 8;
constexpr double kFadeFraction = 0.1;
constexpr double kMinFade_mm = 0.2;
constexpr double kMaxFade_mm = 2;
/// Path time before and after the current position over which the direction of a stroke is computed.
constexpr double kAhead_s = 0.01;

}  // namespace

HandMotion::HandMotion(SimulatedDevice& device, Path path, const SceneHand& hand, const Vec3& p_TC_mm,
                       double felt_stiffness_N_per_mm)
    : device_(device),
      path_(std::move(path)),
      hand_(hand),
      p_TC_mm_(p_TC_mm),
      felt_stiffness_N_per_mm_(felt_stiffness_N_per_mm),
      X_aim_(start()) {
  device_.SetIntention({.X_WH = X_aim_});
}

/// Returns the speed of the tool along a segment of the path, mm/s; never 0.
double HandMotion::CalcSpeed(std::size_t segment) const {
  const PathSegment& s = path_.segments()[segment];
  const double distance_mm =
      glm::distance(path_.CalcPose(segment, s.start_s).p_AB, path_.CalcPose(segment, s.end_s).p_AB);
  return std::max(distance_mm / (s.end_s - s.start_s), 1e-3);
}

bool HandMotion::IsLastOfChain() const noexcept {
  return segment_ + 1 >= path_.segments().size() || path_.segments()[segment_ + 1].retract_before;
}

/// Returns the distance along the stroke to its end, mm, from the handle or the tool, whichever is farther ahead.
/// Negative beyond the end.
double HandMotion::CalcDistanceLeft() const noexcept {
  const Vec3 p_end = path_.CalcPose(segment_, path_.segments()[segment_].end_s).Point(p_TC_mm_);
  // During the return the last direction of the stroke is used, otherwise the current one.
  const Vec3 p_from = phase_ == Phase::kReturn ? p_end : X_aim_.Point(p_TC_mm_);
  // A tool ahead of the handle pulls the handle forward.
  const double tool_ahead_mm = std::max(glm::dot(device_.force_N(), direction_W_), 0.0) / felt_stiffness_N_per_mm_;
  return glm::dot(p_from - device_.p_WC_mm(), direction_W_) + glm::distance(p_from, p_end) - tool_ahead_mm;
}

/// Returns the braking force near a stroke's end, N along the stroke.
double HandMotion::CalcStop(double left_mm) const noexcept {
  const double mass = 1e-3 * (device_.profile().mass_kg + device_.hand().mass_kg);  // N s^2 / mm
  const double speed = glm::dot(device_.v_WC_mm_per_s(), direction_W_);
  const double too_fast = std::max(speed - left_mm / kStop_s, 0.0);
  return -kStopDamping * mass / kStop_s * too_fast;
}

void HandMotion::EnterNextChain() noexcept {
  std::size_t next = first_ + 1;
  while (next < path_.segments().size() && !path_.segments()[next].retract_before) ++next;
  if (next >= path_.segments().size()) {
    next = 0;
    ++passes_;
  }
  first_ = segment_ = next;
  t_s_ = path_.segments()[next].start_s;
  X_from_ = X_aim_;
  fraction_ = 0;
  waited_s_ = 0;
  phase_ = Phase::kTransfer;
}

void HandMotion::JoinFrom(const Pose& X_WH) {
  device_.Place(X_WH);
  first_ = segment_ = 0;
  t_s_ = path_.segments().front().start_s;
  X_from_ = X_aim_ = X_WH;
  push_W_N_ = Vec3{0};
  fraction_ = waited_s_ = 0;
  passes_ = strokes_ = 0;
  phase_ = Phase::kJoin;
}

Vec3 HandMotion::AdvanceCut(double dt_s) noexcept {
  t_s_ += pace_ * dt_s;
  if (t_s_ >= path_.segments()[segment_].end_s) {
    t_s_ = path_.segments()[segment_].end_s;
    if (!IsLastOfChain()) {
      ++segment_;
    } else {
      waited_s_ += dt_s;
      if (CalcDistanceLeft() <= kArrivalFraction * hand_.lead_mm || waited_s_ >= kMaxWait_s) phase_ = Phase::kReturn;
    }
  }
  X_aim_ = path_.CalcPose(segment_, t_s_);
  const Vec3 ahead = path_.CalcPose(segment_, t_s_ + kAhead_s).p_AB - path_.CalcPose(segment_, t_s_ - kAhead_s).p_AB;
  const double length = glm::length(ahead);
  if (!(length > 1e-12)) return Vec3{0};
  direction_W_ = ahead / length;
  const double felt_N = std::max(-glm::dot(device_.force_N(), direction_W_), 0.0);
  return std::min(hand_.push_N, kPushFraction * felt_N) * direction_W_;
}

void HandMotion::AdvanceReturn(double dt_s) noexcept {
  const std::vector<PathSegment>& segments = path_.segments();
  const double speed_mm_per_s = CalcSpeed(segment_);
  t_s_ -= pace_ * dt_s * hand_.lift_mm_per_s / speed_mm_per_s;
  if (t_s_ <= segments[segment_].start_s) {
    t_s_ = segments[segment_].start_s;
    if (segment_ > first_) --segment_;
  }
  X_aim_ = path_.CalcPose(segment_, t_s_);
  if (segment_ == first_ && t_s_ <= segments[first_].start_s) EnterNextChain();
}

void HandMotion::AdvanceToStroke(double dt_s) noexcept {
  const Pose X_to = path_.CalcPose(segment_, t_s_);
  const double distance_mm = std::max(glm::distance(X_from_.p_AB, X_to.p_AB), 1.0);
  const double moved = phase_ == Phase::kJoin ? dt_s / kJoin_s : pace_ * dt_s * hand_.lift_mm_per_s / distance_mm;
  fraction_ = std::min(fraction_ + moved, 1.0);
  X_aim_ = {glm::slerp(X_from_.R_AB, X_to.R_AB, fraction_), glm::mix(X_from_.p_AB, X_to.p_AB, fraction_)};
  if (!(fraction_ >= 1)) return;
  ++strokes_;
  phase_ = Phase::kCut;
}

void HandMotion::Advance(double dt_s) noexcept {
  // The farther the handle lags behind the target, the slower the hand moves; at `lead_mm` it waits.
  const double lag_mm = glm::distance(X_aim_.Point(p_TC_mm_), device_.p_WC_mm());
  const double wanted = std::clamp(2 * (1 - lag_mm / hand_.lead_mm), 0.0, 1.0);
  const double smoothing = -std::expm1(-dt_s / kSmoothing_s);
  pace_ += smoothing * (wanted - pace_);

  const Pose X_before = X_aim_;
  Vec3 push_W_N{0};
  switch (phase_) {
    case Phase::kCut:
      push_W_N = AdvanceCut(dt_s);
      break;
    case Phase::kReturn:
      AdvanceReturn(dt_s);
      break;
    case Phase::kTransfer:
    case Phase::kJoin:
      AdvanceToStroke(dt_s);
      break;
  }
  push_W_N_ += -std::expm1(-dt_s / kPush_s) * (push_W_N - push_W_N_);
  // The hand may still be moving when it turns back.
  double fade = 1;
  Vec3 stop_W_N{0};
  if (phase_ != Phase::kTransfer && phase_ != Phase::kJoin && IsLastOfChain()) {
    const double left_mm = CalcDistanceLeft();
    fade = std::clamp(left_mm / std::clamp(kFadeFraction * hand_.lead_mm, kMinFade_mm, kMaxFade_mm), 0.0, 1.0);
    stop_W_N = CalcStop(left_mm) * direction_W_;
  }
  Intention intention;
  intention.X_WH = X_aim_;
  intention.v_W_mm_per_s = (X_aim_.Point(p_TC_mm_) - X_before.Point(p_TC_mm_)) / dt_s;
  intention.push_W_N = fade * push_W_N_ + stop_W_N;
  device_.SetIntention(intention);
}

}  // namespace kerf
