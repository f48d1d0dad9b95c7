// Parameters of WoodenHaptics-type devices, which have a rotating base, an upper arm, a forearm, and three motors with
// capstans.
#pragma once

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// The three joint angles are a, of the base about the vertical; b, of the upper arm from the vertical; and c, of the
/// forearm from hanging straight down. Vectors have one component per joint, in this order. The defaults are those of
/// the 2016 wooden build (woodenhaptics_2016ed.json, with the signs of CWoodenDevice.cpp for USB, at woody-experimental
/// 726e186).
struct WoodenParams {
  double base_mm = 80;         // height of joint b above the table
  double upper_arm_mm = 205;   // from joint b to joint c
  double forearm_mm = 245;     // from joint c to the handle
  Vec3 middle_mm{220, 0, 80};  // middle of the workspace, from the base: towards the user, to the right, up
  double workspace_radius_mm = 100;
  Vec3 counts_per_turn{-2000, 2000, 2000};  // encoder counts per turn of each motor; negative: opposite to its pull
  Vec3 gear{16, -12, -12};                  // turns of the motor per turn of the joint; negative: opposite direction
  Vec3 zero_deg{0, 0, 90};                  // joint angles at encoder count 0
  Vec3 motor_Nmm_per_A{25.9, 25.9, 25.9};
  double max_current_A = 3;  // per motor; the firmware's limit is 3
  double peak_force_N = 5;
  double max_stiffness_N_per_mm = 1;
  double max_damping_Ns_per_mm = 0.008;
  /// True: the arm is in the zero pose when the session begins. False: it was in that pose at power-on.
  bool zero_at_start = false;
};

template <typename V>
void Describe(WoodenParams& p, V&& visit) {
  visit("base_mm", p.base_mm, Range{0, 1000}, "height of the upper arm's joint above the table");
  visit("upper_arm_mm", p.upper_arm_mm, Range{20, 2000}, "length of the upper arm, from its joint to the next one");
  visit("forearm_mm", p.forearm_mm, Range{20, 2000}, "length of the forearm, from its joint to the handle");
  visit("middle_mm", p.middle_mm, Range{-2000, 2000},
        "middle of the workspace, measured from the base: towards the user, to the right, up");
  visit("workspace_radius_mm", p.workspace_radius_mm, Range{1, 2000}, "radius of the workspace about its middle");
  visit(
      "counts_per_turn", p.counts_per_turn, Range{-1e6, 1e6},
      "counts of each encoder per turn of its motor, four per line; negative: it counts opposite to the motor's pull");
  visit("gear", p.gear, Range{-1000, 1000},
        "turns of each motor per turn of its joint; negative: in the opposite direction");
  visit("zero_deg", p.zero_deg, Range{-360, 360}, "angle of each joint when its encoder reads 0");
  visit("motor_Nmm_per_A", p.motor_Nmm_per_A, Range{0.1, 1e4}, "torque of each motor per unit of current");
  visit("max_current_A", p.max_current_A, Range{0.01, 3}, "maximum current of a motor; the firmware limits it to 3 A");
  visit("peak_force_N", p.peak_force_N, Range{0.01, 100}, "peak force at the handle");
  visit("max_stiffness_N_per_mm", p.max_stiffness_N_per_mm, Range{1e-3, 100},
        "maximum stiffness that the device renders stably");
  visit("max_damping_Ns_per_mm", p.max_damping_Ns_per_mm, Range{1e-5, 1},
        "maximum damping that the device renders stably");
  visit("zero_at_start", p.zero_at_start,
        "true: the arm is held in the zero pose when the session begins; false: it was in that pose at power-on");
}

}  // namespace kerf
