// What is asked of a loop while it runs, done one after the other: at moments given before, or by whoever sits at it.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loop/haptics/step_body.h"
#include "session/run/loop_peer.h"
#include "session/run/loop_undo.h"

namespace kerf {

/// The reader's thread.
class LoopActions {
 public:
  /// All must outlive it; `undo` and `peer` may be null. `tell` records what is asked, before it is.
  LoopActions(const std::vector<LoopAction>& planned, StepBody& body, LoopUndo* undo, LoopPeer* peer,
              LoopUndo::Tell tell)
      : planned_(planned), body_(body), undo_(undo), peer_(peer), tell_(std::move(tell)) {}

  /// What is due by then, as far as nothing is under way. What could not be done is told to the peer, or to
  /// `warnings`.
  void Act(double now_s, std::vector<std::string>& warnings);
  /// Those planned for a moment that was gone through already, dropped with a warning.
  void SkipTo(double begun_s, std::vector<std::string>& warnings);

  std::size_t left() const { return planned_.size() - next_; }
  double next_s() const { return planned_[next_].at_s; }
  double longest_ms() const { return longest_ms_; }  // from asking for a restore to the bone being there

 private:
  void Poll();
  void Do(const LoopAction& action);

  const std::vector<LoopAction>& planned_;
  StepBody& body_;
  LoopUndo* undo_;
  LoopPeer* peer_;
  LoopUndo::Tell tell_;
  std::size_t next_ = 0;
  std::optional<LoopAction> under_way_;
  bool planned_under_way_ = false;
  std::chrono::steady_clock::time_point asked_at_;
  double longest_ms_ = 0;
};

}  // namespace kerf
