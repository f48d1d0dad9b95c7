#include "session/export/contacts.h"

namespace kerf::export_detail {

Prepared Prepare(const ExportInput& input, const ExportOptions& options) {
  Prepared out;
  if (input.pieces == nullptr) return out;
  const PieceSet& set = *input.pieces;
  for (int i = 0; i < set.size(); ++i) {
    if (!set.state(i).deleted) out.pieces.push_back(i);
  }
  for (std::size_t k = 0; k < out.pieces.size(); ++k) {
    for (std::size_t m = k + 1; m < out.pieces.size(); ++m) {
      const int a = out.pieces[k];
      const int b = out.pieces[m];
      PairRow row{.a = set.piece(a).name,
                  .b = set.piece(b).name,
                  .overlap_mm3 = set.CalcOverlapWith(a, b),
                  .gap_mm = {},
                  .facing = {}};
      if (row.overlap_mm3 > 0) {
        row.gap_mm = 0;
      } else if (const auto gap = set.CalcGapTo(a, b, options.gap_limit_mm)) {
        row.gap_mm = gap->gap_mm;
      }
      // Overlapping pieces have no facing surfaces.
      if (row.overlap_mm3 <= 0) {
        const Facing facing = set.CalcFacingTo(a, b);
        if (facing.area_mm2 > 0) row.facing = facing;
      }
      out.pairs.push_back(row);
    }
  }
  return out;
}

}  // namespace kerf::export_detail
