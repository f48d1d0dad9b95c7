// fragments: bone that a cut separates becomes a numbered piece.
#pragma once

#include <atomic>

#include "cut/effects/effect.h"
#include "cut/effects/fragments/watch.h"

namespace kerf {

/// In the tick it only reports the last result. The search is done by watch(), to which the owner of the simulation
/// passes changed leaves and which it calls at intervals, on another thread or between ticks.
class FragmentsEffect final : public Effect {
 public:
  FragmentsEffect(const FragmentsParams& params, const EffectSetup& setup);

  void End(EffectEnd& end) override;
  void Report(std::span<double> channels) const override;
  bool reads_teeth() const override { return false; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this) - sizeof(watch_) + watch_.CalcMemoryBytes(); }

  // ---- one thread, but not the tick thread
  FragmentWatch& watch() { return watch_; }
  const FragmentWatch& watch() const { return watch_; }
  /// Calls FragmentWatch::Look(); the following ticks report the result.
  std::size_t Look(double time_s);

 private:
  void Tell();

  FragmentWatch watch_;
  std::atomic<int> reported_pieces_{0}, reported_crumbs_{0};
  int pieces_ = 0, crumbs_ = 0;  // as reported in the tick
};

}  // namespace kerf
