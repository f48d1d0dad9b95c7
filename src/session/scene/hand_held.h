// Sections of a scene for a coupled simulation: [coupling], [device], [hand], [loop]. A run along a path (`kerf run`)
// ignores them; `kerf loop` uses the defaults of sections that the file leaves out.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/core/describe.h"
#include "device/devices/workspace.h"
#include "kerf/coupled.h"

namespace kerf {

/// Point at which the spring between handle and tool holds the tool: its origin, or the hand's grip.
enum class CouplingPoint { kTool, kGrip };

struct SceneCoupling {
  bool given = false;  // the file has the section; not a key. Likewise below.
  CouplingPoint at = CouplingPoint::kTool;
  CouplingParams params;  // all but its point
};

struct SceneDevice {
  bool given = false;
  std::string profile = "omega_6";
  std::string file;        // table of profiles (CSV), absolute path; empty: the built-in ones
  std::string file_place;  // place of that key, "scene.toml:12:8", for messages; not a key
  double expected_peak_N = 28;
  double expected_peak_torque_Nmm = 400;
  double slew_N_per_s = 1000;
  double ramp_s = 0.5;
  int delay_ticks = 0;
  // For a real device (WorkspaceParams).
  double motion_scale = 1;
  Quat orientation = kFacingPatient;
  bool left_handed = false;
};

struct SceneHand {
  bool given = false;
  std::string model = "H3";
  double push_N = 5;
  double lead_mm = 15;
  double lift_mm_per_s = 20;
};

struct SceneLoop {
  bool given = false;
  double rate_hz = 1000;
  bool degrade = false;
  double budget_share = 0.8;
  double overrun_share = 0.1;
  double calm_s = 2;
  double watchdog_ms = 50;
  int publish_leaves_per_tick = 4;
};

template <typename V>
void Describe(SceneCoupling& p, V&& visit) {
  CouplingParams& q = p.params;
  std::string at = p.at == CouplingPoint::kGrip ? "grip" : "tool";
  visit(
      "at", at, Choices{{"tool", "grip"}},
      "point at which the spring holds the tool: its centre, as needed by a device without torque, or the hand's grip");
  p.at = at == "grip" ? CouplingPoint::kGrip : CouplingPoint::kTool;
  visit("stiffness_N_per_mm", q.stiffness_N_per_mm, Range{1e-3, 1000},
        "stiffness of the spring between handle and tool; lowered to the limits of device and loop");
  visit("damping_Ns_per_mm", q.damping_Ns_per_mm, Range{0, 1},
        "damping between handle and tool; also lowered, and raised to the minimum that a sampled spring needs");
  visit("torsion_Nmm_per_rad", q.torsion_Nmm_per_rad, Range{1, 1e7}, "torsional stiffness between handle and tool");
  visit("torsion_damping_Nmms", q.torsion_damping_Nmms, Range{0, 1e4}, "torsional damping between handle and tool");
  visit("max_force_N", q.max_force_N, Range{0.1, 1e4}, "maximum force of the spring, however far the handle moves");
  visit("max_torque_Nmm", q.max_torque_Nmm, Range{1, 1e6},
        "maximum torque of the torsional spring, however far the handle turns");
}

/// Visits all keys except the texts.
template <typename V>
void Describe(SceneDevice& p, V&& visit) {
  visit("expected_peak_N", p.expected_peak_N, Range{0.1, 1e4},
        "simulated force that is scaled to the device's peak force, if it is larger than this peak");
  visit("expected_peak_torque_Nmm", p.expected_peak_torque_Nmm, Range{1, 1e7},
        "simulated torque that is scaled to the device's peak torque, if it is larger than this peak");
  visit("slew_N_per_s", p.slew_N_per_s, Range{1, 1e7}, "maximum rate of change of the device's force");
  visit("ramp_s", p.ramp_s, Range{0, 60}, "time over which the force ramps up at the start and after each fault");
  visit(
      "delay_ticks", p.delay_ticks, Range{0, 16},
      "delay of the device's force in ticks, in addition to the loop's own: 2 for a device that has a separate thread");
  visit("motion_scale", p.motion_scale, Range{0.02, 20}, "motion of the tool, in mm per mm of the device's handle");
  visit("orientation", p.orientation,
        "orientation of a real device in the world: unit quaternion [w, x, y, z]; its x to the user's right, y up, z "
        "towards the user");
  visit("left_handed", p.left_handed,
        "true: mirrors the orientation for a left-handed user, and exchanges the right and the left button");
}

/// Values of `model` in [hand].
const std::vector<std::string_view>& HandWords();

template <typename V>
void Describe(SceneHand& p, V&& visit) {
  visit("model", p.model, Choices{HandWords()},
        "model of the hand (mass, spring and damper): released, light pinch, pen grip, resting arm, power grip");
  visit("push_N", p.push_N, Range{0, 200},
        "maximum force with which the hand presses against the resistance along a stroke, in addition to its spring's "
        "pull");
  visit("lead_mm", p.lead_mm, Range{0.1, 500},
        "maximum distance by which the hand aims ahead of the handle; at this distance it waits");
  visit("lift_mm_per_s", p.lift_mm_per_s, Range{0.1, 1000},
        "speed of the return and of the move to the start of the next stroke");
}

template <typename V>
void Describe(SceneLoop& p, V&& visit) {
  visit("rate_hz", p.rate_hz, Range{250, 4000}, "ticks per second");
  visit("degrade", p.degrade,
        "true: if ticks keep exceeding their time budget, the fidelity is lowered to coarse, then to slab");
  visit("budget_share", p.budget_share, Range{0.05, 1}, "fraction of the period that a tick may take: the time budget");
  visit("overrun_share", p.overrun_share, Range{0, 1},
        "fraction of the ticks in 0.1 s that may exceed the time budget before the fidelity is lowered");
  visit("calm_s", p.calm_s, Range{0.1, 3600},
        "time with ticks below half the budget after which the fidelity is raised again");
  visit("watchdog_ms", p.watchdog_ms, Range{2, 10000},
        "time since the start of a tick after which the watchdog sets the device's force to zero");
  visit("publish_leaves_per_tick", p.publish_leaves_per_tick, Range{0, 1000},
        "maximum number of changed leaves (blocks of 8 x 8 x 8 voxels) sent to the renderer per tick");
}

}  // namespace kerf
