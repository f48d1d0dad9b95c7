// Tests of the chunks of a surface: together they are closed, independent of the order of changes, and true to the
// solid.
#include "view/live/bone_chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <tuple>

#include "bone/grid/set_leaf.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "kerf/simulation.h"
#include "kerf/surface.h"
#include "support/chunks.h"
#include "view/live/surface_worker.h"

namespace kerf {
namespace {

using test::CountUnpaired;
using test::JoinChunks;
using test::MakePlate;
using test::MeshAll;

// Cuts a kerf with the disc, tick by tick, and passes every changed leaf to `take`.
void CutSlot(Simulation& simulation, const Pose& start, int ticks,
             const std::function<void(const LeafMessage&)>& take) {
  for (int i = 1; i <= ticks; ++i) {
    TickInput in;
    in.X_WT = start;
    in.X_WT.p_AB.z -= 0.1 * i;
    simulation.Tick(in);
  }
  LeafMessage message;
  for (int i = 0; i < simulation.changed_count(); ++i) {
    const ChangedLeaf leaf = simulation.changed(i);
    message.index = leaf.index;
    std::copy_n(leaf.cut, 512, message.values.begin());
    take(message);
  }
}

struct Slot {
  Slot() {
    DiscSaw saw;
    saw.thickness_mm = 1;
    params.tool = saw;
    start.R_AB = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
    start.p_AB = {0.03, 0.11, 15};
  }
  SimulationParams params;
  Pose start;
};

TEST(BoneChunks, FormAClosedSurfaceAtEveryStep) {
  const BoneChunks chunks(MakePlate(0.2));
  for (const int step : BoneChunks::kSteps) {
    const TriangleMesh mesh = JoinChunks(chunks, MeshAll(chunks, step));
    ASSERT_GT(mesh.triangles.size(), 500u);
    EXPECT_EQ(CountUnpaired(mesh), 0u) << step;
    // The vertices at an edge lie in the cells that the edge crosses, so at most a cell's area is lost along 144 mm of
    // edges.
    const double bevel = 144 * std::pow(0.2 * step, 2);
    EXPECT_NEAR(CalcEnclosedVolume(mesh), 16 * 10 * 10, bevel) << step;
  }
}

std::vector<ChunkVertex> Sorted(const ChunkMesh& mesh) {
  std::vector<ChunkVertex> vertices = mesh.vertices;
  std::sort(vertices.begin(), vertices.end(),
            [](const ChunkVertex& a, const ChunkVertex& b) { return a.p_mm < b.p_mm; });
  return vertices;
}

TEST(BoneChunks, UpdatedChunkEqualsAChunkMeshedFromScratch) {
  const Slot slot;
  Simulation simulation(MakePlate(0.2), slot.params, slot.start);
  BoneChunks kept(MakePlate(0.2));
  std::map<std::array<int, 3>, ChunkMesh> drawn;
  for (const auto& index : kept.ListChunks(Vec3{0})) kept.Mesh(index, 1, drawn[index]);
  CutSlot(simulation, slot.start, 120, [&](const LeafMessage& leaf) { kept.Take(leaf); });
  std::size_t remeshed = 0;
  for (ChunkMesh mesh; kept.Next(mesh); ++remeshed) drawn[mesh.index] = mesh;
  EXPECT_GT(remeshed, 4u);
  EXPECT_LT(remeshed, drawn.size());

  // The chunks are made from the cut bone without information on what was cut, and from all leaves at once in reverse
  // order.
  const BoneChunks fresh(simulation.UpdateBone());
  ASSERT_EQ(fresh.origin_W(), kept.origin_W());
  BoneChunks at_once(MakePlate(0.2));
  LeafMessage message;
  for (int i = simulation.changed_count(); i-- > 0;) {
    message.index = simulation.changed(i).index;
    std::copy_n(simulation.changed(i).cut, 512, message.values.begin());
    at_once.Take(message);
  }
  std::size_t cut = 0;
  for (const auto& [index, mesh] : drawn) {
    ChunkMesh scratch;
    fresh.Mesh(index, 1, scratch);
    ASSERT_EQ(mesh.triangles, scratch.triangles);
    const auto a = Sorted(mesh);
    const auto b = Sorted(scratch);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].p_mm, b[i].p_mm);
      cut += a[i].cut != 0 ? 1u : 0u;
    }
    at_once.Mesh(index, 1, scratch);
    ASSERT_EQ(mesh.triangles, scratch.triangles);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      ASSERT_EQ(mesh.vertices[i].p_mm, scratch.vertices[i].p_mm);
      ASSERT_EQ(mesh.vertices[i].normal, scratch.vertices[i].normal);
      ASSERT_EQ(mesh.vertices[i].region, scratch.vertices[i].region);
      ASSERT_EQ(mesh.vertices[i].cut, scratch.vertices[i].cut);
    }
  }
  EXPECT_GT(cut, 1000u);
  std::vector<ChunkMesh> all;
  for (const auto& [index, mesh] : drawn) all.push_back(mesh);
  EXPECT_EQ(CountUnpaired(JoinChunks(kept, all)), 0u);
}

TEST(BoneChunks, EachLeafUpdatesTheChunksThatItBordersOn) {
  const Bone bone = MakePlate(0.5);
  std::vector<std::array<int, 3>> leaves;
  for (int x = -3; x <= 3; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -4; z <= 1; ++z) leaves.push_back({x, y, z});
    }
  }
  std::size_t changed = 0;
  for (const auto& index : leaves) {
    BoneChunks kept(bone);
    std::map<std::array<int, 3>, ChunkMesh> drawn;
    for (int i = 0; i < 64; ++i) {
      const std::array<int, 3> chunk{i % 4 - 2, i / 4 % 4 - 2, i / 16 - 2};
      kept.Mesh(chunk, 1, drawn[chunk]);
    }
    // The surface moves by a fifth of a voxel in this leaf only.
    LeafMessage leaf;
    leaf.index = index;
    GetLeaf(bone, index, leaf.values);
    for (float& phi : leaf.values) phi = std::min(phi + 0.1F, 1.5F);
    kept.Take(leaf);
    for (ChunkMesh mesh; kept.Next(mesh);) drawn[mesh.index] = mesh;
    const BoneChunks fresh(kept.bone());
    ASSERT_EQ(fresh.origin_W(), kept.origin_W());
    for (const auto& [chunk, mesh] : drawn) {
      ChunkMesh scratch;
      fresh.Mesh(chunk, 1, scratch);
      const auto a = Sorted(mesh);
      const auto b = Sorted(scratch);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(a[i].p_mm, b[i].p_mm) << index[0] << " " << index[1] << " " << index[2];
      }
      changed += mesh.cut ? 1 : 0;
    }
  }
  EXPECT_GT(changed, leaves.size());  // some leaves border on several chunks
}

TEST(BoneChunks, CutSurfaceIsMarkedAndShowsItsTissue) {
  const Slot slot;
  Simulation simulation(MakePlate(0.2), slot.params, slot.start);
  BoneChunks chunks(MakePlate(0.2));
  CutSlot(simulation, slot.start, 120, [&](const LeafMessage& leaf) { chunks.Take(leaf); });
  const Tissue expected[2] = {Tissue::kCortical, Tissue::kCancellous};
  std::size_t wall[2] = {0, 0};
  for (const ChunkMesh& mesh : MeshAll(chunks, 1)) {
    for (const ChunkVertex& v : mesh.vertices) {
      const Vec3 p = chunks.origin_W() + Vec3{v.p_mm[0], v.p_mm[1], v.p_mm[2]};
      // These are the kerf's walls, from -0.47 to 0.53. The disc reaches down to z = -8.
      const bool on_wall = std::abs(std::abs(p.x - 0.03) - 0.5) < 0.05 && std::abs(p.y) < 4 && p.z < -0.5 && p.z > -7;
      const bool far_off = std::abs(p.x) > 1.2 || p.z < -9;
      if (far_off) {
        ASSERT_EQ(v.cut, 0) << p.x << " " << p.y << " " << p.z;
      }
      // The layers meet at z = -4. Within a voxel of that, either is correct.
      if (!on_wall || std::abs(p.z + 4) < 0.3) continue;
      ASSERT_EQ(v.cut, 255) << p.x << " " << p.y << " " << p.z;
      const std::size_t layer = p.z < -4 ? 1 : 0;
      ASSERT_EQ(chunks.bone().materials().At(v.region).tissue, expected[layer]);
      ++wall[layer];
    }
  }
  EXPECT_GT(wall[0], 500u);
  EXPECT_GT(wall[1], 300u);
}

TEST(BoneChunks, TheEdgesOfAKerfAreCrisp) {
  const Slot slot;
  Simulation simulation(MakePlate(0.2), slot.params, slot.start);
  BoneChunks chunks(MakePlate(0.2));
  CutSlot(simulation, slot.start, 120, [&](const LeafMessage& leaf) { chunks.Take(leaf); });
  std::size_t on_edge[2] = {0, 0};  // of the plate's upper face and of the kerf's walls
  for (const ChunkMesh& mesh : MeshAll(chunks, 1)) {
    for (const ChunkVertex& v : mesh.vertices) {
      const Vec3 p = chunks.origin_W() + Vec3{v.p_mm[0], v.p_mm[1], v.p_mm[2]};
      const double from_wall = std::abs(std::abs(p.x - 0.03) - 0.5);
      if (std::abs(p.x) > 2 || std::abs(p.y) > 4 || p.z < -1) continue;
      // No vertex has a normal between those of the two surfaces, and each has the colour of its own.
      const bool on_wall = v.cut != 0;
      ASSERT_GE(on_wall ? std::abs(v.normal[0]) : v.normal[2], 126) << p.x << " " << p.y << " " << p.z;
      if (from_wall < 0.01 && p.z > -0.01) ++on_edge[on_wall ? 1 : 0];
    }
  }
  EXPECT_GT(on_edge[0], 80u);  // 8 mm along both edges, in cells of 0.2 mm
  EXPECT_EQ(on_edge[0], on_edge[1]);
}

TEST(BoneChunks, ACutBoneThatIsOpenedAgainLooksAsDuringTheCut) {
  const Slot slot;
  const Bone bone = MakePlate(0.2);
  Simulation simulation(bone, slot.params, slot.start);
  BoneChunks during(bone);
  CutSlot(simulation, slot.start, 60, [&](const LeafMessage& leaf) { during.Take(leaf); });
  const BoneChunks again(during.bone(), &bone);
  std::size_t cut = 0;
  for (const int step : BoneChunks::kSteps) {
    for (const auto& index : during.ListChunks({0, 0, 0})) {
      ChunkMesh then, now;
      during.Mesh(index, step, then);
      again.Mesh(index, step, now);
      ASSERT_EQ(now.vertices.size(), then.vertices.size());
      for (std::size_t i = 0; i < then.vertices.size(); ++i) {
        ASSERT_EQ(now.vertices[i].p_mm, then.vertices[i].p_mm);
        ASSERT_EQ(now.vertices[i].cut, then.vertices[i].cut);
        cut += now.vertices[i].cut != 0 ? 1 : 0;
      }
      EXPECT_EQ(now.triangles, then.triangles);
      EXPECT_EQ(now.cut, then.cut);
    }
  }
  EXPECT_GT(cut, 500u);
}

TEST(BoneChunks, SkirtsAreTheBorderFacesOfTheNextChunksUp) {
  BlockParams params;
  params.size_mm = {16, 10, 10};
  params.layers = {{10, 24}};
  params.voxel_mm = 0.2;
  params.X_WB.R_AB = glm::angleAxis(0.6, glm::normalize(Vec3{1, 2, 3}));
  const BoneChunks chunks(MakeBlock(params, DefaultMandibleTable()));
  const std::vector<ChunkMesh> meshes = MeshAll(chunks, 2);
  std::map<std::array<float, 3>, ChunkVertex> known;
  std::set<std::set<std::array<float, 3>>> faces;
  const auto corners = [](const ChunkMesh& mesh, const std::vector<std::uint32_t>& triangles, std::size_t t) {
    return std::set<std::array<float, 3>>{mesh.vertices[triangles[t]].p_mm, mesh.vertices[triangles[t + 1]].p_mm,
                                          mesh.vertices[triangles[t + 2]].p_mm};
  };
  for (const ChunkMesh& mesh : meshes) {
    for (const std::uint32_t i : mesh.triangles) known[mesh.vertices[i].p_mm] = mesh.vertices[i];
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) faces.insert(corners(mesh, mesh.triangles, t));
  }
  std::size_t looked = 0;
  for (const ChunkMesh& mesh : meshes) {
    for (std::size_t t = 0; t < mesh.skirt.size(); t += 3) {
      ASSERT_EQ(faces.count(corners(mesh, mesh.skirt, t)), 1u);
      ++looked;
    }
    for (const std::uint32_t i : mesh.skirt) {
      const ChunkVertex& v = mesh.vertices[i];
      const ChunkVertex& w = known.at(v.p_mm);
      // The normals are computed from a smaller neighbourhood of the level set, so they are similar except at the
      // block's edges.
      const double along =
          (v.normal[0] * w.normal[0] + v.normal[1] * w.normal[1] + v.normal[2] * w.normal[2]) / 127.0 / 127;
      ASSERT_GT(along, 0.7);
    }
  }
  EXPECT_GT(looked, 200u);
}

TEST(BoneChunks, NormalsPointOutward) {
  // The plate has axis-aligned faces, so its normals are known except at the edges.
  const BoneChunks chunks(MakePlate(0.25));
  std::size_t looked = 0;
  for (const ChunkMesh& mesh : MeshAll(chunks, 1)) {
    for (const ChunkVertex& v : mesh.vertices) {
      const Vec3 p = chunks.origin_W() + Vec3{v.p_mm[0], v.p_mm[1], v.p_mm[2]};
      if (std::abs(p.x) > 7 || std::abs(p.y) > 4) continue;
      ++looked;
      ASSERT_EQ(v.normal[2], p.z > -5 ? 127 : -127);
    }
  }
  EXPECT_GT(looked, 1000u);
}

TEST(SurfaceWorker, ReturnsAChangedChunkByTheSecondFrame) {
  SurfaceWorker worker(MakePlate(0.2), 1);
  BoneChunks alone(MakePlate(0.2));
  worker.WaitIdle();
  while (!worker.Fetch().empty()) continue;
  const std::array<int, 3> chunk{0, 0, -1};  // with the plate's top, z = 0, at its upper end
  for (int round = 1; round <= 30; ++round) {
    // A hole in one leaf, deeper from round to round; slices take the worker's time meanwhile.
    LeafMessage leaf{.index = {1, 1, -1}};
    leaf.values.fill(0.01F * static_cast<float>(round));
    worker.RequestSlice(0, {});
    worker.Offer(leaf);
    alone.Take(leaf);
    ChunkMesh wanted;
    alone.Mesh(chunk, 1, wanted);
    ChunkMesh seen;
    for (int frame = 1; frame <= 2; ++frame) {
      for (ChunkMesh& mesh : worker.Fetch(1024, std::chrono::minutes(5))) {
        if (mesh.index == chunk && mesh.step == 1) seen = std::move(mesh);
      }
    }
    ASSERT_GT(wanted.triangles.size(), 0u);
    EXPECT_EQ(seen.triangles, wanted.triangles) << round;
    ASSERT_EQ(seen.vertices.size(), wanted.vertices.size()) << round;
    for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
      EXPECT_EQ(seen.vertices[i].p_mm, wanted.vertices[i].p_mm) << round;
    }
  }
}

TEST(SurfaceWorker, GivesTheSameMeshAsASingleThread) {
  const Slot slot;
  Simulation simulation(MakePlate(0.2), slot.params, slot.start);
  SurfaceWorker worker(MakePlate(0.2), 2);
  BoneChunks alone(MakePlate(0.2));
  CutSlot(simulation, slot.start, 120, [&](const LeafMessage& leaf) {
    worker.Offer(leaf);
    alone.Take(leaf);
  });
  worker.WaitIdle();
  std::map<std::array<int, 3>, ChunkMesh> newest;
  for (;;) {
    const std::vector<ChunkMesh> some = worker.Fetch(7);
    if (some.empty()) break;
    EXPECT_LE(some.size(), 7u);
    for (const ChunkMesh& mesh : some) {
      if (mesh.step == 1) newest[mesh.index] = mesh;
    }
  }
  std::size_t compared = 0;
  for (const auto& index : alone.ListChunks(Vec3{0})) {
    ChunkMesh mesh;
    alone.Mesh(index, 1, mesh);
    if (mesh.triangles.empty()) continue;
    ASSERT_EQ(newest.count(index), 1u);
    EXPECT_EQ(newest[index].triangles, mesh.triangles);
    EXPECT_EQ(newest[index].cut, mesh.cut);
    ++compared;
  }
  EXPECT_GT(compared, 10u);
  EXPECT_EQ(worker.CopyBone().CalcHash(), simulation.UpdateBone().CalcHash());
  EXPECT_TRUE(worker.first_done());
  EXPECT_EQ(worker.counts().leaves_waiting, 0u);
  // The rays go from above onto the plate next to the kerf, and down the kerf to its floor.
  const auto top = worker.Pick({{5, 0, 40}, {0, 0, -1}});
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->z, 0, 1e-3);
  const auto floor = worker.Pick({{0.03, 0.11, 40}, {0, 0, -1}});
  ASSERT_TRUE(floor);
  EXPECT_NEAR(floor->z, 15 - 12 - 11, 0.1);
  EXPECT_FALSE(worker.Pick({{50, 0, 40}, {0, 0, -1}}));
}

}  // namespace
}  // namespace kerf
