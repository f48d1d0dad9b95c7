// edge_plus_chip: F = (Ke w + Kc w h) E* / E*_ref on a tooth of width w (of a disc, its thickness) that bites h deep.
// The edge rubs with a force of its own, the chip adds one that grows with its thickness.
//
// The defaults are a derived estimate, not a measurement (figures: src/cut/force/measured.h). From James et al. (2012),
// a single saw tooth in bovine cortical bone: the resultant rises from 8 to 11 N over bites of 2.5 to 10 um; and from a
// sagittal saw's tooth in bovine femur: thrust / cutting force = 1.4 to 1.8.
//   1. At a ratio of 1.6 thrust = resultant * 1.6 / sqrt(1 + 1.6^2) = 0.848 resultant: 6.78 N to 9.33 N.
//   2. The line through both: 5.94 N + 339 N/mm h.
//   3. A tooth 0.64 mm wide, the thickness of the surgical saw blade whose teeth Hage and Hamade describe for the same
//      bites of 2.5 to 10 um. That it is the blade of these two tests is likely, not proven: Ke = 9.28 N/mm,
//      Kc = 530 N/mm^2.
//   4. Figures for one bone only, so that a softer one gets less in proportion to E*, ASSUMED; E*_ref is that of steel
//      (205 GPa, 0.28) on region 24 (19.3 GPa, 0.28), standing for the bovine bone: 19140 MPa.
// Check: with a cutting force of thrust / 1.6 the specific cutting energy is 2.65 J/mm3 at 2.5 um and 0.91 J/mm3 at
// 10 um, within the 2.4 to 2.9 and 0.83 to 1.0 J/mm3 that the first test's resultants (8 and 11 N) give with the second
// test's ratios. The line gives 41 % more thrust at 10 um than at 2 um; James et al. (2013) measured 30 %.
#include "cut/force/laws.h"

namespace kerf {
namespace {

// coefficients: Ke w / E*_ref, mm^2; Kc w / E*_ref, mm.
double CalcForce(const LawValues& c, double bite_mm, double E_star_MPa) {
  return (c[0] + c[1] * bite_mm) * E_star_MPa;
}

}  // namespace

const ForceLawInfo& EdgePlusChip() {
  static const ForceLawInfo kLaw{
      "edge_plus_chip",
      "a constant for the edge and a share that grows with the bite, both by the tooth's width; derived estimate",
      "derived from James et al. 2012, bovine cortical bone, on a tooth 0.64 mm wide; E* scaling assumed "
      "(docs/physics.md)",
      {0.0025, 0.01, "below that the edge's share is an extrapolation",
       "beyond that the chip's share is an extrapolation"},
      {{"edge_N_per_mm", 9.28, 0, 1e4, "Ke: thrust of the edge for each mm of tooth width; derived estimate"},
       {"chip_N_per_mm2", 530, 0, 1e6, "Kc: thrust for each mm2 of chip, tooth width times bite; derived estimate"},
       {"reference_E_star_MPa", 19140, 1, 1e6,
        "reduced modulus, tool on bone, that both are for; the force goes with E*, an assumption"}},
      [](const LawValues& values, const Tooth& tooth) {
        const double share = tooth.width_mm / values[2];
        return ToothForce{CalcForce, {values[0] * share, values[1] * share}};
      }};
  return kLaw;
}

}  // namespace kerf
