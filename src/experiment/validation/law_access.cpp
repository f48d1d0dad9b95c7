#include "experiment/validation/law_access.h"

#include <algorithm>
#include <string_view>

#include "cut/force/measured.h"
#include "kerf/material.h"

namespace kerf {

LawOnTooth::LawOnTooth(const ForceLaw& law, const Tool& tool) : force_(MakeToothForce(law, tool)), tool_(tool) {}

ToothForces LawOnTooth::operator()(const ToothState& state) const {
  const double E_star_MPa = CalcReducedModulus(CalcModulus(tool_), CalcPoissonRatio(tool_),
                                               kMeasuredE_MPa * state.density, kMeasuredPoissonRatio);
  const double thrust_N = force_(state.bite_mm, E_star_MPa);
  return {thrust_N, thrust_N / kThrustPerCuttingForce};
}

bool HasCuttingForce(const ForceLaw&) {
  return false;
}

std::vector<std::string> LawNames() {
  // Sets name these laws, which are not yet in this version.
  std::vector<std::string> names{"two_component", "tabulated"};
  for (const ForceLawInfo* law : ForceLaws()) names.emplace_back(law->name);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

DiscSaw MakeReferenceDisc(double width_mm) {
  DiscSaw disc;
  disc.thickness_mm = width_mm;
  return disc;
}

ForceLaw TransferLaw(const ForceLaw& law, const DiscSaw& from, const DiscSaw& to) {
  ForceLaw transferred = law;
  for (const LawParameter& parameter : law.info().parameters) {
    const std::string_view key = parameter.key;
    if (key == "contact_radius_mm" && !(law.Get(key) > 0)) transferred.Set(key, from.radius_mm());
    if (key == "contact_share_of_pitch") transferred.Set(key, law.Get(key) * from.pitch_mm() / to.pitch_mm());
  }
  return transferred;
}

}  // namespace kerf
