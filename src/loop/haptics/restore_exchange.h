// Checkpoints and restores that a reader requests from the loop. They are carried out between ticks, one at a time, in
// the order of the requests.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/core/spsc_ring.h"
#include "cut/hand_sim/restore.h"
#include "loop/record/step.h"

namespace kerf {

/// The loop's end of the exchange. While a restore runs, the simulation is stopped and the device's force falls to zero
/// at the slew rate. Afterwards, the tool is placed at the handle and the force is ramped in.
class RestoreExchange {
 public:
  /// `leaves_per_tick`: number of leaves restored per tick, at least 1.
  explicit RestoreExchange(std::size_t leaves_per_tick = 1500) : leaves_per_tick_(leaves_per_tick) {}

  // ---- Called by the reader.
  /// Requests that the bone as it is after the current tick become this checkpoint (CoupledSimulation::Checkpoint()).
  /// Returns false if too many requests are waiting.
  bool RequestCheckpoint(std::uint32_t number) { return ring_.TryPush({number, nullptr}); }
  /// Requests a restore. The state of the job reports whether it was accepted or refused. Returns false as above.
  bool Send(RestoreJob& job) { return ring_.TryPush({0, &job}); }

  // ---- Called by the loop; tick-safe.
  /// Starts the next request before a tick and notes it in the tick's inputs: a replay can repeat it in the same tick,
  /// with a job that the same journal creates again (src/cut/undo). Does nothing if `wait` is true or while a restore
  /// runs. A checkpoint waits while the history has no room for it.
  void Begin(CoupledSimulation& simulation, bool wait, TickInputs& in);
  /// Called instead of the simulation's tick while a restore runs. Returns true when the restore is complete and End()
  /// must be called.
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
