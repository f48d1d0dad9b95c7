// Energy of cutting: specific energy (per volume of removed bone) and energy per tooth passage, for comparison with
// published tests. Also describes the caveats of a force law, which are reported next to its forces.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "session/run/effect_record.h"
#include "session/scene/scene.h"

namespace kerf {

/// Sums over a run.
struct CuttingSums {
  double thrust_J = 0;       // integral of TeethOutput::thrust_W
  double simulated_s = 0;    // duration that `effects` covers
  double cutting_turns = 0;  // spindle revolutions with a tooth engaged
  double removed_mm3 = 0;
  double cutting_J = 0;  // work of the law's cutting force, if the law states one
};

/// Source of the cutting force.
enum class CuttingForceFrom { kRatio, kEffect, kLaw };

/// Work of the teeth's cutting force along their motion: the sum of the teeth's cutting forces times the speed of the
/// rim, over time. If the effect tangential_force is on, its power is used. Otherwise the cutting force is the law's
/// own or, for a law that states none, the thrust divided by kThrustPerCuttingForce.
/// The work of the feed is left out, because the rim moves about a thousand times faster.
struct CuttingEnergy {
  CuttingForceFrom from = CuttingForceFrom::kRatio;
  std::optional<double> ratio;  // thrust per cutting force; none if the law states the cutting force
  /// None for a ball without the effect and with a law that states no cutting force, because its teeth move at
  /// different speeds.
  std::optional<double> work_J;
  std::optional<double> specific_J_per_mm3;  // none if almost nothing was cut
  std::optional<double> pass_mJ;             // mean per tooth passage while any tooth is engaged

  /// Returns true if the specific energy is within kerf's widened interval (src/cut/force/measured.h), or unknown.
  bool IsWithinWidened() const;
};

CuttingEnergy CalcCuttingEnergy(const SimulationParams& params, const EffectRecord& effects, const CuttingSums& sums);
CuttingEnergy CalcCuttingEnergy(const Scene& scene, const EffectRecord& effects, const CuttingSums& sums);

/// Returns a phrase such as "0.412 J, 6.05 J/mm3, 1.2 mJ per tooth pass; cutting force = thrust / 1.6; range 0.8 to 6
/// J/mm3 (...)".
std::string DescribeCuttingEnergy(const CuttingEnergy& energy);
/// Returns a sentence if the specific energy is outside that interval.
std::vector<std::string> FindEnergyWarnings(const ForceLaw& law, const CuttingEnergy& energy);
inline std::vector<std::string> FindEnergyWarnings(const Scene& scene, const CuttingEnergy& energy) {
  return FindEnergyWarnings(scene.force, energy);
}
/// Returns a phrase such as "hertz_chip: thrust ...; ...".
std::string DescribeLaw(const Scene& scene);
/// Returns a phrase on the bites at the speeds of the scene's path, such as "up to a bite of 1 um, below the 2.5 to 10
/// um of the published tests".
std::string DescribeBites(const Scene& scene);
/// Returns the object "cutting" of a summary.
nlohmann::ordered_json CuttingJson(const CuttingEnergy& energy);

}  // namespace kerf
