// Keys and mouse to where the saw is wanted. Knows no window: events in, a pose out.
#pragma once

#include <optional>
#include <set>

#include "app/window/event.h"
#include "kerf/geometry.h"

namespace kerf {

/// The directions of the picture in the world, unit length, and its scale where the saw is.
struct ViewBasis {
  Vec3 right_W{1, 0, 0};
  Vec3 up_W{0, 0, 1};
  Vec3 forward_W{0, 1, 0};  // from the eye into the picture
  double mm_per_pixel = 0.1;
};

/// Arrows and page keys move, W A S D Q E turn; the mouse drags, with Shift into the picture, with Control turning.
class SawControls {
 public:
  /// Not further from the saw than this may what is wanted be: the mouse's hand reaches no further either.
  static constexpr double kLead_mm = 14;
  static constexpr double kLead_rad = 0.35;

  explicit SawControls(const Pose& X_WT) : X_wanted_(X_WT) {}

  /// True when the event was for the saw.
  bool Take(const WindowEvent& event, const ViewBasis& view);
  /// The time since the last call goes by with the keys that are held. `X_WT`: where the saw is.
  void Advance(double dt_s, const ViewBasis& view, const Pose& X_WT);
  /// All keys and buttons are let go.
  void Release();
  /// The saw is wanted there, at once.
  void Set(const Pose& X_WT) { X_wanted_ = X_WT; }

  const Pose& wanted() const { return X_wanted_; }
  double feed_mm_per_s() const { return feed_mm_per_s_; }
  /// Of keys: 0.5 to 20.
  void set_feed_mm_per_s(double feed);
  /// In the plane of the blade alone, and turning only about the spindle: how a straight cut is kept straight.
  bool in_blade_plane() const { return in_blade_plane_; }
  void set_in_blade_plane(bool on) { in_blade_plane_ = on; }

 private:
  void Move(const Vec3& by_W);
  void Turn(const Vec3& by_W_rad);

  Pose X_wanted_;
  std::set<Key> held_;
  bool dragging_ = false;
  double last_x_ = 0;
  double last_y_ = 0;
  bool fast_ = false;
  double feed_mm_per_s_ = 4;
  bool in_blade_plane_ = false;
};

}  // namespace kerf
