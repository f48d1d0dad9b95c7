#include "bone/material/region_table.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <vector>

#include "base/core/csv.h"
#include "kerf/error.h"
#include "mandible_regions_csv.h"

namespace kerf {
namespace {

enum RegionColumn { kRegionId, kRegionName, kRegionTissue, kRegionE, kRegionNu, kRegionEstimate, kRegionSource };
const std::vector<std::string> kRegionColumns = {"id", "name", "tissue", "E_GPa", "nu", "estimate", "source"};

Region ParseRegionRow(const std::vector<std::string>& fields, const CsvPlace& place) {
  const auto field = [&](RegionColumn c) -> const std::string& { return fields[c]; };
  Region region;
  const std::string& id = field(kRegionId);
  const auto [end, code] = std::from_chars(id.data(), id.data() + id.size(), region.id);
  if (code != std::errc() || end != id.data() + id.size()) {
    place.Fail(fmt::format("id = {} is not a whole number from {}", Quote(id), ShowRange(kRegionRange, "")));
  }
  region.name = field(kRegionName);
  if (region.name.empty()) place.Fail("name is empty");
  const std::optional<Tissue> tissue = TissueFromString(field(kRegionTissue));
  if (!tissue) {
    place.Fail(fmt::format("tissue = {} is not one of cortical, cancellous, tooth, canal, other",
                           Quote(field(kRegionTissue))));
  }
  region.tissue = *tissue;
  region.E_MPa = ParseCsvNumber(field(kRegionE), 3, "E_GPa", place);
  if (!(region.E_MPa > 0 && region.E_MPa <= kMaxTableE_MPa)) {
    place.Fail(fmt::format("region {}: E = {} GPa must be above 0 and at most {}", region.id, region.E_MPa / 1000,
                           kMaxTableE_MPa / 1000));
  }
  region.nu = ParseCsvNumber(field(kRegionNu), 0, "nu", place);
  const std::string& estimate = field(kRegionEstimate);
  if (estimate != "yes" && estimate != "no") {
    place.Fail(fmt::format("estimate = {} is neither yes nor no", Quote(estimate)));
  }
  region.estimate = estimate == "yes";
  region.source = field(kRegionSource);
  if (region.source.empty()) place.Fail("source is empty; state where the numbers come from");
  return region;
}

}  // namespace

MaterialTable ParseRegionTable(const std::string& text, const std::string& file) {
  MaterialTable table;
  ReadCsv(text, file, kRegionColumns, [&table](const std::vector<std::string>& fields, const CsvPlace& place) {
    Region region = ParseRegionRow(fields, place);
    try {
      table.Add(std::move(region));
    } catch (const Error& e) {
      place.Fail(e.what());
    }
  });
  if (table.empty()) throw Error(fmt::format("{}: no region below the header", file));
  return table;
}

std::string FormatRegionTable(const MaterialTable& table) {
  std::string text = fmt::format("{}\n", fmt::join(kRegionColumns, ","));
  for (const auto& [id, region] : table.regions()) {
    text += fmt::format("{},{},{},{},{},{},{}\n", id, FormatCsvField(region.name), ToString(region.tissue),
                        FormatCsvNumber(region.E_MPa, 3), region.nu, region.estimate ? "yes" : "no",
                        FormatCsvField(region.source));
  }
  return text;
}

const MaterialTable& DefaultMandibleTable() {
  static const MaterialTable table = ParseRegionTable(kMandibleRegionsCsv, "volumes/mandible_regions.csv");
  return table;
}

}  // namespace kerf
