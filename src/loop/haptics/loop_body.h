// Work that the loop does in each tick, as an interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "loop/haptics/haptic_step.h"

namespace kerf {

/// A tick of the loop: the log, the recording and the window read it. The loop sets what is not in HapticTick, except
/// `stands`, `held` and `voxel_hash`, which the body sets.
struct LoopTick : HapticTick {
  std::uint64_t number = 0;  // starting at 1; a gap means lost ticks
  double time_s = 0;         // deadline of the tick, seconds since the start of the loop
  float tick_us = 0;
  float late_us = 0;
  bool stands = false;           // bone is being restored, so the simulation did not advance
  bool held = true;              // false: the hand has let go of the tool; not recorded
  std::uint64_t voxel_hash = 0;  // hash of all changed voxels (bone/grid/changed_hash.h); 0 if not requested
};

/// Body of the loop. All functions except the constructor are called in the loop thread and must be tick-safe.
class LoopBody {
 public:
  virtual ~LoopBody() = default;

  /// Reads the device, advances the simulation by `dt_s` and writes to the device. Returns false if the device has
  /// failed; the loop then ends.
  virtual bool Tick(double dt_s, TickObserver& observer, LoopTick& tick) = 0;
  /// Values of a tick in addition to `tick`. Their number is constant; ReportChannels() outputs those of the last
  /// tick.
  virtual std::size_t channel_count() const { return 0; }
  virtual void ReportChannels(std::span<double>) const {}
  /// Called after the device's force has been zero: the force is ramped in from now on.
  virtual void RampIn() = 0;
  /// Sets the fidelity. The change takes effect gradually over the next ticks, so that the force does not jump.
  virtual void SetFidelity(Fidelity fidelity) = 0;

  /// These functions are as in CoupledSimulation. ClearChanged() removes the first leaves from the list.
  virtual int changed_count() const = 0;
  virtual ChangedLeaf changed(int i) const = 0;
  virtual void ClearChanged(int first) = 0;
};

}  // namespace kerf
