#include "bone/import/preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "base/files/memory.h"
#include "bone/grid/build.h"
#include "bone/import/spline_field.h"
#include "bone/import/tissue.h"

namespace kerf {

namespace {

constexpr int kAirRim_vox = 3;  // around the scan, so that bone that it cuts is closed
constexpr float kRimAir_HU = -1000;

// CT with larger voxels, each the mean of `step` voxels along each axis, and a rim of air.
struct CoarseCt {
  std::array<int, 3> size{};
  std::array<int, 3> step{};
  std::vector<float> hu;
  Vec3 CoarseFromVoxel(const Vec3& p_V) const {
    const Vec3 n(step[0], step[1], step[2]);
    return (p_V - 0.5 * (n - 1.0)) / n + static_cast<double>(kAirRim_vox);
  }
};

CoarseCt Coarsen(const Volume& ct, double voxel_mm, const std::function<void(double)>& progress) {
  CoarseCt coarse;
  for (int a = 0; a < 3; ++a) {
    coarse.step[a] = std::clamp(static_cast<int>(std::lround(voxel_mm / ct.spacing_mm[a])), 1, ct.size[a]);
    coarse.size[a] = ct.size[a] / coarse.step[a] + 2 * kAirRim_vox;
  }
  const auto index = [&](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * coarse.size[1] + j) * coarse.size[0] + i;
  };
  coarse.hu.assign(static_cast<std::size_t>(coarse.size[0]) * coarse.size[1] * coarse.size[2], kRimAir_HU);
  const auto [si, sj, sk] = coarse.step;
  const float part = 1.0f / static_cast<float>(si * sj * sk);
  for (int k = 0; k < ct.size[2] / sk; ++k) {
    if (progress) progress(0.3 * k / ct.size[2] * sk);
    for (int j = 0; j < ct.size[1] / sj; ++j) {
      for (int i = 0; i < ct.size[0] / si; ++i) {
        float sum = 0;
        for (int c = 0; c < sk; ++c) {
          for (int b = 0; b < sj; ++b) {
            const std::int16_t* row = &ct.hu[ct.Index(i * si, j * sj + b, k * sk + c)];
            for (int a = 0; a < si; ++a) sum += static_cast<float>(row[a]);
          }
        }
        coarse.hu[index(i + kAirRim_vox, j + kAirRim_vox, k + kAirRim_vox)] = part * sum;
      }
    }
  }
  return coarse;
}

}  // namespace

Bone MakePreview(const Volume& ct, double iso_hu, double voxel_mm, const std::function<void(double)>& progress) {
  CoarseCt coarse = Coarsen(ct, voxel_mm, progress);
  const SplineField hu(coarse.size, std::move(coarse.hu), false);
  const glm::dmat3 turn = glm::inverse(ct.axes_W);
  const auto coarse_from_world = [&](const Vec3& p_W) {
    return coarse.CoarseFromVoxel(turn * (p_W - ct.origin_W) / ct.spacing_mm);
  };
  Vec3 reach(0);  // half extent, in coarse voxels, of the box around a ball of radius 1 mm
  for (int a = 0; a < 3; ++a) {
    reach[a] = glm::length(Vec3(turn[0][a], turn[1][a], turn[2][a])) / (ct.spacing_mm[a] * coarse.step[a]);
  }
  SolidField solid;
  solid.value = [&](const Vec3& p_W) { return (iso_hu - hu.At(coarse_from_world(p_W))) / 1000; };
  solid.classify = [&](const Vec3& centre_W, double radius_mm) {
    const Vec3 p = coarse_from_world(centre_W);
    const SplineField::Bounds bounds = hu.CalcBounds(p - radius_mm * reach, p + radius_mm * reach);
    if (bounds.upper < iso_hu) return BlockClass::kOutside;
    return bounds.lower > iso_hu ? BlockClass::kInside : BlockClass::kMixed;
  };
  solid.region = [](const Vec3&) { return TissueMap::kPlainCortexRegion; };
  solid.is_distance = false;
  BuildOptions build;
  build.voxel_mm = voxel_mm;
  build.region_voxel_mm = voxel_mm;
  build.max_bytes = static_cast<double>(ReadAvailableBytes());
  if (progress) build.progress = [&](double fraction) { progress(0.3 + 0.7 * fraction); };
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p_V;
    for (int a = 0; a < 3; ++a) {
      const double rim = coarse.step[a] * (kAirRim_vox + 1);
      p_V[a] = ((corner >> a) & 1) != 0 ? ct.size[a] + rim : -rim;
    }
    box.Include(ct.WorldFromVoxel(p_V));
  }
  return MakeBone(solid, box.Grown(5 * voxel_mm), build, MakePlainTable());
}

}  // namespace kerf
