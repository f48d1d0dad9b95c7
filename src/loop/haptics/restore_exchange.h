// Checkpoints, restores and motions of the tool that a reader requests from the loop. They are carried out between
// ticks, one at a time, in the order of the requests.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/core/spsc_ring.h"
#include "cut/hand_sim/restore.h"
#include "loop/record/step.h"

namespace kerf {

/// Motion of the hand and the tool by the program, without touching bone. The reader owns it; the loop uses it until it
/// is done.
struct CarryJob {
  enum class State : std::uint8_t {
    kRequested,
    kHeld,   // the loop holds the tool still until the reader, who then knows the bone exactly, has set the poses
    kReady,  // the poses are set
    kDone,
  };
  std::vector<Pose> poses;  // X_WT, one per tick; may be empty
  std::atomic<State> state{State::kRequested};
};

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
  /// Requests a restore. The state of the job reports whether it was accepted or refused. `carry`: motion of the tool
  /// after the restore, before the simulation continues, so that the tool need not stay in bone that was restored
  /// around it; null: none. If the restore is refused, the motion is not made. Returns false as above.
  bool Send(RestoreJob& job, CarryJob* carry = nullptr) { return ring_.TryPush({0, &job, carry}); }
  /// Requests a motion of the tool. Returns false as above.
  bool Send(CarryJob& carry) { return ring_.TryPush({0, nullptr, &carry}); }
  /// For a replay, between ticks: the tool is moved to this pose in the next tick.
  void Repeat(const Pose& X_WT) { repeated_ = X_WT; }

  // ---- Called by the loop; tick-safe.
  /// Starts the next request before a tick and notes it in the tick's inputs: a replay can repeat it in the same tick,
  /// with a job that the same journal creates again (src/cut/undo). Does nothing if `wait` is true or while a restore
  /// or a motion runs. A checkpoint waits while the history has no room for it. Returns the pose to which the tool is
  /// moved in this tick, and notes this in the tick's inputs too; null: it is not moved. `X_WT`: pose of the tool;
  /// null: not known yet.
  const Pose* Begin(CoupledSimulation& simulation, const Pose* X_WT, bool wait, TickInputs& in);
  /// True while a restore or a motion runs; then Step() is called instead of the simulation's tick.
  bool running() const { return restore_.running() || moves_; }
  /// `X_WT`: pose of the handle, where the tool is set down; null: unknown.
  void Step(CoupledSimulation& simulation, const Pose* X_WT);

 private:
  struct Request {
    std::uint32_t checkpoint = 0;
    RestoreJob* job = nullptr;
    CarryJob* carry = nullptr;  // without both: a checkpoint
  };
  void BeginNext(CoupledSimulation& simulation, TickInputs& in);
  const Pose* FindNextPose(const Pose& X_WT);
  SpscRing<Request> ring_{64};
  std::size_t leaves_per_tick_;
  Restore restore_;
  CarryJob* carry_ = nullptr;
  std::size_t next_pose_ = 0;
  Pose X_held_;
  std::optional<Pose> repeated_;
  bool moves_ = false;  // the tool is moved, or held still, in this tick
};

}  // namespace kerf
