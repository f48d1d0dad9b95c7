// The energy that cutting took: specific (for each volume of bone removed) and of each tooth's passage, to be compared
// with published tests; and a force law's own words of caution, beside each force that is reported.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/run/effect_record.h"
#include "session/scene/scene.h"

namespace kerf {

/// What a run adds up.
struct CuttingSums {
  double thrust_turns_N = 0;  // sum of the teeth's thrusts times the spindle's turns meanwhile
  double simulated_s = 0;     // that `effects` covers
  double cutting_turns = 0;   // of the spindle with a tooth engaged
  double removed_mm3 = 0;
};

/// Work of the teeth's cutting force along their way: its sum over the teeth times the speed of the rim. A law gives
/// the thrust; the cutting force is the thrust divided by `ratio`: the one of the effect tangential_force where it is
/// on, whose own power is then taken, else kThrustPerCuttingForce at the spindle speed that was asked for. The feed's
/// own work is left out: the rim is some thousand times faster.
struct CuttingEnergy {
  double ratio = 0;
  bool from_effect = false;
  /// None for a ball without the effect, whose teeth differ in speed.
  std::optional<double> work_J;
  std::optional<double> specific_J_per_mm3;  // none where hardly anything was cut
  std::optional<double> pass_mJ;             // mean over the passages of a tooth while any is engaged

  /// Within the range derived from published tests (src/cut/force/measured.h); true where there is no figure.
  bool IsAsMeasured() const;
};

CuttingEnergy CalcCuttingEnergy(const Scene& scene, const EffectRecord& effects, const CuttingSums& sums);

/// "0.412 J: 6.05 J/mm3, 1.2 mJ a tooth pass; cutting force = thrust / 1.6; range 0.8 to 6 J/mm3 (...)".
std::string DescribeCuttingEnergy(const CuttingEnergy& energy);
/// A sentence where the specific energy is outside what was measured.
std::vector<std::string> FindEnergyWarnings(const Scene& scene, const CuttingEnergy& energy);
/// "hertz_chip: thrust ...; ...".
std::string DescribeLaw(const Scene& scene);
/// The object "cutting" of a summary, as JSON text.
std::string FormatCuttingJson(const CuttingEnergy& energy);

}  // namespace kerf
