#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "experiment/study/figures.h"
#include "experiment/study/knobs.h"

namespace kerf {
namespace {

constexpr Rgb8 kPathColour{196, 202, 210};
constexpr Rgb8 kTheoryColour{60, 64, 72};

/// Returns the geometric mean over the paths at each number that all paths have.
SlopePath CalcMeanCurve(const std::vector<SlopePath>& curves) {
  std::map<double, std::pair<double, std::size_t>> sums;
  for (const SlopePath& curve : curves) {
    for (std::size_t i = 0; i < curve.numbers.size(); ++i) {
      auto& [sum, count] = sums[curve.numbers[i]];
      sum += std::log(curve.errors[i]), ++count;
    }
  }
  SlopePath mean;
  for (const auto& [number, sum] : sums) {
    if (sum.second != curves.size()) continue;
    mean.numbers.push_back(number);
    mean.errors.push_back(std::exp(sum.first / static_cast<double>(sum.second)));
  }
  return mean;
}

std::string DescribeSlope(const std::optional<Slope>& slope) {
  if (!slope) return "none";
  if (!slope->interval) return fmt::format("{:.2f}", slope->slope);
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", slope->slope, slope->interval->first, slope->interval->second);
}

/// Returns the minimum error of all curves at a number; the curves are interpolated linearly in logarithms.
double CalcMinError(const std::vector<SlopePath>& curves, double number) {
  double min_error = std::numeric_limits<double>::infinity();
  for (const SlopePath& curve : curves) {
    for (std::size_t i = 0; i + 1 < curve.numbers.size(); ++i) {
      if (number < curve.numbers[i] || number > curve.numbers[i + 1]) continue;
      const double t = std::log(number / curve.numbers[i]) / std::log(curve.numbers[i + 1] / curve.numbers[i]);
      min_error = std::min(min_error, curve.errors[i] * std::pow(curve.errors[i + 1] / curve.errors[i], t));
    }
  }
  return min_error;
}

/// Adds a right triangle with the theoretical slope, slightly below the curves.
void AddTriangle(PlotSpec& plot, const std::vector<SlopePath>& curves, const SlopePath& mean, double order,
                 double scale) {
  if (order == 0 || mean.numbers.size() < 2) return;
  const double x0 = mean.numbers.front();
  const double x1 = mean.numbers.back();
  // The triangle is towards the coarse end, where the order is visible.
  const double middle = x0 * std::pow(x1 / x0, order > 0 ? 0.6 : 0.4);
  const double half = std::pow(x1 / x0, 0.1);
  const double a = middle / half;
  const double b = middle * half;
  const double rise = std::pow(b / a, std::abs(order));
  const double low_a = CalcMinError(curves, a);
  const double low_b = CalcMinError(curves, b);
  const double bottom = 0.6 * scale * (order > 0 ? std::min(low_a, low_b / rise) : std::min(low_b, low_a / rise));
  if (!std::isfinite(bottom)) return;
  const double top = bottom * rise;
  PlotSeries triangle;
  triangle.colour = kTheoryColour;
  triangle.width = 1.5;
  if (order > 0)
    triangle.x = {a, b, b, a}, triangle.y = {bottom, top, bottom, bottom};
  else
    triangle.x = {a, b, a, a}, triangle.y = {top, bottom, bottom, top};
  plot.series.push_back(std::move(triangle));
  const double beside = order > 0 ? b * std::pow(x1 / x0, 0.015) : a / std::pow(x1 / x0, 0.015);
  plot.notes.push_back({beside, std::sqrt(bottom * top), fmt::format("theory: {:g}", order), kTheoryColour,
                        order > 0 ? Align::kLeft : Align::kRight});
}

const char* DescribeElse(const StudyResults& study) {
  return DescribeBase(study.base).empty() ? "shipped" : "in the study's base";
}

void AddCurves(PlotSpec& plot, const KnobErrors& errors, double scale, const std::string& knob,
               const StudySettings& base) {
  bool first = true;
  for (std::size_t p = 0; p < errors.curves.size(); ++p) {
    PlotSeries path;
    if (first) path.label = "each path";
    first = false;
    path.colour = kPathColour;
    path.width = 1.5;
    path.marker = 5;
    const SlopePath& curve = errors.curves[p];
    const SlopePath& above = errors.above[p];
    for (std::size_t i = 0; i < curve.numbers.size(); ++i) {
      path.x.push_back(curve.numbers[i]), path.y.push_back(scale * curve.errors[i]);
      path.at_most.push_back(std::find(above.numbers.begin(), above.numbers.end(), curve.numbers[i]) ==
                             above.numbers.end());
    }
    plot.series.push_back(std::move(path));
  }
  const SlopePath mean = CalcMeanCurve(errors.curves);
  const MarkerStyle style = StyleOfKnob(knob);
  PlotSeries series;
  series.label = fmt::format("geometric mean of {} paths", errors.curves.size());
  series.colour = style.colour;
  series.shape = style.shape;
  series.width = 2.5;
  series.marker = 10;
  series.x = mean.numbers;
  for (const double error : mean.errors) series.y.push_back(scale * error);
  for (const double number : mean.numbers) {
    // A mean that includes an "at most" value is itself "at most".
    series.at_most.push_back(std::any_of(errors.above.begin(), errors.above.end(), [&](const SlopePath& above) {
      return std::find(above.numbers.begin(), above.numbers.end(), number) == above.numbers.end();
    }));
    series.point_labels.push_back(number == NumberOf(base, knob) ? fmt::format("{:g}, default", number)
                                                                 : fmt::format("{:g}", number));
  }
  plot.series.push_back(std::move(series));
  AddTriangle(plot, errors.curves, mean, errors.order, scale);
  if (mean.numbers.size() < 2) return;
  const double room = std::pow(mean.numbers.back() / mean.numbers.front(), 0.04);
  plot.x.lower = mean.numbers.front() / room, plot.x.upper = mean.numbers.back() * room;
}

StudyFigure MakeConvergence(const StudyResults& study, const KnobErrors& errors, Holding holding) {
  const Knob& knob = FindKnob(errors.knob);
  const bool heat = errors.knob == "heat_grid_mm";
  StudyFigure figure;
  figure.name = fmt::format("convergence_{}_{}", errors.knob, ToString(holding));
  figure.plot = MakeStudyPlot();
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("{}: {}", knob.label, DescribeHolding(holding));
  plot.caption = fmt::format("slope over all values {}; over the coarser half {}", DescribeSlope(errors.slope),
                             DescribeSlope(errors.coarse));
  plot.x.label = knob.label;
  plot.y.label = heat ? "error of the temperature near the kerf, p95 (K)" : "force error, p95 (%)";
  AddCurves(plot, errors, heat ? 1 : 100, errors.knob, study.base);
  if (!heat) AddForceLines(plot, errors.order < 0);
  figure.caption = fmt::format(
      "All else as {}. Slope: least squares in logarithms, with a separate offset for each path; in brackets, the 95 % "
      "interval for other paths (bootstrap over the paths). Errors below that of the reference are excluded. {}",
      DescribeElse(study), knob.theory.empty() ? "Theory predicts no order." : fmt::format("Theory: {}.", knob.theory));
  return figure;
}

/// Makes a diagram of an error other than that of the force as a function of the voxel edge: worst path and median.
std::optional<StudyFigure> MakeVoxelFigure(const StudyResults& study, Holding holding, const std::string& name,
                                           const std::string& what, double scale, double ErrorFigures::*figure_of) {
  KnobErrors errors;
  errors.knob = "voxel_mm";
  errors.order = 0;
  const std::vector<PooledSetting> curve = CurveOf(PoolSettings(study, holding), study.base, "voxel_mm");
  for (const std::string& path : study.paths) {
    SlopePath points;
    for (const PooledSetting& setting : curve) {
      for (const CaseRecord* record : setting.cases) {
        const double value = (*record->errors).*figure_of;
        if (record->path != path || !(value > 0) || !std::isfinite(value)) continue;
        points.numbers.push_back(setting.number), points.errors.push_back(value);
      }
    }
    if (!points.numbers.empty()) errors.curves.push_back(std::move(points));
  }
  if (curve.size() < 2 || errors.curves.empty()) return std::nullopt;
  errors.above = errors.curves;
  errors.slope = FitSlope(errors.curves);
  StudyFigure figure;
  figure.name = fmt::format("{}_{}", name, ToString(holding));
  figure.plot = MakeStudyPlot();
  figure.plot.title =
      fmt::format("{} against voxel size: {}", what.substr(0, what.find(" (")), DescribeHolding(holding));
  figure.plot.title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(figure.plot.title[0])));
  figure.plot.caption = fmt::format("slope {}", DescribeSlope(errors.slope));
  figure.plot.x.label = FindKnob("voxel_mm").label;
  figure.plot.y.label = what;
  AddCurves(figure.plot, errors, scale, "voxel_mm", study.base);
  figure.caption =
      fmt::format("All else as {}. The slope is given with the 95 % interval for other paths.", DescribeElse(study));
  return figure;
}

}  // namespace

std::vector<StudyFigure> MakeKnobFigures(const StudyResults& study, Holding holding) {
  std::vector<StudyFigure> figures;
  for (const std::string& knob : study.knobs) {
    const std::optional<KnobErrors> errors = MakeKnobErrors(study, holding, knob);
    if (errors) figures.push_back(MakeConvergence(study, *errors, holding));
  }
  const auto add = [&](std::optional<StudyFigure> figure) {
    if (figure) figures.push_back(std::move(*figure));
  };
  add(MakeVoxelFigure(study, holding, "volume", "error of the removed volume (%)", 100, &ErrorFigures::volume));
  add(MakeVoxelFigure(study, holding, "surface", "mean distance between the cut surfaces (mm)", 1,
                      &ErrorFigures::surface_mean_mm));
  return figures;
}

}  // namespace kerf
