// Bone that was removed, cell by cell.
#pragma once

#include <array>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// A cell (bone/grid/cell_volume.h) whose volume of bone has changed.
struct RemovedCell {
  Vec3 p_W{0};       // centre of the lost bone
  double mm3 = 0;    // lost volume; negative if bone was gained
  int region = 0;    // at p_W, before the cut
  double in_mm = 0;  // depth of p_W below the surface before the cut, at most the band's width
};

/// Returns the leaves in which two bones differ: along each axis the voxel's index divided by 8, rounded down.
std::vector<std::array<int, 3>> FindChangedLeaves(const Bone& before, const Bone& after);

/// Returns the changed cells whose lowest corner is in the leaf. See FindRemoved().
std::vector<RemovedCell> FindRemovedInLeaf(const Bone& before, const Bone& after, const std::array<int, 3>& leaf);
/// Returns the leaf and its neighbours: those whose cells' volumes depend on its values (see CellFields).
std::array<std::array<int, 3>, 27> FindCellLeaves(const std::array<int, 3>& leaf);

/// Finds the cells in which `after`, a cut copy of `before`, differs from it; the sum of their volumes is the
/// difference between the bones' volumes. The cells are in the order of the grid. A piece that was taken out counts as
/// removed. Throws kerf::Error if the voxel sizes differ.
std::vector<RemovedCell> FindRemoved(const Bone& before, const Bone& after);

/// Returns which regions belong to a tissue, according to the bone's material table.
std::array<bool, 256> FindRegionsOf(const Bone& bone, Tissue tissue);

/// Evaluates phi of a bone at many points near each other: like Bone::SignedDistance(), but faster.
class PhiSampler {
 public:
  /// The bone must outlive the sampler and must not change.
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
