// This file is compiled once for each vector instruction set. It uses no fused multiply-add, so the results are
// bit-identical at every width.
#include "bone/import/spline_lattice.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bone/import/spline_lattice.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using LatticeDoubles = hn::CappedTag<double, 8>;
constexpr LatticeDoubles kLatticeDoubles;
constexpr int kLatticeLanes = static_cast<int>(hn::MaxLanes(kLatticeDoubles));

/// Sets `to` to the weighted sums of four lists of `count` numbers, which are `step` apart; `count`: a multiple of the
/// lanes.
HWY_INLINE void SumFour(const double* from, int step, const std::array<double, 4>& weights, int count, double* to) {
  for (int n = 0; n < count; n += kLatticeLanes) {
    auto sum = hn::Zero(kLatticeDoubles);
    for (int i = 0; i < 4; ++i) {
      const auto weight = hn::Set(kLatticeDoubles, weights[static_cast<std::size_t>(i)]);
      sum = hn::Add(sum, hn::Mul(weight, hn::Load(kLatticeDoubles, from + i * step + n)));
    }
    hn::Store(sum, kLatticeDoubles, to + n);
  }
}

void Sum(const float* coefficients, const std::array<std::size_t, 3>& stride, const std::array<SplineAxis, 3>& axes,
         std::array<double, 512>& sums) {
  constexpr int kMax = kLatticeCoefficients;
  alignas(64) double block[kMax][kMax][kMax];      // the coefficients i, j, k
  alignas(64) double lines[kMax][kMax];            // sums along i, at j, k; of one x
  alignas(64) double planes[kMax][8][8];           // sums along i and j, at k, x, y
  alignas(64) double plane[kMax];                  // at k; of one x and y
  const int across = (axes[2].count + 7) / 8 * 8;  // numbers along k that are computed, some of them not used
  for (int k = 0; k < axes[2].count; ++k) {
    for (int j = 0; j < axes[1].count; ++j) {
      const float* const row = coefficients + static_cast<std::size_t>(axes[1].coefficients[j]) * stride[1] +
                               static_cast<std::size_t>(axes[2].coefficients[k]) * stride[2];
      for (int i = 0; i < axes[0].count; ++i) {
        block[i][j][k] = static_cast<double>(row[static_cast<std::size_t>(axes[0].coefficients[i]) * stride[0]]);
      }
    }
  }
  for (int i = 0; i < axes[0].count; ++i) {
    for (int j = 0; j < axes[1].count; ++j) {
      for (int k = axes[2].count; k < across; ++k) block[i][j][k] = 0;
    }
  }
  for (int x = 0; x < kLatticePoints; ++x) {
    for (int j = 0; j < axes[1].count; ++j)
      SumFour(block[axes[0].first[x]][j], kMax * kMax, axes[0].weights[x], across, lines[j]);
    for (int y = 0; y < kLatticePoints; ++y) {
      SumFour(lines[axes[1].first[y]], kMax, axes[1].weights[y], across, plane);
      for (int k = 0; k < axes[2].count; ++k) planes[k][x][y] = plane[k];
    }
  }
  alignas(64) double layer[64];  // the sums at x, y; of one z
  for (int z = 0; z < kLatticePoints; ++z) {
    SumFour(planes[axes[2].first[z]][0], 64, axes[2].weights[z], 64, layer);
    for (std::size_t n = 0; n < 64; ++n) sums[8 * n + static_cast<std::size_t>(z)] = layer[n];
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(Sum);

}  // namespace

void SumSplines(const float* coefficients, const std::array<std::size_t, 3>& stride,
                const std::array<SplineAxis, 3>& axes, std::array<double, 512>& sums) {
  HWY_DYNAMIC_DISPATCH(Sum)(coefficients, stride, axes, sums);
}

}  // namespace kerf
#endif
