// Drawn surfaces of pieces: coarser than measured where the bone was not cut, with the tissues on the cut faces. Pure.
#pragma once

#include <cstddef>
#include <vector>

#include "kerf/bone.h"
#include "view/picture/colours.h"

namespace kerf {

/// Colour of a piece's original surface: muted, and distinguishable from those of the other pieces and from cut faces
/// with any colour vision. `piece`: index from 0; the colours repeat after kPieceColours pieces.
Rgb8 PieceColour(int piece);
inline constexpr int kPieceColours = 6;

struct PieceMesh {
  TriangleMesh mesh_P;
  std::vector<Rgb8> colours;  // one for each point
};

/// Makes the drawn surface of a piece. A point is on a cut face if it lies more than half a voxel below the surface of
/// `start`, the bone before it was cut; it then has the colour of its tissue, as on the bone (CutColour()). Uncut
/// points have the colour `uncut`, and teeth their own. If the mesh has more than `max_triangles`, the points of uncut
/// bone are merged within cells of growing size; cut faces are not changed. Uses several threads.
PieceMesh MakePieceMesh(const Bone& start, const TriangleMesh& mesh_P, const Rgb8& uncut, std::size_t max_triangles);

}  // namespace kerf
