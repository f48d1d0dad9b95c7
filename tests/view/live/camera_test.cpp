// Tests of the camera's invariants: projected points are recovered, and a dragged point stays under the mouse.
#include "view/live/camera.h"

#include <gtest/gtest.h>

#include <rapidcheck/gtest.h>
#include <glm/geometric.hpp>

namespace kerf {
namespace {

double Fraction() {
  return *rc::gen::inRange(-1000, 1001) / 1000.0;
}

ViewCamera AnyCamera() {
  ViewCamera camera;
  camera.SetSize(*rc::gen::inRange(200, 3000), *rc::gen::inRange(200, 3000));
  camera.set_parallel(*rc::gen::arbitrary<bool>());
  camera.set_target_W(100.0 * Vec3{Fraction(), Fraction(), Fraction()});
  camera.set_height_mm(5 + 200 * std::abs(Fraction()));
  camera.Look({Fraction(), Fraction(), 1.1}, {Fraction(), 1.5, 0.1});
  return camera;
}

RC_GTEST_PROP(ViewCameraProperty, ProjectAndUnprojectAreInverse, ()) {
  const ViewCamera camera = AnyCamera();
  const Vec3 p_W = camera.target_W() + 0.4 * camera.height_mm() * Vec3{Fraction(), Fraction(), Fraction()};
  const auto at = camera.Project(p_W);
  RC_ASSERT(at.has_value());
  RC_ASSERT(glm::length(camera.Unproject(*at, p_W) - p_W) < 1e-9 * (1 + glm::length(p_W)));
  const Ray ray = camera.CalcRay(*at);
  const Vec3 off = glm::cross(ray.direction_W, p_W - ray.origin_W);
  RC_ASSERT(glm::length(off) < 1e-6);
  RC_ASSERT(std::abs(glm::length(ray.direction_W) - 1) < 1e-12);
}

RC_GTEST_PROP(ViewCameraProperty, PointUnderTheMouseStaysThereWhenZooming, ()) {
  ViewCamera camera = AnyCamera();
  camera.set_height_mm(50);
  const ScreenPoint at{0.5 * camera.width() * (1 + Fraction()), 0.5 * camera.height() * (1 + Fraction())};
  const Vec3 held = camera.Unproject(at, camera.target_W());
  camera.Zoom(1 + 0.5 * Fraction(), at);
  const auto now = camera.Project(held);
  RC_ASSERT(now.has_value());
  RC_ASSERT(std::hypot(now->x - at.x, now->y - at.y) < 1e-6);
}

RC_GTEST_PROP(ViewCameraProperty, MotionOfTheWorldMatchesTheMouse, ()) {
  const ViewCamera camera = AnyCamera();
  const Vec3 p_W = camera.target_W() + 0.3 * camera.height_mm() * Vec3{Fraction(), Fraction(), Fraction()};
  const double dx = 50 * Fraction();
  const double dy = 50 * Fraction();
  const auto before = camera.Project(p_W);
  const auto after = camera.Project(p_W + camera.WorldMotion(dx, dy, p_W));
  RC_ASSERT(std::abs(after->x - before->x - dx) < 1e-6);
  RC_ASSERT(std::abs(after->y - before->y - dy) < 1e-6);
}

RC_GTEST_PROP(ViewCameraProperty, AxesStayPerpendicular, ()) {
  ViewCamera camera = AnyCamera();
  for (int i = 0; i < 20; ++i) camera.Orbit(300 * Fraction(), 300 * Fraction());
  camera.Roll(3 * Fraction());
  const Vec3 r = camera.right_W();
  const Vec3 u = camera.up_W();
  const Vec3 f = camera.forward_W();
  RC_ASSERT(std::abs(glm::dot(r, u)) + std::abs(glm::dot(u, f)) + std::abs(glm::dot(f, r)) < 1e-9);
  RC_ASSERT(glm::length(glm::cross(r, u) + f) < 1e-9);
}

RC_GTEST_PROP(ViewCameraProperty, FittedPointsAreInsideThePicture, ()) {
  ViewCamera camera = AnyCamera();
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i) points.push_back(40.0 * Vec3{Fraction(), Fraction(), Fraction()});
  camera.Fit(points, 0.1);
  for (const Vec3& p : points) {
    const auto at = camera.Project(p);
    RC_ASSERT(at.has_value());
    RC_ASSERT(std::abs(at->x / camera.width() - 0.5) <= 0.4 + 1e-6);
    RC_ASSERT(std::abs(at->y / camera.height() - 0.5) <= 0.4 + 1e-6);
  }
}

TEST(ViewCamera, NamedViewsAreInThePatientsFrame) {
  ViewCamera camera;
  camera.Look(View::kFront);  // seen from the front the patient's left (+x) is on the right
  EXPECT_NEAR(camera.right_W().x, 1, 1e-12);
  EXPECT_NEAR(camera.up_W().z, 1, 1e-12);
  EXPECT_NEAR(camera.forward_W().y, 1, 1e-12);
  camera.Look(View::kLeft);
  EXPECT_NEAR(camera.forward_W().x, -1, 1e-12);
}

TEST(ViewCamera, DraggingTurnsTheNearSideWithTheMouse) {
  ViewCamera camera;
  camera.Look(View::kFront);
  const Vec3 near_W{0, -10, 0};
  const double x_before = camera.Project(near_W)->x;
  const double y_before = camera.Project(near_W)->y;
  camera.Orbit(40, 0);
  EXPECT_GT(camera.Project(near_W)->x, x_before + 1);
  camera.Orbit(-40, 0);
  camera.Orbit(0, 40);
  EXPECT_GT(camera.Project(near_W)->y, y_before + 1);
}

TEST(ViewCamera, NothingIsSeenBehindTheEye) {
  ViewCamera camera;
  EXPECT_FALSE(camera.Project(camera.eye_W() - 5.0 * camera.forward_W()));
}

}  // namespace
}  // namespace kerf
