// Material that a tooth cuts at a point, in the form that the force laws read.
#pragma once

#include <array>
#include <cstdint>

#include "bone/grid/field.h"
#include "kerf/force.h"
#include "kerf/material.h"
#include "kerf/tool.h"

namespace kerf {

/// Throws kerf::Error if the law has no forces for a tissue that occurs in the bone.
void CheckTissues(const ForceLaw& law, const Bone& bone);

/// Tables of the constants by region id. They are built once, so that the tick needs no search.
class MaterialLookup {
 public:
  MaterialLookup(const Bone& bone, const Tool& tool);

  /// E and E* of the regions, MPa.
  const RegionConstants& moduli() const { return moduli_; }
  /// Sets a cut amid one region, whose moduli are interpolated already. Returns false, and sets nothing, if the region
  /// is 0 or its E comes from the CT. `reads`: LawReads. Tick-safe.
  bool SetUniform(int region, double E_MPa, double E_star_MPa, unsigned reads, ToothCut& cut) const {
    const auto id = static_cast<std::size_t>(region);
    if (region == 0 || (any_by_ct_ && by_ct_[id])) return false;
    cut.E_MPa = E_MPa;
    cut.E_star_MPa = E_star_MPa;
    if ((reads & kReadsTissue) != 0) cut.tissue[tissue_[id]] = 1;
    return true;
  }
  /// Sets the moduli and, if asked for, the tissues of a cut, whose members are 0 before. Returns the region of the
  /// nearest voxel that has a material; 0: no material. Interpolates between the region voxels around the point that
  /// have a material; E comes from the CT in regions that use it. Without interpolation, an arc that crosses a border
  /// between tissues all at once would cause a step in the force. `reads`: LawReads. Tick-safe.
  int Find(const BoneField& field, const Vec3& p_W, unsigned reads, ToothCut& cut) const;

 private:
  RegionConstants moduli_;  // a: E, b: E*; 0: unknown id
  std::array<double, 256> nu_{};
  std::array<std::uint8_t, 256> tissue_{};
  std::array<bool, 256> by_ct_{};
  bool any_by_ct_ = false;
  double tool_E_MPa_;
  double tool_nu_;
};

}  // namespace kerf
