// WoodenHaptics and its kin: a base that turns, an upper arm and a forearm on it, three motors with capstans.
#pragma once

#include "base/core/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// Three joints: a, the base about the vertical; b, the upper arm from the vertical; c, the forearm from hanging
/// straight down. Lists have one item for each joint, in this order. The figures are those of the wooden build of 2016
/// (woodenhaptics_2016ed.json, and the signs of CWoodenDevice.cpp for USB, at woody-experimental 726e186).
struct WoodenParams {
  double base_mm = 80;         // joint b above the table
  double upper_arm_mm = 205;   // b to c
  double forearm_mm = 245;     // c to the handle
  Vec3 middle_mm{220, 0, 80};  // of the workspace, from the base: towards the user, to the right, up
  double workspace_radius_mm = 100;
  Vec3 counts_per_turn{-2000, 2000, 2000};  // of the motors; negative: counts the other way round than the motor pulls
  Vec3 gear{16, -12, -12};                  // turns of the motor for one of the joint; negative: the other way round
  Vec3 zero_deg{0, 0, 90};                  // where the joints are when the encoders say 0
  Vec3 motor_Nmm_per_A{25.9, 25.9, 25.9};
  double max_current_A = 3;  // of a motor; the firmware's own limit is 3
  double peak_force_N = 5;
  double max_stiffness_N_per_mm = 1;
  double max_damping_Ns_per_mm = 0.008;
  /// The arm is held in the zero pose when the session begins; else it was when the device got its power.
  bool zero_at_start = false;
};

template <typename V>
void Describe(WoodenParams& p, V&& visit) {
  visit("base_mm", p.base_mm, Range{0, 1000}, "height of the upper arm's joint above the table");
  visit("upper_arm_mm", p.upper_arm_mm, Range{20, 2000}, "from its joint to the forearm's");
  visit("forearm_mm", p.forearm_mm, Range{20, 2000}, "from its joint to the handle");
  visit("middle_mm", p.middle_mm, Range{-2000, 2000},
        "middle of the workspace from the base: towards the user, to the right, up");
  visit("workspace_radius_mm", p.workspace_radius_mm, Range{1, 2000}, "how far the handle goes from the middle");
  visit("counts_per_turn", p.counts_per_turn, Range{-1e6, 1e6},
        "of each encoder, four for each line; negative: it counts the other way round than its motor pulls");
  visit("gear", p.gear, Range{-1000, 1000}, "turns of each motor for one of its joint; negative: the other way round");
  visit("zero_deg", p.zero_deg, Range{-360, 360}, "where each joint is when its encoder says 0");
  visit("motor_Nmm_per_A", p.motor_Nmm_per_A, Range{0.1, 1e4}, "torque of each motor for its current");
  visit("max_current_A", p.max_current_A, Range{0.01, 3}, "of a motor; the firmware cuts at 3 A");
  visit("peak_force_N", p.peak_force_N, Range{0.01, 100}, "at the handle");
  visit("max_stiffness_N_per_mm", p.max_stiffness_N_per_mm, Range{1e-3, 100}, "that it renders steadily");
  visit("max_damping_Ns_per_mm", p.max_damping_Ns_per_mm, Range{1e-5, 1}, "that it renders steadily");
  visit("zero_at_start", p.zero_at_start,
        "true: the arm is held in the zero pose when the session begins; false: it was when it got its power");
}

}  // namespace kerf
