// What the flat panels over the picture show: plain values, no drawing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "view/picture/colours.h"

namespace kerf {

/// Shown with one or two decimals; none: "-".
struct HudValues {
  std::optional<double> depth_mm;           // of the tool's lowest point under the surface where it entered
  std::optional<double> feed_mm_per_s;      // of the tool
  std::optional<double> rpm;                // of the spindle
  std::optional<double> force_N;            // on the hand
  std::optional<double> nerve_mm;           // blade to the canal; not above 0: it is cut
  std::optional<double> plan_angle_deg;     // blade to the plan's plane
  std::optional<double> plan_offset_mm;     // likewise
  std::optional<double> nerve_warn_mm = 2;  // nearer than this is marked
};

struct PlotPoint {
  double time_s = 0;
  double force_N = 0;
};

enum class HudLevel : std::uint8_t { kPlain, kGood, kWarn, kBad };

/// How far something is from where it is to be. Colour, shape and word say the same.
struct HudGauge {
  std::string title;  // "Depth"
  std::string unit = "mm";
  double lower = 0;  // the bar's ends
  double upper = 10;
  std::optional<double> value;
  std::optional<double> goal;  // a mark
  double good = 0.3;           // within so much of the goal
  double warn = 1;             // within so much; beyond the goal by more than that is bad
  HudLevel level = HudLevel::kPlain;
  std::string word;  // "go on", "slow down", "stop", "too deep"
};

struct HudStatus {
  bool spindle_on = false;
  std::string saw;   // its name
  std::string mode;  // "Rehearse", an exercise's title, ...
  std::string message;
  std::optional<double> recording_s;
  std::string right;  // at the right end: "F1 help", ticks missed, ...
};

struct HudPiece {
  std::string name;
  std::string detail;  // volume, moved by
  Rgb8 colour = kBoneColour;
  bool selected = false;
  bool hidden = false;
};

struct HudKey {
  std::string keys;
  std::string meaning;
};
struct HudKeyGroup {
  std::string title;
  std::vector<HudKey> keys;
};

struct HudMenuRow {
  std::string name;
  std::string detail;
  bool enabled = true;
};
struct HudMenu {
  std::string title;
  std::vector<HudMenuRow> rows;  // what does not fit is scrolled, so that the selected one is seen
  int selected = 0;
  std::string footer;  // which keys do what
};

struct HudResultRow {
  std::string name;
  std::string value;  // with its unit
  std::string note;   // "goal 0.5 mm", "information"
  HudLevel level = HudLevel::kPlain;
};
struct HudResult {
  std::string title;
  std::string headline;  // "82 of 100"
  std::vector<HudResultRow> rows;
  std::string footer;
};

struct HudProgress {
  std::string title;  // "Loading body_osteotomy.toml"
  std::string stage;
  std::optional<double> fraction;  // 0 to 1; none: unknown
};

struct HudBanner {
  enum class Kind : std::uint8_t { kNotice, kWarning, kQuestion };
  Kind kind = Kind::kNotice;
  std::string text;
  std::string answers;  // "Y yes   N no"; may be empty
};

/// Everything that is flat. What is none or empty takes no room.
struct HudState {
  bool show_values = true;
  HudValues values;
  bool show_plot = true;
  std::vector<PlotPoint> force;  // in order of time; the last 10 s are shown
  double now_s = 0;              // the plot's right end
  std::string force_note;        // how near the force is to a measured one; below the plot
  std::optional<HudGauge> gauge;
  HudStatus status;
  std::vector<HudPiece> pieces;
  std::string legend_title;
  std::vector<LegendEntry> legend;
  bool show_help = false;
  std::vector<HudKeyGroup> help;
  std::optional<HudMenu> menu;
  std::optional<HudResult> result;
  std::optional<HudProgress> progress;
  std::optional<HudBanner> banner;
};

}  // namespace kerf
