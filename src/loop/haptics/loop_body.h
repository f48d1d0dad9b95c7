// What the loop does each time round, seen from the loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/devices/device.h"
#include "kerf/coupled.h"
#include "loop/haptics/restore_exchange.h"

namespace kerf {

/// What a tick was given: the same again gives the same tick, to the bit.
struct LoopGiven {
  DeviceSample sample;  // as read
  bool read = true;     // false: the device told no pose
  bool wrote = true;    // false: it did not take the force
  bool force_off = false;
  double dt_s = 0;
  std::uint32_t skipped = 0;  // deadlines missed before it
  double rpm = 0;
  Fidelity fidelity = Fidelity::kFull;  // asked for
  std::uint32_t piece = 0;              // its number, if it began to leave the bone after this tick
  bool taken_up = false;                // the first tick after another body's
  RestoreEvent restore;                 // a checkpoint made, or a restore begun, before this tick
};

/// A tick, when it is over.
struct LoopTick {
  LoopGiven given;
  std::uint64_t voxel_hash = 0;  // of all that have changed (bone/changed_hash.h); 0 when nobody asked for it
  Pose X_WH;                     // handle, as read
  Vec3 f_device_N{0};            // that the device was told to make
  CoupledOutput out;
  bool stands = false;  // bone is put back: the simulation was not ticked
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
