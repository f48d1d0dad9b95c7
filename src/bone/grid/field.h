// View of the bone for the tick: a table of its leaves with O(1) access, which can be changed without allocating
// memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "bone/grid/leaf_table.h"
#include "bone/grid/sample_points.h"
#include "kerf/bone.h"

namespace kerf {

class LeafHistory;

/// View of a Bone's grids for the duration of a simulation.
///
/// The values are those of the grids: writing here changes the bone. A leaf is 512 floats (mm), z fastest, y next.
/// Where the grid holds one value for a whole leaf, the table points to a shared leaf filled with that value: kOutside
/// (+band_mm) or kInside (-band_mm). Reading therefore never branches. The first write into a shared inside leaf
/// replaces it with one of the spare leaves, which are allocated when the field is made.
///
/// Points and leaves are expressed in the field's frame F: the world frame, shifted to the bone by a whole number of
/// leaves, so that a bone far from the world's origin loses no precision. For a bone within 65536 voxels of the origin
/// F is the world frame.
class BoneField {
 public:
  static constexpr int kLeafVoxels = 512;
  enum class LeafKind : std::uint8_t { kOutside, kInside, kOwn };

  /// The bone must outlive the field, and no other code may change its grids meanwhile. `spare_leaves`: number of
  /// leaves of pure bone that can be cut into before Refill() (2 kB each; a 22 mm disc at 5 mm/s needs about 500 per
  /// second if the voxels are 0.1 mm). Allocates. The bone's values stay unchanged.
  explicit BoneField(Bone& bone, int spare_leaves = 4096);
  ~BoneField();
  BoneField(BoneField&&) noexcept;
  BoneField& operator=(BoneField&&) noexcept;

  double voxel_mm() const;
  double band_mm() const;
  /// Origin of F in the world: as a leaf index, and as a point.
  LeafIndex origin_leaf() const;
  Vec3 p_WF_mm() const;
  /// Converts a leaf's index in the world to its index in F.
  LeafIndex FromWorld(const std::array<int, 3>& index) const;
  /// All leaves that are not air lie from lowest() to highest(), both included; highest() is below lowest() if there
  /// are none. Computed when the field is made.
  LeafIndex lowest() const;
  LeafIndex highest() const;

  // ---- reading: tick-safe, O(1), any index; outside the bone's box there is air
  LeafKind kind(const LeafIndex& leaf) const;
  const float* Read(const LeafIndex& leaf) const;
  /// Returns phi, mm, interpolated trilinearly; `p_vox` = p_F / voxel_mm().
  double Sample(const Vec3& p_vox) const;
  /// Does the same for the points p of a list, at p_vox = R p + t. `phi_mm`: one value per point.
  void Sample(const PointMap& to_vox, const PointList& points, double* phi_mm) const;
  /// Returns the gradient of that interpolation (dimensionless; length about 1 near the surface).
  Vec3 SampleGradient(const Vec3& p_vox) const;
  /// Returns the region of the nearest voxel; 0: none.
  int RegionAt(const Vec3& p_F) const;
  double region_voxel_mm() const;
  /// The eight region voxels around a point, for VisitRegions(). E* and E of the regions come from the caller's tables.
  struct RegionCell {
    CellValues<int> regions;
    Vec3 f;  // position in the cell, 0 to 1 along each axis
  };
  RegionCell FindRegionCell(const Vec3& p_F) const;
  /// Finds for the points p of a list, at p_vox = R p + t, the region (id 1 to 255) of all eight region voxels around
  /// each; 0: they are not all of one region, or that is not known without a look at them. Interpolates the region's
  /// constants between these voxels, with the bits of VisitRegions().
  void InterpolateUniform(const PointMap& to_vox, const PointList& points, const RegionConstants& constants,
                          std::uint8_t* regions, double* a, double* b) const;
  /// Returns E from the CT at a point, MPa; 0 if the CT gives no value there.
  double ModulusAt(const Vec3& p_F) const;
  /// Returns whether the E of a region (id 0 to 255) comes from the CT wherever the CT gives a value.
  bool by_modulus(int region) const;
  /// Returns whether a region (id 0 to 255) is metal, and whether the bone's table has a region of metal.
  bool is_metal(int region) const;
  bool has_metal() const;

  // ---- writing: tick-safe
  /// Returns the leaf's own values for writing and marks it as changed. Returns null if the leaf is outside, or if it
  /// needs a spare leaf and none is left.
  float* Write(const LeafIndex& leaf);
  /// Like Write(), but also replaces an outside leaf with a spare one, so that bone can be restored there. Returns null
  /// if no spare leaf is left or the leaf lies beyond the bone's box.
  float* Open(const LeafIndex& leaf);
  /// Returns the leaf's own values; null unless its kind is kOwn. A caller that changes them must also call Write(),
  /// and must call it before the change if NeedsOldValues() returns true.
  float* OwnValues(const LeafIndex& leaf);
  /// Returns whether there is a history that has not yet received the leaf's old values. Write() and Open() pass them
  /// to it, so they must be called before the values change.
  bool NeedsOldValues(const LeafIndex& leaf) const;
  /// Exchanges the leaf's values with `values` (512), without adding to the history. Returns false and changes nothing
  /// if Open() returns null.
  bool Swap(const LeafIndex& leaf, float* values);
  /// Leaves marked since the last ClearChanged(), each once, in the order of their first mark.
  std::span<const LeafIndex> changed() const;
  /// Returns the i-th of the changed leaves.
  ChangedLeaf ReadChanged(int i) const;
  void ClearChanged();
  int spare_leaves() const;

  // ---- between ticks: may allocate
  /// Sets the history that receives the values of leaves before they change (src/bone/grid/leaf_history.h); null: none.
  /// It must outlive this field.
  void set_history(LeafHistory* history);
  /// Number of places in the table of leaves, and the place of a leaf.
  std::size_t place_count() const;
  std::size_t PlaceOf(const LeafIndex& leaf) const;
  /// Allocates spare leaves until there are `spare_leaves`.
  void Refill(int spare_leaves);
  /// Updates the grids' bookkeeping (active voxels, emptied leaves) after writing; the values themselves are always up
  /// to date. Emptied leaves become spare again. Invalidates pointers from Read() and Write().
  void Settle();
  std::size_t CalcMemoryBytes() const;  // of the table and the spare leaves, not of the bone

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
