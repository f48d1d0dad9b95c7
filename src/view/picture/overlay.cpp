#include "view/picture/overlay.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>

namespace kerf {
namespace {

constexpr int kDpi = 72;  // makes a point equal a pixel

void Apply(const TextStyle& style, int supersampling, vtkTextProperty& property) {
  property.SetFontFamilyToArial();
  property.SetFontSize(style.size * supersampling);
  property.SetBold(style.bold ? 1 : 0);
  property.SetColor(style.colour[0] / 255.0, style.colour[1] / 255.0, style.colour[2] / 255.0);
  property.SetVerticalJustificationToTop();
  property.SetLineSpacing(1.15);
  property.SetOrientation(style.upward ? 90 : 0);
  if (style.align == Align::kLeft) property.SetJustificationToLeft();
  if (style.align == Align::kCentre) property.SetJustificationToCentered();
  if (style.align == Align::kRight) property.SetJustificationToRight();
}

// Polygons in pixels of the window, whose rows are counted from the bottom.
class Polygons {
 public:
  Polygons(int height, int supersampling) : height_(height), supersampling_(supersampling) {}

  void Add(std::initializer_list<OverlayPoint> corners) {
    cells_->InsertNextCell(static_cast<int>(corners.size()));
    for (const OverlayPoint& corner : corners) AddCorner(corner);
  }
  void AddDisc(const OverlayPoint& centre, double radius, int corners) {
    cells_->InsertNextCell(corners);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      AddCorner({centre.column + radius * std::cos(angle), centre.row + radius * std::sin(angle)});
    }
  }
  vtkSmartPointer<vtkPolyData> MakeData() const {
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points_);
    data->SetPolys(cells_);
    return data;
  }

 private:
  void AddCorner(const OverlayPoint& p) {
    cells_->InsertCellPoint(points_->InsertNextPoint(p.column * supersampling_, (height_ - p.row) * supersampling_, 0));
  }

  int height_;
  int supersampling_;
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
};

/// Fills `data` with the image, interpolated between the centres of the four surrounding pixels.
void Stretch(const Image& image, int columns, int rows, vtkImageData& data) {
  const auto place = [](int i, int count, int pixels, int& low, int& high) {
    const double at = std::clamp((i + 0.5) / count * pixels - 0.5, 0.0, pixels - 1.0);
    low = static_cast<int>(at);
    high = std::min(low + 1, pixels - 1);
    return at - low;
  };
  for (int row = 0; row < rows; ++row) {
    int upper = 0, lower = 0;
    const double down = place(row, rows, image.height, upper, lower);
    auto* out = static_cast<unsigned char*>(data.GetScalarPointer(0, rows - 1 - row, 0));  // VTK counts from the bottom
    for (int column = 0; column < columns; ++column) {
      int near = 0, far = 0;
      const double across = place(column, columns, image.width, near, far);
      for (std::size_t c = 0; c < 3; ++c) {
        const double above = image.At(near, upper)[c] * (1 - across) + image.At(far, upper)[c] * across;
        const double below = image.At(near, lower)[c] * (1 - across) + image.At(far, lower)[c] * across;
        *out++ = static_cast<unsigned char>(above * (1 - down) + below * down + 0.5);
      }
    }
  }
}

}  // namespace

Overlay::Size Overlay::MeasureText(const std::string& text, const TextStyle& style) const {
  const vtkNew<vtkTextProperty> property;
  Apply(style, supersampling_, *property);
  int box[4] = {0, 0, 0, 0};
  vtkTextRenderer::GetInstance()->GetBoundingBox(property, text, box, kDpi);
  return {static_cast<double>(box[1] - box[0] + 1) / supersampling_,
          static_cast<double>(box[3] - box[2] + 1) / supersampling_};
}

std::size_t Overlay::FindFitting(const std::string& word, double width, const TextStyle& style) const {
  const auto next = [&](std::size_t at) {
    for (++at; at < word.size() && (static_cast<unsigned char>(word[at]) & 0xc0U) == 0x80;) ++at;
    return at;
  };
  if (MeasureText(word, style).width <= width) return 0;
  std::size_t end = next(0);
  while (next(end) < word.size() && MeasureText(word.substr(0, next(end)), style).width <= width) end = next(end);
  return end < word.size() ? end : 0;
}

std::string Overlay::Wrap(const std::string& text, double width, const TextStyle& style) const {
  std::string wrapped;
  std::string line;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", from), text.size());
    const std::string word = text.substr(from, end - from);
    std::string longer = line;
    if (!line.empty()) longer += ' ';
    longer += word;
    const bool fits = MeasureText(longer, style).width <= width;
    if (!fits && !line.empty()) wrapped.append(line).append(1, '\n');
    line = fits ? longer : word;
    // A word that is too long by itself is divided, but not within a character of UTF-8.
    for (std::size_t cut = fits ? 0 : FindFitting(line, width, style); cut > 0; cut = FindFitting(line, width, style)) {
      wrapped.append(line, 0, cut).append(1, '\n');
      line.erase(0, cut);
    }
    if (end < text.size() && text[end] == '\n') wrapped.append(std::exchange(line, {})).append(1, '\n');
    from = end + 1;
  }
  return wrapped + line;
}

void Overlay::AddText(const std::string& text, double column, double row, const TextStyle& style) {
  if (text.empty()) return;
  const vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  Apply(style, supersampling_, *actor->GetTextProperty());
  actor->SetPosition(column * supersampling_, (height_ - row) * supersampling_);
  renderer_.AddActor2D(actor);
}

void Overlay::AddFlat(vtkPolyData& data, const Rgb8& colour, double opacity) {
  const vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(&data);
  const vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  actor->GetProperty()->SetOpacity(opacity);
  renderer_.AddActor2D(actor);
}

void Overlay::AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) {
  Polygons polygons(height_, supersampling_);
  polygons.Add({{left, top + height}, {left + width, top + height}, {left + width, top}, {left, top}});
  AddFlat(*polygons.MakeData(), colour, opacity);
}

void Overlay::AddPolyline(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double opacity) {
  Polygons polygons(height_, supersampling_);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const OverlayPoint& a = points[i];
    const OverlayPoint& b = points[i + 1];
    const double length = std::hypot(b.column - a.column, b.row - a.row);
    if (length <= 0) continue;
    const double x = 0.5 * width * (b.row - a.row) / length;
    const double y = -0.5 * width * (b.column - a.column) / length;
    polygons.Add(
        {{a.column + x, a.row + y}, {b.column + x, b.row + y}, {b.column - x, b.row - y}, {a.column - x, a.row - y}});
    if (i > 0) polygons.AddDisc(a, 0.5 * width, 8);
  }
  AddFlat(*polygons.MakeData(), colour, opacity);
}

void Overlay::AddImage(const Image& image, double left, double top, double width, double height) {
  const int columns = static_cast<int>(std::lround(width * supersampling_));
  const int rows = static_cast<int>(std::lround(height * supersampling_));
  const vtkNew<vtkImageData> data;
  data->SetDimensions(columns, rows, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  if (columns == image.width * supersampling_ && rows == image.height * supersampling_) {
    auto* out = static_cast<Rgb8*>(data->GetScalarPointer());
    for (int row = rows - 1; row >= 0; --row) {  // VTK counts from the bottom
      for (int column = 0; column < image.width; ++column) {
        out = std::fill_n(out, supersampling_, image.At(column, row / supersampling_));
      }
    }
  } else {
    Stretch(image, columns, rows, *data);
  }
  const vtkNew<vtkImageMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorWindow(255);
  mapper->SetColorLevel(127.5);
  const vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->SetPosition(left * supersampling_, (height_ - top - height) * supersampling_);
  renderer_.AddActor2D(actor);
}

void Overlay::AddPolygon(const std::vector<OverlayPoint>& corners, const Rgb8& colour) {
  OverlayPoint middle{0, 0};
  for (const OverlayPoint& corner : corners) {
    middle.column += corner.column / static_cast<double>(corners.size());
    middle.row += corner.row / static_cast<double>(corners.size());
  }
  // The polygon is drawn as triangles, because VTK does not fill non-convex polygons correctly.
  Polygons polygons(height_, supersampling_);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    polygons.Add({middle, corners[(i + 1) % corners.size()], corners[i]});
  }
  AddFlat(*polygons.MakeData(), colour, 1);
}

void Overlay::AddDiscs(const std::vector<OverlayPoint>& centres, double diameter, const Rgb8& colour) {
  Polygons polygons(height_, supersampling_);
  for (const OverlayPoint& centre : centres) polygons.AddDisc(centre, 0.5 * diameter, 24);
  AddFlat(*polygons.MakeData(), colour, 1);
}

}  // namespace kerf
