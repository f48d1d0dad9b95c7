// Marks on a bone whose pieces have been moved.
#pragma once

#include <vector>

#include "bone/pieces/piece_set.h"
#include "view/live/overlays.h"

namespace kerf {

struct MovedMarks {
  std::vector<MarkOverlay> marks;
  bool left_out = false;  // a part lies in no piece, and a piece has moved
};

/// Moves each part of a mark with the piece in which, or on which, it lies. A mark in several pieces becomes several
/// marks, of which the first has the label. Without a motion, all marks stay as they are.
MovedMarks MoveMarks(const PieceSet& pieces, const std::vector<MarkOverlay>& marks);

}  // namespace kerf
