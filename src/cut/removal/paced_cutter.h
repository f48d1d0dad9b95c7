// Removal that may wait for some ticks, to save time at the price of a tool that is a little ahead of its cut.
#pragma once

#include "cut/removal/cutter.h"

namespace kerf {

/// Cuts at once with an interval of one tick. With a longer one the tool may get as far as a quarter voxel ahead of
/// what is removed (at any of its points; of a disc thinner than a voxel, a quarter of that), however many ticks are
/// left.
class PacedCutter {
 public:
  /// `reach_mm`: of the tool from its origin. The cutter must outlive this.
  PacedCutter(Cutter& cutter, const Tool& tool, double reach_mm, double voxel_mm, int interval_ticks);

  /// Before the first Cut() of a tick. Tick-safe.
  void BeginTick() {
    if (waits_) ++ticks_;
  }
  /// As Cutter::Cut(), now or later. What could not be cut for want of leaves waits on. Tick-safe.
  Cutter::Result Cut(const Pose& X_from, const Pose& X_to);
  /// Cuts what waits, up to X_to, where the tool is. Tick-safe.
  Cutter::Result Flush(const Pose& X_to);
  bool waits() const { return waits_; }
  /// What waits is not cut: the tool was set down elsewhere.
  void Forget() { waits_ = false; }

 private:
  Cutter* cutter_;
  double reach_mm_;
  double most_mm_;
  int interval_;
  bool waits_ = false;
  int ticks_ = 0;  // since the oldest of what waits
  Pose X_cut_;     // so far it is cut, while something waits
};

}  // namespace kerf
