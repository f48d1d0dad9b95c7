// A bone from a label map: a lattice of small integers, such as a segmentation of a CT.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>

#include "kerf/bone.h"
#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

inline constexpr Range kLabelSpacingRange_mm{1e-3, 100};

/// Labels on a lattice. The voxel (i, j, k) is number i + size[0] (j + size[1] k) of `labels`; its centre lies at
/// X_WL.Point({i, j, k} * spacing_mm).
struct LabelMap {
  std::array<int, 3> size{0, 0, 0};  // each 1 or more
  Vec3 spacing_mm{1};                // each in kLabelSpacingRange_mm
  Pose X_WL;                         // of the lattice's axes and its first voxel's centre
  std::span<const std::uint8_t> labels;
};

/// Makes a bone of the voxels whose labels are in `region_of_label`, with the region given there. Its surface lies
/// where the labels, interpolated linearly between voxel centres, are half bone: between voxel centres, and smooth to
/// about the lattice's spacing. Bone at the lattice's edge ends half a voxel beyond the last voxel centre. `progress`:
/// as in MakeMandible(). Throws kerf::Error if the lattice is invalid or empty, does not match `labels`, if no voxel is
/// bone, if a region is unknown, or if the bone would be too large.
Bone MakeBoneFromLabels(const LabelMap& map, const std::map<int, int>& region_of_label, double voxel_mm,
                        const MaterialTable& materials = DefaultMandibleTable(),
                        const std::function<void(double)>& progress = {});

}  // namespace kerf
