// Device whose handle follows prescribed poses, regardless of the force: at rest, along a table of poses, or as in a
// recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kerf/device.h"

namespace kerf {

struct PlayedPose {
  double time_s = 0;
  DeviceSample sample;
};

/// Between two poses, the handle moves linearly and turns uniformly (slerp); it stays at the last one. At the times in
/// the table, the poses are bit-exact. Time advances only in Elapse().
class PlayedDevice final : public Device {
 public:
  /// Throws kerf::Error if there is no pose, a pose is invalid, or the times do not increase.
  PlayedDevice(const DeviceProfile& profile, std::vector<PlayedPose> poses);

  const DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;

  const Vec3& force_N() const { return f_W_N_; }  // last force that was written
  double time_s() const { return time_s_; }

 private:
  DeviceProfile profile_;
  std::vector<PlayedPose> poses_;
  std::size_t next_ = 0;  // index of the first pose that has not been passed yet
  double time_s_ = 0;
  Vec3 f_W_N_{0};
};

}  // namespace kerf
