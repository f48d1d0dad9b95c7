#include "session/run/loop_recorder.h"

#include <algorithm>
#include <cmath>

#include "base/core/hash.h"

namespace kerf {

LoopRecorder::LoopRecorder(const Vec3& p_TC_mm, int every, double ticks, LoopLog log, double dt_s, LoopSummary& summary)
    : p_TC_mm_(p_TC_mm),
      every_(static_cast<std::uint64_t>(std::max(every, 1))),
      keeps_rows_(log == LoopLog::kMemory),
      summary_(summary),
      noise_(dt_s) {
  const std::size_t rows = (static_cast<std::size_t>(ticks) + 64) / every_ + 1;
  summary_.force_curve.Reserve(rows);
  if (!keeps_rows_) return;
  // All memory is reserved at once, because each page is costly in locked memory.
  summary_.rows.reserve(rows);
  summary_.effects.rows.reserve(rows * summary_.effects.figures.size());
}

void LoopRecorder::Drain(HapticLoop& loop) {
  SpscRing<LoopTick>& samples = loop.samples();
  while (const LoopTick* sample = samples.Peek()) {
    const TickToRecord tick = MakeTickToRecord(*sample);
    hash_ = MixHash(hash_ ^ tick.hash);
    if (recording_ != nullptr) Record(*sample, tick);
    if (take_tick_) take_tick_(*sample, loop.channels(popped_));
    Take(*sample, loop.channels(popped_));
    samples.Pop();
    ++popped_;
  }
}

void LoopRecorder::Finish() {
  summary_.force_hash = hash_;
  summary_.force.noise_above_20_Hz_mN = noise_.Finish_mN();
  summary_.force.cutting_noise_mN = noise_.cutting_mN();
  if (!any_) return;
  for (const auto* moment : {&first_, &peak_, &last_}) {
    summary_.moments.push_back((*moment)[0]);
    summary_.moments.push_back((*moment)[1]);
    // Only the position of the preceding tick is used.
    summary_.moments[summary_.moments.size() - 2].out.engaged_teeth = 0;
  }
}

void LoopRecorder::Record(const LoopTick& s, const TickToRecord& tick) {
  if (s.number != next_tick_) recording_->Lose(s.number - next_tick_);
  next_tick_ = s.number + 1;
  recording_->Take(tick);
}

void LoopRecorder::Take(const LoopTick& s, std::span<const double> channels) {
  const CoupledOutput& out = s.coupled;
  // The device held its force during missed ticks.
  for (std::uint32_t k = 0; k < s.in.skipped && k < 10'000; ++k) noise_.Hold();
  noise_.Take(s.force.f_H_W_N, out.engaged_teeth > 0);
  summary_.effect_files.Take(s.time_s, s.time_s - summary_.simulated_s, out.X_WT, channels);
  const double dt_s = s.time_s - summary_.simulated_s;
  const double turns = std::abs(s.in.rpm) / 60 * dt_s;
  summary_.cutting_sums.thrust_J += out.thrust_W * dt_s;
  summary_.cutting_sums.cutting_J += out.cutting_W * dt_s;
  if (out.engaged_teeth > 0) summary_.cutting_sums.cutting_turns += turns;
  summary_.simulated_s = s.time_s;
  summary_.force.largest_simulated_N = std::max(summary_.force.largest_simulated_N, glm::length(out.f_H_W_N));
  summary_.hand_J += 1e-3 * out.hand_mJ;
  summary_.spindle_J += 1e-3 * out.spindle_mJ;
  summary_.stored_J += 1e-3 * out.stored_mJ;
  summary_.cut_J += 1e-3 * out.cut_mJ;
  summary_.friction_J += 1e-3 * out.friction_mJ;
  summary_.damping_J += 1e-3 * out.damping_mJ;
  summary_.numerical_J += 1e-3 * out.numerical_mJ;
  summary_.removed_by_occupancy_mm3 += out.removed_mm3;
  if ((out.status & kCoupledLeavesUsedUp) != 0 && !summary_.leaves_used_up_s) summary_.leaves_used_up_s = s.time_s;
  if ((out.status & kCoupledTouchesMetal) != 0 && !summary_.metal_touched_s) summary_.metal_touched_s = s.time_s;
  X_WT_ = out.X_WT;
  NoteMoments(s);
  removed_mm3_ += out.removed_mm3;
  if (++ticks_ % every_ != 0) {
    summary_.effects.Take(channels);
    return;
  }
  TakeRow(s, channels);
}

void LoopRecorder::TakeRow(const LoopTick& s, std::span<const double> channels) {
  const LoopRow row = MakeLoopRow(s, p_TC_mm_, removed_mm3_);
  removed_mm3_ = 0;
  summary_.force_curve.Add(MakeForcePoint(row));
  if (summary_.force_log) summary_.force_log->Take(row, channels);
  if (!keeps_rows_) return summary_.effects.Take(channels);
  summary_.effects.TakeRow(channels);
  summary_.rows.push_back(row);
}

void LoopRecorder::NoteMoments(const LoopTick& s) {
  const CoupledOutput& out = s.coupled;
  const Vec3 f_W_N = out.f_cut_W_N + out.f_face_W_N + out.f_friction_W_N;
  TickRecord now;
  now.time_s = s.time_s;
  now.X_WT = out.X_WT;
  now.out.engaged_teeth = out.engaged_teeth;
  now.out.f_T_W_N = f_W_N;
  if (!any_) before_ = first_ = peak_ = last_ = {now, now};
  any_ = true;
  const std::array<TickRecord, 2> both{before_[1], now};
  before_ = both;
  summary_.touched = summary_.touched || glm::length(f_W_N) > 0;
  if (out.engaged_teeth <= 0) return;
  if (!engaged_) first_ = both;
  engaged_ = true;
  last_ = both;
  if (glm::length(f_W_N) > peak_N_) {
    peak_N_ = glm::length(f_W_N);
    peak_ = both;
  }
}

}  // namespace kerf
