// Checkpoints, undo and redo of a loop, and retracting its tool: requested at given times, carried out between ticks,
// recorded and replayed.
#pragma once

#include <functional>
#include <map>
#include <memory>
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
  // kRetract: take the tool out of the bone, and to X_to; only if the program can move the hand, as with a mouse.
  enum class Kind { kCheckpoint, kUndo, kRedo, kSpindle, kRetract };
  double at_s = 0;
  Kind kind = Kind::kCheckpoint;
  double rpm = 0;    // kSpindle
  std::string name;  // name of the checkpoint, or with kSpindle the speed as text; empty with kUndo: one step back
  std::optional<Pose> X_to = std::nullopt;  // kRetract: where the tool is taken; none: only out of the bone
};
/// Parses "2.5:checkpoint=before the cut", "6:undo", "6:undo=before the cut", "7:redo" or "8:rpm=0". Throws kerf::Error
/// for any other text, and for a speed, whatever its sign, outside of `rates`: CalcRateRange() of the tool.
LoopAction ParseLoopAction(const std::string& text, const Range& rates = kSpindleRange_rpm);

/// Moves the tool of a loop whose hand can be moved by the program (HandDriver::Place()). Called in the reader's
/// thread.
class ToolMover {
 public:
  ToolMover() = default;
  ToolMover(const ToolMover&) = delete;
  ToolMover& operator=(const ToolMover&) = delete;
  virtual ~ToolMover() = default;

  /// False if something else determines the tool's pose: a path or a haptic device.
  virtual bool can_move() const = 0;
  /// Returns the tool's last known pose.
  virtual Pose X_WT() const = 0;
  /// These return the poses, one per tick, through which a tool that the loop holds still is moved. They return nothing
  /// while not all changes of the bone have been received from the loop. A pose at which the tool would be in bone
  /// stands for one nearby that is clear of it.
  /// After undo and redo: to `X_wanted`, at once.
  virtual std::optional<std::vector<Pose>> FindReturn(const Pose& X_wanted) = 0;
  /// Out of the bone, and from there to `X_to`, if it is given.
  virtual std::optional<std::vector<Pose>> FindRetraction(const std::optional<Pose>& X_to) = 0;
  /// Returns the volume that the tool has removed so far, without regard to undo.
  virtual double removed_mm3() const = 0;
};

/// Requests checkpoints, undo and redo, and retracts the tool. Undo and redo bring the tool back to its pose at the
/// time of the restored state. Call in the reader's thread. A simulation keeps a history only if this object exists.
class LoopUndo {
 public:
  /// All references must outlive this object. `max_MB`: as in UndoParams. `mover`: null: undo and redo leave the tool
  /// at the handle, and retracting is not possible.
  LoopUndo(CoupledSimulation& simulation, double max_MB, ToolMover* mover = nullptr);

  RestoreExchange& exchange() { return exchange_; }
  UndoJournal& journal() { return journal_; }

  using RecordRequest = std::function<void(const std::string& what, const std::string& name, std::uint32_t number)>;
  /// Requests an action. `record_request` is called with each request before it is made. Throws kerf::Error for an
  /// impossible action, such as an undo without history or retracting a tool that a device holds. Returns false if
  /// another action is in progress.
  bool Do(const LoopAction& action, const RecordRequest& record_request);
  /// Call periodically. Retries a restore that was refused, and moves the tool. Returns true if a restore has just been
  /// completed.
  bool Poll();
  /// Returns true if no action is in progress; an action must wait for the previous one.
  bool is_idle() const { return journal_.job() == nullptr && pending_checkpoint_ == 0 && carry_ == nullptr; }

  /// For a replay, between ticks: repeats the action recorded before `step`. `names`: events with the names of
  /// checkpoints, by number. Throws kerf::Error if it cannot be repeated.
  void Repeat(const RecordedStep& step, const std::vector<RecordedEvent>& names);

  /// Returns the number of completed restores. The caller measures their duration.
  std::size_t restores() const { return restores_; }
  /// Returns the volume that the last restore has put back, or taken away again (redo); none if it is not known.
  std::optional<double> restored_mm3() const { return restored_mm3_; }

 private:
  /// Where the tool was in a state of the bone, and what had been cut out of it.
  struct State {
    Pose X_WT;
    double removed_mm3 = 0;
  };
  bool can_move() const { return mover_ != nullptr && mover_->can_move(); }
  State MakeState() const { return {mover_->X_WT(), mover_->removed_mm3() - put_back_mm3_}; }
  void FinishRestore(bool redo);
  UndoJob* Prepare(const LoopAction& action);
  void Send(UndoJob& job);
  void PollCarry();

  CoupledSimulation& simulation_;
  ToolMover* mover_;
  RestoreExchange exchange_;
  UndoJournal journal_;
  std::optional<LoopAction> pending_;     // action of the job in progress
  bool supplied_ = false;                 // spare leaves for that job, after it was refused
  std::uint32_t pending_checkpoint_ = 0;  // checkpoint that is not made yet; 0: none
  std::size_t restores_ = 0;
  std::map<std::uint32_t, State> at_;     // at each checkpoint, by its number; with a mover only
  std::vector<State> undone_;             // at each undo that can be redone; with a mover only
  State before_;                          // before the restore in progress
  std::optional<State> goal_;             // after it; none: unknown
  double put_back_mm3_ = 0;               // by all restores
  std::optional<double> restored_mm3_;    // by the last one
  std::unique_ptr<CarryJob> carry_;       // motion in progress
  std::optional<LoopAction> retracting_;  // it is a retraction; none: it follows a restore
};

}  // namespace kerf
