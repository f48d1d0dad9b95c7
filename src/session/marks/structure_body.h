// The voxels of a structure in the bone, and whether they still connect its two ends after a cut.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/bone.h"
#include "session/marks/mark_tube.h"
#include "session/marks/region_parts.h"

namespace kerf {

/// The largest connected part of a structure's voxels of phi's grid that are bone before the cut. Voxels are connected
/// if they share a face, as in the pieces of a bone. The ends of the structure are the places of this part that are
/// furthest from each other, measured through it.
class StructureBody {
 public:
  /// A part of the bone's regions.
  StructureBody(const Bone& before, const RegionParts& parts, int part);
  StructureBody(const Bone& before, const MarkTube& tube);

  /// Returns true if no path through bone connects the structure's ends any more: it is cut over its whole
  /// cross-section. False if it has no voxels, or more than kMaxVoxels in its box.
  bool IsSevered(const Bone& after) const;
  static constexpr std::size_t kMaxVoxels = 100'000'000;

 private:
  using Index = std::array<int, 3>;
  bool Allocate(const Box3& box_W);
  void Set(const PhiSampler& before, const Index& voxel);
  void FindEnds();
  Vec3 PointOf(std::size_t i) const;
  /// Calls visit(voxel, steps) for `from` and for the voxels that can be reached from there and are not `seen` yet, the
  /// nearest first. `enter`: returns true for voxels that may be visited.
  template <typename Enter, typename Visit>
  void Flood(std::vector<std::size_t> from, std::vector<bool>& seen, Enter&& enter, Visit&& visit) const;

  double h_;
  Index lower_{0, 0, 0};      // voxel at index 0
  Index size_{0, 0, 0};       // with a margin of one voxel that is never set
  std::vector<bool> inside_;  // z fastest
  std::vector<std::size_t> first_end_;
  std::vector<bool> second_end_;
};

}  // namespace kerf
