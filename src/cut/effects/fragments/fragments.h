// fragments: what the cut takes off becomes a piece with a number.
#pragma once

#include <atomic>

#include "cut/effects/effect.h"
#include "cut/effects/fragments/watch.h"

namespace kerf {

/// In the tick it only passes on what was found. Finding is the work of watch(), which whoever runs the simulation
/// feeds with its changed leaves and asks now and then, on another thread or between ticks.
class FragmentsEffect final : public Effect {
 public:
  FragmentsEffect(const FragmentsParams& params, const EffectSetup& setup);

  void End(EffectEnd& end) override;
  void Report(std::span<double> channels) const override;
  bool reads_teeth() const override { return false; }
  std::size_t CalcMemoryBytes() const override { return sizeof(*this) - sizeof(watch_) + watch_.CalcMemoryBytes(); }

  // ---- one thread, not the tick's
  FragmentWatch& watch() { return watch_; }
  const FragmentWatch& watch() const { return watch_; }
  /// FragmentWatch::Look(); the ticks from now on report it.
  std::size_t Look(double time_s);

 private:
  void Tell();

  FragmentWatch watch_;
  std::atomic<int> told_pieces_{0}, told_crumbs_{0};
  int pieces_ = 0, crumbs_ = 0;  // as reported
};

}  // namespace kerf
