// The rim of the saw against the bone: which teeth are engaged, how deep each bites, and the force they add up to.
#pragma once

#include <array>

#include "bone/field.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// What the rim needs of materials, by region id; 0 where the id is unknown. Made once, not in the tick.
struct RimMaterials {
  std::array<double, 256> E_MPa{};
  std::array<double, 256> E_star_MPa{};  // reduced modulus against the tool's steel
  // Where E is taken from the CT instead, E* needs these:
  std::array<double, 256> nu{};
  double steel_E_MPa = 1;
  double steel_nu = 0;
};
RimMaterials MakeRimMaterials(const MaterialTable& materials, const Tool& tool);

/// The tool frame's axes; the force is on the tool.
struct RimLoad {
  Vec3 f_T_N{0};             // acts at the disc's centre: tooth forces are radial
  double thrust_sum_N = 0;   // sum of the magnitudes
  double engaged_teeth = 0;  // engaged arc / pitch, a real number
  double E_sum_MPa = 0;      // sums over the engaged teeth; divide by engaged_teeth for the mean
  double bite_sum_mm = 0;
  std::array<double, 256> thrust_by_region_N{};  // sums to thrust_sum_N
};

/// How far ahead of the rim a tooth looks for bone, as a share of the voxel's edge. The cut surface lies exactly on the
/// rim, so on it there is nothing to see. An engaged arc comes out too long by about look-ahead * (cos(alpha) - 1/2) /
/// sin(alpha) where the rim crosses the surface at angle alpha from its lowest point: 0.5 % at 1.1 mm depth and 0.1 mm
/// voxels.
inline constexpr double kLookAheadVoxels = 0.25;

/// Mean force over many tooth passages on a rim that moves with velocity `v_T_mm_per_s` (of the disc's centre, tool
/// frame). Model:  teeth lie densely: each mm of rim holds 1/pitch teeth. A tooth at angle phi bites delta = max(0,
/// v.e(phi)) / f, with f
///         tooth passes a second, where there is bone before it; its force is -F(delta, E*) e(phi). docs/physics.md.
/// Valid:  feed well below rim speed; bites within the law's own range.
/// Error:  below 1 % in engaged teeth and force at 0.1 mm voxels and depths from 1.1 mm
/// (tests/sim/closed_form_test.cpp). Tick-safe: yes.
class Rim {
 public:
  Rim(const DiscSaw& saw, const ToothForce& force, const RimMaterials& materials, int samples_per_pitch);

  RimLoad CalcLoad(const BoneField& field, const Pose& X_WT, const Vec3& v_T_mm_per_s, double passes_per_s) const;

 private:
  double radius_mm_;
  int teeth_;
  ToothForce force_;
  RimMaterials materials_;
  int half_samples_;  // intervals over half the rim
};

}  // namespace kerf
