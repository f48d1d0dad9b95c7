// edge_plus_chip: F = (Ke w + Kc w h) E* / E*_ref for a tooth of width w (for a disc, its thickness) and bite h. The
// first term is the rubbing force of the edge. The second is the force on the chip and grows with its thickness.
//
// The defaults are a derived estimate, not a measurement (figures: src/cut/force/measured.h). Sources: James et al.
// (2012), a single saw tooth in bovine cortical bone, whose resultant rises from 8 to 11 N over bites of 2.5 to 10 um;
// and a tooth of a sagittal saw in bovine femur, with thrust / cutting force = 1.4 to 1.8.
//   1. At a ratio of 1.6, thrust = resultant * 1.6 / sqrt(1 + 1.6^2) = 0.848 resultant: 6.78 N to 9.33 N.
//   2. The line through both points: 5.94 N + 339 N/mm h.
//   3. The tooth is taken as 0.64 mm wide, the thickness of the surgical saw blade whose teeth Hage and Hamade describe
//      for the same bites of 2.5 to 10 um. It is likely, but not proven, that these two tests used the same blade. The
//      result is Ke = 9.28 N/mm, Kc = 530 N/mm^2.
//   4. The tests cover one bone only. The force on softer bone is ASSUMED to be proportional to E*. E*_ref is the value
//      for steel (205 GPa, 0.28) on region 24 (19.3 GPa, 0.28), which represents the bovine bone: 19140 MPa. With
//      density_exponent the force is proportional to a power of the density instead (density.h).
// Check: with a cutting force of thrust / 1.6 the specific cutting energy is 2.65 J/mm3 at 2.5 um and 0.91 J/mm3 at 10
// um. Both are within the ranges of 2.4 to 2.9 and 0.83 to 1.0 J/mm3 that follow from the resultants of the first test
// (8 and 11 N) with the ratios of the second. The line gives 41 % more thrust at 10 um than at 2 um; James et al.
// (2013) measured 30 %.
#include "cut/force/density.h"
#include "cut/force/laws.h"

namespace kerf {
namespace {

// coefficients: Ke w / E*_ref, mm^2; Kc w / E*_ref, mm.
double CalcEdgeAndChipThrust(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return (law.c[0] + law.c[1] * bite_mm) * cut.E_star_MPa;
}
// coefficients: Ke w, N; Kc w, N/mm; E_ref; n / b.
double CalcThrustByDensity(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return (law.c[0] + law.c[1] * bite_mm) * CalcDensityFactor(cut.E_MPa, law.c[2], law.c[3]);
}

}  // namespace

const ForceLawInfo& EdgePlusChip() {
  static const ForceLawInfo kLaw{
      "edge_plus_chip",
      "a constant edge term and a chip term that grows with the bite, both proportional to the tooth's width; derived "
      "estimate",
      "derived from James et al. 2012, bovine cortical bone, on a tooth 0.64 mm wide; E* scaling assumed "
      "(docs/physics.md)",
      {0.0025, 0.01, "below that the edge term is an extrapolation", "beyond that the chip term is an extrapolation"},
      {{"edge_N_per_mm", 9.28, 0, 1e4, "Ke: thrust of the edge for each mm of tooth width; derived estimate", 9.28,
        10.05, "the two readings of the published forces (docs/physics.md)"},
       {"chip_N_per_mm2", 530, 0, 1e6, "Kc: thrust for each mm2 of chip, tooth width times bite; derived estimate", 407,
        530, "the two readings of the published forces (docs/physics.md)"},
       {"reference_E_star_MPa", 19140, 1, 1e6,
        "reduced modulus, tool on bone, for which both hold; the force is proportional to E*, an assumption, unless "
        "density_exponent is set"},
       kDensityExponent,
       kModulusExponent,
       kDensityReferenceE},
      [](const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>&) {
        if (values[3] > 0) {
          return ToothForce{
              .thrust = CalcThrustByDensity,
              .c = {values[0] * tooth.width_mm, values[1] * tooth.width_mm, values[5], values[3] / values[4]}};
        }
        const double fraction = tooth.width_mm / values[2];
        return ToothForce{.thrust = CalcEdgeAndChipThrust, .c = {values[0] * fraction, values[1] * fraction}};
      }};
  return kLaw;
}

}  // namespace kerf
