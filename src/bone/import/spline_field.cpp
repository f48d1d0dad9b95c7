#include "bone/import/spline_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bone/import/spline_lattice.h"

namespace kerf {

namespace {

constexpr int kBigBox = 14;  // coefficients along an edge; larger boxes use the bounds of blocks

constexpr std::size_t kLanes = 16;  // lines that are filtered side by side

// Filters lines of `count` samples, `step` apart, of which up to kLanes start `lane_step` apart: the recursive filter
// of Unser 1999, with mirrored borders, as in itk::BSplineDecompositionImageFilter, bit for bit.
void FilterLines(float* start, std::size_t count, std::size_t step, std::size_t lanes, std::size_t lane_step,
                 std::vector<std::array<double, kLanes>>& line) {
  static const double pole = std::sqrt(3.0) - 2.0;
  static const double gain = (1.0 - pole) * (1.0 - 1.0 / pole);
  constexpr double kTolerance = 1e-10;
  static const auto horizon = static_cast<std::size_t>(std::ceil(std::log(kTolerance) / std::log(std::abs(pole))));
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t l = 0; l < lanes; ++l) {
      line[n][l] = static_cast<double>(start[n * step + l * lane_step]) * gain;
    }
  }
  const std::size_t last = count - 1;
  std::array<double, kLanes> sum = line[0];
  if (horizon < count) {
    double power = pole;
    for (std::size_t n = 1; n < horizon; ++n, power *= pole) {
      for (std::size_t l = 0; l < kLanes; ++l) sum[l] += power * line[n][l];
    }
    line[0] = sum;
  } else {
    double power = pole, mirrored = std::pow(pole, static_cast<double>(last));
    for (std::size_t l = 0; l < kLanes; ++l) sum[l] += mirrored * line[last][l];
    mirrored *= mirrored * (1.0 / pole);
    for (std::size_t n = 1; n + 1 < count; ++n, power *= pole, mirrored *= 1.0 / pole) {
      for (std::size_t l = 0; l < kLanes; ++l) sum[l] += (power + mirrored) * line[n][l];
    }
    for (std::size_t l = 0; l < kLanes; ++l) line[0][l] = sum[l] / (1.0 - power * power);
  }
  for (std::size_t n = 1; n < count; ++n) {
    for (std::size_t l = 0; l < kLanes; ++l) line[n][l] += pole * line[n - 1][l];
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    line[last][l] = (pole / (pole * pole - 1.0)) * (pole * line[last - 1][l] + line[last][l]);
  }
  for (std::size_t n = last; n-- > 0;) {
    for (std::size_t l = 0; l < kLanes; ++l) line[n][l] = pole * (line[n + 1][l] - line[n][l]);
  }
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t l = 0; l < lanes; ++l) start[n * step + l * lane_step] = static_cast<float>(line[n][l]);
  }
}

// Replaces samples by the coefficients of the cubic spline that interpolates them.
void Decompose(const std::array<int, 3>& size, std::vector<float>& samples) {
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(size[0]),
                                             static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto count = static_cast<std::size_t>(size[axis]);
    if (count == 1) continue;
    const std::size_t beside = axis == 0 ? 1 : 0, across = 3 - axis - beside;
    const auto width = static_cast<std::size_t>(size[beside]);
    tbb::parallel_for(0, size[across], [&](int q) {
      std::vector<std::array<double, kLanes>> line(count);
      for (std::size_t first = 0; first < width; first += kLanes) {
        FilterLines(&samples[static_cast<std::size_t>(q) * stride[across] + first * stride[beside]], count,
                    stride[axis], std::min(kLanes, width - first), stride[beside], line);
      }
    });
  }
}

std::array<double, 4> Weights(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
}

}  // namespace

SplineField::SplineField(const std::array<int, 3>& size, std::vector<float> samples, bool interpolate) : size_(size) {
  if (interpolate) Decompose(size, samples);
  coefficients_ = std::move(samples);
  MakeBlocks();
}

void SplineField::MakeBlocks() {
  for (int a = 0; a < 3; ++a) blocks_[a] = (size_[a] + kBlock - 1) / kBlock;
  constexpr float kInf = std::numeric_limits<float>::infinity();
  block_bounds_.assign(static_cast<std::size_t>(blocks_[0]) * blocks_[1] * blocks_[2], {kInf, -kInf});
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i) {
        auto& b =
            block_bounds_[(static_cast<std::size_t>(k / kBlock) * blocks_[1] + j / kBlock) * blocks_[0] + i / kBlock];
        const float c = coefficients_[Index(i, j, k)];
        b[0] = std::min(b[0], c);
        b[1] = std::max(b[1], c);
      }
    }
  }
}

double SplineField::At(const Vec3& p_V) const {
  std::array<std::array<int, 4>, 3> at{};
  std::array<std::array<double, 4>, 3> w{};
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(p_V[a], -1.0, static_cast<double>(size_[a]));
    const double floor = std::floor(x);
    w[a] = Weights(x - floor);
    for (int n = 0; n < 4; ++n) at[a][n] = std::clamp(static_cast<int>(floor) - 1 + n, 0, size_[a] - 1);
  }
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    double plane = 0;
    for (int j = 0; j < 4; ++j) {
      const float* row = &coefficients_[Index(0, at[1][j], at[2][k])];
      double line = 0;
      for (int i = 0; i < 4; ++i) line += w[0][i] * static_cast<double>(row[at[0][i]]);
      plane += w[1][j] * line;
    }
    sum += w[2][k] * plane;
  }
  return sum;
}

void SplineField::AtLattice(const LatticePositions& at_V, std::array<double, 512>& values) const {
  std::array<SplineAxis, 3> axes;
  for (std::size_t a = 0; a < 3; ++a) {
    std::array<int, 8> below{};
    for (std::size_t n = 0; n < 8; ++n) {
      const double x = std::clamp(at_V[a][n], -1.0, static_cast<double>(size_[a]));
      const double floor = std::floor(x);
      axes[a].weights[n] = Weights(x - floor);
      below[n] = static_cast<int>(floor);
    }
    const auto [lowest, highest] = std::minmax_element(below.begin(), below.end());
    axes[a].count = *highest - *lowest + 4;
    for (int n = 0; n < axes[a].count; ++n) {
      axes[a].coefficients[static_cast<std::size_t>(n)] = std::clamp(*lowest - 1 + n, 0, size_[a] - 1);
    }
    for (std::size_t n = 0; n < 8; ++n) axes[a].first[n] = below[n] - *lowest;
  }
  SumSplines(coefficients_.data(), {1, Index(0, 1, 0), Index(0, 0, 1)}, axes, values);
}

SplineField::Bounds SplineField::CalcBounds(const Vec3& lower_V, const Vec3& upper_V) const {
  std::array<int, 3> lo{}, hi{};
  bool big = false;
  for (int a = 0; a < 3; ++a) {
    const double last = size_[a] - 1;
    lo[a] = static_cast<int>(std::clamp(std::floor(lower_V[a]) - 1, 0.0, last));
    hi[a] = static_cast<int>(std::clamp(std::floor(upper_V[a]) + 2, 0.0, last));
    big = big || hi[a] - lo[a] >= kBigBox;
  }
  float lower = std::numeric_limits<float>::infinity();
  float upper = -lower;
  if (big) {
    for (int k = lo[2] / kBlock; k <= hi[2] / kBlock; ++k) {
      for (int j = lo[1] / kBlock; j <= hi[1] / kBlock; ++j) {
        for (int i = lo[0] / kBlock; i <= hi[0] / kBlock; ++i) {
          const auto& b = block_bounds_[(static_cast<std::size_t>(k) * blocks_[1] + j) * blocks_[0] + i];
          lower = std::min(lower, b[0]);
          upper = std::max(upper, b[1]);
        }
      }
    }
  } else {
    for (int k = lo[2]; k <= hi[2]; ++k) {
      for (int j = lo[1]; j <= hi[1]; ++j) {
        const float* row = &coefficients_[Index(lo[0], j, k)];
        for (int i = 0; i <= hi[0] - lo[0]; ++i) {
          lower = std::min(lower, row[i]);
          upper = std::max(upper, row[i]);
        }
      }
    }
  }
  return {static_cast<double>(lower), static_cast<double>(upper)};
}

}  // namespace kerf
