// The figure of a calibration.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "experiment/calibration/calibration_files.h"
#include "kerf/error.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr int kPanelWidth = 960;
constexpr int kFitHeight = 620;
constexpr int kResidualHeight = 380;
/// Sizes follow the height of a plot; this makes them equal in both panels.
constexpr double kResidualScale = static_cast<double>(kFitHeight) / kResidualHeight;
constexpr Rgb8 kThrustColour{0, 114, 178};
constexpr Rgb8 kCuttingColour{213, 94, 0};
constexpr Rgb8 kFitColour{33, 37, 43};
constexpr Rgb8 kBandColour{120, 126, 134};
/// From this ratio of the largest to the smallest bite, the axis is logarithmic.
constexpr double kLinearBiteRatio = 20;

/// A measured value for each mm of width.
struct PlottedValue {
  double bite_um;
  double drawn_um;  // beside other values of the same bite
  double force_N_per_mm;
  double sd_N_per_mm;
  double residual_N_per_mm;
};

std::vector<PlottedValue> ListValues(const Calibration& c, ForceComponent component) {
  std::vector<PlottedValue> values;
  for (const ForceObservation& o : c.data.observations) {
    if (o.component != component) continue;
    const double force = o.force_N / o.width_mm;
    values.push_back({1000 * o.bite_mm, 1000 * o.bite_mm, force, o.sd_N / o.width_mm,
                      force - c.CalcForcePerWidth(component, o.bite_mm)});
  }
  return values;
}

/// Draws values of the same bite side by side. `width_um`: of all values of one bite, at most.
void Spread(std::vector<PlottedValue>& values, double width_um) {
  std::map<double, std::vector<PlottedValue*>> of_bite;
  for (PlottedValue& v : values) of_bite[v.bite_um].push_back(&v);
  constexpr double kMaxGapFraction = 0.5;  // of the distance to the next bite
  for (auto at = of_bite.begin(); std::next(at) != of_bite.end(); ++at) {
    width_um = std::min(width_um, kMaxGapFraction * (std::next(at)->first - at->first));
  }
  for (auto& [bite_um, same] : of_bite) {
    constexpr double kMaxStepFraction = 0.2;  // of the width
    const double count = static_cast<double>(same.size());
    const double step_um = width_um * std::min(kMaxStepFraction, 1 / count);
    for (std::size_t i = 0; i < same.size(); ++i) {
      same[i]->drawn_um = bite_um + step_um * (static_cast<double>(i) - 0.5 * (count - 1));
    }
  }
}

/// Adds points with error bars of one SD; `y` selects the quantity. The sizes of marks are multiplied by `scale`.
void AddPoints(PlotSpec& plot, const std::vector<PlottedValue>& values, double PlottedValue::*y, const Rgb8& colour,
               const std::string& label, double scale) {
  PlotSeries bars;
  bars.colour = colour;
  bars.width = 1.5 * scale;
  PlotSeries points;
  points.label = label;
  points.colour = colour;
  points.width = 0;
  points.marker = 9 * scale;
  for (const PlottedValue& v : values) {
    points.x.push_back(v.drawn_um);
    points.y.push_back(v.*y);
    if (!(v.sd_N_per_mm > 0)) continue;
    bars.x.insert(bars.x.end(), 3, v.drawn_um);
    bars.y.insert(bars.y.end(), {v.*y - v.sd_N_per_mm, v.*y + v.sd_N_per_mm, std::numeric_limits<double>::quiet_NaN()});
  }
  double lower = std::numeric_limits<double>::infinity();
  double upper = -lower;
  for (const PlottedValue& v : values) {
    lower = std::min(lower, v.*y - v.sd_N_per_mm);
    upper = std::max(upper, v.*y + v.sd_N_per_mm);
  }
  const double margin = upper > lower ? 0.05 * (upper - lower) : 1;
  plot.y.lower = lower - margin;
  plot.y.upper = upper + margin;
  if (!bars.x.empty()) plot.series.push_back(std::move(bars));
  plot.series.push_back(std::move(points));
}

/// Adds the fitted curve and the ends of its band, over the bites of the data.
void AddCurve(PlotSpec& plot, const Calibration& c, ForceComponent component, double low_um, double high_um) {
  PlotSeries fit{"fit", {}, {}, kFitColour};
  PlotSeries lower{"95 % band of the fit", {}, {}, kBandColour};
  lower.dash = 6;
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) {
    const double bite_um = std::lerp(low_um, high_um, static_cast<double>(i) / kSteps);
    fit.x.push_back(bite_um);
    fit.y.push_back(c.CalcForcePerWidth(component, 1e-3 * bite_um));
  }
  lower.x = fit.x;
  PlotSeries upper = lower;
  upper.label.clear();
  for (int i = 0; i <= kSteps; ++i) {
    const auto half = c.CalcHalfBand(component, 1e-3 * fit.x[static_cast<std::size_t>(i)]);
    if (!half) break;
    lower.y.push_back(fit.y[static_cast<std::size_t>(i)] - *half);
    upper.y.push_back(fit.y[static_cast<std::size_t>(i)] + *half);
  }
  plot.series.push_back(std::move(fit));
  if (lower.y.empty()) return;
  plot.series.push_back(std::move(lower));
  plot.series.push_back(std::move(upper));
}

PlotSpec MakePanel(int height, double low_um, double high_um) {
  PlotSpec plot;
  plot.width = kPanelWidth;
  plot.height = height;
  plot.x.label = "bite (um)";
  plot.x.log = high_um > kLinearBiteRatio * low_um;
  const double margin_um = 0.05 * (high_um - low_um);
  plot.x.lower = plot.x.log ? 0.8 * low_um : std::max(0.0, low_um - margin_um);
  plot.x.upper = plot.x.log ? 1.25 * high_um : high_um + margin_um;
  return plot;
}

Image RenderComponent(const Calibration& c, ForceComponent component) {
  std::vector<PlottedValue> values = ListValues(c, component);
  const auto [low, high] = std::minmax_element(
      values.begin(), values.end(), [](const PlottedValue& a, const PlottedValue& b) { return a.bite_um < b.bite_um; });
  const double low_um = low->bite_um;
  const double high_um = high->bite_um;
  Spread(values, high_um > kLinearBiteRatio * low_um ? 0 : 0.05 * (high_um - low_um));
  const Rgb8 colour = component == ForceComponent::kThrust ? kThrustColour : kCuttingColour;
  const ComponentResult& result = c.Find(component);
  PlotSpec fit = MakePanel(kFitHeight, low_um, high_um);
  fit.title = fmt::format("{}: {}", c.law.name, ToString(component));
  fit.caption = result.r2 ? fmt::format("{} values, R2 {:.3f}", values.size(), *result.r2)
                          : fmt::format("{} values", values.size());
  if (result.weighted) fit.caption += "; error bars: one SD";
  fit.caption += "; values of the same bite side by side";
  fit.y.label = fmt::format("{} for each mm of width (N/mm)", ToString(component));
  AddPoints(fit, values, &PlottedValue::force_N_per_mm, colour, "data", 1);
  AddCurve(fit, c, component, low_um, high_um);
  PlotSpec residuals = MakePanel(kResidualHeight, low_um, high_um);
  residuals.text_scale = kResidualScale;
  residuals.title = "Residuals: data minus fit";
  residuals.y.label = "N/mm";
  AddPoints(residuals, values, &PlottedValue::residual_N_per_mm, colour, "", kResidualScale);
  residuals.lines.push_back({false, 0, "", kFitColour});
  Image image = RenderPlot(fit);
  AppendImage(RenderPlot(residuals), image);
  return image;
}

}  // namespace

Image RenderCalibration(const Calibration& c) {
  std::vector<Image> panels;
  for (const ComponentResult& r : c.components) {
    if (r.determined) panels.push_back(RenderComponent(c, r.component));
  }
  return panels.size() == 1 ? panels.front() : JoinImages(panels.at(0), panels.at(1));
}

}  // namespace kerf
