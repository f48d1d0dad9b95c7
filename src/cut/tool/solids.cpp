#include "cut/tool/solids.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace kerf {

void AddPrism(const std::vector<Vec3>& outline, double z0, double z1, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const Vec3& p : outline) mesh.points.emplace_back(p.x, p.y, z0);
  for (const Vec3& p : outline) mesh.points.emplace_back(p.x, p.y, z1);
  const auto bottom = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, z0);
  mesh.points.emplace_back(0, 0, z1);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = first + i;
    const std::uint32_t b = first + (i + 1) % n;
    mesh.triangles.push_back({a, b, b + n});
    mesh.triangles.push_back({a, b + n, a + n});
    mesh.triangles.push_back({bottom, b, a});
    mesh.triangles.push_back({bottom + 1, a + n, b + n});
  }
}

std::vector<Vec3> MakeCircle(double radius, int corners) {
  std::vector<Vec3> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return outline;
}

}  // namespace kerf
