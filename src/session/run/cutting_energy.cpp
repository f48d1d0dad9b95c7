#include "session/run/cutting_energy.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <variant>

#include "base/table/table_json.h"
#include "cut/force/measured.h"
#include "cut/tool/shape.h"
#include "cut/tool/words.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

constexpr double kNegligible_mm3 = 1e-3;
/// Specific energy below which practically no tooth cut, far below that of any law.
constexpr double kNoCutting_J_per_mm3 = 1e-6;
/// In the order of CuttingForceFrom.
constexpr std::array<const char*, 3> kFromWords{"thrust / ratio", "tangential_force", "law"};

/// Returns the cutting power of the effect tangential_force, averaged over the run's ticks; none if the effect is off.
std::optional<double> FindMeanPower(const EffectRecord& effects) {
  for (const EffectFigure& figure : effects.figures) {
    if (figure.effect == "tangential_force" && figure.name == "cutting_W" && effects.ticks > 0) {
      return figure.sum / static_cast<double>(effects.ticks);
    }
  }
  return std::nullopt;
}

}  // namespace

bool CuttingEnergy::IsWithinWidened() const {
  return !specific_J_per_mm3 ||
         (*specific_J_per_mm3 >= kMinSpecificEnergy_J_per_mm3 && *specific_J_per_mm3 <= kMaxSpecificEnergy_J_per_mm3);
}

CuttingEnergy CalcCuttingEnergy(const Scene& scene, const EffectRecord& effects, const CuttingSums& sums) {
  return CalcCuttingEnergy(MakeSimulationParams(scene), effects, sums);
}

CuttingEnergy CalcCuttingEnergy(const SimulationParams& params, const EffectRecord& effects, const CuttingSums& sums) {
  CuttingEnergy energy;
  const bool by_law = params.law.info().has_cutting;
  if (const std::optional<double> power_W = FindMeanPower(effects)) {
    energy.from = CuttingForceFrom::kEffect;
    if (!by_law) energy.ratio = FindChoice(params.effects, "tangential_force")->GetNumber("ratio");
    energy.work_J = *power_W * sums.simulated_s;
  } else if (by_law) {
    energy.from = CuttingForceFrom::kLaw;
    energy.work_J = sums.cutting_J;
  } else {
    energy.ratio = kThrustPerCuttingForce;
    if (IsBlade(params.tool)) energy.work_J = sums.thrust_J / *energy.ratio;
  }
  if (!energy.work_J) return energy;
  // If bone was removed only because the tool was placed inside it, no work was done.
  const bool cuts = *energy.work_J > 0 || sums.cutting_turns > 0;
  if (cuts && sums.removed_mm3 > kNegligible_mm3) energy.specific_J_per_mm3 = *energy.work_J / sums.removed_mm3;
  const double passes = CountPassesPerTurn(params.tool) * sums.cutting_turns;
  if (passes > 0) energy.pass_mJ = 1e3 * *energy.work_J / passes;
  return energy;
}

std::string DescribeCuttingEnergy(const CuttingEnergy& energy) {
  if (!energy.work_J) return "energy unknown: the teeth of this tool differ in speed; add [effects.tangential_force]";
  std::string text = fmt::format("{:.3g} J", *energy.work_J);
  if (energy.specific_J_per_mm3) text += fmt::format(", {:.3g} J/mm3", *energy.specific_J_per_mm3);
  if (energy.pass_mJ) text += fmt::format(", {:.3g} mJ per tooth pass", *energy.pass_mJ);
  const std::string force = energy.ratio ? fmt::format("thrust / {:.3g}", *energy.ratio) : "the law's own";
  return text + fmt::format("; cutting force = {}; range {:g} to {:g} J/mm3 ({})", force, kMinSpecificEnergy_J_per_mm3,
                            kMaxSpecificEnergy_J_per_mm3, kSpecificEnergySource);
}

std::vector<std::string> FindEnergyWarnings(const ForceLaw& law, const CuttingEnergy& energy) {
  if (energy.IsWithinWidened()) return {};
  if (*energy.specific_J_per_mm3 < 0) {
    return {"the tool moves as fast as its teeth: the bone drives the spindle, and the energy of cutting is below 0"};
  }
  if (*energy.specific_J_per_mm3 < kNoCutting_J_per_mm3) {
    return {"practically no tooth cut: the tool removed bone without a force; move it with its teeth first"};
  }
  return {
      fmt::format("the specific cutting energy is {:.3g} J/mm3, outside {:g} to {:g} J/mm3 ({}): the forces of {} are "
                  "unrealistic",
                  *energy.specific_J_per_mm3, kMinSpecificEnergy_J_per_mm3, kMaxSpecificEnergy_J_per_mm3,
                  kSpecificEnergySource, law.name())};
}

std::string DescribeLaw(const Scene& scene) {
  return fmt::format("{}, {}: {}; {}", scene.force.name(), DescribeBites(scene),
                     DescribeAccuracy(scene.force, MakeTool(scene)), DescribeBlades(scene.force, MakeTool(scene)));
}

std::string DescribeBites(const Scene& scene) {
  const double bite_mm = CalcMaxBite(scene);
  if (!std::isfinite(bite_mm)) return "the spindle is stopped";
  const Tool tool = MakeTool(scene);
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  const bool equal = solid && !solid->side_cuts;  // the lips of a drill bite equally deep everywhere
  const bool within = bite_mm >= FindDataBites(scene.force).first;
  if (!within || equal) return fmt::format("up to {}", DescribeBite(scene.force, bite_mm));
  return fmt::format("up to {}, but bites {} begin at 0", DescribeBite(scene.force, bite_mm),
                     CalcStroke(tool) > 0 ? "in each stroke" : fmt::format("along the {}", GetWords(tool).edge));
}

nlohmann::ordered_json CuttingJson(const CuttingEnergy& energy) {
  return {{"work_J", OrNull(energy.work_J)},
          {"specific_energy_J_per_mm3", OrNull(energy.specific_J_per_mm3)},
          {"from_measured_forces_J_per_mm3", kEnergyFromForces_J_per_mm3},
          {"widened_J_per_mm3", {kMinSpecificEnergy_J_per_mm3, kMaxSpecificEnergy_J_per_mm3}},
          {"within_widened", energy.specific_J_per_mm3 ? nlohmann::ordered_json(energy.IsWithinWidened()) : nullptr},
          {"tooth_pass_mJ", OrNull(energy.pass_mJ)},
          {"thrust_per_cutting_force", OrNull(energy.ratio)},
          {"cutting_force_from", kFromWords[static_cast<std::size_t>(energy.from)]}};
}

}  // namespace kerf
