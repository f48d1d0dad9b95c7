// The surface of a bone that is being cut, in chunks that are meshed anew where it changes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "kerf/bone.h"
#include "loop/haptics/leaf_stream.h"

namespace kerf {

/// A vertex, 20 bytes, as the graphics card gets it.
struct ChunkVertex {
  std::array<float, 3> p_mm;          // from BoneChunks::origin_W()
  std::array<std::int8_t, 3> normal;  // outward, times 127
  std::uint8_t region;                // just below the surface; 0: none
  std::uint8_t cut;                   // 255 where the bone was cut, 0 where it is as it was
  std::array<std::uint8_t, 3> unused;
};

/// The surface within one chunk, at one fineness: `step` 1, 2, 4 or 8 voxels a cell.
struct ChunkMesh {
  std::array<int, 3> index{};  // of 32 voxels, from the world's origin
  int step = 1;
  bool cut = false;  // one of its leaves has changed since the beginning
  std::vector<ChunkVertex> vertices;
  std::vector<std::uint32_t> triangles;  // three each, counter-clockwise from outside
  std::vector<std::uint32_t> skirt;  // likewise, into the chunks above: to be drawn where those are finer; not step 1
  Vec3 lower_W{0}, upper_W{0};       // holds the vertices; both 0 when there are none

  std::size_t CountBytes() const {
    return vertices.size() * sizeof(ChunkVertex) + (triangles.size() + skirt.size()) * 4;
  }
};

/// One thread. The surface is that of dual cells ("surface nets"): a vertex in each cell that the surface goes through,
/// in the middle of where it crosses the cell's edges. Chunks of one step join without gaps: together they are closed.
class BoneChunks {
 public:
  static constexpr int kVoxels = 32;  // a chunk's edge
  static constexpr std::array<int, 4> kSteps{8, 4, 2, 1};

  /// `bone`: as it is before the cutting; its surface now is what later counts as not cut.
  explicit BoneChunks(Bone bone);
  ~BoneChunks();
  BoneChunks(BoneChunks&&) noexcept;
  BoneChunks& operator=(BoneChunks&&) noexcept;

  const Bone& bone() const;
  /// What points are counted from: a chunk's corner near the middle of the bone.
  Vec3 origin_W() const;

  /// Gives a leaf its new values; its chunk and those that it borders on are dirty.
  void Take(const LeafMessage& leaf);
  /// Chunks that may hold a surface, nearest to `p_W` first.
  std::vector<std::array<int, 3>> ListChunks(const Vec3& p_W) const;
  std::size_t CountDirty() const;
  /// The chunks that have changed since they were asked for, oldest first; at most so many.
  std::vector<std::array<int, 3>> TakeDirty(std::size_t at_most);
  /// Meshes one dirty chunk at step 1; false when there is none.
  bool Next(ChunkMesh& mesh);
  /// Meshes any chunk, empty or not. `step`: one of kSteps. Several threads may do so at once while nobody calls
  /// Take().
  void Mesh(const std::array<int, 3>& index, int step, ChunkMesh& mesh) const;

  std::size_t CalcMemoryBytes() const;  // of the bone, and of what is kept of it uncut

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Where a ray first meets the bone; none when it does not. Steps by the level set's distances. Error: below a
/// thousandth of a voxel for a flat surface.
bool FindSurface(const Bone& bone, const Vec3& origin_W, const Vec3& direction_W, Vec3& p_W);

}  // namespace kerf
