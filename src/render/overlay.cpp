#include "render/overlay.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

namespace kerf {
namespace {

constexpr int kDpi = 72;  // a point is a pixel

void Apply(const TextStyle& style, int supersampling, vtkTextProperty& property) {
  property.SetFontFamilyToArial();
  property.SetFontSize(style.size * supersampling);
  property.SetBold(style.bold ? 1 : 0);
  property.SetColor(style.colour[0] / 255.0, style.colour[1] / 255.0, style.colour[2] / 255.0);
  property.SetVerticalJustificationToTop();
  property.SetLineSpacing(1.15);
  if (style.align == Align::kLeft) property.SetJustificationToLeft();
  if (style.align == Align::kCentre) property.SetJustificationToCentered();
  if (style.align == Align::kRight) property.SetJustificationToRight();
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

void Overlay::AddText(const std::string& text, double column, double row, const TextStyle& style) {
  if (text.empty()) return;
  const vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  Apply(style, supersampling_, *actor->GetTextProperty());
  actor->SetPosition(column * supersampling_, (height_ - row) * supersampling_);
  renderer_.AddActor2D(actor);
}

void Overlay::AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) {
  const double x0 = left * supersampling_;
  const double x1 = (left + width) * supersampling_;
  const double y0 = (height_ - top - height) * supersampling_;
  const double y1 = (height_ - top) * supersampling_;
  const vtkNew<vtkPoints> points;
  points->InsertNextPoint(x0, y0, 0);
  points->InsertNextPoint(x1, y0, 0);
  points->InsertNextPoint(x1, y1, 0);
  points->InsertNextPoint(x0, y1, 0);
  const vtkNew<vtkCellArray> cells;
  cells->InsertNextCell({0, 1, 2, 3});
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  const vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(data);
  const vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  actor->GetProperty()->SetOpacity(opacity);
  renderer_.AddActor2D(actor);
}

}  // namespace kerf
