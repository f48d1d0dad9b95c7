// The innermost loop: one leaf of the bone, less what one step of the tool sweeps. Vectorised, the same bits at every
// width.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// One step of the tool, in its own frame at the end of the step; mm. The tool comes from `back` * `length`.
struct CarveStep {
  bool ball = false;          // else a disc, whose `back` has no z
  bool whole_voxels = false;  // phi in steps of a voxel
  int precision_bits = 24;    // of phi's significand that are kept, 4 to 24: all of a float's
  bool new_only = false;      // leave out what the step before has carved as far: it ended where this one begins
  float radius = 0;
  float half_thickness = 0;  // of a disc
  float edge_depth = 0;      // a disc cuts only so far inside its rim
  float back[3] = {0, 0, 0};
  float length = 0;
  float flank_slack = 0;  // new_only: how far the flats may lie from where they cut last
  float band = 0;
  float voxel = 0;
  float rounding = 0;       // what float arithmetic may be off by
  float grid[3][3] = {{}};  // [i]: the step to the next voxel along axis i of the bone's grid
  /// Works out what follows from the above, the same for all leaves.
  void Prepare();
  alignas(64) float across[3][8] = {{}};  // [i]: from a leaf's first row to the next ones along y, tool axis i
  alignas(64) float along[3][16] = {{}};  // from a row's first voxel to the others, twice over
  float row_mm = 0;                       // half a row's length, of a disc in its plane
  float bend_mm = 0;    // by how much at most a row's end lies farther out than along the tangent at its middle
  float behind_mm = 0;  // the middles of rows with a voxel that is not behind the start lie below this
};

struct CarveLoss {
  double voxels = 0;  // occupancy before less after
  int rows = 0;       // of eight voxels, worked out
  int changed = 0;    // voxels
};

/// phi <- max(phi, -distance to what the step sweeps) in a leaf: 512 values, mm, z fastest; `corner_T`: its lowest
/// voxel. Tick-safe.
CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, float* values);

/// Which leaves come near a zone about the tool's edge. Lengths in mm.
struct LeafCull {
  float axes[3][3];        // [i]: the tool frame's axis i in the frame of the middles
  float origin[3];         // of the middles' frame, in the tool frame
  float half_edges[3][3];  // [i]: from a leaf's middle to its outermost voxels along the grid's axis i, tool frame
  float half_leaf2;        // square of the same to its corner
  float back[3];           // leaves behind the step are left out: middles whose way along this is more than
  float behind;            // this
  float axial;             // and those with |z| above this
  float axial_counts;      // 0: the distance is to the tool's axis (a disc); 1: to its centre (a ball)
  float inner;             // some voxel at least so far from it
  float outer;             // and some at most so far
  float least;             // a small distance
};

/// Middles of leaves, in float; the arrays are aligned to 64 bytes and may be read up to a multiple of 16.
struct LeafMiddles {
  const float* x;
  const float* y;
  const float* z;
};

/// Sets a bit in `near` for each of the first `count` leaves that may have a voxel in the zone; never wrong when it
/// says no. Tick-safe.
void FindLeaves(const LeafCull& cull, const LeafMiddles& middles, int count, std::uint64_t* near);

/// The vector instruction sets that this machine has, widest first, in lower case ("avx3" is AVX-512).
std::vector<std::string> VectorTargets();
/// The one in use.
std::string VectorTarget();
/// Uses one of them from here on; "" for the best. For tests and for tools that know no wide vectors (valgrind).
/// Throws Error when the machine does not have it. Not while a tick runs.
void SetVectorTarget(std::string_view name);

}  // namespace kerf
