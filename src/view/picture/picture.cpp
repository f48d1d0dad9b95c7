#include "view/picture/picture.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkOpenGLFXAAPass.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSSAOPass.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "cut/tool/looks.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "view/picture/axes.h"
#include "view/picture/layout.h"
#include "view/picture/offscreen.h"
#include "view/picture/overlay.h"
#include "view/picture/turn_arrow.h"
#include "view/picture/vtk_scene.h"

namespace kerf {
namespace {

constexpr Rgb8 kWhite{255, 255, 255};
constexpr Rgb8 kDark{38, 41, 47};

constexpr std::array kLights = {0.70, 0.40, 0.25, 0.10};

vtkSmartPointer<vtkActor> MakeActor(const Shape& shape) {
  const bool by_point = !shape.point_colours.empty();
  if (by_point && shape.point_colours.size() != shape.mesh_W.points.size()) {
    throw Error(fmt::format("a shape to draw has {} colours for {} points", shape.point_colours.size(),
                            shape.mesh_W.points.size()));
  }
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(MakeCreasedPolyData(shape.mesh_W, shape.point_colours));
  mapper->SetScalarVisibility(by_point ? 1 : 0);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  vtkProperty& property = *actor->GetProperty();
  SetColour(property, shape.colour);
  property.SetInterpolationToPhong();
  property.SetAmbient(0.2);
  property.SetDiffuse(0.86);
  property.SetSpecular(shape.shiny ? 0.40 : 0.06);
  property.SetSpecularPower(shape.shiny ? 40 : 18);
  property.SetOpacity(shape.opacity);
  return actor;
}

// Makes a shaft with a conical head.
Shape MakeArrowShape(const Arrow& arrow, double shaft_radius_mm) {
  const Vec3 along = arrow.tip_W - arrow.tail_W;
  const double length = glm::length(along);
  const Vec3 axis = length > 0 ? along / length : Vec3{0, 0, 1};
  const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = glm::normalize(glm::cross(axis, other));
  const Vec3 v = glm::cross(axis, u);
  const double head = std::min(8 * shaft_radius_mm, 0.6 * length);
  struct Ring {
    double z;
    double radius;
  };
  const Ring rings[] = {{0, 0},
                        {0, shaft_radius_mm},
                        {length - head, shaft_radius_mm},
                        {length - head, 3 * shaft_radius_mm},
                        {length, 0}};
  constexpr std::uint32_t kSectors = 48;
  Shape shape;
  shape.colour = arrow.colour;
  for (const Ring& ring : rings) {
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const double angle = 2 * std::numbers::pi * j / kSectors;
      shape.mesh_W.points.push_back(arrow.tail_W + ring.z * axis +
                                    ring.radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  for (std::uint32_t i = 0; i + 1 < std::size(rings); ++i) {
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const std::uint32_t a = i * kSectors + j;
      const std::uint32_t b = i * kSectors + (j + 1) % kSectors;
      shape.mesh_W.triangles.push_back({a, b, b + kSectors});
      shape.mesh_W.triangles.push_back({a, b + kSectors, a + kSectors});
    }
  }
  return shape;
}

/// Makes the bent arrow of a tool: in front of it, or over the flat of a disc.
Shape MakeTurnArrowShape(const ToolInPicture& at, const ViewFrame& frame, double shaft_radius_mm) {
  constexpr double kHalfSpan_rad = 1.2;
  const double radius = (IsBlade(at.tool) ? 0.6 : 1.6) * CalcRadius(at.tool);
  const std::optional<RoundSolid> solid = CalcRoundSolid(at.tool);
  const Vec3 middle_T(0, 0, solid ? std::min(solid->top_z_mm, 4 * solid->top_radius_mm) : 0);
  const Vec3 seen_T = at.X_WT.InverseVector(frame.toward_eye_W + frame.up_W);
  const double angle = std::atan2(seen_T.y, seen_T.x);
  const double half = std::copysign(kHalfSpan_rad, at.rpm);
  Shape shape;
  shape.colour = kTurnColour;
  shape.mesh_W = MakeTurnArrowMesh(radius, std::min(shaft_radius_mm, 0.08 * radius), angle - half, angle + half);
  for (Vec3& p : shape.mesh_W.points) p = at.X_WT.Point(middle_T + p);
  return shape;
}

void SetCamera(const ViewFrame& frame, int padding, const Box3& box, vtkRenderer& renderer) {
  // Sets the clipping planes around everything.
  double nearest = -1;
  double farthest = 1;
  for (int corner = 0; corner < 8; ++corner) {
    const double depth = glm::dot(frame.toward_eye_W, CornerOf(box, corner) - frame.centre_W);
    nearest = std::max(nearest, depth);
    farthest = std::min(farthest, depth);
  }
  const double margin = 0.02 * (nearest - farthest) + 1;
  const Vec3 eye = frame.centre_W + (nearest + 2 * margin) * frame.toward_eye_W;
  vtkCamera& camera = *renderer.GetActiveCamera();
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(frame.centre_W.x, frame.centre_W.y, frame.centre_W.z);
  camera.SetPosition(eye.x, eye.y, eye.z);
  camera.SetViewUp(frame.up_W.x, frame.up_W.y, frame.up_W.z);
  camera.SetParallelScale(0.5 * (frame.height + 2 * padding) / frame.pixels_per_mm);
  camera.SetClippingRange(margin, nearest - farthest + 3 * margin);
}

// Adds a cube in the corner that turns with the view.
void AddOrientation(const PictureSpec& spec, const ViewFrame& frame, const Layout& layout, vtkRenderer& renderer) {
  const vtkSmartPointer<vtkAnnotatedCubeActor> cube =
      MakeOrientationCube({.patient = spec.orientation == Orientation::kPatient,
                           .side = {186 / 255.0, 191 / 255.0, 199 / 255.0},
                           .letter = {40 / 255.0, 44 / 255.0, 52 / 255.0},
                           .ambient = 0.3,
                           .diffuse = 0.85});
  renderer.AddActor(cube);
  AddCameraLights(renderer, kLights);
  const double side = 110 * layout.unit;  // pixels
  const double edge = 6 * layout.unit;
  const double right = spec.width - edge;
  renderer.SetViewport((right - side) / spec.width, edge / spec.height, right / spec.width,
                       (edge + side) / spec.height);
  vtkCamera& camera = *renderer.GetActiveCamera();
  camera.ParallelProjectionOn();
  const Vec3 eye = 5.0 * frame.toward_eye_W;
  camera.SetFocalPoint(0, 0, 0);
  camera.SetPosition(eye.x, eye.y, eye.z);
  camera.SetViewUp(frame.up_W.x, frame.up_W.y, frame.up_W.z);
  camera.SetParallelScale(0.95);
  camera.SetClippingRange(1, 10);
}

// Returns 1, 2 or 5 times a power of ten, close to `wanted`.
double CalcRoundLength(double wanted) {
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= wanted) return factor * power;
  }
  return power;
}

// Adds a background below text, which shapes may reach.
void AddPanel(const PictureSpec& spec, const Layout& layout, double left, double top, double right, double bottom,
              Overlay& overlay) {
  const double room = 0.5 * layout.text_size;
  overlay.AddBox(left - room, top - room, right - left + 2 * room, bottom - top + 2 * room, spec.dark ? kDark : kWhite,
                 0.8);
}

void AddTexts(const PictureSpec& spec, const ViewFrame& frame, const Layout& layout, Overlay& overlay) {
  const Rgb8 strong = layout.title_style.colour;
  const double edge = layout.edge;
  if (layout.has_words()) {
    if (spec.camera.target_W) {
      // A tool or bone that reaches the top ends at a band; between the lines it would be taken for what is behind it.
      overlay.AddBox(0, 0, spec.width, layout.words_bottom + 0.5 * layout.text_size, spec.dark ? kDark : kWhite);
    }
    overlay.AddText(layout.title, edge, edge, layout.title_style);
    overlay.AddText(layout.caption, edge, layout.caption_top, layout.caption_style);
  }
  if (!spec.legend.empty()) {
    const double swatch = layout.legend_size;
    const double left = spec.width - edge - layout.legend_width;
    const double height = swatch * (1 + kLegendLine * static_cast<double>(spec.legend.size() - 1));
    AddPanel(spec, layout, left, edge, spec.width - edge, edge + height, overlay);
    double top = edge;
    for (const LegendEntry& entry : spec.legend) {
      overlay.AddBox(left - 1, top - 1, swatch + 2, swatch + 2, layout.caption_style.colour);
      overlay.AddBox(left, top, swatch, swatch, entry.colour);
      overlay.AddText(entry.text, left + kLegendText * swatch, top - 0.06 * swatch, {layout.legend_size, strong});
      top += kLegendLine * swatch;
    }
  }
  if (spec.scale_bar) {
    const double length_mm = CalcRoundLength(0.16 * spec.width / frame.pixels_per_mm);
    const double length = length_mm * frame.pixels_per_mm;
    const double bottom = spec.height - layout.edge;
    const double thick = std::max(2.0, std::round(3 * layout.unit));
    const double tick = std::round(9 * layout.unit);
    AddPanel(spec, layout, layout.edge, bottom - tick - 1.25 * layout.text_size, layout.edge + length, bottom, overlay);
    overlay.AddBox(layout.edge, bottom - thick, length, thick, strong);
    overlay.AddBox(layout.edge, bottom - tick, thick, tick, strong);
    overlay.AddBox(layout.edge + length - thick, bottom - tick, thick, tick, strong);
    overlay.AddText(fmt::format("{:g} mm", length_mm), layout.edge + 0.5 * length,
                    bottom - tick - 1.25 * layout.text_size, {layout.text_size, strong, false, Align::kCentre});
  }
  for (const Arrow& arrow : spec.arrows) {
    const ViewFrame::Pixel tail = frame.Project(arrow.tail_W);
    const ViewFrame::Pixel tip = frame.Project(arrow.tip_W);
    // The label is placed beyond the tail, on the side away from the tip, and on a plate: it may lie on the tool.
    const bool to_right = tail.column >= tip.column;
    const double gap = 0.6 * layout.text_size;
    const double top = tail.row - 0.5 * layout.text_size;
    const TextStyle style{layout.text_size, spec.dark ? strong : arrow.colour, true,
                          to_right ? Align::kLeft : Align::kRight};
    const double width = overlay.MeasureText(arrow.label, style).width + gap;
    const double left = tail.column + (to_right ? 0.5 * gap : -0.5 * gap - width);
    if (!arrow.label.empty())
      overlay.AddBox(left, top - 0.2 * gap, width, 1.25 * layout.text_size, spec.dark ? kDark : kWhite);
    overlay.AddText(arrow.label, tail.column + (to_right ? gap : -gap), top, style);
  }
}

/// Draws what lies in space, without the arrows. `supersampling` as for OffscreenWindow::Draw(); with 1, edges are
/// smoothed in the finished picture.
Image DrawScene(const PictureSpec& spec, const ViewFrame& frame, const PatientAxes* axes, int supersampling) {
  std::vector<vtkSmartPointer<vtkActor>> actors;
  Box3 box;
  const auto add = [&](const Shape& shape) {
    if (shape.mesh_W.triangles.empty()) return;
    for (const Vec3& p : shape.mesh_W.points) {
      if (!std::isfinite(p.x + p.y + p.z)) throw Error("a surface to draw has a point that is not finite");
      box.Include(p);
    }
    actors.push_back(MakeActor(shape));
  };
  for (const Shape& shape : spec.shapes) add(shape);
  for (const ToolInPicture& at : spec.tools) {
    Shape shape{MakeToolLooks(at.tool).whole, kSteelColour, {}, at.opacity, true};
    for (Vec3& p : shape.mesh_W.points) p = at.X_WT.Point(p);
    add(shape);
  }

  // Ambient occlusion samples a pixel's neighbourhood. Where shapes can reach the edge, a margin is drawn and cut off.
  const int padding = spec.camera.target_W ? static_cast<int>(0.08 * spec.height) : 0;
  OffscreenWindow offscreen((spec.width + 2 * padding) * supersampling, (spec.height + 2 * padding) * supersampling);
  vtkRenderWindow& window = offscreen.window();
  const vtkNew<vtkRenderer> scene;
  const Rgb8 background = spec.dark ? kDark : kWhite;
  scene->SetBackground(background[0] / 255.0, background[1] / 255.0, background[2] / 255.0);
  for (const auto& actor : actors) scene->AddActor(actor);
  if (axes != nullptr) axes->AddGrid(*scene);
  AddCameraLights(*scene, kLights);
  window.AddRenderer(scene);
  SetCamera(frame, padding, box, *scene);
  // Ambient occlusion darkens corners and gaps, which makes a thin kerf visible.
  const vtkNew<vtkRenderStepsPass> steps;
  const vtkNew<vtkSSAOPass> occlusion;
  const double view_height_mm = frame.height / frame.pixels_per_mm;
  occlusion->SetRadius(0.09 * view_height_mm);
  occlusion->SetBias(0.0015 * view_height_mm);
  occlusion->SetKernelSize(64);
  occlusion->BlurOn();
  occlusion->SetDelegatePass(steps);
  const vtkNew<vtkOpenGLFXAAPass> smooth;
  smooth->SetDelegatePass(occlusion);
  if (supersampling > 1) {
    scene->SetPass(occlusion);
  } else {
    scene->SetPass(smooth);
  }
  Image image = offscreen.Draw(supersampling, padding);
  scene->SetPass(nullptr);
  smooth->ReleaseGraphicsResources(&window);
  occlusion->ReleaseGraphicsResources(&window);
  return image;
}

}  // namespace

const bool kPicturesBuilt = true;
void RequirePictures() {
  if (const std::string lack = FindLackOfPictures(); !lack.empty())
    throw Error("nothing was computed, because the report has figures. " + lack);
}

Image RenderPicture(const PictureSpec& spec) {
  const Layout layout(spec);
  const ViewFrame frame = CalcViewFrame(spec, layout);
  std::optional<PatientAxes> axes;
  if (spec.axes) axes.emplace(CalcShapeBox(spec), frame, layout, spec.dark);
  // In the scene, ambient occlusion at each of four samples a pixel would take most of the time; only the thin lines of
  // a grid need them.
  const int supersampling = layout.supersampling;
  const Image below = DrawScene(spec, frame, axes ? &*axes : nullptr, axes ? supersampling : 1);

  OffscreenWindow offscreen(spec.width * supersampling, spec.height * supersampling);
  vtkRenderWindow& window = offscreen.window();
  window.SetNumberOfLayers(4);
  const vtkNew<vtkRenderer> scene;
  scene->SetLayer(0);
  Overlay(*scene, spec.height, supersampling).AddImage(below, 0, 0, spec.width, spec.height);
  window.AddRenderer(scene);

  // Arrows are drawn over everything, so that bone does not hide them.
  const vtkNew<vtkRenderer> over;
  std::vector<Shape> arrows;
  const double shaft_radius_mm = 3.0 * layout.unit / frame.pixels_per_mm;
  for (const Arrow& arrow : spec.arrows) arrows.push_back(MakeArrowShape(arrow, shaft_radius_mm));
  for (const ToolInPicture& at : spec.tools) {
    if (at.rpm == 0 || GetDrive(at.tool) != DriveMotion::kRotation) continue;
    arrows.push_back(MakeTurnArrowShape(at, frame, shaft_radius_mm));
  }
  if (!arrows.empty()) {
    over->SetLayer(1);
    Box3 box;
    for (const Shape& shape : arrows) {
      for (const Vec3& p : shape.mesh_W.points) box.Include(p);
      over->AddActor(MakeActor(shape));
    }
    AddCameraLights(*over, kLights);
    window.AddRenderer(over);
    SetCamera(frame, 0, box, *over);
  }
  const vtkNew<vtkRenderer> corner;
  if (spec.orientation != Orientation::kNone) {
    corner->SetLayer(2);
    AddOrientation(spec, frame, layout, *corner);
    window.AddRenderer(corner);
  }
  const vtkNew<vtkRenderer> words;
  words->SetLayer(3);
  Overlay overlay(*words, spec.height, supersampling);
  if (axes) axes->AddNumbers(overlay);
  AddTexts(spec, frame, layout, overlay);
  window.AddRenderer(words);
  return offscreen.Draw(supersampling);
}

void WritePicture(const PictureSpec& spec, const std::string& path) {
  WritePng(RenderPicture(spec), path);
}

}  // namespace kerf
