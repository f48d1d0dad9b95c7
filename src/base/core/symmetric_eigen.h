// Eigenvalues and eigenvectors of a symmetric 3x3 matrix.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// Eigenvalues in no particular order; vectors[i], of unit length, belongs to values[i].
struct SymmetricEigen {
  std::array<double, 3> values;
  std::array<Vec3, 3> vectors;
};

/// Computes them by Jacobi rotations.
SymmetricEigen CalcSymmetricEigen(std::array<std::array<double, 3>, 3> a);

}  // namespace kerf
