// The figures of a comparison with measurements.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "experiment/validation/validation_files.h"

namespace kerf {
namespace {

// Okabe and Ito's palette, whose colours colour-blind people can distinguish.
constexpr std::array<Rgb8, 6> kLawColours{
    {{0, 114, 178}, {230, 159, 0}, {0, 158, 115}, {204, 121, 167}, {86, 180, 233}, {213, 94, 0}}};
constexpr std::array<Rgb8, 4> kSetColours{{{33, 37, 43}, {130, 60, 40}, {90, 95, 105}, {60, 90, 50}}};
constexpr std::array<Marker, 4> kSetMarkers{Marker::kDisc, Marker::kSquare, Marker::kDiamond, Marker::kTriangleUp};
constexpr int kCurvePoints = 60;
constexpr std::size_t kSeriesPerSet = 2;  // bars and marks
constexpr double kBeside = 0.04;          // distance of neighbouring sets, as a fraction of x
/// If the largest value exceeds the smallest one by this factor, the axis is logarithmic.
constexpr double kLinearRatio = 8;

/// Measured values of one set that share a figure.
struct SetPoints {
  std::size_t set = 0;
  std::vector<const MeasuredValue*> values;
};

struct FigureData {
  std::string quantity;
  std::string against;  // condition on the x axis
  std::vector<SetPoints> sets;
};

double ConditionAt(const MeasuredSet& set, const MeasuredValue& value, const std::string& against) {
  MeasuredConditions at = JoinConditions(value.at, set.conditions);
  return ConditionOf(at, against);
}

double LowOf(const MeasuredValue& v) {
  return IsGiven(v.low) ? v.low : IsGiven(v.sd) ? v.value - v.sd : v.value;
}
double HighOf(const MeasuredValue& v) {
  return IsGiven(v.high) ? v.high : IsGiven(v.sd) ? v.value + v.sd : v.value;
}

/// Returns the values of a set that have this quantity, are of cortical bone and have all conditions of a simulation.
SetPoints FindPoints(const Validation& v, std::size_t set, std::string_view quantity, const std::string& against) {
  SetPoints points{set, {}};
  for (const MeasuredValue& value : v.sets[set].values) {
    if (value.quantity != quantity || value.material != "cortical") continue;
    if (IsGiven(ConditionAt(v.sets[set], value, against))) points.values.push_back(&value);
  }
  return points;
}

PlotSeries MakeErrorBars(const Validation& v, const FigureData& data, std::size_t i, double half_cap,
                         std::vector<double>& extent) {
  const SetPoints& points = data.sets[i];
  const MeasuredSet& set = v.sets[points.set];
  PlotSeries bars;
  bars.colour = kSetColours[i % kSetColours.size()];
  for (const MeasuredValue* value : points.values) {
    // Sets at the same place are drawn side by side.
    const double x = ConditionAt(set, *value, data.against) * (1 + kBeside * static_cast<double>(i));
    const double left = x * (1 - half_cap);
    const double right = x * (1 + half_cap);
    const double low = LowOf(*value);
    const double high = HighOf(*value);
    for (const auto& [px, py] : {std::pair{left, low},
                                 {right, low},
                                 {x, low},
                                 {x, high},
                                 {left, high},
                                 {right, high},
                                 {kNotGiven, kNotGiven}}) {
      bars.x.push_back(px);
      bars.y.push_back(py);
    }
    extent.push_back(low);
    extent.push_back(high);
  }
  return bars;
}

PlotSeries MakeMeans(const Validation& v, const FigureData& data, std::size_t i) {
  const SetPoints& points = data.sets[i];
  const MeasuredSet& set = v.sets[points.set];
  PlotSeries means;
  means.label = "measured: " + set.name;
  means.colour = kSetColours[i % kSetColours.size()];
  means.shape = kSetMarkers[i % kSetMarkers.size()];
  means.width = 0;
  means.marker = 10;
  for (const MeasuredValue* value : points.values) {
    means.x.push_back(ConditionAt(set, *value, data.against) * (1 + kBeside * static_cast<double>(i)));
    means.y.push_back(IsGiven(value->value) ? value->value : 0.5 * (value->low + value->high));
  }
  return means;
}

/// Returns the law's values over the range of the x axis.
PlotSeries MakeCurve(const Validation& v, const FigureData& data, std::size_t law, double from, double to, bool log) {
  const MeasuredSet& set = v.sets[data.sets.front().set];
  PlotSeries curve;
  curve.label = v.names[law];
  curve.colour = kLawColours[law % kLawColours.size()];
  curve.width = 3;
  for (int i = 0; i <= kCurvePoints; ++i) {
    const double t = static_cast<double>(i) / kCurvePoints;
    MeasuredConditions at = data.sets.front().values.front()->at;
    const double x = log ? from * std::pow(to / from, t) : from + t * (to - from);
    ConditionOf(at, data.against) = x;
    const Simulated simulated = SimulateQuantity(v.laws[law], set, data.quantity, at);
    if (!simulated.why.empty()) return {};
    if (simulated.assumed_ratio && i == 0) curve.dash = 8;
    curve.x.push_back(x);
    curve.y.push_back(simulated.value);
  }
  return curve;
}

std::string AxisLabel(const std::string& against) {
  if (against == "bite_um") return "bite (um)";
  if (against == "rpm") return "speed (rpm)";
  return against;
}

/// Sets the range of the x axis to that of the measured values, with a margin.
void SetXRange(const Validation& v, const FigureData& data, PlotAxis& x) {
  double from = std::numeric_limits<double>::infinity();
  double to = 0;
  for (const SetPoints& points : data.sets) {
    for (const MeasuredValue* value : points.values) {
      from = std::min(from, ConditionAt(v.sets[points.set], *value, data.against));
      to = std::max(to, ConditionAt(v.sets[points.set], *value, data.against));
    }
  }
  x.log = data.against == "bite_um";
  const double margin = x.log ? 1.35 : 1.08;
  x.lower = from / margin;
  x.upper = to * margin;
}

/// Sets the range of the y axis. `values`: all values in the figure.
void SetYRange(const std::vector<double>& values, PlotAxis& y) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  y.log = *low > 0 && *high > kLinearRatio * *low;
  y.lower = y.log ? *low / 1.5 : std::min(0.0, *low);
  y.upper = *high * (y.log ? 1.5 : 1.15);
}

/// Returns which sets of a figure were used to calibrate which of the laws; empty if none.
std::string DescribeCalibrations(const Validation& v, const FigureData& data) {
  std::vector<std::pair<std::string, std::string>> groups;  // laws, and the sets with which all of them were calibrated
  for (const SetPoints& points : data.sets) {
    std::vector<std::string_view> names;
    for (std::size_t law = 0; law < v.laws.size(); ++law) {
      if (IsCalibrated(v.sets[points.set], v.laws[law])) names.emplace_back(v.names[law]);
    }
    if (names.empty()) continue;
    const std::string laws = fmt::format("{}", fmt::join(names, ", "));
    const std::string& set = v.sets[points.set].name;
    const auto same = std::ranges::find(groups, laws, &std::pair<std::string, std::string>::first);
    if (same == groups.end()) {
      groups.emplace_back(laws, set);
    } else {
      same->second += ", " + set;
    }
  }
  std::string text;
  for (const auto& [laws, sets] : groups)
    text += fmt::format("{}calibrated with {}: {}", text.empty() ? "" : "; ", sets, laws);
  return text;
}

/// Returns a figure with a curve for each law that has the quantity. The curves are those of the first set's tool.
ValidationFigure MakeFigure(const Validation& v, const FigureData& data, std::string name, const std::string& title) {
  const MeasuredQuantity& quantity = FindQuantity(data.quantity);
  ValidationFigure figure;
  figure.name = std::move(name);
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("{}: {}", title, quantity.label.substr(0, quantity.label.rfind(" (")));
  plot.x.label = AxisLabel(data.against);
  plot.y.label = std::string(quantity.label);
  SetXRange(v, data, plot.x);
  std::vector<double> values;
  for (std::size_t law = 0; law < v.laws.size(); ++law) {
    PlotSeries curve = MakeCurve(v, data, law, *plot.x.lower, *plot.x.upper, plot.x.log);
    if (curve.x.empty()) continue;
    values.insert(values.end(), curve.y.begin(), curve.y.end());
    plot.series.push_back(std::move(curve));
  }
  for (std::size_t i = 0; i < data.sets.size(); ++i) {
    plot.series.push_back(MakeErrorBars(v, data, i, plot.x.log ? 0.015 : 0.006, values));
    plot.series.push_back(MakeMeans(v, data, i));
  }
  SetYRange(values, plot.y);
  plot.caption = "bars: mean +- standard deviation, or a measured range with a mark in its middle";
  const bool dashed =
      std::any_of(plot.series.begin(), plot.series.end(), [](const PlotSeries& s) { return s.dash > 0; });
  if (dashed) plot.caption += "; dashed: cutting force assumed as thrust / 1.6";
  const std::string calibrations = DescribeCalibrations(v, data);
  if (!calibrations.empty()) plot.caption += "\n" + calibrations;
  figure.caption = fmt::format("{}: {} against {}. Bars are measured ranges, or means with standard deviations.", title,
                               quantity.label, AxisLabel(data.against));
  return figure;
}

/// Returns the values of teeth of each width, in um.
std::map<int, FigureData> FindTeeth(const Validation& v, std::string_view quantity) {
  std::map<int, FigureData> by_width;
  for (std::size_t set = 0; set < v.sets.size(); ++set) {
    const MeasuredTool& tool = v.sets[set].tool;
    if (tool.kind != kToolTooth) continue;
    SetPoints points = FindPoints(v, set, quantity, "bite_um");
    if (points.values.empty()) continue;
    FigureData& data = by_width[static_cast<int>(std::lround(1000 * tool.width_mm))];
    data.quantity = quantity;
    data.against = "bite_um";
    data.sets.push_back(std::move(points));
  }
  return by_width;
}

}  // namespace

std::vector<ValidationFigure> MakeValidationFigures(const Validation& v) {
  std::vector<ValidationFigure> figures;
  const auto add = [&](const FigureData& data, const std::string& prefix, const std::string& title) {
    ValidationFigure figure = MakeFigure(v, data, prefix + "_" + data.quantity, title);
    if (figure.plot.series.size() > kSeriesPerSet * data.sets.size()) figures.push_back(std::move(figure));
  };
  for (const MeasuredQuantity& quantity : MeasuredQuantities()) {
    for (const auto& [width_um, data] : FindTeeth(v, quantity.name)) {
      add(data, fmt::format("tooth_{}um", width_um), fmt::format("A saw tooth {:g} mm wide", 1e-3 * width_um));
    }
  }
  for (std::size_t set = 0; set < v.sets.size(); ++set) {
    const MeasuredSet& s = v.sets[set];
    if (s.tool.kind != kToolDrill || !IsGiven(s.conditions.feed_mm_per_min)) continue;
    for (const MeasuredQuantity& quantity : MeasuredQuantities()) {
      SetPoints points = FindPoints(v, set, quantity.name, "rpm");
      if (!points.values.empty()) add({std::string(quantity.name), "rpm", {std::move(points)}}, s.name, s.title);
    }
  }
  return figures;
}

}  // namespace kerf
