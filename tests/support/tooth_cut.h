// What a tooth cuts in tests of the force laws.
#pragma once

#include "kerf/force.h"

namespace kerf {

/// Returns cortical bone of the given reduced modulus; the laws of the tests read no other modulus.
inline ToothCut Cortical(double E_star_MPa) {
  return MakeToothCut(E_star_MPa, E_star_MPa, Tissue::kCortical);
}

}  // namespace kerf
