#include "bone/material/region_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "base/core/csv.h"
#include "kerf/error.h"
#include "mandible_regions_csv.h"

namespace kerf {
namespace {

enum RegionColumn {
  kRegionId,
  kRegionName,
  kRegionTissue,
  kRegionE,
  kRegionNu,
  kRegionEstimate,
  kRegionSource,
  kRegionLower,
  kRegionUpper
};
const std::vector<std::string> kRegionColumns = {"id", "name", "tissue", "E_GPa", "nu", "estimate", "source"};
const std::vector<std::string> kIntervalColumns = {"E_lower_GPa", "E_upper_GPa"};

/// Parses the interval of E, which may be missing.
void ParseInterval(const std::string& lower, const std::string& upper, const CsvPlace& place, Region& region) {
  if (lower.empty() && upper.empty()) return;
  if (lower.empty() || upper.empty()) {
    place.Fail(fmt::format("region {}: give both E_lower_GPa and E_upper_GPa, or neither", region.id));
  }
  region.E_lower_MPa = ParseCsvNumber(lower, 3, "E_lower_GPa", place);
  region.E_upper_MPa = ParseCsvNumber(upper, 3, "E_upper_GPa", place);
  if (!(region.E_lower_MPa > 0)) place.Fail(fmt::format("region {}: E_lower_GPa must be above 0", region.id));
  if (!(region.E_upper_MPa <= kMaxTableE_MPa)) {
    place.Fail(fmt::format("region {}: E_upper_GPa must be at most {}", region.id, kMaxTableE_MPa / 1000));
  }
}

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
    place.Fail(fmt::format("tissue = {} is not one of cortical, cancellous, tooth, canal, other, metal, lesion",
                           Quote(field(kRegionTissue))));
  }
  region.tissue = *tissue;
  region.E_MPa = ParseCsvNumber(field(kRegionE), 3, "E_GPa", place);
  if (!(region.E_MPa > 0 && region.E_MPa <= kMaxTableE_MPa)) {
    place.Fail(fmt::format("region {}: E = {} GPa must be above 0 and at most {}", region.id, region.E_MPa / 1000,
                           kMaxTableE_MPa / 1000));
  }
  ParseInterval(field(kRegionLower), field(kRegionUpper), place, region);
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
  const auto add = [&table](const std::vector<std::string>& fields, const CsvPlace& place) {
    Region region = ParseRegionRow(fields, place);
    try {
      table.Add(std::move(region));
    } catch (const Error& e) {
      place.Fail(e.what());
    }
  };
  ReadCsv(text, file, kRegionColumns, add, kIntervalColumns);
  if (table.empty()) throw Error(fmt::format("{}: no region below the header", file));
  return table;
}

std::string FormatRegionTable(const MaterialTable& table) {
  const auto& regions = table.regions();
  // A table without intervals is written as before, so that earlier versions of kerf can read it.
  const bool intervals =
      std::any_of(regions.begin(), regions.end(), [](const auto& entry) { return entry.second.E_lower_MPa > 0; });
  std::string text = fmt::format("{}", fmt::join(kRegionColumns, ","));
  if (intervals) text += fmt::format(",{}", fmt::join(kIntervalColumns, ","));
  text += '\n';
  for (const auto& [id, region] : regions) {
    text += fmt::format("{},{},{},{},{},{},{}", id, FormatCsvField(region.name), ToString(region.tissue),
                        FormatCsvNumber(region.E_MPa, 3), region.nu, region.estimate ? "yes" : "no",
                        FormatCsvField(region.source));
    if (intervals && region.E_lower_MPa > 0) {
      text += fmt::format(",{},{}", FormatCsvNumber(region.E_lower_MPa, 3), FormatCsvNumber(region.E_upper_MPa, 3));
    } else if (intervals) {
      text += ",,";
    }
    text += '\n';
  }
  return text;
}

const MaterialTable& DefaultMandibleTable() {
  static const MaterialTable table = ParseRegionTable(kMandibleRegionsCsv, "volumes/mandible_regions.csv");
  return table;
}

}  // namespace kerf
