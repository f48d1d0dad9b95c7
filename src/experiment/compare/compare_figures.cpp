// The figures of a comparison.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "experiment/compare/compare_files.h"
#include "experiment/compare/conclusion.h"

namespace kerf {
namespace {

// Okabe and Ito's palette, whose colours colour-blind people can distinguish, without those of the slabs.
constexpr std::array<Rgb8, 6> kColours{
    {{33, 37, 43}, {0, 114, 178}, {204, 121, 167}, {86, 180, 233}, {230, 159, 0}, {140, 140, 140}}};
constexpr Rgb8 kSlabAsComputed{213, 94, 0};
constexpr Rgb8 kSlabCorrected{0, 158, 115};
constexpr std::array<Rgb8, 6> kBandColours{
    {{252, 232, 205}, {219, 234, 245}, {222, 240, 226}, {240, 226, 238}, {250, 244, 205}, {228, 228, 228}}};
/// Bands shorter than this fraction of the axis are merged with the previous band.
constexpr double kShortestBandFraction = 0.012;
/// If the ratio of the forces exceeds this, the axis is logarithmic.
constexpr double kLinearRatio = 10;

Rgb8 ColourOf(const Comparison& c, std::size_t k) {
  const CompareCase& what = c.cases[k].what;
  if (what.slab) return what.reading == PaperReading::kAsComputed ? kSlabAsComputed : kSlabCorrected;
  return kColours[k % kColours.size()];
}

/// Returns the depth ranges, each in one region, labelled with the region's number and, if there is room, its name.
std::vector<PlotBand> MakeBands(const Comparison& c) {
  std::vector<PlotBand> bands;
  std::map<int, std::size_t> order;
  const double whole_mm = c.grid.step_mm * static_cast<double>(c.grid.count);
  std::vector<int> ids;
  for (const std::size_t i : c.slice_bins) {
    const double top = c.grid.Centre(i) - 0.5 * c.grid.step_mm;
    const int id = c.region_of_bin[i];
    if (bands.empty() || ids.back() != id) {
      const bool short_one = !bands.empty() && bands.back().x1 - bands.back().x0 < kShortestBandFraction * whole_mm;
      if (short_one) {
        bands.pop_back(), ids.pop_back();
      }
      if (bands.empty() || ids.back() != id) {
        const double from = bands.empty() ? top : bands.back().x1;
        ids.push_back(id);
        bands.push_back({from, top, "", {}});
      }
    }
    bands.back().x1 = top + c.grid.step_mm;
  }
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const std::size_t colour = order.emplace(ids[b], order.size()).first->second;
    bands[b].colour = ids[b] == 0 ? Rgb8{255, 255, 255} : kBandColours[colour % kBandColours.size()];
    const double fraction = (bands[b].x1 - bands[b].x0) / whole_mm;
    const auto region =
        std::find_if(c.regions.begin(), c.regions.end(), [&](const CompareRegion& r) { return r.id == ids[b]; });
    std::string named = ids[b] == 0 ? std::string("no bone") : fmt::format("{} {}", ids[b], region->name);
    if (ids[b] != 0 && region->name == fmt::format("region {}", ids[b])) named = region->name;
    if (fraction < 0.009 * static_cast<double>(named.size())) {
      named = ids[b] == 0 || fraction < 0.025 ? std::string() : fmt::format("{}", ids[b]);
    }
    bands[b].label = named;
  }
  return bands;
}

PlotSeries MakeSeries(const Comparison& c, std::size_t k) {
  PlotSeries series;
  series.label = c.cases[k].what.label;
  series.colour = ColourOf(c, k);
  series.width = k == 0 ? 3 : 2;
  if (k >= 3) series.dash = 3 * static_cast<double>(k);  // so that they differ in grey as well
  for (std::size_t i = 0; i < c.grid.count; ++i) series.x.push_back(c.grid.Centre(i));
  return series;
}

PlotSpec MakeDepthPlot(const Comparison& c, const std::string& what) {
  PlotSpec plot;
  plot.title = fmt::format("{}: {}", c.title.empty() ? c.scene : c.title, what);
  plot.x.label = "depth of the leading rim below the first bone, along the cut (mm)";
  plot.x.lower = 0;
  plot.x.upper = c.grid.step_mm * static_cast<double>(c.grid.count);
  plot.bands = MakeBands(c);
  return plot;
}

}  // namespace

PlotSpec MakeForceDepthPlot(const Comparison& c) {
  PlotSpec plot = MakeDepthPlot(c, "force against depth");
  double lowest_N = std::numeric_limits<double>::infinity();
  double highest_N = 0;
  for (std::size_t k = 0; k < c.cases.size(); ++k) {
    PlotSeries series = MakeSeries(c, k);
    series.y = c.cases[k].curve.force_N;
    plot.series.push_back(std::move(series));
    if (c.cases[k].slice.mean_N > 0) {
      lowest_N = std::min(lowest_N, c.cases[k].slice.mean_N);
      highest_N = std::max(highest_N, c.cases[k].slice.mean_N);
    }
  }
  plot.y.label = "force on the tool against the cut (N)";
  plot.caption = fmt::format("{:g} mm/s, {:g} rpm; each point the mean over {:g} mm of depth", c.feed_mm_per_s, c.rpm,
                             c.grid.step_mm);
  if (highest_N > kLinearRatio * lowest_N) {
    plot.y.log = true;
    plot.y.lower = std::pow(10, std::floor(std::log10(lowest_N / 5)));
    double peak_N = 0;
    for (const CaseResult& result : c.cases) peak_N = std::max(peak_N, result.peak_N);
    // This leaves room for the regions' names above the curves.
    plot.y.upper = *plot.y.lower * std::pow(peak_N / *plot.y.lower, 1.18);
    plot.caption += "; logarithmic";
  } else {
    plot.y.lower = 0;
  }
  return plot;
}

PlotSpec MakeDifferencePlot(const Comparison& c) {
  PlotSpec plot = MakeDepthPlot(c, "force difference");
  for (std::size_t k = 1; k < c.cases.size(); ++k) {
    PlotSeries series = MakeSeries(c, k);
    for (std::size_t i = 0; i < c.grid.count; ++i) {
      series.y.push_back(c.cases[k].curve.force_N[i] - c.reference().curve.force_N[i]);
    }
    series.label = fmt::format("{} (rms {} N)", series.label, ShowFigure(c.cases[k].slice.rms_N));
    plot.series.push_back(std::move(series));
  }
  PlotSeries zero;
  zero.x = {0, c.grid.step_mm * static_cast<double>(c.grid.count)};
  zero.y = {0, 0};
  zero.colour = ColourOf(c, 0);
  zero.width = 1.5;
  zero.dash = 6;
  plot.series.push_back(std::move(zero));
  plot.y.label = "force minus reference force (N)";
  plot.caption = fmt::format("reference: {}; dashed: no difference", c.reference().what.label);
  return plot;
}

PlotSpec MakeCostPlot(const Comparison& c) {
  PlotSpec plot;
  plot.title = fmt::format("{}: time per tick and force difference", c.title.empty() ? c.scene : c.title);
  plot.caption = "dot: median (p50); line: to the 99th percentile; the reference's difference is 0";
  plot.x.label = "time per tick (us)";
  plot.x.log = true;
  plot.y.label = fmt::format("rms force difference from {} (N)", c.reference().what.label);
  double max_N = 0;
  double fastest_us = std::numeric_limits<double>::infinity();
  double slowest_us = 1e6 / c.rate_hz;
  for (const CaseResult& result : c.cases) {
    max_N = std::max(max_N, result.slice.rms_N);
    fastest_us = std::min(fastest_us, std::max(result.times.p50_us, 1e-3));
    slowest_us = std::max(slowest_us, result.times.p99_us);
  }
  if (!(max_N > 0)) max_N = 1;
  plot.x.lower = fastest_us / 2;
  plot.x.upper = slowest_us * 4;
  plot.y.lower = -0.08 * max_N;
  plot.y.upper = 1.2 * max_N;
  PlotSeries deadline;
  deadline.x = {1e6 / c.rate_hz, 1e6 / c.rate_hz};
  deadline.y = {*plot.y.lower, *plot.y.upper};
  deadline.colour = Rgb8{170, 60, 60};
  deadline.width = 1.5;
  deadline.dash = 6;
  plot.series.push_back(std::move(deadline));
  plot.notes.push_back({1e6 / c.rate_hz, 1.12 * max_N, fmt::format(" {:g} Hz", c.rate_hz), Rgb8{170, 60, 60}});
  // Labels of cases that are close to each other are stacked.
  std::vector<std::pair<bool, double>> taken_N;  // whether a label is in the right half, and its height
  for (std::size_t k = 0; k < c.cases.size(); ++k) {
    const CaseResult& result = c.cases[k];
    PlotSeries line;
    line.colour = ColourOf(c, k);
    line.x = {result.times.p50_us, result.times.p99_us};
    line.y = {result.slice.rms_N, result.slice.rms_N};
    line.width = 3;
    plot.series.push_back(line);
    PlotSeries dot = line;
    dot.x = {result.times.p50_us};
    dot.y = {result.slice.rms_N};
    dot.marker = 15;
    plot.series.push_back(dot);
    const bool right_half =
        std::log(result.times.p50_us / *plot.x.lower) > 0.5 * std::log(*plot.x.upper / *plot.x.lower);
    double at_N = result.slice.rms_N + 0.055 * max_N;
    const auto crowded = [&] {
      return std::any_of(taken_N.begin(), taken_N.end(), [&](const std::pair<bool, double>& other) {
        return other.first == right_half && std::abs(other.second - at_N) < 0.055 * max_N;
      });
    };
    while (crowded()) at_N += 0.02 * max_N;
    taken_N.emplace_back(right_half, at_N);
    plot.notes.push_back({result.times.p50_us, at_N,
                          fmt::format("{}: {}, {}", result.what.label, ShowTime(result.times.p50_us),
                                      ShowMemory(static_cast<double>(result.memory_bytes))),
                          ColourOf(c, k), right_half ? Align::kRight : Align::kLeft, true});
  }
  return plot;
}

}  // namespace kerf
