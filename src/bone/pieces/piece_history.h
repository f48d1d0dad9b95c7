// What was done with pieces: states one after the other, gone back to and forward again, and their file.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bone/pieces/piece_set.h"

namespace kerf {

/// "move piece 2", for people.
std::string Describe(const PieceAction& action);

class PieceHistory {
 public:
  const std::vector<PieceState>& now() const { return steps_[at_].states; }
  /// `like`: the piece whose states it gets, -1 for those of the start.
  void AddPiece(int like);

  void Do(PieceAction action, std::vector<PieceState> states, int gesture);
  bool Undo();
  bool Redo();
  const PieceAction* FindUndo() const;  // null: nothing
  const PieceAction* FindRedo() const;
  std::vector<PieceAction> actions() const;
  void Checkpoint(const std::string& name);
  bool GoTo(const std::string& name);
  std::vector<std::string> checkpoint_names() const;
  const std::map<std::string, std::vector<PieceState>>& checkpoints() const { return checkpoints_; }
  void set_checkpoint(const std::string& name, std::vector<PieceState> states);

 private:
  struct Step {
    PieceAction action;  // that led here
    std::vector<PieceState> states;
    int gesture = 0;
  };
  std::vector<Step> steps_{Step{}};  // the first: the start
  std::size_t at_ = 0;
  std::map<std::string, std::vector<PieceState>> checkpoints_;
};

/// By which a file's pieces are told.
struct PieceIdentity {
  std::string name;
  double volume_mm3 = 0;
};
/// As PieceSet::FormatJson() and PieceSet::Restore().
std::string FormatPieces(const std::vector<PieceIdentity>& pieces, const PieceHistory& history);
void RestorePieces(const std::string& text, const std::string& path, const std::vector<PieceIdentity>& pieces,
                   PieceHistory& history);

}  // namespace kerf
