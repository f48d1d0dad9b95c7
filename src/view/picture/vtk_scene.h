// Parts of a VTK scene that still pictures and the live picture share. For the view group only.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kerf/geometry.h"
#include "view/picture/colours.h"

class vtkActor;
class vtkAnnotatedCubeActor;
class vtkPolyData;
class vtkProperty;
class vtkRenderer;
template <class T>
class vtkSmartPointer;

namespace kerf {

void SetColour(vtkProperty& property, const Rgb8& colour);
/// `colours`: one for each point.
void SetPointColours(vtkPolyData& data, const std::vector<Rgb8>& colours);
/// Converts a mesh and the colours of its points (may be empty), with normals that are smooth on smooth surfaces and
/// creased where the bone was cut. Points at creases are repeated at the end.
vtkSmartPointer<vtkPolyData> MakeCreasedPolyData(const TriangleMesh& mesh, std::span<const Rgb8> colours);

/// Towards a key light at the upper left, two fill lights at the right and in front, and a rim light below, relative to
/// the camera: right, up, towards the viewer. Not normalised.
inline constexpr std::array<Vec3, 4> kCameraLights = {
    {{-0.5, 0.7, 1.2}, {0.9, 0.0, 1.0}, {0.0, 0.0, 1.0}, {0.2, -0.9, 0.3}}};
/// Adds these lights, fixed to the camera, so that all views are lit equally.
void AddCameraLights(vtkRenderer& renderer, const std::array<double, 4>& intensities);

/// Colours from 0 to 1 and fractions of the light.
struct OrientationCubeLook {
  bool patient = true;  // letters of the patient's sides; false: axes
  std::array<double, 3> side;
  std::array<double, 3> letter;
  double ambient;
  double diffuse;
};

/// Returns a cube whose faces show the patient's sides (L and R left and right, A and P front and back, S and I up and
/// down), or the axes.
vtkSmartPointer<vtkAnnotatedCubeActor> MakeOrientationCube(const OrientationCubeLook& look);
/// Returns the faces and letters of a cube as one actor, which is drawn in a tenth of the time.
vtkSmartPointer<vtkActor> MergeOrientationCube(vtkAnnotatedCubeActor& cube);

}  // namespace kerf
