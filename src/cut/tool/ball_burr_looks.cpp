#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "cut/tool/ball_burr.h"
#include "cut/tool/solids.h"

namespace kerf {
namespace {

/// Makes a sphere with grooves between its slightly twisted flutes, and the end of the shank.
TriangleMesh MakeBallMesh(const BallBurr& ball) {
  constexpr int kParallels = 48;
  constexpr double kGroove = 0.12;  // depth, as a fraction of the radius
  constexpr double kTwist = 0.6;    // rad from pole to pole
  const int meridians = 12 * std::max(4, ball.flutes);
  const double radius = ball.radius_mm();
  TriangleMesh mesh;
  for (int j = 1; j < kParallels; ++j) {
    const double colatitude = std::numbers::pi * j / kParallels;
    for (int i = 0; i < meridians; ++i) {
      const double longitude =
          2 * std::numbers::pi * i / meridians + kTwist * j / kParallels;  // points follow the flutes
      const double phase = static_cast<double>(i * ball.flutes % meridians) / meridians;
      // A sharp edge in front with a slope behind it; the grooves fade out towards the poles.
      const double groove = kGroove * std::sin(colatitude) * phase;
      const double r = radius * (1 - groove);
      mesh.points.emplace_back(r * std::sin(colatitude) * std::cos(longitude),
                               r * std::sin(colatitude) * std::sin(longitude), r * std::cos(colatitude));
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, radius);
  mesh.points.emplace_back(0, 0, -radius);
  const auto n = static_cast<std::uint32_t>(meridians);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({top, i, next});
    for (std::uint32_t j = 0; j + 2 < kParallels; ++j) {
      const std::uint32_t a = j * n;
      mesh.triangles.push_back({a + i, a + n + i, a + n + next});
      mesh.triangles.push_back({a + i, a + n + next, a + next});
    }
    const std::uint32_t last = (kParallels - 2) * n;
    mesh.triangles.push_back({top + 1, last + next, last + i});
  }
  AddPrism(MakeCircle(0.45 * radius, 48), 0.85 * radius, 4 * radius, mesh);
  return mesh;
}

}  // namespace

ToolLooks ToolKind<BallBurr>::MakeLooks(const BallBurr& ball) {
  ToolLooks looks;
  looks.whole = MakeBallMesh(ball);
  return looks;
}

std::vector<Vec3> ToolKind<BallBurr>::MakeSection(const BallBurr& ball, const Pose& X_ST, double) {
  const double R = ball.radius_mm();
  const double d = X_ST.p_AB.z;
  if (std::abs(d) >= R) return {};
  std::vector<Vec3> outline = MakeCircle(std::sqrt(R * R - d * d), 64);
  for (Vec3& p : outline) p += Vec3{X_ST.p_AB.x, X_ST.p_AB.y, 0};
  outline.push_back(outline.front());
  return outline;
}

std::vector<Vec3> ToolKind<BallBurr>::SampleSurface(const BallBurr& ball, double step_mm) {
  std::vector<Vec3> points;
  const int rings = std::max(3, static_cast<int>(std::ceil(std::numbers::pi * ball.radius_mm() / step_mm)));
  for (int i = 0; i <= rings; ++i) {
    const double polar = std::numbers::pi * i / rings;
    const double radius = ball.radius_mm() * std::sin(polar);
    const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / step_mm)));
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), ball.radius_mm() * std::cos(polar));
    }
  }
  return points;
}

}  // namespace kerf
