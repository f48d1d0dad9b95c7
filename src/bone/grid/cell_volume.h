// Volume of bone in a cell. A cell is the cube between eight neighbouring voxel centres. Within it phi is linear on
// each of six tetrahedra (Kuhn's division, the same in every cell, so that neighbouring cells agree on their common
// face). The volume is therefore exact for plane surfaces, second-order for curved ones, and a function of the eight
// values alone. The difference between the volumes before and after a cut is exactly the sum of the volumes that the
// changed cells have lost.
#pragma once

#include <array>
#include <cstddef>

namespace kerf {

/// Returns the fraction (0 to 1) of a tetrahedron where the linear function with these corner values is negative.
/// Tick-safe.
inline double CalcNegativeFraction(double a, double b, double c, double d) {
  const auto swap_if = [](double& x, double& y) {
    if (y < x) {
      const double t = x;
      x = y;
      y = t;
    }
  };
  // Sorting places the negative corners first and makes the result independent of the corners' order.
  swap_if(a, b);
  swap_if(c, d);
  swap_if(a, c);
  swap_if(b, d);
  swap_if(b, c);
  if (a >= 0) return 0;
  if (d < 0) return 1;
  if (b >= 0) return a * a * a / ((a - b) * (a - c) * (a - d));
  if (c >= 0) {
    const double p = a / (a - c);
    const double q = a / (a - d);
    const double r = b / (b - c);
    const double s = b / (b - d);
    return r * s + p * s * (1 - r) + p * q * (1 - s);
  }
  return 1 - d * d * d / ((d - a) * (d - b) * (d - c));
}

/// Returns the fraction of a cell where phi < 0; v[4x + 2y + z] is the value at corner (x, y, z). Tick-safe.
inline double CalcCellFraction(const std::array<float, 8>& v) {
  int negative = 0;
  for (const float value : v) negative += value < 0 ? 1 : 0;
  if (negative == 0) return 0;
  if (negative == 8) return 1;
  // The six paths from corner 0 to corner 7 along the edges; each defines a tetrahedron.
  static constexpr int kPaths[6][2] = {{4, 6}, {4, 5}, {2, 6}, {2, 3}, {1, 5}, {1, 3}};
  double sum = 0;
  for (const auto& path : kPaths) {
    sum += CalcNegativeFraction(static_cast<double>(v[0]), static_cast<double>(v[path[0]]),
                                static_cast<double>(v[path[1]]), static_cast<double>(v[7]));
  }
  return sum / 6;
}

/// Returns phi within a cell, linear on each tetrahedron as in CalcCellFraction(). `f`: position in the cell, 0 to 1
/// along x, y and z. Tick-safe.
inline double InterpolateInCell(const std::array<float, 8>& v, const double f[3]) {
  // The path from corner 0 along the axes in descending order of f defines the tetrahedron that contains the point.
  int axis[3] = {0, 1, 2};
  const auto swap_if = [&](int i, int j) {
    if (f[axis[i]] >= f[axis[j]]) return;
    const int t = axis[i];
    axis[i] = axis[j];
    axis[j] = t;
  };
  swap_if(0, 1);
  swap_if(1, 2);
  swap_if(0, 1);
  double before = static_cast<double>(v[0]);
  double value = before;
  std::size_t corner = 0;
  for (const int a : axis) {
    corner += std::size_t{4} >> a;
    const double at = static_cast<double>(v[corner]);
    value += f[a] * (at - before);
    before = at;
  }
  return value;
}

}  // namespace kerf
