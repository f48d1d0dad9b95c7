// The pieces of a bone that was cut through: picked, moved, hidden, measured against each other, all of it undone.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bone/pieces/overlap.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// What stays as it was made.
struct Piece {
  std::string name;  // "piece 1", the largest first
  Bone bone;         // where it was cut off: its own frame P is the world then
  TriangleMesh mesh;
  double volume_mm3 = 0;
  Box3 bounds_P;
  Vec3 centroid_P{0};  // of the enclosed volume
};

/// What is done to it.
struct PieceState {
  Pose X_WP;
  bool hidden = false;
  bool deleted = false;
  bool operator==(const PieceState&) const;
};

/// What was done, for lists and files: plain data.
struct PieceAction {
  std::string what;   // "hide", "show", "delete", "move", "rotate", "move along", "rotate about", "place", "reset",
                      // "reset all", "go to", "restore"
  std::string piece;  // its name; of the last three empty
  Pose X_WW;          // by which it was moved: X_WP after = X_WW X_WP before
  std::string name;   // of a checkpoint or a file
};

struct PiecePick {
  int piece = -1;
  Vec3 p_W_mm{0};
  double way_mm = 0;  // along the ray
};

/// Of a piece against another that is not deleted.
struct PieceContact {
  int other = -1;
  double overlap_mm3 = 0;
  std::optional<Gap> gap;  // none beyond the limit; where they overlap it is 0
};

/// Indices are those of pieces, from 0, and stay good. All functions that take one throw Error for a deleted piece or
/// none of that number. Not thread-safe.
class PieceSet {
 public:
  PieceSet();
  /// Splits the bone (SplitPieces); smaller ones are left out.
  explicit PieceSet(const Bone& bone, double min_mm3 = 1);
  ~PieceSet();
  PieceSet(PieceSet&&) noexcept;
  PieceSet& operator=(PieceSet&&) noexcept;

  /// Another one, as one that left the bone while it was cut. Its state is that of the start in all that was done so
  /// far. `name`: empty for the next number. Returns its index.
  int Add(Bone bone, const std::string& name = "");
  /// The piece was cut further: it is now the largest part of `now`, and its other parts are new pieces that come along
  /// in all that was done with it. Returns their indices; the piece itself when nothing is left of it.
  std::vector<int> Recut(int i, const Bone& now, double min_mm3 = 1);

  int size() const;
  const Piece& piece(int i) const;          // of a deleted one too
  const PieceState& state(int i) const;     // likewise
  int Find(const std::string& name) const;  // -1: none
  Vec3 CalcCentroid(int i) const;           // world, where it is now

  // ---- what can be undone. Steps with the same `gesture` (not 0) on the same piece, one after the other, are one.
  void SetHidden(int i, bool hidden);
  void Delete(int i);
  void Move(int i, const Vec3& by_W_mm, int gesture = 0);
  /// About a point, by a unit quaternion.
  void Rotate(int i, const Vec3& p_W, const Quat& by_W, int gesture = 0);
  /// The constrained movements: along an axis, and about it. `axis_W`: any length but 0.
  void MoveAlong(int i, const Vec3& axis_W, double by_mm, int gesture = 0);
  void RotateAbout(int i, const Vec3& p_W, const Vec3& axis_W, double by_deg, int gesture = 0);
  void Place(int i, const Pose& X_WP, int gesture = 0);
  void Reset(int i);  // back to where it was cut off
  void ResetAll();    // shown, and back what was deleted
  bool Undo();        // false: nothing to undo
  bool Redo();
  bool can_undo() const;
  bool can_redo() const;
  /// What was done up to now, oldest first.
  std::vector<PieceAction> actions() const;
  /// Of what Undo() would undo; empty: nothing.
  std::string next_undo() const;
  std::string next_redo() const;
  /// Keeps the state by name; one of the same name is replaced.
  void Checkpoint(const std::string& name);
  /// As it was then; can be undone. False: there is none of that name.
  bool GoTo(const std::string& name);
  std::vector<std::string> checkpoints() const;

  // ---- asked
  /// Makes what the functions below need at their first call: seconds for a whole mandible at 0.125 mm. After it they
  /// may be called by several threads at once, as long as nobody changes the set.
  void Prepare() const;
  /// The first piece, shown and not deleted, that a ray meets; `direction_W`: any length but 0.
  std::optional<PiecePick> Pick(const Vec3& origin_W, const Vec3& direction_W) const;
  /// Against each other piece that is not deleted. `gap_limit_mm`: gaps beyond are not looked for.
  std::vector<PieceContact> CalcContacts(int i, double gap_limit_mm = 50) const;
  double CalcOverlapWith(int i, int other) const;
  std::optional<Gap> CalcGapTo(int i, int other, double limit_mm) const;
  /// Of the surface of piece i that faces the other one.
  Facing CalcFacingTo(int i, int other, double reach_mm = 3, double contact_mm = 0.2) const;

  // ---- kept
  /// pieces.json: poses as 4 x 4 matrices from the place where a piece was cut off to where it is, LPS mm, row by row;
  /// state, checkpoints and what was done.
  std::string FormatJson() const;
  /// Brings pieces, told by their names, and checkpoints to where a file has them; all of it is undone in one step.
  /// Throws Error with one sentence when the text is no such file, or is of other pieces (volumes that differ by more
  /// than a hundredth).
  void Restore(const std::string& text, const std::string& path);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A free motion of a piece held to an axis: what of it goes along the axis through p and turns about it.
Pose ConstrainToAxis(const Pose& X_WW, const Vec3& p_W, const Vec3& axis_W);

/// Row by row.
std::array<double, 16> MakeMatrix(const Pose& X);

}  // namespace kerf
