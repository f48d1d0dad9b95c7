// Conversion of kerf's meshes to VTK. For the view group only.
#pragma once

#include "kerf/geometry.h"

class vtkPolyData;
template <class T>
class vtkSmartPointer;

namespace kerf {

/// Converts a mesh, with points in double precision. Point ids keep their order.
vtkSmartPointer<vtkPolyData> MakePolyData(const TriangleMesh& mesh);
/// Stops VTK from writing to stderr; kerf detects failures from return values instead. May be called by any thread, any
/// number of times.
void QuietVtk();

}  // namespace kerf
