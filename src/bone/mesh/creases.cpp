#include "bone/mesh/creases.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <utility>

namespace kerf {
namespace {

constexpr float kLeastCosine = 0.766044F;  // of 40 degrees

using Triangle = std::array<std::uint32_t, 3>;

bool ShareSide(const Triangle& s, const Triangle& t, std::uint32_t point) {
  return std::any_of(s.begin(), s.end(),
                     [&](std::uint32_t p) { return p != point && std::find(t.begin(), t.end(), p) != t.end(); });
}

/// Puts the triangles of the smooth part to which the first one belongs in front of the others and returns their
/// number.
std::size_t GatherSmooth(const TriangleMesh& mesh, const std::vector<glm::vec3>& normals, std::uint32_t point,
                         std::span<std::uint32_t> triangles) {
  std::size_t count = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t from = triangles[i];
    for (std::size_t j = count; j < triangles.size(); ++j) {
      const std::uint32_t to = triangles[j];
      if (glm::dot(normals[from], normals[to]) <= kLeastCosine) continue;
      if (ShareSide(mesh.triangles[from], mesh.triangles[to], point)) std::swap(triangles[count++], triangles[j]);
    }
  }
  return count;
}

}  // namespace

CreasedMesh SplitAtCreases(const TriangleMesh& mesh) {
  std::vector<glm::vec3> of_triangles;
  of_triangles.reserve(mesh.triangles.size());
  std::vector<std::uint32_t> first(mesh.points.size() + 1, 0);  // of each point in `around`
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n = glm::cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]);
    const double length = glm::length(n);
    of_triangles.emplace_back(length > 0 ? n / length : Vec3(0));
    for (const std::uint32_t p : t) ++first[p + 1];
  }
  for (std::size_t p = 0; p < mesh.points.size(); ++p) first[p + 1] += first[p];
  std::vector<std::uint32_t> around(3 * mesh.triangles.size());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t p : mesh.triangles[t]) around[next[p]++] = t;
  }

  CreasedMesh creased;
  creased.mesh = mesh;
  creased.normals.assign(mesh.points.size(), glm::vec3(0));
  for (std::uint32_t p = 0; p < mesh.points.size(); ++p) {
    std::span<std::uint32_t> left(around.begin() + first[p], around.begin() + first[p + 1]);
    for (std::uint32_t id = p; !left.empty();) {
      const std::span<std::uint32_t> smooth = left.first(GatherSmooth(mesh, of_triangles, p, left));
      glm::vec3 sum(0);
      for (const std::uint32_t t : smooth) sum += of_triangles[t];
      const float length = glm::length(sum);
      creased.normals[id] = length > 0 ? sum / length : sum;
      if (id != p) {
        for (const std::uint32_t t : smooth) std::ranges::replace(creased.mesh.triangles[t], p, id);
      }
      left = left.subspan(smooth.size());
      if (left.empty()) break;
      id = static_cast<std::uint32_t>(creased.mesh.points.size());
      creased.mesh.points.push_back(mesh.points[p]);
      creased.repeated.push_back(p);
      creased.normals.emplace_back(0);
    }
  }
  return creased;
}

}  // namespace kerf
