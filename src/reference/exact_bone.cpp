#include "reference/exact_bone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace kerf {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kBits = 3;  // a group has 2^3 members
constexpr std::size_t kMembers = std::size_t{1} << kBits;
constexpr int kLevels = 7;
constexpr double kTie_mm = 1e-10;  // groups that are nearer by no more than this are not looked into

/// A disc that went straight in its own plane: a stadium of the disc's thickness, with the hole that all discs on the
/// way have in common.
struct Swept {
  Vec3 a{0};        // centre at the start, in the plane of the middle
  Vec3 way{0};      // of the centre, in that plane
  Vec3 n{0, 0, 1};  // the plane's normal
  double inverse_way2 = 0;
  double hole_mm = -1;  // radius; below 0: none
};

/// Around some of what was swept, in order of time.
struct Group {
  Box3 centres;  // of the discs
  Vec3 n{0, 0, 1};
  double z_lower = kInfinity, z_upper = -kInfinity;  // along n
  double hole_mm = kInfinity;                        // the smallest
};

/// Angle between two planes' normals as a sine.
double CalcSine(const Vec3& n_a, const Vec3& n_b) {
  return glm::length(glm::cross(n_a, n_b));
}

/// The orientation half-way.
Quat CalcMiddle(const Quat& a, const Quat& b) {
  const Quat near_b = glm::dot(a, b) < 0 ? -b : b;
  return glm::normalize(a + near_b);
}

}  // namespace

struct ExactBone::State {
  double CalcDistance(const Swept& s, const Vec3& p) const {
    const Vec3 q = p - s.a;
    const double z = glm::dot(q, s.n);
    const Vec3 flat = q - z * s.n;
    const double t = std::clamp(glm::dot(flat, s.way) * s.inverse_way2, 0.0, 1.0);
    double across = glm::length(flat - t * s.way) - radius_mm;
    if (s.hole_mm >= 0) {
      across = std::max(across, s.hole_mm - std::max(glm::length(flat), glm::length(flat - s.way)));
    }
    const double along = std::abs(z) - half_mm;
    return across > 0 && along > 0 ? std::hypot(across, along) : std::max(across, along);
  }

  /// No member's signed distance is less.
  double CalcBound(const Group& g, const Vec3& p) const {
    const double z = glm::dot(p, g.n);
    double bound = std::max(g.z_lower - z, z - g.z_upper);
    const Vec3 beyond = glm::max(glm::max(g.centres.lower - p, p - g.centres.upper), Vec3(0));
    const double nearest = glm::length(beyond);
    if (nearest > 0) bound = std::max(bound, nearest - reach_mm);
    if (g.hole_mm > 0) {
      const Vec3 furthest = glm::max(glm::abs(g.centres.lower - p), glm::abs(g.centres.upper - p));
      bound = std::max(bound, g.hole_mm - glm::length(furthest));
    }
    return bound;
  }

  void Add(const Swept& s) {
    const std::size_t index = swept.size();
    swept.push_back(s);
    for (int level = 0; level < kLevels; ++level) {
      const std::size_t at = index >> (kBits * (level + 1));
      if (at == groups[level].size()) {
        groups[level].emplace_back();
        groups[level].back().n = s.n;
      }
      Group& g = groups[level][at];
      g.centres.Include(s.a);
      g.centres.Include(s.a + s.way);
      g.hole_mm = std::min(g.hole_mm, s.hole_mm);
      const double thickness = half_mm + radius_mm * CalcSine(s.n, g.n);
      for (const Vec3& centre : {s.a, s.a + s.way}) {
        g.z_lower = std::min(g.z_lower, glm::dot(centre, g.n) - thickness);
        g.z_upper = std::max(g.z_upper, glm::dot(centre, g.n) + thickness);
      }
    }
  }

  /// Lowers `least` to the least signed distance of the group's members; looks no further when it is below `enough`.
  void FindLeast(int level, std::size_t at, const Vec3& p, double enough, double& least) const {
    const std::size_t begin = at << kBits;
    if (level == 0) {
      const std::size_t end = std::min(begin + kMembers, swept.size());
      for (std::size_t i = end; i-- > begin && least > enough;) least = std::min(least, CalcDistance(swept[i], p));
      return;
    }
    const std::size_t end = std::min(begin + kMembers, groups[level - 1].size());
    std::array<std::pair<double, std::size_t>, kMembers> order;
    std::size_t count = 0;
    for (std::size_t i = end; i-- > begin;) {  // newest first: what is asked lies mostly near them
      const double bound = CalcBound(groups[level - 1][i], p);
      if (bound >= least - kTie_mm) continue;
      std::size_t k = count++;
      for (; k > 0 && order[k - 1].first > bound; --k) order[k] = order[k - 1];
      order[k] = {bound, i};
    }
    for (std::size_t k = 0; k < count && least > enough; ++k) {
      if (order[k].first < least - kTie_mm) FindLeast(level - 1, order[k].second, p, enough, least);
    }
  }

  double FindLeast(const Vec3& p, double most, double enough) const {
    double least = most;
    for (std::size_t at = groups[kLevels - 1].size(); at-- > 0 && least > enough;) {
      if (CalcBound(groups[kLevels - 1][at], p) < least) FindLeast(kLevels - 1, at, p, enough, least);
    }
    return least;
  }

  ExactSolid solid;
  double radius_mm = 0;
  double half_mm = 0;
  double reach_mm = 0;
  std::vector<Swept> swept;
  std::array<std::vector<Group>, kLevels> groups;  // of 8 sweeps, of 8 groups of those, ...
  Box3 bounds;
};

ExactBone::ExactBone(ExactSolid solid, const DiscSaw& saw) : state_(std::make_unique<State>()) {
  state_->solid = std::move(solid);
  state_->radius_mm = saw.radius_mm();
  state_->half_mm = 0.5 * saw.thickness_mm;
  state_->reach_mm = std::hypot(state_->radius_mm, state_->half_mm);
}
ExactBone::~ExactBone() = default;
ExactBone::ExactBone(ExactBone&&) noexcept = default;
ExactBone& ExactBone::operator=(ExactBone&&) noexcept = default;

void ExactBone::Sweep(const Pose& X_a, const Pose& X_b, double edge_mm) {
  State& s = *state_;
  const Vec3 way = X_b.p_AB - X_a.p_AB;
  // The distance function may rise twice as fast as the distance.
  if (s.solid.distance_mm(X_a.p_AB) > 2 * (s.reach_mm + glm::length(way))) return;
  Swept swept;
  swept.n = CalcMiddle(X_a.R_AB, X_b.R_AB) * Vec3(0, 0, 1);
  const double along = glm::dot(way, swept.n);
  swept.a = X_a.p_AB + 0.5 * along * swept.n;
  swept.way = way - along * swept.n;
  const double way2 = glm::dot(swept.way, swept.way);
  swept.inverse_way2 = way2 > 0 ? 1 / way2 : 0;
  swept.hole_mm = edge_mm > 0 ? s.radius_mm - edge_mm : -1;
  s.Add(swept);
  for (const Vec3& centre : {swept.a, swept.a + swept.way}) {
    // A disc reaches R sqrt(1 - n_i^2) along axis i, and half its thickness times n_i.
    const Vec3 n2 = swept.n * swept.n;
    const Vec3 reach = s.radius_mm * glm::sqrt(glm::max(Vec3(1) - n2, Vec3(0))) + s.half_mm * glm::abs(swept.n);
    s.bounds.Include(centre - reach);
    s.bounds.Include(centre + reach);
  }
}

double ExactBone::Distance(const Vec3& p_W) const {
  return std::max(state_->solid.distance_mm(p_W), -state_->FindLeast(p_W, kInfinity, -kInfinity));
}

bool ExactBone::IsSwept(const Vec3& p_W) const {
  return state_->FindLeast(p_W, 2 * kTie_mm, 0) <= 0;
}

double ExactBone::SweptDistance(const Vec3& p_W, double most_mm) const {
  return state_->FindLeast(p_W, most_mm, -kInfinity);
}

namespace {

/// Of a cube: how much of it was solid and is swept, by halving.
double CalcRemovedOf(const ExactBone& bone, const Vec3& centre, double size_mm, double finest_mm) {
  const double reach_mm = 0.5 * std::sqrt(3.0) * size_mm;
  const double solid = bone.solid().distance_mm(centre);
  // The solid's distance may rise twice as fast as a distance.
  if (solid > 2 * reach_mm) return 0;
  const double swept = bone.SweptDistance(centre, reach_mm);
  if (swept >= reach_mm) return 0;
  const double whole = size_mm * size_mm * size_mm;
  if (solid < -2 * reach_mm && swept < -reach_mm) return whole;
  if (size_mm <= finest_mm) {
    const auto share = [size_mm](double distance) { return std::clamp(0.5 - distance / size_mm, 0.0, 1.0); };
    return whole * share(solid) * share(swept);
  }
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3 side(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    sum += CalcRemovedOf(bone, centre + 0.25 * size_mm * side, 0.5 * size_mm, finest_mm);
  }
  return sum;
}

}  // namespace

double ExactBone::CalcRemoved(double finest_mm) const {
  const Box3& box = state_->bounds;
  if (box.empty()) return 0;
  constexpr double kCoarsest_mm = 1;
  double sum = 0;
  for (double x = box.lower.x; x < box.upper.x; x += kCoarsest_mm) {
    for (double y = box.lower.y; y < box.upper.y; y += kCoarsest_mm) {
      for (double z = box.lower.z; z < box.upper.z; z += kCoarsest_mm) {
        sum += CalcRemovedOf(*this, Vec3(x, y, z) + Vec3(0.5 * kCoarsest_mm), kCoarsest_mm, finest_mm);
      }
    }
  }
  return sum;
}

const ExactSolid& ExactBone::solid() const {
  return state_->solid;
}

Box3 ExactBone::swept_bounds() const {
  return state_->bounds;
}

}  // namespace kerf
