#include "experiment/validation/rib.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "bone/grid/build.h"
#include "cut/force/measured.h"

namespace kerf {
namespace {

constexpr int kRegion = 24;

}  // namespace

Bone MakeRib(double length_mm, double width_mm, double voxel_mm, double depth_mm) {
  const Vec3 half(0.5 * length_mm, 0.5 * width_mm + kRibMargin_mm, 0.5 * depth_mm);
  const Vec3 centre(0, kRibPlane_mm, -half.z);
  SolidField field;
  field.value = [=](const Vec3& p) {
    const Vec3 q = glm::abs(p - centre) - half;
    return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return kRegion; };
  MaterialTable table;
  table.Add({kRegion, "bone of the measurements", Tissue::kCortical, kMeasuredE_MPa, kMeasuredPoissonRatio, true,
             "cut/force/measured.h"});
  const Box3 box{centre - half, centre + half};
  return MakeBone(field, box.Grown(6 * voxel_mm), {voxel_mm, voxel_mm, {}}, table);
}

double CalcRibVoxel(double width_mm) {
  return std::clamp(width_mm / 6, 0.02, 0.1);
}

}  // namespace kerf
