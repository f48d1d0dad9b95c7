// A block with canals and teeth, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/material/segment_regions.h"

namespace kerf::test {

inline constexpr double kVoxel_mm = 0.2;

/// A block of 40 x 20 x 16 mm, z from -16 to 0, with these regions. With `slot_mm`, it is without a slot of 0.4 mm at
/// x = slot_x_mm that is slot_mm deep.
inline Bone MakeBlock(double slot_x_mm, double slot_mm, const std::function<int(const Vec3&)>& region,
                      const MaterialTable& table) {
  SolidField solid;
  solid.value = [=](const Vec3& p) {
    const Vec3 out = glm::abs(p - Vec3(0, 0, -8)) - Vec3(20, 10, 8);
    const double block = std::max({out.x, out.y, out.z});
    return slot_mm > 0 ? std::max(block, -std::max(std::abs(p.x - slot_x_mm) - 0.2, -slot_mm - p.z)) : block;
  };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = region;
  BuildOptions options;
  options.voxel_mm = kVoxel_mm;
  options.region_voxel_mm = kVoxel_mm;
  return MakeBone(solid, Box3{Vec3(-21.5, -11.5, -17.5), Vec3(21.5, 11.5, 1.5)}, options, table);
}

/// The block with canals of radius 1.2 mm along x at z = -10, except in the middle, and three teeth of 4 x 4 mm, down
/// to z = -6: one on the patient's right (x < 0), two on the left.
inline Bone MakeJaw(double slot_x_mm = 0, double slot_mm = 0) {
  const auto region = [](const Vec3& p) {
    if (std::hypot(p.y, p.z + 10) < 1.2 && std::abs(p.x) > 2) return 34;
    for (const double x : {-8.0, 5.0, 12.0}) {
      if (std::abs(p.x - x) < 2 && std::abs(p.y) < 2 && p.z > -6) return 33;
    }
    return 32;
  };
  return MakeBlock(slot_x_mm, slot_mm, region, DefaultMandibleTable());
}

/// The block as a segmentation names it: the teeth 36 (x from 4 to 8) and 37 (8 to 12), which touch, down to z = -6, a
/// tooth without a number at x = -8, a lesion of radius 2 mm at (-8, 0, -10), and metal beyond x = 16.
inline Bone MakeSegmentedJaw(double slot_x_mm = 0, double slot_mm = 0) {
  const auto region = [](const Vec3& p) {
    if (p.x > 16) return kMetalRegion;
    if (glm::length(p - Vec3(-8, 0, -10)) < 2) return kLesionRegion;
    if (std::abs(p.y) >= 2 || p.z < -6) return kCancellousRegion;
    if (std::abs(p.x + 8) < 2) return kToothRegion;
    return p.x < 4 || p.x > 12 ? kCancellousRegion : ToothRegion(p.x < 8 ? 36 : 37);
  };
  MaterialTable table = DefaultMandibleTable();
  AddTooth(36, "test", table);
  AddTooth(37, "test", table);
  AddMetal("test", table);
  AddLesion("test", table);
  return MakeBlock(slot_x_mm, slot_mm, region, table);
}

/// The block with teeth that touch from x = 2 to 17 as one region, one tooth behind them, and one on the other side.
inline Bone MakeJawWithRow(double slot_x_mm = 0, double slot_mm = 0) {
  const auto region = [](const Vec3& p) {
    const bool tooth = (p.x > 2 && p.x < 17) || p.x > 18 || std::abs(p.x + 8) < 2;
    return tooth && std::abs(p.y) < 2 && p.z > -6 ? 33 : 32;
  };
  return MakeBlock(slot_x_mm, slot_mm, region, DefaultMandibleTable());
}

}  // namespace kerf::test
