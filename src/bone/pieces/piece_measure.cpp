#include "bone/pieces/piece_measure.h"

#include "bone/pieces/measure.h"

namespace kerf {

PiecePoint MakePiecePoint(const PieceSet& pieces, const PiecePick& pick) {
  return {.piece = pieces.piece(pick.piece).name, .p_P = pieces.state(pick.piece).X_WP.InversePoint(pick.p_W_mm)};
}

std::optional<Vec3> CalcPlace(const PieceSet& pieces, const PiecePoint& point) {
  const int i = pieces.Find(point.piece);
  if (i < 0 || pieces.state(i).deleted) return {};
  return pieces.state(i).X_WP.Point(point.p_P);
}

std::optional<PieceMeasure> MeasurePieces(const PieceSet& pieces, const MeasuredPoints& points) {
  PieceMeasure measure;
  for (const PiecePoint& point : points) {
    const std::optional<Vec3> p_W = CalcPlace(pieces, point);
    if (!p_W) return {};
    measure.points_W.push_back(*p_W);
  }
  const std::vector<Vec3>& p = measure.points_W;
  measure.value = p.size() == 2 ? CalcDistance(p[0], p[1]) : CalcAngle(p[0], p[1], p[2]).value_or(0);
  return measure;
}

}  // namespace kerf
