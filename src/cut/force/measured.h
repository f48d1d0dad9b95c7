// Measured forces on saw teeth in bone, with which the thrust of the force laws is compared.
//
// All values of thrust are derived. The tests give resultants (James, Pearlman and Saigal 2012, J Biomech Eng
// 134:071001, single tooth, bovine cortical bone, 8 to 11 N) and, for a tooth of a sagittal saw in bovine femur, the
// ratio of thrust to cutting force (1.4 to 1.8). No force was measured below a bite of 2 um (docs/physics.md).
#pragma once

#include <array>
#include <string>
#include <utility>

#include "kerf/force.h"

namespace kerf {

/// Thrust / cutting force of a tooth, the middle of the measured range 1.4 to 1.8.
inline constexpr double kThrustPerCuttingForce = 1.6;

/// Thrust on a tooth at a bite.
struct MeasuredThrust {
  double bite_mm;
  double thrust_N;
};
/// Thrust on one tooth: 1.6 / sqrt(1 + 1.6^2) = 0.848 of the resultants of 8 and 11 N.
inline constexpr std::array<MeasuredThrust, 2> kMeasuredThrust{{{0.0025, 6.784}, {0.010, 9.328}}};
/// Width of that tooth: the thickness of a surgical saw blade tested at the same bites (Hage and Hamade), likely the
/// same blade.
inline constexpr double kMeasuredToothWidth_mm = 0.64;
/// Elastic constants of the cortical bone that represents the bone of the tests, and its reduced modulus in contact
/// with steel (205 GPa, 0.28).
inline constexpr double kMeasuredE_MPa = 19300;
inline constexpr double kMeasuredPoissonRatio = 0.28;
inline constexpr double kMeasuredEStar_MPa = 19140;

/// Returns the bone of the tests at the speed of its first, as this tool cuts it: cortical, direction unknown.
ToothCut MakeMeasuredBone(const Tool& tool);

/// Thrust in cortical bone / thrust in cancellous bone of a jaw at the same bite. No test measured it with a saw. Its
/// interval is (1.91 / density)^n for densities of 0.55 +- 0.29 g/cm3 (O'Mahony et al. 2000: cancellous bone of one
/// edentulous mandible, n = 7) and n from 1 (drilling forces are linear in the bone mineral density, Ong and
/// Bouazza-Marouf 2000) to 2 (strength, Carter and Hayes 1977, recalled): 2.3 to 54. Drilling a human trochanter took
/// up to 50 N in cortical and 1 to 1.5 N in cancellous bone (Tsai et al. 2007, as quoted by Orelaja et al. 2020, table
/// 6).
inline constexpr std::array<double, 2> kCorticalPerCancellous{2.3, 50};
inline constexpr const char* kCorticalPerCancellousSource =
    "densities (O'Mahony et al. 2000) to a power of 1 to 2, and drilling forces (docs/physics.md)";
/// Returns that ratio for a law at a bite of 2.5 um: region 24 of the built-in table over region 32.
double CalcCorticalPerCancellous(const ForceLaw& law, const Tool& tool);

/// Specific cutting energy, J/mm3. No test measured it. Published forces, widths and bites give 2.9 (bites of 2.5 um)
/// to 0.83 (10 um) for saw teeth, and at most 1.2 to 1.4 for a drill (MacAvelia et al. 2012: thrust and torque).
inline constexpr std::array<double, 2> kEnergyFromForces_J_per_mm3{0.83, 2.9};
/// That interval, widened by kerf: rounded, and the upper bound doubled, because studies differ by a factor of 2.
inline constexpr double kMinSpecificEnergy_J_per_mm3 = 0.8;
inline constexpr double kMaxSpecificEnergy_J_per_mm3 = 6;

/// Returns the law's cutting force on a tooth, N; thrust / kThrustPerCuttingForce if it states none.
inline double CalcCuttingForce(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return law.HasCutting() ? law.Cutting(bite_mm, cut) : law(bite_mm, cut) / kThrustPerCuttingForce;
}
/// Returns the energy of a cutting force per volume of a chip as wide as the tooth, J/mm3.
inline double CalcSpecificEnergy(double cutting_N, double width_mm, double bite_mm) {
  return 1e-3 * cutting_N / (width_mm * bite_mm);
}

/// Explanation that is shown after the bounds.
inline constexpr const char* kSpecificEnergySource =
    "derived from published forces at bites of 2.5 um and more: 0.83 to 2.9, with the upper bound doubled";

/// Limits of a law's use, shown by `kerf check`, `kerf compare` and docs/physics.md.
struct LawCaveat {
  const char* law;
  bool by_width;         // the force is proportional to the tooth's width, so it is compared per mm of width
  const char* good_for;  // phrase: the questions that the law answers, and those that it does not
};

/// Returns the row of the table in src/cut/force/measured.cpp, or one without a name for a law of another program.
const LawCaveat& FindCaveat(const ForceLawInfo& law);

/// Returns the law's thrust on a tooth of this tool divided by the measured thrust. The measured thrust at other bites
/// is taken from the line through the two measured points.
double CalcThrustFactor(const ForceLaw& law, const Tool& tool, double bite_mm);
/// Returns the note on accuracy that accompanies every reported force (`kerf check`, summaries, the window,
/// docs/physics.md), with the factors of this tool and of the law's current parameters.
std::string DescribeAccuracy(const ForceLaw& law, const Tool& tool);
/// Returns the note on how the law's force depends on the size of the blade, or of another tool, shown in the same
/// places.
std::string DescribeBlades(const ForceLaw& law, const Tool& tool);

/// Returns the smallest and the largest bite of the data of a law, mm: of cortical bone in its table (if it has none,
/// of the first tissue), or of the measurements with which the other laws are compared.
std::pair<double, double> FindDataBites(const ForceLaw& law);
/// Returns a phrase such as "a bite of 0.6 um, below the 2.5 to 10 um of the published tests".
std::string DescribeBite(const ForceLaw& law, double bite_mm);

/// Below this bite no force was measured.
inline constexpr double kMinMeasuredBite_mm = 0.002;
/// Multiple of the measured thrust up to which hertz_chip counts as valid.
inline constexpr double kMaxThrustFactor = 2;
/// Returns the largest bite for which the law is valid, mm. For hertz_chip it is the bite at which the law's thrust is
/// kMaxThrustFactor times the measured thrust, but at least kMinMeasuredBite_mm; this bite depends on the tool. For a
/// law with a table see FindDataBites().
double FindMaxValidBite(const ForceLaw& law, const Tool& tool);
/// Returns the smallest bite for which the law is valid, mm. For a law with a table see
/// FindDataBites().
double FindMinValidBite(const ForceLaw& law);

/// Returns true if the law is not valid at any bite (to_mm = 0): its force does not depend on the bite, as the text
/// `beyond` states.
inline bool IsNowhereMeasured(const LawValidity& validity) {
  return validity.to_mm == 0;
}

}  // namespace kerf
