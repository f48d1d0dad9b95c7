#include "kerf/checkpoints.h"

#include "cut/hand_sim/internals.h"
#include "cut/undo/journal.h"

namespace kerf {

struct Checkpoints::State {
  CoupledSimulation& simulation;
  UndoJournal journal;
};

Checkpoints::Checkpoints(CoupledSimulation& simulation, double max_MB)
    : state_(new State{simulation, UndoJournal(KeepHistory(simulation), {.max_MB = max_MB})}) {}
Checkpoints::~Checkpoints() = default;

void Checkpoints::Update() {
  state_->journal.Drain();
}

void Checkpoints::Make(const std::string& name) {
  MakeCheckpoint(state_->simulation, state_->journal, name);
}

std::vector<UndoCheckpoint> Checkpoints::List() const {
  return state_->journal.checkpoints();
}

void Checkpoints::Undo(const std::string& name, const Pose* X_WT) {
  state_->journal.Drain();
  UndoTo(state_->simulation, state_->journal, name.empty() ? state_->journal.FindOneBack() : state_->journal.Find(name),
         X_WT);
}

void Checkpoints::Redo(const Pose* X_WT) {
  kerf::Redo(state_->simulation, state_->journal, X_WT);
}

bool Checkpoints::CanRedo() const {
  return state_->journal.CanRedo();
}

}  // namespace kerf
