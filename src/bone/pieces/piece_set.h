// Pieces of a bone that was cut through: picking, moving, hiding, and measuring them against each other, with undo.
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

/// Constant data of a piece.
struct Piece {
  std::string name;  // "piece 1" is the largest
  Bone bone;         // in the place where it was cut off, so that its frame P is the world frame
  TriangleMesh mesh;
  double volume_mm3 = 0;
  Box3 bounds_P;
  Vec3 centroid_P{0};  // of the enclosed volume
};

/// Changeable state of a piece.
struct PieceState {
  Pose X_WP;
  bool hidden = false;
  bool deleted = false;
  bool operator==(const PieceState&) const;
};

/// One action on the pieces, for lists and files: plain data.
struct PieceAction {
  std::string what;   // "hide", "show", "delete", "move", "rotate", "move along", "rotate about", "place", "reset",
                      // "reset all", "go to", "restore"
  std::string piece;  // its name; empty for the last three
  Pose X_WW;          // its motion: X_WP after = X_WW X_WP before
  std::string name;   // of a checkpoint or a file
};

struct PiecePick {
  int piece = -1;
  Vec3 p_W_mm{0};
  double distance_mm = 0;  // distance along the ray
};

/// Contact of a piece with another one that is not deleted.
struct PieceContact {
  int other = -1;
  double overlap_mm3 = 0;
  std::optional<Gap> gap;  // empty if beyond the limit; 0 where the pieces overlap
};

/// The pieces of a bone. Indices of pieces start at 0 and never change. Unless stated otherwise, all functions that
/// take an index throw kerf::Error if it is out of range or the piece is deleted. Not thread-safe.
class PieceSet {
 public:
  PieceSet();
  /// Splits the bone with SplitPieces(); pieces smaller than `min_mm3` are omitted.
  explicit PieceSet(const Bone& bone, double min_mm3 = 1);
  ~PieceSet();
  PieceSet(PieceSet&&) noexcept;
  PieceSet& operator=(PieceSet&&) noexcept;

  /// Adds a piece, for example one that separated while the bone was cut. In all earlier steps of the
  /// undo history it has its initial state. If `name` is empty, the piece is named by the next free number. Returns its
  /// index.
  int Add(Bone bone, const std::string& name = "");
  /// Updates a piece that was cut further: it becomes the largest part of `now`. The others become new pieces;
  /// each copies the piece's state in every step of the undo history. Returns their indices, starting with `i`; only
  /// `i` if nothing is left of the piece. Also accepts a deleted piece.
  std::vector<int> Recut(int i, const Bone& now, double min_mm3 = 1);

  int size() const;
  const Piece& piece(int i) const;          // a deleted piece is allowed
  const PieceState& state(int i) const;     // a deleted piece is allowed
  int Find(const std::string& name) const;  // -1 if not found
  Vec3 CalcCentroid(int i) const;           // world, at its current pose; a deleted piece is allowed

  // ---- changes that can be undone. Consecutive steps with the same `gesture` (not 0) on one piece count as one.
  void SetHidden(int i, bool hidden);
  void Delete(int i);
  void Move(int i, const Vec3& by_W_mm, int gesture = 0);
  /// Rotates about a point, by a unit quaternion.
  void Rotate(int i, const Vec3& p_W, const Quat& by_W, int gesture = 0);
  /// Constrained motions: along an axis, and about it. `axis_W`: any length except 0.
  void MoveAlong(int i, const Vec3& axis_W, double by_mm, int gesture = 0);
  void RotateAbout(int i, const Vec3& p_W, const Vec3& axis_W, double by_deg, int gesture = 0);
  void Place(int i, const Pose& X_WP, int gesture = 0);
  void Reset(int i);  // back to where it was cut off
  void ResetAll();    // shows, restores and moves back all pieces
  bool Undo();        // false if there is nothing to undo
  bool Redo();
  /// Returns the actions up to now, oldest first.
  std::vector<PieceAction> actions() const;
  /// Saves the current states under a name; replaces a checkpoint of the same name.
  void Checkpoint(const std::string& name);
  /// Goes back to a checkpoint; this can be undone. Returns false if there is none of that name.
  bool GoTo(const std::string& name);
  std::vector<std::string> checkpoints() const;

  // ---- queries
  /// Builds the search trees that the functions below otherwise build on their first call, which takes seconds for a
  /// whole mandible at 0.125 mm. Afterwards, several threads may call them at once, as long as the set is not changed.
  void Prepare() const;
  /// Returns the first piece, shown and not deleted, that a ray hits; `direction_W`: any length except 0.
  std::optional<PiecePick> Pick(const Vec3& origin_W, const Vec3& direction_W) const;
  /// Computes the contacts with every other piece that is not deleted. Gaps beyond `gap_limit_mm` are not searched for.
  std::vector<PieceContact> CalcContacts(int i, double gap_limit_mm = 50) const;
  PieceContact CalcContact(int i, int other, double gap_limit_mm = 50) const;
  double CalcOverlapWith(int i, int other) const;
  std::optional<Gap> CalcGapTo(int i, int other, double limit_mm) const;
  /// Computes statistics of the surface of piece i that faces the other piece.
  Facing CalcFacingTo(int i, int other, double reach_mm = 3, double contact_mm = 0.2) const;

  // ---- files
  /// Formats pieces.json: states, checkpoints and actions. A pose is a 4 x 4 matrix, row by row (LPS, mm), that moves a
  /// piece from where it was cut off to where it is.
  std::string FormatJson() const;
  /// Sets pieces, identified by name, and checkpoints to the states in a file, as one step that can be undone. Throws
  /// kerf::Error with one sentence if the text is not such a file, or belongs to other pieces (volumes that differ by
  /// more than one percent).
  void Restore(const std::string& text, const std::string& path);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Constrains a free motion of a piece to an axis: returns its translation along the axis through p_W and its rotation
/// about it.
Pose ConstrainToAxis(const Pose& X_WW, const Vec3& p_W, const Vec3& axis_W);

/// Returns the 4 x 4 matrix of a pose, row by row.
std::array<double, 16> MakeMatrix(const Pose& X);

}  // namespace kerf
