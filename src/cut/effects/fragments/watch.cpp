#include "cut/effects/fragments/watch.h"

namespace kerf {

std::size_t FragmentWatch::Look(double time_s) {
  const FoundPieces& found = finder_.Find();
  for (const FoundPiece& piece : found.came_off) {
    ++event_count_;
    if (events_.size() >= kMaxEvents) continue;
    events_.push_back({time_s, piece, static_cast<int>(found.pieces.size()), finder_.FindMainRegion(piece.id)});
  }
  return found.came_off.size();
}

std::size_t FragmentWatch::CalcMemoryBytes() const {
  return sizeof(*this) + finder_.CalcMemoryBytes() + events_.capacity() * sizeof(FragmentEvent);
}

}  // namespace kerf
