// fragments: bone that a cut separates becomes a numbered piece.
#pragma once

#include <atomic>

#include "cut/effects/effect.h"
#include "cut/effects/fragments/watch.h"

namespace kerf {

/// In the tick, the effect only reports the last result. The search itself is done by watch(): the owner of the
/// simulation passes changed leaves to it and starts a search at intervals, on another thread or between ticks.
class FragmentsEffect final : public Effect {
 public:
  FragmentsEffect(const FragmentsParams& params, const EffectSetup& setup);

  void End(EffectEnd& end) override;
  void Report(std::span<double> channels) const override;
  bool reads_teeth() const override { return false; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this) - sizeof(watch_) + watch_.CalcMemoryBytes(); }

  // ---- for one thread at a time, but not the tick thread
  FragmentWatch& watch() { return watch_; }
  const FragmentWatch& watch() const { return watch_; }
  /// Calls FragmentWatch::Look(); the following ticks report the result.
  std::size_t Look(double time_s);

 private:
  void PublishCounts();

  FragmentWatch watch_;
  std::atomic<int> reported_pieces_{0}, reported_crumbs_{0};
  int pieces_ = 0, crumbs_ = 0;  // as reported in the tick
};

}  // namespace kerf
