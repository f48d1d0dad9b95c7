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

  bool operator==(const PiecePoint&) const = default;
};
PiecePoint MakePiecePoint(const PieceSet& pieces, const PiecePick& pick);
/// Returns where the point is now, world frame; none if there is no such piece or it was deleted.
std::optional<Vec3> CalcPlace(const PieceSet& pieces, const PiecePoint& point);

/// Points of a measurement: two for a distance, three for the angle at the second one.
using MeasuredPoints = std::vector<PiecePoint>;

/// A measurement at the current places of its points.
struct PieceMeasure {
  std::vector<Vec3> points_W;
  double value = 0;  // mm or degrees
};
/// Returns none if one of the points has no place.
std::optional<PieceMeasure> MeasurePieces(const PieceSet& pieces, const MeasuredPoints& points);

}  // namespace kerf
