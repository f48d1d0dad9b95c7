// A device that the loop and the watchdog share. Only one of them accesses it at a time, and neither waits for the
// other in a tick.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "kerf/device.h"

namespace kerf {

/// Statistics of the forces that were written to a device.
struct ForceCounts {
  double largest_N = 0;
  double largest_step_N = 0;  // between consecutive writes of the loop; zeroing by Trip() or Close() does not count
  std::uint64_t writes = 0;
  std::uint64_t skipped = 0;     // reads and writes skipped while the watchdog used the device
  std::uint64_t not_finite = 0;  // number of forces that were not finite and were replaced by zero
  std::uint64_t bad_poses = 0;   // number of samples with an invalid pose
};

/// Device that the watchdog can set to zero force. The loop calls the functions of a Device; the watchdog calls
/// Trip(). After Trip() the device has zero force, and every Write() writes zero until the loop has called
/// TakeTripped() and started its ramp.
class GuardedDevice final : public Device {
 public:
  /// `device` must outlive this object.
  explicit GuardedDevice(Device& device) : device_(device) {}

  const DeviceProfile& profile() const override { return device_.profile(); }
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;
  void TakeToolPose(const Pose& X_WT) noexcept override;
  /// Returns true if the device was tripped since the last call.
  bool TakeTripped() noexcept;
  /// Sets the force to zero; every later Write() writes zero. May be called by any thread. Waits for the other thread,
  /// so it is not tick-safe.
  void Close() noexcept;
  /// Call in the loop thread, or after the loop has ended.
  const ForceCounts& counts() const { return counts_; }

  /// Sets the force to zero. Returns false if the loop is calling the device; the caller must then try again. May be
  /// called by any thread.
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
