#include "bone/pieces/piece_history.h"

#include <cmath>
#include <utility>

namespace kerf {

bool PieceState::operator==(const PieceState& other) const {
  return X_WP.p_AB == other.X_WP.p_AB && X_WP.R_AB == other.X_WP.R_AB && hidden == other.hidden &&
         deleted == other.deleted;
}

std::array<double, 16> MakeMatrix(const Pose& X) {
  const Vec3 x = X.Vector({1, 0, 0});
  const Vec3 y = X.Vector({0, 1, 0});
  const Vec3 z = X.Vector({0, 0, 1});
  const Vec3& p = X.p_AB;
  return {x.x, y.x, z.x, p.x, x.y, y.y, z.y, p.y, x.z, y.z, z.z, p.z, 0, 0, 0, 1};
}

void PieceHistory::AddPiece(int like) {
  const auto extend = [like](std::vector<PieceState>& states) {
    states.push_back(like < 0 ? PieceState{} : states[static_cast<std::size_t>(like)]);
  };
  for (Step& step : steps_) extend(step.states);
  for (auto& [name, states] : checkpoints_) extend(states);
}

void PieceHistory::Do(PieceAction action, std::vector<PieceState> states, int gesture) {
  steps_.resize(at_ + 1);
  Step& last = steps_.back();
  if (gesture != 0 && at_ > 0 && last.gesture == gesture && last.action.what == action.what &&
      last.action.piece == action.piece) {
    const Pose before = last.action.X_WW;
    last.action.X_WW = {glm::normalize(action.X_WW.R_AB * before.R_AB), action.X_WW.Point(before.p_AB)};
    last.states = std::move(states);
    return;
  }
  steps_.push_back({.action = std::move(action), .states = std::move(states), .gesture = gesture});
  ++at_;
}

bool PieceHistory::Undo() {
  if (at_ == 0) return false;
  steps_[at_].gesture = 0;  // the gesture has ended
  --at_;
  return true;
}

bool PieceHistory::Redo() {
  if (at_ + 1 >= steps_.size()) return false;
  ++at_;
  return true;
}

std::vector<PieceAction> PieceHistory::actions() const {
  std::vector<PieceAction> actions;
  for (std::size_t i = 1; i <= at_; ++i) actions.push_back(steps_[i].action);
  return actions;
}

void PieceHistory::Checkpoint(const std::string& name) {
  checkpoints_[name] = now();
}

void PieceHistory::set_checkpoint(const std::string& name, std::vector<PieceState> states) {
  checkpoints_[name] = std::move(states);
}

bool PieceHistory::GoTo(const std::string& name) {
  const auto found = checkpoints_.find(name);
  if (found == checkpoints_.end()) return false;
  if (found->second != now()) Do({.what = "go to", .piece = {}, .X_WW = {}, .name = name}, found->second, 0);
  return true;
}

std::vector<std::string> PieceHistory::checkpoint_names() const {
  std::vector<std::string> names;
  for (const auto& [name, states] : checkpoints_) names.push_back(name);
  return names;
}

}  // namespace kerf
