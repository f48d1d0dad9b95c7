// The events of a recording held against its steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/recording.h"

namespace kerf {

/// Where what comes out is not what was recorded.
struct Divergence {
  std::uint64_t step = 0;  // the first
  double time_s = 0;       // at its end
  std::string what;        // a sentence's end: "the force on the hand or the tool's pose"
};

/// Each checkpoint, undo, redo and taking up that a step has must have been announced by an event of that kind and
/// number, in the same order; and each event must stand at the time of its step. An undo or redo that was announced may
/// be missing among the steps: it could not be done.
class EventCheck {
 public:
  /// The recording must outlive it.
  explicit EventCheck(const RecordingReader& recording);

  /// Before each step, in order: its number and the time before it. What is wrong, as a sentence's end; else empty.
  std::string Take(const RecordedStep& step, std::uint64_t number, double time_s);

 private:
  std::string Announce(const RecordedEvent& event, std::uint64_t number, double time_s);
  std::string Match(const char* what, const RecordedStep& step);

  const std::vector<RecordedEvent>& events_;
  bool may_lack_some_;  // blocks are missing
  std::size_t next_ = 0;
  std::vector<const RecordedEvent*> announced_;  // and not yet found among the steps
  std::map<std::uint32_t, std::string> names_;   // of checkpoints
};

}  // namespace kerf
