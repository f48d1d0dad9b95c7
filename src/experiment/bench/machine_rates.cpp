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

constexpr hn::CappedTag<float, 8> kFloats;  // as in removal
constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
constexpr std::size_t kChains = 8;  // enough to hide the latency of an operation
using V = hn::Vec<decltype(kFloats)>;

float SumOf(const V (&chains)[kChains]) {
  float sum = 0;
  for (const V& chain : chains) sum += hn::GetLane(hn::SumOfLanes(kFloats, chain));
  return sum;
}

/// Returns the sum of the values; `count`: a multiple of 64.
float Read(const float* values, std::size_t count) {
  V chains[kChains];
  for (V& chain : chains) chain = hn::Zero(kFloats);
  for (std::size_t i = 0; i < count; i += kChains * kLanes) {
    for (std::size_t k = 0; k < kChains; ++k) {
      chains[k] = hn::Add(chains[k], hn::LoadU(kFloats, values + i + k * kLanes));
    }
  }
  return SumOf(chains);
}

/// Does `rounds` multiplications and as many additions in each lane of each chain. Sets `operations` to their number.
float Compute(std::size_t rounds, double& operations) {
  V chains[kChains];
  for (std::size_t k = 0; k < kChains; ++k) chains[k] = hn::Set(kFloats, static_cast<float>(k));
  const V factor = hn::Set(kFloats, 0.5f);
  const V term = hn::Set(kFloats, 1);
  for (std::size_t i = 0; i < rounds; ++i) {
    for (V& chain : chains) chain = hn::Add(hn::Mul(chain, factor), term);
  }
  operations = 2.0 * static_cast<double>(rounds * kChains * kLanes);
  return SumOf(chains);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(Read);
HWY_EXPORT(Compute);

constexpr int kRepeats = 3;  // the fastest counts

}  // namespace

MachineRates MeasureMachineRates() {
  const std::vector<float> values(std::size_t{32} << 20, 1);
  volatile float sum = 0;  // keeps the work from being left out
  double read_s = 1e9;
  double compute_s = 1e9;
  double operations = 0;
  for (int i = 0; i < kRepeats; ++i) {
    const auto read = [&] { sum = HWY_DYNAMIC_DISPATCH(Read)(values.data(), values.size()); };
    read_s = std::min(read_s, 1e-6 * TimeWork(read).us());
    const auto compute = [&] { sum = HWY_DYNAMIC_DISPATCH(Compute)(3'000'000, operations); };
    compute_s = std::min(compute_s, 1e-6 * TimeWork(compute).us());
  }
  return {1e-9 * static_cast<double>(values.size() * sizeof(float)) / read_s, 1e-9 * operations / compute_s};
}

}  // namespace kerf
#endif  // HWY_ONCE
