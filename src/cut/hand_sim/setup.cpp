#include "cut/hand_sim/setup.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {
namespace {

void CheckRange(const char* name, double value, double lower, double upper) {
  if (!(value >= lower && value <= upper)) {
    throw Error(fmt::format("{} = {} is out of range; valid range {} to {}", name, value, lower, upper));
  }
}

}  // namespace

void CheckParams(const CoupledParams& p) {
  Validate(p.tool);
  const CouplingParams& c = p.coupling;
  for (int axis = 0; axis < 3; ++axis) CheckRange("coupling point_mm", c.p_TC_mm[axis], -1000, 1000);
  CheckRange("coupling stiffness_N_per_mm", c.stiffness_N_per_mm, 1e-3, 1e3);
  CheckRange("coupling damping_Ns_per_mm", c.damping_Ns_per_mm, 0, 1);
  CheckRange("coupling torsion_Nmm_per_rad", c.torsion_Nmm_per_rad, 1, 1e7);
  CheckRange("coupling torsion_damping_Nmms", c.torsion_damping_Nmms, 0, 1e4);
  CheckRange("coupling max_force_N", c.max_force_N, 0.1, 1e4);
  CheckRange("coupling max_torque_Nmm", c.max_torque_Nmm, 1, 1e6);
  CheckEffects(p.effects);
  CheckRange("rim_samples_per_pitch", p.rim_samples_per_pitch, 1, 256);
  CheckRange("max_iterations", p.max_iterations, 1, 1000);
  CheckRange("max_substeps", p.max_substeps, 1, 4096);
  CheckRange("substeps", p.substeps, 1, 64);
  CheckRange("carve_interval_ticks", p.carve_interval_ticks, 1, 64);
  CheckRange("precision_bits", p.precision_bits, 4, 24);
  CheckRange("spare_leaves", p.spare_leaves, 0, 1 << 24);
}

double CalcRamp(const ToothForce& force, double creep_mm_per_s) {
  constexpr double kE_star_MPa = 1e4;
  return force(1e-9, kE_star_MPa) > 1e-4 * force(1e-3, kE_star_MPa) ? creep_mm_per_s : 0;
}

Pose MakeStart(const Pose& X_WT) {
  if (!IsValid(X_WT)) throw Error("the tool's start pose is not finite or its quaternion is not of unit length");
  if (!IsInWorld(X_WT.p_AB)) {
    throw Error(fmt::format("the tool's start position is more than {} mm from the world origin", kWorldReach_mm));
  }
  return X_WT;
}

int CountOldLeaves(const BoneField& field, const CoupledParams& params) {
  const int max_count = std::max(4096, params.spare_leaves);
  const LeafIndex low = field.lowest();
  const LeafIndex high = field.highest();
  int count = 0;
  for (int x = low.x; x <= high.x; ++x) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z && count < max_count; ++z) {
        count += field.kind({x, y, z}) == BoneField::LeafKind::kOwn ? 1 : 0;
      }
    }
  }
  return count;
}

}  // namespace kerf
