#include "bone/material/segment_regions.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "bone/material/region_table.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::string_view kToothName = "tooth ";

/// Adds the region if the table lacks it, and checks that a region with its id is the same.
void AddRegion(const Region& region, const std::string& table_name, MaterialTable& table) {
  if (!table.Contains(region.id)) {
    table.Add(region);
    return;
  }
  const Region& known = table.At(region.id);
  if (known.tissue == region.tissue && FindToothNumber(known) == FindToothNumber(region)) return;
  throw Error(fmt::format("{}: region {} is '{}', but an import with this mask needs it for '{}'", table_name,
                          region.id, known.name, region.name));
}

}  // namespace

int FindToothNumber(const Region& region) {
  if (region.tissue != Tissue::kTooth || !region.name.starts_with(kToothName)) return 0;
  int fdi = 0;
  const char* const end = region.name.data() + region.name.size();
  const auto [at, fault] = std::from_chars(region.name.data() + kToothName.size(), end, fdi);
  return fault == std::errc() && at == end && IsToothNumber(fdi) ? fdi : 0;
}

void AddTooth(int fdi, const std::string& name, MaterialTable& table) {
  Region tooth = table.At(kToothRegion);
  tooth.id = ToothRegion(fdi);
  tooth.name = fmt::format("{}{}", kToothName, fdi);
  AddRegion(tooth, name, table);
}

void AddMetal(const std::string& name, MaterialTable& table) {
  AddRegion(
      {.id = kMetalRegion,
       .name = "metal",
       .tissue = Tissue::kMetal,
       .E_MPa = 110'000,
       .nu = 0.34,
       .source = "Estimate: handbook value of the alloy Ti-6Al-4V; a segmentation does not say which metal it is"},
      name, table);
}

void AddLesion(const std::string& name, MaterialTable& table) {
  Region lesion = DefaultMandibleTable().At(kCanalRegion);
  lesion.id = kLesionRegion;
  lesion.name = "lesion";
  lesion.tissue = Tissue::kLesion;
  lesion.source = "Estimate: that of the mandibular canal; no figure for a lesion was found, and lesions differ";
  AddRegion(lesion, name, table);
}

}  // namespace kerf
