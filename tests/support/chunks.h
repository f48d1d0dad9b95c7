// Reassembles the chunks of a bone's surface, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <vector>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "view/live/bone_chunks.h"

namespace kerf::test {

/// Makes a cortical lid of 4 mm over a cancellous core: 16 x 10 x 10 mm, top at z = 0.
inline Bone MakePlate(double voxel_mm) {
  BlockParams params;
  params.size_mm = {16, 10, 10};
  params.layers = {{4, 24}, {6, kCancellousRegion}};
  params.voxel_mm = voxel_mm;
  return MakeBlock(params, DefaultMandibleTable());
}

inline std::vector<ChunkMesh> MeshAll(const BoneChunks& chunks, int step) {
  std::vector<ChunkMesh> meshes;
  for (const auto& index : chunks.ListChunks(Vec3{0})) {
    ChunkMesh mesh;
    chunks.Mesh(index, step, mesh);
    meshes.push_back(mesh);
  }
  return meshes;
}

/// Merges vertices with bit-identical positions.
inline TriangleMesh JoinChunks(const BoneChunks& chunks, const std::vector<ChunkMesh>& meshes) {
  TriangleMesh joined;
  std::map<std::array<float, 3>, std::uint32_t> ids;
  for (const ChunkMesh& mesh : meshes) {
    std::vector<std::uint32_t> id_of;
    for (const ChunkVertex& v : mesh.vertices) {
      const auto [at, is_new] = ids.emplace(v.p_mm, static_cast<std::uint32_t>(joined.points.size()));
      if (is_new) joined.points.push_back(chunks.origin_W() + Vec3{v.p_mm[0], v.p_mm[1], v.p_mm[2]});
      id_of.push_back(at->second);
    }
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
      joined.triangles.push_back(
          {id_of[mesh.triangles[t]], id_of[mesh.triangles[t + 1]], id_of[mesh.triangles[t + 2]]});
    }
  }
  return joined;
}

/// Returns the number of directed edges that do not occur equally often in the opposite direction: 0 for a closed
/// surface, pinched or not.
inline std::size_t CountUnpaired(const TriangleMesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, int> balance;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  return static_cast<std::size_t>(
      std::count_if(balance.begin(), balance.end(), [](const auto& edge) { return edge.second != 0; }));
}

/// Makes an axis-aligned cube.
inline std::shared_ptr<const TriangleMesh> MakeCube(const Vec3& middle, double edge) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (int i = 0; i < 8; ++i) mesh->points.push_back(middle + edge * (Vec3{i & 1, (i >> 1) & 1, i >> 2} - 0.5));
  const std::array<std::uint32_t, 4> faces[] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : faces) {
    mesh->triangles.push_back({f[0], f[1], f[2]});
    mesh->triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

}  // namespace kerf::test
