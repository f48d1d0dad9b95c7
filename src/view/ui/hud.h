// Contents of the flat panels over the picture: plain values, no drawing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "view/picture/colours.h"

namespace kerf {

/// Values shown with one or two decimals, unset ones as a dash.
struct HudValues {
  std::optional<double> depth_mm;        // depth of the tool's lowest point below the surface where it entered
  std::optional<double> feed_mm_per_s;   // of the tool
  std::optional<double> rpm;             // of the spindle, or double strokes a minute
  std::optional<double> force_N;         // on the hand
  std::optional<double> nerve_mm;        // distance from blade to nerve canal; 0 or less: the canal is cut
  bool nerve_is_crossed = false;         // the canal is to be cut, so that a small distance is no alarm
  bool nerve_is_marked = true;           // false: the bone has neither a canal nor a mark of one
  std::string nerve_injury = {};         // "injured", "severed"; empty: none
  std::string teeth_injury = {};         // the same of teeth and roots
  std::optional<double> plan_angle_deg;  // angle between the blade and the plane of the plan
  std::optional<double> plan_offset_mm;  // distance of the blade from that plane
  std::string plan_side = {};            // of that plane on which the blade is: "left"; empty: not named
  bool has_plan = true;                  // false: these two are left out
  bool plan_is_of_saw = false;           // these two are named as those of the saw now, not of the cut
  bool strokes = false;                  // the tool has a stroke
  bool feed_is_along = false;            // the feed is that along the wanted line
  std::optional<double> wanted_feed_mm_per_s = {};
  std::optional<double> key_feed_mm_per_s = {};  // with which keys move the saw
};

struct PlotPoint {
  double time_s = 0;
  double force_N = 0;
};

enum class HudLevel : std::uint8_t { kPlain, kGood, kWarn, kBad };

/// Gauge of a quantity with a goal. Its colour, shape and word all show the same level.
struct HudGauge {
  std::string title;  // "Depth"
  std::string unit = "mm";
  double lower = 0;  // range of the bar
  double upper = 10;
  std::optional<double> value;
  std::optional<double> goal;  // marked on the bar
  double good = 0.3;           // tolerance around the goal that counts as good
  double warn = 1;             // before the goal: tolerance for a warning
  double bad = 1;              // beyond the goal: tolerance for a warning; more is bad
  HudLevel level = HudLevel::kPlain;
  std::string word;  // "go on", "slow down", "stop", "too deep"
};

struct HudStatus {
  bool spindle_on = false;
  std::string saw;   // its name
  std::string mode;  // "Rehearse", an exercise's title, ...
  // The same in short, for a narrow window; empty: the full text is left out there.
  std::string short_saw = {};
  std::string short_mode = {};
  std::string short_right = {};
  std::string message;
  std::string warning{};  // stays beside later messages
  std::optional<double> recording_s;
  std::string right;  // at the right end: "F1 help", missed ticks, ...
};

struct HudPiece {
  std::string name;
  std::string detail;   // volume
  std::string contact;  // gap to, or overlap with, another piece, on a line of its own; empty: none
  Rgb8 colour = kBoneColour;
  bool selected = false;
  bool hidden = false;
  std::string tip{};      // its volume and position in full
  bool overlaps = false;  // it overlaps another piece: `contact` has the mark of a warning
  std::string moved{};    // how far, on a line of its own; empty: it was not moved
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
/// List to choose from.
struct HudMenu {
  std::string title;
  std::vector<HudMenuRow> rows;
  int selected = 0;
  std::string footer;  // explains the keys
};

struct HudProgress {
  std::string title;  // "Loading body_osteotomy.toml"
  std::string stage;
  std::optional<double> fraction = std::nullopt;  // 0 to 1; unset: unknown
  std::optional<double> left_s = std::nullopt;    // estimated time until the end
  bool can_cancel = false;
};

struct HudBanner {
  enum class Kind : std::uint8_t { kNotice, kWarning, kQuestion };
  Kind kind = Kind::kNotice;
  std::string text;
  std::string answers;  // "Y yes   N no"; optional
};

/// Contents of the panels that do not accept input, except for clicks on rows. Unset or empty members take no space.
struct HudState {
  bool show_values = true;
  HudValues values;
  bool show_plot = true;
  std::vector<PlotPoint> force;  // in order of time; the last 10 s are shown
  double now_s = 0;              // time at the plot's right end
  std::string force_note;        // comparison of the force with a measured one; below the plot
  std::string force_details;     // the same in technical terms; its tooltip
  std::optional<HudGauge> gauge;
  HudStatus status;
  std::vector<HudPiece> pieces;
  std::string legend_title;
  std::vector<LegendEntry> legend;
  std::optional<HudMenu> menu;
  std::optional<HudProgress> progress;
  std::optional<HudBanner> banner;
  std::vector<std::string> injuries;  // a line for each injured structure; shown, with a border, as long as it is one
};

}  // namespace kerf
