#include "mesh/vtk_mesh.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <mutex>

#include "kerf/error.h"

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
  QuietVtk();  // what there is no memory for is said by an exception too
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

TriangleMesh MakeTriangleMesh(vtkPolyData& data, const std::string& what) {
  TriangleMesh mesh;
  const vtkIdType point_count = data.GetNumberOfPoints();
  mesh.points.resize(static_cast<std::size_t>(point_count));
  for (vtkIdType i = 0; i < point_count; ++i) {
    double p[3];
    data.GetPoint(i, p);
    mesh.points[static_cast<std::size_t>(i)] = {p[0], p[1], p[2]};
  }
  mesh.triangles.reserve(static_cast<std::size_t>(data.GetNumberOfPolys()));
  const auto cells = vtk::TakeSmartPointer(data.GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    cells->GetCurrentCell(size, ids);
    if (size != 3) continue;
    for (int i = 0; i < 3; ++i) {
      if (ids[i] < 0 || ids[i] >= point_count) {
        throw Error(fmt::format("{}: triangle {} names point {}, but there are {} points", what,
                                mesh.triangles.size() + 1, ids[i], point_count));
      }
    }
    mesh.triangles.push_back(
        {static_cast<std::uint32_t>(ids[0]), static_cast<std::uint32_t>(ids[1]), static_cast<std::uint32_t>(ids[2])});
  }
  return mesh;
}

}  // namespace kerf
