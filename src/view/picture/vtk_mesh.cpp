#include "view/picture/vtk_mesh.h"

#include <vtkCellArray.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <mutex>

namespace kerf {
namespace {

class SilentOutputWindow : public vtkOutputWindow {
 public:
  static SilentOutputWindow* New();
  void DisplayText(const char*) override {}

 protected:
  SilentOutputWindow() = default;
};
vtkStandardNewMacro(SilentOutputWindow)

}  // namespace

void QuietVtk() {
  static std::once_flag once;
  std::call_once(once, [] {
    const vtkNew<SilentOutputWindow> silent;
    vtkOutputWindow::SetInstance(silent);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  });
}

vtkSmartPointer<vtkPolyData> MakePolyData(const TriangleMesh& mesh) {
  QuietVtk();  // running out of memory is also reported by an exception
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    points->SetPoint(static_cast<vtkIdType>(i), p.x, p.y, p.z);
  }
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(mesh.triangles.size()),
                       3 * static_cast<vtkIdType>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) cells->InsertNextCell({vtkIdType{t[0]}, vtkIdType{t[1]}, vtkIdType{t[2]}});
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(cells);
  return data;
}

}  // namespace kerf
