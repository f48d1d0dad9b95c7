// Reads the log of a running loop: sums it up, keeps or writes its rows, and passes it to a recording.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "loop/haptics/haptic_loop.h"
#include "session/run/force_noise.h"
#include "session/run/run_loop.h"
#include "session/run/session_recorder.h"

namespace kerf {

/// Call in the reader's thread.
class LoopRecorder {
 public:
  /// Writes into `summary`, which must outlive this object. `p_TC_mm`: the coupling's point in the tool frame. `every`:
  /// ticks per row. `ticks`: expected number of ticks. `dt_s`: period of the loop.
  LoopRecorder(const Vec3& p_TC_mm, int every, double ticks, LoopLog log, double dt_s, LoopSummary& summary);

  void set_recording(SessionRecorder* recording) { recording_ = recording; }
  void set_take_tick(const TakeTick& take_tick) { take_tick_ = take_tick; }
  /// Returns the last pose of the tool; none before the first tick.
  const std::optional<Pose>& X_WT() const { return X_WT_; }

  /// Takes all samples that the loop has logged so far.
  void Drain(HapticLoop& loop);
  /// Completes the summary. Call once, after the last Drain().
  void Finish();

 private:
  void Record(const LoopTick& s, const TickToRecord& tick);
  void Take(const LoopTick& s, std::span<const double> channels);
  void TakeRow(const LoopTick& s, std::span<const double> channels);
  void NoteMoments(const LoopTick& s);

  SessionRecorder* recording_ = nullptr;
  TakeTick take_tick_;
  std::uint64_t next_tick_ = 1;
  std::optional<Pose> X_WT_;
  Vec3 p_TC_mm_;
  std::uint64_t every_;
  bool keeps_rows_;
  LoopSummary& summary_;
  ForceNoise noise_;  // of the force on the device at every deadline
  std::uint64_t ticks_ = 0;
  std::uint64_t popped_ = 0;
  std::uint64_t hash_ = 0;
  bool any_ = false;
  bool engaged_ = false;
  double peak_N_ = 0;
  std::array<TickRecord, 2> before_, first_, peak_, last_;  // each with the tick before it
  double removed_mm3_ = 0;
};

}  // namespace kerf
