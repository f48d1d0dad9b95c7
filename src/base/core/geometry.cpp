#include "kerf/geometry.h"

#include <algorithm>
#include <unordered_map>

namespace kerf {

bool IsValid(const Pose& X) {
  const double n2 = glm::dot(X.R_AB, X.R_AB);
  return std::isfinite(X.p_AB.x) && std::isfinite(X.p_AB.y) && std::isfinite(X.p_AB.z) && std::abs(n2 - 1) <= 2e-6;
}

bool IsInWorld(const Vec3& p_W) {
  return std::abs(p_W.x) <= kWorldReach_mm && std::abs(p_W.y) <= kWorldReach_mm && std::abs(p_W.z) <= kWorldReach_mm;
}

std::optional<Vec3> CalcDirection(const Vec3& v) {
  // The squared length of a very long or very short vector exceeds the range of a double.
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z) || largest == 0) return std::nullopt;
  const Vec3 scaled(v.x / largest, v.y / largest, v.z / largest);
  return scaled / std::sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

void Box3::Include(const Vec3& p) {
  lower = glm::min(lower, p);
  upper = glm::max(upper, p);
}

double CalcEnclosedVolume(const TriangleMesh& mesh) {
  if (mesh.points.empty()) return 0;
  // Relative to a point of the mesh, so that a mesh far from the origin loses no precision.
  const Vec3 origin = mesh.points.front();
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.points[t[0]] - origin;
    const Vec3 b = mesh.points[t[1]] - origin;
    const Vec3 c = mesh.points[t[2]] - origin;
    sum += glm::dot(a, glm::cross(b, c));
  }
  return sum / 6;
}

std::size_t CountOpenEdges(const TriangleMesh& mesh) {
  // Each directed edge a->b of one triangle needs exactly one edge b->a of another.
  std::unordered_map<std::uint64_t, int> uses;
  uses.reserve(mesh.triangles.size() * 3);
  const auto key = [](std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; };
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++uses[key(t[i], t[(i + 1) % 3])];
  }
  std::size_t open = 0;
  for (const auto& [edge, count] : uses) {
    const auto opposite = uses.find((edge << 32) | (edge >> 32));
    if (count != 1 || opposite == uses.end() || opposite->second != 1) ++open;
  }
  return open;
}

}  // namespace kerf
