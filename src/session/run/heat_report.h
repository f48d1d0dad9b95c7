// Results of the effect "heat" in a run: values and a picture of the kerf's surroundings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "cut/effects/heat/heat.h"
#include "cut/effects/plan.h"
#include "kerf/geometry.h"

namespace kerf {

struct HeatReport {
  HeatParams params;
  HeatFigures figures;
  HeatBalance balance_mJ;
  double memory_MB = 0;
  HeatSection section;  // across the kerf, through the centre of the warm region; v along the kerf's normal
};

/// Returns none if the plan has no heat. `X_WT`: a pose of the tool in its kerf. Allocates; call between ticks only.
std::optional<HeatReport> MakeHeatReport(const EffectPlan& effects, const Pose& X_WT);

/// Describes the heat in one readable line.
std::string DescribeHeat(const HeatReport& heat);
/// Returns an object with stable keys that include the units.
nlohmann::ordered_json HeatJson(const HeatReport& heat);
/// Draws the temperatures at the end of the run, with isolines at 47 C and at a dose of 16 min.
void WriteHeatPicture(const HeatReport& heat, const std::string& name, const std::string& path);

}  // namespace kerf
