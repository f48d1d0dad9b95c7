// Triangulates the samples of a chunk.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Level set samples on a lattice. There are `cells` owned cells along each axis, one layer of cells before them, and
/// one extra sample at each end for normals: cells + 4 samples, z fastest. The lower corner of the first owned cell is
/// sample (2, 2, 2).
struct SampleBlock {
  int cells = 0;
  std::vector<float> phi;
  std::vector<float> uncut;  // same layout, before any cutting; empty: equal to `phi`

  int samples() const { return cells + 4; }
};

/// Vertex in cell units; the lower corner of the first owned cell is 0.
struct CellVertex {
  std::array<int, 3> cell;      // -1 to cells - 1
  std::array<float, 3> within;  // position within the cell, 0 to 1
  std::array<float, 3> normal;  // unit, outward
  bool cut;                     // true if not on the original surface
};

struct CellSurface {
  std::vector<CellVertex> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> skirt;           // triangles that are not part of the surface
  std::vector<std::uint32_t> vertex_of_cell;  // scratch
  std::vector<std::uint64_t> signs;           // scratch

  void Clear();
};

/// Meshes a block with dual cells. A face belongs to the block that owns the lower end of the cell edge that the
/// surface crosses. A vertex is bit-identical in each block that contains its cell. `cut_depth`: a vertex deeper than
/// this below the uncut surface counts as cut; in units of phi. `skirt`: also adds the faces that reach half a cell
/// into the next blocks up; they close the gap where those blocks are drawn with smaller cells.
void MakeCellSurface(const SampleBlock& block, float cut_depth, bool skirt, CellSurface& surface);

}  // namespace kerf
