#include "cut/force/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kerf/error.h"

namespace kerf {

const std::vector<const ForceLawInfo*>& ForceLaws() {
#define KERF_LAW_ADDRESS(function) &function(),
  static const std::vector<const ForceLawInfo*> kLaws{KERF_FORCE_LAWS(KERF_LAW_ADDRESS)};
#undef KERF_LAW_ADDRESS
  return kLaws;
}

ToothCut MakeToothCut(double E_MPa, double E_star_MPa, Tissue tissue, double speed_mm_per_s) {
  ToothCut cut{.E_star_MPa = E_star_MPa, .E_MPa = E_MPa, .speed_mm_per_s = speed_mm_per_s};
  cut.tissue[static_cast<std::size_t>(tissue)] = 1;
  return cut;
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
  if (info_->has_table) table_ = DefaultForceTable();
}

void ForceLaw::SetTable(std::shared_ptr<const ForceTable> table) {
  if (!info_->has_table) throw Error(fmt::format("the force law {} reads no table", info_->name));
  table_ = std::move(table);
  has_own_table_ = true;
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
  ToothForce force = info.make(law.values(), CalcTooth(tool), law.table());
  // Any tissue may be the one with a force at a bite of 0.
  constexpr double kE_MPa = 1e4;
  for (int i = 0; i < kTissueCount; ++i) {
    force.jumps |= force.thrust(force, 0, MakeToothCut(kE_MPa, kE_MPa, static_cast<Tissue>(i))) > 0;
  }
  return force;
}

bool LacksTissue(const ForceLaw& law) {
  return law.table() != nullptr &&
         std::ranges::any_of(law.table()->rows(), [](const auto& rows) { return rows.empty(); });
}

void CheckTissues(const ForceLaw& law, const MaterialTable& materials) {
  if (law.table() == nullptr) return;
  for (const auto& [id, region] : materials.regions()) {
    if (law.table()->Has(region.tissue)) continue;
    throw Error(fmt::format("the table of the force law {} has no rows for {} (region {})", law.name(),
                            ToString(region.tissue), id));
  }
}

}  // namespace kerf
