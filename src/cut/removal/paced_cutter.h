// Removal that may be delayed for some ticks: this saves time, but the tool is then slightly ahead of its cut.
#pragma once

#include "cut/removal/cutter.h"

namespace kerf {

/// Cuts at once if the interval is one tick. With a longer interval, no point of the tool gets further ahead of the
/// removal than a quarter of a voxel (for a disc thinner than a voxel, a quarter of its thickness), regardless of
/// how many ticks remain.
class PacedCutter {
 public:
  /// `reach_mm`: reach of the tool from its origin. `cutter` must outlive this.
  PacedCutter(Cutter& cutter, const Tool& tool, double reach_mm, double voxel_mm, int interval_ticks);

  /// Must be called before the first Cut() of a tick. Tick-safe.
  void BeginTick() {
    if (waits_) ++ticks_;
  }
  /// Cuts as Cutter::Cut() does, now or later. Bone that could not be cut for lack of leaves stays pending. Tick-safe.
  Cutter::Result Cut(const Pose& X_from, const Pose& X_to, const SlideRange& slide = {});
  /// Performs all pending cuts, up to the current pose X_to of the tool. Tick-safe.
  Cutter::Result Flush(const Pose& X_to);
  bool waits() const { return waits_; }
  /// Discards pending cuts, for a tool that was set down elsewhere.
  void Forget() { waits_ = false; }

 private:
  Cutter* cutter_;
  double reach_mm_;
  double max_mm_;
  int interval_;
  bool waits_ = false;
  int ticks_ = 0;     // since the oldest pending cut
  Pose X_cut_;        // end of the completed removal, while a cut is pending
  SlideRange slide_;  // of the pending cuts
};

}  // namespace kerf
