// Splits faces with more than three corners into triangles.
#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <utility>
#include <vector>

#include "bone/mesh/limits.h"
#include "bone/mesh/read.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Corners = std::span<const std::uint32_t>;

void AddFan(Corners corners, TriangleMesh& mesh) {
  for (std::size_t n = 2; n < corners.size(); ++n) mesh.triangles.push_back({corners[0], corners[n - 1], corners[n]});
}

/// Returns the normal of triangle `n` of the fan, of twice the length of its area.
Vec3 CalcFanNormal(Corners corners, std::size_t n, const std::vector<Vec3>& points) {
  const Vec3& first = points[corners[0]];
  return glm::cross(points[corners[n - 1]] - first, points[corners[n]] - first);
}

/// Cuts ears off a polygon in a plane: corners whose triangle with both neighbours contains no other corner. The time
/// grows with the square of the number of corners, because a cut changes only the neighbours.
class EarCutter {
 public:
  /// `normal`: of the face. The polygon is projected along the normal's largest component.
  EarCutter(Corners corners, const std::vector<Vec3>& points, const Vec3& normal) : corners_(corners) {
    const Vec3 size = glm::abs(normal);
    const int across = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    int u = (across + 1) % 3;
    int v = (across + 2) % 3;
    if (normal[across] < 0) std::swap(u, v);
    for (std::size_t n = 0; n < corners.size(); ++n) {
      const Vec3& p = points[corners[n]];
      flat_.emplace_back(p[u], p[v]);
      before_.push_back(n == 0 ? corners.size() - 1 : n - 1);
      after_.push_back(n + 1 == corners.size() ? 0 : n + 1);
    }
    for (std::size_t n = 0; n < corners.size(); ++n) is_ear_.push_back(CheckEar(n));
  }

  void AddTriangles(TriangleMesh& mesh) {
    std::size_t at = 0;
    std::size_t left = corners_.size();
    std::size_t tried = 0;  // since the last cut
    while (left > 3 && tried < left) {
      const std::size_t before = before_[at];
      const std::size_t after = after_[at];
      ++tried;
      if (is_ear_[at]) {
        mesh.triangles.push_back({corners_[before], corners_[at], corners_[after]});
        after_[before] = after;
        before_[after] = before;
        is_ear_[before] = CheckEar(before);
        is_ear_[after] = CheckEar(after);
        --left;
        tried = 0;
      }
      at = after;
    }
    // The last triangle. Of a face that crosses itself or is flat, several may be left.
    std::vector<std::uint32_t> rest;
    for (; left > 0; --left, at = after_[at]) rest.push_back(corners_[at]);
    AddFan(rest, mesh);
  }

 private:
  /// Returns twice the area of a triangle, positive if it turns to the left.
  double CalcTurn(std::size_t a, std::size_t b, std::size_t c) const {
    const glm::dvec2 u = flat_[b] - flat_[a];
    const glm::dvec2 v = flat_[c] - flat_[a];
    return u.x * v.y - u.y * v.x;
  }
  double CalcTurnAt(std::size_t n) const { return CalcTurn(before_[n], n, after_[n]); }

  bool CheckEar(std::size_t b) const {
    const std::size_t a = before_[b];
    const std::size_t c = after_[b];
    if (!(CalcTurn(a, b, c) > 0)) return false;
    for (std::size_t n = after_[c]; n != a; n = after_[n]) {
      const bool is_inside = CalcTurn(a, b, n) >= 0 && CalcTurn(b, c, n) >= 0 && CalcTurn(c, a, n) >= 0;
      // A face with a hole passes the line between the hole and the rim twice, so it has corners in the same place.
      const bool is_corner = flat_[n] == flat_[a] || flat_[n] == flat_[b] || flat_[n] == flat_[c];
      if (is_inside && !is_corner && !(CalcTurnAt(n) > 0)) return false;
    }
    return true;
  }

  Corners corners_;
  std::vector<glm::dvec2> flat_;
  std::vector<std::size_t> before_;
  std::vector<std::size_t> after_;
  std::vector<bool> is_ear_;
};

}  // namespace

void AddFace(std::span<const std::uint32_t> corners, const std::string& path, TriangleMesh& mesh) {
  constexpr double kRounding = 1e-9;  // of the face's area: triangles of the fan that are flat up to rounding
  if (corners.size() == 3) return AddFan(corners, mesh);
  Vec3 normal(0);
  for (std::size_t n = 2; n < corners.size(); ++n) normal += CalcFanNormal(corners, n, mesh.points);
  const double limit = -kRounding * glm::dot(normal, normal);
  std::size_t n = 2;
  while (n < corners.size() && !(glm::dot(CalcFanNormal(corners, n, mesh.points), normal) < limit)) ++n;
  if (n == corners.size()) return AddFan(corners, mesh);  // no triangle of the fan is turned over
  if (corners.size() > kMaxConcaveCorners) {
    throw Error(fmt::format(
        "{}: has a face with {} corners that is not convex, and kerf splits those of up to {}; split the faces into "
        "triangles in a mesh program",
        path, WithSeparators(corners.size()), WithSeparators(kMaxConcaveCorners)));
  }
  EarCutter(corners, mesh.points, normal).AddTriangles(mesh);
}

}  // namespace kerf
