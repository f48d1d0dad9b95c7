#include "view/live/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace kerf {
namespace {

double TanHalf() {
  return std::tan(0.5 * ViewCamera::kFieldOfView_deg * std::numbers::pi / 180);
}

}  // namespace

void ViewCamera::SetSize(int width, int height) {
  width_ = std::max(1, width);
  height_ = std::max(1, height);
}

void ViewCamera::set_height_mm(double height_mm) {
  height_mm_ = std::clamp(height_mm, 1.0, 2000.0);
}

void ViewCamera::Look(const Vec3& toward_eye_W, const Vec3& up_W) {
  const auto toward = CalcDirection(toward_eye_W);
  if (!toward) return;
  const auto right = CalcDirection(glm::cross(up_W, *toward));
  if (!right) return;
  toward_eye_W_ = *toward;
  right_W_ = *right;
  up_W_ = glm::cross(toward_eye_W_, right_W_);
}

void ViewCamera::Look(View view) {
  const Camera camera = MakeCamera(view);
  Look(camera.toward_eye_W, camera.up_W);
}

void ViewCamera::Orbit(double dx, double dy) {
  // Dragging over the height of the window rotates by half a turn.
  const double unit = std::numbers::pi / height_;
  const Quat R = glm::angleAxis(-unit * dx, up_W_) * glm::angleAxis(-unit * dy, right_W_);
  Look(R * toward_eye_W_, R * up_W_);
}

void ViewCamera::Roll(double angle_rad) {
  Look(toward_eye_W_, glm::angleAxis(angle_rad, toward_eye_W_) * up_W_);
}

void ViewCamera::Pan(double dx, double dy) {
  target_W_ -= WorldMotion(dx, dy, target_W_);
}

void ViewCamera::Zoom(double factor, const ScreenPoint& at) {
  const Vec3 before = Unproject(at, target_W_);
  set_height_mm(height_mm_ / factor);
  target_W_ += before - Unproject(at, target_W_);
}

void ViewCamera::Fit(const std::vector<Vec3>& points_W, double margin) {
  if (points_W.empty()) return;
  // Converts to components along the image's right and up directions and towards the eye.
  const auto in_view = [&](const Vec3& p) {
    return Vec3{glm::dot(p, right_W_), glm::dot(p, up_W_), glm::dot(p, toward_eye_W_)};
  };
  Box3 box;
  for (const Vec3& p : points_W) box.Include(in_view(p));
  const Vec3 middle = box.centre();
  target_W_ = middle.x * right_W_ + middle.y * up_W_ + middle.z * toward_eye_W_;
  const double fraction = std::max(0.05, 1 - 2 * margin);
  const double aspect = static_cast<double>(width_) / height_;
  double height = 1;
  for (const Vec3& p : points_W) {
    const Vec3 d = in_view(p) - middle;
    const double sides = 2 * std::max(std::abs(d.y), std::abs(d.x) / aspect);
    // Points nearer than the target appear larger, farther ones smaller.
    height = std::max(height, sides / fraction + (parallel_ ? 0 : d.z * 2 * TanHalf()));
  }
  set_height_mm(height);
}

double ViewCamera::Distance() const {
  return 0.5 * height_mm_ / TanHalf();
}

Vec3 ViewCamera::eye_W() const {
  return target_W_ + (parallel_ ? std::max(Distance(), 1000.0) : Distance()) * toward_eye_W_;
}

double ViewCamera::WorldPerPixel(const Vec3& p_W) const {
  const double at_target = height_mm_ / height_;
  if (parallel_) return at_target;
  const double depth = glm::dot(eye_W() - p_W, toward_eye_W_);
  return at_target * std::max(depth, 1e-3) / Distance();
}

std::optional<ScreenPoint> ViewCamera::Project(const Vec3& p_W) const {
  if (!parallel_ && glm::dot(eye_W() - p_W, toward_eye_W_) <= 1e-3) return std::nullopt;
  const double mm = WorldPerPixel(p_W);
  const Vec3 d = p_W - target_W_;
  return ScreenPoint{0.5 * width_ + glm::dot(d, right_W_) / mm, 0.5 * height_ - glm::dot(d, up_W_) / mm};
}

Ray ViewCamera::CalcRay(const ScreenPoint& at) const {
  const Vec3 on_target = Unproject(at, target_W_);
  if (parallel_) return {on_target + std::max(Distance(), 1000.0) * toward_eye_W_, -toward_eye_W_};
  const Vec3 eye = eye_W();
  return {eye, glm::normalize(on_target - eye)};
}

Vec3 ViewCamera::Unproject(const ScreenPoint& at, const Vec3& p_W) const {
  const double mm = WorldPerPixel(p_W);
  const double along = glm::dot(p_W - target_W_, toward_eye_W_);
  return target_W_ + along * toward_eye_W_ + mm * (at.x - 0.5 * width_) * right_W_ -
         mm * (at.y - 0.5 * height_) * up_W_;
}

Vec3 ViewCamera::WorldMotion(double dx, double dy, const Vec3& p_W) const {
  const double mm = WorldPerPixel(p_W);
  return mm * dx * right_W_ - mm * dy * up_W_;
}

}  // namespace kerf
