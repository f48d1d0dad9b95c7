// From the samples of a chunk to its triangles.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Samples of a level set on a lattice: `cells` owned cells along each axis, one layer of cells before them, and a
/// sample more at each end for normals: cells + 4 samples, z fastest; the first owned cell's lower corner is sample
/// (2, 2, 2).
struct SampleBlock {
  int cells = 0;
  std::vector<float> phi;
  std::vector<float> uncut;  // likewise, as it was before any cutting; empty: the same

  int samples() const { return cells + 4; }
};

/// A vertex in cell units: the first owned cell's lower corner is 0.
struct CellVertex {
  std::array<int, 3> cell;      // -1 to cells - 1
  std::array<float, 3> within;  // of the cell, 0 to 1
  std::array<float, 3> normal;  // unit, outward
  bool cut;                     // not on the surface as it was
};

struct CellSurface {
  std::vector<CellVertex> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> skirt;           // as triangles; not of the surface
  std::vector<std::uint32_t> vertex_of_cell;  // scratch
  std::vector<std::uint64_t> signs;           // scratch

  void Clear();
};

/// Dual cells. A face goes to the block that owns the edge which the surface crosses, at that edge's lower end; a
/// vertex is the same to the bit in each block that has its cell. `cut_depth`: a vertex deeper than this under the
/// uncut surface is cut, in the units of phi. `skirt`: also the faces that reach half a cell into the blocks above,
/// which close the gap where those are drawn with smaller cells.
void MakeCellSurface(const SampleBlock& block, float cut_depth, bool skirt, CellSurface& surface);

}  // namespace kerf
