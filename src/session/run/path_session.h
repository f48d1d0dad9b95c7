// A session along a prescribed path, stepped tick by tick. `kerf run`, its slab mode and replays of both step it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/core/percentiles.h"
#include "kerf/path.h"
#include "kerf/simulation.h"
#include "session/run/path_tape.h"
#include "session/scene/path.h"

namespace kerf {

/// What the tool on a path cuts, with everything that is attached to it.
class PathBody {
 public:
  virtual ~PathBody() = default;
  /// Called when the tool is lifted and placed at X_WT. `time_s`: path time.
  virtual void SetDown(const Pose& X_WT, double time_s) = 0;
  /// Runs a tick. Only this call is timed.
  virtual TickOutput Tick(const TickInput& in) = 0;
  /// Returns a hash of all that the ticks have changed so far. Called after each tick, only if there is a tape.
  virtual std::uint64_t TakeHash() = 0;
  /// Called at the end of each tick, which took `tick_us`. May change `record`'s travel_mm and touched.
  virtual void End(TickRecord& record, double dt_s, double tick_us) = 0;
};

/// Steps a body along a path.
class PathSession {
 public:
  /// The tool rotates at `rpm`. `ticks`: expected number, for reserving memory. `body` must outlive this object.
  PathSession(const PathDriver& driver, PathBody& body, double rpm, std::size_t ticks, const PathTape& tape);
  /// Runs the next tick, or places the tool. Returns false, without having done so, at the end of the path or of
  /// the recording that is replayed.
  bool Step();
  /// Runs all steps. `progress` (optional) is called with values from 0 to 1.
  void Run(const std::function<void(double)>& progress);

  const std::vector<TickRecord>& ticks() const { return ticks_; }
  std::vector<TickRecord> TakeTicks() { return std::move(ticks_); }
  /// Returns percentiles of the durations of the ticks.
  Percentiles CalcTimes() const { return CalcPercentiles(times_us_); }
  /// Time since the construction of this object.
  double CalcElapsed_s() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  bool Place(const PathStep& step);
  void Keep(const PathStep& step, TickRecord& record);

  PathDriver driver_;
  PathBody& body_;
  double rpm_;
  std::size_t expected_ticks_;
  PathTape tape_;
  std::vector<TickRecord> ticks_;
  std::vector<double> times_us_;
  Vec3 p_WT_mm_{0};  // position of the tool after the last step
  Clock::time_point began_ = Clock::now();
};

}  // namespace kerf
