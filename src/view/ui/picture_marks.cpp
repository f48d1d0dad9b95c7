#include "view/ui/picture_marks.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "view/ui/imgui_colours.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

// Around the place of the cut, only a few labels are drawn.
constexpr double kCutRadius_points = 190;
constexpr std::size_t kMaxAtCut = 3;

bool OverlapsAny(const UiBox& box, const std::vector<UiBox>& others) {
  return std::any_of(others.begin(), others.end(), [&](const UiBox& other) { return Overlap(other, box); });
}

ImVec2 At(double x, double y) {
  return {static_cast<float>(x), static_cast<float>(y)};
}

Rgb8 RingColour(HudLevel level) {
  return level == HudLevel::kPlain ? Rgb8{0, 92, 150} : LevelColour(level);
}

/// Draws a ring around a spot: thin and dashed, thicker with longer dashes, or thick and closed with four ticks.
void DrawRing(ImDrawList& list, const UiRing& ring, double scale) {
  const double radius = RingRadius(ring.level) * scale;
  const ImU32 colour = ToImU32(RingColour(ring.level));
  const ImU32 casing = ToImU32(ring.level == HudLevel::kWarn ? Rgb8{60, 42, 0} : Rgb8{255, 255, 255}, 0.9);
  const auto arc = [&](double r, double points, double begin, double end) {
    for (const auto& [width, ink] : {std::pair{points + 2.4, casing}, std::pair{points, colour}}) {
      const auto from = static_cast<float>(2 * std::numbers::pi * begin);
      const auto to = static_cast<float>(2 * std::numbers::pi * end);
      list.PathArcTo(At(ring.x, ring.y), static_cast<float>(r), from, to,
                     std::max(3, static_cast<int>(std::ceil(72 * (end - begin)))));
      list.PathStroke(ink, 0, static_cast<float>(width * scale));
    }
  };
  if (ring.level == HudLevel::kPlain) {
    for (int i = 0; i < 12; ++i) arc(radius, 2, i / 12.0, (i + 0.5) / 12);
  } else if (ring.level == HudLevel::kWarn) {
    for (int i = 0; i < 6; ++i) arc(radius, 4, (i + 0.12) / 6, (i + 0.88) / 6);
  } else {
    arc(radius, 6, 0, 1);
    arc(0.72 * radius, 2.4, 0, 1);
    for (int i = 0; i < 4; ++i) {
      const double c = std::cos(std::numbers::pi * (0.25 + 0.5 * i));
      const double s = std::sin(std::numbers::pi * (0.25 + 0.5 * i));
      const ImVec2 from = At(ring.x + radius * c, ring.y + radius * s);
      const ImVec2 to = At(ring.x + 1.45 * radius * c, ring.y + 1.45 * radius * s);
      list.AddLine(from, to, casing, static_cast<float>(7.4 * scale));
      list.AddLine(from, to, colour, static_cast<float>(5 * scale));
    }
  }
}

/// Draws the border within the area: dashed for a warning, closed with hatching for danger, and closed and thin for an
/// injury.
void DrawBorder(ImDrawList& list, HudLevel level, bool injured, const UiBox& area, double scale) {
  if (injured && level != HudLevel::kBad) {
    const float thick = static_cast<float>(BorderThickness(HudLevel::kWarn) * scale);
    const float half = 0.5F * thick;
    list.AddRect({static_cast<float>(area.left) + half, static_cast<float>(area.top) + half},
                 {static_cast<float>(area.right()) - half, static_cast<float>(area.bottom()) - half},
                 ToImU32(LevelColour(HudLevel::kBad)), 0, 0, thick);
    return;
  }
  const double thick = BorderThickness(level) * scale;
  if (!(thick > 0) || area.width < 4 * thick || area.height < 4 * thick) return;
  const ImU32 colour = ToImU32(LevelColour(level));
  const auto box = [&](double x, double y, double width, double height) {
    list.AddRectFilled(At(x, y), At(x + width, y + height), colour);
  };
  const auto dashes = [&](double length, double dash, double gap, const auto& add) {
    for (double at = 0; at < length; at += dash + gap) add(at, std::min(dash, length - at));
  };
  const bool danger = level == HudLevel::kBad;
  const double dash = danger ? 1e6 : 34 * scale;
  const double gap = danger ? 0 : 14 * scale;
  dashes(area.width, dash, gap, [&](double at, double length) {
    box(area.left + at, area.top, length, thick);
    box(area.left + at, area.bottom() - thick, length, thick);
  });
  dashes(area.height, dash, gap, [&](double at, double length) {
    box(area.left, area.top + at, thick, length);
    box(area.right() - thick, area.top + at, thick, length);
  });
  if (!danger) return;
  // White slanted stripes.
  const double pitch = 44 * scale;
  const double stripe = 9 * scale;
  const ImU32 white = ToImU32({255, 255, 255}, 0.9);
  for (double at = pitch; at + stripe + thick < area.width; at += pitch) {
    for (const double top : {area.top, area.bottom() - thick}) {
      const double x = area.left + at;
      list.AddQuadFilled(At(x + thick, top), At(x + thick + stripe, top), At(x + stripe, top + thick),
                         At(x, top + thick), white);
    }
  }
  for (double at = pitch; at + stripe + 2 * thick < area.height; at += pitch) {
    for (const double left : {area.left, area.right() - thick}) {
      const double y = area.top + at;
      list.AddQuadFilled(At(left, y + thick), At(left + thick, y), At(left + thick, y + stripe),
                         At(left, y + thick + stripe), white);
    }
  }
}

void DrawScaleBar(ImDrawList& list, const ScaleBar& bar, const UiBox& box, const UiColours& c, double s) {
  list.AddRectFilled(At(box.left, box.top), At(box.right(), box.bottom()), ToImU32(c.panel, 0.8), 3);
  const double x = box.left + 8 * s;
  const double y = box.bottom() - 9 * s;
  const ImU32 ink = ToImU32(c.text);
  list.AddRectFilled(At(x, y), At(x + bar.points, y + 3 * s), ink);
  list.AddRectFilled(At(x, y - 5 * s), At(x + 2 * s, y + 3 * s), ink);
  list.AddRectFilled(At(x + bar.points - 2 * s, y - 5 * s), At(x + bar.points, y + 3 * s), ink);
  list.AddText(At(x, box.top + 3 * s), ink, fmt::format("{:g} mm", bar.mm).c_str());
}

}  // namespace

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

std::optional<UiBox> PlaceScaleBar(const UiSize& size, const UiBox& scene, const std::vector<UiBox>& others,
                                   double scale) {
  const double step = 12 * scale;
  for (double bottom = scene.bottom() - 16 * scale; bottom - size.height > scene.top + 0.5 * scene.height;
       bottom -= step) {
    for (const double left : {scene.left + 14 * scale, scene.right() - 120 * scale - size.width}) {
      const UiBox box{left, bottom - size.height, size.width, size.height};
      if (left >= scene.left && !OverlapsAny(box, others)) return box;
    }
  }
  return std::nullopt;
}

std::vector<UiLabel> ThinOutLabels(const std::vector<UiLabel>& labels, const UiSpot& cut, double radius_px,
                                   std::size_t count) {
  std::vector<UiLabel> kept;
  std::size_t near = 0;
  for (const UiLabel& label : labels) {
    const bool is_near = std::hypot(label.x - cut.x, label.y - cut.y) < radius_px;
    if (!is_near || near < count) kept.push_back(label);
    near += is_near ? 1 : 0;
  }
  return kept;
}

std::vector<UiBox> PlaceLabels(const std::vector<UiLabel>& labels, const std::vector<UiSize>& sizes,
                               const std::vector<UiBox>& panels, const std::vector<UiBox>& soft, const UiBox& area,
                               double scale) {
  std::vector<UiBox> taken = panels;
  std::vector<UiBox> places(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const UiLabel& label = labels[i];
    if (label.text.empty()) continue;
    const double width = sizes[i].width;
    const double height = sizes[i].height;
    const auto find = [&](bool avoids_soft) -> std::optional<UiBox> {
      for (const double points : {8.0, 32.0, 58.0, 92.0, 140.0}) {
        const double gap = points * scale;
        const double right = label.x + gap;
        const double left = label.x - gap - width;
        const double above = label.y - gap - 0.8 * height;
        const double below = label.y + gap;
        const double middle = label.x - 0.5 * width;
        const double level = label.y - 0.5 * height;
        const std::array<std::pair<double, double>, 8> corners{{{right, above},
                                                                {right, below},
                                                                {left, above},
                                                                {left, below},
                                                                {right, level},
                                                                {left, level},
                                                                {middle, above - 6 * scale},
                                                                {middle, below}}};
        for (const auto& [x, y] : corners) {
          const UiBox box{x, y, width, height};
          const bool within =
              x >= area.left && y >= area.top && box.right() <= area.right() && box.bottom() <= area.bottom();
          if (!within || OverlapsAny(box, taken) || (avoids_soft && OverlapsAny(box, soft))) continue;
          return box;
        }
      }
      return std::nullopt;
    };
    std::optional<UiBox> box = find(true);
    if (!box && !soft.empty() && !label.yields) box = find(false);
    if (!box) continue;
    places[i] = *box;
    taken.push_back(*box);
  }
  return places;
}

UiArrow FindBorderArrow(const UiBox& box, const UiSpot& beyond, double inset) {
  const double x = box.left + 0.5 * box.width, y = box.top + 0.5 * box.height;
  const double dx = beyond.x - x, dy = beyond.y - y;
  const double length = std::max(std::hypot(dx, dy), 1e-9);
  // The border is met first along the direction that needs the smaller part of the way.
  const double half_width = std::max(0.5 * box.width - inset, 0.0),
               half_height = std::max(0.5 * box.height - inset, 0.0);
  const double part = std::min(half_width / std::max(std::abs(dx), 1e-9), half_height / std::max(std::abs(dy), 1e-9));
  return {{x + part * dx, y + part * dy}, dx / length, dy / length};
}

double RingRadius(HudLevel level) {
  return level == HudLevel::kBad ? 36 : level == HudLevel::kWarn ? 26 : 18;
}

double BorderThickness(HudLevel level) {
  return level == HudLevel::kBad ? 12 : level == HudLevel::kWarn ? 5 : 0;
}

namespace {

void DrawArrow(ImDrawList& list, const UiArrow& arrow, double s) {
  constexpr double kLength = 46, kHalf = 12;  // points; so slender that its tip is evident
  const auto at = [&](double along, double across) {
    return At(arrow.tip.x + s * (along * arrow.dx - across * arrow.dy),
              arrow.tip.y + s * (along * arrow.dy + across * arrow.dx));
  };
  for (const auto& [grow, colour] :
       {std::pair{3.0, ToImU32({255, 255, 255}, 0.9)}, std::pair{0.0, ToImU32(LevelColour(HudLevel::kWarn))}}) {
    list.AddTriangleFilled(at(3 * grow, 0), at(-kLength - grow, kHalf + 1.5 * grow),
                           at(-kLength - grow, -kHalf - 1.5 * grow), colour);
  }
  list.AddTriangle(at(0, 0), at(-kLength, kHalf), at(-kLength, -kHalf), ToImU32({60, 42, 0}),
                   static_cast<float>(1.5 * s));
}

}  // namespace

void DrawPictureMarks(Ui& ui, const PictureMarks& marks, const UiBox& scene) {
  const double s = ui.scale();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const UiColours& c = ui.colours();
  std::vector<UiBox> soft = marks.kept_clear;
  soft.push_back(marks.tool);
  for (const UiRing& ring : marks.rings) {
    DrawRing(list, ring, s);
    const double r = RingRadius(ring.level) * s;
    soft.push_back({ring.x - r, ring.y - r, 2 * r, 2 * r});
  }
  DrawBorder(list, marks.alarm, marks.injured, scene, s);
  if (marks.beyond) DrawArrow(list, FindBorderArrow(scene, *marks.beyond, 14 * s), s);
  std::vector<UiBox> taken = marks.avoids_panels ? ui.PanelBoxes() : std::vector<UiBox>();
  std::vector<UiLabel> labels = marks.labels;
  if (marks.cut) {
    const double r = 30 * s;
    soft.push_back({marks.cut->x - r, marks.cut->y - r, 2 * r, 2 * r});
    labels = ThinOutLabels(labels, *marks.cut, kCutRadius_points * s, kMaxAtCut);
  }
  if (scene.width > 220 * s && marks.mm_per_pixel > 0) {
    const ScaleBar bar = CalcScaleBar(marks.mm_per_pixel, 190 * s);
    std::vector<UiBox> others = taken;
    for (const UiBox& box : {marks.keep_clear, marks.tool}) {
      if (!box.empty()) others.push_back(box);
    }
    const auto box = PlaceScaleBar({std::max(bar.points + 16 * s, 70 * s), 34 * s}, scene, others, s);
    if (box) DrawScaleBar(list, bar, *box, c, s);
    if (box) taken.push_back(*box);
  }
  ImGui::PushFont(ui.bold());
  std::vector<UiSize> sizes;
  for (const UiLabel& label : labels) {
    const ImVec2 size = ImGui::CalcTextSize(label.text.c_str());
    sizes.push_back({static_cast<double>(size.x) + 14 * s, static_cast<double>(size.y) + 4 * s});
  }
  const std::vector<UiBox> places = PlaceLabels(labels, sizes, taken, soft, scene, s);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const UiBox& box = places[i];
    const UiLabel& label = labels[i];
    if (box.empty()) continue;
    // A line leads to the spot of a label that lies apart from it.
    const double x = std::clamp(label.x, box.left, box.right());
    const double y = std::clamp(label.y, box.top, box.bottom());
    if (std::hypot(x - label.x, y - label.y) <= 16 * s) continue;
    list.AddLine(At(label.x, label.y), At(x, y), ToImU32(c.panel, 0.7), static_cast<float>(3 * s));
    list.AddLine(At(label.x, label.y), At(x, y), ToImU32(label.colour), static_cast<float>(1.4 * s));
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    const UiBox& box = places[i];
    if (box.empty()) continue;
    list.AddRectFilled(At(box.left, box.top), At(box.right(), box.bottom()), ToImU32(c.panel, 0.88));
    list.AddRectFilled(At(box.left, box.top), At(box.left + 3 * s, box.bottom()), ToImU32(labels[i].colour));
    list.AddText(At(box.left + 8 * s, box.top + 2 * s), ToImU32(c.text), labels[i].text.c_str());
  }
  ImGui::PopFont();
}

}  // namespace kerf
