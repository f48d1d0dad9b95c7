// Each pair of pieces once: what they have in common and between them.
#pragma once

#include <string>
#include <vector>

#include "session/export/take_away.h"

namespace kerf::takeaway {

struct PairRow {
  std::string a;
  std::string b;
  double overlap_mm3 = 0;
  std::optional<double> gap_mm;  // none beyond the limit
  std::optional<Facing> facing;  // of a's surface; none where none faces
};
/// All that is written of a session, worked out once.
struct Prepared {
  std::vector<int> pieces;  // not deleted
  std::vector<PairRow> pairs;
};
Prepared Prepare(const TakeAway& taken, const TakeAwayOptions& options);

std::string FormatReportHtml(const TakeAway& taken, const Prepared& prepared);
std::string FormatMeasuresCsv(const TakeAway& taken, const Prepared& prepared);

}  // namespace kerf::takeaway
