// Bitwise comparison of two bones, and a saw that cuts a small bar at random places.
#pragma once

#include <openvdb/openvdb.h>

#include <bit>
#include <cstdint>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "base/core/heap_guard.h"
#include "bone/grid/grids.h"
#include "kerf/coupled.h"
#include "support/cuts.h"

namespace kerf::test {

/// Returns the number of voxels in the leaves of either bone whose bits differ, including voxels outside the band.
inline std::size_t CountDifferingVoxels(const Bone& a, const Bone& b) {
  std::set<openvdb::Coord> origins;
  for (const Bone* bone : {&a, &b}) {
    for (auto leaf = GridsOf(*bone).phi->tree().cbeginLeaf(); leaf; ++leaf) origins.insert(leaf->origin());
  }
  const auto of_a = GridsOf(a).phi->getConstAccessor();
  const auto of_b = GridsOf(b).phi->getConstAccessor();
  std::size_t other = 0;
  for (const openvdb::Coord& origin : origins) {
    for (int i = 0; i < 512; ++i) {
      const openvdb::Coord p = origin.offsetBy(i / 64, i / 8 % 8, i % 8);
      other += std::bit_cast<std::uint32_t>(of_a.getValue(p)) != std::bit_cast<std::uint32_t>(of_b.getValue(p));
    }
  }
  return other;
}

inline constexpr double kBarVoxel_mm = 0.25;
inline Bone MakeBar() {
  return MakeBox({}, {16, 6, 6}, kBarVoxel_mm);
}
inline CoupledParams BarParams() {
  DiscSaw saw;
  saw.diameter_mm = 8;
  saw.thickness_mm = 0.3;
  CoupledParams params;
  params.tool = saw;
  params.coupling.stiffness_N_per_mm = 100;
  params.coupling.torsion_Nmm_per_rad = 1e5;
  params.spare_leaves = 2000;
  return params;
}
inline Pose OverBar(double x_mm, double tilt, double z_mm) {
  Pose X;
  X.R_AB = glm::angleAxis(tilt, Vec3(0, 0, 1)) * glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0));
  X.p_AB = {x_mm, 0, z_mm};
  return X;
}

/// A plunge at a random place and back out; the tool is first set down there.
struct Plunge {
  double x_mm, tilt, depth_mm;
  explicit Plunge(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto draw = [&](double a, double b) { return a + (b - a) * 0x1p-64 * static_cast<double>(random()); };
    x_mm = draw(-6.5, 6.5);
    tilt = draw(-0.6, 0.6);
    depth_mm = draw(0.5, 4.5);
  }
  /// Runs the plunge and calls each(out) after each tick.
  template <typename Each>
  void Run(CoupledSimulation& simulation, Each&& each) const {
    const double top_mm = 3 + 4 + 1.5;
    simulation.SetDown(OverBar(x_mm, tilt, top_mm));
    for (int i = 1; i <= 160; ++i) {
      const double down_mm = (1.5 + depth_mm) * (i <= 120 ? i / 120.0 : (160 - i) / 40.0);
      CoupledOutput out;
      {
        const HeapGuard guard;
        out = simulation.Tick({.X_WH = OverBar(x_mm, tilt, top_mm - down_mm)});
      }
      each(out);
    }
  }
  void Run(CoupledSimulation& simulation) const {
    Run(simulation, [](const CoupledOutput&) {});
  }
};

}  // namespace kerf::test
