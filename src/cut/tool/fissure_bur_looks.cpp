#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>

#include "cut/tool/fissure_bur.h"
#include "cut/tool/solids.h"

namespace kerf {
namespace {

constexpr double kGroove = 0.16;       // depth between two flutes, as a fraction of the radius
constexpr double kTwist_per_mm = 0.1;  // of the flutes, rad for each mm of height
constexpr double kShank = 0.6;         // radius, as a fraction of the head's
constexpr double kShank_mm = 6;        // visible length of the shank

/// Adds rings of points up to the top, and the triangles between them; then the two ends.
TriangleMesh MakeHeadMesh(const FissureBur& bur) {
  const RoundSolid solid = MakeBurSolid(bur);
  constexpr int kRingsOfSide = 24;
  constexpr int kRingsOfEnd = 4;
  const int meridians = 12 * std::max(4, bur.flutes);
  TriangleMesh mesh;
  const auto add_ring = [&](double radius, double z, double groove) {
    for (int i = 0; i < meridians; ++i) {
      const double turn = 2 * std::numbers::pi * i / meridians + kTwist_per_mm * z;
      // A sharp edge in front with a slope behind it.
      const double phase = static_cast<double>(i * bur.flutes % meridians) / meridians;
      const double r = radius * (1 - groove * phase);
      mesh.points.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
    }
  };
  for (int k = 1; k <= kRingsOfEnd; ++k) {
    const double t = static_cast<double>(k) / kRingsOfEnd;
    add_ring(t * solid.corner_radius_mm, t * solid.corner_z_mm, t * kGroove);
  }
  for (int k = 1; k <= kRingsOfSide; ++k) {
    const double t = static_cast<double>(k) / kRingsOfSide;
    add_ring(solid.corner_radius_mm + t * (solid.top_radius_mm - solid.corner_radius_mm),
             solid.corner_z_mm + t * (solid.top_z_mm - solid.corner_z_mm), kGroove);
  }
  const auto tip = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, 0);
  mesh.points.emplace_back(0, 0, solid.top_z_mm);
  const auto n = static_cast<std::uint32_t>(meridians);
  constexpr std::uint32_t kRings = kRingsOfEnd + kRingsOfSide;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({tip, next, i});
    for (std::uint32_t j = 0; j + 1 < kRings; ++j) {
      const std::uint32_t a = j * n;
      mesh.triangles.push_back({a + i, a + next, a + n + next});
      mesh.triangles.push_back({a + i, a + n + next, a + n + i});
    }
    const std::uint32_t last = (kRings - 1) * n;
    mesh.triangles.push_back({tip + 1, last + i, last + next});
  }
  AddPrism(MakeCircle(kShank * solid.top_radius_mm, 48), 0.98 * solid.top_z_mm, solid.top_z_mm + kShank_mm, mesh);
  return mesh;
}

}  // namespace

ToolLooks ToolKind<FissureBur>::MakeLooks(const FissureBur& bur) {
  ToolLooks looks;
  looks.whole = MakeHeadMesh(bur);
  return looks;
}

std::vector<Vec3> ToolKind<FissureBur>::MakeSection(const FissureBur& bur, const Pose& X_ST, double) {
  // The section of a convex solid is convex, so its points in the order of their angle about one of them are its
  // outline. They lie where the plane meets the generatrices and the edges of end and top.
  const RoundSolid solid = MakeBurSolid(bur);
  std::vector<Vec3> points;
  const auto add = [&](const Vec3& a_T, const Vec3& b_T) {
    const Vec3 a = X_ST.Point(a_T);
    const Vec3 b = X_ST.Point(b_T);
    if ((a.z > 0) == (b.z > 0)) return;
    const Vec3 p = glm::mix(a, b, a.z / (a.z - b.z));
    points.emplace_back(p.x, p.y, 0);
  };
  constexpr int kTurns = 128;
  const auto at = [](double radius, double z, int i) {
    const double turn = 2 * std::numbers::pi * i / kTurns;
    return Vec3(radius * std::cos(turn), radius * std::sin(turn), z);
  };
  for (int i = 0; i < kTurns; ++i) {
    const Vec3 corner = at(solid.corner_radius_mm, solid.corner_z_mm, i);
    const Vec3 top = at(solid.top_radius_mm, solid.top_z_mm, i);
    add(Vec3(0), corner);
    add(corner, top);
    add(top, Vec3(0, 0, solid.top_z_mm));
    add(corner, at(solid.corner_radius_mm, solid.corner_z_mm, i + 1));
    add(top, at(solid.top_radius_mm, solid.top_z_mm, i + 1));
  }
  if (points.size() < 3) return {};
  Vec3 middle(0);
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
    return std::atan2(a.y - middle.y, a.x - middle.x) < std::atan2(b.y - middle.y, b.x - middle.x);
  });
  points.push_back(points.front());
  return points;
}

std::vector<Vec3> ToolKind<FissureBur>::SampleSurface(const FissureBur& bur, double step_mm) {
  const RoundSolid solid = MakeBurSolid(bur);
  std::vector<Vec3> points;
  const auto add_cone = [&](double r_a, double z_a, double r_b, double z_b) {
    const int rings = std::max(1, static_cast<int>(std::ceil(std::hypot(r_b - r_a, z_b - z_a) / step_mm)));
    for (int j = 0; j <= rings; ++j) {
      const double t = static_cast<double>(j) / rings;
      const double r = r_a + t * (r_b - r_a);
      const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * r / step_mm)));
      for (int i = 0; i < count; ++i) {
        const double turn = 2 * std::numbers::pi * i / count;
        points.emplace_back(r * std::cos(turn), r * std::sin(turn), z_a + t * (z_b - z_a));
      }
    }
  };
  add_cone(solid.top_radius_mm, solid.top_z_mm, solid.corner_radius_mm, solid.corner_z_mm);
  add_cone(solid.corner_radius_mm, solid.corner_z_mm, 0, 0);
  add_cone(solid.top_radius_mm, solid.top_z_mm, 0, solid.top_z_mm);
  return points;
}

}  // namespace kerf
