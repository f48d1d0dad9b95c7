// What a bone has lost, cell by cell.
#pragma once

#include <array>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// A cell (bone/cell_volume.h) that holds less bone than before.
struct RemovedCell {
  Vec3 p_W{0};       // the middle of what it lost
  double mm3 = 0;    // that it lost; below 0: gained
  int region = 0;    // at its middle, before
  double in_mm = 0;  // so deep in the bone as it was, up to the band's width
};

/// Where `after`, a copy of `before` that was cut, differs from it; their sum is the difference of their volumes. In
/// the order of the grid. Blocks that were whole before and are wholly empty now (a piece taken out) are not among
/// them. Throws Error when their voxels are not of one size.
std::vector<RemovedCell> FindRemoved(const Bone& before, const Bone& after);

/// The regions of a tissue, by the bone's table.
std::array<bool, 256> FindRegionsOf(const Bone& bone, Tissue tissue);

/// phi of a bone at many points near each other: as Bone::SignedDistance(), quicker.
class PhiSampler {
 public:
  /// The bone must outlive it and stay as it is.
  explicit PhiSampler(const Bone& bone);
  ~PhiSampler();
  PhiSampler(PhiSampler&&) noexcept;
  PhiSampler& operator=(PhiSampler&&) noexcept;
  double Calc(const Vec3& p_W) const;
  double voxel_mm() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
