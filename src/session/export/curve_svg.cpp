#include "session/export/curve_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/files/html_text.h"
#include "session/export/html.h"

namespace kerf::export_detail {
namespace {

constexpr double kWidth = 760;
constexpr double kHeight = 280;
constexpr double kLeft = 64;
constexpr double kRight = 16;
constexpr double kTop = 16;
constexpr double kBottom = 48;
constexpr std::size_t kBins = 600;

struct Axis {
  double low = 0;
  double high = 1;
  double step = 1;
};

/// Returns an axis from 0 or the minimum to the maximum, with round numbers.
Axis MakeAxis(double low, double high, bool from_zero) {
  if (from_zero) low = std::min(0.0, low);
  if (!(high > low)) high = low + 1;
  const double raw = (high - low) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = power;
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    step = factor * power;
    if (step >= raw * 0.999) break;
  }
  return {.low = std::floor(low / step + 1e-9) * step, .high = std::ceil(high / step - 1e-9) * step, .step = step};
}

std::string Tick(double value, double step, const ReportLanguage& t) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return t.Show(value, decimals);
}

/// Returns the minimum and the maximum of each interval.
std::vector<std::pair<double, double>> Thin(const std::vector<std::pair<double, double>>& points) {
  if (points.size() <= 4 * kBins) return points;
  std::vector<std::pair<double, double>> out;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(bin * points.size() / kBins);
    const auto last = points.begin() + static_cast<std::ptrdiff_t>((bin + 1) * points.size() / kBins);
    const auto by_y = [](const auto& a, const auto& b) { return a.second < b.second; };
    const auto [lowest, highest] = std::minmax_element(first, last, by_y);
    out.push_back(lowest < highest ? *lowest : *highest);
    if (lowest != highest) out.push_back(lowest < highest ? *highest : *lowest);
  }
  return out;
}

}  // namespace

std::string FormatCurveSvg(const ExportCurve& curve, const ReportLanguage& t) {
  std::vector<std::pair<double, double>> points;
  for (const auto& p : curve.points) {
    if (std::isfinite(p.first) && std::isfinite(p.second)) points.push_back(p);
  }
  double x_low = 0;
  double x_high = 1;
  double y_low = 0;
  double y_high = 1;
  if (!points.empty()) {
    x_low = points.front().first;
    x_high = points.back().first;
    const auto by_y = [](const auto& a, const auto& b) { return a.second < b.second; };
    const auto [lowest, highest] = std::minmax_element(points.begin(), points.end(), by_y);
    y_low = lowest->second;
    y_high = highest->second;
  }
  const Axis x = MakeAxis(x_low, x_high, false);
  const Axis y = MakeAxis(y_low, y_high, true);
  const auto to_x = [&](double v) { return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight); };
  const auto to_y = [&](double v) {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  };
  std::string out = fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n", kWidth, kHeight,
                                EscapeHtml(t.Tr(curve.title)));
  out += fmt::format("<title>{}</title>\n", EscapeHtml(t.Tr(curve.title)));
  const int x_ticks = static_cast<int>(std::lround((x.high - x.low) / x.step));
  const int y_ticks = static_cast<int>(std::lround((y.high - y.low) / y.step));
  for (int i = 0; i <= y_ticks; ++i) {
    const double v = y.low + i * y.step;
    out += fmt::format("<line class=\"grid\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kLeft, to_y(v),
                       kWidth - kRight, to_y(v));
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kLeft - 8, to_y(v) + 4,
                       Tick(v, y.step, t));
  }
  for (int i = 0; i <= x_ticks; ++i) {
    const double v = x.low + i * x.step;
    out += fmt::format("<line class=\"axis\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\"/>", to_x(v),
                       kHeight - kBottom, kHeight - kBottom + 5);
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", to_x(v),
                       kHeight - kBottom + 19, Tick(v, x.step, t));
  }
  out += fmt::format("<line class=\"axis\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kLeft,
                     kHeight - kBottom, kWidth - kRight, kHeight - kBottom);
  out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                     0.5 * (kLeft + kWidth - kRight), kHeight - 8, EscapeHtml(t.Tr(curve.x_label)));
  out += fmt::format("<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     0.5 * (kTop + kHeight - kBottom), EscapeHtml(t.Tr(curve.y_label)));
  out += "<polyline class=\"curve\" points=\"";
  for (const auto& [px, py] : Thin(points)) out += fmt::format("{:.1f},{:.1f} ", to_x(px), to_y(py));
  return out + "\"/>\n</svg>\n";
}

}  // namespace kerf::export_detail
