#include "view/plot/plot.h"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/files/memory.h"
#include "kerf/error.h"
#include "view/picture/offscreen.h"
#include "view/picture/overlay.h"
#include "view/plot/clip.h"
#include "view/plot/label_places.h"
#include "view/plot/plot_canvas.h"
#include "view/plot/plot_scale.h"

namespace kerf {
namespace {

constexpr int kSupersampling = 2;
constexpr Rgb8 kInk{33, 37, 43};
constexpr Rgb8 kSoftInk{85, 92, 102};
constexpr Rgb8 kGrid{222, 226, 230};
// Okabe and Ito's colours with good contrast on white, blue first.
constexpr std::array<Rgb8, 7> kPalette{
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}, {33, 37, 43}}};

Rgb8 MixWithWhite(const Rgb8& colour, double white) {
  Rgb8 mixed{};
  for (std::size_t i = 0; i < 3; ++i) mixed[i] = static_cast<std::uint8_t>(colour[i] + white * (255 - colour[i]) + 0.5);
  return mixed;
}

// Clips the segment a-b to the box. Returns false if no part of it lies inside.
bool ClipToBox(const PlotFrame& box, OverlayPoint& a, OverlayPoint& b) {
  const auto part = ClipSegment(a, b, {box.left, box.top, box.right, box.bottom});
  if (!part || part->from > part->to) return false;
  const OverlayPoint start = a;
  const double dx = b.column - a.column;
  const double dy = b.row - a.row;
  a = {start.column + part->from * dx, start.row + part->from * dy};
  b = {start.column + part->to * dx, start.row + part->to * dy};
  return true;
}

class PlotDrawing {
 public:
  PlotDrawing(const PlotSpec& spec, PlotCanvas& canvas)
      : spec_(spec), canvas_(canvas), unit_(std::clamp(spec.height / 720.0, 0.5, 8.0)) {
    const double words = std::clamp(spec.text_scale, 0.5, 3.0) * unit_;
    text_ = static_cast<int>(std::round(18 * words));
    small_ = static_cast<int>(std::round(16 * words));
    title_ = static_cast<int>(std::round(26 * words));
  }

  PlotFrame Draw() {
    MakeScales();
    const double words_bottom = DrawTexts();
    const std::vector<Tick> y_ticks = y_.MakeTicks(TickCount(0.7 * spec_.height, 60));
    const std::vector<Tick> right_ticks =
        has_right_ ? right_.MakeTicks(TickCount(0.7 * spec_.height, 60)) : std::vector<Tick>{};
    const double edge = 24 * unit_;
    frame_.top = words_bottom + 0.9 * text_;
    frame_.bottom = spec_.height - edge - 3.4 * text_;
    frame_.left = edge + 1.6 * text_ + WidestText(y_ticks) + 14 * unit_;
    frame_.right = spec_.width - edge - (has_right_ ? 1.6 * text_ + WidestText(right_ticks) + 14 * unit_ : 14 * unit_);
    if (frame_.right - frame_.left < 40 || frame_.bottom - frame_.top < 40) {
      throw Error(fmt::format("a plot of {} x {} pixels is too small for its labels", spec_.width, spec_.height));
    }
    frame_.x_lower = x_.lower(), frame_.x_upper = x_.upper();
    frame_.y_lower = y_.lower(), frame_.y_upper = y_.upper();
    DrawBands();
    DrawAxes(y_ticks, right_ticks);
    DrawBandLabels();
    DrawLines();
    for (std::size_t i = 0; i < spec_.series.size(); ++i) DrawSeries(spec_.series[i], ColourOf(i));
    DrawPointLabels();
    DrawNotes();
    return frame_;
  }

 private:
  static int TickCount(double length, double spacing) { return std::max(2, static_cast<int>(length / spacing)); }
  double Column(double fraction) const { return frame_.left + fraction * (frame_.right - frame_.left); }
  double Row(double fraction) const { return frame_.bottom - fraction * (frame_.bottom - frame_.top); }
  Rgb8 ColourOf(std::size_t i) const { return spec_.series[i].colour.value_or(kPalette[i % kPalette.size()]); }

  void MakeScales() {
    PlotExtent x, y, right;
    const auto takes = [](const PlotAxis& axis, double value) {
      return std::isfinite(value) && (!axis.log || value > 0);
    };
    for (const PlotSeries& series : spec_.series) {
      if (series.x.size() != series.y.size()) {
        throw Error(fmt::format("the plot series '{}' has {} x and {} y values", series.label, series.x.size(),
                                series.y.size()));
      }
      has_right_ = has_right_ || series.right_axis;
      const PlotAxis& y_axis = series.right_axis ? spec_.y_right : spec_.y;
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!takes(spec_.x, series.x[i]) || !takes(y_axis, series.y[i])) continue;
        x.Include(series.x[i]);
        (series.right_axis ? right : y).Include(series.y[i]);
      }
    }
    const double headroom = spec_.bands.empty() ? 0.08 : 0.16;  // space for the bands' labels
    x_ = MakePlotScale(spec_.x, x, true, 0, "x");
    // All curves of a plot may use the right axis.
    if (!(y.lower <= y.upper) && has_right_) y = right;
    y_ = MakePlotScale(spec_.y, y, false, headroom, "y");
    if (has_right_) right_ = MakePlotScale(spec_.y_right, right, false, headroom, "the right y");
  }

  double WidestText(const std::vector<Tick>& ticks) const {
    double widest = 0;
    for (const Tick& tick : ticks) {
      if (!tick.text.empty()) widest = std::max(widest, canvas_.MeasureText(tick.text, {small_}).width);
    }
    return widest;
  }

  // Draws title, caption and legend. Returns their lower end.
  double DrawTexts() {
    const double edge = 24 * unit_;
    double row = edge;
    if (!spec_.title.empty()) {
      canvas_.AddText(spec_.title, edge, row, {title_, kInk, true});
      row += 1.45 * title_;
    }
    if (!spec_.caption.empty()) {
      canvas_.AddText(spec_.caption, edge, row, {text_, kSoftInk});
      const auto lines = 1 + std::count(spec_.caption.begin(), spec_.caption.end(), '\n');
      row += (0.5 + 1.15 * static_cast<double>(lines)) * text_;
    }
    double column = edge;
    bool any = false;
    for (std::size_t i = 0; i < spec_.series.size(); ++i) {
      const PlotSeries& series = spec_.series[i];
      if (series.label.empty()) continue;
      const double sample = 1.6 * text_;
      const double width = sample + 0.5 * text_ + canvas_.MeasureText(series.label, {text_}).width;
      if (any && column + width > spec_.width - edge) column = edge, row += 1.5 * text_;
      any = true;
      const double middle = row + 0.55 * text_;
      if (series.width > 0) {
        canvas_.AddLine({{column, middle}, {column + sample, middle}}, std::max(3.0, series.width) * unit_, ColourOf(i),
                        series.dash * unit_);
      }
      AddMarkers({{column + 0.5 * sample, middle}}, {}, series, ColourOf(i));
      canvas_.AddText(series.label, column + sample + 0.5 * text_, row, {text_, kInk});
      column += width + 1.8 * text_;
    }
    return any ? row + 1.3 * text_ : row;
  }

  std::vector<Tick> MakeXTicks() const {
    if (spec_.x.names.empty()) return x_.MakeTicks(TickCount(frame_.right - frame_.left, 95 * unit_));
    std::vector<Tick> ticks;
    for (std::size_t i = 0; i < spec_.x.names.size(); ++i) {
      const double at = static_cast<double>(i);
      if (at >= x_.lower() && at <= x_.upper()) ticks.push_back({at, spec_.x.names[i]});
    }
    return ticks;
  }

  struct Stretch {
    double left, right;
  };
  // Returns the visible part of a band; right <= left if there is none.
  Stretch VisibleBand(const PlotBand& band) const {
    if (!x_.CanShow(band.x0) && !x_.CanShow(band.x1)) return {0, 0};
    const auto fraction = [&](double value) { return x_.CanShow(value) ? std::clamp(x_(value), 0.0, 1.0) : 0.0; };
    return {Column(fraction(std::min(band.x0, band.x1))), Column(fraction(std::max(band.x0, band.x1)))};
  }

  void DrawBands() {
    for (const PlotBand& band : spec_.bands) {
      const Stretch stretch = VisibleBand(band);
      if (stretch.right > stretch.left) {
        canvas_.AddBox(stretch.left, frame_.top, stretch.right - stretch.left, frame_.bottom - frame_.top,
                       MixWithWhite(band.colour, 0.7), 1);
      }
    }
  }

  void DrawBandLabels() {
    for (const PlotBand& band : spec_.bands) {
      const Stretch stretch = VisibleBand(band);
      const double middle = 0.5 * (stretch.left + stretch.right);
      const double room = stretch.right - stretch.left - 0.5 * small_;
      const Overlay::Size size = canvas_.MeasureText(band.label, {small_});
      const double top = frame_.top + 0.5 * small_;
      if (size.width <= room) {
        canvas_.AddText(band.label, middle, top, {small_, kInk, false, Align::kCentre});
      } else if (size.height <= room) {
        canvas_.AddText(band.label, middle - 0.5 * size.height, top, {small_, kInk, false, Align::kRight, true});
      }
    }
  }

  void DrawAxes(const std::vector<Tick>& y_ticks, const std::vector<Tick>& right_ticks) {
    const double thin = std::max(1.0, unit_);
    const std::vector<Tick> x_ticks = MakeXTicks();
    const bool quiet_background = spec_.bands.empty();
    for (const Tick& tick : x_ticks) {
      const double column = Column(x_(tick.value));
      if (quiet_background) canvas_.AddLine({{column, frame_.top}, {column, frame_.bottom}}, thin, kGrid, 0);
    }
    for (const Tick& tick : y_ticks) {
      const double row = Row(y_(tick.value));
      canvas_.AddLine({{frame_.left, row}, {frame_.right, row}}, thin, kGrid, 0);
    }
    const double line = 1.5 * unit_;
    canvas_.AddLine({{frame_.left, frame_.top}, {frame_.left, frame_.bottom}}, line, kInk, 0);
    canvas_.AddLine({{frame_.left, frame_.bottom}, {frame_.right, frame_.bottom}}, line, kInk, 0);
    if (has_right_) canvas_.AddLine({{frame_.right, frame_.top}, {frame_.right, frame_.bottom}}, line, kInk, 0);

    const auto tick_length = [&](const Tick& tick) { return (tick.text.empty() ? 4 : 7) * unit_; };
    for (const Tick& tick : x_ticks) {
      const double column = Column(x_(tick.value));
      canvas_.AddLine({{column, frame_.bottom}, {column, frame_.bottom + tick_length(tick)}}, line, kInk, 0);
      canvas_.AddText(tick.text, column, frame_.bottom + 10 * unit_, {small_, kInk, false, Align::kCentre});
    }
    for (const Tick& tick : y_ticks) {
      const double row = Row(y_(tick.value));
      canvas_.AddLine({{frame_.left - tick_length(tick), row}, {frame_.left, row}}, line, kInk, 0);
      canvas_.AddText(tick.text, frame_.left - 11 * unit_, row - 0.42 * small_, {small_, kInk, false, Align::kRight});
    }
    for (const Tick& tick : right_ticks) {
      const double row = Row(right_(tick.value));
      canvas_.AddLine({{frame_.right, row}, {frame_.right + tick_length(tick), row}}, line, kInk, 0);
      canvas_.AddText(tick.text, frame_.right + 11 * unit_, row - 0.42 * small_, {small_, kInk});
    }
    const double middle_row = 0.5 * (frame_.top + frame_.bottom);
    canvas_.AddText(spec_.x.label, 0.5 * (frame_.left + frame_.right), spec_.height - 24 * unit_ - text_,
                    {text_, kInk, false, Align::kCentre});
    canvas_.AddText(spec_.y.label, 24 * unit_, middle_row, {text_, kInk, false, Align::kCentre, true});
    if (has_right_) {
      canvas_.AddText(spec_.y_right.label, spec_.width - 24 * unit_ - 1.1 * text_, middle_row,
                      {text_, kInk, false, Align::kCentre, true});
    }
  }

  void DrawSeries(const PlotSeries& series, const Rgb8& colour) {
    const PlotScale& y = series.right_axis ? right_ : y_;
    std::vector<OverlayPoint> markers;
    std::vector<OverlayPoint> limits;
    std::vector<OverlayPoint> line;
    const auto finish_line = [&] {
      if (line.size() > 1) {
        canvas_.AddLine(line, series.width * unit_, colour, series.dash * unit_);
        for (std::size_t i = 0; i + 1 < line.size(); ++i) drawn_lines_.emplace_back(line[i], line[i + 1]);
      }
      line.clear();
    };
    bool has_last = false;
    OverlayPoint last{};
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!x_.CanShow(series.x[i]) || !y.CanShow(series.y[i])) {
        finish_line();
        has_last = false;
        continue;
      }
      const OverlayPoint p{Column(x_(series.x[i])), Row(y(series.y[i]))};
      const bool inside = p.column >= frame_.left - 1e-6 && p.column <= frame_.right + 1e-6 &&
                          p.row >= frame_.top - 1e-6 && p.row <= frame_.bottom + 1e-6;
      if (inside) {
        (i < series.at_most.size() && series.at_most[i] ? limits : markers).push_back(p);
        if (series.marker > 0) AddMark(p, series, i, colour);
      }
      if (has_last && series.width > 0) {
        // Skips steps too small to be visible; long logs have many of them.
        const bool is_end = i + 1 == series.x.size();
        if (std::hypot(p.column - last.column, p.row - last.row) < 0.2 && !is_end) continue;
        OverlayPoint a = last;
        OverlayPoint b = p;
        if (ClipToBox(frame_, a, b)) {
          const bool joined =
              !line.empty() && std::hypot(line.back().column - a.column, line.back().row - a.row) < 1e-6;
          if (!joined) {
            finish_line();
            line.push_back(a);
          }
          line.push_back(b);
        } else {
          finish_line();
        }
      }
      last = p;
      has_last = true;
    }
    finish_line();
    AddMarkers(markers, limits, series, colour);
  }

  // Keeps the mark's place free of text and stores its label until all marks are known.
  void AddMark(const OverlayPoint& at, const PlotSeries& series, std::size_t i, const Rgb8& colour) {
    const double side = series.marker * unit_;
    marks_.push_back({at.column - 0.5 * side, at.row - 0.5 * side, side, side});
    if (i >= series.point_labels.size() || series.point_labels[i].empty()) return;
    // Darker than the curve, so that thin strokes have the contrast of thick ones.
    const Rgb8 dark{static_cast<std::uint8_t>(0.75 * colour[0]), static_cast<std::uint8_t>(0.75 * colour[1]),
                    static_cast<std::uint8_t>(0.75 * colour[2])};
    const TextStyle style{small_, dark};
    labels_.push_back({series.point_labels[i], style});
    label_requests_.push_back({at, 0.5 * side + 3 * unit_, canvas_.MeasureText(series.point_labels[i], style)});
  }

  // `limits`: upper limits; the true value lies there or below.
  void AddMarkers(const std::vector<OverlayPoint>& centres, const std::vector<OverlayPoint>& limits,
                  const PlotSeries& series, const Rgb8& colour) {
    if (series.marker <= 0) return;
    MarkerStyle style{series.shape, series.marker * unit_, colour};
    canvas_.AddMarkers(centres, style);
    style.hollow = true;
    for (const OverlayPoint& p : limits) {
      const double down = 1.8 * series.marker * unit_;
      const double wing = 0.35 * series.marker * unit_;
      const double thin = std::max(1.0, 1.3 * unit_);
      canvas_.AddLine({p, {p.column, p.row + down}}, thin, colour, 0);
      canvas_.AddLine(
          {{p.column - wing, p.row + down - wing}, {p.column, p.row + down}, {p.column + wing, p.row + down - wing}},
          thin, colour, 0);
    }
    canvas_.AddMarkers(limits, style);
  }

  void DrawLines() {
    for (const PlotLine& line : spec_.lines) {
      const PlotScale& scale = line.vertical ? x_ : y_;
      if (!scale.CanShow(line.at)) continue;
      const double fraction = scale(line.at);
      if (fraction < 0 || fraction > 1) continue;
      const TextStyle style{small_, line.colour, false, Align::kRight, line.vertical};
      const Overlay::Size size = canvas_.MeasureText(line.label, style);
      const double gap = 4 * unit_;
      const double at = line.vertical ? Column(fraction) : Row(fraction);
      if (line.vertical) {
        canvas_.AddLine({{at, frame_.top}, {at, frame_.bottom}}, 1.5 * unit_, line.colour, line.dash * unit_);
        canvas_.AddText(line.label, at - size.width - gap, frame_.top + gap, style);
        words_.push_back({at - size.width - gap, frame_.top + gap, size.width, size.height});
        drawn_lines_.push_back({{at, frame_.top}, {at, frame_.bottom}});
      } else {
        canvas_.AddLine({{frame_.left, at}, {frame_.right, at}}, 1.5 * unit_, line.colour, line.dash * unit_);
        const double left = line.at_start ? frame_.left + gap : frame_.right - gap - size.width;
        const TextStyle level{small_, line.colour};
        canvas_.AddText(line.label, left, at - size.height - gap, level);
        words_.push_back({left, at - size.height - gap, size.width, size.height});
        drawn_lines_.push_back({{frame_.left, at}, {frame_.right, at}});
      }
    }
  }

  void DrawPointLabels() {
    if (label_requests_.empty()) return;
    LabelObstacles obstacles;
    obstacles.frame = {frame_.left, frame_.top, frame_.right - frame_.left, frame_.bottom - frame_.top};
    obstacles.boxes = marks_;
    obstacles.boxes.insert(obstacles.boxes.end(), words_.begin(), words_.end());
    obstacles.lines = drawn_lines_;
    const std::vector<LabelBox> places = PlaceLabels(label_requests_, obstacles);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const LabelBox& box = places[i];
      // Draws a leader line from the mark to the nearest point of a label that is not next to it.
      const OverlayPoint& at = label_requests_[i].at;
      const OverlayPoint near{std::clamp(at.column, box.left, box.left + box.width),
                              std::clamp(at.row, box.top, box.top + box.height)};
      if (std::hypot(near.column - at.column, near.row - at.row) > 2 * label_requests_[i].reach) {
        canvas_.AddLine({at, near}, std::max(1.0, 0.8 * unit_), labels_[i].style.colour, 0);
      }
      canvas_.AddBox(box.left - unit_, box.top - unit_, box.width + 2 * unit_, box.height + 2 * unit_, {255, 255, 255},
                     0.7);
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      canvas_.AddText(labels_[i].text, places[i].left, places[i].top, labels_[i].style);
    }
  }

  void DrawNotes() {
    for (const PlotNote& note : spec_.notes) {
      if (!x_.CanShow(note.x) || !y_.CanShow(note.y)) continue;
      const TextStyle style{text_, note.colour.value_or(kInk), note.bold, note.align};
      const Overlay::Size size = canvas_.MeasureText(note.text, style);
      const double column = Column(x_(note.x));
      const double top = Row(y_(note.y)) - 0.5 * size.height;
      const double before = note.align == Align::kLeft ? 0 : note.align == Align::kCentre ? 0.5 : 1;
      const double rim = 0.15 * text_;
      canvas_.AddBox(column - before * size.width - rim, top - rim, size.width + 2 * rim, size.height + 2 * rim,
                     {255, 255, 255}, 0.8);
      canvas_.AddText(note.text, column, top, style);
    }
  }

  const PlotSpec& spec_;
  PlotCanvas& canvas_;
  double unit_;
  int text_;
  int small_;
  int title_;
  PlotScale x_, y_, right_;
  bool has_right_ = false;
  PlotFrame frame_{};
  struct PointLabel {
    std::string text;
    TextStyle style;
  };
  std::vector<PointLabel> labels_;
  std::vector<LabelRequest> label_requests_;  // positions wanted for labels_
  std::vector<LabelBox> marks_;
  std::vector<LabelBox> words_;
  std::vector<std::pair<OverlayPoint, OverlayPoint>> drawn_lines_;
};

void CheckSize(const PlotSpec& spec) {
  if (!kSheetSideRange.Contains(spec.width) || !kSheetSideRange.Contains(spec.height)) {
    throw Error(fmt::format("a plot of {} x {} pixels can't be drawn; each side must be {}", spec.width, spec.height,
                            ShowRange(kSheetSideRange, "")));
  }
}

}  // namespace

Image RenderPlot(const PlotSpec& spec, PlotFrame* frame) {
  CheckSize(spec);
  OffscreenWindow offscreen(spec.width * kSupersampling, spec.height * kSupersampling);
  const vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  offscreen.window().AddRenderer(renderer);
  PixelCanvas canvas(*renderer, spec.height, kSupersampling);
  const PlotFrame drawn = PlotDrawing(spec, canvas).Draw();
  if (frame != nullptr) *frame = drawn;
  return offscreen.Draw(kSupersampling);
}

void WritePlot(const PlotSpec& spec, const std::string& path) {
  WritePng(RenderPlot(spec), path);
}

std::string FormatPlotSvg(const PlotSpec& spec, PlotFrame* frame) {
  CheckSize(spec);
  const ExitOnBadAlloc ends;
  const vtkNew<vtkRenderer> renderer;
  SvgCanvas canvas(*renderer, spec.width, spec.height, kSupersampling);
  const PlotFrame drawn = PlotDrawing(spec, canvas).Draw();
  if (frame != nullptr) *frame = drawn;
  return canvas.Finish(spec.title);
}

}  // namespace kerf
