#include "session/run/event_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace kerf {
namespace {

constexpr std::array<std::string_view, 6> kKinds{"checkpoint", "undo", "redo", "taken up", "rpm", "retract"};

std::string Name(const RecordedEvent& event) {
  return fmt::format("the event \"{}{}{}\" at {:.3f} s", event.what, event.name.empty() ? "" : " ", event.name,
                     event.time_s);
}

}  // namespace

EventCheck::EventCheck(const RecordingReader& recording)
    : events_(recording.events()), may_lack_some_(recording.damage().lost_blocks > 0) {
  names_[0] = "start";
}

std::string EventCheck::Take(const RecordedStep& step, std::uint64_t number, double time_s) {
  std::string wrong;
  while (wrong.empty() && next_ < events_.size() && events_[next_].step <= number) {
    wrong = Announce(events_[next_++], number, time_s);
  }
  if (wrong.empty() && (step.flags & kRecordedTakenUp) != 0) wrong = Match("taken up", step);
  if (wrong.empty() && (step.flags & kRecordedCheckpoint) != 0) wrong = Match("checkpoint", step);
  if (wrong.empty() && (step.flags & kRecordedUndo) != 0) wrong = Match("undo", step);
  if (wrong.empty() && (step.flags & kRecordedRedo) != 0) wrong = Match("redo", step);
  return wrong;
}

std::string EventCheck::Announce(const RecordedEvent& event, std::uint64_t number, double time_s) {
  if (std::find(kKinds.begin(), kKinds.end(), event.what) == kKinds.end()) {
    return fmt::format("{} has an unknown kind", Name(event));
  }
  if (event.step != number) return fmt::format("{} is out of order", Name(event));
  // Compare exactly: both times are sums of the same numbers in the same order.
  if (event.time_s != time_s) return fmt::format("{} belongs to {:.6f} s according to its step", Name(event), time_s);
  if (event.what == "checkpoint") names_[event.number] = event.name;
  if (event.what == "undo" && !event.name.empty() && !may_lack_some_) {
    const auto it = names_.find(event.number);
    if (it == names_.end() || it->second != event.name) {
      return fmt::format("{} restores checkpoint {}, which has another name", Name(event), event.number);
    }
  }
  if (event.what != "rpm" && event.what != "retract") announced_.push_back(&event);
  return "";
}

std::string EventCheck::Match(const char* what, const RecordedStep& step) {
  while (!announced_.empty()) {
    const RecordedEvent& event = *announced_.front();
    if (event.what != what && (event.what == "checkpoint" || event.what == "taken up")) {
      return fmt::format("{} has no step: a step of \"{}\" follows instead", Name(event), what);
    }
    announced_.erase(announced_.begin());
    if (event.what != what) continue;
    // An unnamed undo may have been retried after further cutting, with another checkpoint.
    const bool is_free = event.what == "taken up" || (event.what == "undo" && event.name.empty());
    if (is_free || event.number == step.checkpoint) return "";
    return fmt::format("{} has checkpoint {}, but its step has {}", Name(event), event.number, step.checkpoint);
  }
  if (may_lack_some_) return "";
  return fmt::format("a step has \"{}\" of checkpoint {}, for which there is no event", what, step.checkpoint);
}

}  // namespace kerf
