// The bone as the tick sees it: its leaves in a table, found in one step, changed without asking for memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// Number of a leaf: of 8 x 8 x 8 voxels, along each axis the voxel's index divided by 8, rounded down.
struct LeafIndex {
  int x = 0;
  int y = 0;
  int z = 0;
  bool operator==(const LeafIndex&) const = default;
};

/// A window on a Bone's grids for the time of a simulation.
///
/// The values are the grids' own: what is written here is the bone. A leaf is 512 floats (mm), z fastest, y next. Where
/// the grid holds one value for a whole leaf, the table points to a shared leaf full of that value: kOutside
/// (+band_mm) or kInside (-band_mm); so reading never branches. Writing into a shared inside leaf first takes one of
/// the leaves set aside when the field was made.
class BoneField {
 public:
  static constexpr int kLeafVoxels = 512;
  enum class LeafKind : std::uint8_t { kOutside, kInside, kOwn };

  /// The bone must outlive the field; nothing else may change its grids meanwhile. `spare_leaves`: how many leaves of
  /// pure bone can be cut into before Refill() (2 kB each; a disc of 22 mm opens about 500 a second at 5 mm/s and 0.1
  /// mm). Allocates.
  explicit BoneField(Bone& bone, int spare_leaves = 4096);
  ~BoneField();
  BoneField(BoneField&&) noexcept;
  BoneField& operator=(BoneField&&) noexcept;

  double voxel_mm() const;
  double band_mm() const;
  /// Leaves that are not air lie from lowest() to highest(), both included; highest() is below lowest() when there are
  /// none. As it was when the field was made.
  LeafIndex lowest() const;
  LeafIndex highest() const;

  // ---- reading: tick-safe, O(1), any index; outside the bone's box it is air
  LeafKind kind(const LeafIndex& leaf) const;
  const float* Read(const LeafIndex& leaf) const;
  /// phi, mm, trilinear; `p_vox` = p_W / voxel_mm().
  double Sample(const Vec3& p_vox) const;
  /// The gradient of that interpolation (no unit; about unit length near the surface).
  Vec3 SampleGradient(const Vec3& p_vox) const;
  /// Region of the nearest voxel; 0: none.
  int RegionAt(const Vec3& p_W) const;
  /// Calls visit(region, weight) for the region voxels around a point: see ForEachRegionAround in bone/grids.h.
  /// E* and E there come from the caller's tables.
  struct RegionShare {
    int region;
    double weight;
  };
  /// Fills `shares` (at most 8, one a voxel) and returns how many; weights are not normalised. Tick-safe.
  int FindRegions(const Vec3& p_W, std::array<RegionShare, 8>& shares) const;
  /// E from the CT at a point, MPa; 0 where the bone has none there. Tick-safe.
  double ModulusAt(const Vec3& p_W) const;

  // ---- writing: tick-safe
  /// The leaf's own values to write to, null when the spare leaves are used up. Not for outside leaves. Marks it
  /// changed.
  float* Write(const LeafIndex& leaf);
  /// Leaves marked since the last ClearChanged(), each once, in the order of the first mark.
  std::span<const LeafIndex> changed() const;
  void ClearChanged();
  int spare_leaves() const;

  // ---- between ticks: may allocate
  void Refill(int spare_leaves);
  /// Makes the grids' bookkeeping (active voxels, emptied leaves) true again after writing; the values always are.
  void Settle();
  std::size_t CalcMemoryBytes() const;  // of the table and the spare leaves, not of the bone

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
