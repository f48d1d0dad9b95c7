#include <fmt/format.h>

#include "base/core/csv.h"
#include "cut/force/laws.h"
#include "force_table_csv.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMinStep = 1.01;  // ratio of two bites; the last segment is extended, so it must not be too short

}  // namespace

void ForceTable::Add(const ForceLawRow& row) {
  CheckParameters(row);
  const std::optional<Tissue> tissue = TissueFromString(row.tissue);
  if (!tissue) throw Error(fmt::format("there is no tissue {}", Quote(row.tissue)));
  if (row.source.empty()) throw Error("the source is empty; state where the numbers come from");
  if (row.source.size() > kForceSourceLimit.characters) {
    throw Error(fmt::format("the source has {} characters; at most {} are allowed", row.source.size(),
                            kForceSourceLimit.characters));
  }
  std::vector<Row>& rows = rows_[static_cast<std::size_t>(*tissue)];
  const Row next{row.bite_um, 1e-3 * row.bite_um, row.thrust_N_per_mm, row.cutting_N_per_mm, row.source};
  if (!rows.empty() && !(next.bite_mm >= kMinStep * rows.back().bite_mm)) {
    throw Error(fmt::format("the bites of {} must increase from row to row, by at least 1 %", row.tissue));
  }
  if (!rows.empty() && next.thrust_N_per_mm < rows.back().thrust_N_per_mm) {
    throw Error(fmt::format("the thrust in {} falls as the bite grows; a tool in a hand would have no unique motion",
                            row.tissue));
  }
  rows.push_back(next);
}

void ForceTable::CheckComplete() const {
  bool any = false;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    any = any || !rows_[i].empty();
    if (rows_[i].size() == 1) {
      throw Error(
          fmt::format("there is one row for {}; at least two bites are needed", ToString(static_cast<Tissue>(i))));
    }
  }
  if (!any) throw Error("there are no rows");
}

std::vector<ForceLawRow> ForceTable::ListRows() const {
  std::vector<ForceLawRow> list;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    for (const Row& row : rows_[i]) {
      list.push_back(
          {ToString(static_cast<Tissue>(i)), row.bite_um, row.thrust_N_per_mm, row.cutting_N_per_mm, row.source});
    }
  }
  return list;
}

ForceTable ParseForceTable(const std::string& text, const std::string& name) {
  ForceTable table;
  ReadCsv(text, name, {"tissue", "bite_um", "thrust_N_per_mm", "cutting_N_per_mm", "source"},
          [&](const std::vector<std::string>& fields, const CsvPlace& place) {
            ForceLawRow row{.tissue = fields[0], .source = fields[4]};
            row.bite_um = ParseCsvNumber(fields[1], 0, "bite_um", place);
            row.thrust_N_per_mm = ParseCsvNumber(fields[2], 0, "thrust_N_per_mm", place);
            row.cutting_N_per_mm = ParseCsvNumber(fields[3], 0, "cutting_N_per_mm", place);
            try {
              table.Add(row);
            } catch (const Error& e) {
              place.Fail(e.what());
            }
          });
  try {
    table.CheckComplete();
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", name, e.what()));
  }
  return table;
}

const std::shared_ptr<const ForceTable>& DefaultForceTable() {
  static const std::shared_ptr<const ForceTable> kTable =
      std::make_shared<const ForceTable>(ParseForceTable(kForceTableCsv, "volumes/force_table.csv"));
  return kTable;
}

}  // namespace kerf
