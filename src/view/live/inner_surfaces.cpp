#include "view/live/inner_surfaces.h"

#include <algorithm>
#include <array>
#include <vector>

#include "bone/grid/grids.h"

namespace kerf {
namespace {

// Meshes a smooth field of the tissue: the tissue's fraction among a voxel and its 26 neighbours, shifted to be
// negative inside.
TriangleMesh MeshTissue(const Bone& bone, Tissue tissue) {
  const BoneGrids& grids = GridsOf(bone);
  const openvdb::FloatGrid::Ptr fraction = openvdb::FloatGrid::create(1.0F);
  fraction->setTransform(grids.region->transform().copy());
  fraction->setGridClass(openvdb::GRID_LEVEL_SET);  // otherwise its surface is turned inside out
  std::array<bool, 256> wanted{};
  bool any = false;
  for (const auto& [id, region] : grids.materials.regions()) {
    wanted[static_cast<std::size_t>(id)] = region.tissue == tissue;
    any = any || region.tissue == tissue;
  }
  if (!any) return {};
  auto to = fraction->getAccessor();
  constexpr float kPart[4] = {8.0F / 64, 4.0F / 64, 2.0F / 64, 1.0F / 64};  // by the number of axes that differ
  const auto add = [&](const openvdb::Coord& at) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const openvdb::Coord n = at.offsetBy(x, y, z);
          to.setValue(n, to.getValue(n) - 2 * kPart[x * x + y * y + z * z]);
        }
      }
    }
  };
  for (auto v = grids.region->cbeginValueOn(); v; ++v) {
    const int id = v.getValue();
    if (id < 0 || id > 255 || !wanted[static_cast<std::size_t>(id)]) continue;
    if (v.isVoxelValue()) {
      add(v.getCoord());
    } else {
      openvdb::CoordBBox box;
      v.getBoundingBox(box);
      for (auto at = box.begin(); at; ++at) add(*at);
    }
  }
  if (fraction->activeVoxelCount() == 0) return {};
  return ExtractZeroLevel(*fraction, 0);
}

// Taubin smoothing: moves each point towards the mean of its neighbours and nearly as far back, which removes steps but
// keeps the size.
void Smooth(TriangleMesh& mesh) {
  constexpr int kRounds = 10;
  std::vector<Vec3> sum(mesh.points.size());
  std::vector<int> count(mesh.points.size());
  for (int round = 0; round < 2 * kRounds; ++round) {
    std::fill(sum.begin(), sum.end(), Vec3{0});
    std::fill(count.begin(), count.end(), 0);
    for (const auto& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        sum[t[i]] += mesh.points[t[(i + 1) % 3]];
        ++count[t[i]];
      }
    }
    const double fraction = round % 2 == 0 ? 0.5 : -0.53;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      if (count[i] > 0) mesh.points[i] += fraction * (sum[i] / static_cast<double>(count[i]) - mesh.points[i]);
    }
  }
}

}  // namespace

InnerSurfaces MakeInnerSurfaces(const Bone& bone) {
  InnerSurfaces surfaces{MeshTissue(bone, Tissue::kCanal), MeshTissue(bone, Tissue::kTooth)};
  Smooth(surfaces.canal_W);
  Smooth(surfaces.teeth_W);
  return surfaces;
}

}  // namespace kerf
