// Restores the bone to an earlier state, between ticks, a few leaves at a time.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kerf/coupled.h"

namespace kerf {

/// Leaves to be restored. The job is made by the reader of a history (src/cut/undo/journal.h) and is owned by it; the
/// simulation uses it until it is done. The job then holds the exchanged values of the bone, with which it can be
/// reversed.
///
/// The reader is slightly behind the simulation. Leaves that changed since its last read are in the history ring, where
/// the simulation thread finds them. The result is therefore the bone of the checkpoint, no matter when the restore
/// begins.
struct RestoreJob {
  struct Leaf {
    std::array<int, 3> index{};
    float* values = nullptr;  // 512, exchanged with the bone's
  };
  /// Progress, or the reason for a refusal.
  enum class State : std::uint8_t {
    kWaiting,
    kRunning,
    kDone,
    kChanged,   // too much bone has been cut since the job was made (for redo: any bone); make another job
    kLost,      // old values were lost because the history ring was full
    kNoLeaves,  // too few spare leaves: SupplyLeaves()
  };

  std::uint32_t number = 0;   // checkpoint to return to; for redo, the one that undo returned to
  bool redo = false;          // true: redo, which is possible only while nothing changes
  std::size_t seen = 0;       // number of history entries read when the job was made
  std::uint32_t lost = 0;     // LeafHistory::last_lost() when the job was made
  std::vector<Leaf> leaves;   // each leaf once
  std::vector<float*> spare;  // blocks of 512 values for leaves that have changed since; the last one is used first
  std::array<double, 256> taken_out_mm3{};

  // Set by the simulation before `state` is kDone.
  std::size_t pushed = 0;   // number of history entries from before the restore
  std::uint32_t epoch = 0;  // epoch in which the restore ended
  std::atomic<State> state{State::kWaiting};
};

/// Returns the reason for a refusal as a clause; empty if the job was not refused.
const char* WhyRefused(RestoreJob::State state);

/// The simulation's part of a restore. Tick-safe, unless `may_refill` is true. Its course depends only on the tick in
/// which it begins, because the number of steps follows from the number of changed leaves.
class Restore {
 public:
  /// Begins the restore. Returns false and changes nothing if it is not possible; job.state then gives the reason.
  /// `may_refill`: allocate spare leaves when they are needed, which is not tick-safe.
  bool Begin(CoupledSimulation& simulation, RestoreJob& job, bool may_refill = false);
  bool running() const { return job_ != nullptr; }
  /// Restores at most `leaves` further leaves; `leaves` is 1 or more. Returns true when all are restored; then End()
  /// must follow before the next tick.
  bool Step(CoupledSimulation& simulation, std::size_t leaves);
  /// Sets the tool down at X_WT; null: at its current pose. Returns the job to its owner.
  void End(CoupledSimulation& simulation, const Pose* X_WT);
  /// Sets the handle and the tool down at X_WT without cutting on the way; an invalid pose is ignored. Tick-safe.
  static void SetDown(CoupledSimulation& simulation, const Pose& X_WT);

 private:
  bool HasRoom(const CoupledSimulation& simulation) const;
  void Swap(CoupledSimulation& simulation, const RestoreJob::Leaf& leaf);
  static bool Touch(CoupledSimulation& simulation, const std::array<int, 3>& index);

  RestoreJob* job_ = nullptr;
  bool may_refill_ = false;
  std::size_t next_ = 0;       // index in the job's leaves
  std::size_t at_begin_ = 0;   // initial number of the job's leaves
  std::size_t next_seen_ = 0;  // index of the next history entry
};

/// Runs the whole restore at once, allocating spare leaves as needed; for a thread that owns the simulation, not in a
/// tick. `X_WT`: pose at which the tool is then set down; null: its current pose. Returns false if refused: see
/// job.state.
bool RunRestore(CoupledSimulation& simulation, RestoreJob& job, const Pose* X_WT = nullptr);

}  // namespace kerf
