#include "bone/import/smooth.h"

#include <algorithm>
#include <cmath>

namespace kerf {

namespace {

// Applies (w, 1 - 2 w, w) along an axis, `passes` times.
void FilterAlong(int axis, float w, int passes, const std::array<int, 3>& size, std::vector<float>& values) {
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(size[0]),
                                             static_cast<std::size_t>(size[0]) * size[1]};
  const int b = (axis + 1) % 3;
  const int c = (axis + 2) % 3;
  const int n = size[axis];
  std::vector<float> line(static_cast<std::size_t>(n));
  for (int q = 0; q < size[c]; ++q) {
    for (int p = 0; p < size[b]; ++p) {
      float* start = &values[static_cast<std::size_t>(p) * stride[b] + static_cast<std::size_t>(q) * stride[c]];
      for (int pass = 0; pass < passes; ++pass) {
        for (int i = 0; i < n; ++i) line[i] = start[static_cast<std::size_t>(i) * stride[axis]];
        for (int i = 0; i < n; ++i) {
          start[static_cast<std::size_t>(i) * stride[axis]] =
              w * (line[std::max(i - 1, 0)] + line[std::min(i + 1, n - 1)]) + (1 - 2 * w) * line[i];
        }
      }
    }
  }
}

}  // namespace

void Smooth(const std::array<int, 3>& size, const Vec3& sigma_vox, std::vector<float>& values) {
  for (int axis = 0; axis < 3; ++axis) {
    const double variance = sigma_vox[axis] * sigma_vox[axis];
    const int passes = std::min(static_cast<int>(std::ceil(2 * variance)), 4);  // w of at most 1/4 damps all
                                                                                // wavelengths
    if (passes == 0) continue;
    FilterAlong(axis, static_cast<float>(std::min(variance / (2 * passes), 0.25)), passes, size, values);
  }
}

void Sharpen(const std::array<int, 3>& size, const Vec3& fraction, std::vector<float>& values) {
  for (int axis = 0; axis < 3; ++axis) {
    if (fraction[axis] > 0) FilterAlong(axis, static_cast<float>(-fraction[axis] / 24), 1, size, values);
  }
}

}  // namespace kerf
