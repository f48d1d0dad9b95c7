// Surface of a bone that is being cut, in chunks that are remeshed where the bone changes.
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

struct ChunkVertex {
  std::array<float, 3> p_mm;          // relative to BoneChunks::origin_W()
  std::array<std::int8_t, 3> normal;  // outward, times 127
  std::uint8_t region;                // region just below the surface; 0: none
  std::uint8_t cut;                   // 255 on a cut face, 0 on the original surface
};

/// Surface within one chunk at one resolution: cells of `step` = 1, 2, 4 or 8 voxels.
struct ChunkMesh {
  std::array<int, 3> index{};  // in chunks of 32 voxels, from the world's origin
  int step = 1;
  bool cut = false;  // at least one of its leaves has changed since the beginning
  std::vector<ChunkVertex> vertices;
  std::vector<std::uint32_t> triangles;  // three indices each, counter-clockwise seen from outside
  std::vector<std::uint32_t> skirt;      // triangles that reach into the next chunks up; drawn where those are finer;
                                         // empty for step 1
  Vec3 lower_W{0}, upper_W{0};           // bounding box of the vertices; both 0 if there are none
};

/// Chunked mesh of a bone's level set. Not thread-safe unless stated otherwise. The mesh is a dual mesh ("surface
/// nets"): one vertex in each cell that the surface crosses, at the mean of its crossings with the cell's edges. Chunks
/// of equal step join without gaps and together form a closed surface.
class BoneChunks {
 public:
  static constexpr int kVoxels = 32;  // edge length of a chunk
  static constexpr std::array<int, 4> kSteps{8, 4, 2, 1};

  /// `before`: the bone before any cutting, with the same voxels; its surface counts as uncut. Null: `bone` itself.
  explicit BoneChunks(Bone bone, const Bone* before = nullptr);
  ~BoneChunks();
  BoneChunks(BoneChunks&&) noexcept;
  BoneChunks& operator=(BoneChunks&&) noexcept;

  const Bone& bone() const;
  /// Returns the origin of vertex coordinates: a corner of the chunk near the middle of the bone.
  Vec3 origin_W() const;

  /// Sets the values of a leaf and marks its chunk and the chunks it borders on as dirty.
  void Take(const LeafMessage& leaf);
  /// Returns the chunks that may contain surface, sorted by distance from `p_W`, nearest first.
  std::vector<std::array<int, 3>> ListChunks(const Vec3& p_W) const;
  std::size_t CountDirty() const;
  /// Removes and returns at most `at_most` dirty chunks (changed since they were last taken), oldest first.
  std::vector<std::array<int, 3>> TakeDirty(std::size_t at_most);
  /// Meshes one dirty chunk at step 1. Returns false if no chunk is dirty.
  bool Next(ChunkMesh& mesh);
  /// Meshes any chunk, empty or not. `step`: one of kSteps; throws Error for any other. Several threads may call it at
  /// once while no thread calls Take().
  void Mesh(const std::array<int, 3>& index, int step, ChunkMesh& mesh) const;

  std::size_t CalcMemoryBytes() const;  // of the bone and of the stored original values

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Finds the first intersection of a ray with the bone, stepping by the distances in the level set. Returns false if
/// there is none. For a flat surface, the position found is wrong by less than a thousandth of a voxel.
bool FindSurface(const Bone& bone, const Vec3& origin_W, const Vec3& direction_W, Vec3& p_W);

}  // namespace kerf
