#include "experiment/validation/measured_set.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/core/nearest_name.h"
#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "base/toml/toml_document.h"
#include "experiment/validation/law_access.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxRows = 500;
constexpr std::string_view kConditionNames[] = {"bite_um",        "speed_mm_per_s", "rpm",    "feed_mm_per_min",
                                                "cycles_per_min", "force_N",        "density"};

Choices MakeQuantityChoices() {
  Choices choices;
  for (const MeasuredQuantity& quantity : MeasuredQuantities()) choices.words.push_back(quantity.name);
  return choices;
}

Choices MakeConditionChoices() {
  return {{std::begin(kConditionNames), std::end(kConditionNames)}};
}

bool Has(const MeasuredQuantity& quantity, std::string_view kind) {
  return kind == kToolTooth        ? quantity.of_tooth
         : kind == kToolDrill      ? quantity.of_drill
         : kind == kToolBladeForce ? quantity.of_blade_force
         : kind == kToolBladeFeed  ? quantity.of_blade_feed
                                   : true;
}

/// Returns the conditions on which a tool's forces depend.
std::vector<std::string_view> ConditionsOf(std::string_view kind) {
  if (kind == kToolTooth) return {"bite_um", "speed_mm_per_s", "density"};
  if (kind == kToolDrill) return {"rpm", "feed_mm_per_min", "density"};
  if (kind == kToolBladeForce) return {"force_N", "speed_mm_per_s", "density"};
  if (kind == kToolBladeFeed) return {"feed_mm_per_min", "cycles_per_min", "density"};
  return {std::begin(kConditionNames), std::end(kConditionNames)};
}

/// Reads the list of laws. Every name must be that of a law.
void ReadCalibrated(TableReader& reader, Faults& faults, std::vector<std::string>& calibrated) {
  const TomlNode* node = reader.Node("calibrated");
  if (node == nullptr) return reader.Require("calibrated");
  const std::vector<std::string> laws = LawNames();
  const std::string wanted = fmt::format("a list of laws (\"{}\"); empty if none", fmt::join(laws, "\", \""));
  if (node->kind != TomlNode::Kind::kArray) return reader.Fault("calibrated", "calibrated must be " + wanted);
  for (const TomlNode& item : node->children) {
    if (faults.full()) return;
    if (item.kind != TomlNode::Kind::kText) {
      faults.Add(item.line, item.column, fmt::format("calibrated: {} must be the name of a law", item.Show()));
    } else if (std::find(laws.begin(), laws.end(), item.text) == laws.end()) {
      const std::string nearest = FindNearestName(item.text.substr(0, 100), laws);
      faults.Add(item.line, item.column,
                 fmt::format("calibrated: there is no force law {}; {}", item.Show(),
                             nearest.empty() ? "it must be " + wanted : "the nearest is \"" + nearest + "\""));
    } else {
      calibrated.push_back(item.text);
    }
  }
}

/// Requires all dimensions of the blade with which trends are also sawn, if one is given.
void RequireBlade(TableReader& inner, const MeasuredTool& tool) {
  const bool swings = tool.kind == kToolBladeFeed;
  const std::vector<const char*> needed = swings ? std::vector<const char*>{"pitch_mm", "radius_mm", "swing_deg"}
                                                 : std::vector<const char*>{"pitch_mm", "stroke_mm"};
  const char* given = nullptr;
  for (const char* key : {"pitch_mm", "stroke_mm", "radius_mm", "swing_deg"}) {
    if (!inner.Has(key)) continue;
    given = key;
    const bool fits = tool.kind != kToolDrill && tool.kind != kToolNone &&
                      std::find(needed.begin(), needed.end(), std::string_view(key)) != needed.end();
    if (!fits)
      inner.Fault(key, fmt::format("a tool of kind \"{}\" is not sawn with a blade that has {}", tool.kind, key));
  }
  if (given == nullptr) return;
  for (const char* key : needed) inner.Require(key);
}

void ReadTool(TableReader& reader, Faults& faults, MeasuredTool& tool) {
  const TomlNode* table = reader.Table("tool");
  if (table == nullptr) return;
  TableReader inner(*table, "[tool]", faults);
  Describe(tool, inner);
  inner.Require("kind");
  inner.Finish();
  if (tool.kind == kToolTooth || tool.kind == kToolBladeFeed || tool.kind == kToolBladeForce) inner.Require("width_mm");
  if (tool.kind == kToolBladeForce) inner.Require("teeth");
  RequireBlade(inner, tool);
  if (tool.kind == kToolDrill) {
    inner.Require("diameter_mm");
    inner.Require("point_deg");
  }
}

void ReadConditions(TableReader& reader, Faults& faults, MeasuredSet& set) {
  if (const TomlNode* table = reader.Table("conditions")) {
    TableReader inner(*table, "[conditions]", faults);
    Describe(set.conditions, inner);
    inner.Finish();
  }
  if (set.tool.kind != kToolBladeFeed) return;
  const MeasuredConditions& c = set.conditions;
  if (!IsGiven(c.bite_um) || !IsGiven(c.feed_mm_per_min) || !IsGiven(c.cycles_per_min)) {
    reader.Fault("conditions",
                 "a tool of kind \"blade_feed\" needs bite_um, feed_mm_per_min and cycles_per_min in [conditions]: the "
                 "bite is proportional to feed / speed");
  }
}

/// Reads the quantity, which the set's tool must have.
void ReadQuantity(TableReader& reader, const MeasuredTool& tool, bool trend, std::string& quantity) {
  reader("quantity", quantity, MakeQuantityChoices(), "quantity");
  reader.Require("quantity");
  if (quantity.empty()) return;
  const MeasuredQuantity& found = FindQuantity(quantity);
  if (!Has(found, tool.kind)) {
    reader.Fault("quantity", fmt::format("a tool of kind \"{}\" has no {}", tool.kind, quantity));
  } else if (found.only_trend && !trend) {
    reader.Fault("quantity", fmt::format("{} can only be the quantity of a trend; write a remark", quantity));
  }
}

void CheckNumbers(TableReader& reader, const MeasuredValue& value) {
  const bool range = reader.Has("low") || reader.Has("high");
  if (range && (reader.Has("value") || reader.Has("sd"))) {
    reader.Fault(reader.Has("value") ? "value" : "sd", "give either value (and sd), or low and high");
  } else if (range) {
    reader.Require("low");
    reader.Require("high");
    if (value.low > value.high) reader.Fault("low", fmt::format("low = {} exceeds high = {}", value.low, value.high));
  } else {
    reader.Require("value");
  }
}

MeasuredValue ReadValue(const TomlNode& table, const MeasuredTool& tool, Faults& faults) {
  MeasuredValue value;
  TableReader reader(table, "[[value]]", faults);
  ReadQuantity(reader, tool, false, value.quantity);
  Describe(value, reader);
  Describe(value.at, reader);
  reader.Require("obtained");
  reader.Finish();
  CheckNumbers(reader, value);
  return value;
}

/// Checks the ends of a trend against the range of its condition.
void CheckEnds(TableReader& reader, const MeasuredTrend& trend) {
  const Range range = FindRange<MeasuredConditions>(trend.against);
  for (const auto& [key, value] : {std::pair{"from", trend.from}, {"to", trend.to}}) {
    if (!IsGiven(value)) continue;
    const std::string fault = FindRangeFault(value, range, UnitOfKey(trend.against));
    if (!fault.empty()) reader.Fault(key, fmt::format("{} = {} {}", key, value, fault));
  }
}

MeasuredTrend ReadTrend(const TomlNode& table, const MeasuredSet& set, Faults& faults) {
  MeasuredTrend trend;
  TableReader reader(table, "[[trend]]", faults);
  ReadQuantity(reader, set.tool, true, trend.quantity);
  reader("against", trend.against, MakeConditionChoices(), "condition that changes");
  Describe(trend, reader);
  Describe(trend.at, reader);
  for (const char* key : {"against", "sign", "obtained"}) reader.Require(key);
  reader.Finish();
  if (trend.against.empty()) return trend;
  const std::vector<std::string_view> conditions = ConditionsOf(set.tool.kind);
  if (std::find(conditions.begin(), conditions.end(), trend.against) == conditions.end()) {
    reader.Fault("against", fmt::format("a tool of kind \"{}\" does not depend on {}; it depends on {}", set.tool.kind,
                                        trend.against, fmt::join(conditions, ", ")));
  }
  if (reader.Has(trend.against.c_str())) {
    reader.Fault(trend.against.c_str(), fmt::format("{} changes from `from` to `to`; leave it out", trend.against));
  }
  if (reader.Has("from") != reader.Has("to")) {
    reader.Fault(reader.Has("from") ? "from" : "to", "give both from and to, or neither");
  } else if (reader.Has("from") && trend.from == trend.to) {
    reader.Fault("to", "from and to must differ");
  }
  CheckEnds(reader, trend);
  MeasuredConditions common = set.conditions;
  if (!reader.Has("from") && trend.against != "density" && !IsGiven(ConditionOf(common, trend.against))) {
    reader.Fault("against", fmt::format("without from and to, [conditions] must give {}", trend.against));
  }
  return trend;
}

MeasuredRemark ReadRemark(const TomlNode& table, Faults& faults) {
  MeasuredRemark remark;
  TableReader reader(table, "[[remark]]", faults);
  Describe(remark, reader);
  reader.Require("text");
  reader.Require("obtained");
  reader.Finish();
  return remark;
}

/// Calls visit(name, value) for each condition that is given.
template <typename Visit>
void VisitGiven(const MeasuredConditions& conditions, Visit visit) {
  MeasuredConditions copy = conditions;
  for (const std::string_view name : kConditionNames) {
    const double value = ConditionOf(copy, name);
    if (IsGiven(value)) visit(name, value);
  }
}

}  // namespace

const std::vector<MeasuredQuantity>& MeasuredQuantities() {
  static const std::vector<MeasuredQuantity> kQuantities{
      {"thrust_N", "thrust (N)", true, true, false, true, false},
      {"cutting_N", "cutting force (N)", true, false, false, true, false},
      {"resultant_N", "resultant force (N)", true, false, false, true, false},
      {"thrust_per_cutting", "thrust / cutting force", true, false, false, false, false},
      {"energy_J_per_mm3", "energy per volume (J/mm3)", true, true, false, true, false},
      {"torque_Nmm", "torque (N mm)", false, true, false, false, false},
      {"removal_mm3_per_s", "removal rate (mm3/s)", false, false, true, false, false},
      {"temperature_rise", "temperature rise (relative)", false, false, false, true, true},
  };
  return kQuantities;
}

const MeasuredQuantity& FindQuantity(std::string_view name) {
  const auto& all = MeasuredQuantities();
  const auto found = std::find_if(all.begin(), all.end(), [&](const MeasuredQuantity& q) { return q.name == name; });
  if (found == all.end()) throw Error(fmt::format("there is no measured quantity {}", name));
  return *found;
}

double& ConditionOf(MeasuredConditions& c, std::string_view name) {
  double* found = nullptr;
  Describe(c, [&](const char* key, double& value, Range, const char*) {
    if (name == key) found = &value;
  });
  if (found == nullptr) throw Error(fmt::format("there is no condition {}", name));
  return *found;
}

MeasuredConditions JoinConditions(const MeasuredConditions& own, const MeasuredConditions& common) {
  MeasuredConditions joined = common;
  VisitGiven(own, [&](std::string_view name, double value) { ConditionOf(joined, name) = value; });
  return joined;
}

std::string ShowCondition(std::string_view name, double value) {
  if (name == "density") return fmt::format("density x {:g}", value);
  const std::string_view unit = name == "bite_um"           ? "um"
                                : name == "speed_mm_per_s"  ? "mm/s"
                                : name == "rpm"             ? "rpm"
                                : name == "feed_mm_per_min" ? "mm/min"
                                : name == "cycles_per_min"  ? "cycles/min"
                                                            : "N";
  return fmt::format("{:g} {}", value, unit);
}

std::string ShowConditions(const MeasuredConditions& conditions) {
  std::string text;
  VisitGiven(conditions, [&](std::string_view name, double value) {
    text += (text.empty() ? "" : ", ") + ShowCondition(name, value);
  });
  return text;
}

MeasuredSet ParseMeasuredSet(const std::string& text, const std::string& file, const std::string& name) {
  const TomlNode root = ParseToml(text, file);
  Faults faults(file);
  TableReader reader(root, "the file", faults);
  MeasuredSet set;
  set.name = name;
  Describe(set, reader);
  for (const char* key : {"title", "citation", "doi", "specimen", "setup", "licence"}) reader.Require(key);
  ReadCalibrated(reader, faults, set.calibrated);
  ReadTool(reader, faults, set.tool);
  ReadConditions(reader, faults, set);
  for (const TomlNode* table : reader.Tables("value", kMaxRows)) {
    if (!faults.full()) set.values.push_back(ReadValue(*table, set.tool, faults));
  }
  for (const TomlNode* table : reader.Tables("trend", kMaxRows)) {
    if (!faults.full()) set.trends.push_back(ReadTrend(*table, set, faults));
  }
  for (const TomlNode* table : reader.Tables("remark", kMaxRows)) {
    if (!faults.full()) set.remarks.push_back(ReadRemark(*table, faults));
  }
  reader.Finish();
  if (set.tool.kind == kToolNone && !(set.values.empty() && set.trends.empty())) {
    reader.Fault("tool", "values and trends need a [tool] whose kind is not \"none\"; write remarks instead");
  }
  faults.ThrowIfAny();
  return set;
}

}  // namespace kerf
