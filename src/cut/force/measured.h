// What was measured of the forces on a saw's teeth in bone, for the laws to be compared with, thrust with thrust.
//
// All of it is derived: the tests give resultants (James, Pearlman and Saigal 2012, J Biomech Eng 134:071001, single
// tooth, bovine cortical bone, 8 to 11 N) and, for a sagittal saw's tooth in bovine femur, the ratio of thrust to
// cutting force (1.4 to 1.8). Below a bite of 2 um no force was measured at all (docs/physics.md).
#pragma once

#include <array>
#include <string>

#include "kerf/force.h"

namespace kerf {

/// Thrust / cutting force of a tooth, the middle of 1.4 to 1.8.
inline constexpr double kThrustPerCuttingForce = 1.6;

struct MeasuredThrust {
  double bite_mm;
  double thrust_N;
};
/// 1.6 / sqrt(1 + 1.6^2) = 0.848 of the resultants of 8 and 11 N, on one tooth.
inline constexpr std::array<MeasuredThrust, 2> kMeasuredThrust{{{0.0025, 6.784}, {0.010, 9.328}}};
/// Of that tooth: thickness of a surgical saw blade tested at the same bites (Hage and Hamade). Likely the same blade.
inline constexpr double kMeasuredToothWidth_mm = 0.64;
/// Cortical bone, standing for the bone of the tests; and its reduced modulus with steel (205 GPa, 0.28).
inline constexpr double kMeasuredE_MPa = 19300;
inline constexpr double kMeasuredPoissonRatio = 0.28;
inline constexpr double kMeasuredEStar_MPa = 19140;

/// Bounds of the specific cutting energy, J/mm3. No test measured it: from published forces, widths and bites follow
/// 0.83 (10 um bites) to 2.9 (2.5 um) on saw teeth, and at most 1.2 to 1.4 on a drill (MacAvelia et al. 2012: thrust
/// and torque). The upper bound leaves the factor of 2 by which studies differ.
inline constexpr double kLeastSpecificEnergy_J_per_mm3 = 0.8;
inline constexpr double kMostSpecificEnergy_J_per_mm3 = 6;

/// Energy of the cutting force, thrust / kThrustPerCuttingForce, for each volume of a chip as wide as the tooth, J/mm3.
inline double CalcSpecificEnergy(double thrust_N, double width_mm, double bite_mm) {
  return 1e-3 * thrust_N / kThrustPerCuttingForce / (width_mm * bite_mm);
}

/// What follows the bounds where they are shown.
inline constexpr const char* kSpecificEnergySource =
    "derived from published forces at bites of 2.5 um and more, 0.83 to 2.9, and doubled above";

/// `kerf check`, `kerf compare` and docs/physics.md show it.
struct LawCaveat {
  const char* law;
  bool by_width;         // its force goes with the tooth's width: compared with the measured for each mm of it
  const char* good_for;  // which questions it answers and which not, a phrase
};

/// Throws Error for a law that src/cut/force/measured.cpp has no row of.
const LawCaveat& FindCaveat(const ForceLawInfo& law);

/// The law's thrust on this tool's tooth by the measured one, or the line through the two measured at other bites.
double CalcThrustFactor(const ForceLaw& law, const Tool& tool, double bite_mm);
/// What stands beside every force that is reported by a law: `kerf check`, summaries, the window, docs/physics.md. With
/// the factors of this tool and of the law's parameters as they are.
std::string DescribeAccuracy(const ForceLaw& law, const Tool& tool);
/// What the law says of different blades, likewise.
std::string DescribeBlades(const ForceLaw& law);

/// The largest bite that the law holds for: of hertz_chip, the one with kMostThrustFactor, which depends on the tool.
inline constexpr double kMostThrustFactor = 2;
double FindTopValidBite(const ForceLaw& law, const Tool& tool);

/// A law whose range of bites is empty (to_mm = 0) has a force that no bite changes, as `beyond` then says.
inline bool IsNowhereMeasured(const LawValidity& validity) {
  return validity.to_mm == 0;
}

}  // namespace kerf
