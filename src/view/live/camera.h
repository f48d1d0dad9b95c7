// Camera of the live view: viewpoint, and the mapping between pixels and the world.
#pragma once

#include <optional>
#include <vector>

#include "kerf/geometry.h"
#include "view/picture/picture.h"

namespace kerf {

/// Point in the window in framebuffer pixels, from the top left; whole numbers are pixel corners.
struct ScreenPoint {
  double x = 0;
  double y = 0;
};

struct Ray {
  Vec3 origin_W{0};
  Vec3 direction_W{0, 0, -1};  // unit
};

/// Camera that looks at a target from a distance at which the view spans `height_mm` in the plane through the target.
/// Pure: independent of any window.
class ViewCamera {
 public:
  static constexpr double kFieldOfView_deg = 30;  // vertical, perspective projection only

  /// Sets the size in framebuffer pixels, at least 1 each.
  void SetSize(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }

  bool parallel() const { return parallel_; }
  void set_parallel(bool parallel) { parallel_ = parallel; }

  const Vec3& target_W() const { return target_W_; }
  void set_target_W(const Vec3& p_W) { target_W_ = p_W; }
  double height_mm() const { return height_mm_; }
  void set_height_mm(double height_mm);  // clamped to 1 to 2000
  /// Sets the direction from target to eye and the up direction. `up_W` must not be parallel to `toward_eye_W`.
  void Look(const Vec3& toward_eye_W, const Vec3& up_W);
  void Look(View view);

  // Mouse motions, in pixels.
  void Orbit(double dx, double dy);  // about the target; right and down are positive, the scene follows the mouse
  void Roll(double angle_rad);       // about the line of sight
  void Pan(double dx, double dy);
  /// Zooms in for `factor` > 1. The point under the pixel in the target plane stays fixed.
  void Zoom(double factor, const ScreenPoint& at);
  /// Brings all points into view and centres them, leaving a fraction `margin` of the window free on each side.
  void Fit(const std::vector<Vec3>& points_W, double margin = 0.06);

  // Unit vectors of the image.
  Vec3 right_W() const { return right_W_; }
  Vec3 up_W() const { return up_W_; }
  Vec3 forward_W() const { return -toward_eye_W_; }
  Vec3 eye_W() const;  // also in parallel projection, where it is far enough back that the scene lies in front of it

  /// Returns the size of a pixel at the depth of a point, mm.
  double WorldPerPixel(const Vec3& p_W) const;
  /// Returns the pixel position of a point; nullopt if the point is behind the eye.
  std::optional<ScreenPoint> Project(const Vec3& p_W) const;
  Ray CalcRay(const ScreenPoint& at) const;
  /// Returns the point under a pixel in the plane through `p_W` parallel to the image.
  Vec3 Unproject(const ScreenPoint& at, const Vec3& p_W) const;
  /// Returns the motion in the image plane that appears as (dx, dy) pixels at the depth of `p_W`; down is positive.
  Vec3 WorldMotion(double dx, double dy, const Vec3& p_W) const;

 private:
  double Distance() const;  // eye to target, mm

  int width_ = 1280;
  int height_ = 720;
  bool parallel_ = false;
  Vec3 target_W_{0};
  Vec3 toward_eye_W_{0, -1, 0};
  Vec3 right_W_{1, 0, 0};
  Vec3 up_W_{0, 0, 1};
  double height_mm_ = 150;
};

}  // namespace kerf
