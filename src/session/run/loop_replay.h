// A recorded session gone through by `kerf loop` and `kerf replay`.
#pragma once

#include <functional>
#include <utility>

#include "loop/haptics/haptic_loop.h"
#include "session/run/replay_body.h"
#include "session/run/run_loop.h"

namespace kerf {

/// Does nothing when there is no recording.
class LoopReplay {
 public:
  /// All must outlive it.
  LoopReplay(const LoopReplayOptions& options, StepBody& body, CoupledSimulation& simulation, ReplayDevice& device);
  /// What is done beside the ticks: ReplayBody. Before GoThrough().
  void set_beside(std::function<void(const RecordedStep&)> beside) { beside_ = std::move(beside); }

  /// Between loop and body: first what was recorded, then, once it has been gone through, whatever the loop says.
  LoopBody& body() { return *body_; }
  /// `read`: before each tick, now and then with 0..1 and else with -1; false ends it. Throws Error for a recording
  /// that can't be gone through.
  void GoThrough(HapticLoop& loop, const std::function<bool(double)>& read);
  Replayed MakeReport() const;
  /// Before the next step, and its number.
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
