#include "kerf/material.h"

#include <fmt/format.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kRigidE_MPa = 1e9;  // rigid for any tool; above this, the sum of the compliances loses precision

/// Throws kerf::Error unless the interval of E is absent or contains E.
void CheckInterval(const Region& region) {
  const double lower = region.E_lower_MPa;
  const double upper = region.E_upper_MPa;
  if (lower == 0 && upper == 0) return;
  if (!(lower > 0 && lower <= region.E_MPa && region.E_MPa <= upper && upper <= kRigidE_MPa)) {  // also rejects NaN
    throw Error(
        fmt::format("region {}: E = {} GPa must lie in its interval, {} to {} GPa, which must begin above 0 and "
                    "end at most at {}",
                    region.id, region.E_MPa / 1000, lower / 1000, upper / 1000, kRigidE_MPa / 1000));
  }
}

}  // namespace

const char* ToString(Tissue tissue) {
  switch (tissue) {
    case Tissue::kCortical:
      return "cortical";
    case Tissue::kCancellous:
      return "cancellous";
    case Tissue::kTooth:
      return "tooth";
    case Tissue::kCanal:
      return "canal";
    case Tissue::kOther:
      break;
    case Tissue::kMetal:
      return "metal";
    case Tissue::kLesion:
      return "lesion";
  }
  return "other";
}

std::optional<Tissue> TissueFromString(const std::string& name) {
  for (const Tissue tissue : {Tissue::kCortical, Tissue::kCancellous, Tissue::kTooth, Tissue::kCanal, Tissue::kOther,
                              Tissue::kMetal, Tissue::kLesion}) {
    if (name == ToString(tissue)) return tissue;
  }
  return std::nullopt;
}

void MaterialTable::Add(Region region) {
  CheckRange("id", region.id, kRegionRange, "region");
  if (!(region.E_MPa > 0 && region.E_MPa <= kRigidE_MPa)) {  // also rejects NaN
    throw Error(fmt::format("region {}: E = {} GPa must be above 0 and at most {}", region.id, region.E_MPa / 1000,
                            kRigidE_MPa / 1000));
  }
  CheckInterval(region);
  CheckRange("nu", region.nu, kPoissonRatioRange, fmt::format("region {}", region.id));
  if (Contains(region.id)) throw Error(fmt::format("region {} is given twice", region.id));
  const int id = region.id;
  regions_.emplace(id, std::move(region));
}

const Region& MaterialTable::At(int id) const {
  const auto it = regions_.find(id);
  if (it == regions_.end()) throw Error(fmt::format("the region table has no region {}", id));
  return it->second;
}

void MaterialTable::SetOsteonDirection(const Vec3& direction_W) {
  const double length = glm::length(direction_W);
  if (!(length >= 1e-6 && std::isfinite(length))) {  // also rejects NaN
    throw Error("the direction of the osteons must be finite and at least 1e-6 long");
  }
  osteon_direction_ = direction_W / length;
}

MaterialTable MakeUniformTable(const MaterialTable& table, double E_MPa, double nu) {
  MaterialTable uniform;
  for (const auto& [id, region] : table.regions()) {
    Region same = region;
    same.E_MPa = E_MPa;
    same.nu = nu;
    same.E_lower_MPa = 0;
    same.E_upper_MPa = 0;
    same.estimate = true;
    same.source = "Uniform: the same for all regions";
    uniform.Add(std::move(same));
  }
  return uniform;
}

double CalcReducedModulus(double E1_MPa, double nu1, double E2_MPa, double nu2) {
  return 1 / ((1 - nu1 * nu1) / E1_MPa + (1 - nu2 * nu2) / E2_MPa);
}

}  // namespace kerf
