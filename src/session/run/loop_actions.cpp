#include "session/run/loop_actions.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

void LoopActions::Poll() {
  if (undo_ == nullptr) return;
  if (undo_->Poll()) {
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - requested_at_;
    longest_ms_ = std::max(longest_ms_, took.count());
  }
  if (!current_ || !undo_->is_idle()) return;
  if (peer_ != nullptr && !current_is_planned_) peer_->Done(*current_, "", undo_->restored_mm3());
  current_.reset();
}

void LoopActions::Do(const LoopAction& action) {
  requested_at_ = std::chrono::steady_clock::now();
  if (action.kind == LoopAction::Kind::kSpindle) {
    record_request_("rpm", action.name, 0);
    body_.set_rpm(tool_.CalcTickRpm(action.rpm));
    return;
  }
  current_ = action;
  undo_->Do(action, record_request_);
}

void LoopActions::Act(double now_s, std::vector<std::string>& warnings) {
  std::optional<LoopAction> requested;
  try {
    Poll();
    while ((undo_ == nullptr || undo_->is_idle()) && next_ < planned_.size() && planned_[next_].at_s <= now_s + 1e-9) {
      current_is_planned_ = true;
      Do(planned_[next_++]);
    }
    while (peer_ != nullptr && (undo_ == nullptr || undo_->is_idle()) && (requested = peer_->NextAction())) {
      current_is_planned_ = false;
      Do(*requested);
      if (!current_) peer_->Done(*requested, "", {});
    }
  } catch (const Error& e) {
    const bool from_peer = current_ && !current_is_planned_;
    const LoopAction failed = current_.value_or(LoopAction{});
    current_.reset();
    if (from_peer) {
      peer_->Done(failed, e.what(), {});
    } else {
      warnings.push_back(fmt::format("at {:.3f} s: {}", now_s, e.what()));
    }
  }
}

void LoopActions::SkipTo(double begun_s, std::vector<std::string>& warnings) {
  for (; next_ < planned_.size() && planned_[next_].at_s < begun_s - 1e-6; ++next_) {
    warnings.push_back(fmt::format("the action at {:g} s is before the time at which the session continues, {:.3f} s",
                                   planned_[next_].at_s, begun_s));
  }
}

}  // namespace kerf
