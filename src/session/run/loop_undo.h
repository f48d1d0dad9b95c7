// Checkpoints, undo and redo of a loop: requested at given times, carried out between ticks, recorded and replayed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cut/undo/journal.h"
#include "loop/haptics/restore_exchange.h"
#include "loop/record/recording.h"

namespace kerf {

/// Times in a session that users may give.
inline constexpr Range kSessionTimeRange_s{0, 1e9};

/// An action at a given time of a loop.
struct LoopAction {
  enum class Kind { kCheckpoint, kUndo, kRedo, kSpindle };
  double at_s = 0;
  Kind kind = Kind::kCheckpoint;
  double rpm = 0;    // kSpindle
  std::string name;  // name of the checkpoint, or with kSpindle the speed as text; empty with kUndo: one step back
};
/// Parses "2.5:checkpoint=before the cut", "6:undo", "6:undo=before the cut", "7:redo" or "8:rpm=0". Throws kerf::Error
/// for any other text.
LoopAction ParseLoopAction(const std::string& text);

/// Requests checkpoints, undo and redo. Call in the reader's thread. A simulation keeps a history only if this object
/// exists.
class LoopUndo {
 public:
  /// `simulation` must outlive this object. `max_MB`: as in UndoParams.
  LoopUndo(CoupledSimulation& simulation, double max_MB);

  RestoreExchange& exchange() { return exchange_; }
  UndoJournal& journal() { return journal_; }

  using RecordRequest = std::function<void(const std::string& what, const std::string& name, std::uint32_t number)>;
  /// Requests an action. `record_request` is called with each request before it is made. Throws kerf::Error for an
  /// impossible action, such as an undo without history. Returns false if another action is in progress.
  bool Do(const LoopAction& action, const RecordRequest& record_request);
  /// Call periodically. Retries a restore that was refused. Returns true if a restore has just been completed.
  bool Poll();
  /// Returns true if no action is in progress; an action must wait for the previous one.
  bool is_idle() const { return journal_.job() == nullptr && pending_checkpoint_ == 0; }

  /// For a replay, between ticks: repeats the action recorded before `step`. `names`: events with the names of
  /// checkpoints, by number. Throws kerf::Error if it cannot be repeated.
  void Repeat(const RecordedStep& step, const std::vector<RecordedEvent>& names);

  /// Returns the number of completed restores. The caller measures their duration.
  std::size_t restores() const { return restores_; }

 private:
  RestoreExchange exchange_;
  UndoJournal journal_;
  std::optional<LoopAction> pending_;     // action of the job in progress
  std::uint32_t pending_checkpoint_ = 0;  // checkpoint that is not made yet; 0: none
  std::size_t restores_ = 0;
};

}  // namespace kerf
