// Buffers on the graphics card that many meshes share, so that one call draws many of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "view/live/bone_chunks.h"

namespace kerf {

/// Meshes in the current OpenGL context, in pages of equal size.
class ChunkBuffers {
 public:
  /// A mesh in a page. A default one is empty.
  struct Place {
    int page = -1;  // -1: none
    std::uint32_t vertices = 0;
    std::uint32_t first_vertex = 0;
    std::uint32_t indices = 0;
    std::uint32_t first_index = 0;
  };

  ChunkBuffers();
  ~ChunkBuffers();  // call Clear() first, while the context exists

  /// `unit_mm`: in which positions are stored, as whole numbers of 16 bits. Call it without meshes only.
  void set_unit_mm(double unit_mm) { unit_mm_ = unit_mm; }
  /// Stores a mesh, with its skirt after its triangles, in place of an earlier one.
  void Put(const ChunkMesh& mesh, Place& place);
  void Remove(Place& place);
  void Clear();
  std::size_t CountBytes() const;  // of all pages, used or not
  /// Draws the first `corners` indices of some meshes, in their order. A program must be in use.
  struct ToDraw {
    const Place* place = nullptr;
    std::uint32_t corners = 0;
  };
  void Draw(std::span<const ToDraw> meshes);

 private:
  struct Page;
  int FindPage(std::uint32_t vertices, std::uint32_t indices, Place& place);

  double unit_mm_ = 1;
  std::vector<std::unique_ptr<Page>> pages_;
  // Of the call that Draw() prepares.
  std::vector<std::int32_t> counts_, first_vertices_;
  std::vector<const void*> offsets_;
};

}  // namespace kerf
