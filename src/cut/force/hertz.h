// The parameter that both Hertz laws share.
#pragma once

#include "kerf/force.h"

namespace kerf {

inline constexpr LawParameter kContactRadius{"contact_radius_mm", 0, 0, 1000,
                                             "R of Hertz's sphere; 0: half the tool's diameter, the paper's choice"};

inline double ContactRadius(double contact_radius_mm, const Tooth& tooth) {
  return contact_radius_mm > 0 ? contact_radius_mm : tooth.tool_radius_mm;
}

}  // namespace kerf
