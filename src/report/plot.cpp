#include "report/plot.h"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kerf/error.h"
#include "render/offscreen.h"
#include "render/overlay.h"
#include "report/ticks.h"

namespace kerf {
namespace {

constexpr int kSupersampling = 2;
constexpr Rgb8 kInk{33, 37, 43};
constexpr Rgb8 kSoftInk{85, 92, 102};
constexpr Rgb8 kGrid{222, 226, 230};
// Okabe and Ito's colours that stand out on white, blue first.
constexpr std::array<Rgb8, 7> kPalette{
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}, {33, 37, 43}}};

Rgb8 MixWithWhite(const Rgb8& colour, double white) {
  Rgb8 mixed{};
  for (std::size_t i = 0; i < 3; ++i) mixed[i] = static_cast<std::uint8_t>(colour[i] + white * (255 - colour[i]) + 0.5);
  return mixed;
}

// One axis: from data to a share of the axes' box, 0 to 1.
class Scale {
 public:
  Scale() = default;
  Scale(double lower, double upper, bool log) : lower_(lower), upper_(upper), log_(log) {}
  double lower() const { return lower_; }
  double upper() const { return upper_; }
  bool log() const { return log_; }
  bool Takes(double value) const { return std::isfinite(value) && (!log_ || value > 0); }
  double operator()(double value) const {
    if (log_) return std::log(value / lower_) / std::log(upper_ / lower_);
    return (value - lower_) / (upper_ - lower_);
  }
  std::vector<Tick> MakeTicks(int count) const {
    return log_ ? CalcLogTicks(lower_, upper_) : CalcLinearTicks(lower_, upper_, count);
  }

 private:
  double lower_ = 0;
  double upper_ = 1;
  bool log_ = false;
};

struct Extent {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();
  void Include(double value) {
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  }
};

// `tight`: the axis ends where the data end.
// `headroom`: share of the range that stays free above the data.
Scale MakeScale(const PlotAxis& axis, const Extent& data, bool tight, double headroom, const char* name) {
  double lower = axis.lower.value_or(data.lower);
  double upper = axis.upper.value_or(data.upper);
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    throw Error(fmt::format("a plot needs at least one finite{} value along {}", axis.log ? " positive" : "", name));
  }
  if (axis.log) {
    if (!(lower > 0)) throw Error(fmt::format("a logarithmic axis can't begin at {} along {}", lower, name));
    if (!axis.lower && !tight) lower /= 1.3;
    if (!axis.upper && !tight) upper *= 1.3;
    if (!(upper > lower * 1.0001)) lower /= 2, upper *= 2;
    return {lower, upper, true};
  }
  // Quantities that begin near nothing are shown from nothing on.
  if (!axis.lower && !tight && lower > 0 && lower < 0.5 * upper) lower = 0;
  const double span = upper - lower;
  if (!axis.upper && !tight) upper += headroom * span;
  if (!axis.lower && !tight && lower < 0) lower -= 0.08 * span;
  if (!(upper - lower > 1e-9 * std::max(std::abs(lower), std::abs(upper)))) {
    const double room = lower == 0 ? 1 : 0.5 * std::abs(lower);
    lower -= room, upper += room;
  }
  return {lower, upper, false};
}

// Cuts the segment a-b to the box; false when nothing of it lies inside (after Liang and Barsky, 1984).
bool ClipToBox(const PlotFrame& box, OverlayPoint& a, OverlayPoint& b) {
  double enter = 0;
  double leave = 1;
  const double dx = b.column - a.column;
  const double dy = b.row - a.row;
  const double p[4] = {-dx, dx, -dy, dy};
  const double q[4] = {a.column - box.left, box.right - a.column, a.row - box.top, box.bottom - a.row};
  for (int i = 0; i < 4; ++i) {
    if (p[i] == 0) {
      if (q[i] < 0) return false;
      continue;
    }
    const double t = q[i] / p[i];
    if (p[i] < 0)
      enter = std::max(enter, t);
    else
      leave = std::min(leave, t);
  }
  if (enter > leave) return false;
  const OverlayPoint start = a;
  a = {start.column + enter * dx, start.row + enter * dy};
  b = {start.column + leave * dx, start.row + leave * dy};
  return true;
}

class PlotDrawing {
 public:
  PlotDrawing(const PlotSpec& spec, vtkRenderer& renderer)
      : spec_(spec), overlay_(renderer, spec.height, kSupersampling), unit_(std::clamp(spec.height / 720.0, 0.5, 8.0)) {
    const double words = std::clamp(spec.text_scale, 0.5, 3.0) * unit_;
    text_ = static_cast<int>(std::round(18 * words));
    small_ = static_cast<int>(std::round(16 * words));
    title_ = static_cast<int>(std::round(26 * words));
  }

  PlotFrame Draw() {
    MakeScales();
    const double words_bottom = DrawWords();
    const std::vector<Tick> y_ticks = y_.MakeTicks(TickCount(0.7 * spec_.height, 60));
    const std::vector<Tick> right_ticks =
        has_right_ ? right_.MakeTicks(TickCount(0.7 * spec_.height, 60)) : std::vector<Tick>{};
    const double edge = 24 * unit_;
    frame_.top = words_bottom + 0.9 * text_;
    frame_.bottom = spec_.height - edge - 3.4 * text_;
    frame_.left = edge + 1.6 * text_ + WidestText(y_ticks) + 14 * unit_;
    frame_.right = spec_.width - edge - (has_right_ ? 1.6 * text_ + WidestText(right_ticks) + 14 * unit_ : 14 * unit_);
    if (frame_.right - frame_.left < 40 || frame_.bottom - frame_.top < 40) {
      throw Error(fmt::format("a plot of {} x {} pixels has no room for its words", spec_.width, spec_.height));
    }
    frame_.x_lower = x_.lower(), frame_.x_upper = x_.upper();
    frame_.y_lower = y_.lower(), frame_.y_upper = y_.upper();
    DrawBands();
    DrawAxes(y_ticks, right_ticks);
    DrawBandLabels();
    for (std::size_t i = 0; i < spec_.series.size(); ++i) DrawSeries(spec_.series[i], ColourOf(i));
    DrawNotes();
    return frame_;
  }

 private:
  static int TickCount(double length, double wish) { return std::max(2, static_cast<int>(length / wish)); }
  double Column(double share) const { return frame_.left + share * (frame_.right - frame_.left); }
  double Row(double share) const { return frame_.bottom - share * (frame_.bottom - frame_.top); }
  Rgb8 ColourOf(std::size_t i) const { return spec_.series[i].colour.value_or(kPalette[i % kPalette.size()]); }

  void MakeScales() {
    Extent x, y, right;
    const auto takes = [](const PlotAxis& axis, double value) {
      return std::isfinite(value) && (!axis.log || value > 0);
    };
    for (const PlotSeries& series : spec_.series) {
      if (series.x.size() != series.y.size()) {
        throw Error(
            fmt::format("the plot's series '{}' has {} x and {} y", series.label, series.x.size(), series.y.size()));
      }
      has_right_ = has_right_ || series.right_axis;
      const PlotAxis& y_axis = series.right_axis ? spec_.y_right : spec_.y;
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!takes(spec_.x, series.x[i]) || !takes(y_axis, series.y[i])) continue;
        x.Include(series.x[i]);
        (series.right_axis ? right : y).Include(series.y[i]);
      }
    }
    const double headroom = spec_.bands.empty() ? 0.08 : 0.16;  // the bands' labels stand there
    x_ = MakeScale(spec_.x, x, true, 0, "x");
    // A plot may have all its curves on the right.
    if (!(y.lower <= y.upper) && has_right_) y = right;
    y_ = MakeScale(spec_.y, y, false, headroom, "y");
    if (has_right_) right_ = MakeScale(spec_.y_right, right, false, headroom, "the right y");
  }

  double WidestText(const std::vector<Tick>& ticks) const {
    double widest = 0;
    for (const Tick& tick : ticks) {
      if (!tick.text.empty()) widest = std::max(widest, overlay_.MeasureText(tick.text, {small_}).width);
    }
    return widest;
  }

  // Title, caption and legend; returns where they end.
  double DrawWords() {
    const double edge = 24 * unit_;
    double row = edge;
    if (!spec_.title.empty()) {
      overlay_.AddText(spec_.title, edge, row, {title_, kInk, true});
      row += 1.45 * title_;
    }
    if (!spec_.caption.empty()) {
      overlay_.AddText(spec_.caption, edge, row, {text_, kSoftInk});
      row += 1.65 * text_;
    }
    double column = edge;
    bool any = false;
    for (std::size_t i = 0; i < spec_.series.size(); ++i) {
      const PlotSeries& series = spec_.series[i];
      if (series.label.empty()) continue;
      const double sample = 1.6 * text_;
      const double width = sample + 0.5 * text_ + overlay_.MeasureText(series.label, {text_}).width;
      if (any && column + width > spec_.width - edge) column = edge, row += 1.5 * text_;
      any = true;
      const double middle = row + 0.55 * text_;
      if (series.width > 0) {
        AddLine({{column, middle}, {column + sample, middle}}, series, std::max(3.0, series.width), ColourOf(i));
      }
      AddMarkers({{column + 0.5 * sample, middle}}, series, ColourOf(i));
      overlay_.AddText(series.label, column + sample + 0.5 * text_, row, {text_, kInk});
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
  // The part of a band that the axis shows; right <= left when there is none.
  Stretch VisibleBand(const PlotBand& band) const {
    if (!x_.Takes(band.x0) && !x_.Takes(band.x1)) return {0, 0};
    const auto share = [&](double value) { return x_.Takes(value) ? std::clamp(x_(value), 0.0, 1.0) : 0.0; };
    return {Column(share(std::min(band.x0, band.x1))), Column(share(std::max(band.x0, band.x1)))};
  }

  void DrawBands() {
    for (const PlotBand& band : spec_.bands) {
      const Stretch stretch = VisibleBand(band);
      if (stretch.right > stretch.left) {
        overlay_.AddBox(stretch.left, frame_.top, stretch.right - stretch.left, frame_.bottom - frame_.top,
                        MixWithWhite(band.colour, 0.7));
      }
    }
  }

  void DrawBandLabels() {
    for (const PlotBand& band : spec_.bands) {
      const Stretch stretch = VisibleBand(band);
      const double middle = 0.5 * (stretch.left + stretch.right);
      const double room = stretch.right - stretch.left - 0.5 * small_;
      const Overlay::Size size = overlay_.MeasureText(band.label, {small_});
      const double top = frame_.top + 0.5 * small_;
      if (size.width <= room) {
        overlay_.AddText(band.label, middle, top, {small_, kInk, false, Align::kCentre});
      } else if (size.height <= room) {
        overlay_.AddText(band.label, middle - 0.5 * size.height, top, {small_, kInk, false, Align::kRight, true});
      }
    }
  }

  void DrawAxes(const std::vector<Tick>& y_ticks, const std::vector<Tick>& right_ticks) {
    const double thin = std::max(1.0, unit_);
    const std::vector<Tick> x_ticks = MakeXTicks();
    const bool quiet_background = spec_.bands.empty();
    for (const Tick& tick : x_ticks) {
      const double column = Column(x_(tick.value));
      if (quiet_background) overlay_.AddPolyline({{column, frame_.top}, {column, frame_.bottom}}, thin, kGrid);
    }
    for (const Tick& tick : y_ticks) {
      const double row = Row(y_(tick.value));
      overlay_.AddPolyline({{frame_.left, row}, {frame_.right, row}}, thin, kGrid);
    }
    const double line = 1.5 * unit_;
    overlay_.AddPolyline({{frame_.left, frame_.top}, {frame_.left, frame_.bottom}}, line, kInk);
    overlay_.AddPolyline({{frame_.left, frame_.bottom}, {frame_.right, frame_.bottom}}, line, kInk);
    if (has_right_) overlay_.AddPolyline({{frame_.right, frame_.top}, {frame_.right, frame_.bottom}}, line, kInk);

    const auto tick_length = [&](const Tick& tick) { return (tick.text.empty() ? 4 : 7) * unit_; };
    for (const Tick& tick : x_ticks) {
      const double column = Column(x_(tick.value));
      overlay_.AddPolyline({{column, frame_.bottom}, {column, frame_.bottom + tick_length(tick)}}, line, kInk);
      overlay_.AddText(tick.text, column, frame_.bottom + 10 * unit_, {small_, kInk, false, Align::kCentre});
    }
    for (const Tick& tick : y_ticks) {
      const double row = Row(y_(tick.value));
      overlay_.AddPolyline({{frame_.left - tick_length(tick), row}, {frame_.left, row}}, line, kInk);
      overlay_.AddText(tick.text, frame_.left - 11 * unit_, row - 0.42 * small_, {small_, kInk, false, Align::kRight});
    }
    for (const Tick& tick : right_ticks) {
      const double row = Row(right_(tick.value));
      overlay_.AddPolyline({{frame_.right, row}, {frame_.right + tick_length(tick), row}}, line, kInk);
      overlay_.AddText(tick.text, frame_.right + 11 * unit_, row - 0.42 * small_, {small_, kInk});
    }
    const double middle_row = 0.5 * (frame_.top + frame_.bottom);
    overlay_.AddText(spec_.x.label, 0.5 * (frame_.left + frame_.right), spec_.height - 24 * unit_ - text_,
                     {text_, kInk, false, Align::kCentre});
    overlay_.AddText(spec_.y.label, 24 * unit_, middle_row, {text_, kInk, false, Align::kCentre, true});
    if (has_right_) {
      overlay_.AddText(spec_.y_right.label, spec_.width - 24 * unit_ - 1.1 * text_, middle_row,
                       {text_, kInk, false, Align::kCentre, true});
    }
  }

  void DrawSeries(const PlotSeries& series, const Rgb8& colour) {
    const Scale& y = series.right_axis ? right_ : y_;
    std::vector<OverlayPoint> markers;
    std::vector<OverlayPoint> line;
    const auto finish_line = [&] {
      if (line.size() > 1) AddLine(line, series, series.width, colour);
      line.clear();
    };
    bool has_last = false;
    OverlayPoint last{};
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!x_.Takes(series.x[i]) || !y.Takes(series.y[i])) {
        finish_line();
        has_last = false;
        continue;
      }
      const OverlayPoint p{Column(x_(series.x[i])), Row(y(series.y[i]))};
      const bool inside = p.column >= frame_.left - 1e-6 && p.column <= frame_.right + 1e-6 &&
                          p.row >= frame_.top - 1e-6 && p.row <= frame_.bottom + 1e-6;
      if (inside) markers.push_back(p);
      if (has_last && series.width > 0) {
        // Steps too small to be seen are passed over; long logs have many.
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
    AddMarkers(markers, series, colour);
  }

  // Through the points, dashed when the series asks for it.
  void AddLine(const std::vector<OverlayPoint>& points, const PlotSeries& series, double width, const Rgb8& colour) {
    if (series.dash <= 0) return overlay_.AddPolyline(points, width * unit_, colour);
    const double dash = std::max(1.0, series.dash * unit_);
    double walked = 0;  // of the present dash or gap
    bool on = true;
    std::vector<OverlayPoint> stroke{points.front()};
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const OverlayPoint& a = points[i];
      const OverlayPoint& b = points[i + 1];
      const double length = std::hypot(b.column - a.column, b.row - a.row);
      double at = 0;
      while (length - at >= dash - walked) {
        at += dash - walked;
        walked = 0;
        const double t = at / length;
        const OverlayPoint p{a.column + t * (b.column - a.column), a.row + t * (b.row - a.row)};
        if (on) {
          stroke.push_back(p);
          overlay_.AddPolyline(stroke, width * unit_, colour);
        }
        on = !on;
        stroke = {p};
      }
      walked += length - at;
      if (on) stroke.push_back(b);
    }
    if (on && stroke.size() > 1) overlay_.AddPolyline(stroke, width * unit_, colour);
  }

  void AddMarkers(const std::vector<OverlayPoint>& centres, const PlotSeries& series, const Rgb8& colour) {
    if (series.marker > 0) overlay_.AddDiscs(centres, series.marker * unit_, colour);
  }

  void DrawNotes() {
    for (const PlotNote& note : spec_.notes) {
      if (!x_.Takes(note.x) || !y_.Takes(note.y)) continue;
      const TextStyle style{text_, note.colour.value_or(kInk), note.bold, note.align};
      const Overlay::Size size = overlay_.MeasureText(note.text, style);
      const double column = Column(x_(note.x));
      const double top = Row(y_(note.y)) - 0.5 * size.height;
      const double before = note.align == Align::kLeft ? 0 : note.align == Align::kCentre ? 0.5 : 1;
      const double rim = 0.15 * text_;
      overlay_.AddBox(column - before * size.width - rim, top - rim, size.width + 2 * rim, size.height + 2 * rim,
                      {255, 255, 255}, 0.8);
      overlay_.AddText(note.text, column, top, style);
    }
  }

  const PlotSpec& spec_;
  Overlay overlay_;
  double unit_;
  int text_;
  int small_;
  int title_;
  Scale x_, y_, right_;
  bool has_right_ = false;
  PlotFrame frame_{};
};

}  // namespace

Image RenderPlot(const PlotSpec& spec, PlotFrame* frame) {
  constexpr int kSmallest = 200;
  constexpr int kLargest = 8192;
  if (std::min(spec.width, spec.height) < kSmallest || std::max(spec.width, spec.height) > kLargest) {
    throw Error(fmt::format("a plot of {} x {} pixels can't be drawn; each side must be {} to {}", spec.width,
                            spec.height, kSmallest, kLargest));
  }
  OffscreenWindow offscreen(spec.width * kSupersampling, spec.height * kSupersampling);
  const vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  offscreen.window().AddRenderer(renderer);
  const PlotFrame drawn = PlotDrawing(spec, *renderer).Draw();
  if (frame != nullptr) *frame = drawn;
  return offscreen.Draw(kSupersampling);
}

void WritePlot(const PlotSpec& spec, const std::string& path) {
  WritePng(RenderPlot(spec), path);
}

}  // namespace kerf
