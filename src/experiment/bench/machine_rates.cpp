// This file is compiled once for each vector instruction set.
#include "experiment/bench/machine_rates.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "experiment/bench/measure.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "experiment/bench/machine_rates.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 8>;    // as in removal
using Doubles = hn::CappedTag<double, 8>;  // as in contact
constexpr std::size_t kChains = 8;         // enough to hide the latency of an operation

template <typename Tag>
double SumOf(Tag tag, const hn::Vec<Tag> (&chains)[kChains]) {
  double sum = 0;
  for (const auto& chain : chains) sum += static_cast<double>(hn::GetLane(hn::SumOfLanes(tag, chain)));
  return sum;
}

/// Returns the sum of the values; `count`: a multiple of 64.
double Read(const float* values, std::size_t count) {
  constexpr Floats kTag;
  constexpr std::size_t kLanes = hn::MaxLanes(kTag);
  hn::Vec<Floats> chains[kChains];
  for (auto& chain : chains) chain = hn::Zero(kTag);
  for (std::size_t i = 0; i < count; i += kChains * kLanes) {
    for (std::size_t k = 0; k < kChains; ++k) {
      chains[k] = hn::Add(chains[k], hn::LoadU(kTag, values + i + k * kLanes));
    }
  }
  return SumOf(kTag, chains);
}

/// Does `rounds` multiplications and as many additions in each lane of each chain. Sets `operations` to their number.
template <typename Tag>
double Compute(Tag tag, std::size_t rounds, double& operations) {
  using T = hn::TFromD<Tag>;
  hn::Vec<Tag> chains[kChains];
  for (std::size_t k = 0; k < kChains; ++k) chains[k] = hn::Set(tag, static_cast<T>(k));
  const auto factor = hn::Set(tag, static_cast<T>(0.5));
  const auto term = hn::Set(tag, static_cast<T>(1));
  for (std::size_t i = 0; i < rounds; ++i) {
    for (auto& chain : chains) chain = hn::Add(hn::Mul(chain, factor), term);
  }
  operations = 2.0 * static_cast<double>(rounds * kChains * hn::MaxLanes(tag));
  return SumOf(tag, chains);
}
double ComputeFloats(std::size_t rounds, double& operations) {
  return Compute(Floats(), rounds, operations);
}
double ComputeDoubles(std::size_t rounds, double& operations) {
  return Compute(Doubles(), rounds, operations);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(Read);
HWY_EXPORT(ComputeFloats);
HWY_EXPORT(ComputeDoubles);

/// Returns the time of the fastest of a few repetitions, s.
template <typename Work>
double TimeFastest_s(Work&& work) {
  constexpr int kRepeats = 3;
  double least_us = 1e12;
  for (int i = 0; i < kRepeats; ++i) least_us = std::min(least_us, TimeWork(work).us());
  return 1e-6 * least_us;
}

}  // namespace

MachineRates MeasureMachineRates() {
  const std::vector<float> values(std::size_t{32} << 20, 1);
  constexpr std::size_t kRounds = 3'000'000;
  volatile double sum = 0;  // keeps the work from being left out
  double floats = 0;
  double doubles = 0;
  const double read_s = TimeFastest_s([&] { sum = HWY_DYNAMIC_DISPATCH(Read)(values.data(), values.size()); });
  const double floats_s = TimeFastest_s([&] { sum = HWY_DYNAMIC_DISPATCH(ComputeFloats)(kRounds, floats); });
  const double doubles_s = TimeFastest_s([&] { sum = HWY_DYNAMIC_DISPATCH(ComputeDoubles)(kRounds, doubles); });
  const double bytes = static_cast<double>(values.size() * sizeof(float));
  return {1e-9 * bytes / read_s, 1e-9 * floats / floats_s, 1e-9 * doubles / doubles_s};
}

}  // namespace kerf
#endif  // HWY_ONCE
