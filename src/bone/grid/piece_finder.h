// Pieces of a bone that is being cut, updated from its changed leaves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "bone/grid/leaf_mask.h"
#include "kerf/bone.h"

namespace kerf {

/// A piece at the time of the last Find().
struct FoundPiece {
  int id = 0;    // from 1; never changes. When a piece falls apart, the largest part keeps the id; the others get new
                 // ones.
  int from = 0;  // id of the piece that it separated from; 0: none, it existed from the start
  std::size_t voxels = 0;
  double volume_mm3 = 0;  // sum of its voxels
  Box3 bounds_W;          // of its voxels; world frame, mm
};

struct FoundPieces {
  std::vector<FoundPiece> pieces;      // largest first
  std::vector<FoundPiece> came_off;    // pieces that separated in the last Find(); none at the start
  std::size_t dust_count = 0;          // number of connected sets of voxels that are smaller than a piece
  double dust_mm3 = 0;                 // their total volume
  const FoundPiece* At(int id) const;  // null if there is none
};

/// Finds and tracks the pieces of a bone. Two inside voxels (phi < 0) are connected if they share a face, as in
/// SplitPieces().
///
/// The connected parts of each leaf are kept as masks, together with the contacts between parts of neighbouring leaves.
/// A changed leaf is analysed on its own, in one microsecond; Find() then only joins parts, thousands of them for
/// millions of voxels. To be used by one thread at a time; not tick-safe. The memory needed is proportional to the
/// number of leaves that contain bone at the start, plus the size of their box. It grows only for leaves that fall
/// apart into several parts.
class PieceFinder {
 public:
  /// Pieces whose voxels have a volume of less than `dust_mm3` are dust. Allocates; finds the initial pieces.
  PieceFinder(const Bone& bone, double dust_mm3);
  ~PieceFinder();
  PieceFinder(PieceFinder&&) noexcept;
  PieceFinder& operator=(PieceFinder&&) noexcept;

  /// Updates the leaf `index` (along each axis the voxel's index divided by 8, rounded down) with its 512 new values,
  /// ordered as in set_leaf.h. Returns false if no voxel changed between inside and outside.
  bool Change(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// Returns whether Change() has returned true since the last Find().
  bool changed() const;
  const FoundPieces& Find();
  const FoundPieces& found() const;

  /// Returns the region with the largest fraction of a piece at the last Find(), estimated from one voxel per leaf
  /// part; 0: none.
  int FindMainRegion(int id) const;
  /// Calls visit(leaf, voxels) for the leaves of a piece (0: of all dust) at the last Find(). A leaf may be visited
  /// more than once.
  void ForEachLeaf(int id, const std::function<void(const std::array<int, 3>&, const LeafMask&)>& visit) const;
  double dust_mm3() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
