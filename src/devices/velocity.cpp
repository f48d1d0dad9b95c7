#include "devices/velocity.h"

#include <algorithm>

namespace kerf {

AdaptiveVelocity::AdaptiveVelocity(double quantum_mm, int max_samples)
    : quantum_(quantum_mm), max_samples_(std::clamp(max_samples, 2, kMaxSamples)) {}

void AdaptiveVelocity::Reset() {
  count_ = 0;
  v_ = Vec3{0};
}

Vec3 AdaptiveVelocity::Update(const Vec3& p_mm, double dt_s) {
  if (!std::isfinite(p_mm.x) || !std::isfinite(p_mm.y) || !std::isfinite(p_mm.z)) return v_;
  if (count_ > 0 && !(dt_s > 0)) return v_;
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
  double v = (p0 - p_[at(1)][axis]) / t_[at(1)];
  for (int n = 2; n < count_; ++n) {
    const double slope = (p0 - p_[at(n)][axis]) / t_[at(n)];
    for (int i = 1; i < n; ++i) {
      const double off = p_[at(i)][axis] - (p0 - slope * t_[at(i)]);
      if (!(std::abs(off) <= quantum_)) return v;
    }
    v = slope;
  }
  return v;
}

}  // namespace kerf
