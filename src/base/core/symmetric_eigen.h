// Eigenvalues and eigenvectors of a symmetric 3x3 matrix.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Eigenvalues in no particular order; vectors[i], of unit length, belongs to values[i].
struct SymmetricEigen {
  std::array<double, 3> values;
  std::array<Vec3, 3> vectors;
};

/// Computes them by Jacobi rotations.
SymmetricEigen CalcSymmetricEigen(std::array<std::array<double, 3>, 3> a);

/// Mean of points, and the principal axes of their scatter about it: the values are sums of squared distances.
struct PointSpread {
  Vec3 mean{0};
  SymmetricEigen scatter;
};

PointSpread CalcPointSpread(const std::vector<Vec3>& points);

}  // namespace kerf
