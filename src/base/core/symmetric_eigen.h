// Eigenvalues and eigenvectors of a symmetric 3x3 matrix.
#pragma once

#include <array>

#include "kerf/geometry.h"

namespace kerf {

/// In no particular order; vectors[i], of unit length, belongs to values[i].
struct SymmetricEigen {
  std::array<double, 3> values;
  std::array<Vec3, 3> vectors;
};

/// By Jacobi's rotations.
SymmetricEigen CalcSymmetricEigen(std::array<std::array<double, 3>, 3> a);

}  // namespace kerf
