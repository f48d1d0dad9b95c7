#include "view/picture/axes.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "view/picture/mm_grid.h"

namespace kerf {
namespace {

constexpr double kAlong = 0.02;  // below this cosine, directions count as along the line of sight

Vec3 AxisVector(int axis) {
  Vec3 v{0};
  v[axis] = 1;
  return v;
}

}  // namespace

PatientAxes::PatientAxes(const Box3& box_W, const ViewFrame& frame, const Layout& layout, bool dark)
    : box_W_(box_W), frame_(frame), layout_(layout), dark_(dark) {
  const MmGrid grid = ChooseMmGrid(frame.pixels_per_mm, 16 * layout.unit, 48 * layout.unit);
  line_mm_ = grid.line_mm;
  number_mm_ = grid.number_mm;
}

bool PatientAxes::IsSeenAlong(int axis) const {
  return 1 - std::abs(frame_.toward_eye_W[axis]) < kAlong * kAlong;
}

// Lists the lines on those of the three back faces that are not seen edge-on.
std::vector<PatientAxes::Line> PatientAxes::ListLines() const {
  std::vector<Line> lines;
  for (int normal = 0; normal < 3; ++normal) {
    if (std::abs(frame_.toward_eye_W[normal]) < kAlong) continue;
    const double face = frame_.toward_eye_W[normal] > 0 ? box_W_.lower[normal] : box_W_.upper[normal];
    for (const int across : {(normal + 1) % 3, (normal + 2) % 3}) {
      const int along = 3 - normal - across;
      for (const double mm : ListMultiples(line_mm_, box_W_.lower[across], box_W_.upper[across])) {
        Line line{Vec3{0}, Vec3{0}, IsMultiple(mm, number_mm_)};
        for (Vec3* end : {&line.from_W, &line.to_W}) (*end)[normal] = face, (*end)[across] = mm;
        line.from_W[along] = box_W_.lower[along];
        line.to_W[along] = box_W_.upper[along];
        lines.push_back(line);
      }
    }
  }
  return lines;
}

void PatientAxes::AddGrid(vtkRenderer& scene) const {
  for (const bool strong : {false, true}) {
    const vtkNew<vtkPoints> points;
    const vtkNew<vtkCellArray> cells;
    for (const Line& line : ListLines()) {
      if (line.strong != strong) continue;
      cells->InsertNextCell(2);
      for (const Vec3& p : {line.from_W, line.to_W}) cells->InsertCellPoint(points->InsertNextPoint(p.x, p.y, p.z));
    }
    const vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetLines(cells);
    const vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    const vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    const double grey = dark_ ? (strong ? 0.55 : 0.35) : (strong ? 0.55 : 0.8);
    actor->GetProperty()->SetColor(grey, grey, grey);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetLineWidth(static_cast<float>(std::max(1.0, layout_.unit)));
    scene.AddActor(actor);
  }
}

void PatientAxes::AddNumbers(Overlay& overlay) const {
  const bool along = IsSeenAlong(0) || IsSeenAlong(1) || IsSeenAlong(2);
  if (along) {
    for (const Line& line : ListLines()) {
      const auto from = frame_.Project(line.from_W);
      const auto to = frame_.Project(line.to_W);
      overlay.AddPolyline({{from.column, from.row}, {to.column, to.row}}, std::max(1.0, layout_.unit), {0, 114, 178},
                          line.strong ? 0.5 : 0.15);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!IsSeenAlong(axis)) AddNumbersOf(axis, overlay);
  }
}

// Adds the numbers along one of the four edges of the box parallel to the axis: an edge of the outline, at the bottom
// or on the left.
void PatientAxes::AddNumbersOf(int axis, Overlay& overlay) const {
  const int b = (axis + 1) % 3;
  const int c = (axis + 2) % 3;
  const bool upright = std::abs(frame_.up_W[axis]) > std::abs(frame_.right_W[axis]);
  const auto middle_of = [&](bool b_upper, bool c_upper) {
    Vec3 p_W = box_W_.centre();
    p_W[b] = b_upper ? box_W_.upper[b] : box_W_.lower[b];
    p_W[c] = c_upper ? box_W_.upper[c] : box_W_.lower[c];
    return p_W;
  };
  Vec3 best_W{0};
  double best = -std::numeric_limits<double>::infinity();
  for (int edge = 0; edge < 4; ++edge) {
    const bool b_upper = (edge & 1) != 0;
    const bool c_upper = (edge & 2) != 0;
    // For an edge of the outline, one of its faces points towards the eye and one away; a face seen edge-on counts as
    // either.
    const double toward_b = (b_upper ? 1 : -1) * frame_.toward_eye_W[b];
    const double toward_c = (c_upper ? 1 : -1) * frame_.toward_eye_W[c];
    if (toward_b * toward_c > kAlong * kAlong) continue;
    const Vec3 p_W = middle_of(b_upper, c_upper);
    const ViewFrame::Pixel at = frame_.Project(p_W);
    const double score = upright ? -at.column : at.row;
    if (score > best) best = score, best_W = p_W;
  }
  const ViewFrame::Pixel middle = frame_.Project(best_W);
  // The outward direction, perpendicular to the edge.
  const ViewFrame::Pixel ahead = frame_.Project(best_W + AxisVector(axis));
  double out_column = -(ahead.row - middle.row);
  double out_row = ahead.column - middle.column;
  const double length = std::hypot(out_column, out_row);
  const double side = (upright ? -out_column : out_row) < 0 ? -1 : 1;
  out_column *= side / length, out_row *= side / length;

  const Rgb8 ink = dark_ ? Rgb8{230, 230, 230} : Rgb8{33, 37, 43};
  const Rgb8 soft = dark_ ? Rgb8{190, 194, 200} : Rgb8{85, 92, 102};
  const TextStyle number{layout_.small_size, ink};
  const bool oblique = !IsSeenAlong(b) && !IsSeenAlong(c);
  const double tick = 6 * layout_.unit;
  const double line_width = std::max(1.0, 1.3 * layout_.unit);
  const auto put = [&](const std::string& text, const ViewFrame::Pixel& at, double distance, const TextStyle& style) {
    const Overlay::Size size = overlay.MeasureText(text, style);
    const double reach = 0.5 * (std::abs(out_column) * size.width + std::abs(out_row) * size.height);
    const double column = at.column + (distance + reach) * out_column;
    const double row = at.row + (distance + reach) * out_row;
    overlay.AddText(text, column - 0.5 * size.width, style.upward ? row : row - 0.5 * size.height, style);
  };
  Vec3 from_W = best_W;
  Vec3 to_W = best_W;
  from_W[axis] = box_W_.lower[axis];
  to_W[axis] = box_W_.upper[axis];
  const ViewFrame::Pixel from = frame_.Project(from_W);
  const ViewFrame::Pixel to = frame_.Project(to_W);
  overlay.AddPolyline({{from.column, from.row}, {to.column, to.row}}, line_width, ink);
  for (const double mm : ListMultiples(number_mm_, box_W_.lower[axis], box_W_.upper[axis])) {
    Vec3 p_W = best_W;
    p_W[axis] = mm;
    const ViewFrame::Pixel at = frame_.Project(p_W);
    overlay.AddPolyline({{at.column, at.row}, {at.column + tick * out_column, at.row + tick * out_row}}, line_width,
                        ink);
    // Where two axes meet at a corner, their numbers would overlap.
    const double to_end = std::min(mm - box_W_.lower[axis], box_W_.upper[axis] - mm) / number_mm_;
    if (oblique && to_end < 0.3) continue;
    put(fmt::format("{:g}", mm + 0.0), at, 1.4 * tick, number);
  }
  TextStyle name{layout_.text_size, soft};
  name.upward = upright;
  if (upright) name.align = Align::kCentre;
  const double clear = 1.4 * tick + (upright ? 2.6 : 1.3) * layout_.small_size;
  put(NamePatientAxis(axis), middle, clear, name);
}

}  // namespace kerf
