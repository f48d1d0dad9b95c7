#include "app/window/saw_controls.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

constexpr double kTurnByKey_rad_per_s = 0.35;
constexpr double kTurnByPixel_rad = 0.004;
constexpr double kFast = 6;

/// Motion of a key along the picture's right, up and forward directions, and rotation about these.
struct KeyMotion {
  Key key;
  Vec3 move;
  Vec3 turn;
};
const std::array<KeyMotion, 12>& Motions() {
  static const std::array<KeyMotion, 12> motions{{
      {Key::kLeft, {-1, 0, 0}, {0, 0, 0}},
      {Key::kRight, {1, 0, 0}, {0, 0, 0}},
      {Key::kUp, {0, 1, 0}, {0, 0, 0}},
      {Key::kDown, {0, -1, 0}, {0, 0, 0}},
      {Key::kPageUp, {0, 0, 1}, {0, 0, 0}},
      {Key::kPageDown, {0, 0, -1}, {0, 0, 0}},
      {Key::kW, {0, 0, 0}, {-1, 0, 0}},
      {Key::kS, {0, 0, 0}, {1, 0, 0}},
      {Key::kA, {0, 0, 0}, {0, 1, 0}},
      {Key::kD, {0, 0, 0}, {0, -1, 0}},
      {Key::kQ, {0, 0, 0}, {0, 0, -1}},
      {Key::kE, {0, 0, 0}, {0, 0, 1}},
  }};
  return motions;
}

Vec3 InWorld(const Vec3& v, const ViewBasis& view) {
  return v.x * view.right_W + v.y * view.up_W + v.z * view.forward_W;
}

/// Returns v_W, shortened to a length by limiting its largest components in the view's directions: a saw that is
/// pressed in one direction with the greatest force still moves in another one.
Vec3 LimitLength(const Vec3& v_W, const ViewBasis& view, double length) {
  if (glm::length(v_W) <= length) return v_W;
  std::array<double, 3> v{glm::dot(v_W, view.right_W), glm::dot(v_W, view.up_W), glm::dot(v_W, view.forward_W)};
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return std::abs(v[a]) < std::abs(v[b]); });
  double left = length * length;
  for (std::size_t i = 0; i < 3; ++i) {
    const double limit = std::sqrt(left / static_cast<double>(3 - i));
    double& component = v[order[i]];
    component = std::clamp(component, -limit, limit);
    left -= component * component;
  }
  return InWorld({v[0], v[1], v[2]}, view);
}

}  // namespace

ViewBasis AlignWithCut(const ViewBasis& view, const Vec3& along_W, const Vec3& into_W) {
  ViewBasis aligned = view;
  aligned.up_W = -into_W;
  const Vec3 across_W = glm::cross(into_W, along_W);
  const double along = glm::dot(along_W, view.right_W);
  const double across = glm::dot(across_W, view.right_W);
  aligned.right_W =
      std::abs(along) >= std::abs(across) ? (along < 0 ? -along_W : along_W) : (across < 0 ? -across_W : across_W);
  aligned.forward_W = glm::cross(aligned.up_W, aligned.right_W);
  return aligned;
}

bool SawControls::Take(const WindowEvent& event, const ViewBasis& view) {
  using Kind = WindowEvent::Kind;
  const auto is_motion = [](Key key) {
    return std::any_of(Motions().begin(), Motions().end(), [key](const KeyMotion& m) { return m.key == key; });
  };
  switch (event.kind) {
    case Kind::kKeyDown:
      if (!is_motion(event.key) || event.control || event.alt) return false;
      if (held_.insert(event.key).second) held_by_lock_ = IsHeldByLock(event.key, view);
      fast_ = event.shift;
      return true;
    case Kind::kKeyUp:
      fast_ = event.shift && fast_;
      if (held_.erase(event.key) == 0) return false;
      if (!dragging_ && held_.empty()) X_set_.reset();
      return true;
    case Kind::kMouseDown:
      if (event.button != MouseButton::kLeft) return false;
      dragging_ = true;
      last_x_ = event.x;
      last_y_ = event.y;
      return true;
    case Kind::kMouseUp:
      if (event.button != MouseButton::kLeft || !dragging_) return false;
      dragging_ = false;
      if (held_.empty()) X_set_.reset();
      return true;
    case Kind::kMouseMove: {
      if (!dragging_) return false;
      X_set_.reset();  // from here on, the user moves the saw
      const double dx = event.x - last_x_;
      const double dy = last_y_ - event.y;  // positive upwards
      last_x_ = event.x;
      last_y_ = event.y;
      if (event.control) {
        Turn(kTurnByPixel_rad * (dx * view.up_W - dy * view.right_W));
      } else if (event.shift) {
        Move(view.mm_per_pixel * dy * view.forward_W);
      } else {
        Move(view.mm_per_pixel * (dx * view.right_W + dy * view.up_W));
      }
      return true;
    }
    default:
      return false;
  }
}

void SawControls::Release() {
  held_.clear();
  dragging_ = false;
  fast_ = false;
  X_set_.reset();
}

void SawControls::Continue(const Pose& X_WT) {
  const std::optional<Pose> X_set = X_set_;
  Release();
  X_wanted_ = X_WT;
  X_set_ = X_set;
}

Vec3 SawControls::LockNormal() const {
  return lock_plane_ ? lock_plane_->normal_W : X_wanted_.Vector({0, 0, 1});
}

/// Returns what the restriction permits of a motion.
Vec3 SawControls::LimitToLock(const Vec3& by_W) const {
  if (!in_blade_plane_) return by_W;
  const Vec3 normal_W = LockNormal();
  const double across = glm::dot(by_W, normal_W);
  const double to_plane = lock_plane_ ? glm::dot(lock_plane_->p_W - X_wanted_.p_AB, normal_W) : 0;
  return by_W + (std::clamp(across, std::min(to_plane, 0.0), std::max(to_plane, 0.0)) - across) * normal_W;
}

bool SawControls::IsHeldByLock(Key key, const ViewBasis& view) const {
  constexpr double kNone = 1e-6;  // of a motion of 1 mm or 1 rad
  if (!in_blade_plane_) return false;
  return std::any_of(Motions().begin(), Motions().end(), [&](const KeyMotion& m) {
    if (m.key != key) return false;
    return glm::length(m.move) > 0 ? glm::length(LimitToLock(InWorld(m.move, view))) < kNone
                                   : std::abs(glm::dot(InWorld(m.turn, view), LockNormal())) < kNone;
  });
}

void SawControls::Move(const Vec3& by_W) {
  X_wanted_.p_AB += LimitToLock(by_W);
}

void SawControls::Turn(const Vec3& by_W_rad) {
  Vec3 by = by_W_rad;
  if (in_blade_plane_) by = glm::dot(by, LockNormal()) * LockNormal();
  const double angle = glm::length(by);
  if (angle < 1e-12) return;
  X_wanted_.R_AB = glm::normalize(glm::angleAxis(angle, by / angle) * X_wanted_.R_AB);
}

void SawControls::FollowSaw(const Pose& X_WT, bool touches) {
  // In air a short motion is completed, so that short presses of a key add up although the handle has friction.
  const double cosine = std::abs(glm::dot(X_wanted_.R_AB, X_WT.R_AB));
  const bool far = glm::distance(X_wanted_.p_AB, X_WT.p_AB) > kCoast_mm || cosine < std::cos(0.5 * kCoast_rad);
  if (touches || far) X_wanted_ = X_WT;
}

void SawControls::Advance(double dt_s, const ViewBasis& view, const Pose& X_WT, bool touches) {
  if (!holds()) return FollowSaw(X_WT, touches);
  if (!held_.empty()) X_set_.reset();
  if (X_set_) X_wanted_ = *X_set_;  // however far it is
  dt_s = std::clamp(dt_s, 0.0, 0.1);
  Vec3 move{0};
  Vec3 turn{0};
  for (const KeyMotion& m : Motions()) {
    if (!held_.contains(m.key)) continue;
    move += m.move;
    turn += m.turn;
  }
  // In the bone, a fast saw would slip rather than cut.
  const double pace = dt_s * (fast_ && !touches ? kFast : 1);
  for (const Vec3& axis : {Vec3{move.x, 0, 0}, Vec3{0, move.y, 0}, Vec3{0, 0, move.z}}) {
    if (axis == Vec3{0}) continue;
    const Vec3 direction_W = InWorld(axis, view);
    // What holds the saw back has let the wanted pose run ahead of it. The way back begins at the saw.
    const double ahead_mm = glm::dot(X_WT.p_AB - X_wanted_.p_AB, direction_W);
    if (touches && ahead_mm > 0) Move(ahead_mm * direction_W);
    Move(pace * feed_mm_per_s_ * direction_W);
  }
  if (glm::length(turn) > 0) Turn(pace * kTurnByKey_rad_per_s * InWorld(glm::normalize(turn), view));

  // If the bone holds the saw back, the wanted pose waits for it.
  X_wanted_.p_AB = X_WT.p_AB + LimitLength(X_wanted_.p_AB - X_WT.p_AB, view, kLead_mm);
  Quat R = X_wanted_.R_AB;
  if (glm::dot(R, X_WT.R_AB) < 0) R = -R;
  const double angle = 2 * std::acos(std::clamp(glm::dot(R, X_WT.R_AB), -1.0, 1.0));
  if (angle > kLead_rad) X_wanted_.R_AB = glm::normalize(glm::slerp(X_WT.R_AB, R, kLead_rad / angle));
}

}  // namespace kerf
