// Reading a recording: its origin, the inputs of its ticks, and its replay.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "kerf/run.h"
#include "kerf/scene.h"

namespace kerf {

/// Inputs of a tick.
struct RecordedInput {
  double time_s = 0;  // at the end of the tick
  Pose X;             // with the tool in a hand: of the handle; along a path: of the tool at the end of the tick
  double dt_s = 0;
  double rpm = 0;
  std::uint32_t buttons = 0;
  bool set_down = false;  // no tick: the tool was placed at X
};

/// A named moment, such as a "checkpoint" named "before the second cut".
struct RecordedMoment {
  double time_s = 0;
  std::string what;
  std::string name;
};

/// A recording. Of a damaged or incomplete one, everything that can be read is used.
class Recording {
 public:
  /// Throws kerf::Error if the file is not a recording or its header is invalid.
  explicit Recording(const std::string& path);
  ~Recording();
  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) noexcept;

  /// "run" along a path, "slab" in slab mode, or "loop" with the tool in a hand.
  std::string kind() const;
  std::string created() const;  // UTC, "2026-11-26T08:30:00Z"
  std::string version() const;  // of kerf, with its commit
  double rate_hz() const;
  double duration_s() const;
  std::uint64_t ticks() const;  // that can be read
  std::string damage() const;   // one sentence; empty if the recording is whole
  std::vector<RecordedMoment> moments() const;
  /// Returns the scene with all its settings.
  SceneFile scene() const;
  /// Reads the inputs of all ticks. Throws kerf::Error if a part is invalid.
  std::vector<RecordedInput> ReadInputs();

  /// Runs the recorded session again and compares it with the recording, tick by tick: `difference` of the result is
  /// set where they first differ. The recording must be of the kind that the function names. Throws kerf::Error.
  PathRun ReplayPath(const ShowProgress& progress = {});
  HandRun ReplayHand(const ShowProgress& progress = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
