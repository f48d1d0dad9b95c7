// Bricks of voxels near the tool's edge, by leaf, searched again only after the tool has moved some distance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cut/removal/carve.h"
#include "cut/removal/sweep.h"

namespace kerf {

/// A leaf is divided into bricks of 2 x 4 voxels (CarveStep), of which a step changes few. Those that any step may
/// change while no point of the edge moves by more than a slack are found once, and kept for a part of that slack. How
/// far the edge has moved is bounded by the sum of its ways, also if it turns back. Nothing is kept in a step that is
/// too long for this, for a blade with an outline, and for a solid of revolution, whose sides a step's direction
/// excludes.
///
/// A kept brick that a step would not have found is computed too. Its values can grow by their rounding.
class NearBricks {
 public:
  /// `origin`: a leaf that moves with the bone, so that the results do not depend on where in the world it is.
  /// `leaves`: a bound on the number of leaves near the edge. Allocates.
  NearBricks(double voxel_mm, const LeafIndex& origin, std::size_t leaves);

  /// Returns whether bricks are kept for a tool.
  static bool Keeps(const EdgeZone& zone) { return zone.outline.empty() && !zone.solid; }

  /// Discards all that is kept, so that a new cut does not depend on earlier ones. Tick-safe.
  void Forget();
  /// Begins a step from X_from, where the last one since Forget() ended. `sweep` must outlive the calls of Find().
  /// `same_zone`: false if it sweeps another zone than the other steps; nothing is kept for it. Tick-safe.
  void Begin(const Sweep& sweep, const Pose& X_from, bool same_zone);
  /// Returns the bricks of a leaf that the step may change, a bit each. `corner_T`: as for CarveLeaf(). Tick-safe.
  std::uint64_t Find(const LeafIndex& leaf, const std::array<float, 3>& corner_T);
  /// Number of leaves searched in this step.
  int searched() const { return searched_; }
  std::size_t CalcMemoryBytes() const { return kept_.capacity() * sizeof(Kept); }

 private:
  struct Kept {
    LeafIndex leaf;
    std::uint32_t epoch = 0;
    bool all_zone = false;  // found for a step that is not CarveStep::new_only
    double until_mm = 0;    // value of moved_mm_ up to which they are valid
    std::uint64_t bricks = 0;
  };
  double voxel_mm_;
  LeafIndex origin_;
  std::vector<Kept> kept_;   // by a hash of the leaf; the one searched last replaces another
  std::uint32_t epoch_ = 1;  // rises with each Forget()
  double moved_mm_ = 0;      // sum of the bounds on the edge's ways since then
  const CarveStep* step_ = nullptr;
  bool keeps_ = false;  // in this step
  int searched_ = 0;
  double way_mm_ = 0;                 // bound on the edge's way in this step
  std::optional<CarveStep> widened_;  // for the search, if not the step itself
};

}  // namespace kerf
