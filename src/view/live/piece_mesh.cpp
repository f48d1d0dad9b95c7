#include "view/live/piece_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <unordered_map>

#include "bone/grid/grids.h"
#include "view/live/palette.h"

namespace kerf {
namespace {

// At a sharp edge of the original surface, the points of a mesh lie up to this far below the edge.
constexpr double kCutDepth_voxels = 0.5;

// Merges the points that are not kept within cells of `cell_mm`. Triangles that become degenerate are removed.
PieceMesh MergePoints(const PieceMesh& fine, const std::vector<bool>& kept, double cell_mm) {
  PieceMesh coarse;
  std::vector<std::uint32_t> id_of(fine.mesh_P.points.size());
  std::vector<double> counts;
  std::unordered_map<std::uint64_t, std::uint32_t> cells;
  for (std::size_t i = 0; i < id_of.size(); ++i) {
    const Vec3& p = fine.mesh_P.points[i];
    const auto next = static_cast<std::uint32_t>(coarse.mesh_P.points.size());
    std::uint32_t id = next;
    if (!kept[i]) {
      // 21 bits for each index: enough for two million cells along an axis.
      const auto part = [&](double v) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / cell_mm)) + (1 << 20)) & 0x1fffff;
      };
      id = cells.try_emplace(part(p.x) << 42 | part(p.y) << 21 | part(p.z), next).first->second;
    }
    id_of[i] = id;
    if (id == next) {
      coarse.mesh_P.points.push_back(p);
      coarse.colours.push_back(fine.colours[i]);
      counts.push_back(1);
    } else {
      coarse.mesh_P.points[id] += p;
      counts[id] += 1;
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i) coarse.mesh_P.points[i] /= counts[i];
  for (const auto& t : fine.mesh_P.triangles) {
    const std::array<std::uint32_t, 3> now{id_of[t[0]], id_of[t[1]], id_of[t[2]]};
    if (now[0] != now[1] && now[1] != now[2] && now[2] != now[0]) coarse.mesh_P.triangles.push_back(now);
  }
  return coarse;
}

}  // namespace

Rgb8 PieceColour(int piece) {
  constexpr std::array<Rgb8, kPieceColours> kColours{
      {{200, 187, 140}, {140, 207, 240}, {131, 149, 141}, {206, 225, 217}, {61, 132, 162}, {151, 118, 82}}};
  return kColours[static_cast<std::size_t>(std::max(0, piece)) % kColours.size()];
}

PieceMesh MakePieceMesh(const Bone& start, const TriangleMesh& mesh_P, const Rgb8& uncut, std::size_t max_triangles) {
  PieceMesh made{mesh_P, std::vector<Rgb8>(mesh_P.points.size(), uncut)};
  const BoneGrids& grids = GridsOf(start);
  const double voxel_mm = grids.voxel_mm();
  const double region_mm = grids.region_voxel_mm();
  std::vector<Vec3> normals(mesh_P.points.size(), Vec3{0});
  for (const auto& t : mesh_P.triangles) {
    const Vec3& a = mesh_P.points[t[0]];
    const Vec3 n = glm::cross(mesh_P.points[t[1]] - a, mesh_P.points[t[2]] - a);
    for (const auto id : t) normals[id] += n;
  }
  std::vector<char> cut(mesh_P.points.size(), 0);  // not bool, because several threads write it
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cut.size(), 4096), [&](const auto& range) {
    auto phi = grids.phi->getConstAccessor();
    auto region = grids.region->getConstAccessor();
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vec3& p = mesh_P.points[i];
      cut[i] = SampleTrilinear(phi, p / voxel_mm) < -kCutDepth_voxels * voxel_mm ? 1 : 0;
      const Vec3 n = CalcDirection(normals[i]).value_or(Vec3{0});
      // Half a voxel below the surface; deeper if there is no material.
      int id = 0;
      for (int step = 1; step <= 4 && id == 0; ++step) {
        id = region.getValue(NearestVoxel(p - 0.5 * step * std::max(voxel_mm, region_mm) * n, region_mm));
      }
      if (!grids.materials.Contains(id)) continue;
      const Tissue tissue = grids.materials.At(id).tissue;
      if (cut[i] != 0 || tissue == Tissue::kTooth) made.colours[i] = CutColour(tissue);
    }
  });
  if (mesh_P.triangles.size() <= max_triangles) return made;
  // The triangles of cut faces and their neighbours keep all their points.
  std::vector<bool> kept(cut.begin(), cut.end());
  for (const auto& t : mesh_P.triangles) {
    if (cut[t[0]] + cut[t[1]] + cut[t[2]] > 0) {
      for (const auto id : t) kept[id] = true;
    }
  }
  PieceMesh coarse;
  for (double cell_mm = 1.5 * voxel_mm; cell_mm < 40 * voxel_mm; cell_mm *= 1.3) {
    coarse = MergePoints(made, kept, cell_mm);
    if (coarse.mesh_P.triangles.size() <= max_triangles) break;
  }
  return coarse;
}

}  // namespace kerf
