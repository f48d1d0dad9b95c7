// Work that the loop does in each tick, as an interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/devices/device.h"
#include "kerf/coupled.h"
#include "loop/haptics/restore_exchange.h"

namespace kerf {

/// Inputs of a tick. The same inputs reproduce the tick bit for bit.
struct TickInputs {
  DeviceSample sample;  // as read
  bool read = true;     // false: the device returned no pose
  bool wrote = true;    // false: the device did not accept the force
  bool force_off = false;
  double dt_s = 0;
  std::uint32_t skipped = 0;  // number of deadlines missed before this tick
  double rpm = 0;
  Fidelity fidelity = Fidelity::kFull;  // requested fidelity
  std::uint32_t piece = 0;              // number of the piece that began to leave the bone after this tick; 0: none
  bool taken_up = false;  // this body continues a session that another body began, and this is its first tick
  RestoreEvent restore;   // checkpoint made, or restore begun, before this tick
};

/// Result of a tick.
struct LoopTick {
  TickInputs inputs;
  std::uint64_t voxel_hash = 0;  // hash of all changed voxels (bone/grid/changed_hash.h); 0 if not requested
  Pose X_WH;                     // handle, as read
  Vec3 f_device_N{0};            // force that was written to the device
  CoupledOutput out;
  bool stands = false;  // bone is being restored, so the simulation did not advance
};

/// Body of the loop. All functions except the constructor are called in the loop thread and must be tick-safe.
class LoopBody {
 public:
  virtual ~LoopBody() = default;

  /// Reads the device, advances the simulation by `dt_s` and writes to the device. Returns false if the device has
  /// failed; the loop then ends.
  virtual bool Tick(double dt_s, TickObserver& observer, LoopTick& report) = 0;
  /// Values of a tick in addition to its report. Their number is constant; ReportChannels() outputs those of the last
  /// tick.
  virtual std::size_t channel_count() const { return 0; }
  virtual void ReportChannels(std::span<double>) const {}
  /// Called after the device's force has been zero: the force is ramped in from now on.
  virtual void RampIn() = 0;
  /// Sets the fidelity. The change takes effect gradually over the next ticks, so that the force does not jump.
  virtual void SetFidelity(Fidelity fidelity) = 0;

  /// These functions are as in CoupledSimulation.
  virtual int changed_count() const = 0;
  virtual ChangedLeaf changed(int i) const = 0;
  virtual void ClearChanged() = 0;
};

}  // namespace kerf
