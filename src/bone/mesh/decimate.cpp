#include "bone/mesh/decimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <queue>

#include "bone/mesh/quadric.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Id = std::uint32_t;

// Minimum cosine of the angle by which a triangle may turn when its corner moves.
constexpr double kMinStepCosine = 0.3;
// Longest edge squared over twice the area; 1.15 for an equilateral triangle. Triangles beyond this are slivers and are
// not made.
constexpr double kWorstStepShape = 60;

class Collapser {
 public:
  explicit Collapser(const TriangleMesh& mesh)
      : points_(mesh.points),
        triangles_(mesh.triangles),
        quadrics_(points_.size()),
        around_(points_.size()),
        versions_(points_.size(), 0),
        live_triangles_(triangles_.size()) {
    dead_.assign(triangles_.size(), false);
    std::vector<Id> degree(points_.size(), 0);
    for (const auto& t : triangles_) {
      for (const Id p : t) ++degree[p];
    }
    for (std::size_t p = 0; p < points_.size(); ++p) around_[p].reserve(degree[p]);
    for (Id i = 0; i < triangles_.size(); ++i) {
      const Vec3 n = Normal(triangles_[i]);  // its length is twice the area
      const double length = glm::length(n);
      for (const Id p : triangles_[i]) around_[p].push_back(i);
      if (!(length > 0)) continue;
      const Quadric q = Quadric::OfPlane(n / length, points_[triangles_[i][0]], 0.5 * length);
      for (const Id p : triangles_[i]) quadrics_[p] += q;
    }
    AddRims();
    for (const auto& t : triangles_) {
      // An inner edge occurs in two triangles and is pushed once; an edge of the rim occurs in one only.
      for (std::size_t k = 0; k < 3; ++k) {
        const Id a = t[k];
        const Id b = t[(k + 1) % 3];
        if (a < b || CountShared(a, b) < 2) Push(a, b);
      }
    }
  }

  void Run(std::size_t target) {
    while (live_triangles_ > target && !queue_.empty()) {
      const Candidate best = queue_.top();
      queue_.pop();
      if (best.version_a != versions_[best.a] || best.version_b != versions_[best.b]) continue;
      if (MayCollapse(best)) Collapse(best);
    }
  }

  TriangleMesh TakeMesh() const {
    TriangleMesh mesh;
    constexpr Id kNone = ~Id{0};
    std::vector<Id> new_ids(points_.size(), kNone);
    mesh.triangles.reserve(live_triangles_);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (dead_[i]) continue;
      std::array<Id, 3> t{};
      for (std::size_t k = 0; k < 3; ++k) {
        Id& id = new_ids[triangles_[i][k]];
        if (id == kNone) {
          id = static_cast<Id>(mesh.points.size());
          mesh.points.push_back(points_[triangles_[i][k]]);
        }
        t[k] = id;
      }
      mesh.triangles.push_back(t);
    }
    return mesh;
  }

 private:
  struct Candidate {
    double cost;
    Id a, b;
    std::uint32_t version_a, version_b;
    Vec3 place;
    // The queue's top has the lowest cost; ties are resolved by id, so that the result is the same everywhere.
    bool operator<(const Candidate& o) const {
      if (cost != o.cost) return cost > o.cost;
      return a != o.a ? a > o.a : b > o.b;
    }
  };

  Vec3 Normal(const std::array<Id, 3>& t) const {
    return glm::cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]);
  }
  static bool Has(const std::array<Id, 3>& t, Id p) { return t[0] == p || t[1] == p || t[2] == p; }

  int CountShared(Id a, Id b) const {
    int count = 0;
    for (const Id i : around_[a]) count += Has(triangles_[i], b) ? 1 : 0;
    return count;
  }

  // Where the surface is open, planes perpendicular to it through its rim keep the rim in place.
  void AddRims() {
    for (Id i = 0; i < triangles_.size(); ++i) {
      const auto& t = triangles_[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const Id a = t[k];
        const Id b = t[(k + 1) % 3];
        if (CountShared(a, b) != 1) continue;
        const Vec3 along = points_[b] - points_[a];
        const Vec3 upright = glm::cross(along, Normal(t));
        const double length = glm::length(upright);
        if (!(length > 0)) continue;
        const Quadric q = Quadric::OfPlane(upright / length, points_[a], 10 * glm::dot(along, along));
        quadrics_[a] += q;
        quadrics_[b] += q;
      }
    }
  }

  void Push(Id a, Id b) {
    Quadric q = quadrics_[a];
    q += quadrics_[b];
    const Vec3 middle = 0.5 * (points_[a] + points_[b]);
    const Vec3 place = q.CalcMinimum(middle);
    const Vec3 along = points_[b] - points_[a];
    // Where the surface is flat, all errors are zero. Short edges are then collapsed first, which keeps the triangles
    // well shaped.
    const double cost = std::max(0.0, q(place)) + 1e-6 * q.weight * glm::dot(along, along);
    queue_.push({cost, a, b, versions_[a], versions_[b], place});
  }

  void CollectNeighbours(Id p, std::vector<Id>& neighbours) const {
    neighbours.clear();
    for (const Id i : around_[p]) {
      for (const Id q : triangles_[i]) {
        if (q != p) neighbours.push_back(q);
      }
    }
    std::sort(neighbours.begin(), neighbours.end());
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  }

  bool MayCollapse(const Candidate& c) {
    // The surface keeps its topology if the only common neighbours of both ends are the corners opposite the edge (the
    // link condition of Dey, Edelsbrunner, Guha and Nekhayev, 1999).
    CollectNeighbours(c.a, near_a_);
    CollectNeighbours(c.b, near_b_);
    shared_.clear();
    std::set_intersection(near_a_.begin(), near_a_.end(), near_b_.begin(), near_b_.end(), std::back_inserter(shared_));
    std::size_t opposite = 0;
    for (const Id i : around_[c.a]) {
      if (!Has(triangles_[i], c.b)) continue;
      ++opposite;
    }
    if (opposite == 0 || opposite > 2 || shared_.size() != opposite) return false;
    if (opposite == 2) {
      // Collapsing an edge that crosses the surface from rim to rim would pinch it.
      if (IsOnRim(near_a_, c.a) && IsOnRim(near_b_, c.b)) return false;
      for (const Id p : shared_) {
        if (around_[p].size() <= 3) return false;  // would leave two triangles back to back
      }
    }
    return KeepsShape(c.a, c.b, c.place) && KeepsShape(c.b, c.a, c.place);
  }

  bool IsOnRim(const std::vector<Id>& neighbours, Id p) const { return neighbours.size() != around_[p].size(); }

  // Returns whether the triangles around `moved` that survive the collapse are neither folded over nor slivers.
  bool KeepsShape(Id moved, Id other, const Vec3& place) const {
    for (const Id i : around_[moved]) {
      const auto& t = triangles_[i];
      if (Has(t, other)) continue;
      Vec3 p[3];
      for (std::size_t k = 0; k < 3; ++k) p[k] = t[k] == moved ? place : points_[t[k]];
      if (!KeepsTriangleShape(Normal(t), p, kMinStepCosine, kWorstStepShape)) return false;
    }
    return true;
  }

  void Collapse(const Candidate& c) {
    points_[c.a] = c.place;
    quadrics_[c.a] += quadrics_[c.b];
    for (const Id i : around_[c.b]) {
      if (dead_[i]) continue;
      auto& t = triangles_[i];
      if (Has(t, c.a)) {
        dead_[i] = true;
        --live_triangles_;
        for (const Id p : t) {
          if (p != c.b) std::erase(around_[p], i);
        }
        continue;
      }
      std::replace(t.begin(), t.end(), c.b, c.a);
      around_[c.a].push_back(i);
    }
    std::vector<Id>().swap(around_[c.b]);
    ++versions_[c.a];
    ++versions_[c.b];
    CollectNeighbours(c.a, near_a_);
    for (const Id p : near_a_) Push(std::min(p, c.a), std::max(p, c.a));
  }

  std::vector<Vec3> points_;
  std::vector<std::array<Id, 3>> triangles_;
  std::vector<bool> dead_;
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<Id>> around_;  // triangles at each point
  std::vector<std::uint32_t> versions_;  // number of changes of a point; older candidates are invalid
  std::priority_queue<Candidate> queue_;
  std::size_t live_triangles_;
  std::vector<Id> near_a_, near_b_, shared_;
};

}  // namespace

TriangleMesh Decimate(const TriangleMesh& mesh, std::size_t triangles) {
  CheckRange("triangles", static_cast<double>(triangles), kTrianglesRange);
  if (mesh.triangles.size() <= triangles) return mesh;
  Collapser collapser(mesh);
  collapser.Run(triangles);
  return collapser.TakeMesh();
}

}  // namespace kerf
