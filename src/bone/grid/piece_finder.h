// The pieces of a bone that is being cut, kept up to date from its changed leaves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// The voxels of a leaf, a bit each: a word for each x, in it 8 y + z.
using LeafMask = std::array<std::uint64_t, 8>;

/// A piece as it was found last.
struct FoundPiece {
  int id = 0;    // from 1 on, for good. What comes apart: the largest part keeps the number, the others get new ones.
  int from = 0;  // the piece that it came off; 0: it was there from the start
  std::size_t voxels = 0;
  double volume_mm3 = 0;  // of its voxels
  Box3 bounds_W;          // of its voxels, world, mm
};

struct FoundPieces {
  std::vector<FoundPiece> pieces;      // largest first
  std::vector<FoundPiece> came_off;    // of them, those that the last Find() gave a number; none at the start
  std::size_t dust_count = 0;          // connected voxels that are smaller than a piece
  double dust_mm3 = 0;                 // together
  const FoundPiece* At(int id) const;  // null: there is none
};

/// Two inside voxels (phi < 0) belong together when they share a face, as in SplitPieces().
///
/// Of each leaf the connected parts are kept as masks, and which of them touch across leaves. A changed leaf is looked
/// at anew by itself (a microsecond); Find() then joins parts, thousands of them where there are millions of voxels.
/// One thread at a time; not tick-safe. Memory goes with the leaves that hold bone at the start and with their box; it
/// does not grow but for leaves that fall into several parts.
class PieceFinder {
 public:
  /// Pieces smaller than `dust_mm3` by their voxels are dust. Allocates; finds what pieces there are.
  PieceFinder(const Bone& bone, double dust_mm3);
  ~PieceFinder();
  PieceFinder(PieceFinder&&) noexcept;
  PieceFinder& operator=(PieceFinder&&) noexcept;

  /// The leaf (along each axis the voxel's index divided by 8, rounded down) has these 512 values now, as in
  /// set_leaf.h. False when no voxel went in or out.
  bool Change(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// Whether Change() has told of anything since the last Find().
  bool changed() const;
  const FoundPieces& Find();
  const FoundPieces& found() const;

  /// The region that has the most of a piece, by a voxel of each of its leaves; 0: none. As found last.
  int FindMainRegion(int id) const;
  /// Calls visit(leaf, voxels) for the leaves of a piece (0: of all dust), as found last; a leaf may come more than
  /// once.
  void ForEachLeaf(int id, const std::function<void(const std::array<int, 3>&, const LeafMask&)>& visit) const;
  double dust_mm3() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
