#include "bone/mesh/reduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include "bone/mesh/quadric.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Id = std::uint32_t;
constexpr Id kNone = ~Id{0};

// Minimum cosine of the angle by which a triangle may turn when its corner moves.
constexpr double kMinCosine = 0.5;
// Longest edge squared over twice the area; 1.15 for an equilateral triangle. Triangles beyond this are slivers and are
// not made.
constexpr double kWorstShape = 40;
// Number of blocks along the longest side of the surface's box; each thread processes one at a time.
constexpr double kBlocks = 8;
// Each sweep at most halves the number of points. The number of a sweep, counted over all steps, must fit in a byte.
constexpr int kMaxSweeps = 24;
// Distances at points are limited to this fraction of the error, so that distances between points are within the full
// error. At edges and in gaps, where distances between points can be several times those at points, the smaller
// fraction is used.
constexpr double kFractionWhereFlat = 0.4;
constexpr double kFractionWhereRough = 0.3;
// A place is rough if a new triangle is tilted against the nearby full surface so much that over an edge of the full
// surface the distance changes by this many times the error. Above an angle of 18 degrees a place is always rough.
constexpr double kRoughErrors = 2;
constexpr double kMaxRoughSine = 0.31;
// Below this cosine a point does not count as near: the triangle is folded over or belongs to another wall.
constexpr double kMinCosineToFull = 0.2;

/// A new triangle, prepared for fast distance queries from many points.
struct Target {
  std::array<Id, 3> corners{};
  Id id = 0;
  std::array<Vec3, 3> points{};
  Vec3 normal{0};
  double area_mm2 = 0;
  bool has_points = false;       // some points of the full surface are nearest to it
  std::array<Vec3, 3> inward{};  // in the triangle's plane, perpendicular to the edge that begins at each corner
};

double CalcDistance2ToEdge(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double along = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-300), 0.0, 1.0);
  const Vec3 off = p - (a + along * ab);
  return glm::dot(off, off);
}

/// Computes the normal and the values that follow from it; `points` must be set.
void Shape(Target& t) {
  t.normal = glm::cross(t.points[1] - t.points[0], t.points[2] - t.points[0]);
  const double length = glm::length(t.normal);
  t.area_mm2 = 0.5 * length;
  if (length > 0) t.normal /= length;
  for (std::size_t k = 0; k < 3; ++k) t.inward[k] = glm::cross(t.normal, t.points[(k + 1) % 3] - t.points[k]);
}

Target MakeTarget(const Vec3& a, const Vec3& b, const Vec3& c) {
  Target t;
  t.points = {a, b, c};
  Shape(t);
  return t;
}

/// Returns the squared distance of a point from a triangle, or `limit2` if that is smaller.
double CalcDistance2(const Vec3& p, const Target& t, double limit2) {
  const double off = glm::dot(p - t.points[0], t.normal);
  double best2 = off * off;
  if (best2 >= limit2) return limit2;
  bool inside = true;
  double nearest2 = limit2;
  for (std::size_t k = 0; k < 3; ++k) {
    if (glm::dot(p - t.points[k], t.inward[k]) >= 0) continue;
    inside = false;
    nearest2 = std::min(nearest2, CalcDistance2ToEdge(p, t.points[k], t.points[(k + 1) % 3]));
  }
  return inside ? best2 : nearest2;
}

/// The surface during the reduction. Corners of triangles are in lists around their points. Points of the full surface
/// are in lists of the triangles to which they were last found to be near.
struct Surface {
  std::vector<Vec3> full;  // points of the full surface, and additional ones where it is rough
  std::vector<Vec3> points;
  std::vector<std::array<Id, 3>> triangles;
  std::vector<std::uint8_t> dead;  // by triangle
  std::vector<Id> first_corner;    // by point; corner 3 t + k
  std::vector<Id> next_corner;     // by corner
  std::vector<Id> first_near;      // by triangle: a point of the full surface
  std::vector<Id> next_near;       // by point of the full surface
  std::vector<Vec3> full_normals;  // by point of the full surface
  const std::vector<std::array<Id, 3>>& full_triangles;
  std::vector<Id> full_first_corner;   // by point of the full surface
  std::vector<Id> full_next_corner;    // by corner of the full surface
  std::vector<Id> within;              // by additional point: the triangle of the full surface that contains it
  double mean_area_mm2 = 0;            // of a triangle of the full surface
  double rough_cosine = 0;             // between a new triangle and the full surface; below it, locations between
                                       // the points are compared too
  std::vector<Quadric> quadrics;       // by point
  std::vector<std::uint8_t> frozen;    // by point
  std::vector<std::uint8_t> moved_in;  // by point: the last sweep that moved it
  std::vector<std::uint8_t> failed;    // by point: 1 if it could not be collapsed and nothing around it has changed
                                       // since
  std::vector<Id> block;               // by point, for one sweep

  Surface(const TriangleMesh& mesh, double error_mm)
      : full(mesh.points),
        points(mesh.points),
        triangles(mesh.triangles),
        dead(triangles.size(), 0),
        first_corner(points.size(), kNone),
        next_corner(3 * triangles.size(), kNone),
        first_near(triangles.size(), kNone),
        next_near(points.size(), kNone),
        full_normals(points.size(), Vec3(0)),
        full_triangles(mesh.triangles),
        quadrics(points.size()),
        frozen(points.size(), 0),
        moved_in(points.size(), 0),
        failed(points.size(), 0),
        block(points.size(), 0) {
    for (Id t = 0; t < triangles.size(); ++t) {
      const Vec3 n = Normal(triangles[t]);  // its length is twice the area
      const double length = glm::length(n);
      Quadric q;
      if (length > 0) q = Quadric::OfPlane(n / length, points[triangles[t][0]], 0.5 * length);
      for (Id k = 0; k < 3; ++k) {
        const Id p = triangles[t][k];
        next_corner[3 * t + k] = first_corner[p];
        first_corner[p] = 3 * t + k;
        full_normals[p] += n;
        if (length > 0) quadrics[p] += q;
      }
    }
    for (Id p = 0; p < points.size(); ++p) {
      const double length = glm::length(full_normals[p]);
      if (length > 0) full_normals[p] /= length;
      if (first_corner[p] == kNone) continue;
      const Id t = first_corner[p] / 3;
      next_near[p] = first_near[t];
      first_near[t] = p;
    }
    full_first_corner = first_corner;
    full_next_corner = next_corner;
    AddPointsWhereRough(error_mm);
  }

  /// Adds points where the surface is rough: at edges and in gaps, distances may be larger between points than at them.
  void AddPointsWhereRough(double error_mm) {
    for (const auto& t : triangles)
      mean_area_mm2 += 0.5 * glm::length(Normal(t)) / static_cast<double>(triangles.size());
    const double edge_mm = std::sqrt(4 / std::sqrt(3.0) * mean_area_mm2);
    const double sine = edge_mm > 0 ? std::min(kRoughErrors * error_mm / edge_mm, kMaxRoughSine) : kMaxRoughSine;
    rough_cosine = std::sqrt(1 - sine * sine);
    for (Id t = 0; t < triangles.size(); ++t) {
      const auto& [i, j, k] = triangles[t];
      const Vec3 n = Normal(triangles[t]);
      const double length = glm::length(n);
      if (!(length > 0) || glm::dot(full_normals[i] + full_normals[j] + full_normals[k], n) > 3 * rough_cosine * length)
        continue;
      const Vec3 middle = (points[i] + points[j] + points[k]) / 3.0;
      for (const Vec3& p :
           {middle, 0.5 * (points[i] + points[j]), 0.5 * (points[j] + points[k]), 0.5 * (points[k] + points[i])}) {
        next_near.push_back(first_near[t]);
        first_near[t] = static_cast<Id>(full.size());
        full.push_back(p);
        full_normals.push_back(n / length);
        within.push_back(t);
      }
    }
  }

  /// Calls act(triangle) for the triangles of the full surface that touch the point.
  template <typename Do>
  void ForEachFullTriangleAt(Id p, const Do& act) const {
    if (p >= points.size()) return act(within[p - points.size()]);
    for (Id corner = full_first_corner[p]; corner != kNone; corner = full_next_corner[corner]) act(corner / 3);
  }

  Vec3 Normal(const std::array<Id, 3>& t) const {
    return glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
  }

  template <typename Do>
  void ForEachTriangleAt(Id p, const Do& act) const {
    for (Id corner = first_corner[p]; corner != kNone; corner = next_corner[corner]) act(corner / 3);
  }

  void Unlink(Id p, Id triangle) {
    Id* link = &first_corner[p];
    while (*link != kNone && *link / 3 != triangle) link = &next_corner[*link];
    if (*link != kNone) *link = next_corner[*link];
  }
};

/// One thread's work on one block: reads and writes no point or triangle of another block.
class Worker {
 public:
  Worker(Surface& surface, double error_mm)
      : s_(surface),
        error2_(std::pow(kFractionWhereFlat * error_mm, 2)),
        rough_error2_(std::pow(kFractionWhereRough * error_mm, 2)) {}

  /// Collapses each point of the list into a neighbour if this costs at most `cost_mm`. Returns the number of
  /// collapses.
  std::size_t Sweep(std::span<const Id> block_points, int sweep, double cost_mm, bool last) {
    sweep_ = static_cast<std::uint8_t>(sweep);
    cost_is_last_ = last;
    std::size_t count = 0;
    for (const Id p : block_points) {
      if (s_.first_corner[p] == kNone || s_.frozen[p] || s_.failed[p] || s_.moved_in[p] == sweep_) continue;
      count += CollapseAt(p, cost_mm * cost_mm) ? 1 : 0;
    }
    return count;
  }

 private:
  bool CollectNeighbours(Id p, std::vector<Id>& neighbours, std::vector<Id>& triangles) const {
    neighbours.clear();
    triangles.clear();
    bool inside = true;
    s_.ForEachTriangleAt(p, [&](Id t) {
      triangles.push_back(t);
      for (const Id q : s_.triangles[t]) {
        if (q == p || std::find(neighbours.begin(), neighbours.end(), q) != neighbours.end()) continue;
        neighbours.push_back(q);
        inside = inside && s_.block[q] == s_.block[p];
      }
    });
    return inside;
  }

  bool CollapseAt(Id a, double cost2) {
    if (!CollectNeighbours(a, near_a_, at_a_)) return false;
    choices_.clear();
    const Quadric& own = s_.quadrics[a];
    for (const Id b : near_a_) {
      if (s_.moved_in[b] == sweep_) continue;
      const Vec3 along = s_.points[b] - s_.points[a];
      // Where the surface is flat, short edges are collapsed first, which keeps triangles well shaped.
      choices_.push_back({std::max(0.0, own(s_.points[b])) / own.weight + 1e-6 * glm::dot(along, along), b, Vec3(0)});
    }
    std::sort(choices_.begin(), choices_.end(),
              [](const Choice& x, const Choice& y) { return x.cost != y.cost ? x.cost < y.cost : x.b < y.b; });
    // Further choices are hardly ever possible if the best two are not.
    for (std::size_t i = 0; i < std::min<std::size_t>(choices_.size(), 2); ++i) {
      Choice& c = choices_[i];
      Quadric q = own;
      q += s_.quadrics[c.b];
      c.place = s_.frozen[c.b] ? s_.points[c.b] : q.CalcMinimum(0.5 * (s_.points[a] + s_.points[c.b]));
      if (!(std::max(0.0, q(c.place)) <= cost2 * q.weight) || !MayCollapse(a, c)) continue;
      Collapse(a, c);
      return true;
    }
    s_.failed[a] = cost_is_last_ ? 1 : 0;
    return false;
  }

  struct Choice {
    double cost;
    Id b;
    Vec3 place;
  };

  bool MayCollapse(Id a, const Choice& c) {
    other_ = a;
    if (!CollectNeighbours(c.b, near_b_, at_b_)) return false;
    // Link condition (see decimate.cpp).
    std::size_t shared = 0;
    for (const Id p : near_a_) shared += std::find(near_b_.begin(), near_b_.end(), p) != near_b_.end() ? 1 : 0;
    std::size_t opposite = 0;
    targets_.clear();
    for (const Id t : at_a_) {
      const bool dies = Has(s_.triangles[t], c.b);
      opposite += dies ? 1 : 0;
      if (dies) {
        for (const Id p : s_.triangles[t]) {
          if (p != a && p != c.b && CountTriangles(p) <= 3) return false;  // would leave two triangles back to back
        }
      } else if (!AddTarget(t, a, c)) {
        return false;
      }
    }
    if (opposite != 2 || shared != 2) return false;
    for (const Id t : at_b_) {
      if (!Has(s_.triangles[t], a) && !AddTarget(t, c.b, c)) return false;
    }
    return KeepsNear(c);
  }

  static bool Has(const std::array<Id, 3>& t, Id p) { return t[0] == p || t[1] == p || t[2] == p; }

  int CountTriangles(Id p) const {
    int count = 0;
    s_.ForEachTriangleAt(p, [&](Id) { ++count; });
    return count;
  }

  /// Adds the triangle as it would be with its corner `moves` at the new place. Returns false if it would be folded
  /// over or a sliver.
  bool AddTarget(Id t, Id moves, const Choice& c) {
    Target target;
    target.id = t;
    target.corners = s_.triangles[t];
    Vec3 p[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const bool here = target.corners[k] == moves;
      p[k] = here ? c.place : s_.points[target.corners[k]];
      if (here) target.corners[k] = c.b;
    }
    target.points = {p[0], p[1], p[2]};
    if (!KeepsTriangleShape(s_.Normal(s_.triangles[t]), p, kMinCosine, kWorstShape)) return false;
    Shape(target);
    targets_.push_back(target);
    return true;
  }

  /// Returns whether each point of the full surface that was near the old triangles is within the error of a new one,
  /// and whether the new place is within the error of the plane of the closest such point. Records the nearest new
  /// triangles in `assigned_`.
  bool KeepsNear(const Choice& c) {
    assigned_.clear();
    bool rough = false;
    double farthest2 = 0;
    double closest2 = 0;
    Id closest = kNone;
    const auto find_near = [&](Id t) {
      for (Id p = s_.first_near[t]; p != kNone; p = s_.next_near[p]) {
        double best2 = error2_;
        Target* best = nullptr;
        for (Target& target : targets_) {
          const double d2 = CalcDistance2(s_.full[p], target, best2);
          if (d2 >= best2) continue;
          const double cosine = glm::dot(s_.full_normals[p], target.normal);
          if (cosine < kMinCosineToFull) continue;
          best2 = d2;
          best = &target;
          rough = rough || cosine < s_.rough_cosine;
        }
        if (best == nullptr) return false;
        best->has_points = true;
        farthest2 = std::max(farthest2, best2);
        assigned_.push_back({p, best->id});
        const Vec3 off = s_.full[p] - c.place;
        const double d2 = glm::dot(off, off);
        if (closest == kNone || d2 < closest2) closest = p, closest2 = d2;
      }
      return true;
    };
    for (const Id t : at_a_) {
      if (!find_near(t)) return false;
    }
    for (const Id t : at_b_) {
      if (!Has(s_.triangles[t], other_) && !find_near(t)) return false;
    }
    if (closest == kNone) return true;
    const double off = glm::dot(c.place - s_.full[closest], s_.full_normals[closest]);
    farthest2 = std::max(farthest2, off * off);
    for (const Target& target : targets_) {
      rough = rough || glm::dot(target.normal, s_.full_normals[closest]) < s_.rough_cosine;
    }
    if (farthest2 > (rough ? rough_error2_ : error2_)) return false;
    // Where the surface is flat and there are points everywhere, the new triangles are near the full surface if the
    // full surface is near them.
    return std::all_of(targets_.begin(), targets_.end(), [&](const Target& target) {
      return (!rough && (target.has_points || target.area_mm2 < 4 * s_.mean_area_mm2)) || IsNearFull(target);
    });
  }

  bool IsNearFull(const Target& target) {
    const Vec3 u = target.points[1] - target.points[0];
    const Vec3 v = target.points[2] - target.points[0];
    const double longest = std::sqrt(std::max({glm::dot(u, u), glm::dot(v, v), glm::dot(u - v, u - v)}));
    const int n = std::clamp(static_cast<int>(longest / (3 * std::sqrt(rough_error2_))) + 1, 2, 16);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        if (!IsNearFull(target.points[0] + u * (1.0 * i / n) + v * (1.0 * j / n))) return false;
      }
    }
    return true;
  }

  /// Returns whether `x` is near the full surface, tested on the triangles around its three closest points in
  /// `assigned_`.
  bool IsNearFull(const Vec3& x) {
    std::array<std::pair<double, Id>, 3> closest;
    closest.fill({1e300, kNone});
    for (const auto& [p, t] : assigned_) {
      const Vec3 off = s_.full[p] - x;
      const double d2 = glm::dot(off, off);
      if (d2 >= closest[2].first) continue;
      closest[2] = {d2, p};
      if (closest[2] < closest[1]) std::swap(closest[1], closest[2]);
      if (closest[1] < closest[0]) std::swap(closest[0], closest[1]);
    }
    for (const auto& [d2, p] : closest) {
      if (p == kNone) break;
      if (d2 < rough_error2_) return true;
      bool near = false;
      s_.ForEachFullTriangleAt(p, [&](Id t) {
        const auto& [i, j, k] = s_.full_triangles[t];
        near = near || CalcDistance2(x, MakeTarget(s_.full[i], s_.full[j], s_.full[k]), rough_error2_) < rough_error2_;
      });
      if (near) return true;
    }
    return false;
  }

  void Collapse(Id a, const Choice& c) {
    const Id b = c.b;
    for (const Id t : at_a_) {
      if (!Has(s_.triangles[t], b)) continue;
      for (const Id p : s_.triangles[t]) {
        if (p != a) s_.Unlink(p, t);
      }
      s_.dead[t] = 1;
      s_.first_near[t] = kNone;
    }
    for (const Target& target : targets_) {
      s_.first_near[target.id] = kNone;
      if (s_.triangles[target.id] == target.corners) continue;
      s_.triangles[target.id] = target.corners;
      const auto k =
          static_cast<Id>(std::find(target.corners.begin(), target.corners.end(), b) - target.corners.begin());
      s_.next_corner[3 * target.id + k] = s_.first_corner[b];
      s_.first_corner[b] = 3 * target.id + k;
    }
    for (const auto& [p, t] : assigned_) {
      s_.next_near[p] = s_.first_near[t];
      s_.first_near[t] = p;
    }
    s_.first_corner[a] = kNone;
    s_.points[b] = c.place;
    s_.quadrics[b] += s_.quadrics[a];
    s_.moved_in[b] = sweep_;
    s_.failed[b] = 0;
    for (const Target& target : targets_) {
      for (const Id p : target.corners) s_.failed[p] = 0;
    }
  }

  Surface& s_;
  double error2_;
  double rough_error2_;
  std::uint8_t sweep_ = 0;
  bool cost_is_last_ = false;
  Id other_ = kNone;
  std::vector<Id> near_a_, near_b_, at_a_, at_b_;
  std::vector<Choice> choices_;
  std::vector<Target> targets_;
  std::vector<std::pair<Id, Id>> assigned_;  // point of the full surface, its new triangle
};

/// Freezes rims, edges of more than two triangles, and borders between labels.
void Freeze(std::span<const Id> labels, Surface& s) {
  std::vector<Id> neighbours;
  for (Id p = 0; p < s.points.size(); ++p) {
    neighbours.clear();
    std::size_t count = 0;
    bool mixed = false;
    s.ForEachTriangleAt(p, [&](Id t) {
      ++count;
      for (const Id q : s.triangles[t]) {
        if (q == p || std::find(neighbours.begin(), neighbours.end(), q) != neighbours.end()) continue;
        neighbours.push_back(q);
        mixed = mixed || (!labels.empty() && labels[q] != labels[p]);
      }
    });
    s.frozen[p] = mixed || neighbours.size() != count ? 1 : 0;
  }
}

/// Returns the remaining points, block by block. The blocks of successive sweeps overlap: points on the border of a
/// block are inside a block of the next sweep.
std::vector<std::vector<Id>> MakeBlocks(const Box3& box, int sweep, Surface& s) {
  const Vec3 size = box.upper - box.lower;
  const double side = std::max({size.x, size.y, size.z, 1e-9}) / kBlocks;
  const Vec3 start = box.lower - side * (sweep % 3) / 3.0;
  std::array<Id, 3> counts{};
  for (int axis = 0; axis < 3; ++axis) counts[static_cast<std::size_t>(axis)] = static_cast<Id>(size[axis] / side) + 2;
  std::vector<std::vector<Id>> blocks(std::size_t{counts[0]} * counts[1] * counts[2]);
  for (Id p = 0; p < s.points.size(); ++p) {
    if (s.first_corner[p] == kNone) continue;
    const Vec3 at = (s.points[p] - start) / side;
    const auto cell = [&](int axis) {
      return std::min(static_cast<Id>(std::max(at[axis], 0.0)), counts[static_cast<std::size_t>(axis)] - 1);
    };
    s.block[p] = (cell(0) * counts[1] + cell(1)) * counts[2] + cell(2);
    blocks[s.block[p]].push_back(p);
  }
  std::erase_if(blocks, [](const std::vector<Id>& block) { return block.empty(); });
  return blocks;
}

std::size_t Sweep(const std::vector<std::vector<Id>>& blocks, int sweep, double cost_mm, double error_mm, Surface& s) {
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> collapsed = 0;
  const auto work = [&] {
    Worker worker(s, error_mm);
    for (std::size_t i = next++; i < blocks.size(); i = next++)
      collapsed += worker.Sweep(blocks[i], sweep, cost_mm, cost_mm >= error_mm);
  };
  const std::size_t thread_count =
      std::min<std::size_t>(std::max(1U, std::thread::hardware_concurrency()), blocks.size());
  std::vector<std::jthread> threads;
  for (std::size_t i = 1; i < thread_count; ++i) threads.emplace_back(work);
  work();
  threads.clear();
  return collapsed;
}

ReducedMesh TakeMesh(const Surface& s) {
  ReducedMesh out;
  std::vector<Id> ids(s.points.size(), kNone);
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    if (s.dead[t] != 0) continue;
    std::array<Id, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Id p = s.triangles[t][k];
      if (ids[p] == kNone) {
        ids[p] = static_cast<Id>(out.mesh.points.size());
        out.mesh.points.push_back(s.points[p]);
        out.from.push_back(p);
      }
      corners[k] = ids[p];
    }
    out.mesh.triangles.push_back(corners);
  }
  return out;
}

/// Sweeps until hardly any further collapse is possible within the error.
void SweepTo(double error_mm, const Box3& box, int& sweep, Surface& s) {
  // Collapses of low cost are done first, over the whole surface.
  double cost_mm = error_mm / 8;
  std::fill(s.failed.begin(), s.failed.end(), std::uint8_t{0});
  int slow_sweeps = 0;
  for (const int end = sweep + kMaxSweeps; sweep < end && slow_sweeps < 3; ++sweep) {
    const auto blocks = MakeBlocks(box, sweep, s);
    std::size_t left = 0;
    for (const auto& block : blocks) left += block.size();
    const std::size_t collapsed = Sweep(blocks, sweep, cost_mm, error_mm, s);
    slow_sweeps = cost_mm >= error_mm && collapsed * 50 < left ? slow_sweeps + 1 : 0;
    cost_mm = std::min(2 * cost_mm, error_mm);
  }
}

}  // namespace

std::vector<ReducedMesh> ReduceInSteps(const TriangleMesh& mesh, std::span<const double> errors_mm,
                                       std::span<const std::uint32_t> labels) {
  if (!labels.empty() && labels.size() != mesh.points.size()) {
    throw Error(fmt::format("a surface of {} points has {} labels", mesh.points.size(), labels.size()));
  }
  double last_mm = 0;
  for (const double error_mm : errors_mm) last_mm = std::max(last_mm, error_mm);
  Surface surface(mesh, last_mm);
  Freeze(labels, surface);
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  std::vector<ReducedMesh> steps;
  int sweep = 1;
  for (const double error_mm : errors_mm) {
    if (!(error_mm > 0)) throw Error(fmt::format("a surface can't be reduced to an error of {} mm", error_mm));
    SweepTo(error_mm, box, sweep, surface);
    steps.push_back(TakeMesh(surface));
  }
  return steps;
}

ReducedMesh Reduce(const TriangleMesh& mesh, double error_mm, std::span<const std::uint32_t> labels) {
  return std::move(ReduceInSteps(mesh, {&error_mm, 1}, labels).front());
}

}  // namespace kerf
