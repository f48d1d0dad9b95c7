// View of the bone for the tick: a table of its leaves with O(1) access, which can be changed without allocating
// memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "bone/grid/phi_table.h"
#include "bone/grid/sample_points.h"
#include "kerf/bone.h"

namespace kerf {

class LeafHistory;

/// View of a Bone's grids for the duration of a simulation.
///
/// The values are those of the grids: writing here changes the bone. A leaf is 512 floats (mm), z fastest, y next.
/// Where the grid holds one value for a whole leaf, the table points to a shared leaf filled with that value: kOutside
/// (+band_mm) or kInside (-band_mm). Reading therefore never branches. The first cut into a shared inside leaf replaces
/// it with one of the spare leaves, which are allocated when the field is made.
///
/// The bone is what its surface encloses, less what was cut: phi = max(whole, cut). `whole` is phi before the first cut
/// and never changes; `cut` is minus the distance to the swept space, positive inside it, -band_mm where nothing was
/// cut nearby. Each is smooth where the other makes an edge of the bone, so between the voxels they are interpolated
/// separately. A leaf needs both only if the surface was cut in it; such a leaf is split. In all others phi is one of
/// the two.
///
/// Points and leaves are expressed in the field's frame F: the world frame, shifted to the bone by a whole number of
/// leaves, so that a bone far from the world's origin loses no precision. For a bone within 65536 voxels of the origin
/// F is the world frame.
class BoneField {
 public:
  static constexpr int kLeafVoxels = 512;
  enum class LeafKind : std::uint8_t { kOutside, kInside, kOwn };

  /// The bone must outlive the field, and no other code may change its grids meanwhile. `spare_leaves`: number of
  /// leaves of pure bone that can be cut into before Refill() or Supply() (2 kB each; a 22 mm disc at 5 mm/s needs
  /// about 500 per second if the voxels are 0.1 mm). Allocates. The bone's values stay unchanged.
  explicit BoneField(Bone& bone, int spare_leaves = 4096);
  ~BoneField();
  BoneField(BoneField&&) noexcept;

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
  /// The shared leaf of bone, filled with -band_mm.
  const float* inside() const;
  /// Return the leaf's values of the two fields, 512 floats each. Both are +band_mm in an outside leaf.
  PhiParts ReadParts(const LeafIndex& leaf) const;
  /// Returns the two fields, mm, interpolated trilinearly; `p_vox` = p_F / voxel_mm(). In a cell in which only one of
  /// them is near zero, the other may be -band_mm.
  PhiPair SampleParts(const Vec3& p_vox) const;
  /// Does the same for the points p of a list, at p_vox = R p + t. `whole_mm`, `cut_mm`: one value per point.
  void SampleParts(const PointMap& to_vox, const PointList& points, double* whole_mm, double* cut_mm) const;
  /// Returns phi, mm: the larger of the two.
  double Sample(const Vec3& p_vox) const { return SampleParts(p_vox).phi(); }
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
  /// Values of a leaf that was cut. `whole` is null if the leaf is not split; `phi` is then `cut`. A caller that
  /// changes `cut` must also set `phi` to max(whole, cut).
  struct CutValues {
    float* cut = nullptr;
    float* phi = nullptr;
    const float* whole = nullptr;
  };
  /// Returns the leaf's values for writing and marks it as changed. All are null if the leaf is outside, or if it needs
  /// more spare leaves than are left: one if it is inside, two if its surface is cut for the first time.
  CutValues Write(const LeafIndex& leaf);
  /// Like Write(), but also replaces an outside leaf with a spare one, so that bone can be restored there. All are null
  /// if too few spare leaves are left or the leaf lies beyond the bone's box.
  CutValues Open(const LeafIndex& leaf);
  /// Number of spare leaves that Open() takes.
  int CountNeededSpares(const LeafIndex& leaf) const;
  /// Returns the leaf's values; all are null unless it was cut. A caller that changes them must also call Write(), and
  /// must call it before the change if NeedsOldValues() returns true.
  CutValues Find(const LeafIndex& leaf);
  /// Returns whether there is a history that has not yet received the leaf's old values. Write() and Open() pass those
  /// of `cut` to it, so they must be called before the values change.
  bool NeedsOldValues(const LeafIndex& leaf) const;
  /// Exchanges the leaf's values of `cut` with `values` (512), without adding to the history. Returns false and changes
  /// nothing if Open() returns null.
  bool Swap(const LeafIndex& leaf, float* values);
  /// Sets the leaf's phi to the larger of its two fields.
  static void SetPhi(const CutValues& values);
  /// Leaves marked since the last ClearChanged(), each once, in the order of their first mark.
  std::span<const LeafIndex> changed() const;
  /// Returns the i-th of the changed leaves.
  ChangedLeaf ReadChanged(int i) const;
  void ClearChanged() { ClearChanged(static_cast<int>(changed().size())); }
  /// Removes the first leaves from the list; the order of the others may change.
  void ClearChanged(int first);
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
  /// The same, but one other thread may call it at any time, also while this field is written. Of the leaves that it
  /// allocates, at most 65536 are left at a time.
  void Supply(int spare_leaves);
  /// Updates the grids' bookkeeping (active voxels, emptied leaves, the two fields of split leaves) after writing; phi
  /// itself is always up to date. Volumes of the bone need the fields, so they are right only after this. Emptied
  /// leaves become spare again. Invalidates pointers from Read() and Write().
  void Settle();
  std::size_t CalcMemoryBytes() const;  // of the table and the spare leaves, not of the bone

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the number of spare leaves that a cut through all of the bone takes: one for each leaf that it fills, and
/// two for each with a surface that was not cut yet.
std::int64_t CountSparesForAll(const Bone& bone);

}  // namespace kerf
