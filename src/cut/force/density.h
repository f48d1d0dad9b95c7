// Scaling of a law with the density of the bone, instead of with its modulus or tissue.
//
// The density follows from Young's modulus, E ~ density^b, so that E from a CT gives back the density of the CT. The
// forces are multiplied by (density / that of the bone in which the law was measured)^n = (E / E_ref)^(n / b).
// No test measured n for saw teeth. Drilling forces were linear in the bone mineral density (Ong and Bouazza-Marouf
// 2000), and the strength of bone is proportional to the square of its density (Carter and Hayes 1977): 1 to 2.
#pragma once

#include <cmath>

#include "cut/force/measured.h"

namespace kerf {

inline constexpr LawParameter kDensityExponent{
    "density_exponent", 0, 0, 3,
    "n: forces in bone are proportional to density^n, which follows from E; not measured on saw teeth, 1 to 2 are "
    "plausible (docs/physics.md); 0: off"};
inline constexpr LawParameter kModulusExponent{
    "modulus_exponent", 1.93, 0.5, 10,
    "b: E is proportional to density^b, by the relation that gave E (human trabecular bone of four sites: 1.49 to "
    "2.18); only with density_exponent"};
// The range begins above all moduli of bone in GPa.
inline constexpr LawParameter kDensityReferenceE{
    "reference_E_MPa", kMeasuredE_MPa, 50, 1e6,
    "E of the bone in which the law's forces were measured; only with density_exponent"};

/// Returns the factor on forces in bone. `power`: n / b. Tick-safe.
inline double CalcDensityFactor(double E_MPa, double reference_E_MPa, double power) {
  return std::pow(E_MPa / reference_E_MPa, power);
}

}  // namespace kerf
