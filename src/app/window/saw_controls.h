// Maps keys and mouse to the wanted pose of the saw. Independent of any window: events in, pose out.
#pragma once

#include <optional>
#include <set>
#include <utility>

#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "view/ui/event.h"

namespace kerf {

/// Directions of the picture in the world, unit length and right-handed, and its scale at the saw.
struct ViewBasis {
  Vec3 right_W{1, 0, 0};
  Vec3 up_W{0, 0, 1};
  Vec3 forward_W{0, 1, 0};  // from the eye into the picture
  double mm_per_pixel = 0.1;
};

/// Returns the directions in which keys and mouse move the saw along the axes of a cut rather than those of the
/// picture: up is exactly against `into_W`, and right is the direction along or across the cut that is closest to the
/// picture's. `along_W`: perpendicular to `into_W`; both have unit length.
ViewBasis AlignWithCut(const ViewBasis& view, const Vec3& along_W, const Vec3& into_W);

/// Arrow and page keys move the saw, and W, A, S, D, Q and E turn it. The mouse drags it in the picture's plane, with
/// Shift into the picture, and with Control turns it. When the last key or button is released, the user has let go, and
/// the wanted pose is where the saw is. Each key moves the saw at the same speed, also together with others and while
/// another one presses it against something.
class SawControls {
 public:
  /// Maximum distance of the wanted pose from the saw, equal to the reach of the mouse's hand.
  static constexpr double kLead_mm = 14;
  static constexpr double kLead_rad = 0.35;
  /// A saw that has been let go in air may complete a motion of this length, as in MouseHandParams.
  static constexpr double kCoast_mm = 1;
  static constexpr double kCoast_rad = 0.05;

  explicit SawControls(const Pose& X_WT) : X_wanted_(X_WT) {}

  /// Returns true if the event was for the saw.
  bool Take(const WindowEvent& event, const ViewBasis& view);
  /// Advances the wanted pose by `dt_s` with the keys that are held. `X_WT`: pose of the saw. `touches`: a force acts
  /// on the saw.
  void Advance(double dt_s, const ViewBasis& view, const Pose& X_WT, bool touches = true);
  /// Releases all keys and buttons, and cancels Set().
  void Release();
  /// Sets the wanted pose immediately, at any distance, until Release() or the user's next motion.
  void Set(const Pose& X_WT) { X_wanted_ = *(X_set_ = X_WT); }
  /// Call when another session continues with the saw at this pose. Releases all keys and buttons, but keeps Set().
  void Continue(const Pose& X_WT);

  const Pose& wanted() const { return X_wanted_; }
  /// True from Set() until the user moves the saw or lets go of it.
  bool has_goal() const { return X_set_.has_value(); }
  /// False if the user has let go of the saw, so that nothing may pull it.
  bool holds() const { return X_set_ || dragging_ || !held_.empty(); }
  double feed_mm_per_s() const { return feed_mm_per_s_; }
  /// Speed of motion by keys.
  static constexpr Range kFeedRange_mm_per_s{0.5, 20};
  void set_feed_mm_per_s(double feed) { feed_mm_per_s_ = kFeedRange_mm_per_s.Clamp(feed); }
  /// Restricts motion to the blade's plane and rotation to the spindle axis, which keeps a straight cut straight.
  bool in_blade_plane() const { return in_blade_plane_; }
  void set_in_blade_plane(bool on) { in_blade_plane_ = on; }
  /// Replaces the blade's plane by this one for the restriction; none: the blade's. From beside the plane, the saw can
  /// be moved towards it, but not away from it or beyond it.
  void set_lock_plane(const std::optional<CutPlane>& plane) { lock_plane_ = plane; }
  bool has_lock_plane() const { return lock_plane_.has_value(); }
  /// Returns true once after a key was pressed whose motion the restriction does not permit.
  bool TakeHeldByLock() { return std::exchange(held_by_lock_, false); }

 private:
  bool IsHeldByLock(Key key, const ViewBasis& view) const;
  void Move(const Vec3& by_W);
  Vec3 LimitToLock(const Vec3& by_W) const;
  Vec3 LockNormal() const;
  void Turn(const Vec3& by_W_rad);
  void FollowSaw(const Pose& X_WT, bool touches);

  Pose X_wanted_;
  std::optional<Pose> X_set_;
  std::set<Key> held_;
  bool dragging_ = false;
  double last_x_ = 0;
  double last_y_ = 0;
  bool fast_ = false;
  double feed_mm_per_s_ = 4;
  bool in_blade_plane_ = false;
  std::optional<CutPlane> lock_plane_;
  bool held_by_lock_ = false;
};

}  // namespace kerf
