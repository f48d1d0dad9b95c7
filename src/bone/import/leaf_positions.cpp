#include "bone/import/leaf_positions.h"

#include <cmath>

namespace kerf {

LatticeMap::LatticeMap(const Volume& lattice) : origin_W(lattice.origin_W) {
  const glm::dmat3 inverse = glm::inverse(lattice.axes_W);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      voxel_from_world[column][row] = inverse[column][row] / lattice.spacing_mm[row];
  }
}

bool LatticeMap::HasPositions(double voxel_mm) const {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (row != column && voxel_from_world[column][row] != 0) return false;
    }
    constexpr int kSteps = 7;  // from the first voxel of a leaf to the last
    if (kSteps * voxel_mm * std::abs(voxel_from_world[row][row]) > SplineField::kLatticeReach) return false;
  }
  return true;
}

LatticePositions LatticeMap::CalcPositions(const LeafPlace& leaf) const {
  LatticePositions at_V{};
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    for (std::size_t n = 0; n < at_V[axis].size(); ++n) {
      const double p_W = leaf.voxel_mm * (leaf.first[axis] + static_cast<int>(n));
      at_V[axis][n] = voxel_from_world[a][a] * (p_W - origin_W[a]);
    }
  }
  return at_V;
}

}  // namespace kerf
