// A CT of the generic mandible in a head of soft tissue, for tests of what reads scans.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>

#include "bone/import/volume.h"
#include "bone/models/mandible.h"

namespace kerf::test {

/// The HU of the head at a point, LPS mm: air, soft tissue of 40, bone of 900 and teeth of 2000, with edges blurred
/// over 2 mm. A ball of bone of 6 mm radius at the patient's left angle (+x) shows whether a result is mirrored.
inline std::function<double(const Vec3&)> JawHu() {
  const auto shape = std::make_shared<const MandibleShape>(MandibleParams{});
  return [shape](const Vec3& p_W) {
    constexpr double kBlur_mm = 2;
    const Vec3 from_axis = (p_W - Vec3(0, 43, 0)) / Vec3(62, 47, 1);
    if (glm::length(Vec3(from_axis.x, from_axis.y, 0)) > 1) return -1000.0;
    const auto fraction = [](double distance_mm) { return std::clamp(0.5 - distance_mm / kBlur_mm, 0.0, 1.0); };
    const double bone_mm = std::min(shape->Value(p_W), glm::length(p_W - Vec3(50, 60, -18)) - 6);
    return 40 + 860 * fraction(bone_mm) + 1100 * fraction(shape->ToothValue(p_W) + 0.5);
  };
}

/// Samples JawHu() at the centres of the voxels of a lattice.
inline Volume SampleJaw(Volume lattice) {
  const auto hu = JawHu();
  lattice.hu.clear();
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i) {
        lattice.hu.push_back(static_cast<std::int16_t>(std::lround(hu(lattice.WorldFromVoxel({i, j, k})))));
      }
    }
  }
  return lattice;
}

/// The head along the patient's axes, with voxels of `spacing_mm`, 128 x 102 x 90 mm.
inline Volume JawCt(double spacing_mm = 2) {
  Volume lattice;
  lattice.size = {static_cast<int>(std::lround(128 / spacing_mm)), static_cast<int>(std::lround(102 / spacing_mm)),
                  static_cast<int>(std::lround(90 / spacing_mm))};
  lattice.spacing_mm = Vec3(spacing_mm);
  lattice.origin_W = {-64, -6.8, -45.6};
  return SampleJaw(lattice);
}

}  // namespace kerf::test
