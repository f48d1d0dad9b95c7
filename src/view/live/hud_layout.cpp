#include "view/live/hud_layout.h"

#include <algorithm>
#include <cmath>

#include "view/live/draw_list.h"

namespace kerf {
namespace {

using S = HudSizes;

constexpr double kValuesHeight = 2 * S::kInset + 7 * S::kRow - 4;
constexpr double kGaugeHeight = 118;
constexpr double kMenuRow = 28;
constexpr double kMenuHeader = 54;
constexpr double kMenuFooter = 40;
constexpr double kKeyRow = 21;
constexpr double kGroupTitle = 28;
constexpr double kGroupGap = 14;
constexpr double kHelpHeader = 50;

double PiecesHeight(std::size_t rows) {
  return 2 * S::kInset + 20 + static_cast<double>(rows) * S::kRow;
}

double LegendHeight(std::size_t rows) {
  return 2 * S::kInset + 18 + static_cast<double>(rows) * S::kSmallRow;
}

double GroupHeight(const HudKeyGroup& group) {
  return kGroupTitle + kKeyRow * static_cast<double>(group.keys.size());
}

double HelpHeight(const std::vector<HudKeyGroup>& groups, double width) {
  FlatBox inside{0, 0, width, 1e6};
  double bottom = 0;
  for (const HelpPlace& place : PlaceHelp(groups, inside)) {
    bottom = std::max(bottom, place.y + GroupHeight(groups[place.group]));
  }
  return bottom;
}

FlatBox CalcModal(double width, double height, const HudState& state) {
  const double max_width = width - 2 * S::kEdge;
  const double max_height = height - S::kStatus - 2 * S::kEdge;
  double w = 0;
  double h = 0;
  if (state.progress) {
    w = 520;
    h = 150;
  } else if (state.show_help) {
    w = std::min(max_width, 1200.0);
    h = kHelpHeader + HelpHeight(state.help, w - 4 * S::kInset) + 2 * S::kInset;
  } else if (state.menu) {
    w = 640;
    for (const HudMenuRow& row : state.menu->rows) {
      w = std::max(w, 1.05 * (CalcTextWidth(row.name, S::kText, true) + CalcTextWidth(row.detail, S::kSmall, false)) +
                          6 * S::kInset);
    }
    h = kMenuHeader + kMenuRow * static_cast<double>(state.menu->rows.size()) + kMenuFooter;
  } else if (state.result) {
    w = 700;
    h = 96 + S::kRow * static_cast<double>(state.result->rows.size()) + kMenuFooter;
  } else {
    return {};
  }
  w = std::min(w, max_width);
  h = std::min(h, max_height);
  return {std::floor(0.5 * (width - w)), std::floor(0.5 * (height - S::kStatus - h)), w, h};
}

}  // namespace

std::vector<FlatBox> HudLayout::Panels() const {
  std::vector<FlatBox> all{values, plot, gauge, pieces, banner, legend, orientation, scale_bar, status, modal};
  all.insert(all.end(), slices.begin(), slices.end());
  all.erase(std::remove_if(all.begin(), all.end(), [](const FlatBox& box) { return box.empty(); }), all.end());
  return all;
}

std::vector<std::string> WrapForceNote(const HudState& state) {
  return WrapText(state.force_note, S::kSmall - 1, false, S::kColumn - 2 * S::kInset);
}

HudLayout CalcHudLayout(double width, double height, const HudState& state, const HudExtras& extras) {
  HudLayout layout;
  layout.width = width;
  layout.height = height;
  if (width < 120 || height < 90) return layout;
  layout.status = {0, height - S::kStatus, width, S::kStatus};
  const double bottom = height - S::kStatus - S::kEdge;
  double left = S::kEdge;
  double right = width - S::kEdge;
  layout.modal = CalcModal(width, height, state);
  if (!layout.modal.empty()) {
    layout.scene = {0, 0, width, height - S::kStatus};
    return layout;
  }

  // ---- left: values, gauge, plot, pieces, as far as they fit; the gauge has priority over the plot
  const bool wants_column = state.show_values || state.show_plot || state.gauge.has_value() || !state.pieces.empty();
  if (wants_column && width >= 2.2 * S::kColumn) {
    double y = S::kEdge;
    const auto fits = [&](double h) { return y + h <= bottom; };
    const auto take = [&](double h) {
      const FlatBox box{S::kEdge, y, S::kColumn, h};
      y += h + S::kEdge;
      return box;
    };
    if (state.show_values && fits(kValuesHeight)) layout.values = take(kValuesHeight);
    if (state.gauge && fits(kGaugeHeight)) layout.gauge = take(kGaugeHeight);
    const double note = kNoteLine * static_cast<double>(WrapForceNote(state).size());
    if (state.show_plot && fits(kPlotHeight))
      layout.plot = take(fits(kPlotHeight + note) ? kPlotHeight + note : kPlotHeight);
    if (!state.pieces.empty() && fits(PiecesHeight(1))) {
      const auto room = static_cast<std::size_t>(std::floor((bottom - y - PiecesHeight(0)) / S::kRow));
      layout.piece_rows = std::min({state.pieces.size(), room, std::size_t{10}});
      layout.pieces = take(PiecesHeight(layout.piece_rows));
    }
    if (y > S::kEdge) left += S::kColumn + S::kEdge;
  }

  // ---- right: slices, and the orientation cube below them
  const double cube = extras.orientation ? S::kCube : 0;
  double column = 0;
  if (extras.slices > 0 && width >= 3.2 * S::kColumn) {
    const double n = extras.slices;
    const double room = bottom - S::kEdge - (cube > 0 ? cube + S::kEdge : 0) - (n - 1) * S::kEdge;
    const double side = std::min(S::kSlices * (width >= 1500 ? 1.3 : 1.0), std::floor(room / n) - 18);
    if (side >= 90) {
      column = side;
      for (int i = 0; i < extras.slices; ++i) {
        layout.slices.push_back({right - side, S::kEdge + i * (side + 18 + S::kEdge), side, side + 18});
      }
    }
  }
  if (cube > 0 && height >= 3 * cube) {
    const double side = std::min(cube, 0.2 * width);
    layout.orientation = {right - 0.5 * (std::max(column, side) + side), bottom - side, side, side};
    column = std::max(column, side);
  }
  const double free_right = column > 0 ? right - column - S::kEdge : right;
  // Without slices the cube leaves the corner above it free.
  const double top_right = layout.slices.empty() ? right : free_right;

  if (!state.legend.empty() && top_right - left >= S::kLegend + 200) {
    const auto room =
        static_cast<std::size_t>(std::max(0.0, std::floor((0.6 * bottom - LegendHeight(0)) / S::kSmallRow)));
    layout.legend_rows = std::min(state.legend.size(), room);
    if (layout.legend_rows > 0) {
      layout.legend = {top_right - S::kLegend, S::kEdge, S::kLegend, LegendHeight(layout.legend_rows)};
    }
  }
  const double banner_right = layout.legend.empty() ? top_right : layout.legend.left - S::kEdge;
  if (state.banner && banner_right - left >= 160) {
    const double most = banner_right - left;
    const double w = std::min(most, 620.0);
    const std::size_t lines = std::max<std::size_t>(1, WrapText(state.banner->text, S::kText, true, w - 60).size());
    const double h = 2 * S::kInset + S::kRow * static_cast<double>(lines + (state.banner->answers.empty() ? 0 : 1)) - 4;
    layout.banner = {left + std::floor(0.5 * (most - w)), S::kEdge, w, h};
  }
  if (extras.scale_bar && free_right - left >= 200) {
    layout.scale_bar = {left, bottom - 34, std::min(220.0, free_right - left), 34};
  }
  layout.scene = {left, S::kEdge, free_right - left, bottom - S::kEdge};
  return layout;
}

std::vector<HelpPlace> PlaceHelp(const std::vector<HudKeyGroup>& groups, const FlatBox& inside) {
  const std::size_t columns =
      std::max<std::size_t>(1, std::min<std::size_t>(groups.size(), static_cast<std::size_t>(inside.width / 300)));
  const double gap = 24;
  const double width = (inside.width - gap * static_cast<double>(columns - 1)) / static_cast<double>(columns);
  std::vector<double> y(columns, inside.top);
  std::vector<HelpPlace> places;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto least = std::min_element(y.begin(), y.end());
    const auto column = static_cast<double>(least - y.begin());
    places.push_back({i, inside.left + column * (width + gap), *least, width});
    *least += GroupHeight(groups[i]) + kGroupGap;
  }
  return places;
}

std::size_t FirstRow(std::size_t rows, std::size_t shown, std::size_t selected) {
  if (rows <= shown) return 0;
  const std::size_t middle = selected > shown / 2 ? selected - shown / 2 : 0;
  return std::min(middle, rows - shown);
}

MenuRows PlaceMenuRows(const HudMenu& menu, const FlatBox& modal) {
  MenuRows placed;
  const double room = modal.height - kMenuHeader - kMenuFooter;
  const auto fit = static_cast<std::size_t>(std::max(0.0, std::floor(room / kMenuRow + 1e-9)));
  const std::size_t shown = std::min(menu.rows.size(), fit);
  placed.first = FirstRow(menu.rows.size(), shown, static_cast<std::size_t>(std::max(0, menu.selected)));
  for (std::size_t i = 0; i < shown; ++i) {
    placed.rows.push_back({modal.left + S::kInset, modal.top + kMenuHeader + kMenuRow * static_cast<double>(i),
                           modal.width - 2 * S::kInset, kMenuRow});
  }
  return placed;
}

MenuRows PlacePieceRows(const std::vector<HudPiece>& pieces, const HudLayout& layout) {
  MenuRows placed;
  std::size_t selected = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].selected) selected = i;
  }
  placed.first = FirstRow(pieces.size(), layout.piece_rows, selected);
  for (std::size_t i = 0; i < layout.piece_rows; ++i) {
    placed.rows.push_back({layout.pieces.left + 4,
                           layout.pieces.top + S::kInset + 20 + S::kRow * static_cast<double>(i),
                           layout.pieces.width - 8, S::kRow});
  }
  return placed;
}

}  // namespace kerf
