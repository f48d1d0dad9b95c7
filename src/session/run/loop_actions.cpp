#include "session/run/loop_actions.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

void LoopActions::Poll() {
  if (undo_ == nullptr) return;
  if (undo_->Poll()) {
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - asked_at_;
    longest_ms_ = std::max(longest_ms_, took.count());
  }
  if (!under_way_ || !undo_->is_idle()) return;
  if (peer_ != nullptr && !planned_under_way_) peer_->Done(*under_way_, "");
  under_way_.reset();
}

void LoopActions::Do(const LoopAction& action) {
  asked_at_ = std::chrono::steady_clock::now();
  if (action.kind == LoopAction::Kind::kSpindle) {
    tell_("rpm", action.name, 0);
    body_.set_rpm(action.rpm);
    return;
  }
  under_way_ = action;
  undo_->Do(action, tell_);
}

void LoopActions::Act(double now_s, std::vector<std::string>& warnings) {
  std::optional<LoopAction> asked;
  try {
    Poll();
    while ((undo_ == nullptr || undo_->is_idle()) && next_ < planned_.size() && planned_[next_].at_s <= now_s + 1e-9) {
      planned_under_way_ = true;
      Do(planned_[next_++]);
    }
    while (peer_ != nullptr && (undo_ == nullptr || undo_->is_idle()) && (asked = peer_->NextAction())) {
      planned_under_way_ = false;
      Do(*asked);
      if (!under_way_) peer_->Done(*asked, "");
    }
  } catch (const Error& e) {
    const bool of_peer = under_way_ && !planned_under_way_;
    const LoopAction failed = under_way_.value_or(LoopAction{});
    under_way_.reset();
    if (of_peer) {
      peer_->Done(failed, e.what());
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
