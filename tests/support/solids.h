// Solids with known answers for tests.
#pragma once

#include <cmath>

#include "bone/grid/build.h"

namespace kerf::test {

inline MaterialTable OneRegionTable(int id = 24, double E_MPa = 19300, double nu = 0.28) {
  MaterialTable table;
  table.Add({id, "test", Tissue::kCortical, E_MPa, nu, true, "test"});
  return table;
}

inline SolidField SphereField(const Vec3& centre, double radius, int region = 24) {
  SolidField field;
  field.value = [=](const Vec3& p) { return glm::length(p - centre) - radius; };
  field.classify = ClassifyByDistance(field.value);
  field.region = [=](const Vec3&) { return region; };
  return field;
}

inline Bone MakeSphere(const Vec3& centre, double radius, double voxel_mm) {
  Box3 box{centre - Vec3(radius), centre + Vec3(radius)};
  return MakeBone(SphereField(centre, radius), box.Grown(6 * voxel_mm), {voxel_mm, voxel_mm, {}}, OneRegionTable());
}

/// Returns the signed distance of a box with half edges `half`, centred at the origin.
inline double BoxDistance(const Vec3& p, const Vec3& half) {
  const Vec3 q = glm::abs(p) - half;
  return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

/// Makes a box at the pose X_WB, centred at B's origin.
inline Bone MakeBox(const Pose& X_WB, const Vec3& size, double voxel_mm, int band_voxels = 3) {
  SolidField field;
  field.value = [=](const Vec3& p_W) { return BoxDistance(X_WB.InversePoint(p_W), 0.5 * size); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const double reach = 0.5 * glm::length(size);
  const Box3 box{X_WB.p_AB - Vec3(reach), X_WB.p_AB + Vec3(reach)};
  BuildOptions options{voxel_mm, voxel_mm, {}};
  options.band_voxels = band_voxels;
  return MakeBone(field, box.Grown((band_voxels + 3) * voxel_mm), options, OneRegionTable());
}

}  // namespace kerf::test
