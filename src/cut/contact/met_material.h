// What a tooth cuts at a point: the elastic constants there, as the tick needs them.
#pragma once

#include <array>

#include "bone/grid/field.h"
#include "kerf/material.h"
#include "kerf/tool.h"

namespace kerf {

/// Tables by region id, made once, so that nothing is searched in the tick.
class MaterialLookup {
 public:
  MaterialLookup(const Bone& bone, const Tool& tool);

  struct Material {
    int region = 0;  // of the nearest voxel with a material; 0: none
    double E_MPa = 0;
    double E_star_MPa = 0;  // reduced modulus, tool on bone
  };
  /// Interpolated between the region voxels around the point that have a material, E from the CT where it is used. An
  /// arc that crosses a border between tissues all at once would else feel a step. Tick-safe.
  Material Find(const BoneField& field, const Vec3& p_W) const;

 private:
  std::array<double, 256> E_MPa_{};
  std::array<double, 256> E_star_MPa_{};  // 0 where the id is unknown
  std::array<double, 256> nu_{};
  std::array<bool, 256> by_ct_{};
  bool any_by_ct_ = false;
  double tool_E_MPa_;
  double tool_nu_;
};

}  // namespace kerf
