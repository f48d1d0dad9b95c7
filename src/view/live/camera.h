// From where the scene is looked at, and how pixels and world go together.
#pragma once

#include <optional>
#include <vector>

#include "kerf/geometry.h"
#include "view/picture/picture.h"

namespace kerf {

/// A pixel of the window, from its top left, in framebuffer pixels; whole numbers are pixels' corners.
struct ScreenPoint {
  double x = 0;
  double y = 0;
};

struct Ray {
  Vec3 origin_W{0};
  Vec3 direction_W{0, 0, -1};  // unit
};

/// Looks at a target from a distance that shows `height_mm` of the plane through it. Pure: no window in it.
class ViewCamera {
 public:
  static constexpr double kFieldOfView_deg = 30;  // vertical, in perspective

  /// Framebuffer pixels, at least 1.
  void SetSize(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }

  bool parallel() const { return parallel_; }
  void set_parallel(bool parallel) { parallel_ = parallel; }

  const Vec3& target_W() const { return target_W_; }
  void set_target_W(const Vec3& p_W) { target_W_ = p_W; }
  double height_mm() const { return height_mm_; }
  void set_height_mm(double height_mm);  // held to 1 to 2000
  /// Direction from target to eye and which way is up; `up_W` not along it.
  void Look(const Vec3& toward_eye_W, const Vec3& up_W);
  void Look(View view);

  // What a mouse does, in pixels.
  void Orbit(double dx, double dy);  // about the target; right and down are positive, the scene follows the mouse
  void Roll(double angle_rad);       // about the line of sight
  void Pan(double dx, double dy);
  /// `factor` > 1 comes nearer; what lies under the pixel in the plane of the target stays there.
  void Zoom(double factor, const ScreenPoint& at);
  /// All of the points in view and in its middle, with `margin` of the window free on each side.
  void Fit(const std::vector<Vec3>& points_W, double margin = 0.06);

  // Unit vectors of the picture.
  Vec3 right_W() const { return right_W_; }
  Vec3 up_W() const { return up_W_; }
  Vec3 forward_W() const { return -toward_eye_W_; }
  Vec3 eye_W() const;  // in parallel projection too: far enough that all lies before it

  /// Size of a pixel at the depth of a point, mm.
  double WorldPerPixel(const Vec3& p_W) const;
  /// None behind the eye.
  std::optional<ScreenPoint> Project(const Vec3& p_W) const;
  Ray CalcRay(const ScreenPoint& at) const;
  /// The point under a pixel in the plane through `p_W` parallel to the picture.
  Vec3 Unproject(const ScreenPoint& at, const Vec3& p_W) const;
  /// The motion in the picture's plane, at the depth of `p_W`, that looks like (dx, dy) pixels; down is positive.
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
