// Sections of a scene for a coupled simulation: [coupling], [device], [hand], [loop]. A run along a path (`kerf run`)
// ignores them; `kerf loop` uses the defaults of sections that the file leaves out.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "device/devices/workspace.h"
#include "kerf/coupling.h"
#include "kerf/describe.h"
#include "loop/haptics/force_map.h"
#include "loop/haptics/loop_params.h"

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
  std::string at = p.at == CouplingPoint::kGrip ? "grip" : "tool";
  visit(
      "at", at, Choices{{"tool", "grip"}},
      "point at which the spring holds the tool: its centre, as needed by a device without torque, or the hand's grip");
  p.at = at == "grip" ? CouplingPoint::kGrip : CouplingPoint::kTool;
  DescribeSprings(p.params, visit);
}

/// Visits all keys except the texts.
template <typename V>
void Describe(SceneDevice& p, V&& visit) {
  DescribeForceScale(p, p.ramp_s, false, visit);
  DescribeDelay(p.delay_ticks, visit);
  DescribeMotion(p, visit);
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
  DescribeRate(p.rate_hz, visit);
  DescribeGovernor(p, visit);
  DescribeWatchdog(p.watchdog_ms, visit);
  DescribeLeaves("publish_leaves_per_tick", p.publish_leaves_per_tick, visit);
}

}  // namespace kerf
