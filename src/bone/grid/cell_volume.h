// Volume of bone in a cell. A cell is the cube between eight neighbouring voxel centres. Within it phi is linear on
// each of six tetrahedra (Kuhn's division, the same in every cell, so that neighbouring cells agree on their common
// face). The volume is therefore exact for plane surfaces, second-order for curved ones, and a function of the eight
// values alone. The difference between the volumes before and after a cut is exactly the sum of the volumes that the
// changed cells have lost.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

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

/// The six paths from corner 0 to corner 7 along the edges; each defines a tetrahedron.
inline constexpr int kCellPaths[6][2] = {{4, 6}, {4, 5}, {2, 6}, {2, 3}, {1, 5}, {1, 3}};

/// Returns the fraction of a cell where phi < 0; v[4x + 2y + z] is the value at corner (x, y, z). Tick-safe.
inline double CalcCellFraction(const std::array<float, 8>& v) {
  int negative = 0;
  for (const float value : v) negative += value < 0 ? 1 : 0;
  if (negative == 0) return 0;
  if (negative == 8) return 1;
  double sum = 0;
  for (const auto& path : kCellPaths) {
    sum += CalcNegativeFraction(static_cast<double>(v[0]), static_cast<double>(v[path[0]]),
                                static_cast<double>(v[path[1]]), static_cast<double>(v[7]));
  }
  return sum / 6;
}

/// Returns the fraction of a tetrahedron where two linear functions with these corner values are both negative.
/// Tick-safe.
inline double CalcCommonFraction(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  // Order the corners: those where a is negative first.
  std::array<std::size_t, 4> corner{0, 1, 2, 3};
  std::size_t negative = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (a[i] < 0) std::swap(corner[i], corner[negative++]);
  }
  if (negative == 0) return 0;
  const double whole = CalcNegativeFraction(a[0], a[1], a[2], a[3]);
  if (negative == 4) return CalcNegativeFraction(b[0], b[1], b[2], b[3]);
  const auto b_at = [&](std::size_t i) { return b[corner[i]]; };
  // Where a is 0 on the edge from corner i to corner j, and b there.
  const auto cross = [&](std::size_t i, std::size_t j) { return a[corner[i]] / (a[corner[i]] - a[corner[j]]); };
  const auto b_on = [&](std::size_t i, std::size_t j, double t) { return b_at(i) + t * (b_at(j) - b_at(i)); };
  // The part where a is negative, as tetrahedra. Where b is negative in all of it, the result has the bits of `whole`:
  // a cut that does not meet the bone changes nothing.
  double sum = 0;
  bool is_all = true;
  const auto add = [&](double share, double b0, double b1, double b2, double b3) {
    const double fraction = CalcNegativeFraction(b0, b1, b2, b3);
    sum += share * fraction;
    is_all = is_all && fraction == 1;
  };
  if (negative == 1) {
    const double p = cross(0, 1), q = cross(0, 2), r = cross(0, 3);
    add(p * q * r, b_at(0), b_on(0, 1, p), b_on(0, 2, q), b_on(0, 3, r));
  } else if (negative == 2) {
    const double p = cross(0, 2), q = cross(0, 3), r = cross(1, 2), s = cross(1, 3);
    const double b_p = b_on(0, 2, p), b_q = b_on(0, 3, q), b_r = b_on(1, 2, r), b_s = b_on(1, 3, s);
    add(r * s, b_at(1), b_r, b_s, b_at(0));
    add(p * s * (1 - r), b_at(0), b_p, b_r, b_s);
    add(p * q * (1 - s), b_at(0), b_p, b_q, b_s);
  } else {
    const double p = cross(0, 3), q = cross(1, 3), r = cross(2, 3);
    const double b_p = b_on(0, 3, p), b_q = b_on(1, 3, q), b_r = b_on(2, 3, r);
    add(p, b_at(0), b_at(1), b_at(2), b_p);
    add(q * (1 - p), b_at(1), b_at(2), b_p, b_q);
    add(r * (1 - p) * (1 - q), b_at(2), b_p, b_q, b_r);
  }
  return is_all ? whole : sum;
}

/// Returns the fraction of a cell where both fields of a bone are negative (see BoneField); the corners are those of
/// CalcCellFraction(). Tick-safe.
inline double CalcCellFraction(const std::array<float, 8>& whole, const std::array<float, 8>& cut) {
  int whole_negative = 0, cut_negative = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    whole_negative += whole[i] < 0 ? 1 : 0;
    cut_negative += cut[i] < 0 ? 1 : 0;
  }
  if (whole_negative == 0 || cut_negative == 0) return 0;
  if (whole_negative == 8) return CalcCellFraction(cut);
  if (cut_negative == 8) return CalcCellFraction(whole);
  double sum = 0;
  for (const auto& path : kCellPaths) {
    const std::array<std::size_t, 4> at{0, static_cast<std::size_t>(path[0]), static_cast<std::size_t>(path[1]), 7};
    std::array<double, 4> a{}, b{};
    for (std::size_t i = 0; i < 4; ++i) {
      a[i] = static_cast<double>(whole[at[i]]);
      b[i] = static_cast<double>(cut[at[i]]);
    }
    sum += CalcCommonFraction(a, b);
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
