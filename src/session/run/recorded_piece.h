// A piece of bone that was going to leave, as a recording keeps it: which voxels change, and to what.
#pragma once

#include <string>
#include <string_view>

#include "kerf/bone.h"
#include "session/run/pieces_out.h"

namespace kerf {

/// Without what was there before: of a bone that is the same, that is known.
std::string EncodePiece(const PieceJob& job);
/// `bone`: as it was when the piece was going to leave. Without the piece as a bone of its own. Throws Error for bytes
/// that are none.
PieceJob DecodePiece(std::string_view bytes, const Bone& bone);

}  // namespace kerf
