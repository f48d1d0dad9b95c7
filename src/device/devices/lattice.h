// The lattice on which the loop takes a handle's pose: fine enough that nothing is felt of it, coarse enough that a
// recording of a minute, exact to the bit, is below a megabyte.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Of a position, mm: 4e-9, a hundred-thousandth of what the finest device resolves.
inline constexpr double kLatticePosition_mm = 0x1p-28;
/// Of the components of a quaternion: 1.5e-11.
inline constexpr double kLatticeQuaternion = 0x1p-36;

/// A pose in whole numbers: the position, and the three smaller components of the quaternion; the largest follows from
/// them, as its length is 1.
struct LatticePose {
  std::array<std::int64_t, 3> p{};
  int largest = 0;  // component left out: 0 to 3 for w, x, y, z
  bool negative = false;
  std::array<std::int64_t, 3> q{};  // the others, in order
};

/// Exact: the same bits everywhere, as the square root is correctly rounded. Tick-safe.
inline Pose MakePose(const LatticePose& lattice) {
  std::array<double, 4> q{};
  double rest = 1;
  std::size_t k = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (static_cast<int>(i) == lattice.largest) continue;
    q[i] = static_cast<double>(lattice.q[k++]) * kLatticeQuaternion;
    rest -= q[i] * q[i];
  }
  const double largest = std::sqrt(std::fmax(rest, 0));
  q[static_cast<std::size_t>(lattice.largest)] = lattice.negative ? -largest : largest;
  return {Quat{q[0], q[1], q[2], q[3]},
          kLatticePosition_mm * Vec3(static_cast<double>(lattice.p[0]), static_cast<double>(lattice.p[1]),
                                     static_cast<double>(lattice.p[2]))};
}

/// The lattice's pose nearest to a valid one within the world, but for rounding in the component that follows.
/// Tick-safe.
inline LatticePose FindNearestOnLattice(const Pose& X) {
  LatticePose lattice;
  for (int axis = 0; axis < 3; ++axis) {
    lattice.p[static_cast<std::size_t>(axis)] = std::llround(X.p_AB[axis] / kLatticePosition_mm);
  }
  const std::array<double, 4> q{X.R_AB.w, X.R_AB.x, X.R_AB.y, X.R_AB.z};
  for (int i = 1; i < 4; ++i) {
    if (std::abs(q[static_cast<std::size_t>(i)]) > std::abs(q[static_cast<std::size_t>(lattice.largest)])) {
      lattice.largest = i;
    }
  }
  lattice.negative = q[static_cast<std::size_t>(lattice.largest)] < 0;
  std::size_t k = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (static_cast<int>(i) != lattice.largest) lattice.q[k++] = std::llround(q[i] / kLatticeQuaternion);
  }
  return lattice;
}

/// The numbers of a pose that is on the lattice to the bit, none when it is not. Tick-safe.
std::optional<LatticePose> FindOnLattice(const Pose& X);

}  // namespace kerf
