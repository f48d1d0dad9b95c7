#include "cut/force/laws.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

const std::vector<const ForceLawInfo*>& ForceLaws() {
#define KERF_LAW_ADDRESS(function) &function(),
  static const std::vector<const ForceLawInfo*> kLaws{KERF_FORCE_LAWS(KERF_LAW_ADDRESS)};
#undef KERF_LAW_ADDRESS
  return kLaws;
}

double ToothForce::operator()(double bite_mm, double E_star_MPa) const {
  return bite_mm > 0 ? law(coefficients, bite_mm, E_star_MPa) : 0;
}

ForceLaw::ForceLaw() : ForceLaw(ForceLaws().front()->name) {}

ForceLaw::ForceLaw(std::string_view name) {
  const auto& laws = ForceLaws();
  const auto found = std::find_if(laws.begin(), laws.end(), [&](const ForceLawInfo* law) { return law->name == name; });
  if (found == laws.end()) {
    std::vector<std::string_view> names;
    for (const ForceLawInfo* law : laws) names.emplace_back(law->name);
    throw Error(fmt::format("there is no force law \"{}\"; available: {}", name, fmt::join(names, ", ")));
  }
  info_ = *found;
  for (std::size_t i = 0; i < info_->parameters.size(); ++i) values_[i] = info_->parameters[i].default_value;
}

std::size_t ForceLaw::FindParameter(std::string_view key) const {
  for (std::size_t i = 0; i < info_->parameters.size(); ++i) {
    if (info_->parameters[i].key == key) return i;
  }
  throw Error(fmt::format("the force law {} has no parameter {}", info_->name, key));
}

ToothForce MakeToothForce(const ForceLaw& law, const Tool& tool) {
  const ForceLawInfo& info = law.info();
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const LawParameter& p = info.parameters[i];
    CheckRange(p.key, law.values()[i], {p.lower, p.upper});
  }
  return info.make(law.values(), CalcTooth(tool));
}

}  // namespace kerf
