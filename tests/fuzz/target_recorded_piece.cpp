#include "session/run/recorded_piece.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(recorded_piece) {
  static const Bone bone;
  PieceJob job;
  if (!Takes([&] { job = DecodePiece(bytes, bone); })) return;
  const std::string once = EncodePiece(job);
  if (EncodePiece(DecodePiece(once, bone)) != once) Finding("reading and writing changed it");
}

}  // namespace kerf::fuzz
