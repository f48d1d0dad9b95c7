#include "view/live/bone_chunks.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "bone/grid/grids.h"
#include "bone/grid/set_leaf.h"
#include "bone/grid/sharp_edges.h"
#include "kerf/error.h"
#include "view/live/chunk_mesher.h"

namespace kerf {
namespace {

using Index = std::array<int, 3>;
constexpr int kLeaf = 8;
constexpr int kLeavesAcross = BoneChunks::kVoxels / kLeaf;

int FloorDiv(int a, int b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

struct IndexHash {
  std::size_t operator()(const Index& i) const {
    std::size_t h = 0;
    for (const int part : i) h = h * 0x9e3779b97f4a7c15u + static_cast<std::uint32_t>(part);
    return h ^ (h >> 29);
  }
};

// Leaves that contain the samples of a chunk: its own leaves, and those within two samples of it on each side.
struct LeafValues {
  const float* values;  // null: `uniform` throughout
  float uniform;
};
int Beyond(int step) {
  return (2 * step + kLeaf - 1) / kLeaf;
}

void FillSamples(const std::vector<LeafValues>& leaves, int step, std::vector<float>& samples) {
  constexpr std::size_t kEdge = kLeaf;
  const auto s = static_cast<std::size_t>(step);
  const auto beyond = static_cast<std::size_t>(Beyond(step));
  const std::size_t reach = kLeavesAcross + 2 * beyond;
  const std::size_t n = static_cast<std::size_t>(BoneChunks::kVoxels / step) + 4;
  samples.resize(n * n * n);
  // Voxels are counted from the first leaf; the first sample lies two samples before the chunk.
  const auto voxel_of = [&](std::size_t i) { return kEdge * beyond + i * s - 2 * s; };
  float* out = samples.data();
  for (std::size_t x = 0; x < n; ++x) {
    const std::size_t vx = voxel_of(x);
    for (std::size_t y = 0; y < n; ++y) {
      const std::size_t vy = voxel_of(y);
      const LeafValues* row = &leaves[((vx / kEdge) * reach + vy / kEdge) * reach];
      const std::size_t within = ((vx % kEdge) * kEdge + vy % kEdge) * kEdge;
      for (std::size_t z = 0; z < n; ++z) {
        const std::size_t vz = voxel_of(z);
        const LeafValues& leaf = row[vz / kEdge];
        *out++ = leaf.values != nullptr ? leaf.values[within + vz % kEdge] : leaf.uniform;
      }
    }
  }
}

/// Returns whether a triangle is part of the cut's surface. All three of its corners may be on edges.
bool IsOnCutFace(const std::vector<SharpEdges::Vertex>& vertices, const std::array<std::uint32_t, 3>& triangle) {
  using Side = SharpEdges::Side;
  const SharpEdges::Vertex *const a = &vertices[triangle[0]], *const b = &vertices[triangle[1]],
                                  *const c = &vertices[triangle[2]];
  const auto is_on = [&](Side side) { return a->IsOn(side) && b->IsOn(side) && c->IsOn(side); };
  if (!is_on(Side::kCut)) return false;
  if (!is_on(Side::kWhole)) return true;
  const Vec3 normal = glm::cross(b->p_vox - a->p_vox, c->p_vox - a->p_vox);
  return glm::dot(normal, a->cut_outward + b->cut_outward + c->cut_outward) >
         glm::dot(normal, a->whole_outward + b->whole_outward + c->whole_outward);
}

/// Splits the triangles of a mesh at the sharp edges of its bone. On an edge, each of the two surfaces has vertices of
/// its own, with its normal and its colour. `sharp`: where each vertex of the mesh lies. add(vertex, outward direction,
/// is cut) appends a vertex to the mesh.
template <typename Add>
void SplitAtEdges(const SharpEdges& edges, std::vector<SharpEdges::Vertex>& sharp, ChunkMesh& mesh, Add add) {
  using Side = SharpEdges::Side;
  const auto is_on_cut = [](const SharpEdges::Vertex& v) { return v.IsOn(Side::kCut); };
  const auto is_on_whole = [](const SharpEdges::Vertex& v) { return v.IsOn(Side::kWhole); };
  if (std::none_of(sharp.begin(), sharp.end(), is_on_cut) || std::none_of(sharp.begin(), sharp.end(), is_on_whole)) {
    return;
  }
  std::vector<std::array<std::uint32_t, 3>> triangles(mesh.triangles.size() / 3);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) triangles[i / 3][i % 3] = mesh.triangles[i];
  edges.SplitTriangles(sharp, triangles);
  for (std::size_t i = mesh.vertices.size(); i < sharp.size(); ++i) add(sharp[i], sharp[i].whole_outward, false);
  std::vector<std::optional<std::uint32_t>> of_cut_face(sharp.size());
  mesh.triangles.clear();
  for (std::array<std::uint32_t, 3>& triangle : triangles) {
    if (IsOnCutFace(sharp, triangle)) {
      bool is_cut = mesh.cut;
      for (const std::uint32_t i : triangle) {
        if (sharp[i].side == Side::kCut && mesh.vertices[i].cut == 0) is_cut = false;
      }
      for (std::uint32_t& i : triangle) {
        if (sharp[i].side != Side::kBoth) continue;
        if (!of_cut_face[i]) {
          add(sharp[i], sharp[i].cut_outward, is_cut);
          of_cut_face[i] = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
        }
        i = *of_cut_face[i];
      }
    }
    mesh.triangles.insert(mesh.triangles.end(), triangle.begin(), triangle.end());
  }
}

std::int8_t ToByte(double x) {
  return static_cast<std::int8_t>(std::lround(127 * x));
}

}  // namespace

struct BoneChunks::State {
  Bone bone;
  Index middle{};  // chunk whose corner is the origin of vertex coordinates
  std::unordered_map<Index, std::array<float, 512>, IndexHash> uncut;  // original values of changed leaves
  std::deque<Index> dirty;
  std::set<Index> is_dirty;

  double voxel_mm() const { return GridsOf(bone).voxel_mm(); }
  // Stores the values of an earlier state of the bone where they differ.
  void SetUncut(const Bone& before) {
    std::array<float, 512> now{};
    std::array<float, 512> then{};
    for (const Bone* of : {&before, static_cast<const Bone*>(&bone)}) {
      for (auto leaf = GridsOf(*of).phi->tree().cbeginLeaf(); leaf; ++leaf) {
        const openvdb::Coord& at = leaf->origin();
        const Index index{FloorDiv(at.x(), kLeaf), FloorDiv(at.y(), kLeaf), FloorDiv(at.z(), kLeaf)};
        GetLeaf(bone, index, now);
        GetLeaf(before, index, then);
        if (now != then) uncut.insert_or_assign(index, then);
      }
    }
  }
  // Returns true if a changed leaf contains samples of the chunk.
  bool IsTouched(const Index& chunk) const {
    if (uncut.empty()) return false;
    for (int x = -1; x <= kLeavesAcross; ++x) {
      for (int y = -1; y <= kLeavesAcross; ++y) {
        for (int z = -1; z <= kLeavesAcross; ++z) {
          if (uncut.count({kLeavesAcross * chunk[0] + x, kLeavesAcross * chunk[1] + y, kLeavesAcross * chunk[2] + z}) !=
              0) {
            return true;
          }
        }
      }
    }
    return false;
  }
};

BoneChunks::BoneChunks(Bone bone, const Bone* before) : state_(std::make_unique<State>()) {
  state_->bone = std::move(bone);
  if (before != nullptr && before->voxel_mm() == state_->bone.voxel_mm()) state_->SetUncut(*before);
  const openvdb::FloatGrid& phi = *GridsOf(state_->bone).phi;
  const openvdb::CoordBBox box = phi.evalActiveVoxelBoundingBox();
  if (!box.empty()) {
    for (int i = 0; i < 3; ++i) {
      state_->middle[static_cast<std::size_t>(i)] = FloorDiv(box.min()[i] + (box.max()[i] - box.min()[i]) / 2, kVoxels);
    }
  }
}

BoneChunks::~BoneChunks() = default;
BoneChunks::BoneChunks(BoneChunks&&) noexcept = default;
BoneChunks& BoneChunks::operator=(BoneChunks&&) noexcept = default;

const Bone& BoneChunks::bone() const {
  return state_->bone;
}

Vec3 BoneChunks::origin_W() const {
  const Index& m = state_->middle;
  return state_->voxel_mm() * kVoxels * Vec3{m[0], m[1], m[2]};
}

void BoneChunks::Take(const LeafMessage& leaf) {
  if (state_->uncut.count(leaf.index) == 0) {
    GetLeaf(state_->bone, leaf.index, state_->uncut[leaf.index]);
  }
  SetCut(state_->bone, leaf.index, leaf.values);
  // For each axis: the chunk that contains the leaf, and the chunk that the leaf borders on.
  std::array<std::array<int, 2>, 3> along{};
  for (std::size_t i = 0; i < 3; ++i) {
    const int chunk = FloorDiv(leaf.index[i], kLeavesAcross);
    const int place = leaf.index[i] - kLeavesAcross * chunk;
    along[i] = {chunk, place == 0 ? chunk - 1 : place == kLeavesAcross - 1 ? chunk + 1 : chunk};
  }
  for (const int x : along[0]) {
    for (const int y : along[1]) {
      for (const int z : along[2]) {
        if (state_->is_dirty.insert({x, y, z}).second) state_->dirty.push_back({x, y, z});
      }
    }
  }
}

std::vector<Index> BoneChunks::ListChunks(const Vec3& p_W) const {
  std::set<Index> chunks;
  for (auto leaf = GridsOf(state_->bone).phi->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord& at = leaf->origin();
    // A face belongs to the chunk with the lower end of its edge, which may be the previous chunk.
    std::array<std::array<int, 2>, 3> along{};
    for (int i = 0; i < 3; ++i) {
      const int chunk = FloorDiv(at[i], kVoxels);
      along[static_cast<std::size_t>(i)] = {chunk, at[i] == kVoxels * chunk ? chunk - 1 : chunk};
    }
    for (const int x : along[0]) {
      for (const int y : along[1]) {
        for (const int z : along[2]) chunks.insert({x, y, z});
      }
    }
  }
  std::vector<std::pair<double, Index>> by_distance;
  const double edge_mm = state_->voxel_mm() * kVoxels;
  for (const Index& i : chunks) {
    by_distance.emplace_back(glm::length(edge_mm * (Vec3{i[0], i[1], i[2]} + 0.5) - p_W), i);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<Index> list;
  list.reserve(by_distance.size());
  for (const auto& [distance, i] : by_distance) list.push_back(i);
  return list;
}

std::size_t BoneChunks::CountDirty() const {
  return state_->dirty.size();
}

std::vector<Index> BoneChunks::TakeDirty(std::size_t at_most) {
  std::vector<Index> taken;
  while (!state_->dirty.empty() && taken.size() < at_most) {
    taken.push_back(state_->dirty.front());
    state_->is_dirty.erase(state_->dirty.front());
    state_->dirty.pop_front();
  }
  return taken;
}

bool BoneChunks::Next(ChunkMesh& mesh) {
  const std::vector<Index> next = TakeDirty(1);
  if (next.empty()) return false;
  Mesh(next.front(), 1, mesh);
  return true;
}

void BoneChunks::Mesh(const Index& index, int step, ChunkMesh& mesh) const {
  if (std::find(kSteps.begin(), kSteps.end(), step) == kSteps.end()) {
    throw Error("the step of a chunk mesh must be 1, 2, 4 or 8");
  }
  mesh.index = index;
  mesh.step = step;
  mesh.cut = state_->IsTouched(index);
  mesh.vertices.clear();
  mesh.triangles.clear();
  mesh.skirt.clear();
  mesh.lower_W = mesh.upper_W = Vec3{0};

  const BoneGrids& grids = GridsOf(state_->bone);
  auto phi = grids.phi->getConstAccessor();
  thread_local std::vector<LeafValues> leaves;
  thread_local std::vector<LeafValues> uncut;
  leaves.clear();
  uncut.clear();
  bool inside = false;
  bool outside = false;
  bool own = false;
  const int beyond = Beyond(step);
  for (int x = -beyond; x < kLeavesAcross + beyond; ++x) {
    for (int y = -beyond; y < kLeavesAcross + beyond; ++y) {
      for (int z = -beyond; z < kLeavesAcross + beyond; ++z) {
        const Index leaf{kLeavesAcross * index[0] + x, kLeavesAcross * index[1] + y, kLeavesAcross * index[2] + z};
        const openvdb::Coord corner(kLeaf * leaf[0], kLeaf * leaf[1], kLeaf * leaf[2]);
        const auto* values = phi.probeConstLeaf(corner);
        if (values != nullptr) {
          leaves.push_back({values->buffer().data(), 0});
          own = true;
        } else {
          leaves.push_back({nullptr, phi.getValue(corner)});
          (leaves.back().uniform < 0 ? inside : outside) = true;
        }
        if (!mesh.cut) continue;
        uncut.push_back(leaves.back());
        const auto before = state_->uncut.find(leaf);
        if (before != state_->uncut.end()) uncut.back().values = before->second.data();
      }
    }
  }
  if (!own && !(inside && outside)) return;

  thread_local SampleBlock block;
  thread_local CellSurface surface;
  block.cells = kVoxels / step;
  FillSamples(leaves, step, block.phi);
  block.uncut.clear();
  if (mesh.cut) FillSamples(uncut, step, block.uncut);
  const double voxel_mm = state_->voxel_mm();
  MakeCellSurface(block, static_cast<float>(0.15 * step * voxel_mm), step > 1, surface);
  if (surface.vertices.empty()) return;

  auto region = grids.region->getConstAccessor();
  const double region_voxel_mm = grids.region_voxel_mm();
  const double below_mm = 0.5 * std::max(voxel_mm, region_voxel_mm);
  const Index& middle = state_->middle;
  const Vec3 origin = origin_W();
  Box3 box;
  mesh.vertices.reserve(surface.vertices.size());
  // Coarse cells are wider than the narrow band, so their normals are computed from the level set itself.
  const double h_vox = mesh.cut ? 0.5 : 1;
  const auto gradient = [&](const Vec3& p_vox) {
    Vec3 g{0};
    for (int i = 0; i < 3; ++i) {
      Vec3 d{0};
      d[i] = h_vox;
      g[i] = SampleTrilinear(phi, p_vox + d) - SampleTrilinear(phi, p_vox - d);
    }
    return g;
  };
  const auto add = [&](const Vec3& p_vox, const Vec3& normal, bool is_cut) {
    ChunkVertex out{};
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      out.p_mm[k] = static_cast<float>(p_vox[i] * voxel_mm);
      out.normal[k] = ToByte(normal[i]);
    }
    const Vec3 p = p_vox * voxel_mm + origin;
    box.Include(p);
    int id = 0;
    for (int k = 1; k <= 4 && id == 0; ++k)
      id = region.getValue(NearestVoxel(p - k * below_mm * normal, region_voxel_mm));
    out.region = static_cast<std::uint8_t>(id);
    out.cut = is_cut ? 255 : 0;
    mesh.vertices.push_back(out);
  };
  using Side = SharpEdges::Side;
  std::optional<SharpEdges> edges;
  if (step == 1 && grids.cut) edges.emplace(grids);
  std::vector<SharpEdges::Vertex> sharp;  // with `edges`: where each vertex was moved
  const Vec3 origin_vox = static_cast<double>(kVoxels) * Vec3{middle[0], middle[1], middle[2]};
  for (const CellVertex& v : surface.vertices) {
    Vec3 p_vox{0};
    Vec3 normal{0};
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const int cell = kVoxels * (index[k] - middle[k]) + step * v.cell[k];
      p_vox[i] = cell + step * static_cast<double>(v.within[k]);
      normal[i] = static_cast<double>(v.normal[k]);
    }
    if (step > 1) normal = CalcDirection(gradient(p_vox + origin_vox)).value_or(normal);
    bool is_cut = v.cut;
    if (edges) {
      const SharpEdges::Vertex& moved = sharp.emplace_back(edges->Move(p_vox + origin_vox));
      p_vox = moved.p_vox - origin_vox;
      normal = CalcDirection(moved.side == Side::kCut ? moved.cut_outward : moved.whole_outward).value_or(normal);
      is_cut = is_cut && moved.side == Side::kCut;
    }
    add(p_vox, normal, is_cut);
  }
  mesh.triangles = surface.triangles;
  if (edges) {
    SplitAtEdges(*edges, sharp, mesh, [&](const SharpEdges::Vertex& v, const Vec3& outward, bool is_cut) {
      add(v.p_vox - origin_vox, CalcDirection(outward).value_or(Vec3(0, 0, 1)), is_cut);
    });
  }
  mesh.skirt = surface.skirt;
  mesh.lower_W = box.lower;
  mesh.upper_W = box.upper;
}

std::size_t BoneChunks::CalcMemoryBytes() const {
  return static_cast<std::size_t>(state_->bone.CalcMemoryBytes()) +
         state_->uncut.size() * (sizeof(Index) + 512 * sizeof(float) + 16);
}

bool FindSurface(const Bone& bone, const Vec3& origin_W, const Vec3& direction_W, Vec3& p_W) {
  const BoneGrids& grids = GridsOf(bone);
  const double voxel_mm = grids.voxel_mm();
  const openvdb::CoordBBox voxels = grids.phi->evalActiveVoxelBoundingBox();
  if (voxels.empty()) return false;
  // The ray is followed only within the box of the narrow band.
  double from = 0;
  double to = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double lower = (voxels.min()[i] - 1) * voxel_mm;
    const double upper = (voxels.max()[i] + 1) * voxel_mm;
    if (std::abs(direction_W[i]) < 1e-12) {
      if (origin_W[i] < lower || origin_W[i] > upper) return false;
      continue;
    }
    const double a = (lower - origin_W[i]) / direction_W[i];
    const double b = (upper - origin_W[i]) / direction_W[i];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  const PartsReader phi(grids);
  const auto value = [&](double t) { return phi.Sample((origin_W + t * direction_W) / voxel_mm); };
  double before = from;
  for (double t = from; t <= to;) {
    const double here = value(t);
    if (here < 0) {
      double outside = before;
      double inside = t;
      for (int i = 0; i < 40 && inside - outside > 1e-6 * voxel_mm; ++i) {
        const double mid = 0.5 * (outside + inside);
        (value(mid) < 0 ? inside : outside) = mid;
      }
      p_W = origin_W + inside * direction_W;
      return true;
    }
    before = t;
    t += std::max(0.4 * voxel_mm, 0.7 * here);
  }
  return false;
}

}  // namespace kerf
