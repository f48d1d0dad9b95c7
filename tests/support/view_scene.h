// Complete contents of a window, for tests and for pictures that are inspected by eye.
#pragma once

#include <cmath>
#include <string>

#include "view/ui/hud.h"

namespace kerf::test {

inline HudState MakeFullHud() {
  HudState hud;
  hud.values = {.depth_mm = 3.42,
                .feed_mm_per_s = 5.1,
                .rpm = 7500,
                .force_N = 2.31,
                .nerve_mm = 1.4,
                .plan_angle_deg = 2.7,
                .plan_offset_mm = 0.38};
  hud.now_s = 14;
  hud.force_note = "The chips are thinner than in published tests on bone: the force is an estimate.";
  hud.force_details = "hertz_chip: thrust 1.6 times that measured at a bite of 2.5 um, 9 times at 10 um (22 mm disc)";
  for (int i = 0; i < 14000; i += 5) {
    const double t = 0.001 * i;
    hud.force.push_back({t, 1.6 + 0.9 * std::sin(1.3 * t) + 0.25 * std::sin(61 * t)});
  }
  HudGauge gauge;
  gauge.title = "Depth";
  gauge.value = 3.42;
  gauge.goal = 4;
  gauge.upper = 8;
  gauge.level = HudLevel::kWarn;
  gauge.word = "slow down";
  hud.gauge = gauge;
  hud.status.spindle_on = true;
  hud.status.saw = "disc 22 x 0.25 mm, 24 teeth";
  hud.status.mode = "Rehearse";
  hud.status.message = "checkpoint \"before second cut\" made";
  hud.status.recording_s = 83;
  hud.status.right = "F1 help";
  hud.pieces = {{"ramus, left", "12.48 cm\xc2\xb3", "gap 0.52 mm with body", {86, 180, 233}, false, false},
                {"body", "31.02 cm\xc2\xb3", "gap 0.52 mm with ramus, left", {230, 159, 0}, true, false},
                {"splinter", "0.04 cm\xc2\xb3", "apart", {0, 158, 115}, false, true}};
  return hud;
}

inline std::vector<HudKeyGroup> MakeHelp() {
  return {{"Move the saw",
           {{"mouse", "in the picture's plane"},
            {"wheel", "towards and away"},
            {"right button + mouse", "turn the blade"},
            {"Q E", "roll about the spindle"},
            {"shift", "ten times finer"}}},
          {"Spindle and saw", {{"space", "spindle on, off"}, {"[ ]", "previous, next saw"}, {"1 to 9", "speed"}}},
          {"Look",
           {{"middle button + mouse", "turn the view"},
            {"shift + middle button", "move the view"},
            {"F", "all in view"},
            {"number pad", "front, left, top, ..."},
            {"T", "translucent"},
            {"C", "colours: plain, tissue, region"}}},
          {"Plan", {{"P", "plane at the blade"}, {"D", "depth stop here"}, {"G", "guide on, off"}}},
          {"Pieces",
           {{"left click", "choose"},
            {"H", "hide"},
            {"Del", "delete"},
            {"arrows", "move along an axis"},
            {"M", "measure"}}},
          {"Session",
           {{"ctrl Z, ctrl Y", "undo, redo"},
            {"K", "checkpoint"},
            {"F2", "screenshot"},
            {"F3", "report"},
            {"Esc", "end"}}}};
}

}  // namespace kerf::test
