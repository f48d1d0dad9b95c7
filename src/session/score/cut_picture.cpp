#include "session/score/cut_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

#include "session/score/columns.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

/// Fraction of a cell's volume below which it is rounding.
constexpr double kRemovedFraction = 0.02;
/// Free space around what is shown, and the largest distance from the wanted cut that is shown.
constexpr double kAround_mm = 2;
constexpr double kFurthest_mm = 25;
/// Spacing of the samples of the bone's outline.
constexpr double kBoneStep_mm = 0.4;
constexpr double kBoneAbove_mm = 15;
/// Space around the shown part in which the bone's outline is made.
constexpr double kBoneAround_mm = 15;
constexpr Rgb8 kWantedColour{0, 114, 178};
constexpr Rgb8 kMadeColour{213, 94, 0};
constexpr Rgb8 kBoneLineColour{140, 140, 140};
/// Pixels of a plot beside and above its axes: estimate for the first pass; the second pass uses the real ones.
constexpr int kSideHeight = 400;

struct Interval {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();

  void Include(double x) {
    lower = std::min(lower, x);
    upper = std::max(upper, x);
  }
  bool empty() const { return upper < lower; }
};

/// Values at the points of a regular grid; outlines surround negative values.
class Field {
 public:
  Field(const Interval& x, const Interval& y, double step_mm)
      : x0_(x.lower),
        y0_(y.lower),
        step_mm_(step_mm),
        columns_(static_cast<int>(std::ceil((x.upper - x.lower) / step_mm)) + 1),
        rows_(static_cast<int>(std::ceil((y.upper - y.lower) / step_mm)) + 1),
        values_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), step_mm) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double x(int i) const { return x0_ + i * step_mm_; }
  double y(int k) const { return y0_ + k * step_mm_; }
  double& At(int i, int k) {
    return values_[static_cast<std::size_t>(k) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i)];
  }
  double At(int i, int k) const { return const_cast<Field&>(*this).At(i, k); }
  int Column(double x) const { return static_cast<int>(std::lround((x - x0_) / step_mm_)); }
  int Row(double y) const { return static_cast<int>(std::lround((y - y0_) / step_mm_)); }

  /// Returns the lines where the value is 0. Lines that do not reach the border are closed.
  std::vector<PictureLine> FindOutlines() const;

 private:
  /// Returns the number of the edge from a point to the right (`up` false) or upwards.
  int EdgeNumber(int i, int k, bool up) const { return 2 * (k * columns_ + i) + (up ? 1 : 0); }
  PicturePoint PointOf(int edge) const;

  double x0_;
  double y0_;
  double step_mm_;
  int columns_;
  int rows_;
  std::vector<double> values_;
};

PicturePoint Field::PointOf(int edge) const {
  const bool up = edge % 2 == 1;
  const int i = edge / 2 % columns_;
  const int k = edge / 2 / columns_;
  const double a = At(i, k);
  const double b = up ? At(i, k + 1) : At(i + 1, k);
  const double t = a / (a - b);
  return {x(i) + (up ? 0 : t * step_mm_), y(k) + (up ? t * step_mm_ : 0)};
}

std::vector<PictureLine> Field::FindOutlines() const {
  // Each segment joins two edges of a cell; an edge belongs to at most two segments.
  std::unordered_map<int, std::array<int, 2>> next;
  std::vector<int> order;
  const auto join = [&](int from, int to) {
    auto [at, is_new] = next.try_emplace(from, std::array<int, 2>{-1, -1});
    if (is_new) order.push_back(from);
    at->second[at->second[0] < 0 ? 0 : 1] = to;
  };
  for (int k = 0; k + 1 < rows_; ++k) {
    for (int i = 0; i + 1 < columns_; ++i) {
      const std::array<bool, 4> in{At(i, k) < 0, At(i + 1, k) < 0, At(i + 1, k + 1) < 0, At(i, k + 1) < 0};
      const std::array<int, 4> edges{EdgeNumber(i, k, false), EdgeNumber(i + 1, k, true), EdgeNumber(i, k + 1, false),
                                     EdgeNumber(i, k, true)};
      std::array<int, 4> crossed{};
      std::size_t count = 0;
      for (std::size_t e = 0; e < 4; ++e) {
        if (in[e] != in[(e + 1) % 4]) crossed[count++] = edges[e];
      }
      for (std::size_t n = 0; n + 1 < count; n += 2) {
        join(crossed[n], crossed[n + 1]);
        join(crossed[n + 1], crossed[n]);
      }
    }
  }
  std::vector<PictureLine> lines;
  const auto follow = [&](int first) {
    PictureLine line;
    for (int at = first; at >= 0;) {
      line.push_back(PointOf(at));
      std::array<int, 2>& ways = next.at(at);
      const int to = ways[0] >= 0 ? ways[0] : ways[1];
      (ways[0] >= 0 ? ways[0] : ways[1]) = -1;
      if (to < 0) break;
      std::array<int, 2>& back = next.at(to);
      (back[0] == at ? back[0] : back[1]) = -1;
      at = to;
    }
    if (line.size() > 1) lines.push_back(std::move(line));
  };
  // Lines that end at the border first, then closed ones.
  for (const int edge : order) {
    const std::array<int, 2>& ways = next.at(edge);
    if (ways[0] >= 0 && ways[1] < 0) follow(edge);
  }
  for (const int edge : order) {
    while (next.at(edge)[0] >= 0 || next.at(edge)[1] >= 0) follow(edge);
  }
  return lines;
}

/// Projection of the cut's frame {s, t, w} onto a picture: `up` is the axis that is shown upwards, with its sign, and
/// `through` the one that is looked along.
struct Projection {
  int up;
  double sign;
  int through;

  double Up(const Vec3& stw) const { return sign * stw[up]; }
  Vec3 Point(double x, double y, double z) const {
    Vec3 stw(0);
    stw.x = x;
    stw[up] = sign * y;
    stw[through] = z;
    return stw;
  }
};
constexpr Projection kAboveView{2, 1, 1};
constexpr Projection kSideView{1, -1, 2};

using Solid = std::function<double(const Vec3& stw)>;  // negative inside

/// Returns the outlines of the projection of a solid in a box. `is_part`: the solid goes on outside of the box, whose
/// border is then no outline.
std::vector<PictureLine> ProjectBox(const Projection& view, const Solid& solid, const Interval& s, const Interval& y,
                                    const Interval& z, double step_mm, bool is_part = false) {
  Field field(s, y, step_mm);
  const int steps = std::max(static_cast<int>(std::ceil((z.upper - z.lower) / step_mm)), 1);
  const int rim = is_part ? 0 : 1;
  for (int k = rim; k + rim < field.rows(); ++k) {
    for (int i = rim; i + rim < field.columns(); ++i) {
      double lowest = field.At(i, k);
      // A point so far inside has no outline beside it.
      for (int n = 0; n <= steps && lowest > -step_mm; ++n) {
        const double at = z.lower + (z.upper - z.lower) * n / steps;
        lowest = std::min(lowest, solid(view.Point(field.x(i), field.y(k), at)));
      }
      field.At(i, k) = lowest;
    }
  }
  return field.FindOutlines();
}

/// Returns the outlines of the projection of a solid near the given points, each of which is a cell of `h_mm`.
std::vector<PictureLine> ProjectCells(const Projection& view, const Solid& solid, const std::vector<Vec3>& cells,
                                      double h_mm) {
  Interval x, y;
  for (const Vec3& stw : cells) {
    x.Include(stw.x);
    y.Include(view.Up(stw));
  }
  if (x.empty()) return {};
  const double step_mm = 0.5 * h_mm;
  const double border_mm = 4 * h_mm;
  Field field({x.lower - border_mm, x.upper + border_mm}, {y.lower - border_mm, y.upper + border_mm}, step_mm);
  // Along each line of sight, the range of the cells near it.
  std::vector<Interval> ranges(static_cast<std::size_t>(field.columns()) * static_cast<std::size_t>(field.rows()));
  constexpr int kNear = 3;  // points on either side of a cell
  for (const Vec3& stw : cells) {
    const int i0 = field.Column(stw.x);
    const int k0 = field.Row(view.Up(stw));
    for (int k = std::max(k0 - kNear, 1); k <= std::min(k0 + kNear, field.rows() - 2); ++k) {
      for (int i = std::max(i0 - kNear, 1); i <= std::min(i0 + kNear, field.columns() - 2); ++i) {
        const auto at = static_cast<std::size_t>(k) * static_cast<std::size_t>(field.columns());
        ranges[at + static_cast<std::size_t>(i)].Include(stw[view.through]);
      }
    }
  }
  for (int k = 1; k + 1 < field.rows(); ++k) {
    for (int i = 1; i + 1 < field.columns(); ++i) {
      const Interval& range =
          ranges[static_cast<std::size_t>(k) * static_cast<std::size_t>(field.columns()) + static_cast<std::size_t>(i)];
      if (range.empty()) continue;
      double lowest = field.At(i, k);
      for (double z = range.lower - h_mm; z <= range.upper + h_mm; z += step_mm) {
        lowest = std::min(lowest, solid(view.Point(field.x(i), field.y(k), z)));
      }
      field.At(i, k) = lowest;
    }
  }
  return field.FindOutlines();
}

void IncludeLines(const std::vector<PictureLine>& lines, Interval& x, Interval& y) {
  for (const PictureLine& line : lines) {
    for (const PicturePoint& p : line) {
      x.Include(p.x_mm);
      y.Include(p.y_mm);
    }
  }
}

/// Sets the shown part: both cuts with some space around them.
void SetExtent(CutView& view) {
  Interval x, y;
  IncludeLines({view.line}, x, y);
  IncludeLines(view.wanted, x, y);
  const Interval wanted_x = x, wanted_y = y;
  IncludeLines(view.made, x, y);
  view.left_mm = std::max(x.lower, wanted_x.lower - kFurthest_mm) - kAround_mm;
  view.right_mm = std::min(x.upper, wanted_x.upper + kFurthest_mm) + kAround_mm;
  view.bottom_mm = std::max(y.lower, wanted_y.lower - kFurthest_mm) - kAround_mm;
  view.top_mm = std::min(y.upper, wanted_y.upper + kFurthest_mm) + kAround_mm;
}

/// Sets the outlines of the bone in what lies around the shown part, too, because a panel may be wider or higher than
/// it. An end of the bone that is near is shown.
void AddBone(const Projection& projection, const Solid& bone, const Interval& z, double step_mm, CutView& view) {
  const Interval x{view.left_mm - kBoneAround_mm, view.right_mm + kBoneAround_mm};
  const Interval y{view.bottom_mm - kBoneAround_mm,
                   std::min(view.top_mm + kBoneAround_mm, projection.through == 2 ? kBoneAbove_mm : 1e9)};
  view.bone = ProjectBox(projection, bone, x, y, z, step_mm, true);
  Interval ends, unused;
  IncludeLines(view.bone, ends, unused);
  if (ends.empty()) return;
  if (ends.lower > x.lower + step_mm) view.left_mm = std::min(view.left_mm, ends.lower - 1);
  if (ends.upper < x.upper - step_mm) view.right_mm = std::max(view.right_mm, ends.upper + 1);
}

/// Returns 1, 2 or 5 times a power of ten, at most a third of the length.
double CalcScaleBar(double length_mm) {
  const double power = std::pow(10.0, std::floor(std::log10(length_mm / 3)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= length_mm / 3) return digit * power;
  }
  return power;
}

PlotSeries MakeSeries(const std::string& label, const std::vector<PictureLine>& lines, const Rgb8& colour, double width,
                      double dash) {
  PlotSeries series;
  series.label = label;
  series.colour = colour;
  series.width = width;
  series.dash = dash;
  for (const PictureLine& line : lines) {
    for (const PicturePoint& p : line) {
      series.x.push_back(p.x_mm);
      series.y.push_back(p.y_mm);
    }
    series.x.push_back(std::numeric_limits<double>::quiet_NaN());
    series.y.push_back(std::numeric_limits<double>::quiet_NaN());
  }
  return series;
}

/// Returns the plot of a view, with the height that gives both axes the same scale.
PlotSpec MakeViewPlot(const CutView& view, const CutViewTexts& texts, int width) {
  PlotSpec plot;
  plot.width = width;
  plot.height = kSideHeight;
  plot.title = texts.title;
  plot.x.label = texts.x_label;
  plot.x.lower = view.left_mm;
  plot.x.upper = view.right_mm;
  plot.y.label = texts.y_label;
  plot.y.lower = view.bottom_mm;
  plot.y.upper = view.top_mm;
  if (!view.bone.empty()) plot.series.push_back(MakeSeries("", view.bone, kBoneLineColour, 1.5, 0));
  plot.series.push_back(MakeSeries(texts.wanted, view.wanted, kWantedColour, 2.5, 7));
  if (!view.made.empty()) plot.series.push_back(MakeSeries(texts.made, view.made, kMadeColour, 2.5, 0));
  // The frame around the axes does not depend on the height.
  PlotFrame frame{};
  FormatPlotSvg(plot, &frame);
  const double box_width = frame.right - frame.left;
  const double box_height = box_width * (view.top_mm - view.bottom_mm) / (view.right_mm - view.left_mm);
  const double around = plot.height - (frame.bottom - frame.top);
  plot.height = static_cast<int>(std::lround(around + box_height));
  plot.height = std::clamp(plot.height, static_cast<int>(kSheetSideRange.lower), 2 * width);
  // If the height was limited, the range is extended instead.
  FormatPlotSvg(plot, &frame);
  const double mm_per_pixel = (view.right_mm - view.left_mm) / (frame.right - frame.left);
  const double shown_mm = mm_per_pixel * (frame.bottom - frame.top);
  const double middle_mm = 0.5 * (view.top_mm + view.bottom_mm);
  if (shown_mm > view.top_mm - view.bottom_mm) {
    plot.y.lower = middle_mm - 0.5 * shown_mm;
    plot.y.upper = middle_mm + 0.5 * shown_mm;
  } else {
    const double wide_mm = (view.top_mm - view.bottom_mm) / (frame.bottom - frame.top) * (frame.right - frame.left);
    const double centre_mm = 0.5 * (view.left_mm + view.right_mm);
    plot.x.lower = centre_mm - 0.5 * wide_mm;
    plot.x.upper = centre_mm + 0.5 * wide_mm;
  }
  return plot;
}

}  // namespace

CutPicture MakeCutPicture(const Bone& before, const Bone& after, const WantedCut& cut,
                          std::span<const RemovedCell> cells) {
  const double h_mm = before.voxel_mm();
  const PhiSampler phi_before(before);
  const PhiSampler phi_after(after);
  const Solid removed = [&](const Vec3& stw) {
    const Vec3 p_W = cut.ToWorld(stw);
    return std::max(phi_before.Calc(p_W), -phi_after.Calc(p_W));
  };
  const Solid wanted = [&](const Vec3& stw) {
    const Vec3 p_W = cut.ToWorld(stw);
    return std::max(phi_before.Calc(p_W), cut.CalcDistance(p_W));
  };
  // From above, the rim of the kerf would hide its walls, and a level set rounds it.
  const auto without_skin = [&](const Solid& solid) -> Solid {
    return [&](const Vec3& stw) { return std::max(solid(stw), phi_before.Calc(cut.ToWorld(stw)) + h_mm); };
  };
  std::vector<Vec3> places;
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 > kRemovedFraction * h_mm * h_mm * h_mm) places.push_back(cut.ToCut(cell.p_W));
  }
  const Interval s{-cut.radius_mm - 3 * h_mm, cut.length_mm + cut.radius_mm + 3 * h_mm};
  const Interval t{-kAbove_mm, cut.depth_mm + 3 * h_mm};
  const double half_mm = 0.5 * cut.thickness_mm;
  const Interval w{-half_mm - 3 * h_mm, half_mm + 3 * h_mm};

  CutPicture picture;
  CutView& above = picture.above;
  above.line = {{0, 0}, {cut.length_mm, 0}};
  above.wanted = ProjectBox(kAboveView, without_skin(wanted), s, w, t, 0.5 * h_mm);
  above.made = ProjectCells(kAboveView, without_skin(removed), places, h_mm);
  SetExtent(above);
  const Solid bone = [&](const Vec3& stw) { return phi_before.Calc(cut.ToWorld(stw)); };
  AddBone(kAboveView, bone, {-kAbove_mm, cut.depth_mm + kAbove_mm}, kBoneStep_mm, above);

  CutView& side = picture.side;
  side.line = {{0, 0}, {cut.length_mm, 0}};
  side.wanted = ProjectBox(kSideView, wanted, s, {-t.upper, -t.lower}, {-half_mm, half_mm}, 0.5 * h_mm);
  side.made = ProjectCells(kSideView, removed, places, h_mm);
  SetExtent(side);
  AddBone(kSideView, bone, {0, 0}, 0.5 * kBoneStep_mm, side);
  picture.scale_bar_mm = CalcScaleBar(std::min(above.right_mm - above.left_mm, side.right_mm - side.left_mm));
  return picture;
}

CutViewTexts AboveTexts() {
  return {.title = "Your cut from above", .y_label = "beside (mm)"};
}

CutViewTexts SideTexts() {
  return {.title = "Your cut from the side", .y_label = "height (mm)"};
}

Image RenderCutView(const CutView& view, const CutViewTexts& texts, int width, PlotFrame* frame) {
  return RenderPlot(MakeViewPlot(view, texts, width), frame);
}

std::string FormatCutViewSvg(const CutView& view, const CutViewTexts& texts, int width, PlotFrame* frame) {
  const std::string svg = FormatPlotSvg(MakeViewPlot(view, texts, width), frame);
  std::string inner = svg.substr(svg.find("<svg"));
  // Inside a page of HTML, no namespace is needed.
  constexpr std::string_view kNamespace = " xmlns=\"http://www.w3.org/2000/svg\"";
  if (const std::size_t at = inner.find(kNamespace); at != std::string::npos) inner.erase(at, kNamespace.size());
  return inner;
}

}  // namespace kerf
