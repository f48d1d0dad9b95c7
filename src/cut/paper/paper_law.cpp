#include "kerf/paper.h"

#include <algorithm>
#include <cmath>

namespace kerf {

std::string_view ToString(PaperReading reading) {
  return reading == PaperReading::kAsComputed ? "as_computed" : "corrected";
}

std::optional<PaperReading> PaperReadingFromString(std::string_view word) {
  if (word == "as_computed") return PaperReading::kAsComputed;
  if (word == "corrected") return PaperReading::kCorrected;
  return std::nullopt;
}

double CalcPaperArc(double depth_mm, double diameter_mm) {
  const double h = std::clamp(depth_mm, 0.0, diameter_mm);
  return diameter_mm * std::acos(1 - h / (2 * diameter_mm));
}

double CalcTrueArc(double depth_mm, double diameter_mm) {
  const double h = std::clamp(depth_mm, 0.0, diameter_mm);
  return 0.5 * diameter_mm * std::acos(1 - 2 * h / diameter_mm);
}

double CalcHertzK(const DiscSaw& saw, double E2_MPa, double nu2) {
  const double compliance = (1 - saw.nu * saw.nu) / saw.E_MPa + (1 - nu2 * nu2) / E2_MPa;
  return std::cbrt(3 * saw.diameter_mm * compliance / 8);
}

double CalcPaperToothForce(const DiscSaw& saw, double fraction_of_pitch, double E2_MPa, double nu2) {
  const double radii = fraction_of_pitch * saw.pitch_mm() / CalcHertzK(saw, E2_MPa, nu2);
  return radii * radii * radii;
}

double FloorTeeth(double teeth) {
  // At some depths the arc is a whole number of pitches (the buried disc: 8 of 24); rounding must not lose a tooth
  // there.
  return std::floor(teeth + 1e-9);
}

double CalcPaperTeeth(const DiscSaw& saw, double depth_mm, PaperReading reading) {
  if (reading == PaperReading::kCorrected) return CalcTrueArc(depth_mm, saw.diameter_mm) / saw.pitch_mm();
  return FloorTeeth(CalcPaperArc(depth_mm, saw.diameter_mm) / saw.pitch_mm());
}

double CalcPaperForce(const DiscSaw& saw, double fraction_of_pitch, double depth_mm, double E2_MPa, double nu2,
                      PaperReading reading) {
  const double n = CalcPaperTeeth(saw, depth_mm, reading);
  const double F_1 = CalcPaperToothForce(saw, fraction_of_pitch, E2_MPa, nu2);
  return reading == PaperReading::kCorrected ? n * F_1 : n * n * n * F_1;
}

}  // namespace kerf
