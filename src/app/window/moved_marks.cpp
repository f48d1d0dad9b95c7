#include "app/window/moved_marks.h"

#include <utility>

namespace kerf {
namespace {

bool HasMoved(const PieceState& state) {
  const Pose still;
  return state.X_WP.p_AB != still.p_AB || state.X_WP.R_AB != still.R_AB;
}

constexpr int kNone = -1;

/// Returns the piece in which a point of the uncut bone lies, or near whose surface; kNone if it is far from all.
int FindPieceAt(const PieceSet& pieces, const Vec3& p_P) {
  int found = kNone;
  double nearest_mm = 0;
  for (int i = 0; i < pieces.size(); ++i) {
    if (pieces.state(i).deleted) continue;
    const Bone& bone = pieces.piece(i).bone;
    const double distance_mm = bone.SignedDistance(p_P);
    if (distance_mm >= 0.99 * bone.band_mm() || (found != kNone && distance_mm >= nearest_mm)) continue;
    found = i;
    nearest_mm = distance_mm;
  }
  return found;
}

}  // namespace

MovedMarks MoveMarks(const PieceSet& pieces, const std::vector<MarkOverlay>& marks) {
  bool moved = false;
  for (int i = 0; i < pieces.size(); ++i) moved = moved || (!pieces.state(i).deleted && HasMoved(pieces.state(i)));
  if (!moved) return {marks, false};
  MovedMarks result;
  for (const MarkOverlay& mark : marks) {
    int in = kNone;
    bool labelled = false;
    for (std::size_t k = 0; k < mark.points_W.size(); ++k) {
      const int piece = FindPieceAt(pieces, mark.points_W[k]);
      result.left_out = result.left_out || piece == kNone;
      if (piece == kNone) {
        in = kNone;
        continue;
      }
      if (piece != in) {
        in = piece;
        result.marks.push_back(mark);
        result.marks.back().points_W.clear();
        if (std::exchange(labelled, true)) result.marks.back().label.clear();
      }
      result.marks.back().points_W.push_back(pieces.state(piece).X_WP.Point(mark.points_W[k]));
    }
  }
  return result;
}

}  // namespace kerf
