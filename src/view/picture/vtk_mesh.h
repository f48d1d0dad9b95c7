// kerf's meshes for VTK. For the view group only.
#pragma once

#include "kerf/geometry.h"

class vtkPolyData;
template <class T>
class vtkSmartPointer;

namespace kerf {

/// Points in double precision. Ids keep their order.
vtkSmartPointer<vtkPolyData> MakePolyData(const TriangleMesh& mesh);
/// From here on VTK writes nothing to stderr; failures are found from what it returns. Any thread, any number of times.
void QuietVtk();

}  // namespace kerf
