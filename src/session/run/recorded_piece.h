// A piece of bone to be removed, as stored in a recording: the voxels that change, and their new values.
#pragma once

#include <string>
#include <string_view>

#include "kerf/bone.h"
#include "session/run/pieces_out.h"

namespace kerf {

/// Encodes a piece. The old values are not stored, because the bone of a replay contains them too.
std::string EncodePiece(const PieceJob& job);
/// `bone`: the bone immediately before the piece was removed. The result does not contain the piece as a separate
/// bone. Throws kerf::Error for invalid bytes.
PieceJob DecodePiece(std::string_view bytes, const Bone& bone);

}  // namespace kerf
