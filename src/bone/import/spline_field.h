// Smooth function of space from samples on a lattice.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Positions along the three axes of the points of a lattice, 8 along each.
using LatticePositions = std::array<std::array<double, 8>, 3>;

/// Tensor product of cubic B-splines over a lattice, twice continuously differentiable. Coordinates are in voxels
/// (index space of the lattice). Beyond the lattice, the outermost samples are assumed to continue unchanged.
/// Thread-safe once constructed.
class SplineField {
 public:
  /// `interpolate`: if true, the spline passes through the samples (no smoothing; sharp edges overshoot by a few
  /// percent). If false, the samples are the coefficients: a smoothing of 0.58 voxels that never overshoots.
  SplineField(const std::array<int, 3>& size, std::vector<float> samples, bool interpolate);

  double At(const Vec3& p_V) const;

  /// Greatest distance between two positions along an axis for AtLattice(), in voxels.
  static constexpr double kLatticeReach = 11;
  /// Sets values[(8 x + y) 8 + z] to At() of (at_V[0][x], at_V[1][y], at_V[2][z]), bit for bit.
  void AtLattice(const LatticePositions& at_V, std::array<double, 512>& values) const;

  struct Bounds {
    double lower, upper;
  };
  /// Returns bounds of the field in a box: a B-spline stays within the range of its coefficients.
  Bounds CalcBounds(const Vec3& lower_V, const Vec3& upper_V) const;

 private:
  std::size_t Index(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size_[1] + j) * size_[0] + i; }
  void MakeBlocks();

  std::array<int, 3> size_;
  std::vector<float> coefficients_;
  // Minimum and maximum coefficient of each block of kBlock^3, for large boxes.
  static constexpr int kBlock = 4;
  std::array<int, 3> blocks_{0, 0, 0};
  std::vector<std::array<float, 2>> block_bounds_;
};

}  // namespace kerf
