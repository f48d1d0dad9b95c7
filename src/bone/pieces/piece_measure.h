// Distances and angles between points of pieces, which move with the pieces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bone/pieces/piece_set.h"

namespace kerf {

/// A point of a piece. It moves with the piece.
struct PiecePoint {
  std::string piece;  // its name
  Vec3 p_P{0};        // in the frame of the piece
};
PiecePoint MakePiecePoint(const PieceSet& pieces, const PiecePick& pick);
/// Returns where the point is now, world frame; none if there is no such piece or it was deleted.
std::optional<Vec3> CalcPlace(const PieceSet& pieces, const PiecePoint& point);

/// A measurement at the current places of its points.
struct PieceMeasure {
  std::vector<Vec3> points_W;
  double value = 0;  // two points: their distance, mm; three: the angle at the second one, degrees
};
/// Measures between two or three points. Returns none if one of them has no place.
std::optional<PieceMeasure> MeasurePieces(const PieceSet& pieces, const std::vector<PiecePoint>& points);

}  // namespace kerf
