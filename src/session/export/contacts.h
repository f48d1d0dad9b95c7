// Pairs of pieces: their overlap, gap and facing surfaces.
#pragma once

#include <string>
#include <vector>

#include "session/export/write_export.h"

namespace kerf::export_detail {

struct PairRow {
  std::string a;
  std::string b;
  double overlap_mm3 = 0;
  std::optional<double> gap_mm;  // none if it is larger than the limit
  std::optional<Facing> facing;  // from the side of `a`; none if no surfaces face each other
};
/// Precomputed data for all files of an export.
struct Prepared {
  std::vector<int> pieces;  // indices of the pieces that are not deleted
  std::vector<PairRow> pairs;
};
Prepared Prepare(const ExportInput& input, const ExportOptions& options);

std::string FormatReportHtml(const ExportInput& input, const Prepared& prepared);
std::string FormatMeasuresCsv(const ExportInput& input, const Prepared& prepared);

}  // namespace kerf::export_detail
