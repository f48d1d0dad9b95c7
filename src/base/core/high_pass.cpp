#include "base/core/high_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

FilterSection MakeHighPass(double dt_s, double cutoff_Hz) {
  const double k = std::tan(std::numbers::pi * cutoff_Hz * dt_s);
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  return {norm, -2 * norm, norm, 2 * (k * k - 1) * norm, (1 - std::numbers::sqrt2 * k + k * k) * norm};
}

void Run(FilterSection section, std::vector<double>& x) {
  section.Begin(x.front());
  for (double& value : x) value = section.Run(value);
}

void CheckBand(double dt_s, double cutoff_Hz) {
  if (!(dt_s > 0) || !(cutoff_Hz > 0) || !(cutoff_Hz * dt_s < 0.5)) {
    throw Error(fmt::format(
        "a high-pass at {} Hz of samples every {} s: the frequency must be above 0 and below half the sampling rate",
        cutoff_Hz, dt_s));
  }
}

/// Number of samples after which the initial state has decayed to exp(-22).
std::size_t CountSettling(double dt_s, double cutoff_Hz) {
  return static_cast<std::size_t>(5 / (cutoff_Hz * dt_s)) + 1;
}

constexpr std::size_t kBlock = 4096;

}  // namespace

double CalcHighPassRms(std::span<const double> x, double dt_s, double cutoff_Hz) {
  CheckBand(dt_s, cutoff_Hz);
  const std::size_t n = x.size();
  if (n < 3) return 0;
  const std::size_t pad = std::min(n - 1, CountSettling(dt_s, cutoff_Hz));
  std::vector<double> y;
  y.reserve(n + 2 * pad);
  for (std::size_t i = pad; i > 0; --i) y.push_back(2 * x[0] - x[i]);
  y.insert(y.end(), x.begin(), x.end());
  for (std::size_t i = 1; i <= pad; ++i) y.push_back(2 * x[n - 1] - x[n - 1 - i]);

  const FilterSection section = MakeHighPass(dt_s, cutoff_Hz);
  Run(section, y);
  std::reverse(y.begin(), y.end());
  Run(section, y);
  double sum = 0;
  for (std::size_t i = pad; i < pad + n; ++i) sum += y[i] * y[i];
  return std::sqrt(sum / static_cast<double>(n));
}

void FilterSection::Begin(double first) {
  z1 = -b0 * first;
  z2 = b2 * first;
}

double FilterSection::Run(double in) {
  const double out = b0 * in + z1;
  z1 = b1 * in - a1 * out + z2;
  z2 = b2 * in - a2 * out;
  return out;
}

HighPassRms::HighPassRms(double dt_s, double cutoff_Hz) : dt_s_(dt_s), cutoff_Hz_(cutoff_Hz) {
  CheckBand(dt_s, cutoff_Hz);
  settle_ = CountSettling(dt_s, cutoff_Hz);
  section_ = MakeHighPass(dt_s, cutoff_Hz);
  head_.reserve(settle_ + 1);
  tail_.resize(settle_ + 1);
  forward_.reserve(kBlock + 3 * settle_);
}

void HighPassRms::Add(double x) {
  tail_[count_++ % tail_.size()] = x;
  if (count_ > settle_ + 1) return Forward(x);
  head_.push_back(x);
  if (count_ < settle_ + 1) return;
  const double first = 2 * head_[0] - head_[settle_];
  section_.Begin(first);
  skip_ = settle_;
  for (std::size_t i = settle_; i > 0; --i) Forward(2 * head_[0] - head_[i]);
  for (const double value : head_) Forward(value);
}

void HighPassRms::Forward(double x) {
  forward_.push_back(section_.Run(x));
  // Wait for twice the settling time, in which the initial state decays to exp(-44), less than rounding.
  if (forward_.size() < skip_ + kBlock + 2 * settle_) return;
  Backward(skip_, skip_ + kBlock);
  forward_.erase(forward_.begin(), forward_.begin() + static_cast<std::ptrdiff_t>(skip_ + kBlock));
  skip_ = 0;
}

/// Filters backwards from the newest value to `first`, and sums the squares of those before `last`.
void HighPassRms::Backward(std::size_t first, std::size_t last) {
  FilterSection back = section_;
  back.Begin(forward_.back());
  for (std::size_t i = forward_.size(); i > first; --i) {
    const double y = back.Run(forward_[i - 1]);
    if (i <= last) sum_ += y * y;
  }
}

double HighPassRms::Finish() {
  if (count_ <= settle_ + 1) return CalcHighPassRms(std::span(tail_).first(count_), dt_s_, cutoff_Hz_);
  const auto from_end = [this](std::size_t i) { return tail_[(count_ - 1 - i) % tail_.size()]; };
  const std::size_t pad = settle_;
  const double last = from_end(0);
  for (std::size_t i = 1; i <= pad; ++i) forward_.push_back(section_.Run(2 * last - from_end(i)));
  Backward(skip_, forward_.size() - pad);
  return std::sqrt(sum_ / static_cast<double>(count_));
}

}  // namespace kerf
