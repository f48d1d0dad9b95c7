#include "device/devices/lattice.h"

#include <bit>

namespace kerf {
namespace {

bool IsSame(const Pose& a, const Pose& b) {
  const auto same = [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  };
  return same(a.p_AB.x, b.p_AB.x) && same(a.p_AB.y, b.p_AB.y) && same(a.p_AB.z, b.p_AB.z) && same(a.R_AB.w, b.R_AB.w) &&
         same(a.R_AB.x, b.R_AB.x) && same(a.R_AB.y, b.R_AB.y) && same(a.R_AB.z, b.R_AB.z);
}

}  // namespace

std::optional<LatticePose> FindOnLattice(const Pose& X) {
  if (!IsValid(X) || !IsInWorld(X.p_AB)) return std::nullopt;
  const LatticePose nearest = FindNearestOnLattice(X);
  if (IsSame(MakePose(nearest), X)) return nearest;
  // If two components are nearly equal, the omitted one may be the smaller of the two after rounding.
  const std::array<double, 4> q{X.R_AB.w, X.R_AB.x, X.R_AB.y, X.R_AB.z};
  for (int largest = 0; largest < 4; ++largest) {
    LatticePose other = nearest;
    other.largest = largest;
    other.negative = q[static_cast<std::size_t>(largest)] < 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (static_cast<int>(i) != largest) other.q[k++] = std::llround(q[i] / kLatticeQuaternion);
    }
    if (IsSame(MakePose(other), X)) return other;
  }
  return std::nullopt;
}

}  // namespace kerf
