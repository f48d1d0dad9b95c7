// Checks the events of a recording against its steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/recording.h"

namespace kerf {

/// First difference between a replay and its recording.
struct Divergence {
  std::uint64_t step = 0;  // first step that differs
  double time_s = 0;       // time at its end
  std::string what;        // end of a sentence: "the force on the hand or the tool's pose"
};

/// Checks that each checkpoint, undo, redo and continuation in a step was announced by an event of the same kind and
/// number, in the same order, and that each event has the time of its step. An announced undo or redo may be missing
/// among the steps if it could not be carried out.
class EventCheck {
 public:
  /// `recording` must outlive this object.
  explicit EventCheck(const RecordingReader& recording);

  /// Call before each step, in order, with its number and the time before it. Returns the end of a sentence that
  /// describes an error, otherwise "".
  std::string Take(const RecordedStep& step, std::uint64_t number, double time_s);

 private:
  std::string Announce(const RecordedEvent& event, std::uint64_t number, double time_s);
  std::string Match(const char* what, const RecordedStep& step);

  const std::vector<RecordedEvent>& events_;
  bool may_lack_some_;  // true if blocks are missing
  std::size_t next_ = 0;
  std::vector<const RecordedEvent*> announced_;  // not yet found among the steps
  std::map<std::uint32_t, std::string> names_;   // names of checkpoints, by number
};

}  // namespace kerf
