// A set of published measurements, with which the force laws are compared, and its file (docs/formats.md).
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/describe.h"

namespace kerf {

/// Value of a number that the file does not give.
inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
inline bool IsGiven(double value) {
  return std::isfinite(value);
}

/// Conditions of a measurement; a condition that is not known is kNotGiven.
struct MeasuredConditions {
  double bite_um = kNotGiven;
  double speed_mm_per_s = kNotGiven;  // of the teeth
  double rpm = kNotGiven;
  double feed_mm_per_min = kNotGiven;
  double cycles_per_min = kNotGiven;
  double force_N = kNotGiven;  // on all engaged teeth together
  double density = kNotGiven;  // relative to the bone of the measurements
};
template <typename V>
void Describe(MeasuredConditions& p, V&& visit) {
  visit("bite_um", p.bite_um, Range{0.01, 2000}, "depth that one tooth cuts, um");
  visit("speed_mm_per_s", p.speed_mm_per_s, Range{0.01, 1e6}, "speed of the teeth");
  visit("rpm", p.rpm, Range{0.1, 1e6}, "speed of a drill");
  visit("feed_mm_per_min", p.feed_mm_per_min, Range{0.001, 1e6}, "feed, mm/min");
  visit("cycles_per_min", p.cycles_per_min, Range{0.1, 1e6}, "speed of a reciprocating blade, cycles/min");
  visit("force_N", p.force_N, Range{0.001, 1e4}, "force on all engaged teeth together");
  visit("density", p.density, Range{0.01, 10}, "density of the bone relative to that of the other measurements");
}

/// Ways to simulate a set.
inline constexpr std::string_view kToolNone = "none";  // nothing is simulated
inline constexpr std::string_view kToolTooth = "tooth";
inline constexpr std::string_view kToolDrill = "drill";
inline constexpr std::string_view kToolBladeForce = "blade_force";
inline constexpr std::string_view kToolBladeFeed = "blade_feed";

struct MeasuredTool {
  std::string kind{kToolNone};
  double width_mm = kNotGiven;     // of a tooth
  double diameter_mm = kNotGiven;  // of a drill
  double point_deg = kNotGiven;    // of a drill: angle between its lips
  double teeth = kNotGiven;        // of a blade: engaged at once
  double pitch_mm = kNotGiven;     // of a blade with which the trends are also sawn
  double stroke_mm = kNotGiven;    // of a reciprocating one
  double radius_mm = kNotGiven;    // of an oscillating one
  double swing_deg = kNotGiven;
  bool is_reciprocating() const { return IsGiven(pitch_mm) && IsGiven(stroke_mm); }
  bool is_oscillating() const { return IsGiven(pitch_mm) && IsGiven(radius_mm) && IsGiven(swing_deg); }
};
template <typename V>
void Describe(MeasuredTool& p, V&& visit) {
  visit("kind", p.kind, Choices{{kToolNone, kToolTooth, kToolDrill, kToolBladeForce, kToolBladeFeed}},
        "what is simulated: nothing, one tooth at a given bite, the two lips of a twist drill, a blade under a given "
        "force, or a blade with a given feed");
  visit("width_mm", p.width_mm, Range{0.05, 10}, "width of a tooth");
  visit("diameter_mm", p.diameter_mm, Range{0.5, 20}, "diameter of a drill");
  visit("point_deg", p.point_deg, Range{60, 180}, "angle between the lips of a drill");
  visit("teeth", p.teeth, Range{1, 1000}, "number of engaged teeth of a blade");
  visit("pitch_mm", p.pitch_mm, Range{0.1, 20},
        "distance between the teeth of a blade with which the trends are also sawn");
  visit("stroke_mm", p.stroke_mm, Range{0.05, 30}, "stroke of that blade, from end to end: a reciprocating one");
  visit("radius_mm", p.radius_mm, Range{3, 100}, "distance of its teeth from its swing axis: an oscillating one");
  visit("swing_deg", p.swing_deg, Range{0.1, 20}, "angle between the ends of its swing");
}

/// Quantities, named with their units.
struct MeasuredQuantity {
  std::string_view name;
  std::string_view label;  // with unit, for people
  bool of_tooth;           // whether a tooth, ... has this quantity
  bool of_drill;
  bool of_blade_force;
  bool of_blade_feed;
  bool only_trend;  // its size is not simulated, only the sign of its change
};
const std::vector<MeasuredQuantity>& MeasuredQuantities();
/// Throws Error if there is no such quantity.
const MeasuredQuantity& FindQuantity(std::string_view name);

/// How a number was obtained: "read" in the publication, "derived" by arithmetic from numbers that were read, or
/// "recalled" from memory and not checked.
inline Choices ObtainedChoices() {
  return {{"read", "derived", "recalled"}};
}

struct MeasuredValue {
  std::string quantity;
  std::string material = "cortical";  // "cortical", or "artificial", with which nothing is compared
  double value = kNotGiven;           // mean; or low and high
  double sd = kNotGiven;
  double low = kNotGiven;  // range
  double high = kNotGiven;
  MeasuredConditions at;
  std::string obtained;
  std::string note;
};
template <typename V>
void Describe(MeasuredValue& p, V&& visit) {
  constexpr Range kValues{1e-9, 1e6};  // magnitudes
  visit("material", p.material, Choices{{"cortical", "artificial"}}, "material that was cut");
  visit("value", p.value, kValues, "mean, in the unit of the quantity's name");
  visit("sd", p.sd, kValues, "standard deviation of `value`");
  visit("low", p.low, kValues, "lower end of a range, instead of `value`");
  visit("high", p.high, kValues, "upper end of the range");
  visit("obtained", p.obtained, ObtainedChoices(), "how the numbers were obtained");
  visit("note", p.note, TextLimit{400}, "remark");
}

/// Change of a quantity with one condition.
struct MeasuredTrend {
  std::string quantity;
  std::string against;      // name of a condition
  double from = kNotGiven;  // of that condition; not given: 1 and 2 times the set's value
  double to = kNotGiven;
  std::string sign;          // "rises", "falls" or "constant"
  double ratio = kNotGiven;  // value at `to` divided by that at `from`
  MeasuredConditions at;     // other conditions
  std::string obtained;
  std::string note;
};
template <typename V>
void Describe(MeasuredTrend& p, V&& visit) {
  constexpr Range kConditions{1e-6, 1e6};
  visit("from", p.from, kConditions, "value of the condition at the start; default: that of [conditions]");
  visit("to", p.to, kConditions, "value of the condition at the end; default: twice that of [conditions]");
  visit("sign", p.sign, Choices{{"rises", "falls", "constant"}}, "change of the quantity from `from` to `to`");
  visit("ratio", p.ratio, Range{1e-6, 1e6}, "quantity at `to` divided by that at `from`, if it is known");
  visit("obtained", p.obtained, ObtainedChoices(), "how the sign was obtained");
  visit("note", p.note, TextLimit{400}, "remark");
}

/// What is known and not compared.
struct MeasuredRemark {
  std::string text;
  std::string obtained;
};
template <typename V>
void Describe(MeasuredRemark& p, V&& visit) {
  visit("text", p.text, TextLimit{600}, "what is known, and why it is not compared");
  visit("obtained", p.obtained, ObtainedChoices(), "how it was obtained");
}

struct MeasuredSet {
  std::string name;  // of the file, without folder and extension
  std::string title;
  std::string citation;
  std::string doi;  // may be empty
  std::string specimen;
  std::string setup;
  std::string licence;
  std::string assumptions;              // of the simulation; may be empty
  std::vector<std::string> calibrated;  // laws whose parameters were derived from this set
  MeasuredTool tool;
  MeasuredConditions conditions;  // of every value and trend that does not give its own
  std::vector<MeasuredValue> values;
  std::vector<MeasuredTrend> trends;
  std::vector<MeasuredRemark> remarks;
};
template <typename V>
void Describe(MeasuredSet& p, V&& visit) {
  visit("title", p.title, TextLimit{120}, "what was measured");
  visit("citation", p.citation, TextLimit{300}, "publication");
  visit("doi", p.doi, TextLimit{100}, "its DOI; empty if it is not known");
  visit("specimen", p.specimen, TextLimit{300}, "what was cut");
  visit("setup", p.setup, TextLimit{300}, "tool and conditions");
  visit("licence", p.licence, TextLimit{300}, "licence of the numbers");
  visit("assumptions", p.assumptions, TextLimit{600}, "what kerf assumes in order to simulate the set");
}

/// Returns the conditions of `own`, and those of `common` where `own` gives none.
MeasuredConditions JoinConditions(const MeasuredConditions& own, const MeasuredConditions& common);
/// Returns a condition. Throws Error if there is none of that name.
double& ConditionOf(MeasuredConditions& conditions, std::string_view name);
/// Returns the conditions that are given, such as "1000 rpm, 120 mm/min".
std::string ShowConditions(const MeasuredConditions& conditions);
/// Returns a condition as text with its unit, such as "2.5 um".
std::string ShowCondition(std::string_view name, double value);

/// Parses a set; `name` becomes its name. Throws Error that lists each fault with its `file`:line:column: an unknown
/// key (with the nearest valid one), a wrong type, a value out of range, a quantity that the tool does not have, a
/// missing key.
MeasuredSet ParseMeasuredSet(const std::string& text, const std::string& file, const std::string& name);

}  // namespace kerf
