#include "bone/pieces/piece_history.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(pieces_file) {
  PieceHistory history;
  history.AddPiece(-1);
  history.AddPiece(-1);
  const std::vector<PieceIdentity> pieces{{.name = "piece 1", .volume_mm3 = 100},
                                          {.name = "piece 2", .volume_mm3 = 50}};
  Accepts([&] { RestorePieces(std::string(bytes), "fuzz.json", pieces, history); });
  for (const PieceState& state : history.now()) {
    if (!IsValid(state.X_WP) || !IsInWorld(state.X_WP.p_AB)) Finding("a piece has an invalid pose");
  }
}

}  // namespace kerf::fuzz
