// A surface is intersected with lines through the voxels' centres, parallel to z. The points at which rows of lines
// cross a triangle's edges decide whether a line crosses the triangle. An edge gives the same point for both of its
// triangles, so every line leaves a closed surface exactly as often as it enters it.
#include "cut/effects/structure_voxels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "bone/grid/interpolate.h"
#include "bone/grid/region_boxes.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr const char* kTooLarge = "is too large for the voxels of the bone's regions";

/// Intersection of a surface with a line along z.
struct Crossing {
  int x, y;
  double z;
  int direction;  // 1 or -1
};

struct Interval {
  double lower, upper;
};

/// Returns the part of the line at (x, y) along z that is in a ball about `centre`.
std::optional<Interval> CrossBall(const Vec3& centre, double radius, double x, double y) {
  const double dx = x - centre.x, dy = y - centre.y;
  const double square = radius * radius - dx * dx - dy * dy;
  if (square < 0) return {};
  const double half = std::sqrt(square);
  return Interval{centre.z - half, centre.z + half};
}

/// Returns the part of the line that is in the cylinder between a and b, without the balls at its ends.
std::optional<Interval> CrossCylinder(const Vec3& a, const Vec3& b, double radius, double x, double y) {
  const double length = glm::length(b - a);
  if (!(length > 0)) return {};
  const Vec3 u = (b - a) / length;
  const Vec3 w(x - a.x, y - a.y, -a.z);
  // |w + z e_z - ((w + z e_z) . u) u|^2 <= radius^2, in z.
  const double along = glm::dot(w, u);
  const double q2 = 1 - u.z * u.z;
  const double q1 = w.z - along * u.z;
  const double q0 = glm::dot(w, w) - along * along - radius * radius;
  Interval at{-1e300, 1e300};
  if (q2 > 1e-12) {
    const double root = q1 * q1 - q2 * q0;
    if (root < 0) return {};
    at = {(-q1 - std::sqrt(root)) / q2, (-q1 + std::sqrt(root)) / q2};
  } else if (q0 > 0) {
    return {};
  }
  // 0 <= along + z u.z <= length
  if (std::abs(u.z) > 1e-12) {
    const double at_a = -along / u.z, at_b = (length - along) / u.z;
    at = {std::max(at.lower, std::min(at_a, at_b)), std::min(at.upper, std::max(at_a, at_b))};
  } else if (along < 0 || along > length) {
    return {};
  }
  return at.lower <= at.upper ? std::optional(at) : std::nullopt;
}

/// Returns the x and z at which a triangle's edge crosses a row; the same for both directions of the edge.
std::pair<double, double> CrossRow(const Vec3& p, const Vec3& q, double y) {
  const bool swap = std::pair(q.y, std::pair(q.x, q.z)) < std::pair(p.y, std::pair(p.x, p.z));
  const Vec3& a = swap ? q : p;
  const Vec3& b = swap ? p : q;
  const double t = (y - a.y) / (b.y - a.y);
  return {a.x + t * (b.x - a.x), a.z + t * (b.z - a.z)};
}

}  // namespace

void StructureVoxels::Push(const Run& run) {
  if (runs_.size() >= kMaxRuns) throw Error(kTooLarge);
  runs_.push_back(run);
}

/// Adds the voxels with centres from `lower_mm` to `upper_mm`.
void StructureVoxels::Add(int x, int y, double lower_mm, double upper_mm) {
  const Run run{x, y, static_cast<int>(std::ceil(lower_mm / voxel_mm_)),
                static_cast<int>(std::floor(upper_mm / voxel_mm_))};
  if (run.z0 <= run.z1) Push(run);
}

void StructureVoxels::AddRegions(const Bone& bone, const std::array<bool, 256>& regions) {
  const double h = voxel_mm_;
  for (const Box3& box : FindRegionBoxes(bone, regions)) {
    const auto low = box.lower + Vec3(0.5 * h), high = box.upper - Vec3(0.5 * h);
    for (int x = NearestIndex(low.x, h); x <= NearestIndex(high.x, h); ++x) {
      for (int y = NearestIndex(low.y, h); y <= NearestIndex(high.y, h); ++y) {
        // Labels extend slightly beyond the bone, for interpolation. Voxels of air are not part of a structure.
        std::optional<int> first;
        const int end = NearestIndex(high.z, h) + 1;
        for (int z = NearestIndex(low.z, h); z <= end; ++z) {
          if (z < end && bone.SignedDistance(Vec3(x, y, z) * h) < 0) {
            if (!first) first = z;
          } else if (first) {
            Push({x, y, *first, z - 1});
            first.reset();
          }
        }
      }
    }
  }
}

void StructureVoxels::AddSurface(const TriangleMesh& closed_W) {
  std::vector<Crossing> crossings;
  for (const auto& triangle : closed_W.triangles) {
    const std::array<Vec3, 3> p{closed_W.points[triangle[0]], closed_W.points[triangle[1]],
                                closed_W.points[triangle[2]]};
    const double lower_y = std::min({p[0].y, p[1].y, p[2].y}), upper_y = std::max({p[0].y, p[1].y, p[2].y});
    const double turn = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
    for (int row = static_cast<int>(std::ceil(lower_y / voxel_mm_)); row * voxel_mm_ <= upper_y; ++row) {
      const double y = row * voxel_mm_;
      std::array<std::pair<double, double>, 2> ends{};
      std::size_t found = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& a = p[i];
        const Vec3& b = p[(i + 1) % 3];
        if ((a.y <= y) != (b.y <= y) && found < 2) ends[found++] = CrossRow(a, b, y);
      }
      if (found < 2) continue;
      if (ends[1].first < ends[0].first) std::swap(ends[0], ends[1]);
      const auto [x0, z0] = ends[0];
      const auto [x1, z1] = ends[1];
      for (int column = static_cast<int>(std::ceil(x0 / voxel_mm_)); column * voxel_mm_ < x1; ++column) {
        const double x = column * voxel_mm_;
        if (crossings.size() >= 2 * kMaxRuns) throw Error(kTooLarge);
        crossings.push_back({column, row, z0 + (x - x0) / (x1 - x0) * (z1 - z0), turn > 0 ? 1 : -1});
      }
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.x, a.y, a.z, a.direction) < std::tie(b.x, b.y, b.z, b.direction);
  });
  int around = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    const Crossing& here = crossings[i];
    const Crossing& next = crossings[i + 1];
    around += here.direction;
    if (here.x != next.x || here.y != next.y) {
      around = 0;
    } else if (around != 0) {
      Add(here.x, here.y, here.z, next.z);
    }
  }
}

void StructureVoxels::AddCurve(const EffectFile::Curve& curve_W, double radius_mm) {
  const std::vector<Vec3>& points = curve_W.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& a = points[i];
    const Vec3& b = points[curve_W.joined && i + 1 < points.size() ? i + 1 : i];
    const Vec3 lower = (glm::min(a, b) - Vec3(radius_mm)) / voxel_mm_;
    const Vec3 upper = (glm::max(a, b) + Vec3(radius_mm)) / voxel_mm_;
    if ((upper.x - lower.x) * (upper.y - lower.y) > static_cast<double>(kMaxRuns)) throw Error(kTooLarge);
    for (int x = static_cast<int>(std::ceil(lower.x)); x <= upper.x; ++x) {
      for (int y = static_cast<int>(std::ceil(lower.y)); y <= upper.y; ++y) {
        std::optional<Interval> all;
        for (const auto& part : {CrossBall(a, radius_mm, x * voxel_mm_, y * voxel_mm_),
                                 CrossBall(b, radius_mm, x * voxel_mm_, y * voxel_mm_),
                                 CrossCylinder(a, b, radius_mm, x * voxel_mm_, y * voxel_mm_)}) {
          if (!part) continue;
          // Two balls and the cylinder between them form a convex body, so the line crosses it in one interval.
          all = all ? Interval{std::min(all->lower, part->lower), std::max(all->upper, part->upper)} : *part;
        }
        if (all) Add(x, y, all->lower, all->upper);
      }
    }
  }
}

void StructureVoxels::Add(const StructureVoxels& other) {
  for (const Run& run : other.runs_) Push(run);
}

void StructureVoxels::Finish() {
  std::sort(runs_.begin(), runs_.end());
  std::size_t kept = 0;
  for (const Run& run : runs_) {
    Run* last = kept > 0 ? &runs_[kept - 1] : nullptr;
    if (last != nullptr && last->x == run.x && last->y == run.y && run.z0 <= last->z1 + 1) {
      last->z1 = std::max(last->z1, run.z1);
    } else {
      runs_[kept++] = Run(run);
    }
  }
  runs_.resize(kept);
  runs_.shrink_to_fit();
}

bool StructureVoxels::Contains(int x, int y, int z) const {
  const auto after = std::upper_bound(runs_.begin(), runs_.end(), Run{x, y, z, std::numeric_limits<int>::max()});
  if (after == runs_.begin()) return false;
  const Run& run = *std::prev(after);
  return run.x == x && run.y == y && z <= run.z1;
}

bool StructureVoxels::Contains(const Vec3& p_W) const {
  return Contains(NearestIndex(p_W.x, voxel_mm_), NearestIndex(p_W.y, voxel_mm_), NearestIndex(p_W.z, voxel_mm_));
}

double StructureVoxels::CalcVolume() const {
  double count = 0;
  for (const Run& run : runs_) count += run.z1 - run.z0 + 1;
  return count * voxel_mm_ * voxel_mm_ * voxel_mm_;
}

std::size_t StructureVoxels::CalcMemoryBytes() const {
  return sizeof(*this) + runs_.capacity() * sizeof(Run);
}

std::vector<Box3> StructureVoxels::MakeBoxes() const {
  std::vector<Box3> boxes;
  boxes.reserve(runs_.size());
  for (const Run& run : runs_) {
    boxes.push_back({(Vec3(run.x, run.y, run.z0) - 0.5) * voxel_mm_, (Vec3(run.x, run.y, run.z1) + 0.5) * voxel_mm_});
  }
  return boxes;
}

template <typename Visit>
void StructureVoxels::ForEachFace(Visit&& visit) const {
  for (const Run& run : runs_) {
    visit(run, 2, -1, run.z0, run.z0);
    visit(run, 2, 1, run.z1, run.z1);
    for (int axis = 0; axis < 2; ++axis) {
      for (int sign = -1; sign <= 1; sign += 2) {
        const int x = run.x + (axis == 0 ? sign : 0), y = run.y + (axis == 1 ? sign : 0);
        int z = run.z0;
        while (z <= run.z1) {
          if (Contains(x, y, z)) {
            ++z;
            continue;
          }
          const int first = z;
          while (z <= run.z1 && !Contains(x, y, z)) ++z;
          visit(run, axis, sign, first, z - 1);
        }
      }
    }
  }
}

std::vector<Box3> StructureVoxels::MakeShell() const {
  std::vector<Box3> boxes;
  ForEachFace([&](const Run& run, int axis, int sign, int z0, int z1) {
    Vec3 low(run.x, run.y, z0), high(run.x, run.y, z1);
    low[axis] += sign;
    high[axis] += sign;
    boxes.push_back({(low - 0.5) * voxel_mm_, (high + 0.5) * voxel_mm_});
  });
  return boxes;
}

TriangleMesh StructureVoxels::MakeSurface() const {
  TriangleMesh mesh;
  ForEachFace([&](const Run& run, int axis, int sign, int z0, int z1) {
    const Vec3 low = Vec3(run.x, run.y, z0) - 0.5, high = Vec3(run.x, run.y, z1) + 0.5;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (int i = 0; i < 4; ++i) {
      Vec3 p = sign > 0 ? high : low;
      p[u] = i == 1 || i == 2 ? high[u] : low[u];
      p[v] = i >= 2 ? high[v] : low[v];
      mesh.points.push_back(p * voxel_mm_);
    }
    // Counter-clockwise seen from outside.
    const std::uint32_t second = sign > 0 ? 1 : 3, fourth = sign > 0 ? 3 : 1;
    mesh.triangles.push_back({first, first + second, first + 2});
    mesh.triangles.push_back({first, first + 2, first + fourth});
  });
  return mesh;
}

}  // namespace kerf
