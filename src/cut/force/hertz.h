// Formulas that both Hertz laws share.
#pragma once

#include "kerf/force.h"

namespace kerf {

/// Returns Hertz's force between a sphere of radius R and a half space at contact radius a, F = 4/3 E* a^3 / R, N.
inline double CalcHertzForce(double a_mm, double R_mm, double E_star_MPa) {
  return 4.0 / 3.0 * E_star_MPa * a_mm * a_mm * a_mm / R_mm;
}

inline constexpr LawParameter kContactRadius{"contact_radius_mm", 0, 0, 1000,
                                             "R of Hertz's sphere; 0: half the tool's diameter, the paper's choice"};

inline double ContactRadius(double contact_radius_mm, const Tooth& tooth) {
  return contact_radius_mm > 0 ? contact_radius_mm : tooth.tool_radius_mm;
}

}  // namespace kerf
