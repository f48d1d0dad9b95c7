// The sections of a scene that a hand holds the tool in: [coupling], [device], [hand], [loop]. A run along a path
// (`kerf run`) doesn't look at them; `kerf loop` takes the defaults of those that the file leaves out.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/core/describe.h"
#include "device/devices/workspace.h"
#include "kerf/coupled.h"

namespace kerf {

/// Where the spring between handle and tool holds the tool: at its own origin, or where the hand grips it.
enum class CouplingPoint { kTool, kGrip };

struct SceneCoupling {
  bool given = false;  // the file has the section; not a key. The same below.
  CouplingPoint at = CouplingPoint::kTool;
  CouplingParams params;  // all but its point
};

struct SceneDevice {
  bool given = false;
  std::string profile = "omega_6";
  std::string file;        // a table of profiles (CSV), absolute path; empty: the built-in ones
  std::string file_place;  // of that key, "scene.toml:12:8", for messages; not a key
  double expected_peak_N = 28;
  double expected_peak_torque_Nmm = 400;
  double slew_N_per_s = 1000;
  double ramp_s = 0.5;
  int delay_ticks = 0;
  // Of a device that is really there (WorkspaceParams).
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
  visit("at", at, Choices{{"tool", "grip"}},
        "where the spring holds the tool: at its centre, as a device without torques needs it, or at the grip");
  p.at = at == "grip" ? CouplingPoint::kGrip : CouplingPoint::kTool;
  visit("stiffness_N_per_mm", q.stiffness_N_per_mm, Range{1e-3, 1000},
        "spring between handle and tool; lowered to what device and loop bear");
  visit("damping_Ns_per_mm", q.damping_Ns_per_mm, Range{0, 1},
        "damper beside it; lowered likewise, and raised to what a sampled spring needs");
  visit("torsion_Nmm_per_rad", q.torsion_Nmm_per_rad, Range{1, 1e7}, "spring against turning");
  visit("torsion_damping_Nmms", q.torsion_damping_Nmms, Range{0, 1e4}, "damper against turning");
  visit("max_force_N", q.max_force_N, Range{0.1, 1e4}, "the spring gives no more, however far the handle goes");
  visit("max_torque_Nmm", q.max_torque_Nmm, Range{1, 1e6}, "nor more torque");
}

/// Its texts aside.
template <typename V>
void Describe(SceneDevice& p, V&& visit) {
  visit("expected_peak_N", p.expected_peak_N, Range{0.1, 1e4},
        "force in the simulation that the device's peak force stands for, if it is more than that");
  visit("expected_peak_torque_Nmm", p.expected_peak_torque_Nmm, Range{1, 1e7}, "torque likewise");
  visit("slew_N_per_s", p.slew_N_per_s, Range{1, 1e7}, "the device's force changes no faster");
  visit("ramp_s", p.ramp_s, Range{0, 60}, "over which the force comes in at the start and after each fault");
  visit("delay_ticks", p.delay_ticks, Range{0, 16},
        "ticks by which its force is late besides the loop's own: 2 for a device that a thread of its own serves");
  visit("motion_scale", p.motion_scale, Range{0.02, 20}, "mm of the tool for each of the device's handle");
  visit("orientation", p.orientation,
        "how a real device stands in the world: its x to the user's right, y up, z towards the user");
  visit("left_handed", p.left_handed, "mirrors that, and exchanges the right and the left button");
}

/// The words of `model` in [hand].
const std::vector<std::string_view>& HandWords();

template <typename V>
void Describe(SceneHand& p, V&& visit) {
  visit("model", p.model, Choices{HandWords()},
        "mass, spring and damper of the hand: released, light pinch, pen grip, resting arm, power grip");
  visit("push_N", p.push_N, Range{0, 200},
        "at most, that it leans with into what it feels along a stroke, besides its spring's pull");
  visit("lead_mm", p.lead_mm, Range{0.1, 500}, "so far ahead of the handle the hand aims at most; then it waits");
  visit("lift_mm_per_s", p.lift_mm_per_s, Range{0.1, 1000}, "speed of going back and over to the next stroke");
}

template <typename V>
void Describe(SceneLoop& p, V&& visit) {
  visit("rate_hz", p.rate_hz, Range{250, 4000}, "ticks a second");
  visit("degrade", p.degrade,
        "true: when ticks overrun for long, the tool is worked out more coarsely, down to a slab");
  visit("budget_share", p.budget_share, Range{0.05, 1}, "of the time from tick to tick that a tick may take");
  visit("overrun_share", p.overrun_share, Range{0, 1}, "of the ticks in 0.1 s; more over budget, and it steps down");
  visit("calm_s", p.calm_s, Range{0.1, 3600}, "of ticks below half the budget before it steps up again");
  visit("watchdog_ms", p.watchdog_ms, Range{2, 10000}, "a tick that began longer ago makes the device's force zero");
  visit("publish_leaves_per_tick", p.publish_leaves_per_tick, Range{0, 1000},
        "blocks of 8 x 8 x 8 voxels that have changed, sent to those who draw the bone");
}

}  // namespace kerf
