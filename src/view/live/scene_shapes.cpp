#include "view/live/scene_shapes.h"

#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkUniforms.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <string>

#include "view/live/lamps.h"
#include "view/picture/colours.h"
#include "view/picture/picture.h"
#include "view/picture/vtk_mesh.h"
#include "view/picture/vtk_scene.h"

namespace kerf {
namespace {

// Follows MakeLampCode(). VTK's own code raises a number to a power for each lamp, which takes much of a picture's time
// without a graphics card.
constexpr const char* kLightCode = R"(
  vec3 toEye = normalize(-vertexVC.xyz);
  float light = 0.0;
  float shine = 0.0;
  for (int i = 0; i < 4; ++i) {
    float facing = dot(normalVCVSOutput, kLamps[i]);
    light += kPower[i] * max(0.0, facing);
    float x = max(0.0, dot(2.0 * facing * normalVCVSOutput - kLamps[i], toEye));
    float x2 = x * x;
    float x8 = x2 * x2 * x2 * x2;
    if (facing > 0.0) shine += kPower[i] * SHINY;
  }
  gl_FragData[0] = vec4(ambientColor + light * diffuseColor + shine * specularColor, opacity);
)";
constexpr const char* kShinyOfMetal = "x8 * x8 * x8 * x8 * x8";  // to the power of 40
constexpr const char* kShinyOfMatt = "x8 * x8 * x2";             // to the power of 18

// Returns two directions perpendicular to a normal.
std::array<Vec3, 2> Across(const Vec3& normal) {
  const Vec3 other = std::abs(normal.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = glm::normalize(glm::cross(normal, other));
  return {u, glm::cross(normal, u)};
}

}  // namespace

vtkSmartPointer<vtkActor> MakeMeshActor(const TriangleMesh& mesh, const Rgb8& colour, double opacity, Finish finish,
                                        const std::vector<Rgb8>* point_colours) {
  const vtkNew<vtkPolyDataMapper> mapper;
  const bool by_point = point_colours != nullptr && point_colours->size() == mesh.points.size();
  mapper->SetInputData(MakeCreasedPolyData(mesh, by_point ? *point_colours : std::vector<Rgb8>{}));
  mapper->SetScalarVisibility(by_point ? 1 : 0);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  // Translucent objects are drawn after everything behind them.
  if (opacity < 1) {
    actor->ForceTranslucentOn();
  } else {
    actor->ForceOpaqueOn();
  }
  vtkProperty& property = *actor->GetProperty();
  SetColour(property, colour);
  property.SetOpacity(opacity);
  property.SetInterpolationToPhong();
  property.SetAmbient(finish == Finish::kFlat ? 1 : 0.22);
  property.SetDiffuse(finish == Finish::kFlat ? 0 : 0.84);
  property.SetSpecular(finish == Finish::kMetal ? 0.4 : finish == Finish::kMatt ? 0.06 : 0);
  if (finish != Finish::kFlat) {
    std::string code = MakeLampCode() + kLightCode;
    code.replace(code.find("SHINY"), 5, finish == Finish::kMetal ? kShinyOfMetal : kShinyOfMatt);
    actor->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Light::Impl", true, code, false);
  }
  return actor;
}

std::vector<std::vector<Vec3>> MakeBoxEdges(const Box3& box) {
  const auto corner = [&](int i) {
    return Vec3{(i & 1) != 0 ? box.upper.x : box.lower.x, (i & 2) != 0 ? box.upper.y : box.lower.y,
                (i & 4) != 0 ? box.upper.z : box.lower.z};
  };
  std::vector<std::vector<Vec3>> edges;
  for (int i = 0; i < 8; ++i) {
    for (const int axis : {1, 2, 4}) {
      if ((i & axis) == 0) edges.push_back({corner(i), corner(i | axis)});
    }
  }
  return edges;
}

vtkSmartPointer<vtkActor> MakeLineActor(const std::vector<std::vector<Vec3>>& lines, const Rgb8& colour,
                                        double width_px) {
  const vtkNew<vtkPoints> points;
  const vtkNew<vtkCellArray> cells;
  for (const std::vector<Vec3>& line : lines) {
    cells->InsertNextCell(static_cast<int>(line.size()));
    for (const Vec3& p : line) cells->InsertCellPoint(points->InsertNextPoint(p.x, p.y, p.z));
  }
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->ForceOpaqueOn();
  SetColour(*actor->GetProperty(), colour);
  actor->GetProperty()->SetLineWidth(static_cast<float>(width_px));
  actor->GetProperty()->LightingOff();
  return actor;
}

vtkSmartPointer<vtkActor> MakeBlurActor(const ToolBlur& blur) {
  constexpr int kSectors = 120;
  constexpr double kAlpha[3] = {225, 150, 60};
  const double radii[3] = {blur.from_mm, 0.5 * (blur.from_mm + blur.to_mm), blur.to_mm};
  const vtkNew<vtkPoints> points;
  const vtkNew<vtkCellArray> cells;
  const vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(4);
  for (int side = 0; side < 2; ++side) {
    const double z = (side == 0 ? -1 : 1) * blur.half_thickness_mm;
    const vtkIdType first = points->GetNumberOfPoints();
    for (int ring = 0; ring < 3; ++ring) {
      for (int i = 0; i < kSectors; ++i) {
        const double angle = 2 * std::numbers::pi * i / kSectors;
        points->InsertNextPoint(radii[ring] * std::cos(angle), radii[ring] * std::sin(angle), z);
        colours->InsertNextTuple4(kSteelColour[0], kSteelColour[1], kSteelColour[2], kAlpha[ring]);
      }
    }
    for (int ring = 0; ring < 2; ++ring) {
      for (int i = 0; i < kSectors; ++i) {
        const vtkIdType a = first + ring * kSectors + i;
        const vtkIdType b = first + ring * kSectors + (i + 1) % kSectors;
        const vtkIdType quad[4] = {a, a + kSectors, b + kSectors, b};
        cells->InsertNextCell(4, quad);
      }
    }
  }
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetPointData()->SetScalars(colours);
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->ForceOpaqueOn();
  actor->GetProperty()->LightingOff();
  return actor;
}

std::vector<Vec3> MakeRectangle(const Vec3& middle, const Vec3& normal, const Vec3& up, double width, double height) {
  const Vec3 n = CalcDirection(normal).value_or(Vec3{0, 0, 1});
  Vec3 v = up - glm::dot(up, n) * n;
  v = glm::length(v) > 1e-6 ? glm::normalize(v) : Across(n)[0];
  const Vec3 u = glm::cross(v, n);
  const Vec3 a = 0.5 * width * u;
  const Vec3 b = 0.5 * height * v;
  return {middle - a - b, middle + a - b, middle + a + b, middle - a + b};
}

std::vector<Vec3> Closed(std::vector<Vec3> corners) {
  if (!corners.empty()) corners.push_back(corners.front());
  return corners;
}

TriangleMesh MakePolygon(const std::vector<Vec3>& corners) {
  TriangleMesh mesh;
  mesh.points = corners;
  for (std::uint32_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({0, i - 1, i});
  return mesh;
}

std::vector<Vec3> MakeCircle(const Vec3& middle, const Vec3& normal, double radius, int corners) {
  const auto [u, v] = Across(CalcDirection(normal).value_or(Vec3{0, 0, 1}));
  std::vector<Vec3> circle;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    circle.push_back(middle + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return circle;
}

TriangleMesh MakeArrowMesh(const Vec3& tail, const Vec3& tip, double shaft_radius) {
  const Vec3 along = tip - tail;
  const double length = glm::length(along);
  const Vec3 axis = length > 0 ? along / length : Vec3{0, 0, 1};
  const double head = std::min(8 * shaft_radius, 0.6 * length);
  const double rings[5][2] = {
      {0, 0}, {0, shaft_radius}, {length - head, shaft_radius}, {length - head, 3 * shaft_radius}, {length, 0}};
  constexpr std::uint32_t kSectors = 32;
  TriangleMesh mesh;
  for (const auto& ring : rings) {
    const std::vector<Vec3> circle = MakeCircle(tail + ring[0] * axis, axis, ring[1], kSectors);
    mesh.points.insert(mesh.points.end(), circle.begin(), circle.end());
  }
  for (std::uint32_t i = 0; i + 1 < std::size(rings); ++i) {
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const std::uint32_t a = i * kSectors + j;
      const std::uint32_t b = i * kSectors + (j + 1) % kSectors;
      mesh.triangles.push_back({a, b, b + kSectors});
      mesh.triangles.push_back({a, b + kSectors, a + kSectors});
    }
  }
  return mesh;
}

TriangleMesh MakeTubeMesh(const std::vector<Vec3>& points, double radius) {
  constexpr std::uint32_t kSectors = 20;
  std::vector<Vec3> line;
  for (const Vec3& p : points) {
    if (line.empty() || glm::length(p - line.back()) > 1e-6) line.push_back(p);
  }
  TriangleMesh mesh;
  if (line.size() < 2) return mesh;
  Vec3 u{0};
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec3 before = glm::normalize(i == 0 ? line[1] - line[0] : line[i] - line[i - 1]);
    const Vec3 after = i + 1 == line.size() ? before : glm::normalize(line[i + 1] - line[i]);
    const Vec3 along = CalcDirection(before + after).value_or(after);
    // The sections do not twist: each keeps the previous one's direction as far as possible.
    u = i == 0 ? Across(along)[0] : CalcDirection(u - glm::dot(u, along) * along).value_or(Across(along)[0]);
    const Vec3 v = glm::cross(along, u);
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const double angle = 2 * std::numbers::pi * j / kSectors;
      mesh.points.push_back(line[i] + radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  const auto last = static_cast<std::uint32_t>(line.size() - 1) * kSectors;
  for (std::uint32_t a = 0; a < last; ++a) {
    const std::uint32_t b = a % kSectors + 1 == kSectors ? a + 1 - kSectors : a + 1;
    mesh.triangles.push_back({a, b, b + kSectors});
    mesh.triangles.push_back({a, b + kSectors, a + kSectors});
  }
  for (std::uint32_t j = 2; j < kSectors; ++j) {
    mesh.triangles.push_back({0, j, j - 1});
    mesh.triangles.push_back({last, last + j - 1, last + j});
  }
  return mesh;
}

void AddSightHole(vtkActor& actor) {
  vtkShaderProperty& shader = *actor.GetShaderProperty();
  // hole_at: x, y and depth; hole: radius, strength and opacity in the middle.
  shader.AddFragmentShaderReplacement("//VTK::TCoord::Impl", true,  // follows that for the light
                                      "//VTK::TCoord::Impl\n"
                                      "  if (hole.y > 0.0 && gl_FragCoord.z < hole_at.z) {\n"
                                      "    float away = distance(gl_FragCoord.xy, hole_at.xy) / max(hole.x, 1.0);\n"
                                      "    float kept = mix(hole.z, 1.0, smoothstep(0.55, 1.0, away));\n"
                                      "    gl_FragData[0].a *= mix(1.0, kept, hole.y);\n"
                                      "  }\n",
                                      false);
  SetSightHole(actor, {});
}

void SetSightHole(vtkActor& actor, const SightHole& hole) {
  vtkUniforms& uniforms = *actor.GetShaderProperty()->GetFragmentCustomUniforms();
  const double at[3] = {hole.x_px, hole.y_px, hole.depth};
  const double values[3] = {hole.radius_px, hole.strength, hole.alpha};
  uniforms.SetUniform3f("hole_at", at);
  uniforms.SetUniform3f("hole", values);
}

void SetPose(vtkActor& actor, const Pose& X_WA) {
  const glm::dmat3 R = glm::mat3_cast(X_WA.R_AB);
  const vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix->SetElement(row, column, R[column][row]);
    matrix->SetElement(row, 3, X_WA.p_AB[row]);
  }
  actor.SetUserMatrix(matrix);
}

}  // namespace kerf
