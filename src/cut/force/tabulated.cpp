// tabulated: thrust and cutting force of a tooth by linear interpolation in a table of bites, by tissue (ForceTable).
// Both forces are proportional to the tooth's width. The table that comes with kerf is volumes/force_table.csv; a scene
// may name another one ([force] file).
#include <algorithm>
#include <cmath>
#include <limits>

#include "cut/force/laws.h"

namespace kerf {
namespace {

// coefficients: w, mm.

/// Interpolates `force` in the rows, as ForceTable states.
double InterpolateRows(const std::vector<ForceTable::Row>& rows, double ForceTable::Row::*force, double bite_mm) {
  const auto above = std::upper_bound(rows.begin(), rows.end(), bite_mm,
                                      [](double bite, const ForceTable::Row& row) { return bite < row.bite_mm; });
  if (above == rows.begin()) return rows.front().*force * (bite_mm / rows.front().bite_mm);
  const ForceTable::Row& b = above == rows.end() ? rows.back() : *above;
  const ForceTable::Row& a = *(&b - 1);
  return std::max(0.0, a.*force + (b.*force - a.*force) * (bite_mm - a.bite_mm) / (b.bite_mm - a.bite_mm));
}

double SumTissues(const ToothForce& law, double ForceTable::Row::*force, double bite_mm, const ToothCut& cut) {
  double sum_N = 0;
  for (std::size_t i = 0; i < cut.tissue.size(); ++i) {
    const std::vector<ForceTable::Row>& rows = law.table->rows()[i];
    if (cut.tissue[i] > 0 && !rows.empty()) sum_N += cut.tissue[i] * InterpolateRows(rows, force, bite_mm);
  }
  return law.c[0] * sum_N;
}
double CalcTableThrust(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return SumTissues(law, &ForceTable::Row::thrust_N_per_mm, bite_mm, cut);
}
double CalcTableCutting(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return SumTissues(law, &ForceTable::Row::cutting_N_per_mm, bite_mm, cut);
}

/// Returns the smallest ratio of thrust to cutting force, of the forces in the rows and of their changes from row to
/// row.
double FindLeastRatio(const ForceTable& table) {
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double thrust, double cutting) {
    if (cutting != 0) least = std::min(least, std::abs(thrust / cutting));
  };
  for (const std::vector<ForceTable::Row>& rows : table.rows()) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      consider(rows[i].thrust_N_per_mm, rows[i].cutting_N_per_mm);
      if (i == 0) continue;
      consider(rows[i].thrust_N_per_mm - rows[i - 1].thrust_N_per_mm,
               rows[i].cutting_N_per_mm - rows[i - 1].cutting_N_per_mm);
    }
  }
  return least;
}

}  // namespace

const ForceLawInfo& Tabulated() {
  static const ForceLawInfo kLaw{
      .name = "tabulated",
      .summary = "thrust and cutting force from a table of bites by tissue, proportional to the tooth's width",
      .source = "volumes/force_table.csv, or the scene's own table; each row names its source",
      .validity = {0.0025, 0.01, "below that the force falls linearly to 0, an assumption",
                   "beyond that the last two rows are extended"},
      .parameters = {{"scale", 1, 0, 100, "factor on all forces of the table"}},
      .make =
          [](const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>& table) {
            ToothForce law{
                .thrust = CalcTableThrust, .cutting = CalcTableCutting, .table = table, .reads = kReadsTissue};
            law.c[0] = values[0] * tooth.width_mm;
            law.least_thrust_per_cutting = FindLeastRatio(*table);
            return law;
          },
      .has_cutting = true,
      .has_table = true};
  return kLaw;
}

}  // namespace kerf
