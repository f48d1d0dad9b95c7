#include "base/core/describe.h"

#include <array>
#include <utility>

namespace kerf {

std::string_view UnitOfKey(std::string_view key) {
  // Longer endings first.
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 32> kEndings{{
      {"_Nmm_per_rad", "N mm/rad"},
      {"_Ns_per_mm", "N s/mm"},
      {"_mL_per_min_kg", "mL/min/kg"},
      {"_W_per_m2K", "W/m2K"},
      {"_W_per_mK", "W/mK"},
      {"_J_per_kgK", "J/kgK"},
      {"_kg_per_m3", "kg/m3"},
      {"_mg_per_mm3", "mg/mm3"},
      {"_N_per_mm2", "N/mm2"},
      {"_N_per_mm", "N/mm"},
      {"_mm_per_s", "mm/s"},
      {"_N_per_s", "N/s"},
      {"_Nmms", "N mm s"},
      {"_Nmm", "N mm"},
      {"_gmm2", "g mm2"},
      {"_mm3", "mm3"},
      {"_mm2", "mm2"},
      {"_mm", "mm"},
      {"_GPa", "GPa"},
      {"_MPa", "MPa"},
      {"_deg", "degrees"},
      {"_hz", "Hz"},
      {"_Hz", "Hz"},
      {"_um", "um"},
      {"_MB", "MB"},
      {"_px", "pixels"},
      {"_ms", "ms"},
      {"_s", "s"},
      {"_g", "g"},
      {"_N", "N"},
      {"rpm", "rpm"},
  }};
  for (const auto& [ending, unit] : kEndings) {
    if (key.size() >= ending.size() && key.substr(key.size() - ending.size()) == ending) return unit;
  }
  return {};
}

}  // namespace kerf
