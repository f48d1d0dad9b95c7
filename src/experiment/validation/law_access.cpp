#include "experiment/validation/law_access.h"

#include <cmath>
#include <string_view>

#include "cut/force/density.h"
#include "cut/force/measured.h"
#include "kerf/material.h"

namespace kerf {

LawOnTooth::LawOnTooth(const ForceLaw& law, const Tool& tool)
    : force_(MakeToothForce(law, tool)), tool_(tool), modulus_exponent_(kModulusExponent.default_value) {
  for (const LawParameter& parameter : law.info().parameters) {
    if (parameter.key == std::string_view(kModulusExponent.key)) modulus_exponent_ = law.Get(parameter.key);
  }
}

ToothForces LawOnTooth::operator()(const ToothState& state) const {
  ToothCut cut = MakeMeasuredBone(tool_);
  cut.speed_mm_per_s = state.speed_mm_per_s;
  cut.E_MPa = kMeasuredE_MPa * std::pow(state.density, modulus_exponent_);
  cut.E_star_MPa = CalcReducedModulus(CalcModulus(tool_), CalcPoissonRatio(tool_), cut.E_MPa, kMeasuredPoissonRatio);
  return {force_(state.bite_mm, cut), CalcCuttingForce(force_, state.bite_mm, cut)};
}

bool HasCuttingForce(const ForceLaw& law) {
  return law.info().has_cutting;
}

std::vector<std::string> LawNames() {
  std::vector<std::string> names;
  for (const ForceLawInfo* law : ForceLaws()) names.emplace_back(law->name);
  return names;
}

DiscSaw MakeReferenceDisc(double width_mm) {
  DiscSaw disc;
  disc.thickness_mm = width_mm;
  return disc;
}

ForceLaw TransferLaw(const ForceLaw& law, const DiscSaw& from, const Tool& to) {
  ForceLaw transferred = law;
  for (const LawParameter& parameter : law.info().parameters) {
    const std::string_view key = parameter.key;
    if (key == "contact_radius_mm" && !(law.Get(key) > 0)) transferred.Set(key, from.radius_mm());
    if (key == "contact_share_of_pitch") transferred.Set(key, law.Get(key) * from.pitch_mm() / CalcTooth(to).pitch_mm);
  }
  return transferred;
}

}  // namespace kerf
