// Lattice to which the loop rounds a handle's pose. It is fine enough that the rounding cannot be felt, and coarse
// enough that a bit-exact recording of one minute is smaller than a megabyte.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Step of a position, mm: 4e-9, a hundred-thousandth of the resolution of the finest device.
inline constexpr double kLatticePosition_mm = 0x1p-28;
/// Step of a quaternion component: 1.5e-11.
inline constexpr double kLatticeQuaternion = 0x1p-36;

/// Pose as integers: the position, and the three smaller components of the quaternion. The largest component follows
/// from them, since the quaternion has unit length.
struct LatticePose {
  std::array<std::int64_t, 3> p{};
  int largest = 0;  // index of the omitted component: 0 to 3 for w, x, y, z
  bool negative = false;
  std::array<std::int64_t, 3> q{};  // the other three components, in order
};

/// Returns the pose. It is bit-identical on every machine, since the square root is correctly rounded. Tick-safe.
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

/// Returns the lattice pose nearest to a valid pose within the world; rounding of the omitted component is not
/// considered. Tick-safe.
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

/// Returns the integers of a pose that is bit-exactly on the lattice; otherwise, returns nullopt. Tick-safe.
std::optional<LatticePose> FindOnLattice(const Pose& X);

}  // namespace kerf
