#include "experiment/reference/exact_bone.h"

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
constexpr double kBent_mm = 1e-10;  // a path counts as straight if it is at most this far from a line
constexpr double kTie_mm = 1e-10;   // groups that are nearer by at most this much are not visited

/// Sweep of a disc that moved straight in its own plane: a stadium of the disc's thickness, with the hole that all
/// discs along the path have in common.
struct Swept {
  Vec3 a{0};        // centre at the start, in the central plane
  Vec3 motion{0};   // of the centre, in that plane
  Vec3 n{0, 0, 1};  // the plane's normal
  double inverse_length2 = 0;
  double hole_mm = -kInfinity;  // radius; below 0: none
};

/// Bound of several consecutive sweeps: a stadium about the segment from the first centre to the last.
struct Group {
  Vec3 a{0}, b{0};    // the segment
  double off_mm = 0;  // maximum distance of a centre from the segment
  Vec3 n{0, 0, 1};
  double tilt = 0;                                   // maximum sine of the angle between n and a disc's normal
  double z_lower = kInfinity, z_upper = -kInfinity;  // along n
  double hole_mm = kInfinity;                        // smallest radius of the members' holes
  Vec3 flat_segment{0};                              // component of the segment across n
  double inverse_length2 = 0;
  double reach_mm = 0;  // across n, from the segment
};

/// Returns 1 / x, or 0 if x is not positive.
double Invert(double x) {
  return x > 0 ? 1 / x : 0;
}

double CalcDistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 segment = b - a;
  const double t = std::clamp(glm::dot(p - a, segment) * Invert(glm::dot(segment, segment)), 0.0, 1.0);
  return glm::length(p - a - t * segment);
}

/// Returns the distance to a plate, negative inside. The point is `along` beyond its faces and `across` beyond its
/// edge.
double CalcPlateDistance(double across, double along) {
  return across > 0 && along > 0 ? std::sqrt(across * across + along * along) : std::max(across, along);
}

/// Returns the sine of the angle between the normals of two planes.
double CalcSine(const Vec3& n_a, const Vec3& n_b) {
  return glm::length(glm::cross(n_a, n_b));
}

/// Returns the orientation halfway between a and b.
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
    const double t = std::clamp(glm::dot(flat, s.motion) * s.inverse_length2, 0.0, 1.0);
    double across = glm::length(flat - t * s.motion) - radius_mm;
    if (s.hole_mm >= 0) {
      across = std::max(across, s.hole_mm - std::max(glm::length(flat), glm::length(flat - s.motion)));
    }
    return CalcPlateDistance(across, std::abs(z) - half_mm);
  }

  /// Returns a lower bound of the members' signed distances: that of a plate that contains all members, to which a
  /// point is at least as near and in which it is at least as deep.
  double CalcBound(const Group& g, const Vec3& p) const {
    const Vec3 q = p - g.a;
    const double z = glm::dot(q, g.n);
    const Vec3 flat = q - z * g.n;
    const double t = std::clamp(glm::dot(flat, g.flat_segment) * g.inverse_length2, 0.0, 1.0);
    const double across = glm::length(flat - t * g.flat_segment) - g.reach_mm;
    const double bound = CalcPlateDistance(across, std::max(g.z_lower - z, z - g.z_upper));
    if (!(g.hole_mm > bound)) return bound;
    return std::max(bound, g.hole_mm - g.off_mm - std::max(glm::length(q), glm::length(p - g.b)));
  }

  /// Updates the groups for the member at `index`, which is new or has been extended.
  void Include(std::size_t index) {
    const Swept& s = swept[index];
    for (int level = 0; level < kLevels; ++level) {
      const std::size_t at = index >> (kBits * (level + 1));
      if (at == groups[level].size()) {
        groups[level].emplace_back();
        groups[level].back().a = s.a;
        groups[level].back().n = s.n;
      }
      Group& g = groups[level][at];
      const double sine = CalcSine(s.n, g.n);
      const double thickness = half_mm + radius_mm * sine;
      for (const Vec3& centre : {s.a, s.a + s.motion}) {
        const double z = glm::dot(centre - g.a, g.n);
        g.z_lower = std::min(g.z_lower, z - thickness);
        g.z_upper = std::max(g.z_upper, z + thickness);
      }
      g.hole_mm = std::min(g.hole_mm, s.hole_mm);
      g.tilt = std::max(g.tilt, sine);
      g.b = s.a + s.motion;
      g.flat_segment = g.b - g.a - glm::dot(g.b - g.a, g.n) * g.n;
      g.inverse_length2 = Invert(glm::dot(g.flat_segment, g.flat_segment));
      g.off_mm = CalcMaxOffset(level, at, g);
      g.reach_mm = radius_mm + half_mm * g.tilt + g.off_mm;
    }
  }

  /// Returns the maximum distance of the members' centres from the group's segment. The distance of a segment from
  /// another one is largest at one of its ends.
  double CalcMaxOffset(int level, std::size_t at, const Group& g) const {
    double off_mm = 0;
    const auto include = [&](const Vec3& a, const Vec3& b, double more_mm) {
      off_mm = std::max(
          {off_mm, CalcDistanceToSegment(a, g.a, g.b) + more_mm, CalcDistanceToSegment(b, g.a, g.b) + more_mm});
    };
    const std::size_t begin = at << kBits;
    if (level == 0) {
      for (std::size_t i = begin; i < std::min(begin + kMembers, swept.size()); ++i) {
        include(swept[i].a, swept[i].a + swept[i].motion, 0);
      }
      return off_mm;
    }
    const std::vector<Group>& members = groups[level - 1];
    for (std::size_t i = begin; i < std::min(begin + kMembers, members.size()); ++i) {
      include(members[i].a, members[i].b, members[i].off_mm);
    }
    return off_mm;
  }

  void Add(const Swept& s) {
    if (swept.empty() || !Extend(s)) {
      swept.push_back(s);
      bent_mm = 0;
    }
    Include(swept.size() - 1);
  }

  /// Merges a sweep that continues straight in one plane with the last one. Returns false if it deviates by more than
  /// kBent_mm anywhere since the start of the merged sweep.
  bool Extend(const Swept& s) {
    Swept& last = swept.back();
    const Vec3 end = last.a + last.motion;
    if (s.hole_mm != last.hole_mm || !(glm::dot(s.motion, last.motion) > 0)) return false;
    const Vec3 motion = s.a + s.motion - last.a;
    const double z_mm = std::abs(glm::dot(motion, last.n)) + std::abs(glm::dot(s.a - last.a, last.n));
    const double bent = bent_mm + glm::length(s.a - end) + z_mm + radius_mm * CalcSine(s.n, last.n) +
                        CalcDistanceToSegment(end, last.a, last.a + motion);
    if (bent > kBent_mm) return false;
    bent_mm = bent;
    last.motion = motion - glm::dot(motion, last.n) * last.n;
    last.inverse_length2 = Invert(glm::dot(last.motion, last.motion));
    return true;
  }

  /// Lowers `min_mm` to the minimum signed distance of the group's members; stops once it is below `enough`.
  void FindMinDistance(int level, std::size_t at, const Vec3& p, double enough, double& min_mm) const {
    const std::size_t begin = at << kBits;
    if (level == 0) {
      const std::size_t end = std::min(begin + kMembers, swept.size());
      for (std::size_t i = end; i-- > begin && min_mm > enough;) min_mm = std::min(min_mm, CalcDistance(swept[i], p));
      return;
    }
    const std::size_t end = std::min(begin + kMembers, groups[level - 1].size());
    std::array<std::pair<double, std::size_t>, kMembers> order;
    std::size_t count = 0;
    for (std::size_t i = end; i-- > begin;) {  // newest first, since most queries are near the newest sweeps
      const double bound = CalcBound(groups[level - 1][i], p);
      if (bound >= min_mm - kTie_mm) continue;
      std::size_t k = count++;
      for (; k > 0 && order[k - 1].first > bound; --k) order[k] = order[k - 1];
      order[k] = {bound, i};
    }
    for (std::size_t k = 0; k < count && min_mm > enough; ++k) {
      if (order[k].first < min_mm - kTie_mm) FindMinDistance(level - 1, order[k].second, p, enough, min_mm);
    }
  }

  double FindMinDistance(const Vec3& p, double max_mm, double enough) const {
    double min_mm = max_mm;
    for (std::size_t at = groups[kLevels - 1].size(); at-- > 0 && min_mm > enough;) {
      if (CalcBound(groups[kLevels - 1][at], p) < min_mm) FindMinDistance(kLevels - 1, at, p, enough, min_mm);
    }
    return min_mm;
  }

  ExactSolid solid;
  double radius_mm = 0;
  double half_mm = 0;
  double reach_mm = 0;
  std::vector<Swept> swept;
  double bent_mm = 0;                              // of the last sweep
  std::array<std::vector<Group>, kLevels> groups;  // groups of 8 sweeps, of 8 such groups, ...
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
  const Vec3 motion = X_b.p_AB - X_a.p_AB;
  // The distance function may grow up to twice as fast as the distance.
  if (s.solid.distance_mm(X_a.p_AB) > 2 * (s.reach_mm + glm::length(motion))) return;
  Swept swept;
  swept.n = CalcMiddle(X_a.R_AB, X_b.R_AB) * Vec3(0, 0, 1);
  const double along = glm::dot(motion, swept.n);
  swept.a = X_a.p_AB + 0.5 * along * swept.n;
  swept.motion = motion - along * swept.n;
  swept.inverse_length2 = Invert(glm::dot(swept.motion, swept.motion));
  swept.hole_mm = edge_mm > 0 ? s.radius_mm - edge_mm : -kInfinity;
  s.Add(swept);
  for (const Vec3& centre : {swept.a, swept.a + swept.motion}) {
    // Along axis i, a disc reaches R sqrt(1 - n_i^2) plus half its thickness times |n_i|.
    const Vec3 n2 = swept.n * swept.n;
    const Vec3 reach = s.radius_mm * glm::sqrt(glm::max(Vec3(1) - n2, Vec3(0))) + s.half_mm * glm::abs(swept.n);
    s.bounds.Include(centre - reach);
    s.bounds.Include(centre + reach);
  }
}

double ExactBone::Distance(const Vec3& p_W) const {
  return std::max(state_->solid.distance_mm(p_W), -state_->FindMinDistance(p_W, kInfinity, -kInfinity));
}

bool ExactBone::IsSwept(const Vec3& p_W) const {
  return state_->FindMinDistance(p_W, 2 * kTie_mm, 0) <= 0;
}

double ExactBone::SweptDistance(const Vec3& p_W, double max_mm, double enough_mm) const {
  return state_->FindMinDistance(p_W, max_mm, enough_mm);
}
double ExactBone::SweptDistance(const Vec3& p_W, double max_mm) const {
  return SweptDistance(p_W, max_mm, -kInfinity);
}

namespace {

/// Returns the volume of the part of a cube that was solid and has been swept, found by recursive halving.
double CalcRemovedOf(const ExactBone& bone, const Vec3& centre, double size_mm, double finest_mm) {
  const double reach_mm = 0.5 * std::sqrt(3.0) * size_mm;
  const double solid = bone.solid().distance_mm(centre);
  // The solid's distance function may grow up to twice as fast as the distance.
  if (solid > 2 * reach_mm) return 0;
  const double swept = bone.SweptDistance(centre, reach_mm, -reach_mm);
  if (swept >= reach_mm) return 0;
  const double whole = size_mm * size_mm * size_mm;
  if (solid < -2 * reach_mm && swept < -reach_mm) return whole;
  if (size_mm <= finest_mm) {
    const auto fraction = [size_mm](double distance) { return std::clamp(0.5 - distance / size_mm, 0.0, 1.0); };
    // The original volume minus the remaining one: where a wall of the kerf coincides with a face of the solid, both
    // are blurred equally and no volume is lost.
    return whole * (fraction(solid) - fraction(std::max(solid, -swept)));
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
