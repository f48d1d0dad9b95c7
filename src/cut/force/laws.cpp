#include "cut/force/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <utility>

#include "base/core/heap_guard.h"
#include "base/core/new_name.h"
#include "kerf/error.h"

namespace kerf {

namespace {

std::vector<const ForceLawInfo*>& AllLaws() {
#define KERF_LAW_ADDRESS(function) &function(),
  static std::vector<const ForceLawInfo*> laws{KERF_FORCE_LAWS(KERF_LAW_ADDRESS)};
#undef KERF_LAW_ADDRESS
  return laws;
}

/// Returns the first rule of ToothForce that the law breaks when it cuts `cut` with growing bites.
std::string FindForceFault(const ToothForce& law, const ToothCut& cut) {
  double last_N = 0;
  for (double bite_mm = 1e-9; bite_mm <= 1000; bite_mm *= 1.25) {
    const double thrust_N = law(bite_mm, cut);
    const double cutting_N = law.HasCutting() ? law.Cutting(bite_mm, cut) : 0;
    for (const double N : {thrust_N, cutting_N}) {
      if (std::isfinite(N) && N >= 0) continue;
      return fmt::format("its force is {:g} N at a bite of {:g} mm; it must be finite and 0 or more", N, bite_mm);
    }
    if (thrust_N < last_N) {
      return fmt::format("its thrust falls by {:.3g} N, from {:g} N, as the bite grows to {:g} mm", last_N - thrust_N,
                         last_N, bite_mm);
    }
    last_N = thrust_N;
    if (law(bite_mm, cut) != thrust_N || (law.HasCutting() && law.Cutting(bite_mm, cut) != cutting_N)) {
      return fmt::format("the same bite of {:g} mm gives two different forces", bite_mm);
    }
    if (law(bite_mm, {}) != 0 || (law.HasCutting() && law.Cutting(bite_mm, {}) != 0)) {
      return "its force is not 0 where there is no material";
    }
  }
  return {};
}

/// Scenes have the parameters as keys beside `law`, `file` and the rows of a table.
std::string FindKeyFault(const std::vector<LawParameter>& parameters, std::size_t i) {
  const std::string_view key = parameters[i].key;
  const bool plain = std::ranges::all_of(key, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (key.empty() || !plain) {
    return fmt::format("the name of its parameter \"{}\" must have letters, digits and _ only", key);
  }
  if (key == "law" || key == "file" || key == "row") return fmt::format("no parameter can have the name {}", key);
  for (std::size_t k = 0; k < i; ++k) {
    if (parameters[k].key == key) return fmt::format("it has two parameters {}", key);
  }
  return {};
}

}  // namespace

const std::vector<const ForceLawInfo*>& ForceLaws() {
  return AllLaws();
}

std::string FindLawFault(const ForceLawInfo& info) {
  if (info.make == nullptr) return "it has no function that makes it";
  if (info.parameters.size() > LawValues{}.size()) {
    return fmt::format("it has {} parameters; at most {} are possible", info.parameters.size(), LawValues{}.size());
  }
  std::vector<LawValues> settings(1);
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const LawParameter& p = info.parameters[i];
    if (std::string fault = FindKeyFault(info.parameters, i); !fault.empty()) return fault;
    if (!(p.lower <= p.default_value && p.default_value <= p.upper)) {
      return fmt::format("the default of its parameter {} is not within the range", p.key);
    }
    settings[0][i] = p.default_value;
  }
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    for (const double end : {info.parameters[i].lower, info.parameters[i].upper}) {
      settings.push_back(settings[0]);
      settings.back()[i] = end;
    }
  }
  const std::shared_ptr<const ForceTable> table = info.has_table ? DefaultForceTable() : nullptr;
  for (const LawValues& values : settings) {
    const ToothForce law = info.make(values, CalcTooth(DiscSaw{}), table);
    if (law.thrust == nullptr) return "it has no thrust";
    if (law.HasCutting() != info.has_cutting)
      return "it states a cutting force only in its description or only in fact";
    for (int tissue = 0; tissue < kTissueCount; ++tissue) {
      if (table && !table->Has(static_cast<Tissue>(tissue))) continue;
      for (const double E_MPa : {1.0, 1e3, 2e4}) {
        for (const double speed_mm_per_s : {0.0, 1e4}) {
          const ToothCut cut = MakeToothCut(E_MPa, E_MPa, static_cast<Tissue>(tissue), speed_mm_per_s);
          const auto find = [&] {
            const HeapGuard guard;  // the tick calls the law
            return std::array{law(0.01, cut), law.HasCutting() ? law.Cutting(0.01, cut) : 0};
          };
          find();
          if (std::string fault = FindForceFault(law, cut); !fault.empty()) return fault;
        }
      }
    }
  }
  return {};
}

void RegisterForceLaw(ForceLawInfo info) {
  CheckNewName("force law", info.name, [](std::string_view name) {
    return std::ranges::any_of(AllLaws(), [&](const ForceLawInfo* law) { return law->name == name; });
  });
  if (const std::string fault = FindLawFault(info); !fault.empty()) {
    throw Error(fmt::format("the force law {} cannot be used: {}", info.name, fault));
  }
  static std::deque<ForceLawInfo> registered;
  AllLaws().push_back(&registered.emplace_back(std::move(info)));
}

ToothCut MakeToothCut(double E_MPa, double E_star_MPa, Tissue tissue, double speed_mm_per_s) {
  ToothCut cut{.E_star_MPa = E_star_MPa, .E_MPa = E_MPa, .speed_mm_per_s = speed_mm_per_s};
  cut.tissue[static_cast<std::size_t>(CutTissue(tissue))] = 1;
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
  std::vector<std::string_view> keys;
  for (const LawParameter& p : info_->parameters) keys.emplace_back(p.key);
  throw Error(fmt::format("the force law {} has no parameter {}; {}", info_->name, key,
                          keys.empty() ? "it has none" : fmt::format("it has {}", fmt::join(keys, ", "))));
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

bool IsOwnLaw(const ForceLaw& law) {
#define KERF_LAW_ADDRESS(function) &function(),
  const std::initializer_list<const ForceLawInfo*> of_kerf{KERF_FORCE_LAWS(KERF_LAW_ADDRESS)};
#undef KERF_LAW_ADDRESS
  return std::find(of_kerf.begin(), of_kerf.end(), &law.info()) == of_kerf.end();
}

bool LacksTissue(const ForceLaw& law) {
  return law.table() != nullptr &&
         std::ranges::any_of(law.table()->rows(), [](const auto& rows) { return rows.empty(); });
}

void CheckTissues(const ForceLaw& law, const MaterialTable& materials) {
  if (law.table() == nullptr) return;
  for (const auto& [id, region] : materials.regions()) {
    if (region.tissue == Tissue::kMetal || law.table()->Has(CutTissue(region.tissue))) continue;
    throw Error(fmt::format("the table of the force law {} has no rows for {} (region {})", law.name(),
                            ToString(region.tissue), id));
  }
}

}  // namespace kerf
