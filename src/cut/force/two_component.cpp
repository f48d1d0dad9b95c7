// two_component: thrust Ft = w (Ket + Kct h) and cutting force Fc = w (Kec + Kcc h) for a tooth of width w and bite h,
// both times a factor of the tissue and of the direction. The first terms are the rubbing and ploughing of the rounded
// edge; the second ones are the forces on the chip.
//
// The four coefficients are derived from published forces, in bovine cortical bone at bites of 2.5 to 10 um
// (src/cut/force/measured.h; docs/physics.md):
//   1. The resultants of 8 and 11 N (James, Pearlman and Saigal 2012) at a ratio of 1.6 and a tooth width of 0.64 mm
//      give a thrust of 10.6 to 14.6 N/mm and a cutting force of 6.6 to 9.1 N/mm at 2.5 and 10 um: Ket = 9.28, Kct =
//      530, Kec = 5.80, Kcc = 331.
//   2. James et al. 2013 measured 30 % more thrust at 10 um than at 2 um, and a constant cutting force. With the same
//      means at 6.25 um this is Ket = 10.05, Kct = 407, Kec = 7.87, Kcc = 0.
//   3. The defaults are the mean of both, and both are the ends of the stated intervals.
// Crossover: a tooth whose bite is a small fraction of the radius of its edge pushes the bone under the edge and forms
// no chip. No force was measured in bone below 2 um. ASSUMED: the edge terms grow in proportion to the bite up to
// crossover_share times the edge radius, and are constant beyond. The minimum thickness of a chip in metals is 0.2 to
// 0.4 of the edge radius; 0 switches the crossover off, and the force then jumps at a bite of 0.
// Tissues: ASSUMED factors on all four coefficients; no measured force of a saw tooth in other tissue is known. The
// interval of the one of cancellous bone follows from densities and drilling forces (kCorticalPerCancellous). With
// density_exponent, cancellous bone is cortical bone of lower density instead (density.h).
// Osteons: published is only the order (cutting is easiest along the osteons and hardest across planes perpendicular to
// them); the factors are ASSUMED and apply to cortical bone. They are weighted by the squared cosines of OsteonShares.
// Without a known direction the law is isotropic. Speed: no effect from 1700 to 7000 mm/s (James et al. 2013).
#include <algorithm>
#include <limits>

#include "cut/force/density.h"
#include "cut/force/laws.h"

namespace kerf {
namespace {

// Coefficients.
enum {
  kThrustEdge,
  kThrustChip,
  kCuttingEdge,
  kCuttingChip,
  kCrossover,
  kTissues,
  kOsteons = kTissues + kTissueCount,
  kReferenceE = kOsteons + 3,  // only by density
  kPower                       // likewise: n / b
};

/// Returns the factor of the tissue and the direction on all forces.
double CalcFactor(const LawCoefficients& c, const ToothCut& cut) {
  double factor = 0;
  for (int i = 0; i < kTissueCount; ++i) factor += c[kTissues + i] * cut.tissue[i];
  const OsteonShares& s = cut.osteon;
  if (s.along + s.into + s.across > 0) {
    constexpr int kCortical = static_cast<int>(Tissue::kCortical);
    const double direction = c[kOsteons] * s.along + c[kOsteons + 1] * s.into + c[kOsteons + 2] * s.across;
    factor += c[kTissues + kCortical] * cut.tissue[kCortical] * (direction - 1);
  }
  return factor;
}

/// Returns the same factor with the forces in cortical and cancellous bone scaled by their density.
double CalcFactorByDensity(const LawCoefficients& c, const ToothCut& cut) {
  double others = 0;
  for (int i = static_cast<int>(Tissue::kTooth); i < kTissueCount; ++i) others += c[kTissues + i] * cut.tissue[i];
  return others + (CalcFactor(c, cut) - others) * CalcDensityFactor(cut.E_MPa, c[kReferenceE], c[kPower]);
}

/// Returns the fraction of the edge terms that acts at a bite.
double CalcEdgeShare(const LawCoefficients& c, double bite_mm) {
  return bite_mm < c[kCrossover] ? bite_mm / c[kCrossover] : 1;
}

template <double (*kFactor)(const LawCoefficients&, const ToothCut&)>
double CalcComponentThrust(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  const LawCoefficients& c = law.c;
  return kFactor(c, cut) * (c[kThrustEdge] * CalcEdgeShare(c, bite_mm) + c[kThrustChip] * bite_mm);
}
template <double (*kFactor)(const LawCoefficients&, const ToothCut&)>
double CalcComponentCutting(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  const LawCoefficients& c = law.c;
  return kFactor(c, cut) * (c[kCuttingEdge] * CalcEdgeShare(c, bite_mm) + c[kCuttingChip] * bite_mm);
}

/// Returns a / b, or infinity if b is 0.
double Ratio(double a, double b) {
  return b > 0 ? a / b : std::numeric_limits<double>::infinity();
}

// Order of the parameters.
enum {
  kTissueParameters = 5,
  kOsteonParameters = kTissueParameters + kTissueCount - 1,
  kDensityParameters = kOsteonParameters + 3
};

}  // namespace

const ForceLawInfo& TwoComponent() {
  static const char* const kSpread = "the two readings of the published forces (docs/physics.md)";
  static const char* const kAssumed = "an assumption; no measurement";
  static const ForceLawInfo kLaw{
      .name = "two_component",
      .summary =
          "thrust and cutting force, each with an edge term and a chip term proportional to the tooth's width; "
          "derived estimate",
      .source =
          "derived from James et al. 2012 and 2013, bovine cortical bone, on a tooth 0.64 mm wide with a rake of "
          "-10 deg; factors of tissue and direction assumed (docs/physics.md)",
      .validity = {0.0025, 0.01, "below that the fading of the edge term is an assumption",
                   "beyond that the chip term is an extrapolation"},
      .parameters =
          {{"thrust_edge_N_per_mm", 9.66, 0, 1e4, "Ket: thrust of the edge for each mm of tooth width; derived", 9.28,
            10.05, kSpread},
           {"thrust_chip_N_per_mm2", 468, 0, 1e6, "Kct: thrust for each mm2 of chip, tooth width times bite; derived",
            407, 530, kSpread},
           {"cutting_edge_N_per_mm", 6.83, 0, 1e4, "Kec: cutting force of the edge for each mm of tooth width; derived",
            5.80, 7.87, kSpread},
           {"cutting_chip_N_per_mm2", 166, 0, 1e6, "Kcc: cutting force for each mm2 of chip; derived", 0, 331, kSpread},
           {"crossover_share", 0.25, 0, 10,
            "bite, as a fraction of the edge's radius, below which the edge terms fall linearly to 0; an assumption", 0,
            0.4, kAssumed},
           {"cancellous_factor", 0.25, 0, 10,
            "factor on all forces in cancellous bone; an assumption; unused with density_exponent",
            1 / kCorticalPerCancellous[1], 1 / kCorticalPerCancellous[0], kCorticalPerCancellousSource},
           {"tooth_factor", 1, 0, 10, "factor on all forces in teeth; an assumption", 0.5, 4, kAssumed},
           {"canal_factor", 0, 0, 10, "factor on all forces in the mandibular canal; an assumption", 0, 0.1, kAssumed},
           {"other_factor", 1, 0, 10, "factor on all forces in other tissue; an assumption", 0.5, 1.5, kAssumed},
           {"osteon_along_factor", 0.75, 0.01, 10,
            "factor in cortical bone for a tooth that moves along the osteons; only the order of the three is "
            "published",
            0.5, 1, kAssumed},
           {"osteon_into_factor", 1.25, 0.01, 10, "factor for a thrust along the osteons; only the order is published",
            1, 1.5, kAssumed},
           {"osteon_across_factor", 1, 0.01, 10, "factor for an edge along the osteons; only the order is published",
            0.75, 1.25, kAssumed},
           kDensityExponent,
           kModulusExponent,
           kDensityReferenceE},
      .make =
          [](const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>&) {
            ToothForce law{.thrust = CalcComponentThrust<CalcFactor>,
                           .cutting = CalcComponentCutting<CalcFactor>,
                           .reads = kReadsTissue | kReadsOsteons};
            for (int i = kThrustEdge; i <= kCuttingChip; ++i) law.c[i] = values[i] * tooth.width_mm;
            law.c[kCrossover] = values[kCrossover] * tooth.edge_radius_mm;
            law.c[kTissues] = 1;  // cortical
            std::copy_n(values.begin() + kTissueParameters, kTissueCount - 1, law.c.begin() + kTissues + 1);
            std::copy_n(values.begin() + kOsteonParameters, 3, law.c.begin() + kOsteons);
            if (const double n = values[kDensityParameters]; n > 0) {
              law.thrust = CalcComponentThrust<CalcFactorByDensity>;
              law.cutting = CalcComponentCutting<CalcFactorByDensity>;
              law.c[kTissues + static_cast<int>(Tissue::kCancellous)] = 1;
              law.c[kReferenceE] = values[kDensityParameters + 2];
              law.c[kPower] = n / values[kDensityParameters + 1];
            }
            // At any bite, force and slope are weighted sums of both pairs of coefficients.
            law.least_thrust_per_cutting = std::min(Ratio(values[kThrustEdge], values[kCuttingEdge]),
                                                    Ratio(values[kThrustChip], values[kCuttingChip]));
            return law;
          },
      .has_cutting = true};
  return kLaw;
}

}  // namespace kerf
