// Replay of a recorded session by `kerf loop` and `kerf replay`.
#pragma once

#include <functional>
#include <utility>

#include "loop/haptics/haptic_loop.h"
#include "session/run/replay_body.h"
#include "session/run/run_loop.h"

namespace kerf {

/// Replays a recording before the loop goes on. Does nothing if there is no recording.
class LoopReplay {
 public:
  /// All references must outlive this object.
  LoopReplay(const LoopReplayOptions& options, StepBody& body, CoupledSimulation& simulation, ReplayDevice& device);
  /// Sets the callback for actions between ticks (ReplayBody). Call before GoThrough().
  void set_beside(std::function<void(const RecordedStep&)> beside) { beside_ = std::move(beside); }

  /// Returns the body between the loop and the loop's own body. It replays the recording and afterwards passes the
  /// loop's calls on.
  LoopBody& body() { return *body_; }
  /// Runs the recorded ticks. `read` is called before each tick, every 64th time with the progress 0..1 and otherwise
  /// with -1; the replay ends if it returns false. Throws kerf::Error for a recording that cannot be replayed.
  void GoThrough(HapticLoop& loop, const std::function<bool(double)>& read);
  Replayed MakeReport() const;
  /// These return the time before the next step, and the number of that step.
  double time_s() const { return body_->time_s(); }
  std::uint64_t step() const { return body_->step(); }

 private:
  LoopReplayOptions options_;
  std::function<void(const RecordedStep&)> beside_;
  StepBody& step_body_;
  ReplayDevice& device_;
  std::optional<RecordedSteps> steps_;
  std::optional<ReplayBody> body_;
};

}  // namespace kerf
