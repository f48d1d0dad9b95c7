#include "view/picture/panel_sheet.h"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>

#include "kerf/error.h"
#include "view/picture/mm_grid.h"
#include "view/picture/offscreen.h"
#include "view/picture/overlay.h"

namespace kerf {
namespace {

constexpr Rgb8 kInk{33, 37, 43};
constexpr Rgb8 kSoftInk{85, 92, 102};
constexpr Rgb8 kGridLine{120, 200, 255};
constexpr Rgb8 kLevelLine{255, 150, 60};

double WidthOf(const Panel& panel) {
  return std::abs(panel.right_mm - panel.left_mm);
}
double HeightOf(const Panel& panel) {
  return std::abs(panel.bottom_mm - panel.top_mm);
}

// Arrangement of the panels.
struct Arrangement {
  int columns = 0;
  double cell_width = 0, cell_height = 0;
  double unit = 1;  // size of letters and lines
  double pixels_per_mm = 0;

  int letter() const { return static_cast<int>(std::lround(17 * unit)); }
  double left_room() const { return 84 * unit; }
  double right_room() const { return 24 * unit; }
  double top_room() const { return 40 * unit; }
  double bottom_room() const { return 66 * unit; }
};

Arrangement Arrange(const SheetSpec& spec, double top) {
  double width_mm = 0;
  double height_mm = 0;
  for (const Panel& panel : spec.panels) {
    width_mm = std::max(width_mm, WidthOf(panel));
    height_mm = std::max(height_mm, HeightOf(panel));
  }
  const int count = static_cast<int>(spec.panels.size());
  Arrangement best;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    Arrangement a;
    a.columns = columns;
    a.cell_width = static_cast<double>(spec.width) / columns;
    a.cell_height = (spec.height - top) / rows;
    a.unit = std::clamp(std::min(a.cell_width, a.cell_height) / 560, 0.6, 1.8);
    a.pixels_per_mm = std::min((a.cell_width - a.left_room() - a.right_room()) / width_mm,
                               (a.cell_height - a.top_room() - a.bottom_room()) / height_mm);
    if (a.pixels_per_mm > best.pixels_per_mm) best = a;
  }
  if (!(best.pixels_per_mm * std::max(width_mm, height_mm) >= 40)) {
    throw Error(fmt::format("{} x {} pixels are too few for {} pictures; give a larger --size", spec.width, spec.height,
                            count));
  }
  return best;
}

class PanelDrawing {
 public:
  PanelDrawing(const Panel& panel, const Arrangement& arrangement, double cell_left, double cell_top, Overlay& overlay)
      : panel_(panel), a_(arrangement), overlay_(overlay) {
    place_.left = std::round(cell_left + a_.left_room());
    place_.right = place_.left + std::round(WidthOf(panel) * a_.pixels_per_mm);
    place_.top = std::round(cell_top + a_.top_room());
    place_.bottom = place_.top + std::round(HeightOf(panel) * a_.pixels_per_mm);
  }

  PanelPlace Draw() {
    const double width = place_.right - place_.left;
    overlay_.AddImage(panel_.image, place_.left, place_.top, width, place_.bottom - place_.top);
    overlay_.AddText(panel_.title, place_.left, place_.top - 1.6 * a_.letter(), {a_.letter(), kInk, true});
    DrawGrid();
    for (const double level : panel_.levels_mm) {
      const double row = Row(level);
      overlay_.AddPolyline({{place_.left, row}, {place_.right, row}}, 1.5 * a_.unit, kLevelLine, 0.8);
    }
    DrawLetters();
    for (const PanelMark& mark : panel_.marks) DrawName(mark);
    for (const PanelMark& mark : panel_.marks) {  // above all names
      const OverlayPoint at{Column(mark.across_mm), Row(mark.down_mm)};
      overlay_.AddDiscs({at}, 15 * a_.unit, {255, 255, 255});
      overlay_.AddDiscs({at}, 11 * a_.unit, mark.colour);
    }
    return place_;
  }

 private:
  double Column(double mm) const {
    return place_.left + (mm - panel_.left_mm) / (panel_.right_mm - panel_.left_mm) * (place_.right - place_.left);
  }
  double Row(double mm) const {
    return place_.top + (mm - panel_.top_mm) / (panel_.bottom_mm - panel_.top_mm) * (place_.bottom - place_.top);
  }

  void DrawGrid() {
    const MmGrid grid = ChooseMmGrid(a_.pixels_per_mm, 13 * a_.unit, 44 * a_.unit);
    const TextStyle number{static_cast<int>(std::lround(0.85 * a_.letter())), kInk};
    const double tick = 5 * a_.unit;
    const auto line = [&](bool strong, const OverlayPoint& from, const OverlayPoint& to) {
      overlay_.AddPolyline({from, to}, std::max(1.0, a_.unit), kGridLine, strong ? 0.6 : 0.22);
    };
    const auto [left_mm, right_mm] = std::minmax(panel_.left_mm, panel_.right_mm);
    for (const double mm : ListMultiples(grid.line_mm, left_mm, right_mm)) {
      const bool strong = IsMultiple(mm, grid.number_mm);
      const double column = Column(mm);
      line(strong, {column, place_.top}, {column, place_.bottom});
      if (!strong) continue;
      overlay_.AddPolyline({{column, place_.bottom}, {column, place_.bottom + tick}}, std::max(1.0, a_.unit), kInk);
      overlay_.AddText(fmt::format("{:g}", mm + 0.0), column, place_.bottom + 1.6 * tick,
                       {number.size, number.colour, false, Align::kCentre});
    }
    const auto [low_mm, high_mm] = std::minmax(panel_.top_mm, panel_.bottom_mm);
    for (const double mm : ListMultiples(grid.line_mm, low_mm, high_mm)) {
      const bool strong = IsMultiple(mm, grid.number_mm);
      const double row = Row(mm);
      line(strong, {place_.left, row}, {place_.right, row});
      if (!strong) continue;
      overlay_.AddPolyline({{place_.left - tick, row}, {place_.left, row}}, std::max(1.0, a_.unit), kInk);
      overlay_.AddText(fmt::format("{:g}", mm + 0.0), place_.left - 1.6 * tick, row - 0.5 * number.size,
                       {number.size, number.colour, false, Align::kRight});
    }
  }

  void DrawLetters() {
    const int size = a_.letter();
    const double below = place_.bottom + 36 * a_.unit;
    overlay_.AddText(panel_.across_name, 0.5 * (place_.left + place_.right), below,
                     {size, kSoftInk, false, Align::kCentre});
    overlay_.AddText(panel_.down_name, place_.left - 78 * a_.unit, 0.5 * (place_.top + place_.bottom),
                     {size, kSoftInk, false, Align::kCentre, true});
    overlay_.AddText(panel_.left_letter, place_.left, below, {size, kInk, true});
    overlay_.AddText(panel_.right_letter, place_.right, below, {size, kInk, true, Align::kRight});
  }

  void DrawName(const PanelMark& mark) {
    const OverlayPoint at{Column(mark.across_mm), Row(mark.down_mm)};
    if (mark.text.empty()) return;
    const TextStyle style{a_.letter(), kInk, true};
    const Overlay::Size size = overlay_.MeasureText(mark.text, style);
    const double left = at.column + 11 * a_.unit;
    const double top = at.row - 0.5 * size.height;
    overlay_.AddBox(left - 3, top - 2, size.width + 6, size.height + 4, {255, 255, 255}, 0.8);
    overlay_.AddText(mark.text, left, top, style);
  }

  const Panel& panel_;
  const Arrangement& a_;
  Overlay& overlay_;
  PanelPlace place_{};
};

void CheckSheet(const SheetSpec& spec) {
  if (spec.panels.empty()) throw Error("a sheet without pictures can't be drawn");
  if (!kSheetSideRange.Contains(spec.width) || !kSheetSideRange.Contains(spec.height)) {
    throw Error(fmt::format("a sheet of {} x {} pixels can't be drawn; each side must be {}", spec.width, spec.height,
                            ShowRange(kSheetSideRange, "")));
  }
  for (const Panel& panel : spec.panels) {
    if (panel.image.width < 1 || panel.image.height < 1 || !(WidthOf(panel) > 0) || !(HeightOf(panel) > 0)) {
      throw Error(fmt::format("the picture \"{}\" of a sheet is empty", panel.title));
    }
  }
}

}  // namespace

Image RenderSheet(const SheetSpec& spec, std::vector<PanelPlace>* places) {
  CheckSheet(spec);
  const int supersampling = std::max(spec.width, spec.height) <= 4096 ? 2 : 1;
  OffscreenWindow offscreen(spec.width * supersampling, spec.height * supersampling);
  const vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  offscreen.window().AddRenderer(renderer);
  Overlay overlay(*renderer, spec.height, supersampling);
  const double unit = std::clamp(spec.height / 1200.0, 0.6, 4.0);
  const int title = static_cast<int>(std::lround(26 * unit));
  const int caption = static_cast<int>(std::lround(18 * unit));
  const double edge = 20 * unit;
  const TextStyle title_style{title, kInk, true};
  const std::string title_text = overlay.Wrap(spec.title, spec.width - 2 * edge, title_style);
  overlay.AddText(title_text, edge, edge, title_style);
  const double below =
      edge + (1.5 + 1.25 * static_cast<double>(std::count(title_text.begin(), title_text.end(), '\n'))) * title;
  const TextStyle caption_style{caption, kSoftInk};
  const std::string caption_text = overlay.Wrap(spec.caption, spec.width - 2 * edge, caption_style);
  overlay.AddText(caption_text, edge, below, caption_style);
  const auto lines = caption_text.empty() ? 0 : 1 + std::count(caption_text.begin(), caption_text.end(), '\n');
  const double top = below + 1.25 * static_cast<double>(lines) * caption;
  const Arrangement arrangement = Arrange(spec, top);
  for (std::size_t i = 0; i < spec.panels.size(); ++i) {
    const int column = static_cast<int>(i) % arrangement.columns;
    const int row = static_cast<int>(i) / arrangement.columns;
    const PanelPlace place = PanelDrawing(spec.panels[i], arrangement, column * arrangement.cell_width,
                                          top + row * arrangement.cell_height, overlay)
                                 .Draw();
    if (places != nullptr) places->push_back(place);
  }
  return offscreen.Draw(supersampling);
}

void WriteSheet(const SheetSpec& spec, const std::string& path) {
  WritePng(RenderSheet(spec), path);
}

}  // namespace kerf
