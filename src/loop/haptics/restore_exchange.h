// Checkpoints and restores that a reader asks the loop for: between ticks, one at a time, in the order asked.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/core/spsc_ring.h"
#include "cut/hand_sim/restore.h"

namespace kerf {

/// Something that a reader asked for and that was done in a tick: all that a replay needs to do it again in the same
/// one, with a job made anew by the same journal (src/cut/undo).
struct RestoreEvent {
  enum class Kind : std::uint8_t { kNone, kCheckpoint, kUndo, kRedo };
  Kind kind = Kind::kNone;
  std::uint32_t number = 0;  // of the checkpoint that was made, or that the restore leads to (RestoreJob)
};

/// The loop's side. While a restore runs the simulation stands still and the device's force goes to zero by its slew;
/// then the tool is set down where the handle is, and the force comes by the ramp.
class RestoreExchange {
 public:
  /// `leaves_per_tick`: put back in a tick, 1 or more.
  explicit RestoreExchange(std::size_t leaves_per_tick = 1500) : leaves_per_tick_(leaves_per_tick) {}

  // ---- the reader's
  /// The bone as it is after the tick under way becomes this checkpoint (CoupledSimulation::Checkpoint()). False when
  /// too much is asked for already.
  bool AskCheckpoint(std::uint32_t number) { return ring_.TryPush({number, nullptr}); }
  /// Takes the job up, now or refused, which its state tells. False as above.
  bool Send(RestoreJob& job) { return ring_.TryPush({0, &job}); }

  // ---- the loop's: tick-safe
  /// Before a tick: takes up what was asked next. Nothing while `wait`, or while a restore runs; a checkpoint for which
  /// the history has no room waits.
  RestoreEvent Begin(CoupledSimulation& simulation, bool wait);
  /// In the place of the simulation's tick while one runs. True when all is there: End() is to follow.
  bool Step(CoupledSimulation& simulation) { return restore_.Step(simulation, leaves_per_tick_); }
  void End(CoupledSimulation& simulation, const Pose* X_WT) { restore_.End(simulation, X_WT); }
  bool running() const { return restore_.running(); }

 private:
  struct Request {
    std::uint32_t checkpoint = 0;
    RestoreJob* job = nullptr;  // null: a checkpoint
  };
  SpscRing<Request> ring_{64};
  std::size_t leaves_per_tick_;
  Restore restore_;
};

}  // namespace kerf
