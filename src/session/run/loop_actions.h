// Actions on a running loop, one after the other: planned for given times, or requested by a peer.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loop/haptics/step_body.h"
#include "session/run/loop_undo.h"
#include "session/run/session_controller.h"
#include "session/scene/scene.h"

namespace kerf {

/// Carries out actions. Call in the reader's thread.
class LoopActions {
 public:
  /// All references must outlive this object; `undo` and `peer` are optional. `record_request` records each request
  /// before it is made. `tool` gives the speeds of actions their sense.
  LoopActions(const std::vector<LoopAction>& planned, const SceneTool& tool, StepBody& body, LoopUndo* undo,
              SessionController* peer, LoopUndo::RecordRequest record_request)
      : planned_(planned),
        tool_(tool),
        body_(body),
        undo_(undo),
        peer_(peer),
        record_request_(std::move(record_request)) {}

  /// Starts the actions that are due at `now_s`, one at a time. A failure is reported to the peer if the action was its
  /// request; otherwise it is added to `warnings`.
  void Act(double now_s, std::vector<std::string>& warnings);
  /// Drops the planned actions before `begun_s`, which the replay has already passed, and adds a warning for each.
  void SkipTo(double begun_s, std::vector<std::string>& warnings);

  std::size_t left() const { return planned_.size() - next_; }
  double next_s() const { return planned_[next_].at_s; }
  double longest_ms() const { return longest_ms_; }  // from the request of a restore to its completion

 private:
  void Poll();
  void Do(const LoopAction& action);

  const std::vector<LoopAction>& planned_;
  const SceneTool& tool_;
  StepBody& body_;
  LoopUndo* undo_;
  SessionController* peer_;
  LoopUndo::RecordRequest record_request_;
  std::size_t next_ = 0;
  std::optional<LoopAction> current_;
  bool current_is_planned_ = false;
  std::chrono::steady_clock::time_point requested_at_;
  double longest_ms_ = 0;
};

}  // namespace kerf
