#include "session/score/depths.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Minimum fraction of a cell's volume that must be removed for the place to count as cut.
constexpr double kCutFraction = 0.02;
/// Depth from which a place of the line counts as begun.
constexpr double kLeastDepth_mm = 0.05;
/// Depth that may lack for a place of the line to count as deep enough; the steps of an exercise permit the same.
constexpr double kDeepEnough_mm = 0.3;
/// Fraction of the line by which a stretch may miss the start of the line and yet begin there.
constexpr double kAtStart = 0.05;

double CalcMean(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}

/// Sets how much of the line was cut at all, and how deep.
void MeasureBegun(const std::vector<double>& depths, ScoreSheet& sheet) {
  if (depths.empty()) return;
  double sum_mm = 0;
  std::size_t begun = 0;
  for (const double depth_mm : depths) {
    if (depth_mm < kLeastDepth_mm) continue;
    sum_mm += depth_mm;
    ++begun;
  }
  sheet.begun_share = static_cast<double>(begun) / static_cast<double>(depths.size());
  if (begun > 0) sheet.depth_mm = sum_mm / static_cast<double>(begun);
}

/// Returns whether the cut beyond the end of a deep stretch is more than what a tool leaves that stopped there.
bool GoesOn(const WantedCut& cut, const std::vector<double>& depths, std::size_t end) {
  constexpr double kMore_mm = 0.3, kPart = 0.1;
  const double step_mm = cut.length_mm / static_cast<double>(depths.size());
  // The tool reaches the least sufficient depth this far ahead of its deepest point.
  const double ahead_mm = cut.CalcReachAlong(kDeepEnough_mm);
  std::size_t more = 0;
  for (std::size_t i = end; i < depths.size(); ++i) {
    const double x_mm = std::min(cut.radius_mm, ahead_mm + static_cast<double>(i - end) * step_mm);
    more += depths[i] > std::max(cut.CalcFloor(x_mm), 0.0) + kMore_mm ? 1 : 0;
  }
  return static_cast<double>(more) > kPart * static_cast<double>(depths.size());
}

/// Sets the stretch of the line that is deep enough.
void MeasureDeep(const WantedCut& cut, const std::vector<double>& depths, ScoreSheet& sheet) {
  const auto deep = [&](double depth_mm) { return depth_mm >= cut.depth_mm - kDeepEnough_mm; };
  const auto first = std::find_if(depths.begin(), depths.end(), deep);
  if (first == depths.end()) return;
  const auto last = std::find_if(depths.rbegin(), depths.rend(), deep).base();
  const auto places = static_cast<double>(depths.size());
  DeepStretch stretch{.share = static_cast<double>(last - first) / places,
                      .from_start = static_cast<double>(first - depths.begin()) < kAtStart * places};
  for (auto depth = first; depth != last; ++depth) {
    stretch.shallow_mm += std::max(cut.depth_mm - *depth, 0.0) / static_cast<double>(last - first);
  }
  stretch.goes_on = GoesOn(cut, depths, static_cast<std::size_t>(last - depths.begin()));
  sheet.deep = stretch;
}

void MeasureDepthErrors(const WantedCut& cut, std::span<const CutColumn> columns, const std::vector<double>& depths,
                        ScoreSheet& sheet) {
  std::vector<double> errors;
  double too_deep_mm = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double error_mm = depths[i] - cut.depth_mm;
    errors.push_back(std::abs(error_mm));
    too_deep_mm = std::max(too_deep_mm, error_mm);
  }
  if (errors.empty()) return;
  SetValue(sheet, "depth_error_mean_mm", CalcMean(errors));
  std::sort(errors.begin(), errors.end());
  const auto p95 = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
  SetValue(sheet, "depth_error_p95_mm", errors[p95]);
  SetValue(sheet, "depth_error_worst_mm", errors.back());
  SetValue(sheet, "too_deep_mm", too_deep_mm);
}

}  // namespace

std::vector<double> MeasureDepths(const Bone& before, const Bone& after, const WantedCut& cut,
                                  std::span<const CutColumn> columns, std::span<const RemovedCell> cells) {
  if (columns.empty()) return {};
  const double h = before.voxel_mm();
  const PhiSampler phi_before(before);
  const PhiSampler phi_after(after);
  // This is negative where bone was removed.
  const auto lost = [&](const Vec3& stw) {
    const Vec3 p_W = cut.ToWorld(stw);
    return std::max(phi_before.Calc(p_W), -phi_after.Calc(p_W));
  };
  struct Deepest {
    double t_mm = -1e300;
    Vec3 stw{0};
  };
  std::vector<Deepest> deepest(columns.size());
  const double step_mm = CalcColumnStep(h, cut);
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 < kCutFraction * h * h * h) continue;
    const Vec3 stw = cut.ToCut(cell.p_W);
    const auto at = std::lower_bound(columns.begin(), columns.end(), stw.x - 0.5 * step_mm,
                                     [](const CutColumn& c, double s) { return c.s_mm < s; });
    if (at == columns.end() || std::abs(at->s_mm - stw.x) > step_mm) continue;
    Deepest& d = deepest[static_cast<std::size_t>(at - columns.begin())];
    if (stw.y > d.t_mm) d = {stw.y, stw};
  }
  std::vector<double> depths(columns.size(), 0);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Deepest& d = deepest[i];
    if (d.t_mm < -1e200) continue;
    // Bottom of the cut near that cell: where lines into the bone leave the removed region.
    double bottom_mm = -1e300;
    for (int across = -4; across <= 4; ++across) {
      const double w = d.stw.z + 0.5 * across * h;
      double t0 = d.t_mm - 3 * h;
      double lost0 = lost({columns[i].s_mm, t0, w});
      for (double t = t0 + 0.25 * h; t <= d.t_mm + 2 * h; t += 0.25 * h) {
        const double lost1 = lost({columns[i].s_mm, t, w});
        if (lost0 < 0 && lost1 >= 0) bottom_mm = std::max(bottom_mm, t0 + (t - t0) * lost0 / (lost0 - lost1));
        t0 = t;
        lost0 = lost1;
      }
    }
    if (bottom_mm < -1e200) bottom_mm = d.t_mm;
    depths[i] = std::max(bottom_mm - columns[i].near_mm, 0.0);
  }
  return depths;
}

void MeasureLineDepths(const Bone& before, const Bone& after, const WantedCut& cut, std::span<const RemovedCell> cells,
                       ScoreSheet& sheet) {
  const std::vector<CutColumn> columns = FindColumns(PhiSampler(before), cut, 0);
  const std::vector<double> depths = MeasureDepths(before, after, cut, columns, cells);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double bone_mm = columns[i].far_mm - columns[i].near_mm;
    if (bone_mm > cut.depth_mm + cut.margin_mm && depths[i] > bone_mm - before.voxel_mm()) sheet.through_mm = bone_mm;
  }
  MeasureBegun(depths, sheet);
  MeasureDeep(cut, depths, sheet);
  MeasureDepthErrors(cut, columns, depths, sheet);
}

}  // namespace kerf
