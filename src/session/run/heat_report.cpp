#include "session/run/heat_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "view/plot/field_plot.h"

namespace kerf {
namespace {

constexpr double kStep_mm = 0.1;
constexpr double kWarm_K = 1;  // the section includes bone that differs from body temperature by at least this much
constexpr double kMargin_mm = 2;
constexpr double kMin_mm = 6;  // minimum side length of the picture
constexpr int kMaxHeatPoints = 1200;

/// Returns the section across the tool's plane, through the centre of the warm region, in the direction of its largest
/// extent.
HeatSection MakeSection(const HeatEffect& heat, const Pose& X_WT) {
  const Vec3 across = X_WT.Vector({0, 0, 1});
  const double body_C = heat.params().grid.body_C;
  Vec3 middle(0);
  double weight = 0;
  const auto each = [&](const auto& visit) {
    heat.grid().ForEachNode([&](const HeatNode& node) {
      const double off_K = std::abs(node.C - body_C);
      if (off_K >= kWarm_K || node.cem43_min >= 1) visit(node.p_F_mm + heat.p_WF_mm(), node.fraction * (1 + off_K));
    });
  };
  each([&](const Vec3& p_W, double w) {
    middle += w * p_W;
    weight += w;
  });
  if (!(weight > 0)) return {};
  middle /= weight;
  // The larger principal direction within the tool's plane.
  const Vec3 a = X_WT.Vector({1, 0, 0}), b = X_WT.Vector({0, 1, 0});
  double aa = 0, ab = 0, bb = 0;
  each([&](const Vec3& p_W, double w) {
    const double x = glm::dot(p_W - middle, a), y = glm::dot(p_W - middle, b);
    aa += w * x * x;
    ab += w * x * y;
    bb += w * y * y;
  });
  const double angle = 0.5 * std::atan2(2 * ab, aa - bb);
  Vec3 along = std::cos(angle) * a + std::sin(angle) * b;
  if (along.z > 0 || (along.z == 0 && along.x < 0)) along = -along;  // pointing downwards, as most cuts do
  Vec3 lower(0), upper(0);
  each([&](const Vec3& p_W, double) {
    const Vec3 at(glm::dot(p_W - middle, along), glm::dot(p_W - middle, across), 0);
    lower = glm::min(lower, at);
    upper = glm::max(upper, at);
  });
  lower = glm::min(lower - Vec3(kMargin_mm), Vec3(-0.5 * kMin_mm));
  upper = glm::max(upper + Vec3(kMargin_mm), Vec3(0.5 * kMin_mm));
  const Vec3 size = upper - lower;
  const double step_mm = std::max(kStep_mm, std::max(size.x, size.y) / kMaxHeatPoints);
  return CalcHeatSection(heat, middle + lower.x * along + lower.y * across, along, across, step_mm,
                         static_cast<int>(size.x / step_mm) + 1, static_cast<int>(size.y / step_mm) + 1);
}

PlotField MakeField(const HeatSection& section, const std::vector<float>& values) {
  return {0, -0.5 * section.step_mm * (section.rows - 1), section.step_mm, section.columns, section.rows, values};
}

}  // namespace

std::optional<HeatReport> MakeHeatReport(const EffectPlan& effects, const Pose& X_WT) {
  const auto* heat = dynamic_cast<const HeatEffect*>(effects.Find("heat"));
  if (heat == nullptr) return {};
  return HeatReport{heat->params(), heat->figures(), heat->CalcBalance(),
                    1e-6 * static_cast<double>(heat->CalcMemoryBytes()), MakeSection(*heat, X_WT)};
}

std::string DescribeHeat(const HeatReport& heat) {
  const HeatFigures& f = heat.figures;
  return fmt::format(
      "peak {:.1f} C ({}), {:.1f} s at 47 C and above; dose up to {:.3g} min at 43 C; past 47 C for 1 min {:.3g} mm3, "
      "past 16 min {:.3g} mm3; {:.3g} J into the bone{}{}",
      f.peak_C, heat.params.grid.irrigation_W_per_m2K > 0 ? "irrigated" : "dry", f.above_47_s, f.cem43_min,
      f.past_47_mm3, f.past_dose_mm3, 1e-3 * heat.balance_mJ.put_in,
      heat.balance_mJ.steam > 0 ? fmt::format(", {:.2g} J of it lost as steam", 1e-3 * heat.balance_mJ.steam) : "",
      f.full ? "; max_MB was used up: part of the warm bone was not simulated" : "");
}

nlohmann::ordered_json HeatJson(const HeatReport& heat) {
  const HeatFigures& f = heat.figures;
  const HeatBalance& b = heat.balance_mJ;
  return {{"peak_C", f.peak_C},
          {"hottest_at_the_end_C", f.hottest_C},
          {"above_47_s", f.above_47_s},
          {"cem43_min", f.cem43_min},
          {"past_47_for_1_min_mm3", f.past_47_mm3},
          {"past_dose_of_16_min_mm3", f.past_dose_mm3},
          {"pool_full", f.full},
          {"memory_MB", heat.memory_MB},
          {"share_into_bone", heat.params.share_into_bone},
          {"irrigated", heat.params.grid.irrigation_W_per_m2K > 0},
          {"balance_mJ",
           {{"put_in", b.put_in},
            {"stored", b.stored + b.waiting},
            {"chilled", b.chilled},
            {"rewarmed", b.rewarmed},
            {"perfusion", b.perfusion},
            {"irrigation", b.irrigation},
            {"air", b.air},
            {"steam", b.steam},
            {"chips", b.chips},
            {"no_room", b.no_room}}}};
}

void WriteHeatPicture(const HeatReport& heat, const std::string& name, const std::string& path) {
  const HeatSection& section = heat.section;
  const HeatGridParams& grid = heat.params.grid;
  FieldPlotSpec spec;
  spec.title = name + ": temperature around the kerf";
  spec.caption = fmt::format(
      "at the end, across the kerf; {}; {:g} % of the power into the bone; highest so far {:.0f} °C",
      grid.irrigation_W_per_m2K > 0 ? fmt::format("irrigated, {:g} °C", grid.coolant_C) : std::string("dry"),
      100 * heat.params.share_into_bone, heat.figures.peak_C);
  spec.x_label = "along the cut (mm)";
  spec.y_label = "across the kerf (mm)";
  spec.bar_label = "temperature (°C)";
  spec.field = MakeField(section, section.C);
  double lower = grid.body_C, upper = 50;
  for (const float C : section.C) {
    if (!std::isfinite(C)) continue;
    lower = std::min(lower, static_cast<double>(C));
    upper = std::max(upper, static_cast<double>(C));
  }
  spec.lower = std::floor(lower);
  spec.upper = std::ceil(upper);
  spec.contours.push_back({MakeField(section, section.C), 47, "47 °C now", 2, {20, 20, 30}});
  spec.contours.push_back(
      {MakeField(section, section.cem43_min), 16, "dose of 16 min at 43 °C so far", 2, {0, 90, 178}});
  WriteFieldPlot(spec, path);
}

}  // namespace kerf
