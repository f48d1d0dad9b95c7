#include "session/hand_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

/// A hand neither starts nor stops nor pushes at once.
constexpr double kGentle_s = 0.1;
/// Share of the resistance that it feels, with which it leans into it. Below 1: else it would lean ever harder against
/// a wall.
constexpr double kLean = 0.8;
constexpr double kLean_s = 0.3;
/// At the end of a stroke it waits for the tool to come there, to a share of `lead_mm`, but not for ever.
constexpr double kThere = 0.1;
constexpr double kPatience_s = 5;
/// Of the path, either way, for the direction of a stroke.
constexpr double kAhead_s = 0.01;

}  // namespace

HandMotion::HandMotion(SimulatedDevice& device, Path path, const SceneHand& hand, const Vec3& p_TC_mm)
    : device_(device), path_(std::move(path)), hand_(hand), p_TC_mm_(p_TC_mm), X_aim_(start()) {
  device_.SetIntention({.X_WH = X_aim_});
}

/// Of the tool along a segment as the path has it, mm/s; never 0.
double HandMotion::CalcSpeed(std::size_t segment) const {
  const PathSegment& s = path_.segments()[segment];
  const double way_mm = glm::distance(path_.CalcPose(segment, s.start_s).p_AB, path_.CalcPose(segment, s.end_s).p_AB);
  return std::max(way_mm / (s.end_s - s.start_s), 1e-3);
}

void HandMotion::EnterNextChain() noexcept {
  std::size_t next = first_ + 1;
  while (next < path_.segments().size() && !path_.segments()[next].retract_before) ++next;
  if (next >= path_.segments().size()) {
    next = 0;
    ++rounds_;
  }
  first_ = segment_ = next;
  t_s_ = path_.segments()[next].start_s;
  X_from_ = X_aim_;
  share_ = 0;
  waited_s_ = 0;
  phase_ = Phase::kOver;
}

void HandMotion::Advance(double dt_s) noexcept {
  // The farther the handle lags behind the aim, the slower; at `lead_mm` it waits.
  const double lag_mm = glm::distance(X_aim_.Point(p_TC_mm_), device_.p_WC_mm());
  const double wanted = std::clamp(2 * (1 - lag_mm / hand_.lead_mm), 0.0, 1.0);
  const double gentle = -std::expm1(-dt_s / kGentle_s);
  pace_ += gentle * (wanted - pace_);

  const Pose X_before = X_aim_;
  const std::vector<PathSegment>& segments = path_.segments();
  Vec3 push_W_N{0};
  switch (phase_) {
    case Phase::kCut: {
      t_s_ += pace_ * dt_s;
      if (t_s_ >= segments[segment_].end_s) {
        t_s_ = segments[segment_].end_s;
        const bool goes_on = segment_ + 1 < segments.size() && !segments[segment_ + 1].retract_before;
        if (goes_on) {
          ++segment_;
        } else {
          waited_s_ += dt_s;
          if (lag_mm <= kThere * hand_.lead_mm || waited_s_ >= kPatience_s) phase_ = Phase::kBack;
        }
      }
      X_aim_ = path_.CalcPose(segment_, t_s_);
      const Vec3 ahead =
          path_.CalcPose(segment_, t_s_ + kAhead_s).p_AB - path_.CalcPose(segment_, t_s_ - kAhead_s).p_AB;
      const double length = glm::length(ahead);
      if (length > 1e-12) {
        const Vec3 way = ahead / length;
        const double felt_N = std::max(-glm::dot(device_.force_N(), way), 0.0);
        push_W_N = std::min(hand_.push_N, kLean * felt_N) * way;
      }
      break;
    }
    case Phase::kBack: {
      const double speed_mm_per_s = CalcSpeed(segment_);
      t_s_ -= pace_ * dt_s * hand_.lift_mm_per_s / speed_mm_per_s;
      if (t_s_ <= segments[segment_].start_s) {
        t_s_ = segments[segment_].start_s;
        if (segment_ > first_) --segment_;
      }
      X_aim_ = path_.CalcPose(segment_, t_s_);
      if (segment_ == first_ && t_s_ <= segments[first_].start_s) EnterNextChain();
      break;
    }
    case Phase::kOver: {
      const Pose X_to = path_.CalcPose(segment_, t_s_);
      const double way_mm = std::max(glm::distance(X_from_.p_AB, X_to.p_AB), 1.0);
      share_ = std::min(share_ + pace_ * dt_s * hand_.lift_mm_per_s / way_mm, 1.0);
      X_aim_ = {glm::slerp(X_from_.R_AB, X_to.R_AB, share_), glm::mix(X_from_.p_AB, X_to.p_AB, share_)};
      if (share_ >= 1) {
        phase_ = Phase::kCut;
        ++strokes_;
      }
      break;
    }
  }
  push_W_N_ += -std::expm1(-dt_s / kLean_s) * (push_W_N - push_W_N_);
  Intention intention;
  intention.X_WH = X_aim_;
  intention.v_W_mm_per_s = (X_aim_.Point(p_TC_mm_) - X_before.Point(p_TC_mm_)) / dt_s;
  intention.push_W_N = push_W_N_;
  device_.SetIntention(intention);
}

}  // namespace kerf
