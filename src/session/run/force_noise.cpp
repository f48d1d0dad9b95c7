#include "session/run/force_noise.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kNoiseFrom_Hz = 20;

}  // namespace

ForceNoise::ForceNoise(double dt_s)
    : dt_s_(dt_s),
      window_(static_cast<std::size_t>(std::lround(1 / dt_s))),
      run_axes_{HighPassRms(dt_s, kNoiseFrom_Hz), HighPassRms(dt_s, kNoiseFrom_Hz), HighPassRms(dt_s, kNoiseFrom_Hz)} {
  for (auto& axis : second_axes_) axis.reserve(window_);
}

void ForceNoise::Take(const Vec3& f_N, bool cuts) {
  last_N_ = f_N;
  cut_ = cuts;
  all_cut_ = all_cut_ && cuts;
  for (int axis = 0; axis < 3; ++axis) {
    run_axes_[static_cast<std::size_t>(axis)].Add(f_N[axis]);
    second_axes_[static_cast<std::size_t>(axis)].push_back(f_N[axis]);
  }
  if (second_axes_[0].size() < window_) return;
  if (all_cut_) {
    double square = 0;
    for (const auto& axis : second_axes_) square += std::pow(CalcHighPassRms(axis, dt_s_, kNoiseFrom_Hz), 2);
    cutting_mN_ = std::max(cutting_mN_.value_or(0), 1000 * std::sqrt(square));
  }
  for (auto& axis : second_axes_) axis.clear();
  all_cut_ = true;
}

double ForceNoise::Finish_mN() {
  double square = 0;
  for (HighPassRms& axis : run_axes_) square += std::pow(axis.Finish(), 2);
  return 1000 * std::sqrt(square);
}

}  // namespace kerf
