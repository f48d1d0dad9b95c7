// Parameters of the coupling between tool and handle.
#pragma once

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// Spring and damper between handle and tool, acting at one point of the tool. A device's profile limits the values.
struct CouplingParams {
  Vec3 p_TC_mm{0};  // coupling point, tool frame: the grip for a device that senses rotation and outputs torques, the
                    // tool's origin for a device that outputs forces only
  double stiffness_N_per_mm = 1;
  double damping_Ns_per_mm = 0;  // acts on the handle velocity of the input
  double torsion_Nmm_per_rad = 5000;
  double torsion_damping_Nmms = 0;  // N mm s / rad
  double max_force_N = 40;          // limit of the spring force and, separately, of the damper force
  double max_torque_Nmm = 4000;     // the same for the torsion spring and damper
  /// Puts the bending of a thin blade in series with spring and damper, along the handle's z axis, across the blade.
  /// Both forces and the maximum of each then fall in that direction. Without effect on a drill or a bur, which are
  /// rigid.
  bool blade_bends = false;
};

/// All but the point; [coupling] of a scene has the same keys.
template <typename Params, typename V>
void DescribeSprings(Params& p, V&& visit) {
  visit("stiffness_N_per_mm", p.stiffness_N_per_mm, Range{1e-3, 1000},
        "stiffness of the spring between handle and tool; lowered to the limits of device and loop");
  visit("damping_Ns_per_mm", p.damping_Ns_per_mm, Range{0, 1},
        "damping between handle and tool; also lowered, and raised to the minimum that a sampled spring needs");
  visit("torsion_Nmm_per_rad", p.torsion_Nmm_per_rad, Range{1, 1e7}, "torsional stiffness between handle and tool");
  visit("torsion_damping_Nmms", p.torsion_damping_Nmms, Range{0, 1e4}, "torsional damping between handle and tool");
  visit("max_force_N", p.max_force_N, Range{0.1, 1e4}, "maximum force of the spring, however far the handle moves");
  visit("max_torque_Nmm", p.max_torque_Nmm, Range{1, 1e6},
        "maximum torque of the torsional spring, however far the handle turns");
  visit("blade_bends", p.blade_bends, "true: a thin blade bends sideways, in series with the spring");
}
template <typename V>
void Describe(CouplingParams& p, V&& visit) {
  visit("point_mm", p.p_TC_mm, Range{-1000, 1000}, "coupling point, tool frame");
  DescribeSprings(p, visit);
}

}  // namespace kerf
