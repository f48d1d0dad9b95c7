#include "experiment/bench/dense_bone.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <optional>

#include "bone/grid/grids.h"
#include "cut/removal/cutter.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Calls visit(x, y, z, phi of the bone) for each voxel of a box.
template <typename Visit>
void ForEachVoxel(const Bone& bone, const std::array<int, 3>& lowest, const std::array<int, 3>& size, Visit visit) {
  const auto accessor = GridsOf(bone).phi->getConstAccessor();
  for (int x = lowest[0]; x < lowest[0] + size[0]; ++x) {
    for (int y = lowest[1]; y < lowest[1] + size[1]; ++y) {
      for (int z = lowest[2]; z < lowest[2] + size[2]; ++z) visit(x, y, z, accessor.getValue({x, y, z}));
    }
  }
}

double CalcFraction(float phi, double voxel_mm) {
  return std::clamp(0.5 - static_cast<double>(phi) / voxel_mm, 0.0, 1.0);
}

}  // namespace

DenseBone::DenseBone(const Bone& bone, const Box3& box_W) : voxel_mm_(bone.voxel_mm()), band_mm_(bone.band_mm()) {
  double count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = std::ceil(box_W.lower[axis] / voxel_mm_ - 1e-6);
    const double upper = std::floor(box_W.upper[axis] / voxel_mm_ + 1e-6);
    count *= std::max(0.0, upper - lower + 1);
    if (!(count >= 1 && count < 2147483648.0 && std::abs(lower) < 1e9)) {
      throw Error(fmt::format("a dense copy of the bone would have {:.3g} voxels; valid range 1 to 2^31", count));
    }
    lowest_[axis] = static_cast<int>(lower);
    size_[axis] = static_cast<int>(upper - lower) + 1;
  }
  phi_.reserve(static_cast<std::size_t>(count));
  ForEachVoxel(bone, lowest_, size_, [&](int, int, int, float phi) { phi_.push_back(phi); });
}

double CalcBallSweepDistance(const Vec3& p_W, const Vec3& from_W, const Vec3& to_W, double radius_mm) {
  const Vec3 way = to_W - from_W;
  const double length2 = glm::dot(way, way);
  const double t = length2 > 0 ? std::clamp(glm::dot(p_W - from_W, way) / length2, 0.0, 1.0) : 0;
  return glm::length(p_W - (from_W + t * way)) - radius_mm;
}

double CalcDiscSweepDistance(const Vec3& p_W, const Pose& X_from, const Pose& X_to, double radius_mm,
                             double thickness_mm) {
  const Vec3 p_T = X_to.InversePoint(p_W);
  Vec3 from_T = X_to.InversePoint(X_from.p_AB);
  from_T.z = 0;
  const double radial = CalcBallSweepDistance({p_T.x, p_T.y, 0}, from_T, Vec3{0}, radius_mm);
  const double axial = std::abs(p_T.z) - 0.5 * thickness_mm;
  if (radial > 0 && axial > 0) return std::hypot(radial, axial);
  return std::max(radial, axial);
}

/// The same for a solid of revolution, whose middle moves straight; outside, the largest distance from one of its
/// faces.
class RoundSolidSweep {
 public:
  RoundSolidSweep(const RoundSolid& solid, const Pose& X_from, const Pose& X_to, double band_mm)
      : faces_(solid.CalcFaces()), X_to_(X_to) {
    const Vec3 middle_T(0, 0, 0.5 * solid.top_z_mm);
    back_T_ = X_to.InverseVector(X_from.Point(middle_T) - X_to.Point(middle_T));
    enough_mm_ = band_mm + glm::length(back_T_);
  }

  double CalcDistance(const Vec3& p_W) const {
    const Vec3 p_T = X_to_.InversePoint(p_W);
    // Too far away, or too deep, to matter: the way changes the distance by at most its length.
    const double at_end = CalcAt(p_T, 0);
    if (at_end > enough_mm_ || at_end < -enough_mm_ || back_T_ == Vec3(0)) return at_end;
    // The distance is a convex function of the way.
    double low = 0;
    double high = 1;
    for (int i = 0; i < 45; ++i) {
      const double third = (high - low) / 3;
      if (CalcAt(p_T, low + third) < CalcAt(p_T, high - third)) {
        high -= third;
      } else {
        low += third;
      }
    }
    return CalcAt(p_T, 0.5 * (low + high));
  }

 private:
  double CalcAt(const Vec3& p_T, double t) const {
    const Vec3 q = p_T - t * back_T_;
    const double radius = std::sqrt(q.x * q.x + q.y * q.y);
    return std::max({faces_[0].CalcDistance(radius, q.z), faces_[1].CalcDistance(radius, q.z),
                     faces_[2].CalcDistance(radius, q.z)});
  }

  std::array<RoundSolid::Face, 3> faces_;
  Pose X_to_;
  Vec3 back_T_;
  double enough_mm_;
};

void DenseBone::Cut(const Tool& tool, const Pose& X_from, const Pose& X_to) {
  const double reach = CalcReach(tool);
  Box3 box;
  box.Include(X_from.p_AB);
  box.Include(X_to.p_AB);
  // A voxel further from the tool than the band's half-width does not change, since |phi| never exceeds this
  // half-width.
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  box = box.Grown(reach + (solid ? solid->CalcCornerFactor() : 1) * band_mm_);
  if (solid) {
    const RoundSolidSweep sweep(*solid, X_from, X_to, band_mm_);
    Cut(box, [&](const Vec3& p_W) { return sweep.CalcDistance(p_W); });
  } else if (IsBlade(tool)) {
    Cut(box, [&](const Vec3& p_W) {
      return CalcDiscSweepDistance(p_W, X_from, X_to, CalcRadius(tool), CalcKerfWidth(CalcThickness(tool), voxel_mm_));
    });
  } else {
    Cut(box, [&](const Vec3& p_W) { return CalcBallSweepDistance(p_W, X_from.p_AB, X_to.p_AB, reach); });
  }
}

double DenseBone::CalcOccupancy_mm3() const {
  double sum = 0;
  for (const float phi : phi_) sum += CalcFraction(phi, voxel_mm_);
  return sum * voxel_mm_ * voxel_mm_ * voxel_mm_;
}

DenseDifference DenseBone::Compare(const Bone& other, double near_mm) const {
  if (other.voxel_mm() != voxel_mm_) {
    throw Error(
        fmt::format("bones with voxels of {} and {} mm can't be compared voxel by voxel", voxel_mm_, other.voxel_mm()));
  }
  DenseDifference difference;
  ForEachVoxel(other, lowest_, size_, [&](int x, int y, int z, float theirs) {
    const float ours = at(x, y, z);
    if (ours == theirs) return;
    const double a = static_cast<double>(ours);
    const double b = static_cast<double>(theirs);
    if (std::min(std::abs(a), std::abs(b)) <= near_mm) {
      ++difference.voxels;
      difference.max_phi_mm = std::max(difference.max_phi_mm, std::abs(b - a));
    }
    difference.volume_mm3 += CalcFraction(theirs, voxel_mm_) - CalcFraction(ours, voxel_mm_);
  });
  difference.volume_mm3 *= voxel_mm_ * voxel_mm_ * voxel_mm_;
  return difference;
}

}  // namespace kerf
