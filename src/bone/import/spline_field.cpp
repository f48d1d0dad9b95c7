#include "bone/import/spline_field.h"

#include <itkBSplineDecompositionImageFilter.h>
#include <itkImportImageFilter.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bone/import/spline_lattice.h"

namespace kerf {

namespace {

constexpr int kBigBox = 14;  // coefficients along an edge; larger boxes use the bounds of blocks

// Returns the coefficients of the interpolating cubic spline, computed by ITK's recursive filter (Unser 1999).
std::vector<float> Decompose(const std::array<int, 3>& size, std::vector<float>& samples) {
  using Image = itk::Image<float, 3>;
  const auto import = itk::ImportImageFilter<float, 3>::New();
  Image::RegionType region;
  for (unsigned a = 0; a < 3; ++a) region.SetSize(a, static_cast<itk::SizeValueType>(size[a]));
  import->SetRegion(region);
  import->SetImportPointer(samples.data(), samples.size(), false);
  const auto filter = itk::BSplineDecompositionImageFilter<Image, Image>::New();
  filter->SetSplineOrder(3);
  filter->SetInput(import->GetOutput());
  filter->Update();
  const float* result = filter->GetOutput()->GetBufferPointer();
  return {result, result + samples.size()};
}

std::array<double, 4> Weights(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
}

}  // namespace

SplineField::SplineField(const std::array<int, 3>& size, std::vector<float> samples, bool interpolate) : size_(size) {
  coefficients_ = interpolate ? Decompose(size, samples) : std::move(samples);
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
