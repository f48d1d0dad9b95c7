#include "experiment/study/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/core/number_text.h"
#include "base/files/markdown_text.h"
#include "cut/force/measured.h"
#include "experiment/study/knobs.h"
#include "experiment/study/pareto.h"
#include "experiment/study/study_words.h"

namespace kerf {
namespace {

constexpr Rgb8 kFrontColour{188, 196, 206};
constexpr Rgb8 kDefaultColour{20, 22, 26};
constexpr Rgb8 kLineColour{85, 92, 102};
constexpr double kMarkerSize = 9;

/// Determines which figures of a setting a diagram shows.
enum class Kind { kWorst, kTypical };

double TimeOf(const PooledSetting& setting, Kind kind) {
  return kind == Kind::kWorst ? setting.p99_us : setting.p50_us;
}

const SafeError& ErrorOf(const PooledSetting& setting, Kind kind) {
  return kind == Kind::kWorst ? setting.worst : setting.median;
}

bool IsDrawn(const PooledSetting& setting, Kind kind) {
  return setting.timed && TimeOf(setting, kind) > 0 && ErrorOf(setting, kind).value > 0;
}

void AddPoint(PlotSeries& series, const PooledSetting& setting, Kind kind, const std::string& label) {
  series.x.push_back(TimeOf(setting, kind));
  series.y.push_back(100 * ErrorOf(setting, kind).value);
  series.at_most.push_back(ErrorOf(setting, kind).at_most);
  series.point_labels.push_back(label);
}

// Sets axis ranges that contain all points and the lines of time and force.
void SetRanges(PlotSpec& plot) {
  double lower_us = 250;
  double upper_us = 1000;
  double lower = 3.5;
  double upper = 7;
  for (const PlotSeries& series : plot.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      lower_us = std::min(lower_us, series.x[i]), upper_us = std::max(upper_us, series.x[i]);
      lower = std::min(lower, series.y[i]), upper = std::max(upper, series.y[i]);
    }
  }
  plot.x.lower = lower_us / 1.35, plot.x.upper = upper_us * 1.35;
  // The upper limit leaves room for the labels of the time lines above all points.
  plot.y.lower = lower / 1.5, plot.y.upper = upper * std::pow(upper / lower, 0.12) * 1.3;
}

// Adds the Pareto front as a staircase, which is drawn beneath everything else.
void AddFront(PlotSpec& plot, const std::vector<PooledSetting>& settings, Kind kind) {
  std::vector<const PooledSetting*> ranked;
  std::vector<CostAndError> points;
  for (const PooledSetting& setting : settings) {
    if (!setting.ranked || !IsDrawn(setting, kind)) continue;
    ranked.push_back(&setting);
    points.push_back({TimeOf(setting, kind), 100 * ErrorOf(setting, kind).value});
  }
  const std::vector<std::size_t> front = FindParetoFront(points);
  if (front.empty()) return;
  PlotSeries series;
  series.label = "Pareto front";
  series.colour = kFrontColour;
  series.width = 5;
  double last = *plot.y.upper;
  for (const std::size_t i : front) {
    series.x.push_back(points[i].cost), series.y.push_back(last);
    series.x.push_back(points[i].cost), series.y.push_back(points[i].error);
    last = points[i].error;
  }
  series.x.push_back(*plot.x.upper), series.y.push_back(last);
  plot.series.insert(plot.series.begin(), std::move(series));
}

void AddTimeLines(PlotSpec& plot) {
  for (const double us : {250.0, 500.0, 1000.0}) {
    plot.lines.push_back({true, us, fmt::format("{:g} ms", us / 1000)});
  }
}

PlotSeries MakeKnobSeries(const std::string& knob) {
  PlotSeries series;
  const MarkerStyle style = StyleOfKnob(knob);
  series.label = FindKnob(knob).label;
  series.colour = style.colour;
  series.shape = style.shape;
  series.marker = kMarkerSize;
  series.width = FindKnob(knob).numeric ? 2 : 0;
  return series;
}

std::string LabelOf(const PooledSetting& setting, std::size_t paths) {
  if (setting.is_default) return "";
  if (setting.complete) return setting.value;
  return fmt::format("{} ({} of {} paths)", setting.value, setting.paths, paths);
}

void AddKnobs(PlotSpec& plot, const StudyResults& study, const std::vector<PooledSetting>& settings,
              const std::vector<std::string>& knobs, Kind kind) {
  const PooledSetting* defaults = nullptr;
  for (const PooledSetting& setting : settings) {
    if (setting.is_default) defaults = &setting;
  }
  for (const std::string& knob : knobs) {
    PlotSeries series = MakeKnobSeries(knob);
    bool any = false;
    const std::vector<PooledSetting> curve = CurveOf(settings, study.base, knob);
    const bool on_all_paths =
        std::all_of(curve.begin(), curve.end(), [](const PooledSetting& s) { return s.is_default || s.complete; });
    for (const PooledSetting& setting : curve) {
      if (!IsDrawn(setting, kind)) continue;
      // The defaults are not joined to the curve of a non-numeric knob, or to a curve with settings that have results
      // on fewer paths than the defaults.
      if (setting.is_default && !(FindKnob(knob).numeric && on_all_paths)) continue;
      AddPoint(series, setting, kind, LabelOf(setting, defaults != nullptr ? defaults->paths : setting.paths));
      any = any || !setting.is_default;
    }
    if (any) plot.series.push_back(std::move(series));
  }
  if (defaults == nullptr || !IsDrawn(*defaults, kind)) return;
  PlotSeries star;
  star.label = DescribeBase(study.base).empty() ? "shipped defaults" : "base settings";
  star.colour = kDefaultColour;
  star.shape = Marker::kStar;
  star.marker = 17;
  star.width = 0;
  AddPoint(star, *defaults, kind, "defaults");
  plot.series.push_back(std::move(star));
}

std::string DescribeReading(const StudyResults& study, const std::vector<PooledSetting>& settings) {
  std::string text = fmt::format(
      "Down and to the left is better; a label is the knob's value, and all else is as {}. Times are per millisecond "
      "of simulated time. A hollow mark with an arrow means that the error is at most that of the reference. {}",
      DescribeBase(study.base).empty() ? "shipped" : "in the study's base",
      WasBusy(study.machine)
          ? "There is no Pareto front, because the machine was busy before the run."
          : "The Pareto front contains only settings that were run on every path, without choices of physics (law, "
            "material).");
  std::string incomplete;
  for (const PooledSetting& setting : settings) {
    if (setting.complete) continue;
    incomplete += fmt::format("{}{} ({})", incomplete.empty() ? "" : ", ", setting.Name(), setting.paths);
  }
  if (!incomplete.empty()) text += " Run on fewer paths and shown for those only: " + incomplete + ".";
  return text;
}

// Makes a view of the surroundings of the defaults: points far to the left are cut off to give more room to the others.
StudyFigure MakeNear(StudyFigure figure, const PooledSetting& defaults, Holding holding) {
  figure.name = fmt::format("near_{}", ToString(holding));
  figure.caption =
      "Detail of the previous diagram near the defaults; settings that are more than four times as fast, or whose "
      "error is "
      "more than twelve times larger or smaller, are not shown.";
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("What accuracy costs in time, near the defaults: {}", DescribeHolding(holding));
  plot.x.lower = std::max(*plot.x.lower, defaults.p99_us / 4);
  plot.y.lower = std::max(*plot.y.lower, 100 * defaults.worst.value / 12);
  plot.y.upper = std::min(*plot.y.upper, 100 * defaults.worst.value * 12);
  return figure;
}

StudyFigure MakeWorkPrecision(const StudyResults& study, Holding holding, Kind kind) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding);
  const std::size_t paths = settings.empty() ? 0 : settings.front().paths;
  StudyFigure figure;
  const bool worst = kind == Kind::kWorst;
  figure.name = fmt::format("{}_{}", worst ? "work_precision" : "typical", ToString(holding));
  figure.plot = MakeStudyPlot();
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("What accuracy costs in time: {}", DescribeHolding(holding));
  plot.caption = worst ? fmt::format("the slowest of {} paths, and the one with the largest error", paths)
                       : fmt::format("medians over {} paths", paths);
  const ForceLaw law(study.base.law);
  const auto factor = [&](std::size_t i) {
    return ShowThree(CalcThrustFactor(law, DiscSaw{}, kMeasuredThrust.at(i).bite_mm));
  };
  plot.caption += fmt::format(
      "\nErrors of the numerics only: the thrust of {} is {} times the measured one at a bite of 2.5 um, {} times at "
      "10 um",
      law.name(), factor(0), factor(1));
  plot.x.label = fmt::format("time per millisecond simulated, {} (\xc2\xb5s)",
                             worst ? "p99 on the slowest path" : "p50, median path");
  plot.y.label = fmt::format("force error, p95, {} path (%)", worst ? "worst" : "median");
  AddKnobs(plot, study, settings, study.knobs, kind);
  SetRanges(plot);
  AddFront(plot, settings, kind);
  AddTimeLines(plot);
  AddForceLines(plot, true);
  figure.caption =
      worst
          ? "Each point shows the p99 of the slowest path and the force error (p95 over the ticks) of the worst path. "
          : "The same for a typical tick of a typical path: medians of p50 and of the force error. ";
  figure.caption += worst ? DescribeReading(study, settings) : "Read as above.";
  return figure;
}

StudyFigure MakeWorstPose(const StudyResults& study, Holding holding) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding, {kWorstPath});
  StudyFigure figure;
  figure.name = fmt::format("worst_pose_{}", ToString(holding));
  figure.plot = MakeStudyPlot();
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("The worst-case pose by itself: {}", DescribeHolding(holding));
  plot.caption = study.path_titles.contains(kWorstPath) ? EscapeMarkdown(study.path_titles.at(kWorstPath)) : "";
  plot.x.label = "time per millisecond simulated, p99 (\xc2\xb5s)";
  plot.y.label = "force error, p95 (%)";
  AddKnobs(plot, study, settings, study.knobs, Kind::kWorst);
  SetRanges(plot);
  AddFront(plot, settings, Kind::kWorst);
  AddTimeLines(plot);
  AddForceLines(plot, true);
  figure.caption = fmt::format("The path `{}` alone; read as above.", kWorstPath);
  return figure;
}

StudyFigure MakeSlabVoxel(const StudyResults& study, Holding holding, const std::vector<std::string>& paths) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding, paths);
  StudyFigure figure;
  figure.name = fmt::format("slab_voxel_{}", ToString(holding));
  figure.plot = MakeStudyPlot();
  PlotSpec& plot = figure.plot;
  plot.title = fmt::format("Voxels against the slab: {}", DescribeHolding(holding));
  plot.caption = fmt::format("the {} paths that the slab can run; small marks: each path", paths.size());
  plot.x.label = "time per millisecond simulated, p99 on the slowest path (\xc2\xb5s)";
  plot.y.label = "force error, p95, worst path (%)";
  std::vector<PlotSeries> clouds;
  for (const PooledSetting& setting : settings) {
    const bool shown = setting.is_default || setting.knob == "method";
    if (!shown || !setting.timed) continue;
    PlotSeries cloud;
    const MarkerStyle style = StyleOfKnob("method");
    cloud.colour = setting.is_default        ? Rgb8{120, 124, 130}
                   : setting.value == "slab" ? Rgb8{240, 165, 110}
                                             : Rgb8{150, 190, 160};
    cloud.shape = setting.is_default ? Marker::kStar : style.shape;
    cloud.marker = setting.is_default ? 8 : 5;
    cloud.width = 0;
    for (const CaseRecord* record : setting.cases) {
      const SafeError error = CalcForceError(study, *record);
      if (!(error.value > 0)) continue;
      cloud.x.push_back(record->costs->tick.p99_us), cloud.y.push_back(100 * error.value);
      cloud.at_most.push_back(error.at_most);
    }
    clouds.push_back(std::move(cloud));
  }
  AddKnobs(plot, study, settings, {"voxel_mm", "method"}, Kind::kWorst);
  plot.series.insert(plot.series.begin(), clouds.begin(), clouds.end());
  SetRanges(plot);
  AddTimeLines(plot);
  AddForceLines(plot, true);
  figure.caption =
      "Time that the slab saves, and its error, compared with voxels of each size, over the paths that both can run: " +
      fmt::format("{}. Large marks: the slowest and the worst path.", fmt::join(paths, ", "));
  return figure;
}

}  // namespace

PlotSpec MakeStudyPlot() {
  PlotSpec plot;
  plot.width = 1600;
  plot.height = 1130;
  plot.text_scale = 0.85;
  plot.x.log = plot.y.log = true;
  return plot;
}

MarkerStyle StyleOfKnob(const std::string& knob) {
  // Okabe and Ito's colours and a few more, each with a different marker.
  static const std::map<std::string, MarkerStyle> styles = {
      {"voxel_mm", {Marker::kDisc, kMarkerSize, {0, 114, 178}}},
      {"rim_samples_per_pitch", {Marker::kSquare, kMarkerSize, {213, 94, 0}}},
      {"substeps", {Marker::kDiamond, kMarkerSize, {0, 158, 115}}},
      {"rate_hz", {Marker::kTriangleUp, kMarkerSize, {204, 121, 167}}},
      {"carve_interval_ticks", {Marker::kTriangleDown, kMarkerSize, {190, 130, 0}}},
      {"law", {Marker::kCross, kMarkerSize, {110, 110, 110}}},
      {"material", {Marker::kPlus, kMarkerSize, {110, 110, 110}}},
      {"precision_bits", {Marker::kTriangleUp, kMarkerSize, {60, 160, 220}}},
      {"method", {Marker::kSquare, kMarkerSize, {33, 37, 43}}},
      {"heat_grid_mm", {Marker::kTriangleDown, kMarkerSize, {150, 50, 50}}},
      {"band_voxels", {Marker::kDiamond, kMarkerSize, {120, 90, 180}}}};
  const auto found = styles.find(knob);
  return found != styles.end() ? found->second : MarkerStyle{};
}

std::string DescribeHolding(Holding holding) {
  return holding == Holding::kHand ? "tool coupled to a handle" : "tool on a prescribed path";
}

void AddForceLines(PlotSpec& plot, bool at_start) {
  plot.lines.push_back(
      {false, 100 * kTargetForce, fmt::format("{:g} %: half a JND", 100 * kTargetForce), kLineColour, 6, at_start});
  plot.lines.push_back(
      {false, 100 * kForceJnd, fmt::format("{:g} %: one JND", 100 * kForceJnd), kLineColour, 6, at_start});
}

std::vector<StudyFigure> MakeStudyFigures(const StudyResults& study) {
  std::vector<StudyFigure> figures;
  const auto add = [&](StudyFigure figure) {
    if (std::any_of(figure.plot.series.begin(), figure.plot.series.end(),
                    [](const PlotSeries& s) { return !s.x.empty(); }))
      figures.push_back(std::move(figure));
  };
  for (const Holding holding : HoldingsOf(study)) {
    const StudyFigure whole = MakeWorkPrecision(study, holding, Kind::kWorst);
    add(whole);
    const std::vector<PooledSetting> settings = PoolSettings(study, holding);
    if (!settings.empty() && settings[0].is_default && IsDrawn(settings[0], Kind::kWorst)) {
      add(MakeNear(whole, settings[0], holding));
    }
    add(MakeWorkPrecision(study, holding, Kind::kTypical));
    add(MakeWorstPose(study, holding));
    const std::vector<std::string> slab = PathsOfSlab(study, holding);
    if (!slab.empty()) add(MakeSlabVoxel(study, holding, slab));
    for (StudyFigure& figure : MakeKnobFigures(study, holding)) add(std::move(figure));
  }
  return figures;
}

}  // namespace kerf
