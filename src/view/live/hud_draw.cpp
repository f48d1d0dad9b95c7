#include "view/live/hud_draw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/live/hud_ink.h"

namespace kerf {

using S = HudSizes;

Rgb8 LevelColour(HudLevel level) {
  switch (level) {
    case HudLevel::kGood:
      return {0, 130, 95};
    case HudLevel::kWarn:
      return {230, 159, 0};
    case HudLevel::kBad:
      return {190, 40, 20};
    case HudLevel::kPlain:
      break;
  }
  return {70, 78, 90};
}

std::string FormatHudNumber(const std::optional<double>& value, int decimals) {
  if (!value || !std::isfinite(*value)) return "-";
  const double unit = std::pow(10.0, -decimals);
  const double shown = std::abs(*value) < 0.5 * unit ? 0.0 : *value;
  return fmt::format("{:.{}f}", shown, decimals);
}

ScaleBar CalcScaleBar(double mm_per_point, double max_points) {
  const double max_mm = mm_per_point * max_points;
  const double power = std::pow(10.0, std::floor(std::log10(max_mm)));
  double mm = power;
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= max_mm) {
      mm = factor * power;
      break;
    }
  }
  return {mm, mm / mm_per_point};
}

namespace {

/// Smaller distances to the nerve canal are highlighted.
constexpr double kNerveWarn_mm = 2;

void DrawValues(const HudValues& v, const FlatBox& box, DrawList& list) {
  if (box.empty()) return;
  list.Panel(box, ink::kGround, ink::kEdge);
  struct Row {
    const char* name;
    std::string value;
    const char* unit;
    HudLevel level;
  };
  HudLevel nerve = HudLevel::kPlain;
  if (v.nerve_mm && *v.nerve_mm < kNerveWarn_mm) {
    nerve = *v.nerve_mm <= 0 ? HudLevel::kBad : HudLevel::kWarn;
  }
  const Row rows[] = {
      {"Depth", FormatHudNumber(v.depth_mm, 2), "mm", HudLevel::kPlain},
      {"Feed", FormatHudNumber(v.feed_mm_per_s, 1), "mm/s", HudLevel::kPlain},
      {"Spindle", FormatHudNumber(v.rpm, 0), "rpm", HudLevel::kPlain},
      {"Force", FormatHudNumber(v.force_N, 2), "N", HudLevel::kPlain},
      {"To nerve", FormatHudNumber(v.nerve_mm, 1), "mm", nerve},
      {"Angle to plan", FormatHudNumber(v.plan_angle_deg, 1), "deg", HudLevel::kPlain},
      {"Offset from plan", FormatHudNumber(v.plan_offset_mm, 2), "mm", HudLevel::kPlain},
  };
  double y = box.top + S::kInset - 2;
  for (const Row& row : rows) {
    const bool marked = row.level != HudLevel::kPlain;
    if (marked) {
      list.Box({box.left + 1, y - 1, box.width - 2, S::kRow}, {LevelColour(row.level), 0.22});
      ink::Mark(row.level, box.left + S::kInset + 80, y + 9, 12, list);
    }
    list.Text({row.name, box.left + S::kInset, y + 2, S::kText, marked, false, Align::kLeft, ink::kText});
    list.Text({row.value, box.right() - S::kInset - 42, y + 1, S::kText + 1, true, false, Align::kRight, ink::kText});
    list.Text({row.unit, box.right() - S::kInset - 36, y + 3, S::kSmall, false, false, Align::kLeft, ink::kFaint});
    y += S::kRow;
  }
}

// Returns the top of the axis: 1, 2 or 5 times a power of ten, at least 1 N.
double CalcAxisTop(double largest) {
  double top = 1;
  for (int i = 0; top < largest && i < 30; ++i) top *= i % 3 == 1 ? 2.5 : 2;
  return top;
}

void DrawPlot(const HudState& state, const FlatBox& box, DrawList& list) {
  if (box.empty()) return;
  constexpr double kSpan_s = 10;
  list.Panel(box, ink::kGround, ink::kEdge);
  list.Text({"Force (N)", box.left + S::kInset, box.top + 6, S::kSmall, true, false, Align::kLeft, ink::kText});
  const FlatBox plot{box.left + 38, box.top + 28, box.width - 38 - S::kInset, kPlotHeight - 28 - 24};
  if (box.height > kPlotHeight) {
    double y = box.top + kPlotHeight - 6;
    for (const std::string& line : WrapForceNote(state)) {
      list.Text({line, box.left + S::kInset, y, S::kSmall - 1, false, false, Align::kLeft, ink::kFaint});
      y += kNoteLine;
    }
  }
  double largest = 0;
  for (const PlotPoint& p : state.force) {
    if (p.time_s >= state.now_s - kSpan_s && std::isfinite(p.force_N)) largest = std::max(largest, p.force_N);
  }
  const double top = CalcAxisTop(largest);
  for (int i = 0; i <= 2; ++i) {
    const double y = plot.bottom() - 0.5 * i * plot.height;
    list.Line({plot.left, y}, {plot.right(), y}, 1, {{200, 205, 212}, 1});
    list.Text({fmt::format("{:g}", 0.5 * i * top), plot.left - 5, y - 8, S::kSmall - 1, false, false, Align::kRight,
               ink::kFaint});
  }
  list.Text({"10 s ago", plot.left, plot.bottom() + 4, S::kSmall - 1, false, false, Align::kLeft, ink::kFaint});
  list.Text({"now", plot.right(), plot.bottom() + 4, S::kSmall - 1, false, false, Align::kRight, ink::kFaint});
  // Reduces many points to the largest and the smallest value for each half point of the screen.
  std::vector<OverlayPoint> line;
  long column = -1;
  double low = 0;
  double high = 0;
  const auto flush = [&] {
    if (column < 0) return;
    const double x = plot.left + 0.5 * static_cast<double>(column);
    for (const double f : {low, high}) {
      line.push_back({x, plot.bottom() - std::clamp(f / top, 0.0, 1.0) * plot.height});
    }
  };
  for (const PlotPoint& p : state.force) {
    const double fraction = 1 - (state.now_s - p.time_s) / kSpan_s;
    if (fraction < 0 || fraction > 1 || !std::isfinite(p.force_N)) continue;
    const long here = std::lround(2 * fraction * plot.width);
    if (here != column) {
      flush();
      column = here;
      low = high = p.force_N;
    }
    low = std::min(low, p.force_N);
    high = std::max(high, p.force_N);
  }
  flush();
  list.Polyline(line, 1.6, {kForceColour, 1});
}

void DrawGauge(const HudGauge& gauge, const FlatBox& box, DrawList& list) {
  if (box.empty()) return;
  list.Panel(box, ink::kGround, ink::kEdge);
  list.Text({CutText(gauge.title, S::kText, true, 110), box.left + S::kInset, box.top + 8, S::kText, true, false,
             Align::kLeft, ink::kText});
  list.Text({FormatHudNumber(gauge.value, 2) + " " + gauge.unit, box.right() - S::kInset, box.top + 6, S::kText + 2,
             true, false, Align::kRight, ink::kText});
  const FlatBox bar{box.left + S::kInset, box.top + 36, box.width - 2 * S::kInset, 22};
  const double span = std::max(1e-9, gauge.upper - gauge.lower);
  const auto at = [&](double value) {
    return bar.left + bar.width * std::clamp((value - gauge.lower) / span, 0.0, 1.0);
  };
  list.Box(bar, {{226, 229, 234}, 1});
  if (gauge.goal) {
    const auto zone = [&](double from, double to, const Rgb8& colour, double alpha) {
      list.Box({at(from), bar.top, at(to) - at(from), bar.height}, {colour, alpha});
    };
    zone(*gauge.goal - gauge.warn, *gauge.goal - gauge.good, LevelColour(HudLevel::kWarn), 0.45);
    zone(*gauge.goal - gauge.good, *gauge.goal + gauge.good, LevelColour(HudLevel::kGood), 0.5);
    zone(*gauge.goal + gauge.good, *gauge.goal + gauge.warn, LevelColour(HudLevel::kWarn), 0.45);
    zone(*gauge.goal + gauge.warn, gauge.upper, LevelColour(HudLevel::kBad), 0.45);
    list.Box({at(*gauge.goal) - 1, bar.top - 4, 2, bar.height + 8}, ink::kText);
    list.Text({fmt::format("goal {:g}", *gauge.goal), std::clamp(at(*gauge.goal), bar.left + 30, bar.right() - 30),
               bar.bottom() + 5, S::kSmall, false, false, Align::kCentre, ink::kFaint});
  }
  if (gauge.value) {
    const double x = at(*gauge.value);
    list.Box({bar.left, bar.top + 7, x - bar.left, 8}, {{40, 44, 52}, 0.85});
    list.Triangle({x - 7, bar.top - 7}, {x + 7, bar.top - 7}, {x, bar.top + 5}, ink::kText);
  }
  if (!gauge.word.empty()) {
    const double y = box.bottom() - 34;
    list.Box({box.left + 1, y, box.width - 2, 33}, {LevelColour(gauge.level), 0.22});
    ink::Mark(gauge.level, box.left + S::kInset + 9, y + 16, 17, list);
    list.Text({CutText(gauge.word, S::kText + 1, true, box.width - 60), box.left + S::kInset + 28, y + 8, S::kText + 1,
               true, false, Align::kLeft, ink::kText});
  }
}

void DrawPieces(const HudState& state, const HudLayout& layout, DrawList& list) {
  const FlatBox& box = layout.pieces;
  if (box.empty()) return;
  list.Panel(box, ink::kGround, ink::kEdge);
  const std::size_t hidden = state.pieces.size() - layout.piece_rows;
  list.Text({hidden > 0 ? fmt::format("Pieces ({} more)", hidden) : "Pieces", box.left + S::kInset, box.top + 8,
             S::kSmall, true, false, Align::kLeft, ink::kText});
  const MenuRows rows = PlacePieceRows(state.pieces, layout);
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const HudPiece& piece = state.pieces[rows.first + i];
    const FlatBox& row = rows.rows[i];
    if (piece.selected) ink::Selected(row, list);
    const FlatBox swatch{row.left + 10, row.top + 5, 12, 12};
    if (!piece.hidden) list.Box(swatch, {piece.colour, 1});
    list.Frame(swatch, 1, ink::kFaint);
    const FlatColour& colour = piece.hidden ? ink::kFaint : ink::kText;
    const double room = row.width - 36;
    const std::string detail = CutText(piece.hidden ? "hidden" : piece.detail, S::kSmall, false, 0.55 * room);
    const double taken = CalcTextWidth(detail, S::kSmall, false) * 1.05;
    list.Text({CutText(piece.name, S::kText, piece.selected, room - taken - 6), row.left + 28, row.top + 3, S::kText,
               piece.selected, false, Align::kLeft, colour});
    list.Text({detail, row.right() - 6, row.top + 4, S::kSmall, false, false, Align::kRight, ink::kFaint});
  }
}

void DrawLegend(const HudState& state, const HudLayout& layout, DrawList& list) {
  const FlatBox& box = layout.legend;
  if (box.empty()) return;
  list.Panel(box, ink::kGround, ink::kEdge);
  const std::size_t hidden = state.legend.size() - layout.legend_rows;
  std::string title = state.legend_title.empty() ? "Colours" : state.legend_title;
  if (hidden > 0) title += fmt::format(" ({} more)", hidden);
  list.Text({CutText(title, S::kSmall, true, box.width - 20), box.left + S::kInset, box.top + 8, S::kSmall, true, false,
             Align::kLeft, ink::kText});
  double y = box.top + S::kInset + 18;
  for (std::size_t i = 0; i < layout.legend_rows; ++i) {
    const LegendEntry& entry = state.legend[i];
    const FlatBox swatch{box.left + S::kInset, y + 1, 14, 13};
    list.Box(swatch, {entry.colour, 1});
    list.Frame(swatch, 1, ink::kFaint);
    list.Text({CutText(entry.text, S::kSmall, false, box.width - 46), box.left + S::kInset + 22, y, S::kSmall, false,
               false, Align::kLeft, ink::kText});
    y += S::kSmallRow;
  }
}

void DrawSlices(const HudPictures& pictures, const HudLayout& layout, DrawList& list) {
  if (pictures.slices == nullptr) return;
  for (std::size_t i = 0; i < layout.slices.size() && i < pictures.slices->slices.size(); ++i) {
    const CtSlice& slice = pictures.slices->slices[i];
    const FlatBox& box = layout.slices[i];
    list.Panel(box, ink::kGround, ink::kEdge);
    list.Text({CutText(fmt::format("{}, {:g} mm", slice.name, slice.edge_mm), S::kSmall - 1, false, box.width - 8),
               box.left + 5, box.top + 2, S::kSmall - 1, false, false, Align::kLeft, ink::kText});
    const FlatBox picture{box.left + 1, box.top + 18, box.width - 2, box.width - 2};
    list.Picture(picture, slice.image, 4 * pictures.version + i);
    const FlatColour white{{255, 255, 255}, 1};
    const auto letter = [&](const std::string& text, double x, double y) {
      list.Box({x - 8, y - 1, 16, 17}, {{0, 0, 0}, 0.55});
      list.Text({text, x, y, S::kSmall, true, false, Align::kCentre, white});
    };
    letter(slice.right_letter, picture.right() - 10, picture.top + 0.5 * picture.height - 8);
    letter(slice.up_letter, picture.left + 0.5 * picture.width, picture.top + 2);
  }
}

void DrawScale(const std::optional<ScaleBar>& scale, const FlatBox& box, DrawList& list) {
  if (box.empty() || !scale) return;
  const double y = box.bottom() - 8;
  const double x = box.left + 4;
  const double length = scale->points;
  const FlatColour halo{{255, 255, 255}, 0.8};
  list.Box({box.left, box.top, std::max(length, 56.0) + 10, box.height}, halo);
  list.Box({x, y, length, 3}, ink::kText);
  list.Box({x, y - 5, 2, 8}, ink::kText);
  list.Box({x + length - 2, y - 5, 2, 8}, ink::kText);
  list.Text({fmt::format("{:g} mm", scale->mm), x, box.top + 3, S::kText, true, false, Align::kLeft, ink::kText});
}

void DrawStatus(const HudStatus& status, const FlatBox& box, DrawList& list) {
  if (box.empty()) return;
  list.Box(box, {{236, 239, 243}, 1});
  list.Box({box.left, box.top, box.width, 1}, ink::kEdge);
  const double y = box.top + 6;
  double right = box.right() - S::kInset;
  if (!status.right.empty()) {
    const std::string text = CutText(status.right, S::kText, false, 0.3 * box.width);
    list.Text({text, right, y, S::kText, false, false, Align::kRight, ink::kFaint});
    right -= 1.05 * CalcTextWidth(text, S::kText, false) + 18;
  }
  double x = box.left + S::kInset;
  bool first = true;
  // Writes texts from left to right while there is space; `before`: space to the left of the text.
  const auto write = [&](const std::string& text, bool bold, double before, double most) {
    const double room = std::min(most, right - x - before);
    if (text.empty() || room < 40) return false;
    const std::string shown = CutText(text, S::kText, bold, room);
    list.Text({shown, x + before, y, S::kText, bold, false, Align::kLeft, ink::kText});
    if (!first) list.Box({x - 10, box.top + 6, 1, box.height - 12}, ink::kEdge);
    first = false;
    x += before + 1.05 * CalcTextWidth(shown, S::kText, bold) + 18;
    return true;
  };
  // A prominent filled disc if the spindle is on, a ring if it is off.
  const OverlayPoint lamp{x + 7, box.top + 14};
  list.Disc(lamp, 14, status.spindle_on ? FlatColour{LevelColour(HudLevel::kBad), 1} : ink::kFaint);
  if (!status.spindle_on) list.Disc(lamp, 9, {{236, 239, 243}, 1});
  x += 20;
  constexpr double kAny = 1e9;
  write(status.spindle_on ? "Spindle ON" : "Spindle off", status.spindle_on, 0, kAny);
  if (status.recording_s) {
    const double mark = x;
    const auto s = static_cast<long>(std::max(0.0, *status.recording_s));
    if (write(fmt::format("REC {}:{:02}", s / 60, s % 60), true, 17, kAny)) {
      list.Box({mark, box.top + 9, 11, 11}, {LevelColour(HudLevel::kBad), 1});
    }
  }
  write(status.saw, false, 0, 0.24 * box.width);
  write(status.mode, false, 0, 0.24 * box.width);
  write(status.message, false, 0, kAny);
}

void DrawBanner(const HudBanner& banner, const FlatBox& box, DrawList& list) {
  if (box.empty()) return;
  const bool warning = banner.kind == HudBanner::Kind::kWarning;
  const HudLevel level = warning ? HudLevel::kWarn : HudLevel::kPlain;
  list.Panel(box, {warning ? Rgb8{255, 240, 205} : Rgb8{232, 241, 252}, 0.97}, {LevelColour(level), 1});
  list.Box({box.left, box.top, 6, box.height}, {warning ? LevelColour(level) : kForceColour, 1});
  const double x = box.left + 22;
  if (warning) {
    ink::Mark(HudLevel::kWarn, x + 8, box.top + S::kInset + 8, 18, list);
  } else {
    list.Disc({x + 8, box.top + S::kInset + 8}, 19, {kForceColour, 1});
    list.Text({banner.kind == HudBanner::Kind::kQuestion ? "?" : "i",
               x + 8,
               box.top + S::kInset,
               S::kText,
               true,
               false,
               Align::kCentre,
               {{255, 255, 255}, 1}});
  }
  double y = box.top + S::kInset;
  for (const std::string& line : WrapText(banner.text, S::kText, true, box.width - 60)) {
    list.Text({line, x + 26, y, S::kText, true, false, Align::kLeft, ink::kText});
    y += S::kRow;
  }
  if (!banner.answers.empty()) {
    list.Text({CutText(banner.answers, S::kText, false, box.width - 60), x + 26, y, S::kText, false, false,
               Align::kLeft, ink::kText});
  }
}

void DrawLabels(const std::vector<SceneLabel>& labels, const HudLayout& layout, DrawList& list) {
  std::vector<FlatBox> taken = layout.Panels();
  for (const SceneLabel& label : labels) {
    const double width = 1.05 * CalcTextWidth(label.text, S::kText, true) + 10;
    // The label is placed next to the spot, at the first place that is free.
    const FlatBox places[] = {
        {label.x + 8, label.y - 24, width, 20},         {label.x + 8, label.y + 6, width, 20},
        {label.x - 8 - width, label.y - 24, width, 20}, {label.x - 8 - width, label.y + 6, width, 20},
        {label.x + 8, label.y - 50, width, 20},         {label.x + 8, label.y + 32, width, 20}};
    for (const FlatBox& box : places) {
      const bool within =
          box.left >= 0 && box.top >= 0 && box.right() <= layout.width && box.bottom() <= layout.height - S::kStatus;
      if (!within || std::any_of(taken.begin(), taken.end(), [&](const FlatBox& t) { return Overlap(t, box); })) {
        continue;
      }
      list.Box(box, {{255, 255, 255}, 0.85});
      list.Box({box.left, box.top, 3, box.height}, {label.colour, 1});
      list.Text({label.text, box.left + 7, box.top + 2, S::kText, true, false, Align::kLeft, ink::kText});
      taken.push_back(box);
      break;
    }
  }
}

}  // namespace

void DrawHud(const HudState& state, const HudLayout& layout, const HudPictures& pictures,
             const std::vector<SceneLabel>& labels, const std::optional<ScaleBar>& scale, DrawList& list) {
  if (layout.modal.empty()) {
    DrawLabels(labels, layout, list);
    DrawScale(scale, layout.scale_bar, list);
    DrawValues(state.values, layout.values, list);
    DrawPlot(state, layout.plot, list);
    if (state.gauge) DrawGauge(*state.gauge, layout.gauge, list);
    DrawPieces(state, layout, list);
    DrawLegend(state, layout, list);
    DrawSlices(pictures, layout, list);
    if (state.banner) DrawBanner(*state.banner, layout.banner, list);
  } else {
    list.Box({0, 0, layout.width, layout.height}, {{250, 251, 252}, 0.7});
    DrawModal(state, layout.modal, list);
  }
  DrawStatus(state.status, layout.status, list);
}

}  // namespace kerf
