// Marrow spaces and canals: what lies within bone without being bone by its HU.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

struct FillOptions {
  double reach_mm = 15;  // how far bone is looked for
  double enclosed =
      0.88;  // share of the directions in which it must be met; the rest are foramina and gaps in thin cortex
};

/// 1 for each voxel that is not bone, but enclosed by it: no way leads out, or bone is met in at least `enclosed` of 60
/// directions spread evenly over the sphere. A gap between teeth or a notch is open on a side, and stays open.
std::vector<std::uint8_t> FindCavities(const Volume& lattice, const std::vector<std::uint8_t>& bone,
                                       const FillOptions& options);

}  // namespace kerf
