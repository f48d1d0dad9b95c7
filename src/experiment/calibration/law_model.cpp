// The only file of this folder that depends on the laws of src/cut/force.
#include "experiment/calibration/law_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/core/nearest_name.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "kerf/force.h"

namespace kerf {
namespace {

constexpr const char* kTwoComponent = "two_component";
constexpr const char* kEdgePlusChip = "edge_plus_chip";

/// Radius of an edge that can be set.
constexpr Range kEdgeRadius_um{0.1, 1000};

LinearLaw MakeTwoComponent() {
  LinearLaw law{kTwoComponent, {}, {}};
  for (const LawParameter& p : ForceLaw(kTwoComponent).info().parameters) {
    const std::string key = p.key;
    const Range range{p.lower, p.upper};
    if (key.ends_with("_N_per_mm") || key.ends_with("_N_per_mm2")) {
      law.coefficients.push_back({key, key.starts_with("thrust") ? ForceComponent::kThrust : ForceComponent::kCutting,
                                  key.ends_with("_mm2") ? ForceTerm::kChip : ForceTerm::kEdge, p.default_value, range});
    } else if (key == "crossover_share") {
      law.fixed.push_back({key, p.default_value, range, false});
    }
  }
  law.fixed.push_back({"edge_radius_um", DiscSaw{}.edge_radius_um, kEdgeRadius_um, true});
  return law;
}

LinearLaw MakeEdgePlusChip() {
  LinearLaw law{kEdgePlusChip, {}, {}};
  for (const LawParameter& p : ForceLaw(kEdgePlusChip).info().parameters) {
    const std::string key = p.key;
    const Range range{p.lower, p.upper};
    if (key.starts_with("edge_")) {
      law.coefficients.push_back({key, ForceComponent::kThrust, ForceTerm::kEdge, p.default_value, range});
    } else if (key.starts_with("chip_")) {
      law.coefficients.push_back({key, ForceComponent::kThrust, ForceTerm::kChip, p.default_value, range});
    } else if (key == "reference_E_star_MPa") {
      law.fixed.push_back({key, p.default_value, range, false});
    }
  }
  return law;
}

const FixedParameter* FindFixed(const LinearLaw& law, std::string_view key) {
  const auto found =
      std::find_if(law.fixed.begin(), law.fixed.end(), [&](const FixedParameter& p) { return p.key == key; });
  return found == law.fixed.end() ? nullptr : &*found;
}

}  // namespace

std::string_view ToString(ForceComponent component) {
  return component == ForceComponent::kThrust ? "thrust" : "cutting force";
}

bool LinearLaw::Has(ForceComponent component) const {
  return std::any_of(coefficients.begin(), coefficients.end(),
                     [&](const Coefficient& c) { return c.component == component; });
}

bool LinearLaw::HasCrossover() const {
  return FindFixed(*this, "crossover_share") != nullptr;
}

double LinearLaw::Get(std::string_view key) const {
  const FixedParameter* found = FindFixed(*this, key);
  if (found == nullptr) throw Error(fmt::format("{} has no fixed parameter {}", name, key));
  return found->value;
}

void LinearLaw::Set(const std::string& key, double value) {
  std::vector<std::string> names;
  for (FixedParameter& p : fixed) {
    names.push_back(p.key);
    if (p.key != key) continue;
    CheckRange(key, value, p.range);
    p.value = value;
    return;
  }
  for (const Coefficient& c : coefficients) {
    if (c.key == key) throw Error(fmt::format("{} is fitted and can't be set; {} can", key, fmt::join(names, ", ")));
  }
  const std::string nearest = FindNearestName(key, names);
  throw Error(fmt::format("{} has no parameter \"{}\"; {}", name, key,
                          nearest.empty() ? fmt::format("{} can be set", fmt::join(names, ", "))
                                          : fmt::format("did you mean \"{}\"?", nearest)));
}

double LinearLaw::CrossoverBite(double crossover_share) const {
  return HasCrossover() ? 1e-3 * crossover_share * Get("edge_radius_um") : 0;
}

const std::vector<std::string>& ListLinearLaws() {
  static const std::vector<std::string> kNames{kTwoComponent, kEdgePlusChip};
  return kNames;
}

LinearLaw MakeLinearLaw(const std::string& name) {
  if (name == kTwoComponent) return MakeTwoComponent();
  if (name == kEdgePlusChip) return MakeEdgePlusChip();
  throw Error(fmt::format("the law \"{}\" can't be calibrated; {} can", name, fmt::join(ListLinearLaws(), " and ")));
}

double CalcTerm(ForceTerm term, double bite_mm, double crossover_mm) {
  if (term == ForceTerm::kChip) return bite_mm;
  return bite_mm < crossover_mm ? bite_mm / crossover_mm : 1;
}

double CalcThrustOfLaw(const LinearLaw& law, const std::vector<double>& coefficients, double bite_mm, double width_mm) {
  ForceLaw own(law.name);
  for (std::size_t i = 0; i < coefficients.size(); ++i) own.Set(law.coefficients[i].key, coefficients[i]);
  DiscSaw saw;
  saw.thickness_mm = width_mm;
  if (law.HasCrossover()) saw.edge_radius_um = law.Get("edge_radius_um");
  ToothCut cut = MakeMeasuredBone(saw);
  for (const FixedParameter& p : law.fixed) {
    if (!p.of_tool) own.Set(p.key, p.value);
    if (p.key == "reference_E_star_MPa") cut.E_star_MPa = p.value;
  }
  return MakeToothForce(own, saw)(bite_mm, cut);
}

}  // namespace kerf
