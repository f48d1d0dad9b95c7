#include "bone/import/blocks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace kerf {

std::array<int, 3> ChooseBlocks(const Volume& ct) {
  constexpr double kFine_mm = 0.35, kBlock_mm = 0.7;
  std::array<int, 3> step = {1, 1, 1};
  const Vec3& h = ct.spacing_mm;
  if (h.x * h.y * h.z >= kFine_mm * kFine_mm * kFine_mm) return step;
  for (int a = 0; a < 3; ++a) {
    step[static_cast<std::size_t>(a)] = std::max(1, static_cast<int>(std::floor(kBlock_mm / h[a] + 1e-6)));
  }
  return step;
}

Volume JoinBlocks(const Volume& ct, const std::array<int, 3>& step, double iso_hu) {
  Volume joined;
  joined.frame = ct.frame;
  joined.axes_W = ct.axes_W;
  Vec3 first;  // centre of the first block, in voxels
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(a);
    joined.size[n] = (ct.size[n] + step[n] - 1) / step[n];
    joined.spacing_mm[a] = ct.spacing_mm[a] * step[n];
    first[a] = 0.5 * (step[n] - 1);
  }
  joined.origin_W = ct.WorldFromVoxel(first);
  joined.hu.resize(joined.count());
  const int thickest = *std::max_element(step.begin(), step.end());
  const auto iso = static_cast<std::int16_t>(std::ceil(std::clamp(iso_hu, -32768.0, 32767.0)));
  tbb::parallel_for(0, joined.size[2], [&](int k) {
    const auto width = static_cast<std::size_t>(joined.size[0]);
    std::vector<int> sum(width), bone(width), count(width);
    for (int j = 0; j < joined.size[1]; ++j) {
      for (std::vector<int>* row : {&sum, &bone, &count}) std::fill(row->begin(), row->end(), 0);
      for (int z = k * step[2]; z < std::min((k + 1) * step[2], ct.size[2]); ++z) {
        for (int y = j * step[1]; y < std::min((j + 1) * step[1], ct.size[1]); ++y) {
          const std::int16_t* hu = &ct.hu[ct.Index(0, y, z)];
          std::size_t block = 0;
          for (int x = 0, in_block = 0; x < ct.size[0]; ++x) {
            sum[block] += hu[x];
            bone[block] += hu[x] >= iso ? 1 : 0;
            ++count[block];
            if (++in_block == step[0]) in_block = 0, ++block;
          }
        }
      }
      std::int16_t* const to = &joined.hu[joined.Index(0, j, k)];
      for (std::size_t i = 0; i < width; ++i) {
        to[i] = static_cast<std::int16_t>(std::lround(static_cast<double>(sum[i]) / count[i]));
        if (bone[i] * thickest >= count[i]) to[i] = std::max(to[i], iso);
      }
    }
  });
  return joined;
}

}  // namespace kerf
