#include "cut/force/measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <variant>

#include "cut/tool/words.h"
#include "kerf/material.h"

namespace kerf {
namespace {

constexpr std::array<LawCaveat, 5> kCaveats{{
    {"hertz_chip", false,
     "good for: comparing the force at different places of a bone, with one blade at one bite (a force proportional "
     "to E* is assumed); not for: absolute forces, energies, the effect of the feed, the choice of a blade"},
    {"hertz_constant_bite", false,
     "good for: the paper's tables; not for: absolute forces, energies, the effect of the feed, the choice of a blade"},
    {"edge_plus_chip", true,
     "good for: the magnitude of the thrust in cortical bone at bites of 2.5 to 10 um, within the factor of 2 to 3 by "
     "which studies differ, and the effect of the feed there; not for: smaller bites, soft bone, discs of another "
     "diameter"},
    {"two_component", true,
     "good for: the magnitude of thrust, cutting force and energy in cortical bone at bites of 2.5 to 10 um, within "
     "the "
     "factor of 2 to 3 by which studies differ, and the effect of the feed there; not for: smaller bites, where the "
     "crossover is assumed, other tissues, whose factors are assumed, teeth of another rake"},
    {"tabulated", true,
     "good for: the tool, the tissues and the bites that its table was measured for; not for: anything else"},
}};

double CalcMeasuredThrust(double bite_mm) {
  const auto& [low, high] = kMeasuredThrust;
  return low.thrust_N + (high.thrust_N - low.thrust_N) * (bite_mm - low.bite_mm) / (high.bite_mm - low.bite_mm);
}

/// Returns a phrase such as "1.6 times" or "1/122 of".
std::string ShowFactor(double factor) {
  if (!(factor > 0)) return "0 times";
  return factor >= 0.1 ? fmt::format("{:.2g} times", factor) : fmt::format("1/{:.3g} of", 1 / factor);
}

}  // namespace

const LawCaveat& FindCaveat(const ForceLawInfo& law) {
  const auto* found = std::find_if(kCaveats.begin(), kCaveats.end(),
                                   [&](const LawCaveat& c) { return std::string_view(c.law) == law.name; });
  static constexpr LawCaveat kOfAnotherProgram{"", false,
                                               "it is a law of another program, of which kerf knows no measurements"};
  return found == kCaveats.end() ? kOfAnotherProgram : *found;
}

ToothCut MakeMeasuredBone(const Tool& tool) {
  constexpr double kSpeed_mm_per_s = 4400;  // the middle of 2600 to 6200 mm/s
  return MakeToothCut(
      kMeasuredE_MPa,
      CalcReducedModulus(CalcModulus(tool), CalcPoissonRatio(tool), kMeasuredE_MPa, kMeasuredPoissonRatio),
      Tissue::kCortical, kSpeed_mm_per_s);
}

double CalcThrustFactor(const ForceLaw& law, const Tool& tool, double bite_mm) {
  const double width = FindCaveat(law.info()).by_width ? kMeasuredToothWidth_mm / CalcTooth(tool).width_mm : 1;
  return width * MakeToothForce(law, tool)(bite_mm, MakeMeasuredBone(tool)) / CalcMeasuredThrust(bite_mm);
}

double CalcCorticalPerCancellous(const ForceLaw& law, const Tool& tool) {
  const ToothForce force = MakeToothForce(law, tool);
  const auto thrust = [&](int id) {
    const Region& region = DefaultMandibleTable().At(id);
    const double E_star_MPa = CalcReducedModulus(CalcModulus(tool), CalcPoissonRatio(tool), region.E_MPa, region.nu);
    return force(kMeasuredThrust.front().bite_mm, MakeToothCut(region.E_MPa, E_star_MPa, region.tissue));
  };
  return thrust(24) / thrust(32);
}

std::string DescribeAccuracy(const ForceLaw& law, const Tool& tool) {
  const bool by_width = FindCaveat(law.info()).by_width;
  const bool is_default = law.values() == ForceLaw(law.name()).values() && !law.has_own_table();
  const auto at = [&](std::size_t i) { return ShowFactor(CalcThrustFactor(law, tool, kMeasuredThrust.at(i).bite_mm)); };
  return fmt::format(
      "thrust{} {} that measured at a bite of 2.5 um, {} that at 10 um ({}); nothing was measured below 2 um",
      by_width ? " for each mm of tooth width:" : "", at(0), at(1),
      !by_width    ? DescribeToolBriefly(tool)
      : is_default ? "to which it is fitted by default; studies differ by a factor of 2 to 3"
                   : "with the scene's own values; studies differ by a factor of 2 to 3");
}

std::pair<double, double> FindDataBites(const ForceLaw& law) {
  if (law.table() == nullptr) return {kMeasuredThrust.front().bite_mm, kMeasuredThrust.back().bite_mm};
  // Cortical bone has by far the largest forces, and comes first.
  const auto rows = std::ranges::find_if(law.table()->rows(), [](const auto& of_tissue) { return !of_tissue.empty(); });
  return {rows->front().bite_mm, rows->back().bite_mm};
}

std::string DescribeBite(const ForceLaw& law, double bite_mm) {
  const auto [from_mm, to_mm] = FindDataBites(law);
  const char* place = bite_mm < from_mm ? "below" : bite_mm > to_mm ? "above" : "within";
  return fmt::format("a bite of {:.3g} um, {} the {:g} to {:g} um of {}", 1000 * bite_mm, place, 1000 * from_mm,
                     1000 * to_mm, law.table() != nullptr ? "its table" : "the published tests");
}

std::string DescribeBlades(const ForceLaw& law, const Tool& tool) {
  // The width of a blade's tooth is the blade's thickness; teeth of another tool are pieces of its flutes or lips.
  const std::string_view line = GetWords(tool).line;
  const std::string_view name = law.name();
  const bool has_radius_term = name == "two_component";
  if (name == "edge_plus_chip" || name == "tabulated" || has_radius_term) {
    const std::string width =
        line.empty() ? "the blade's thickness" : fmt::format("the length of the {}s that cuts", line);
    return fmt::format("scales with {}, {}ignores the tool's radius{}", width, has_radius_term ? "" : "and ",
                       has_radius_term ? ", and reads the edge's radius at small bites" : "");
  }
  const bool own_radius = law.Get("contact_radius_mm") > 0;  // set in the scene, so the tool's radius is not used
  const char* rest = name == "hertz_chip"
                         ? (own_radius ? "the tool's radius" : "scales with the square root of the tool's radius")
                     : own_radius ? "scales with the cube of the tooth pitch"
                                  : "scales with the cube of the tooth pitch over the tool's radius";
  return fmt::format("ignores {} and {}: it can't be used to compare {}",
                     line.empty() ? "the blade's thickness" : "tooth_width_mm", rest,
                     line.empty() ? "blades" : "tools");
}

double FindMaxValidBite(const ForceLaw& law, const Tool& tool) {
  if (law.table() != nullptr) return FindDataBites(law).second;
  const double default_mm = law.info().validity.to_mm;
  if (std::string_view(law.name()) != "hertz_chip") return default_mm;
  double low_mm = kMinMeasuredBite_mm;
  double high_mm = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    (CalcThrustFactor(law, tool, middle_mm) > kMaxThrustFactor ? high_mm : low_mm) = middle_mm;
  }
  return low_mm;
}

double FindMinValidBite(const ForceLaw& law) {
  return law.table() != nullptr ? FindDataBites(law).first : law.info().validity.from_mm;
}

}  // namespace kerf
