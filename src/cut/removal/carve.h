// The innermost loop of removal: subtracts the sweep of one step of the tool from one leaf of the bone. It is
// vectorised and bit-identical at every vector width.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cut/tool/carve_step.h"

namespace kerf {

/// Result of CarveLeaf().
struct CarveLoss {
  double voxels = 0;  // occupancy before, less occupancy after
  int changed = 0;    // changed voxels
};

/// Values of a leaf: 512 each, mm, z fastest (see BoneField).
struct CarvedLeaf {
  float* cut;
  const float* whole = nullptr;  // null where the whole bone fills the leaf: phi is then `cut`
  float* phi = nullptr;          // to be set as well if `whole` is not null; may be null
};

/// Returns the bricks of a leaf that the step may change: bit 8 x + 2 (y / 2) + z / 4 for that of voxel (x, y, z).
/// `corner_T`: position of its lowest voxel. Tick-safe.
std::uint64_t FindBricks(const CarveStep& step, const std::array<float, 3>& corner_T);
/// Sets cut <- max(cut, -distance to the sweep of the step) in these bricks, except in air beyond the band, and phi <-
/// max(whole, cut). Tick-safe.
CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, std::uint64_t bricks,
                    const CarvedLeaf& leaf);

/// Test that finds the leaves near a zone about the tool's edge. Lengths in mm.
struct LeafCull {
  float axes[3][3];        // [i]: axis i of the tool frame, in the frame of the middles
  float origin[3];         // origin of the middles' frame, in the tool frame
  float half_edges[3][3];  // [i]: from a leaf's middle to its outermost voxels along grid axis i, tool frame
  float half_leaf2;        // square of the distance from a leaf's middle to its corner voxel
  float back[3];           // CarveStep::back; zero if no leaf behind the step is to be left out
  float behind;            // leaves whose middle is further along `back` than this are left out
  /// Leaves whose middle is further along `across` than `receded`, and not outside of these heights, are left out.
  /// kNone: no leaf is.
  static constexpr float kNone = 1e9f;
  float across[2];
  float receded;
  float receded_low, receded_high;
  float axial;         // leaves whose middle has a larger |z| are left out
  float axial_counts;  // 0: distance to the tool's axis (disc); 1: distance to its centre (ball)
  float inner;         // at least one voxel must have at least this distance
  float outer;         // at least one voxel must have at most this distance
  float min_distance;  // a small distance, lower bound on a divisor
  /// Blade with an outline: at least one voxel must lie at most `side_out` outside of all sides, at most `side_in`
  /// inside of the nearest side, and at most `side_depth` inside of the nearest side that cuts.
  int sides;
  CarveStep::Side side[CarveStep::kMaxSides];
  float side_out, side_in, side_depth;
  float half_diagonal;  // of the voxels of a leaf
};

/// Middles of leaves, in float. The arrays are aligned to 64 bytes and readable up to a multiple of 16 elements.
struct LeafMiddles {
  const float* x;
  const float* y;
  const float* z;
};

/// Sets a bit in `near` for each of the first `count` leaves that may have a voxel in the zone. A cleared bit
/// guarantees that the leaf has none. Tick-safe.
void FindLeaves(const LeafCull& cull, const LeafMiddles& middles, int count, std::uint64_t* near);

/// Returns the vector instruction sets of this machine, widest first, in lower case ("avx3" is AVX-512).
std::vector<std::string> VectorTargets();
/// Returns the instruction set in use.
std::string VectorTarget();
/// Selects the instruction set by name; "" selects the best. For tests, and for tools that do not support wide vectors
/// (valgrind). Throws Error if the machine does not have it. Must not be called during a tick.
void SetVectorTarget(std::string_view name);

}  // namespace kerf
