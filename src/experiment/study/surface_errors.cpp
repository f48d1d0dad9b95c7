// Distance between two cut surfaces, measured where there is a cut.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <unordered_set>

#include "base/core/hash.h"
#include "bone/grid/crop.h"
#include "experiment/study/errors.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

constexpr double kApart_mm = 0.15;      // one point is kept in each cell with this edge, so that no place has a large
                                        // weight
constexpr double kInside_mm = 0.1;      // only points at least this far inside the uncut solid are used, which excludes
                                        // the edges of the kerf
constexpr double kOnSurface_mm = 1e-4;  // tolerance for a point projected onto the exact surface
constexpr std::size_t kMaxPoses = 400;
constexpr int kRimPoints = 120;
constexpr int kFlatRings = 8;

/// Determines whether a point is the first one in its cell.
class Thinner {
 public:
  bool IsFirst(const Vec3& p_W) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::int64_t>(std::floor(p_W[axis] / kApart_mm));
      key = MixHash(key ^ static_cast<std::uint64_t>(cell));
    }
    return seen_.insert(key).second;
  }

 private:
  std::unordered_set<std::uint64_t> seen_;
};

bool IsWithin(const Box3& box, const Vec3& p) {
  return p.x >= box.lower.x && p.y >= box.lower.y && p.z >= box.lower.z && p.x <= box.upper.x && p.y <= box.upper.y &&
         p.z <= box.upper.z;
}

/// Returns the distances from the bone's cut surface to the exact one.
std::vector<double> MeasureBone(const Bone& bone, const ExactBone& exact) {
  std::vector<double> distances;
  // Cropping creates artificial faces, so the box is large enough to keep them away from the cut.
  const Box3 box_W = exact.swept_bounds().Grown(2 * bone.band_mm());
  const TriangleMesh mesh = ExtractSurface(CropBone(bone, box_W));
  const Box3 near_W = exact.swept_bounds().Grown(bone.voxel_mm());
  Thinner thinner;
  for (const Vec3& p_W : mesh.points) {
    if (!IsWithin(near_W, p_W) || exact.solid().distance_mm(p_W) > -kInside_mm || !thinner.IsFirst(p_W)) continue;
    distances.push_back(std::abs(exact.Distance(p_W)));
  }
  return distances;
}

}  // namespace

void CalcCutSurfaceErrors(const Bone& bone, const ExactBone& exact, std::span<const ReferenceTick> ticks,
                          const DiscSaw& saw, double edge_mm, ErrorFigures& errors) {
  if (exact.swept_bounds().empty() || ticks.empty()) return;
  std::vector<double> there = MeasureBone(bone, exact);
  std::vector<double> back;
  Thinner thinner;
  const double inner_mm = edge_mm > 0 ? std::max(0.0, saw.radius_mm() - edge_mm) : 0;
  const double half_mm = 0.5 * saw.thickness_mm;
  // p_T is on the disc with the outward normal n_T. If the disc passed over the point at another pose, the point is in
  // air and is moved along the normal to the surface.
  const auto look = [&](const Pose& X_WT, const Vec3& p_T, const Vec3& n_T) {
    Vec3 p_W = X_WT.Point(p_T);
    if (exact.solid().distance_mm(p_W) > -kInside_mm) return;
    double distance = exact.Distance(p_W);
    const Vec3 n_W = X_WT.Vector(n_T);
    for (int i = 0; i < 8 && std::abs(distance) > kOnSurface_mm && std::abs(distance) < 0.5 * saw.thickness_mm; ++i) {
      p_W += distance * n_W;
      distance = exact.Distance(p_W);
    }
    if (std::abs(distance) > kOnSurface_mm || exact.solid().distance_mm(p_W) > -kInside_mm) return;
    if (thinner.IsFirst(p_W)) back.push_back(std::abs(bone.SignedDistance(p_W)));
  };
  const std::size_t step = std::max<std::size_t>(1, ticks.size() / kMaxPoses);
  for (std::size_t k = ticks.size() - 1;; k -= step) {
    const Pose& X_WT = ticks[k].X_WT;
    // The points are rotated from pose to pose, so that they are not aligned.
    const double turn = 2.399963 * static_cast<double>(k);
    for (int i = 0; i < kRimPoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRimPoints + turn;
      const Vec3 e_T(std::cos(angle), std::sin(angle), 0);
      const double across = half_mm * (0.8 * std::fmod(0.618034 * i, 1.0) - 0.4) * 2;
      look(X_WT, saw.radius_mm() * e_T + Vec3(0, 0, across), e_T);
      const double fraction = (i % kFlatRings + 0.5) / kFlatRings;
      // The radii are distributed uniformly by area.
      const double r2 = inner_mm * inner_mm + fraction * (saw.radius_mm() * saw.radius_mm() - inner_mm * inner_mm);
      const double side = i % 2 == 0 ? 1 : -1;
      look(X_WT, std::sqrt(r2) * e_T + Vec3(0, 0, side * half_mm), Vec3(0, 0, side));
    }
    if (k < step) break;
  }
  CalcSurfaceErrors(std::move(there), std::move(back), errors);
}

}  // namespace kerf
