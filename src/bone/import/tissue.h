// Which material lies where in an imported bone.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bone/import/spline_field.h"
#include "bone/import/volume.h"
#include "bone/material/atlas.h"
#include "kerf/material.h"

namespace kerf {

/// Thresholds that tell the tissues apart. They sort voxels into kinds; they give no modulus, since the HU of cortex
/// does not predict it.
struct TissueOptions {
  double cortical_hu = 850;  // at least this: cortical at any depth
  double shell_mm =
      1.0;  // nearer to the surface than this: cortical whatever its HU, which the soft tissue outside dims
  double tooth_hu = 1800;       // at least this, in a lump of 15 mm^3: enamel
  double tooth_body_hu = 1200;  // dentin joined to enamel: at least this
  double tooth_reach_mm = 3;    // and not farther from it
};

/// Region ids by place. Thread-safe once made.
class TissueMap {
 public:
  /// `lattice`: the crop of the CT (its hu may be empty when a surface was imported: then only depth counts). `solid`:
  /// bone and filled cavities, `bone`: bone by HU. `hu`: the CT as a smooth field, or null. `use_atlas`: cortex by the
  /// 31 regions; else all cortex is kPlainCortexRegion. Throws Error when the atlas can't be laid on the bone.
  TissueMap(const Volume& lattice, const std::vector<std::uint8_t>& solid, const std::vector<std::uint8_t>& bone,
            const SplineField* hu, bool use_atlas, const TissueOptions& options);
  int RegionAt(const Vec3& p_W) const;
  double tooth_mm3() const { return tooth_mm3_; }

  static constexpr int kPlainCortexRegion = 1;

 private:
  void FindTeeth(const std::vector<std::uint8_t>& bone);
  void MeasureDepth(const std::vector<std::uint8_t>& solid);

  Volume lattice_;  // without its hu, once made
  glm::dmat3 voxel_from_world_{1};
  TissueOptions options_;
  const SplineField* hu_;
  std::vector<std::uint8_t> tooth_voxels_;
  std::unique_ptr<SplineField> depth_mm_;
  std::unique_ptr<SplineField> tooth_;  // null when there are none
  std::unique_ptr<MandibleAtlas> atlas_;
  double tooth_mm3_ = 0;
};

/// The table of a bone that is no mandible: one cortical region, cancellous bone, tooth.
MaterialTable MakePlainTable();

/// Throws Error naming `name` when the table lacks a region that the import uses.
void CheckTable(const MaterialTable& table, bool use_atlas, const std::string& name);

}  // namespace kerf
