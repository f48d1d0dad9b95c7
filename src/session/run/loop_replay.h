// Replay of a recorded session by `kerf loop` and `kerf replay`.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "loop/haptics/haptic_loop.h"
#include "session/run/loop_options.h"
#include "session/run/replay_body.h"

namespace kerf {

/// Replays a recording before the loop continues. Does nothing if there is no recording.
class LoopReplay {
 public:
  /// All references must outlive this object.
  LoopReplay(const LoopReplayOptions& options, StepBody& body, CoupledSimulation& simulation, ReplayDevice& device);
  /// Sets the callback for actions between ticks (ReplayBody). Call before Step().
  void set_between_ticks(std::function<void(const RecordedStep&)> between_ticks) {
    between_ticks_ = std::move(between_ticks);
  }

  /// Returns the body to pass to the loop. It replays the recording; afterwards it forwards the loop's calls to `body`
  /// of the constructor.
  LoopBody& body() { return *body_; }
  /// Runs the next recorded tick. `read` is called before it, at every 64th tick with the progress 0..1 and otherwise
  /// with -1. Returns false if `read` does, or if there is no further tick to replay. Throws kerf::Error for a
  /// recording that cannot be replayed.
  bool Step(HapticLoop& loop, const std::function<bool(double)>& read);
  /// From now on, the loop's calls reach the body and the device.
  void HandOver();
  Replayed MakeReport() const;
  /// These return the time before the next step, and the number of that step.
  double time_s() const { return body_->time_s(); }
  std::uint64_t step() const { return body_->step(); }

 private:
  LoopReplayOptions options_;
  std::function<void(const RecordedStep&)> between_ticks_;
  StepBody& step_body_;
  ReplayDevice& device_;
  std::optional<RecordedSteps> steps_;
  std::optional<ReplayBody> body_;
  std::uint64_t done_ = 0;
  std::optional<std::chrono::steady_clock::time_point> began_;
};

}  // namespace kerf
