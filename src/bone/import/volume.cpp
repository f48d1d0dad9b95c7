#include "bone/import/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr std::uint64_t kFnvOffset = 14695981039346656037ULL;
constexpr std::uint64_t kFnvPrime = 1099511628211ULL;
constexpr std::int16_t kAirHu = -1024;

// Adds data to an FNV-1a hash, in 64-bit words, because single bytes would be slow for a CT.
std::uint64_t Mix(std::uint64_t hash, const void* data, std::size_t bytes) {
  const char* p = static_cast<const char*>(data);
  while (bytes > 0) {
    std::uint64_t word = 0;
    const std::size_t n = bytes < sizeof word ? bytes : sizeof word;
    std::memcpy(&word, p, n);
    hash = (hash ^ word) * kFnvPrime;
    hash ^= hash >> 32;
    p += n;
    bytes -= n;
  }
  return hash;
}

}  // namespace

double Volume::CalcVoxelVolume() const {
  return spacing_mm.x * spacing_mm.y * spacing_mm.z * std::abs(glm::determinant(axes_W));
}

std::uint64_t CalcHash(const Volume& volume) {
  std::uint64_t hash = kFnvOffset;
  hash = Mix(hash, volume.size.data(), sizeof volume.size);
  hash = Mix(hash, &volume.spacing_mm, sizeof volume.spacing_mm);
  hash = Mix(hash, &volume.origin_W, sizeof volume.origin_W);
  hash = Mix(hash, &volume.axes_W, sizeof volume.axes_W);
  return Mix(hash, volume.hu.data(), volume.hu.size() * sizeof volume.hu[0]);
}

void CheckLattice(const Volume& volume, const std::string& name) {
  for (int a = 0; a < 3; ++a) {
    constexpr Range kSpacingRange_mm{0.01, 20};
    const double h = volume.spacing_mm[a];
    if (!kSpacingRange_mm.Contains(h)) {
      const bool in_metres = h > 0 && h < kSpacingRange_mm.lower && h * 1000 <= kSpacingRange_mm.upper;
      throw Error(fmt::format("{}: the voxel spacing along axis {} is {:.6g} mm; kerf accepts {}{}", name, a + 1, h,
                              ShowRange(kSpacingRange_mm, "mm"),
                              in_metres ? "; the header is probably in metres" : ""));
    }
    if (!std::isfinite(volume.origin_W[a]) || std::abs(volume.origin_W[a]) > 1e5) {
      throw Error(fmt::format("{}: the position of the first voxel is {} mm along axis {}, which can't be in a patient",
                              name, volume.origin_W[a], a + 1));
    }
  }
  const double determinant = std::abs(glm::determinant(volume.axes_W));
  if (!(determinant > 0.5)) {
    throw Error(
        fmt::format("{}: the image axes do not span space (determinant {:.3g}); the orientation in the header is wrong",
                    name, determinant));
  }
}

Volume Crop(const Volume& volume, const std::array<int, 3>& lower, const std::array<int, 3>& upper) {
  Volume part;
  part.spacing_mm = volume.spacing_mm;
  part.axes_W = volume.axes_W;
  part.frame = volume.frame;
  part.origin_W = volume.WorldFromVoxel({lower[0], lower[1], lower[2]});
  for (int a = 0; a < 3; ++a) part.size[a] = upper[a] - lower[a] + 1;
  part.hu.assign(part.count(), kAirHu);
  const int i_first = std::max(lower[0], 0);
  const int i_last = std::min(upper[0], volume.size[0] - 1);
  if (i_first > i_last) return part;
  for (int k = std::max(lower[2], 0); k <= std::min(upper[2], volume.size[2] - 1); ++k) {
    for (int j = std::max(lower[1], 0); j <= std::min(upper[1], volume.size[1] - 1); ++j) {
      std::memcpy(&part.hu[part.Index(i_first - lower[0], j - lower[1], k - lower[2])],
                  &volume.hu[volume.Index(i_first, j, k)],
                  sizeof(std::int16_t) * static_cast<std::size_t>(i_last - i_first + 1));
    }
  }
  return part;
}

}  // namespace kerf
