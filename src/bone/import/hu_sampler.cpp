#include "bone/import/hu_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {

HuSampler::HuSampler(const Volume& ct) : ct_(ct) {
  const glm::dmat3 inverse = glm::inverse(ct.axes_W);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      voxel_from_world_[column][row] = inverse[column][row] / ct.spacing_mm[row];
  }
}

double HuSampler::At(const Vec3& p_W) const {
  const Vec3 p_V = voxel_from_world_ * (p_W - ct_.origin_W);
  std::array<int, 3> low{}, high{};
  Vec3 f;
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(p_V[a], 0.0, static_cast<double>(ct_.size[a] - 1));
    low[a] = static_cast<int>(std::floor(x));
    high[a] = std::min(low[a] + 1, ct_.size[a] - 1);
    f[a] = x - low[a];
  }
  const auto line = [&](int j, int k) {
    const double a = ct_.hu[ct_.Index(low[0], j, k)];
    const double b = ct_.hu[ct_.Index(high[0], j, k)];
    return a + f.x * (b - a);
  };
  const auto plane = [&](int k) {
    const double a = line(low[1], k);
    return a + f.y * (line(high[1], k) - a);
  };
  const double a = plane(low[2]);
  return a + f.z * (plane(high[2]) - a);
}

}  // namespace kerf
