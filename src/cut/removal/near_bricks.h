// Bricks of voxels near the tool's edge, by leaf, searched again only after the tool has moved some distance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "cut/removal/carve.h"
#include "cut/removal/sweep.h"

namespace kerf {

/// A leaf is divided into bricks of 2 x 4 voxels (CarveStep), of which a step changes few. Those that any step may
/// change while no point of the edge moves by more than a slack are found once and kept until it has. How far the edge
/// has moved is bounded by the sum of its ways, so that a hand that trembles is covered too.
///
/// The results do not depend on what is kept, apart from the rounding of values that a step leaves as they are. For a
/// blade with an outline nothing is kept.
class NearBricks {
 public:
  /// `leaves`: a bound on the number of leaves near the edge. Allocates.
  NearBricks(double voxel_mm, std::size_t leaves);

  /// Begins a step, which may start anywhere. `sweep` must outlive the calls of Find(). `same_zone`: false if it sweeps
  /// another zone than the other steps; nothing is kept for it. Tick-safe.
  void Begin(const Sweep& sweep, const Pose& X_from, bool same_zone);
  /// Returns the bricks of a leaf that the step may change, a bit each. `corner_T`: as for CarveLeaf(). Tick-safe.
  std::uint64_t Find(const LeafIndex& leaf, const std::array<float, 3>& corner_T);
  /// Number of leaves searched in this step.
  int searched() const { return searched_; }
  std::size_t CalcMemoryBytes() const { return kept_.capacity() * sizeof(Kept); }

 private:
  struct Kept {
    LeafIndex leaf{std::numeric_limits<int>::max(), 0, 0};
    bool all_zone = false;  // found for a step that is not CarveStep::new_only
    double until_mm = 0;    // value of moved_mm_ up to which they are valid
    std::uint64_t bricks = 0;
  };
  Kept& KeptOf(const LeafIndex& leaf);

  double voxel_mm_;
  std::vector<Kept> kept_;  // by a hash of the leaf; the last leaf that was looked for replaces another one
  Pose X_last_;
  double moved_mm_ = 0;  // sum of the bounds on the edge's ways
  const CarveStep* step_ = nullptr;
  bool keeps_ = false;  // in this step
  int searched_ = 0;
  double way_mm_ = 0;  // bound on the edge's way in this step
  double slack_mm_ = 0;
  std::optional<CarveStep> widened_;  // made when first needed in a step
};

}  // namespace kerf
