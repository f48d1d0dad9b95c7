#include "view/picture/vtk_scene.h"

#include <vtkActor.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkAppendPolyData.h>
#include <vtkAssembly.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProp3DCollection.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>

#include "bone/mesh/creases.h"
#include "view/picture/vtk_mesh.h"

namespace kerf {

void SetColour(vtkProperty& property, const Rgb8& colour) {
  property.SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
}

void SetPointColours(vtkPolyData& data, const std::vector<Rgb8>& colours) {
  const vtkNew<vtkUnsignedCharArray> values;
  values->SetName("colours");
  values->SetNumberOfComponents(3);
  values->SetNumberOfTuples(static_cast<vtkIdType>(colours.size()));
  for (std::size_t i = 0; i < colours.size(); ++i) {
    values->SetTypedTuple(static_cast<vtkIdType>(i), colours[i].data());
  }
  data.GetPointData()->SetScalars(values);
}

vtkSmartPointer<vtkPolyData> MakeCreasedPolyData(const TriangleMesh& mesh, std::span<const Rgb8> colours) {
  const CreasedMesh creased = SplitAtCreases(mesh);
  auto data = MakePolyData(creased.mesh);
  const vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  normals->SetNumberOfTuples(static_cast<vtkIdType>(creased.normals.size()));
  for (std::size_t i = 0; i < creased.normals.size(); ++i) {
    normals->SetTypedTuple(static_cast<vtkIdType>(i), &creased.normals[i].x);
  }
  data->GetPointData()->SetNormals(normals);
  if (!colours.empty()) {
    std::vector<Rgb8> of_points(colours.begin(), colours.end());
    for (const std::uint32_t p : creased.repeated) of_points.push_back(colours[p]);
    SetPointColours(*data, of_points);
  }
  return data;
}

void AddCameraLights(vtkRenderer& renderer, const std::array<double, 4>& intensities) {
  renderer.RemoveAllLights();
  renderer.AutomaticLightCreationOff();
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight();
    light->SetPosition(kCameraLights[i].x, kCameraLights[i].y, kCameraLights[i].z);
    light->SetFocalPoint(0, 0, 0);
    light->SetIntensity(intensities[i]);
    light->SetPositional(false);
    renderer.AddLight(light);
  }
}

vtkSmartPointer<vtkAnnotatedCubeActor> MakeOrientationCube(const OrientationCubeLook& look) {
  auto cube = vtkSmartPointer<vtkAnnotatedCubeActor>::New();
  cube->SetXPlusFaceText(look.patient ? "L" : "x");
  cube->SetXMinusFaceText(look.patient ? "R" : "-x");
  cube->SetYPlusFaceText(look.patient ? "P" : "y");
  cube->SetYMinusFaceText(look.patient ? "A" : "-y");
  cube->SetZPlusFaceText(look.patient ? "S" : "z");
  cube->SetZMinusFaceText(look.patient ? "I" : "-z");
  cube->SetFaceTextScale(look.patient ? 0.62 : 0.5);
  cube->SetZFaceTextRotation(-90);
  cube->GetTextEdgesProperty()->SetOpacity(0);
  cube->GetCubeProperty()->SetColor(look.side[0], look.side[1], look.side[2]);
  cube->GetCubeProperty()->SetAmbient(look.ambient);
  cube->GetCubeProperty()->SetDiffuse(look.diffuse);
  for (vtkProperty* face :
       {cube->GetXPlusFaceProperty(), cube->GetXMinusFaceProperty(), cube->GetYPlusFaceProperty(),
        cube->GetYMinusFaceProperty(), cube->GetZPlusFaceProperty(), cube->GetZMinusFaceProperty()}) {
    face->SetColor(look.letter[0], look.letter[1], look.letter[2]);
    face->SetInterpolationToFlat();
  }
  return cube;
}

vtkSmartPointer<vtkActor> MergeOrientationCube(vtkAnnotatedCubeActor& cube) {
  cube.HasTranslucentPolygonalGeometry();  // moves the parts to their places
  const vtkNew<vtkAppendPolyData> all;
  vtkProp3DCollection& parts = *cube.GetAssembly()->GetParts();
  parts.InitTraversal();
  while (auto* part = vtkActor::SafeDownCast(parts.GetNextProp3D())) {
    vtkProperty& property = *part->GetProperty();
    auto* mapper = vtkPolyDataMapper::SafeDownCast(part->GetMapper());
    if (mapper == nullptr || property.GetOpacity() == 0) continue;
    mapper->Update();
    const vtkNew<vtkTransform> transform;
    transform->SetMatrix(part->GetMatrix());
    const vtkNew<vtkTransformPolyDataFilter> moved;
    moved->SetTransform(transform);
    moved->SetInputData(mapper->GetInput());
    moved->Update();
    vtkPolyData& data = *moved->GetOutput();
    Rgb8 colour{};
    for (int i = 0; i < 3; ++i) {
      colour[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(255 * property.GetColor()[i]));
    }
    SetPointColours(data, std::vector<Rgb8>(static_cast<std::size_t>(data.GetNumberOfPoints()), colour));
    all->AddInputData(&data);
  }
  all->Update();
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(all->GetOutput());
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->ForceOpaqueOn();
  vtkProperty& property = *actor->GetProperty();
  property.SetInterpolationToFlat();
  property.SetAmbient(cube.GetCubeProperty()->GetAmbient());
  property.SetDiffuse(cube.GetCubeProperty()->GetDiffuse());
  property.BackfaceCullingOn();
  return actor;
}

}  // namespace kerf
