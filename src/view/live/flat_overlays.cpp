#include "view/live/flat_overlays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace kerf {
namespace {

constexpr int kLabelText = 15;
constexpr double kLabelHeight = 21;
constexpr Rgb8 kCasing{255, 255, 255};

bool OverlapsAny(const FlatBox& box, const std::vector<FlatBox>& others) {
  return std::any_of(others.begin(), others.end(), [&](const FlatBox& other) { return Overlap(other, box); });
}

// A part of a circle as a polyline, from `begin` to `end` in turns.
std::vector<OverlayPoint> MakeArc(double x, double y, double radius, double begin, double end) {
  const int steps = std::max(2, static_cast<int>(std::ceil(72 * (end - begin))));
  std::vector<OverlayPoint> arc;
  for (int i = 0; i <= steps; ++i) {
    const double angle = 2 * std::numbers::pi * (begin + (end - begin) * i / steps);
    arc.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
  }
  return arc;
}

}  // namespace

SceneColours ColoursOf(Theme theme) {
  if (theme == Theme::kDark) return {{52, 58, 67}, {30, 34, 40}, {236, 239, 243}, {38, 43, 50}};
  return {{153, 168, 186}, {204, 212, 222}, {26, 29, 36}, {255, 255, 255}};
}

std::vector<PlacedLabel> PlaceLabels(const std::vector<FlatLabel>& labels, const std::vector<FlatBox>& panels,
                                     const std::vector<FlatBox>& soft, double width, double height) {
  std::vector<FlatBox> taken = panels;
  std::vector<PlacedLabel> placed;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const FlatLabel& label = labels[i];
    if (label.text.empty()) continue;
    const double wide = 1.05 * CalcTextWidth(label.text, kLabelText, true) + 12;
    const auto find = [&](bool avoid_soft) -> std::optional<FlatBox> {
      for (const double gap : {8.0, 32.0, 58.0, 92.0, 140.0}) {
        const double right = label.x + gap;
        const double left = label.x - gap - wide;
        const double above = label.y - gap - 0.8 * kLabelHeight;
        const double below = label.y + gap;
        const double middle = label.x - 0.5 * wide;
        const double level = label.y - 0.5 * kLabelHeight;
        const std::array<OverlayPoint, 8> corners{{{right, above},
                                                   {right, below},
                                                   {left, above},
                                                   {left, below},
                                                   {right, level},
                                                   {left, level},
                                                   {middle, above - 6},
                                                   {middle, below}}};
        for (const OverlayPoint& corner : corners) {
          const FlatBox box{corner.column, corner.row, wide, kLabelHeight};
          if (box.left < 0 || box.top < 0 || box.right() > width || box.bottom() > height) continue;
          if (OverlapsAny(box, taken) || (avoid_soft && OverlapsAny(box, soft))) continue;
          return box;
        }
      }
      return std::nullopt;
    };
    std::optional<FlatBox> box = find(true);
    if (!box && !soft.empty()) box = find(false);
    if (!box) continue;
    placed.push_back({i, *box});
    taken.push_back(*box);
  }
  return placed;
}

void AddLabels(const std::vector<FlatLabel>& labels, const std::vector<PlacedLabel>& places, Theme theme,
               DrawList& list) {
  const SceneColours colours = ColoursOf(theme);
  for (const PlacedLabel& place : places) {
    const FlatLabel& label = labels[place.label];
    const OverlayPoint to{std::clamp(label.x, place.box.left, place.box.right()),
                          std::clamp(label.y, place.box.top, place.box.bottom())};
    if (std::hypot(to.column - label.x, to.row - label.y) > 16) {
      list.Line({label.x, label.y}, to, 3, {colours.ground, 0.7});
      list.Line({label.x, label.y}, to, 1.4, {label.colour, 1});
    }
  }
  for (const PlacedLabel& place : places) {
    const FlatLabel& label = labels[place.label];
    list.Box(place.box, {colours.ground, 0.88});
    list.Box({place.box.left, place.box.top, 3, place.box.height}, {label.colour, 1});
    list.Text(
        {label.text, place.box.left + 8, place.box.top + 2, kLabelText, true, false, Align::kLeft, {colours.text, 1}});
  }
}

Rgb8 AlarmColour(AlarmLevel level) {
  switch (level) {
    case AlarmLevel::kDanger:
      return {190, 40, 20};
    case AlarmLevel::kWarning:
      return {230, 159, 0};
    case AlarmLevel::kNotice:
    case AlarmLevel::kNone:
      break;
  }
  return {0, 92, 150};
}

double AlarmRadius(AlarmLevel level) {
  constexpr std::array<double, 4> kRadii{0, 18, 26, 36};
  return kRadii[static_cast<std::size_t>(level)];
}

void AddAlarmRing(double x, double y, AlarmLevel level, DrawList& list) {
  if (level == AlarmLevel::kNone) return;
  const double radius = AlarmRadius(level);
  const FlatColour colour{AlarmColour(level), 1};
  const FlatColour casing{level == AlarmLevel::kWarning ? Rgb8{60, 42, 0} : kCasing, 0.9};
  const auto arc = [&](double r, double width, double begin, double end) {
    list.Polyline(MakeArc(x, y, r, begin, end), width + 2.4, casing);
    list.Polyline(MakeArc(x, y, r, begin, end), width, colour);
  };
  if (level == AlarmLevel::kNotice) {
    for (int i = 0; i < 12; ++i) arc(radius, 2, i / 12.0, (i + 0.5) / 12);
    return;
  }
  if (level == AlarmLevel::kWarning) {
    for (int i = 0; i < 6; ++i) arc(radius, 4, (i + 0.12) / 6, (i + 0.88) / 6);
    return;
  }
  arc(radius, 6, 0, 1);
  arc(0.72 * radius, 2.4, 0, 1);
  for (int i = 0; i < 4; ++i) {
    const double c = std::cos(std::numbers::pi * (0.25 + 0.5 * i));
    const double s = std::sin(std::numbers::pi * (0.25 + 0.5 * i));
    const OverlayPoint a{x + radius * c, y + radius * s};
    const OverlayPoint b{x + 1.45 * radius * c, y + 1.45 * radius * s};
    list.Line(a, b, 7.4, casing);
    list.Line(a, b, 5, colour);
  }
}

double AlarmThickness(AlarmLevel level) {
  constexpr std::array<double, 4> kThickness{0, 0, 5, 12};
  return kThickness[static_cast<std::size_t>(level)];
}

void AddAlarmBorder(const FlatBox& area, AlarmLevel level, DrawList& list) {
  const double thick = AlarmThickness(level);
  if (!(thick > 0) || area.width < 4 * thick || area.height < 4 * thick) return;
  const FlatColour colour{AlarmColour(level), 1};
  if (level == AlarmLevel::kWarning) {
    // Dashes of equal length on all sides.
    constexpr double kDash = 34;
    constexpr double kGap = 14;
    const auto dashes = [&](double length, const auto& add) {
      for (double at = 0; at < length; at += kDash + kGap) add(at, std::min(kDash, length - at));
    };
    dashes(area.width, [&](double at, double length) {
      list.Box({area.left + at, area.top, length, thick}, colour);
      list.Box({area.left + at, area.bottom() - thick, length, thick}, colour);
    });
    dashes(area.height, [&](double at, double length) {
      list.Box({area.left, area.top + at, thick, length}, colour);
      list.Box({area.right() - thick, area.top + at, thick, length}, colour);
    });
    return;
  }
  list.Frame(area, thick, colour);
  // White slanted stripes.
  constexpr double kPitch = 44;
  constexpr double kStripe = 9;
  const FlatColour white{kCasing, 0.9};
  const auto stripe = [&](const OverlayPoint& a, const OverlayPoint& b, const OverlayPoint& c, const OverlayPoint& d) {
    list.Triangle(a, b, c, white);
    list.Triangle(a, c, d, white);
  };
  for (double at = kPitch; at + kStripe + thick < area.width; at += kPitch) {
    for (const double top : {area.top, area.bottom() - thick}) {
      const double x = area.left + at;
      stripe({x + thick, top}, {x + thick + kStripe, top}, {x + kStripe, top + thick}, {x, top + thick});
    }
  }
  for (double at = kPitch; at + kStripe + 2 * thick < area.height; at += kPitch) {
    for (const double left : {area.left, area.right() - thick}) {
      const double y = area.top + at;
      stripe({left, y + thick}, {left + thick, y}, {left + thick, y + kStripe}, {left, y + thick + kStripe});
    }
  }
}

void AddScaleBar(const ScaleBar& scale, double x, double bottom, Theme theme, DrawList& list) {
  const SceneColours colours = ColoursOf(theme);
  const FlatColour ink{colours.text, 1};
  constexpr double kHeight = 36;
  list.Box({x, bottom - kHeight, std::max(scale.points, 56.0) + 10, kHeight}, {colours.ground, 0.8});
  const double left = x + 4;
  const double y = bottom - 8;
  list.Box({left, y, scale.points, 3}, ink);
  list.Box({left, y - 5, 2, 8}, ink);
  list.Box({left + scale.points - 2, y - 5, 2, 8}, ink);
  list.Text({fmt::format("{:g} mm", scale.mm), left, bottom - kHeight + 3, kLabelText, true, false, Align::kLeft, ink});
}

FlatBox FindFreeArea(const std::vector<FlatBox>& boxes, double width, double height) {
  std::vector<double> lefts{0}, rights{width}, tops{0};
  for (const FlatBox& box : boxes) {
    if (box.empty()) continue;
    const auto add = [](std::vector<double>& to, double v, double most) {
      if (v > 0 && v < most) to.push_back(v);
    };
    add(lefts, box.right(), width);
    add(rights, box.left, width);
    add(tops, box.bottom(), height);
  }
  FlatBox best;
  for (const double left : lefts) {
    for (const double right : rights) {
      if (right <= left) continue;
      for (const double top : tops) {
        if ((right - left) * (height - top) <= best.width * best.height) continue;
        // The lowest bottom above which nothing lies between the other three sides.
        double limit = height;
        bool blocked = false;
        for (const FlatBox& box : boxes) {
          if (box.empty() || box.right() <= left || box.left >= right || box.bottom() <= top) continue;
          blocked = blocked || box.top <= top;
          limit = std::min(limit, box.top);
        }
        if (blocked || limit <= top) continue;
        if ((right - left) * (limit - top) > best.width * best.height) best = {left, top, right - left, limit - top};
      }
    }
  }
  return best;
}

}  // namespace kerf
