#include "experiment/bench/dense_bone.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "bone/grid/grids.h"
#include "cut/removal/cutter.h"
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

void DenseBone::Cut(const Tool& tool, const Pose& X_from, const Pose& X_to) {
  const double reach = CalcReach(tool);
  Box3 box;
  box.Include(X_from.p_AB);
  box.Include(X_to.p_AB);
  // A voxel further from the tool than the band's half-width does not change, since |phi| never exceeds this
  // half-width.
  box = box.Grown(reach + band_mm_);
  if (IsBlade(tool)) {
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
