// The figure of a calibration.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiment/calibration/calibration_files.h"
#include "kerf/error.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr int kPanelWidth = 960;
constexpr int kFitHeight = 620;
constexpr int kResidualHeight = 380;
constexpr Rgb8 kThrustColour{0, 114, 178};
constexpr Rgb8 kCuttingColour{213, 94, 0};
constexpr Rgb8 kFitColour{33, 37, 43};
constexpr Rgb8 kBandColour{120, 126, 134};
/// From this ratio of the largest to the smallest bite, the axis is logarithmic.
constexpr double kLinearBiteRatio = 20;

/// A measured value for each mm of width.
struct PlottedValue {
  double bite_um;
  double force_N_per_mm;
  double sd_N_per_mm;
  double residual_N_per_mm;
};

std::vector<PlottedValue> ListValues(const Calibration& c, ForceComponent component) {
  std::vector<PlottedValue> values;
  for (const ForceObservation& o : c.data.observations) {
    if (o.component != component) continue;
    const double force = o.force_N / o.width_mm;
    values.push_back({1000 * o.bite_mm, force, o.sd_N / o.width_mm, force - c.CalcForcePerWidth(component, o.bite_mm)});
  }
  return values;
}

/// Adds points with error bars of one SD; `y` selects the quantity.
void AddPoints(PlotSpec& plot, const std::vector<PlottedValue>& values, double PlottedValue::*y, const Rgb8& colour,
               const std::string& label) {
  PlotSeries bars;
  bars.colour = colour;
  bars.width = 1.5;
  PlotSeries points;
  points.label = label;
  points.colour = colour;
  points.width = 0;
  points.marker = 9;
  for (const PlottedValue& v : values) {
    points.x.push_back(v.bite_um);
    points.y.push_back(v.*y);
    if (!(v.sd_N_per_mm > 0)) continue;
    bars.x.insert(bars.x.end(), 3, v.bite_um);
    bars.y.insert(bars.y.end(), {v.*y - v.sd_N_per_mm, v.*y + v.sd_N_per_mm, std::numeric_limits<double>::quiet_NaN()});
  }
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
  const std::vector<PlottedValue> values = ListValues(c, component);
  const auto [low, high] = std::minmax_element(
      values.begin(), values.end(), [](const PlottedValue& a, const PlottedValue& b) { return a.bite_um < b.bite_um; });
  const Rgb8 colour = component == ForceComponent::kThrust ? kThrustColour : kCuttingColour;
  const ComponentResult& result = c.Find(component);
  PlotSpec fit = MakePanel(kFitHeight, low->bite_um, high->bite_um);
  fit.title = fmt::format("{}: {}", c.law.name, ToString(component));
  fit.caption = result.r2 ? fmt::format("{} values, R2 {:.3f}", values.size(), *result.r2)
                          : fmt::format("{} values", values.size());
  if (result.weighted) fit.caption += "; error bars: one SD";
  fit.y.label = fmt::format("{} for each mm of width (N/mm)", ToString(component));
  AddPoints(fit, values, &PlottedValue::force_N_per_mm, colour, "data");
  AddCurve(fit, c, component, low->bite_um, high->bite_um);
  PlotSpec residuals = MakePanel(kResidualHeight, low->bite_um, high->bite_um);
  residuals.title = "Residuals: data minus fit";
  residuals.y.label = "N/mm";
  AddPoints(residuals, values, &PlottedValue::residual_N_per_mm, colour, "");
  residuals.lines.push_back({false, 0, "", kFitColour});
  Image image = RenderPlot(fit);
  const Image below = RenderPlot(residuals);
  image.height += below.height;
  image.pixels.insert(image.pixels.end(), below.pixels.begin(), below.pixels.end());
  return image;
}

Image JoinPanels(const Image& left, const Image& right) {
  Image joined{left.width + right.width, left.height, {}};
  joined.pixels.reserve(left.pixels.size() + right.pixels.size());
  for (int row = 0; row < left.height; ++row) {
    for (const Image* image : {&left, &right}) {
      const auto begin = image->pixels.begin() + static_cast<std::ptrdiff_t>(row) * image->width;
      joined.pixels.insert(joined.pixels.end(), begin, begin + image->width);
    }
  }
  return joined;
}

}  // namespace

Image RenderCalibration(const Calibration& c) {
  std::vector<Image> panels;
  for (const ComponentResult& r : c.components) {
    if (r.determined) panels.push_back(RenderComponent(c, r.component));
  }
  return panels.size() == 1 ? panels.front() : JoinPanels(panels.at(0), panels.at(1));
}

}  // namespace kerf
