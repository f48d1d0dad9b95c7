#include "session/run/recorded_piece.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(recorded_piece) {
  // Never destroyed: TBB's table of a tree's accessors then casts the mark of an unused bucket to a pointer, which the
  // sanitizer reports as misaligned.
  static const Bone& bone = *new Bone;
  PieceJob job;
  if (!Accepts([&] { job = DecodePiece(bytes, bone); })) return;
  const std::string once = EncodePiece(job);
  if (EncodePiece(DecodePiece(once, bone)) != once) Finding("a piece changes when it is read and written");
}

}  // namespace kerf::fuzz
