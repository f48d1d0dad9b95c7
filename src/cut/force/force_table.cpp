#include <fmt/format.h>

#include <algorithm>

#include "base/core/csv.h"
#include "cut/force/laws.h"
#include "force_table_csv.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMaxBite_um = 1000;
constexpr double kMaxForce_N_per_mm = 1e6;
constexpr double kMinStep = 1.01;  // ratio of two bites; the last segment is extended, so it must not be too short

double ParseWithin(const std::string& text, const char* name, double lower, double upper, const CsvPlace& place) {
  const double value = ParseCsvNumber(text, 0, name, place);
  if (!(value >= lower && value <= upper))
    place.Fail(fmt::format("{} = {} must be {} to {}", name, value, lower, upper));
  return value;
}

}  // namespace

ForceTable ParseForceTable(const std::string& text, const std::string& name) {
  ForceTable table;
  ReadCsv(text, name, kForceTableColumns, [&](const std::vector<std::string>& fields, const CsvPlace& place) {
    const std::optional<Tissue> tissue = TissueFromString(fields[0]);
    if (!tissue) {
      place.Fail(fmt::format("there is no tissue {}; there are cortical, cancellous, tooth, canal and other",
                             Quote(fields[0])));
    }
    std::vector<ForceTable::Row>& rows = table.rows[static_cast<std::size_t>(*tissue)];
    ForceTable::Row row{};
    row.bite_mm = 1e-3 * ParseWithin(fields[1], "bite_um", 1e-3, kMaxBite_um, place);
    row.thrust_N_per_mm = ParseWithin(fields[2], "thrust_N_per_mm", 0, kMaxForce_N_per_mm, place);
    row.cutting_N_per_mm = ParseWithin(fields[3], "cutting_N_per_mm", 0, kMaxForce_N_per_mm, place);
    if (!rows.empty() && !(row.bite_mm >= kMinStep * rows.back().bite_mm)) {
      place.Fail(fmt::format("the bites of {} must increase from row to row, by at least 1 %", fields[0]));
    }
    if (!rows.empty() && row.thrust_N_per_mm < rows.back().thrust_N_per_mm) {
      place.Fail(
          fmt::format("the thrust in {} falls as the bite grows; a tool in a hand would have no unique "
                      "motion",
                      fields[0]));
    }
    if (fields[4].empty()) place.Fail("the source is missing");
    rows.push_back(row);
    if (std::find(table.sources.begin(), table.sources.end(), fields[4]) == table.sources.end()) {
      table.sources.push_back(fields[4]);
    }
  });
  if (table.sources.empty()) throw Error(fmt::format("{} has no rows", name));
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].size() == 1) {
      throw Error(
          fmt::format("{} has one row for {}; at least two bites are needed", name, ToString(static_cast<Tissue>(i))));
    }
  }
  return table;
}

const std::shared_ptr<const ForceTable>& DefaultForceTable() {
  static const std::shared_ptr<const ForceTable> kTable =
      std::make_shared<const ForceTable>(ParseForceTable(kForceTableCsv, "volumes/force_table.csv"));
  return kTable;
}

}  // namespace kerf
