// History of the pieces' states, with undo and redo, and its file format.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bone/pieces/piece_set.h"

namespace kerf {

class PieceHistory {
 public:
  const std::vector<PieceState>& now() const { return steps_[at_].states; }
  /// `like`: index of the piece whose states are copied; -1: the initial state.
  void AddPiece(int like);

  void Do(PieceAction action, std::vector<PieceState> states, int gesture);
  bool Undo();
  bool Redo();
  std::vector<PieceAction> actions() const;
  void Checkpoint(const std::string& name);
  bool GoTo(const std::string& name);
  std::vector<std::string> checkpoint_names() const;
  const std::map<std::string, std::vector<PieceState>>& checkpoints() const { return checkpoints_; }
  void set_checkpoint(const std::string& name, std::vector<PieceState> states);

 private:
  struct Step {
    PieceAction action;  // that led to these states
    std::vector<PieceState> states;
    int gesture = 0;
  };
  std::vector<Step> steps_{Step{}};  // the first is the initial state
  std::size_t at_ = 0;
  std::map<std::string, std::vector<PieceState>> checkpoints_;
};

/// Identifies a piece in a file.
struct PieceIdentity {
  std::string name;
  double volume_mm3 = 0;
};
/// See PieceSet::FormatJson() and PieceSet::Restore().
std::string FormatPieces(const std::vector<PieceIdentity>& pieces, const PieceHistory& history);
void RestorePieces(const std::string& text, const std::string& path, const std::vector<PieceIdentity>& pieces,
                   PieceHistory& history);

}  // namespace kerf
