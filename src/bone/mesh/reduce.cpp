#include "bone/mesh/reduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include "bone/mesh/near_points.h"
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
// Each sweep at most halves the number of points. The number of a sweep must fit in a byte.
constexpr int kMaxSweeps = 24;
// Fraction of the remaining time that a sweep takes, about, as later ones have fewer points.
constexpr double kTimeOfSweep = 0.15;
// Distances at points are limited to this fraction of the error, so that distances between points are within the full
// error. At edges and in gaps, where distances between points can be several times those at points, the smaller
// fraction is used.
constexpr double kFractionWhereFlat = 0.4;
constexpr double kFractionWhereRough = 0.3;
// A place is rough if a new triangle is tilted against the nearby full surface so much that over an edge of the full
// surface the distance changes by this many times the error. Above an angle of 18 degrees a place is always rough.
constexpr double kRoughErrors = 1.5;
constexpr double kMaxRoughSine = 0.31;
// Below this cosine a point does not count as near: the triangle is folded over or belongs to another wall.
constexpr float kMinCosineToFull = 0.2F;

/// A new triangle, all of whose corners but the place of the collapse stay.
struct Target {
  std::array<Id, 3> corners{};
  Id id = 0;
  bool has_points = false;  // some points of the full surface are nearest to it
};

/// Returns whether a point is nearer to a triangle than the given distance.
bool IsNear(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, double distance2) {
  const Vec3 sides[3] = {b - a, c - b, a - c};
  const Vec3 from[3] = {p - a, p - b, p - c};
  const Vec3 normal = glm::cross(sides[0], sides[1]);
  const double off = glm::dot(from[0], normal);
  if (off * off >= distance2 * glm::dot(normal, normal)) return false;
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    if (glm::dot(glm::cross(normal, sides[k]), from[k]) >= 0) continue;
    inside = false;
    const double along = std::clamp(glm::dot(from[k], sides[k]) / glm::dot(sides[k], sides[k]), 0.0, 1.0);
    const Vec3 rest = from[k] - along * sides[k];
    if (glm::dot(rest, rest) < distance2) return true;
  }
  return inside;
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
        error2_(static_cast<float>(std::pow(kFractionWhereFlat * error_mm, 2))),
        rough_error2_(static_cast<float>(std::pow(kFractionWhereRough * error_mm, 2))) {}

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
    shapes_.clear();
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
    if (!KeepsTriangleShape(s_.Normal(s_.triangles[t]), p, kMinCosine, kWorstShape)) return false;
    const auto here =
        static_cast<std::size_t>(std::find(target.corners.begin(), target.corners.end(), c.b) - target.corners.begin());
    shapes_.emplace_back(Vec3f(p[(here + 1) % 3] - c.place), Vec3f(p[(here + 2) % 3] - c.place));
    targets_.push_back(target);
    return true;
  }

  /// Returns whether each point of the full surface that was near the old triangles is within the error of a new one,
  /// and whether the new place is within the error of the plane of the closest such point. Records the nearest new
  /// triangles in `nearest_`.
  bool KeepsNear(const Choice& c) {
    last_near_ = kNone;
    near_ids_.clear();
    const auto add_near = [&](Id t) {
      for (Id p = s_.first_near[t]; p != kNone; p = s_.next_near[p]) near_ids_.push_back(p);
    };
    for (const Id t : at_a_) add_near(t);
    for (const Id t : at_b_) {
      if (!Has(s_.triangles[t], other_)) add_near(t);
    }
    if (near_ids_.empty()) return true;
    near_.Resize(near_ids_.size());
    for (std::size_t i = 0; i < near_ids_.size(); ++i) {
      near_.Set(i, Vec3f(s_.full[near_ids_[i]] - c.place), Vec3f(s_.full_normals[near_ids_[i]]));
    }
    near_.FindNearest(shapes_, error2_, kMinCosineToFull);
    nearest_.resize(near_.size());
    float farthest2 = 0;
    float least_cosine = 1;
    float closest2 = NearPoints::kFar;
    std::size_t closest = 0;
    for (std::size_t i = 0; i < near_.size(); ++i) {
      NearPoints::Nearest nearest = near_.nearest(i);
      if (nearest.distance2 >= error2_ && !FindNearSide(i, nearest)) return false;
      nearest_[i] = static_cast<std::size_t>(nearest.triangle);
      targets_[nearest_[i]].has_points = true;
      farthest2 = std::max(farthest2, nearest.distance2);
      least_cosine = std::min(least_cosine, nearest.least_cosine);
      const float d2 = glm::dot(near_.point(i), near_.point(i));
      if (d2 < closest2) closest = i, closest2 = d2;
    }
    const float off = glm::dot(near_.point(closest), near_.normal(closest));
    farthest2 = std::max(farthest2, off * off);
    for (const PlaceTriangle& t : shapes_) {
      least_cosine = std::min(least_cosine, glm::dot(t.normal, near_.normal(closest)));
    }
    const bool rough = static_cast<double>(least_cosine) < s_.rough_cosine;
    if (farthest2 > (rough ? rough_error2_ : error2_)) return false;
    // Where the surface is flat and there are points everywhere, the new triangles are near the full surface if the
    // full surface is near them.
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      if (!rough && (targets_[k].has_points || static_cast<double>(shapes_[k].CalcArea_mm2()) < 4 * s_.mean_area_mm2))
        continue;
      if (!IsNearFull(shapes_[k], c.place)) return false;
    }
    return true;
  }

  /// Finds the nearest of the new triangles for a point that lies beyond their sides.
  bool FindNearSide(std::size_t i, NearPoints::Nearest& nearest) const {
    const Vec3f p = near_.point(i);
    nearest.distance2 = error2_;
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      const PlaceTriangle& t = shapes_[k];
      const float off = glm::dot(p, t.normal);
      if (off * off >= nearest.distance2) continue;
      const float cosine = glm::dot(near_.normal(i), t.normal);
      if (cosine < kMinCosineToFull) continue;
      const float d2 = t.CalcDistance2BeyondSides(p);
      if (d2 >= nearest.distance2) continue;
      nearest = {d2, static_cast<int>(k), std::min(nearest.least_cosine, cosine)};
    }
    return nearest.distance2 < error2_;
  }

  bool IsNearFull(const PlaceTriangle& t, const Vec3& place) {
    const Vec3f& u = t.from;
    const Vec3f& v = t.to;
    const float longest = std::sqrt(std::max({glm::dot(u, u), glm::dot(v, v), glm::dot(u - v, u - v)}));
    const int n = std::clamp(static_cast<int>(longest / (3 * std::sqrt(rough_error2_))) + 1, 2, 16);
    const float step = 1 / static_cast<float>(n);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        if (!IsNearFull(u * (step * static_cast<float>(i)) + v * (step * static_cast<float>(j)), place)) return false;
      }
    }
    return true;
  }

  /// Returns whether a location near the place is near the full surface, tested on the triangle that was near the last
  /// location and on those around the three closest points.
  bool IsNearFull(const Vec3f& x, const Vec3& place) {
    const Vec3 x_W = place + Vec3(x);
    const auto is_near = [&](Id t) {
      const auto& [p, q, r] = s_.full_triangles[t];
      return IsNear(x_W, s_.full[p], s_.full[q], s_.full[r], static_cast<double>(rough_error2_));
    };
    if (last_near_ != kNone && is_near(last_near_)) return true;
    for (const std::size_t i : near_.FindClosest(x)) {
      bool near = false;
      s_.ForEachFullTriangleAt(near_ids_[i], [&](Id t) {
        if (near || !is_near(t)) return;
        near = true;
        last_near_ = t;
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
    for (std::size_t i = 0; i < near_ids_.size(); ++i) {
      Id& first = s_.first_near[targets_[nearest_[i]].id];
      s_.next_near[near_ids_[i]] = first;
      first = near_ids_[i];
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
  float error2_;
  float rough_error2_;
  std::uint8_t sweep_ = 0;
  bool cost_is_last_ = false;
  Id other_ = kNone;
  std::vector<Id> near_a_, near_b_, at_a_, at_b_;
  std::vector<Choice> choices_;
  std::vector<Target> targets_;
  std::vector<PlaceTriangle> shapes_;  // of targets_
  std::vector<Id> near_ids_;           // points of the full surface near the targets
  NearPoints near_;                    // the same
  std::vector<std::size_t> nearest_;   // the target of each
  Id last_near_ = kNone;               // triangle of the full surface
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

}  // namespace

ReducedMesh Reduce(const TriangleMesh& mesh, double error_mm, std::span<const std::uint32_t> labels,
                   const std::function<void(double)>& progress) {
  if (!(error_mm > 0)) throw Error(fmt::format("a surface can't be reduced to an error of {} mm", error_mm));
  if (!labels.empty() && labels.size() != mesh.points.size()) {
    throw Error(fmt::format("a surface of {} points has {} labels", mesh.points.size(), labels.size()));
  }
  Surface surface(mesh, error_mm);
  Freeze(labels, surface);
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  // Collapses of low cost are done first, over the whole surface.
  double cost_mm = error_mm / 8;
  bool is_slow = false;
  for (int sweep = 1; sweep <= kMaxSweeps && !is_slow; ++sweep) {
    const auto blocks = MakeBlocks(box, sweep, surface);
    std::size_t left = 0;
    for (const auto& block : blocks) left += block.size();
    const std::size_t collapsed = Sweep(blocks, sweep, cost_mm, error_mm, surface);
    if (progress) progress(1 - std::pow(1 - kTimeOfSweep, sweep));
    is_slow = cost_mm >= error_mm && collapsed * 50 < left;
    cost_mm = std::min(2 * cost_mm, error_mm);
  }
  ReducedMesh reduced = TakeMesh(surface);
  if (progress) progress(1);
  return reduced;
}

}  // namespace kerf
