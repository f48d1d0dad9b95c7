// A device whose handle goes where it was told beforehand, whatever the force: standing still, along a table of poses,
// or as it went in a recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "device/devices/device.h"

namespace kerf {

struct PlayedPose {
  double time_s = 0;
  DeviceSample sample;
};

/// Between two poses it goes straight and turns evenly (slerp); after the last it stays there. At the times of the
/// table the poses are those of the table to the bit. It has no clock: time is what Elapse() says.
class PlayedDevice final : public Device {
 public:
  /// Throws Error when there is no pose, one is not valid, or the times don't rise.
  PlayedDevice(const DeviceProfile& profile, std::vector<PlayedPose> poses);

  const DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;

  const Vec3& force_N() const { return f_W_N_; }  // that it was last told to make
  double time_s() const { return time_s_; }

 private:
  DeviceProfile profile_;
  std::vector<PlayedPose> poses_;
  std::size_t next_ = 0;  // the first that is not yet passed
  double time_s_ = 0;
  Vec3 f_W_N_{0};
};

}  // namespace kerf
