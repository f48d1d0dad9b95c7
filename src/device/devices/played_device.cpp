#include "device/devices/played_device.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "kerf/error.h"

namespace kerf {
namespace {

// Tolerance for a time that is the sum of many steps.
constexpr double kSameTime_s = 1e-9;

}  // namespace

PlayedDevice::PlayedDevice(const DeviceProfile& profile, std::vector<PlayedPose> poses)
    : profile_(profile), poses_(std::move(poses)) {
  if (poses_.empty()) throw Error("a played device needs at least one pose");
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const PlayedPose& pose = poses_[i];
    if (!IsValid(pose.sample.X_WH) || !std::isfinite(pose.time_s)) {
      throw Error(fmt::format("pose {} of the played device is not valid", i + 1));
    }
    if (i > 0 && !(pose.time_s > poses_[i - 1].time_s)) {
      throw Error(fmt::format("pose {} of the played device is not later than the one before", i + 1));
    }
  }
}

void PlayedDevice::Elapse(double dt_s) noexcept {
  if (dt_s > 0 && std::isfinite(dt_s)) time_s_ += dt_s;
  while (next_ < poses_.size() && poses_[next_].time_s <= time_s_ + kSameTime_s) ++next_;
}

bool PlayedDevice::Read(DeviceSample& sample) noexcept {
  if (next_ == 0) {
    sample = poses_.front().sample;
    return true;
  }
  const PlayedPose& from = poses_[next_ - 1];
  sample = from.sample;
  if (next_ == poses_.size() || time_s_ <= from.time_s + kSameTime_s) return true;
  const PlayedPose& to = poses_[next_];
  const double fraction = (time_s_ - from.time_s) / (to.time_s - from.time_s);
  sample.X_WH.p_AB += fraction * (to.sample.X_WH.p_AB - from.sample.X_WH.p_AB);
  sample.X_WH.R_AB = glm::normalize(glm::slerp(from.sample.X_WH.R_AB, to.sample.X_WH.R_AB, fraction));
  return true;
}

bool PlayedDevice::Write(const Vec3& f_H_W_N, const Vec3& /*tau_H_W_Nmm*/) noexcept {
  f_W_N_ = f_H_W_N;
  return true;
}

}  // namespace kerf
