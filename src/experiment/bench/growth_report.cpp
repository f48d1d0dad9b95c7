// Output of `kerf bench growth`: a table, a CSV and a figure.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/core/number_text.h"
#include "base/files/files.h"
#include "experiment/bench/growth.h"
#include "view/picture/image.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr Rgb8 kTickColour{0, 90, 160};
constexpr Rgb8 kBoneColour{200, 90, 0};
constexpr Rgb8 kSimulationColour{0, 130, 90};

PlotSeries MakeCurve(const GrowthSeries& series, double GrowthPoint::*figure, const Rgb8& colour) {
  PlotSeries curve;
  curve.colour = colour;
  curve.marker = 9;
  for (const GrowthPoint& point : series.points) {
    curve.x.push_back(point.value);
    curve.y.push_back(point.*figure);
  }
  return curve;
}

/// Returns the line of the limit through the middle of a curve, in the logarithms.
PlotSeries MakeLimit(const PlotSeries& curve, double exponent) {
  PlotSeries line = curve;
  line.label.clear();
  line.marker = 0;
  line.dash = 7;
  double offset = 0;
  for (std::size_t i = 0; i < curve.x.size(); ++i) offset += std::log(curve.y[i]) - exponent * std::log(curve.x[i]);
  offset /= static_cast<double>(curve.x.size());
  for (std::size_t i = 0; i < curve.x.size(); ++i) line.y[i] = std::exp(offset + exponent * std::log(curve.x[i]));
  return line;
}

std::string ShowExponent(const GrowthExponent& exponent) {
  return fmt::format("{:.2f} ({:g})", exponent.measured, exponent.limit);
}

Image RenderSeries(const GrowthSeries& series) {
  PlotSpec spec;
  spec.width = 640;
  spec.height = 420;
  spec.x.label = series.quantity;
  spec.y.label = "tick, p50 (us)";
  spec.y_right.label = "memory (MB)";
  for (PlotAxis* axis : {&spec.x, &spec.y, &spec.y_right}) axis->log = series.is_power;
  PlotSeries tick = MakeCurve(series, &GrowthPoint::tick_p50_us, kTickColour);
  PlotSeries bone = MakeCurve(series, &GrowthPoint::bone_MB, kBoneColour);
  PlotSeries simulation = MakeCurve(series, &GrowthPoint::simulation_MB, kSimulationColour);
  bone.shape = Marker::kSquare;
  simulation.shape = Marker::kDiamond;
  bone.right_axis = simulation.right_axis = true;
  tick.label = "tick";
  bone.label = "bone (right)";
  simulation.label = "simulation (right)";
  if (series.is_power) {
    spec.title = fmt::format("tick {}, bone {}", ShowExponent(series.tick), ShowExponent(series.bone));
    spec.caption = fmt::format("simulation {}; exponents, in brackets their limits (dashed: of tick and bone)",
                               ShowExponent(series.simulation));
    spec.series = {MakeLimit(tick, series.tick.limit), MakeLimit(bone, series.bone.limit)};
  } else {
    spec.title = "with the first effects of the tick";
    spec.y.lower = spec.y_right.lower = 0;
  }
  for (PlotSeries& curve : std::array{tick, bone, simulation}) spec.series.push_back(curve);
  return RenderPlot(spec);
}

TextTable MakeTable(const GrowthReport& report) {
  TextTable table({"quantity", "values", "tick p50 (us)", "exponent (limit)", "bone (MB)", "exponent (limit)",
                   "simulation (MB)", "exponent (limit)", "voxels computed", "samples", "reason for the limits"});
  for (const GrowthSeries& s : report.series) {
    const auto range = [&](double GrowthPoint::*figure) {
      return fmt::format("{} to {}", ShowThree(s.points.front().*figure), ShowThree(s.points.back().*figure));
    };
    const auto exponent = [&](const GrowthExponent& e) {
      if (!s.is_power) return std::string("-");
      return ShowExponent(e) + (e.within() ? "" : " **beyond**");
    };
    table.Add({s.quantity, range(&GrowthPoint::value), range(&GrowthPoint::tick_p50_us), exponent(s.tick),
               range(&GrowthPoint::bone_MB), exponent(s.bone), range(&GrowthPoint::simulation_MB),
               exponent(s.simulation), range(&GrowthPoint::computed_voxels), range(&GrowthPoint::samples), s.why});
  }
  return table;
}

}  // namespace

const Columns<GrowthRow>& GrowthColumns() {
  static const Columns<GrowthRow> kColumns{
      {"quantity", "{}", "what differs between the cuts, with its unit",
       [](const GrowthRow& r) { return TableCell(r.quantity); }},
      {"value", "{:g}", "of the quantity", [](const GrowthRow& r) { return TableCell(r.point.value); }},
      {"tick_p50_us", "{:.3f}", "time of a tick", [](const GrowthRow& r) { return TableCell(r.point.tick_p50_us); }},
      {"tick_p99_us", "{:.3f}", "time of a tick", [](const GrowthRow& r) { return TableCell(r.point.tick_p99_us); }},
      {"bone_MB", "{:.3f}", "memory of the bone before the cut",
       [](const GrowthRow& r) { return TableCell(r.point.bone_MB); }},
      {"simulation_MB", "{:.3f}", "memory of the simulation, of which most is leaves in reserve",
       [](const GrowthRow& r) { return TableCell(r.point.simulation_MB); }},
      {"computed_voxels", "{:.1f}", "voxels that removal computes, per tick",
       [](const GrowthRow& r) { return TableCell(r.point.computed_voxels); }},
      {"samples", "{:.1f}", "samples of the bone by contact, per tick",
       [](const GrowthRow& r) { return TableCell(r.point.samples); }},
      {"bone_hash", "{:016x}", "of the bone after the cut",
       [](const GrowthRow& r) { return TableCell(r.point.hash); }}};
  return kColumns;
}

std::string FormatGrowthTable(const GrowthReport& report) {
  return DescribeRun(report.run) + "\n" + MakeTable(report).FormatTerminal();
}

std::string FormatGrowthMarkdown(const GrowthReport& report) {
  return fmt::format("{}\n{}. {} ticks of each cut.\n", MakeTable(report).FormatMarkdown(), DescribeRun(report.run),
                     report.options.ticks);
}

void WriteGrowth(const GrowthReport& report, const std::string& folder) {
  std::vector<GrowthRow> rows;
  std::vector<Image> panels;
  for (const GrowthSeries& series : report.series) {
    for (const GrowthPoint& point : series.points) rows.push_back({series.quantity, point});
    panels.push_back(RenderSeries(series));
  }
  if (panels.size() % 2 == 1) {
    Image blank = panels.back();
    std::fill(blank.pixels.begin(), blank.pixels.end(), Rgb8{255, 255, 255});
    panels.push_back(std::move(blank));
  }
  Image image;
  for (std::size_t i = 0; i < panels.size(); i += 2) AppendImage(JoinImages(panels[i], panels[i + 1]), image);
  FileBatch results(folder, "growth.csv");
  WriteTextFile(folder + "/growth.csv", FormatCsv(GrowthColumns(), rows));
  WritePng(image, folder + "/growth.png");
  results.Commit();
}

}  // namespace kerf
