#include "app/cli/paper_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "kerf/paper.h"
#include "view/plot/plot.h"

namespace kerf::cli {
namespace {

constexpr int kHeight = 1080;
constexpr double kDeepest_mm = 7;
constexpr double kComputedTop_N = 4.2;
constexpr double kCorrectedTop_N = 0.3;
constexpr std::array<Rgb8, kPaperRegionCount> kColours{{{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {180, 80, 150}}};
constexpr Rgb8 kGrey{120, 126, 134};

// Makes the computed staircase, with a riser wherever the paper's arc has grown by another pitch.
PlotSeries MakeStaircase(const PaperTables& tables, const PaperRegionRow& region) {
  PlotSeries series;
  const double d = tables.saw.diameter_mm;
  double force = 0;
  series.x = {0};
  series.y = {0};
  for (int n = 1;; ++n) {
    const double step_mm = 2 * d * (1 - std::cos(n * tables.saw.pitch_mm() / d));
    if (step_mm > kDeepest_mm) break;
    series.x.insert(series.x.end(), 2, step_mm);
    series.y.push_back(force);
    force = CalcPaperForce(tables.saw, kPaperShareOfPitch, step_mm, 1000 * region.E_GPa, region.nu,
                           PaperReading::kAsComputed);
    series.y.push_back(force);
  }
  series.x.push_back(kDeepest_mm);
  series.y.push_back(force);
  return series;
}

PlotSeries MakeCorrected(const PaperTables& tables, const PaperRegionRow& region) {
  PlotSeries series;
  constexpr int kSteps = 700;
  for (int i = 0; i <= kSteps; ++i) {
    const double depth_mm = kDeepest_mm * i / kSteps;
    series.x.push_back(depth_mm);
    series.y.push_back(CalcPaperForce(tables.saw, kPaperShareOfPitch, depth_mm, 1000 * region.E_GPa, region.nu,
                                      PaperReading::kCorrected));
  }
  return series;
}

PlotSpec MakePanel(int width) {
  PlotSpec panel;
  panel.width = width;
  panel.height = kHeight;
  panel.text_scale = 1.15;
  panel.x.label = "depth of the disc in the bone (mm)";
  panel.x.lower = 0;
  panel.x.upper = kDeepest_mm;
  panel.y.label = "force on the saw (N)";
  panel.y.lower = 0;
  return panel;
}

// Adds the other reading in grey, in the background.
void AddBackdrop(PlotSpec& panel, PlotSeries series) {
  series.colour = kGrey;
  series.width = 3;
  series.dash = 9;
  panel.series.push_back(std::move(series));
}

// Returns the regions sorted by force, largest first, which is the order of their curves.
std::vector<std::size_t> SortByForce(const PaperTables& tables) {
  std::vector<std::size_t> order(kPaperRegionCount);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tables.regions[a].tooth_force_N > tables.regions[b].tooth_force_N;
  });
  return order;
}

PlotSpec MakeComputedPanel(const PaperTables& tables) {
  PlotSpec panel = MakePanel(1080);
  panel.title = "As the paper computed it: F = n\u00b3 F1";
  panel.caption = "n whole teeth, contact radii added before cubing; F1: one tooth";
  panel.y.upper = kComputedTop_N;
  AddBackdrop(panel, MakeCorrected(tables, tables.regions[0]));
  const std::vector<std::size_t> order = SortByForce(tables);
  for (const std::size_t i : order) {
    PlotSeries line = MakeStaircase(tables, tables.regions[i]);
    line.colour = kColours[i];
    line.width = 2.5;
    panel.series.push_back(line);
  }
  for (const std::size_t i : order) {
    PlotSeries printed;
    for (const PaperDepthRow& row : tables.depths) {
      printed.x.push_back(row.depth_mm);
      printed.y.push_back(row.force_N[i].printed);
    }
    printed.colour = kColours[i];
    printed.width = 0;
    printed.marker = 10;
    panel.series.push_back(printed);
  }
  double y = 3.78;
  for (const std::size_t i : order) {
    const PaperRegionRow& region = tables.regions[i];
    panel.notes.push_back({0.3, y, fmt::format("region {}", region.region), kColours[i], Align::kLeft, true});
    panel.notes.push_back({1.7, y, fmt::format("{:.1f} GPa, nu {:.2f}", region.E_GPa, region.nu), kColours[i]});
    y -= 0.22;
  }
  panel.notes.push_back({0.3, y - 0.06, "dots: the 24 forces that the paper prints", {}});
  const PlotSeries stairs = MakeStaircase(tables, tables.regions[order[0]]);
  // After the start, the curve has two points at each riser, and then the end.
  for (std::size_t n = 1; 2 * n < stairs.x.size(); ++n) {
    const double middle = 0.5 * (stairs.x[2 * n] + stairs.x[2 * n + 1]);
    panel.notes.push_back(
        {middle, stairs.y[2 * n] + (n == 1 ? 0.21 : 0.17), fmt::format("n = {}", n), {}, Align::kCentre});
  }
  panel.notes.push_back({kDeepest_mm - 0.1, 0.4, "corrected", kGrey, Align::kRight});
  return panel;
}

PlotSpec MakeCorrectedPanel(const PaperTables& tables) {
  PlotSpec panel = MakePanel(840);
  panel.title = "Corrected: F = n F1";
  panel.caption = "n = true arc / pitch, the teeth's forces summed";
  panel.y.upper = kCorrectedTop_N;
  AddBackdrop(panel, MakeStaircase(tables, tables.regions[0]));
  for (const std::size_t i : SortByForce(tables)) {
    PlotSeries line = MakeCorrected(tables, tables.regions[i]);
    line.colour = kColours[i];
    line.width = 3;
    panel.series.push_back(line);
  }
  const PaperDepthRow& deepest = tables.depths.back();
  const double computed_N = deepest.force_N[0].computed;
  const double corrected_N = deepest.corrected_N[0];
  const std::string fine = fmt::format("This axis is {:.0f} times as fine.", kComputedTop_N / kCorrectedTop_N);
  const std::string words =
      fmt::format("At {} mm in region {}:\n{:.3f} N corrected,\n{:.3f} N as computed,\n{:.1f} times as much.",
                  deepest.depth_mm, tables.regions[0].region, corrected_N, computed_N, computed_N / corrected_N);
  panel.notes = {
      {1.75, 0.2865, fine, {}, Align::kLeft, true}, {1.75, 0.23, "as computed", kGrey}, {3.1, 0.065, words, {}}};
  return panel;
}

}  // namespace

void WritePaperFigure(const PaperTables& tables, const std::string& path) {
  WritePng(JoinImages(RenderPlot(MakeComputedPanel(tables)), RenderPlot(MakeCorrectedPanel(tables))), path);
}

}  // namespace kerf::cli
