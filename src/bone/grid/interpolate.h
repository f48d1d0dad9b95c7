// Interpolation between the centres of eight neighbouring voxels, independent of the kind of grid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "kerf/geometry.h"

namespace kerf {

/// The cell of a grid that contains a point: its lowest voxel and the point's position in it, 0 to 1 along each axis.
struct CellPoint {
  int x;
  int y;
  int z;
  Vec3 f;
};

inline constexpr double kFarCell = 1 << 30;

/// Finds the cell that contains `p_vox`, a point in the grid's index space; coordinates are clamped to +-kFarCell.
/// Tick-safe.
inline CellPoint FindCell(const Vec3& p_vox) {
  // Rounds down by converting to an integer, because without SSE 4.1 floor() is a function call.
  const auto down = [](double x) {
    const int towards_0 = static_cast<int>(x);
    return towards_0 - (x < towards_0 ? 1 : 0);
  };
  const Vec3 p = glm::clamp(p_vox, Vec3(-kFarCell), Vec3(kFarCell));
  const int x = down(p.x);
  const int y = down(p.y);
  const int z = down(p.z);
  return {x, y, z, Vec3(p.x - x, p.y - y, p.z - z)};
}

/// Eight values of a cell; element [4x + 2y + z] belongs to corner (x, y, z).
template <typename T>
using CellValues = std::array<T, 8>;

/// Returns the weight of a corner in trilinear interpolation. Tick-safe.
inline double CalcCornerWeight(std::size_t corner, const Vec3& f) {
  return ((corner & 4) ? f.x : 1 - f.x) * ((corner & 2) ? f.y : 1 - f.y) * ((corner & 1) ? f.z : 1 - f.z);
}

/// Interpolates trilinearly at the position `f` in the cell. Tick-safe.
inline double Interpolate(const CellValues<float>& v, const Vec3& f) {
  double plane[2];
  for (std::size_t x = 0; x < 2; ++x) {
    double line[2];
    for (std::size_t y = 0; y < 2; ++y) {
      const double v0 = static_cast<double>(v[4 * x + 2 * y]);
      const double v1 = static_cast<double>(v[4 * x + 2 * y + 1]);
      line[y] = v0 + f.z * (v1 - v0);
    }
    plane[x] = line[0] + f.y * (line[1] - line[0]);
  }
  return plane[0] + f.x * (plane[1] - plane[0]);
}

/// Returns the gradient of Interpolate() with respect to f. Tick-safe.
inline Vec3 InterpolateGradient(const CellValues<float>& v, const Vec3& f) {
  // Along each axis, the difference between the two opposite faces, interpolated bilinearly along the other two axes.
  const auto d = [&v](std::size_t upper, std::size_t lower) {
    return static_cast<double>(v[upper]) - static_cast<double>(v[lower]);
  };
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  return {mix(mix(d(4, 0), d(5, 1), f.z), mix(d(6, 2), d(7, 3), f.z), f.y),
          mix(mix(d(2, 0), d(3, 1), f.z), mix(d(6, 4), d(7, 5), f.z), f.x),
          mix(mix(d(1, 0), d(3, 2), f.y), mix(d(5, 4), d(7, 6), f.y), f.x)};
}

/// Interpolates trilinearly between the corners with a value above 0; returns 0 if there are none. Tick-safe.
inline double InterpolatePositive(const CellValues<float>& v, const Vec3& f) {
  double sum = 0;
  double weights = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const double value = static_cast<double>(v[corner]);
    if (!(value > 0)) continue;
    const double weight = CalcCornerWeight(corner, f);
    sum += weight * value;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

/// Returns whether the value of a region voxel is that of a region.
inline bool IsRegion(int value) {
  return value > 0 && value <= 255;
}

/// Calls visit(region id, weight) for the corners that have a material; the weights are those of trilinear
/// interpolation. Tick-safe.
template <typename Visit>
void VisitRegions(const CellValues<int>& v, const Vec3& f, Visit&& visit) {
  for (std::size_t corner = 0; corner < 8; ++corner) {
    if (IsRegion(v[corner])) visit(v[corner], CalcCornerWeight(corner, f));
  }
}

/// Returns the index of the voxel nearest to a point along one axis. Tick-safe.
inline int NearestIndex(double p_mm, double voxel_mm) {
  return static_cast<int>(std::floor(p_mm / voxel_mm + 0.5));
}

}  // namespace kerf
