#include "device/devices/velocity.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace kerf {

AdaptiveVelocity::AdaptiveVelocity(double quantum_mm, int max_samples, double reach_mm)
    : quantum_(quantum_mm), max_samples_(std::clamp(max_samples, 2, kMaxSamples)), reach_(reach_mm) {}

void AdaptiveVelocity::Reset() {
  count_ = 0;
  repeated_s_ = 0;
  v_ = Vec3{0};
}

Vec3 AdaptiveVelocity::Update(const Vec3& p_mm, double dt_s) {
  if (!std::isfinite(p_mm.x) || !std::isfinite(p_mm.y) || !std::isfinite(p_mm.z)) return v_;
  if (count_ > 0 && (!(dt_s > 0) || !std::isfinite(dt_s))) return v_;
  if (count_ > 1) {
    const Vec3 step = p_mm - p_[static_cast<std::size_t>(newest_)];
    const double speed = glm::length(v_);
    const double stop = kMinStop_mm_per_s2 / reach_ * dt_s;
    const bool frozen = repeated_s_ > kLongestRepeat_s;
    if (step == Vec3{0} && (frozen || (speed * dt_s > 2 * quantum_ && speed > stop))) {
      repeated_s_ += dt_s;
      if (repeated_s_ > kLongestRepeat_s) v_ = Vec3{0};
      return v_;
    }
    dt_s += repeated_s_;
    // The step and its prediction each depend on two samples, and each sample is accurate to one quantum per axis.
    const double max_change = kMaxAcceleration_mm_per_s2 / reach_ * dt_s * dt_s + 4 * quantum_;
    if (frozen || glm::length(step - v_ * dt_s) > max_change) count_ = 0;
  }
  repeated_s_ = 0;
  for (double& t : t_) t += dt_s;
  newest_ = (newest_ + 1) % kMaxSamples;
  p_[static_cast<std::size_t>(newest_)] = p_mm;
  t_[static_cast<std::size_t>(newest_)] = 0;
  count_ = std::min(count_ + 1, max_samples_);
  const Vec3 v = count_ < 2 ? Vec3{0} : Vec3{CalcAxis(0), CalcAxis(1), CalcAxis(2)};
  if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) v_ = v;
  return v_;
}

double AdaptiveVelocity::CalcAxis(int axis) const {
  const auto at = [this](int back) { return static_cast<std::size_t>((newest_ + kMaxSamples - back) % kMaxSamples); };
  const double p0 = p_[at(0)][axis];
  int last = 1;
  bool straight = true;
  for (int n = 2; n < count_ && straight; ++n) {
    const double slope = (p0 - p_[at(n)][axis]) / t_[at(n)];
    for (int i = 1; i < n && straight; ++i) {
      straight = std::abs(p_[at(i)][axis] - (p0 - slope * t_[at(i)])) <= quantum_;
    }
    if (straight) last = n;
  }
  // Least-squares line.
  double t = 0, p = 0, tt = 0, tp = 0;
  for (int i = 0; i <= last; ++i) {
    t += t_[at(i)];
    p += p_[at(i)][axis] - p0;
  }
  t /= last + 1;
  p /= last + 1;
  for (int i = 0; i <= last; ++i) {
    tt += (t_[at(i)] - t) * (t_[at(i)] - t);
    tp += (t_[at(i)] - t) * (p_[at(i)][axis] - p0 - p);
  }
  return -tp / tt;
}

}  // namespace kerf
