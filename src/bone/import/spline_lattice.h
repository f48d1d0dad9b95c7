// Sums of a cubic B-spline at the points of a small lattice along the axes of its coefficients.
#pragma once

#include <array>
#include <cstddef>

namespace kerf {

inline constexpr int kLatticePoints = 8;         // along an axis
inline constexpr int kLatticeCoefficients = 16;  // most along an axis

/// Points along an axis, and the coefficients on which they depend.
struct SplineAxis {
  int count = 0;                                         // of the coefficients
  std::array<int, kLatticeCoefficients> coefficients{};  // their places along the axis
  std::array<int, kLatticePoints> first{};               // of the four of each point, in `coefficients`
  std::array<std::array<double, 4>, kLatticePoints> weights{};
};

/// Sets the sums at the points (x, y, z), at (8 x + y) 8 + z. `stride`: from a coefficient to the next along each axis.
/// Adds along the axes in their order, without fused multiply-add, so that the bits do not depend on the width of the
/// vectors. Thread-safe.
void SumSplines(const float* coefficients, const std::array<std::size_t, 3>& stride,
                const std::array<SplineAxis, 3>& axes, std::array<double, 512>& sums);

}  // namespace kerf
