#include "mesh/decimate.h"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSmartPointer.h>

#include "kerf/error.h"
#include "mesh/vtk_mesh.h"

namespace kerf {

TriangleMesh Decimate(const TriangleMesh& mesh, std::size_t triangles) {
  if (triangles < 4) throw Error(fmt::format("a surface needs at least 4 triangles, but {} were asked for", triangles));
  if (mesh.triangles.size() <= triangles) return mesh;
  QuietVtk();
  const vtkNew<vtkQuadricDecimation> decimation;
  decimation->SetInputData(MakePolyData(mesh));
  decimation->SetTargetReduction(1.0 - static_cast<double>(triangles) / static_cast<double>(mesh.triangles.size()));
  decimation->VolumePreservationOn();
  decimation->Update();
  return MakeTriangleMesh(*decimation->GetOutput(), "decimated surface");
}

}  // namespace kerf
