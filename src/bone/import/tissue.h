// Materials of an imported bone by position.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bone/import/leaf_positions.h"
#include "bone/import/mask.h"
#include "bone/import/spline_field.h"
#include "bone/import/volume.h"
#include "bone/material/atlas.h"
#include "kerf/material.h"

namespace kerf {

/// Thresholds that distinguish the tissues. They classify voxels; they do not give a modulus, because in cortex the HU
/// explain less than a fifth of the modulus's variance (docs/materials.md).
struct TissueOptions {
  double cortical_hu = 850;  // cortical at any depth if at least this
  double shell_mm =
      1.0;  // cortical at any HU if nearer to the surface than this, because soft tissue outside lowers the HU there
  double tooth_hu = 1800;       // enamel if at least this, in a lump of at least 15 mm^3
  double tooth_body_hu = 1200;  // dentin connected to enamel if at least this
  double tooth_reach_mm = 3;    // and no farther from the enamel than this
  Vec3 up_W{0, 0, 1};           // towards the top of the head, for the atlas
};

/// A threshold of enamel and the teeth that it gives.
struct ToothLevel {
  double hu = 0;
  double mm3 = 0;
};

/// Returns the volume of the teeth, as TissueMap finds them.
double CalcToothVolume(const Volume& lattice, const std::vector<std::uint8_t>& bone, const TissueOptions& options);

/// Returns the lowest threshold from `options.tooth_hu` on, in steps of 100 HU, at which the teeth are not more than
/// `most_mm3` and above which they hardly shrink: enamel is much brighter than dentin, while the brightest cortical
/// bone becomes less with each step.
ToothLevel FindToothLevel(const Volume& lattice, const std::vector<std::uint8_t>& bone, TissueOptions options,
                          double most_mm3);

/// Region ids by position. Thread-safe once constructed.
class TissueMap {
 public:
  /// `lattice`: the crop of the CT; its hu may be empty for an imported surface, and then only depth is used. `solid`:
  /// bone and filled cavities. `bone`: bone by HU. `hu`: the CT as a smooth field, or null. `use_atlas`: if true, the
  /// cortex is divided into the atlas's 31 regions, otherwise all cortex is kPlainCortexRegion. `mask`: on the same
  /// lattice, or null; if it has teeth, they replace those found by their HU, and its numbered teeth, canal, metal and
  /// lesion get regions of their own (bone/material/segment_regions.h).
  /// `hu_map`: the lattice of `hu` if it is another one. Throws kerf::Error if the atlas cannot be fitted to the bone.
  TissueMap(const Volume& lattice, const std::vector<std::uint8_t>& solid, const std::vector<std::uint8_t>& bone,
            const SplineField* hu, bool use_atlas, const TissueOptions& options, const MaskSamples* mask = nullptr,
            const LatticeMap* hu_map = nullptr);
  int RegionAt(const Vec3& p_W) const;
  /// Sets ids[n] to RegionAt() of each voxel n of a leaf that is `wanted`.
  void FindRegions(const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) const;
  double tooth_mm3() const { return tooth_mm3_; }

  static constexpr int kPlainCortexRegion = 1;

 private:
  void FindTeeth(const std::vector<std::uint8_t>& bone);
  void TakeTeeth(const std::vector<float>& tooth, const std::vector<std::uint8_t>& bone);
  void MeasureDepth(const std::vector<std::uint8_t>& solid);
  int FindToothRegion(const Vec3& p_V) const;
  /// Returns the region at a point where the value of each field is value_of(field).
  template <typename ValueOf>
  int ChooseRegion(const Vec3& p_W, ValueOf&& value_of) const;

  Volume lattice_;  // without its hu after construction
  LatticeMap map_;
  LatticeMap hu_map_;  // of hu_
  TissueOptions options_;
  const SplineField* hu_;
  std::vector<std::uint8_t> tooth_voxels_;
  std::unique_ptr<SplineField> depth_mm_;
  std::unique_ptr<SplineField> tooth_;   // null if there are no teeth
  std::vector<std::uint8_t> number_;     // of the tooth at each voxel; empty if none has a number
  std::unique_ptr<SplineField> canal_;   // null if no canal is known
  std::unique_ptr<SplineField> metal_;   // null if no metal is known
  std::unique_ptr<SplineField> lesion_;  // null if no lesion is known
  std::unique_ptr<MandibleAtlas> atlas_;
  double tooth_mm3_ = 0;
};

/// Returns the table of a bone that is not a mandible: one cortical region, cancellous bone, tooth.
MaterialTable MakePlainTable();

/// Throws kerf::Error, with `name` in the message, if the table lacks a region that the import uses.
void CheckTable(const MaterialTable& table, bool use_atlas, const std::string& name);

}  // namespace kerf
