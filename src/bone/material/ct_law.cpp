// Conversion of HU to density and of density to modulus.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bone/material/region_table.h"
#include "kerf/error.h"
#include "kerf/material.h"

namespace kerf {
namespace {

constexpr double kMaxRho = 25;           // g/cm3; a larger value means a wrong unit
constexpr double kMaxHu = 100'000;       // limit on the absolute value
constexpr double kMaxCoefficient = 1e9;  // MPa
constexpr double kMaxExponent = 10;

double CalcInBand(const CtLaw::Band& band, double rho) {
  return band.E0_MPa + band.a_MPa * std::pow(rho, band.b);
}

void CheckBand(const CtLaw::Band& band) {
  const auto name = [&] { return fmt::format("band {} to {} g/cm3", band.lower, band.upper); };
  if (!(band.lower >= 0)) throw Error(fmt::format("{} begins at a negative density", name()));
  if (!(band.upper > band.lower)) throw Error(fmt::format("{}: the upper density must be above the lower one", name()));
  if (!(band.upper <= kMaxRho)) throw Error(fmt::format("{} reaches beyond {} g/cm3", name(), kMaxRho));
  if (!(band.a_MPa > 0 && band.a_MPa <= kMaxCoefficient)) {
    throw Error(
        fmt::format("{}: the coefficient {} must be above 0 and at most {} MPa", name(), band.a_MPa, kMaxCoefficient));
  }
  if (!(band.b > 0 && band.b <= kMaxExponent)) {
    throw Error(fmt::format("{}: the exponent {} must be above 0 and at most {}", name(), band.b, kMaxExponent));
  }
  // E rises within a band, so its extremes are at the ends.
  const double lowest = CalcInBand(band, band.lower);
  const double highest = CalcInBand(band, band.upper);
  if (!(lowest > 0)) throw Error(fmt::format("{}: E = {} MPa at its lower end is not above 0", name(), lowest));
  if (!(highest <= kMaxTableE_MPa)) {
    throw Error(fmt::format("{}: E = {:g} GPa at its upper end is above {} GPa", name(), highest / 1000,
                            kMaxTableE_MPa / 1000));
  }
}

void CheckCalibration(const CtLaw& law) {
  if (law.calibration.empty()) return;
  if (law.calibration.size() < 2) throw Error("a calibration needs at least two points");
  for (std::size_t i = 0; i < law.calibration.size(); ++i) {
    const CtLaw::Point& p = law.calibration[i];
    if (!(std::abs(p.HU) <= kMaxHu)) {
      throw Error(fmt::format("calibration point {}:{}: HU must be within +-{}", p.HU, p.rho, kMaxHu));
    }
    if (!(p.rho >= 0)) throw Error(fmt::format("calibration point {}:{} has a negative density", p.HU, p.rho));
    if (!(p.rho <= kMaxRho)) {
      throw Error(fmt::format("calibration point {}:{} is above {} g/cm3", p.HU, p.rho, kMaxRho));
    }
    if (i == 0) continue;
    const CtLaw::Point& before = law.calibration[i - 1];
    if (!(p.HU > before.HU && p.rho > before.rho)) {
      throw Error(fmt::format("calibration point {}:{} is not above the previous point, {}:{}, in HU and density", p.HU,
                              p.rho, before.HU, before.rho));
    }
  }
  const double lower = law.calibration.front().rho;
  const double upper = law.calibration.back().rho;
  if (upper <= law.lower_rho() || lower >= law.upper_rho()) {
    throw Error(fmt::format("the calibration covers {} to {} g/cm3, but the bands cover {} to {}", lower, upper,
                            law.lower_rho(), law.upper_rho()));
  }
}

/// Returns the CT number of a density within the calibration.
double InvertCalibration(const CtLaw& law, double rho) {
  const auto& points = law.calibration;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (rho > points[i].rho) continue;
    const CtLaw::Point& a = points[i - 1];
    const CtLaw::Point& b = points[i];
    return a.HU + (std::max(rho, a.rho) - a.rho) / (b.rho - a.rho) * (b.HU - a.HU);
  }
  return points.back().HU;
}

}  // namespace

void CheckCtLaw(const CtLaw& law) {
  if (law.bands.empty()) throw Error("a law needs at least one band");
  for (std::size_t i = 0; i < law.bands.size(); ++i) {
    CheckBand(law.bands[i]);
    if (i == 0 || law.bands[i].lower == law.bands[i - 1].upper) continue;
    const CtLaw::Band& a = law.bands[i - 1];
    const CtLaw::Band& b = law.bands[i];
    throw Error(
        fmt::format("band {} to {} g/cm3 {} the band {} to {} before it; a band must begin where the previous one ends",
                    b.lower, b.upper, b.lower < a.upper ? "overlaps" : "leaves a gap to", a.lower, a.upper));
  }
  CheckCalibration(law);
}

double CalcModulus(const CtLaw& law, double rho) {
  const double clamped_rho = std::clamp(rho, law.lower_rho(), law.upper_rho());
  std::size_t band = law.bands.size() - 1;
  while (band > 0 && clamped_rho < law.bands[band].lower) --band;
  return CalcInBand(law.bands[band], clamped_rho);
}

double CalcDensity(const CtLaw& law, double HU) {
  const auto& points = law.calibration;
  if (HU <= points.front().HU) return points.front().rho;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (HU > points[i].HU) continue;
    const CtLaw::Point& a = points[i - 1];
    const CtLaw::Point& b = points[i];
    return a.rho + (HU - a.HU) / (b.HU - a.HU) * (b.rho - a.rho);
  }
  return points.back().rho;
}

std::pair<double, double> CalcValidHu(const CtLaw& law) {
  return {InvertCalibration(law, law.lower_rho()), InvertCalibration(law, law.upper_rho())};
}

}  // namespace kerf
