// The bone as the tick sees it: its leaves in a table, found in one step, changed without asking for memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "bone/grid/leaf_table.h"
#include "kerf/bone.h"

namespace kerf {

class LeafHistory;

/// A window on a Bone's grids for the time of a simulation.
///
/// The values are the grids' own: what is written here is the bone. A leaf is 512 floats (mm), z fastest, y next. Where
/// the grid holds one value for a whole leaf, the table points to a shared leaf full of that value: kOutside
/// (+band_mm) or kInside (-band_mm); so reading never branches. Writing into a shared inside leaf first takes one of
/// the leaves set aside when the field was made.
///
/// Points and leaves are those of the field's own frame F: the world's, moved by whole leaves to where the bone is, so
/// that a bone far from the world's origin loses no digits. For a bone within 65536 voxels of it they are the world's.
class BoneField {
 public:
  static constexpr int kLeafVoxels = 512;
  enum class LeafKind : std::uint8_t { kOutside, kInside, kOwn };

  /// The bone must outlive the field; nothing else may change its grids meanwhile. `spare_leaves`: how many leaves of
  /// pure bone can be cut into before Refill() (2 kB each; a disc of 22 mm opens about 500 a second at 5 mm/s and 0.1
  /// mm). Allocates. The bone's own values stay as they are.
  explicit BoneField(Bone& bone, int spare_leaves = 4096);
  ~BoneField();
  BoneField(BoneField&&) noexcept;
  BoneField& operator=(BoneField&&) noexcept;

  double voxel_mm() const;
  double band_mm() const;
  /// Where F is: its first leaf, and the same as a point.
  LeafIndex origin_leaf() const;
  Vec3 p_WF_mm() const;
  /// A leaf of the world, by its index there, as one of F.
  LeafIndex FromWorld(const std::array<int, 3>& index) const;
  /// Leaves that are not air lie from lowest() to highest(), both included; highest() is below lowest() when there are
  /// none. As it was when the field was made.
  LeafIndex lowest() const;
  LeafIndex highest() const;

  // ---- reading: tick-safe, O(1), any index; outside the bone's box it is air
  LeafKind kind(const LeafIndex& leaf) const;
  const float* Read(const LeafIndex& leaf) const;
  /// phi, mm, trilinear; `p_vox` = p_F / voxel_mm().
  double Sample(const Vec3& p_vox) const;
  /// The gradient of that interpolation (no unit; about unit length near the surface).
  Vec3 SampleGradient(const Vec3& p_vox) const;
  /// Region of the nearest voxel; 0: none.
  int RegionAt(const Vec3& p_F) const;
  double region_voxel_mm() const;
  struct RegionShare {
    int region;
    double weight;
  };
  /// The regions of the eight region voxels around a point and their shares by trilinear interpolation, as
  /// ForEachRegionAround() in bone/grids.h: fills `shares` (one a voxel that has a region) and returns how many.
  /// Weights are not normalised. E* and E there come from the caller's tables.
  int FindRegions(const Vec3& p_F, std::array<RegionShare, 8>& shares) const;
  /// E from the CT at a point, MPa; 0 where the bone has none there.
  double ModulusAt(const Vec3& p_F) const;
  /// Whether E of a region, 0 to 255, is from the CT where there is one.
  bool by_modulus(int region) const;

  // ---- writing: tick-safe
  /// The leaf's own values to write to, null when the spare leaves are used up or the leaf is outside. Marks it
  /// changed.
  float* Write(const LeafIndex& leaf);
  /// As Write(), but a leaf outside takes a spare one too: bone comes back to where it was. Null when there is none,
  /// and beyond the bone's box.
  float* Open(const LeafIndex& leaf);
  /// The leaf's own values, null unless its kind is kOwn. Who changes them calls Write() too; before, if WantsOld().
  float* OwnValues(const LeafIndex& leaf);
  /// Whether a history is kept that the leaf's old values have yet to go to: Write() and Open() hand them over, so they
  /// are called before the values change.
  bool WantsOld(const LeafIndex& leaf) const;
  /// Gives the leaf `values` (512) and them its own; no history is told. False, and nothing done, where Open() is null.
  bool Swap(const LeafIndex& leaf, float* values);
  /// Leaves marked since the last ClearChanged(), each once, in the order of the first mark.
  std::span<const LeafIndex> changed() const;
  /// The i-th of them.
  ChangedLeaf ReadChanged(int i) const;
  void ClearChanged();
  int spare_leaves() const;

  // ---- between ticks: may allocate
  /// Gets what leaves were before they change (src/bone/grid/leaf_history.h); null: nothing does. It must outlive
  /// this.
  void set_history(LeafHistory* history);
  /// Of the table of leaves: how many places, and that of a leaf.
  std::size_t place_count() const;
  std::size_t PlaceOf(const LeafIndex& leaf) const;
  /// Sets leaves aside until there are so many.
  void Refill(int spare_leaves);
  /// Makes the grids' bookkeeping (active voxels, emptied leaves) true again after writing; the values always are.
  /// Emptied leaves are spare again; pointers from Read() and Write() are good no longer.
  void Settle();
  std::size_t CalcMemoryBytes() const;  // of the table and the spare leaves, not of the bone

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
