#include "bone/import/shells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A side of a triangle; `side` is 3 times the triangle's number plus the corner at which the side begins.
struct Side {
  std::uint64_t edge;  // the two points, the lower one first
  std::uint32_t side;
  bool operator<(const Side& other) const { return edge != other.edge ? edge < other.edge : side < other.side; }
};

std::vector<Side> SortSides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t a = t[i];
      const std::uint64_t b = t[(i + 1) % 3];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), static_cast<std::uint32_t>(sides.size())});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Calls visit(first, count) for the sides of each edge.
template <typename Visit>
void ForEachEdge(const std::vector<Side>& sides, Visit visit) {
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t end = first + 1;
    while (end < sides.size() && sides[end].edge == sides[first].edge) ++end;
    visit(first, end - first);
    first = end;
  }
}

/// Returns, for each side, the side of the other triangle at the same edge.
std::vector<std::uint32_t> FindOpposites(const TriangleMesh& mesh) {
  const std::vector<Side> sides = SortSides(mesh);
  std::vector<std::uint32_t> opposite(sides.size(), kNone);
  ForEachEdge(sides, [&](std::size_t first, std::size_t count) {
    if (count != 2) return;
    opposite[sides[first].side] = sides[first + 1].side;
    opposite[sides[first + 1].side] = sides[first].side;
  });
  return opposite;
}

double CalcVolume(const TriangleMesh& mesh, const Shell& shell) {
  const Vec3 origin = shell.box.centre();
  double sum = 0;
  for (const std::uint32_t n : shell.triangles) {
    const auto& t = mesh.triangles[n];
    sum += glm::dot(mesh.points[t[0]] - origin, glm::cross(mesh.points[t[1]] - origin, mesh.points[t[2]] - origin));
  }
  return sum / 6;
}

/// Rays along an arbitrary direction, parallel to an edge with negligible probability. Triangles are sorted into
/// strips.
class Rays {
 public:
  Rays(const TriangleMesh& mesh, const std::vector<Shell>& shells) : mesh_(mesh), shell_of_(mesh.triangles.size()) {
    for (std::size_t n = 0; n < shells.size(); ++n) {
      for (const std::uint32_t t : shells[n].triangles) shell_of_[t] = static_cast<std::uint32_t>(n);
    }
    const Vec3 w = glm::normalize(Vec3(0.2718281, 0.5772156, 0.7691233));
    const Vec3 u = glm::normalize(glm::cross(w, Vec3(0, 0, 1)));
    const Vec3 v = glm::cross(w, u);
    const Vec3 origin = mesh.points.front();
    Box3 box;
    turned_.reserve(mesh.points.size());
    for (const Vec3& p : mesh.points) {
      turned_.emplace_back(glm::dot(p - origin, u), glm::dot(p - origin, v), glm::dot(p - origin, w));
      box.Include(turned_.back());
    }
    lowest_ = box.lower.x;
    per_mm_ = kStrips / std::max(box.size().x, 1e-12);
    strips_.resize(kStrips);
    for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
      const auto [a, b, c] = Corners(n);
      const int last = Strip(std::max({a.x, b.x, c.x}));
      for (int strip = Strip(std::min({a.x, b.x, c.x})); strip <= last; ++strip) {
        strips_[static_cast<std::size_t>(strip)].push_back(static_cast<std::uint32_t>(n));
      }
    }
  }

  /// Returns the signed number of times that the surface of each shell encloses the centre of a triangle.
  std::vector<int> CountWindings(std::uint32_t triangle, std::size_t shells) const {
    std::vector<int> windings(shells, 0);
    const auto [a0, b0, c0] = Corners(triangle);
    const Vec3 p = (a0 + b0 + c0) / 3.0;
    for (const std::uint32_t n : strips_[static_cast<std::size_t>(Strip(p.x))]) {
      if (shell_of_[n] == shell_of_[triangle]) continue;
      const auto& t = mesh_.triangles[n];
      const int ab = IsLeft(t[0], t[1], p);
      if (IsLeft(t[1], t[2], p) != ab || IsLeft(t[2], t[0], p) != ab) continue;
      const auto [a, b, c] = Corners(n);
      const Vec3 normal = glm::cross(b - a, c - a);
      if (normal.z == 0 || glm::dot(a - p, normal) / normal.z <= 0) continue;  // behind
      windings[shell_of_[n]] += ab;
    }
    return windings;
  }

 private:
  static constexpr int kStrips = 1024;

  std::array<Vec3, 3> Corners(std::size_t n) const {
    const auto& t = mesh_.triangles[n];
    return {turned_[t[0]], turned_[t[1]], turned_[t[2]]};
  }
  int Strip(double x) const { return std::clamp(static_cast<int>((x - lowest_) * per_mm_), 0, kStrips - 1); }
  /// Returns 1 or -1; the opposite for the reversed edge.
  int IsLeft(std::uint32_t i, std::uint32_t j, const Vec3& p) const {
    if (i > j) return -IsLeft(j, i, p);
    const Vec3& a = turned_[i];
    const Vec3& b = turned_[j];
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) >= 0 ? 1 : -1;
  }

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> shell_of_;
  std::vector<Vec3> turned_;
  double lowest_ = 0;
  double per_mm_ = 1;
  std::vector<std::vector<std::uint32_t>> strips_;
};

bool Contains(const Box3& outer, const Box3& inner) {
  return glm::min(outer.lower, inner.lower) == outer.lower && glm::max(outer.upper, inner.upper) == outer.upper;
}

}  // namespace

EdgeCounts CountEdges(const TriangleMesh& mesh) {
  EdgeCounts counts;
  ForEachEdge(SortSides(mesh), [&counts](std::size_t, std::size_t count) {
    counts.open += count == 1 ? 1 : 0;
    counts.crowded += count > 2 ? 1 : 0;
  });
  return counts;
}

std::vector<Shell> OrientShells(TriangleMesh& mesh, std::size_t& flipped, const std::string& path) {
  const std::vector<std::uint32_t> opposite = FindOpposites(mesh);
  enum : std::uint8_t { kUnseen, kAsItIs, kFlipped };
  std::vector<std::uint8_t> state(mesh.triangles.size(), kUnseen);
  std::vector<Shell> shells;
  for (std::uint32_t start = 0; start < state.size(); ++start) {
    if (state[start] != kUnseen) continue;
    Shell shell;
    std::size_t against = 0;  // number of triangles that face opposite to the first one
    state[start] = kAsItIs;
    shell.triangles.push_back(start);
    for (std::size_t n = 0; n < shell.triangles.size(); ++n) {
      const std::uint32_t t = shell.triangles[n];
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t side = opposite[3 * t + i];
        const std::uint32_t next = side / 3;
        // Neighbours with the same orientation traverse their edge in opposite directions.
        const bool agree = mesh.triangles[t][i] != mesh.triangles[next][side % 3];
        const std::uint8_t wanted = (state[t] == kAsItIs) == agree ? kAsItIs : kFlipped;
        if (state[next] == kUnseen) {
          state[next] = wanted;
          against += wanted == kFlipped ? 1 : 0;
          shell.triangles.push_back(next);
        } else if (state[next] != wanted) {
          throw Error(
              fmt::format("{}: a part of the surface is one-sided, like a Moebius strip, so it has no inside", path));
        }
      }
    }
    const bool majority_flipped = 2 * against > shell.triangles.size();
    flipped += majority_flipped ? shell.triangles.size() - against : against;
    for (const std::uint32_t t : shell.triangles) {
      if ((state[t] == kFlipped) != majority_flipped) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      for (const std::uint32_t p : mesh.triangles[t]) shell.box.Include(mesh.points[p]);
    }
    shell.volume_mm3 = CalcVolume(mesh, shell);
    shells.push_back(std::move(shell));
  }
  std::stable_sort(shells.begin(), shells.end(),
                   [](const Shell& a, const Shell& b) { return std::abs(a.volume_mm3) > std::abs(b.volume_mm3); });
  return shells;
}

void FindContainers(const TriangleMesh& mesh, std::vector<Shell>& shells) {
  if (shells.size() < 2) return;
  const Rays rays(mesh, shells);
  for (std::size_t n = 1; n < shells.size(); ++n) {
    const std::vector<int> windings = rays.CountWindings(shells[n].triangles.front(), shells.size());
    for (std::size_t other = 0; other < n; ++other) {
      if (windings[other] != 0 && Contains(shells[other].box, shells[n].box)) {
        shells[n].container = static_cast<int>(other);  // later ones are smaller
      }
    }
  }
}

void DropUnusedPoints(TriangleMesh& mesh) {
  std::vector<std::uint32_t> id_of(mesh.points.size(), kNone);
  std::vector<Vec3> used;
  for (auto& t : mesh.triangles) {
    for (std::uint32_t& p : t) {
      if (id_of[p] == kNone) {
        id_of[p] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.points[p]);
      }
      p = id_of[p];
    }
  }
  mesh.points = std::move(used);
}

}  // namespace kerf
