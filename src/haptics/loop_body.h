// What the loop does each time round, seen from the loop.
#pragma once

#include <cstddef>
#include <span>

#include "kerf/coupled.h"

namespace kerf {

/// A tick, when it is over.
struct LoopTick {
  Pose X_WH;           // handle, as read
  Vec3 f_device_N{0};  // that the device was told to make
  CoupledOutput out;
};

/// All calls but the constructor's are made in the loop's thread: tick-safe, every one.
class LoopBody {
 public:
  virtual ~LoopBody() = default;

  /// Reads the device, moves the world on by `dt_s`, writes the device. False: the device has failed; the loop ends.
  virtual bool Tick(double dt_s, TickObserver& observer, LoopTick& report) = 0;
  /// Figures of a tick beside its report: how many, always as many; and those of the last tick.
  virtual std::size_t channel_count() const { return 0; }
  virtual void ReportChannels(std::span<double>) const {}
  /// The device's force has been zero: it comes back slowly from here on.
  virtual void RampIn() = 0;
  /// Takes effect over the next ticks without a step in the force.
  virtual void SetFidelity(Fidelity fidelity) = 0;

  /// As CoupledSimulation's.
  virtual int changed_count() const = 0;
  virtual ChangedLeaf changed(int i) const = 0;
  virtual void ClearChanged() = 0;
};

}  // namespace kerf
