// The figures of `kerf stability`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiment/stability_study/stability_files.h"

namespace kerf {
namespace {

// Okabe and Ito's palette, whose colours colour-blind people can distinguish. Worse results have larger markers.
constexpr Rgb8 kStableColour{86, 180, 233};
constexpr Rgb8 kFrictionColour{0, 158, 115};
constexpr Rgb8 kCycleColour{230, 159, 0};
constexpr Rgb8 kUnstableColour{190, 60, 0};
constexpr Rgb8 kInk{33, 37, 43};
constexpr Rgb8 kSoft{120, 120, 120};
constexpr Rgb8 kStateColours[] = {{33, 37, 43}, {0, 114, 178}, {0, 158, 115}};
/// Maximum number of points of a curve.
constexpr std::size_t kMaxPoints = 1500;

std::string TitleOf(const StabilityStudy& s) {
  return s.title.empty() ? s.scene : s.title;
}

PlotSeries Line(const std::string& label, std::vector<double> x, std::vector<double> y, const Rgb8& colour,
                double width, double dash) {
  PlotSeries line;
  line.label = label;
  line.x = std::move(x);
  line.y = std::move(y);
  line.colour = colour;
  line.width = width;
  line.dash = dash;
  return line;
}

PlotSeries Dots(const std::string& label, const Rgb8& colour, double diameter) {
  PlotSeries dots;
  dots.label = label;
  dots.colour = colour;
  dots.width = 0;
  dots.marker = diameter;
  return dots;
}

}  // namespace

PlotSpec MakeMapPlot(const StabilityStudy& s) {
  const std::vector<double>& K = s.map.stiffness_N_per_mm;
  const std::vector<double>& B = s.map.damping_Ns_per_mm;
  const double scale = s.setup.force_scale;
  PlotSpec plot;
  plot.title = fmt::format("{}: stability map", TitleOf(s));
  plot.caption = fmt::format("{} held by {}, {:g} Hz, {}; in simulated newtons, scaled by {:.3g} on the device",
                             s.setup.profile.name, s.setup.hand.name, s.rate_hz, ToString(s.map_state), scale);
  plot.x.label = "damping of the coupling (N s/mm)";
  plot.y.label = "stiffness of the coupling (N/mm)";
  plot.y.log = true;
  const double half_B = B.size() > 1 ? 0.6 * (B[1] - B[0]) : 0.5;
  const double half_K = K.size() > 1 ? std::pow(K[1] / K[0], 0.6) : 1.3;
  plot.x.lower = B.front() - half_B;
  plot.x.upper = B.back() + half_B;
  plot.y.lower = K.front() / half_K;
  plot.y.upper = K.back() * half_K;

  PlotSeries stable = Dots("stable", kStableColour, 14);
  PlotSeries by_friction = Dots("stable by its friction alone", kFrictionColour, 14);
  PlotSeries cycle = Dots("limit cycle", kCycleColour, 20);
  PlotSeries unstable = Dots("unstable", kUnstableColour, 26);
  for (std::size_t i = 0; i < s.map.behaviour.size(); ++i) {
    const bool linear_stable = s.map_linear[i] == Behaviour::kStable;
    if (s.map.behaviour[i] == Behaviour::kNotHeld) continue;
    PlotSeries& of = s.map.behaviour[i] == Behaviour::kUnstable     ? unstable
                     : s.map.behaviour[i] == Behaviour::kLimitCycle ? cycle
                     : linear_stable                                ? stable
                                                                    : by_friction;
    of.x.push_back(B[i / K.size()]);
    of.y.push_back(K[i % K.size()]);
  }
  for (PlotSeries* of : {&stable, &by_friction, &cycle, &unstable}) plot.series.push_back(std::move(*of));

  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i <= 100; ++i) {
    x.push_back(std::max(*plot.x.lower, 0.0) + (*plot.x.upper - std::max(*plot.x.lower, 0.0)) * i / 100);
    y.push_back(s.limits.CalcRule(x.back()));
  }
  plot.series.push_back(Line("K = 2 (b + B) / (T + 2 t_d)", x, y, kInk, 2.5, 0));
  const bool stiffness_known = s.limits.max_stiffness_N_per_mm <= *plot.y.upper;
  const bool damping_known = s.limits.max_damping_Ns_per_mm <= *plot.x.upper;
  if (stiffness_known) {
    plot.series.push_back(Line("maximum of the device", {*plot.x.lower, *plot.x.upper},
                               {s.limits.max_stiffness_N_per_mm, s.limits.max_stiffness_N_per_mm}, kSoft, 2, 7));
  }
  if (damping_known) {
    plot.series.push_back(Line(stiffness_known ? "" : "maximum of the device",
                               {s.limits.max_damping_Ns_per_mm, s.limits.max_damping_Ns_per_mm},
                               {*plot.y.lower, *plot.y.upper}, kSoft, 2, 7));
  }
  // A ring marks the scene's gains.
  const CouplingParams& own = s.setup.fitted.coupling;
  for (const auto& [colour, diameter] : {std::pair{kInk, 30.0}, {Rgb8{255, 255, 255}, 22.0}, {kInk, 12.0}}) {
    PlotSeries ring = Dots(diameter == 12.0 ? "the scene's gains" : "", colour, diameter);
    ring.x = {own.damping_Ns_per_mm};
    ring.y = {own.stiffness_N_per_mm};
    plot.series.push_back(std::move(ring));
  }
  return plot;
}

PlotSpec MakeMarginPlot(const StabilityStudy& s, MarginKind kind) {
  const bool gain = kind == MarginKind::kGain;
  PlotSpec plot;
  plot.title = fmt::format("{}: {} margin by hand", TitleOf(s), gain ? "gain" : "delay");
  plot.caption = "large: with the real device; small: without its friction and encoder steps";
  plot.y.label = gain ? "loop gain at the limit of stability" : "additional delay tolerated (ticks)";
  plot.y.log = gain;
  std::vector<std::string> hands;
  for (const HandMargins& m : s.margins) {
    if (std::find(hands.begin(), hands.end(), m.hand) == hands.end()) hands.push_back(m.hand);
  }
  for (const std::string& hand : hands) {
    plot.x.names.push_back(hand == s.setup.hand.name ? fmt::format("{} (the scene's)", hand) : hand);
  }
  plot.x.label = "hand, with the coupling of the scene's hand";
  plot.x.lower = -0.5;
  plot.x.upper = static_cast<double>(hands.size()) - 0.5;
  double most = 4;
  double least = gain ? 0.5 : 0;
  for (std::size_t k = 0; k < kHeldStates.size(); ++k) {
    for (const bool linear : {false, true}) {
      PlotSeries dots = Dots(linear ? "" : ToString(kHeldStates[k]), kStateColours[k], linear ? 10 : 20);
      for (const HandMargins& m : s.margins) {
        if (!m.done || m.state != kHeldStates[k] || m.linear != linear || !m.margins.unjudged.empty()) continue;
        const auto at = std::find(hands.begin(), hands.end(), m.hand) - hands.begin();
        const double y = gain ? std::max(m.margins.gain, 0.01) : m.margins.delay_ticks;
        dots.x.push_back(static_cast<double>(at) + 0.22 * (static_cast<double>(k) - 1) + (linear ? 0.07 : 0));
        dots.y.push_back(y);
        most = std::max(most, y);
        least = std::min(least, y);
        if (!linear && (gain ? m.margins.gain_beyond : m.margins.delay_beyond)) {
          plot.notes.push_back(
              {dots.x.back(), gain ? y * 1.4 : y + 0.9, fmt::format("{:.0f}+", y), kStateColours[k], Align::kCentre});
        }
      }
      plot.series.push_back(std::move(dots));
    }
  }
  plot.y.lower = gain ? least / 1.3 : -0.6;
  plot.y.upper = gain ? most * 1.8 : most + 1.8;
  const double asked = gain ? kMinGainMargin : kMinDelayMargin_ticks;
  plot.series.push_back(Line(fmt::format("required for the scene's hand: {:g}", asked), {*plot.x.lower, *plot.x.upper},
                             {asked, asked}, kCycleColour, 2.5, 8));
  if (gain) {
    plot.series.push_back(Line("below: not stable", {*plot.x.lower, *plot.x.upper}, {1, 1}, kUnstableColour, 2.5, 0));
  }
  return plot;
}

PlotSpec MakeScenarioPlot(const StabilityStudy& s, const WorstFigure& worst) {
  const ScenarioResult& scenario = *worst.scenario;
  PlotSpec plot;
  plot.title = fmt::format("{}: {}", TitleOf(s), scenario.name);
  plot.caption = fmt::format("{}: {}", worst.figure->name, DescribeFigure(*worst.figure));
  if (scenario.cut_through_s) plot.caption += "; " + DescribeCutThrough(scenario);
  plot.x.label = "time (s)";
  plot.y.label = "force on the device (N)";
  // There are at most about as many points as pixels: the minimum and the maximum of each interval, so that no spike is
  // lost.
  PlotSeries force;
  force.width = 1.5;
  const std::size_t count = std::min(scenario.time_s.size(), scenario.force_N.size());
  const std::size_t stretch = std::max<std::size_t>(2 * count / kMaxPoints, 1);
  for (std::size_t i = 0; i < count; i += stretch) {
    const auto first = scenario.force_N.begin() + static_cast<std::ptrdiff_t>(i);
    const auto last = scenario.force_N.begin() + static_cast<std::ptrdiff_t>(std::min(i + stretch, count));
    const auto [low, high] = std::minmax_element(first, last);
    force.x.push_back(scenario.time_s[i]);
    force.y.push_back(*low);
    if (high == low) continue;
    force.x.push_back(scenario.time_s[i]);
    force.y.push_back(*high);
  }
  plot.series = {std::move(force)};
  return plot;
}

}  // namespace kerf
