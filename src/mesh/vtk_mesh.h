// Between kerf's meshes and VTK's. For mesh, render and report only.
#pragma once

#include <string>

#include "kerf/geometry.h"

class vtkPolyData;
template <class T>
class vtkSmartPointer;

namespace kerf {

/// Points in double precision. Ids keep their order.
vtkSmartPointer<vtkPolyData> MakePolyData(const TriangleMesh& mesh);
/// Triangles only; other cells are left out. Throws Error (beginning with `what`) when an index lies outside the
/// points.
TriangleMesh MakeTriangleMesh(vtkPolyData& data, const std::string& what);
/// From here on VTK writes nothing to stderr; failures are found from what it returns. Any thread, any number of times.
void QuietVtk();

}  // namespace kerf
