// Checkpoints, undo and redo of a loop: asked for at moments, done between its ticks, recorded and gone through again.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cut/undo/journal.h"
#include "loop/haptics/restore_exchange.h"
#include "loop/record/recording.h"

namespace kerf {

/// What is to be done at a moment of a loop.
struct LoopAction {
  enum class Kind { kCheckpoint, kUndo, kRedo, kSpindle };
  double at_s = 0;
  Kind kind = Kind::kCheckpoint;
  double rpm = 0;    // kSpindle
  std::string name;  // of the checkpoint; empty with kUndo: one back
};
/// "2.5:checkpoint=before the cut", "6:undo", "6:undo=before the cut", "7:redo", "8:rpm=0". Throws Error that says what
/// is wrong.
LoopAction ParseLoopAction(const std::string& text);

/// The reader's thread. Without it a simulation keeps no history.
class LoopUndo {
 public:
  /// The simulation must outlive it. `most_MB`: as UndoParams.
  LoopUndo(CoupledSimulation& simulation, double most_MB);

  RestoreExchange& exchange() { return exchange_; }
  UndoJournal& journal() { return journal_; }

  using Tell = std::function<void(const std::string& what, const std::string& name, std::uint32_t number)>;
  /// `tell`: what is asked of the loop, before it is. Throws Error for what can't be done, as an undo of nothing.
  /// False: not now, a restore is on its way.
  bool Do(const LoopAction& action, const Tell& tell);
  /// Now and then. A refused restore is tried again. True when one has just been done.
  bool Poll();
  /// Nothing is on its way: each action waits for the one before.
  bool is_idle() const { return journal_.job() == nullptr && asked_checkpoint_ == 0; }

  /// Between ticks, in a replay: what was done before that step. `names`: of checkpoints, by number. Throws Error when
  /// it can't be done.
  void Repeat(const RecordedStep& step, const std::vector<RecordedEvent>& names);

  /// How long it took from Do() to its end, by the caller's clock, is not known here.
  std::size_t restores() const { return restores_; }

 private:
  RestoreExchange exchange_;
  UndoJournal journal_;
  std::optional<LoopAction> asked_;     // of the job on its way
  std::uint32_t asked_checkpoint_ = 0;  // that has not been made yet; 0: none
  std::size_t restores_ = 0;
};

}  // namespace kerf
