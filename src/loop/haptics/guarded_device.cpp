#include "loop/haptics/guarded_device.h"

#include <algorithm>
#include <thread>

#include "base/core/vectors.h"

namespace kerf {
void GuardedDevice::Elapse(double dt_s) noexcept {
  if (!TryEnter()) {
    ++counts_.skipped;
    return;
  }
  device_.Elapse(dt_s);
  Leave();
}

bool GuardedDevice::Read(DeviceSample& sample) noexcept {
  if (!TryEnter()) {
    ++counts_.skipped;
    sample = last_;
    return true;
  }
  const bool ok = device_.Read(sample);
  Leave();
  if (!IsValid(sample.X_WH)) ++counts_.bad_poses;
  last_ = sample;
  return ok;
}

bool GuardedDevice::Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept {
  Vec3 f_W_N = f_H_W_N;
  Vec3 tau_W_Nmm = tau_H_W_Nmm;
  if (!IsFinite(f_W_N) || !IsFinite(tau_W_Nmm)) {
    ++counts_.not_finite;
    f_W_N = tau_W_Nmm = Vec3{0};
  }
  if (!TryEnter()) {
    ++counts_.skipped;
    // The watchdog is tripping the device. This tick may have called TakeTripped() before that, so the next tick must
    // call it.
    tripped_.store(true);
    return true;
  }
  const bool zero = closed_ || tripped_.load();
  if (zero) f_W_N = tau_W_Nmm = Vec3{0};
  const bool ok = device_.Write(f_W_N, tau_W_Nmm);
  Leave();
  ++counts_.writes;
  counts_.largest_N = std::max(counts_.largest_N, glm::length(f_W_N));
  if (!zero) {
    const Vec3 before = written_ ? f_W_N_ : Vec3{0};
    counts_.largest_step_N = std::max(counts_.largest_step_N, glm::length(f_W_N - before));
  }
  written_ = true;
  f_W_N_ = f_W_N;
  return ok;
}

void GuardedDevice::TakeToolPose(const Pose& X_WT) noexcept {
  if (!TryEnter()) return;  // the next tick has a newer one
  device_.TakeToolPose(X_WT);
  Leave();
}

bool GuardedDevice::Trip() noexcept {
  if (!TryEnter()) return false;
  tripped_.store(true);
  device_.Write(Vec3{0}, Vec3{0});
  Leave();
  return true;
}

bool GuardedDevice::TakeTripped() noexcept {
  if (!tripped_.exchange(false)) return false;
  f_W_N_ = Vec3{0};  // the ramp starts from zero
  return true;
}

void GuardedDevice::Close() noexcept {
  while (!TryEnter()) std::this_thread::yield();
  closed_ = true;
  device_.Write(Vec3{0}, Vec3{0});
  Leave();
}

}  // namespace kerf
