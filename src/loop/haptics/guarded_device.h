// A device between the loop and the watchdog: either may reach it, never both at once, and neither waits for the other
// in a tick.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "device/devices/device.h"

namespace kerf {

/// What was written to a device, counted.
struct ForceCounts {
  double largest_N = 0;
  double largest_step_N = 0;  // between two writes in a row of the loop; what Trip() and Close() zero is not a step
  std::uint64_t writes = 0;
  std::uint64_t passed_over = 0;  // writes or reads that found the watchdog at the device
  std::uint64_t not_finite = 0;   // forces that were not finite: zero was written instead
  std::uint64_t bad_poses = 0;    // samples whose pose was not valid
};

/// Elapse(), Read() and Write() are the loop's, Trip() is the watchdog's. After Trip() the device has zero force, and
/// gets zero from every Write() until the loop has taken note with TakeTripped() and begun its ramp.
class GuardedDevice final : public Device {
 public:
  /// The device must outlive this.
  explicit GuardedDevice(Device& device) : device_(device) {}

  const DeviceProfile& profile() const override { return device_.profile(); }
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;
  /// Whether the device was tripped since it was last asked.
  bool TakeTripped() noexcept;
  /// Zero force, and zero to every Write() from here on. Any thread; waits for the other, so it is not tick-safe.
  void Close() noexcept;
  /// The loop's, or after its end.
  const ForceCounts& counts() const { return counts_; }

  /// Makes the force zero. False when the loop is in the middle of a call to the device: try again. Any thread.
  bool Trip() noexcept;

 private:
  bool TryEnter() noexcept { return !busy_.test_and_set(std::memory_order_acquire); }
  void Leave() noexcept { busy_.clear(std::memory_order_release); }

  Device& device_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
  std::atomic<bool> tripped_{false};
  bool closed_ = false;
  bool written_ = false;
  Vec3 f_W_N_{0};
  DeviceSample last_;
  ForceCounts counts_;
};

}  // namespace kerf
