#define GL_GLEXT_PROTOTYPES
#include "view/live/viewport.h"

#include <GL/glcorearb.h>
#include <vtkActor.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkProp.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "kerf/error.h"
#include "view/live/bone_prop.h"
#include "view/live/dust_prop.h"
#include "view/live/lamps.h"
#include "view/live/overlay_colours.h"
#include "view/live/palette.h"
#include "view/live/scene_actors.h"
#include "view/live/xray_prop.h"
#include "view/picture/vtk_scene.h"

namespace kerf {
namespace {

constexpr OrientationCubeLook kCubeLook = {
    .patient = true, .side = {0.93, 0.94, 0.96}, .letter = {0.1, 0.12, 0.16}, .ambient = 0.35, .diffuse = 0.7};

}  // namespace

struct Viewport::State {
  explicit State(vtkRenderWindow& w) : window(w), actors(*scene, *over) {}

  vtkRenderWindow& window;
  vtkNew<vtkRenderer> scene, over, corner, flat;
  vtkNew<BoneProp> bone;
  vtkNew<DustProp> dust;
  vtkNew<XrayProp> xray;
  vtkProp* panels = nullptr;
  vtkSmartPointer<vtkActor> cube = MergeOrientationCube(*MakeOrientationCube(kCubeLook));
  SceneActors actors;
  ViewCamera camera;
  double scale = 1;
  double voxel_mm = 0;
  bool has_fineness = false;         // set once the driver is known
  std::optional<bool> smooth_edges;  // unset: the driver's default

  MaterialTable materials;
  Box3 bounds_W;
  ColourBy by = ColourBy::kPlain;
  bool translucent = false;
  bool bone_hidden = false;
  // For the latest mesh of each chunk: the palette entries that occur, and how often.
  using Few = std::vector<std::pair<std::uint16_t, std::uint32_t>>;
  std::map<std::array<int, 3>, Few> counts_of;
  PaletteCounts counts{};

  std::optional<ForceArrow> force;
  DustCloud cloud;
  bool show_dust = true;
  bool show_handpiece = true;
  Theme theme = Theme::kLight;
  ScreenBox free;  // area of the bone; empty: the window
  ScreenBox cube_box;
  ViewStats stats;
  std::uint64_t changes = 0;  // so far, without those of the actors
  std::uint64_t drawn_changes = 0;
  std::optional<ViewCamera> drawn_camera;

  /// Sets a value, and counts the change if it differs from the one before.
  template <typename T>
  void Renew(T& kept, const T& next) {
    if (kept == next) return;
    kept = next;
    ++changes;
  }

  // Depth of a point on the screen as a fragment has it, 0 to 1.
  double CalcDepth(const Vec3& p_W) {
    const double aspect = static_cast<double>(camera.width()) / camera.height();
    double clip[16];
    vtkMatrix4x4::DeepCopy(clip, scene->GetActiveCamera()->GetCompositeProjectionTransformMatrix(aspect, -1, 1));
    const auto row = [&](int i) {
      return clip[4 * i] * p_W.x + clip[4 * i + 1] * p_W.y + clip[4 * i + 2] * p_W.z + clip[4 * i + 3];
    };
    return 0.5 * (row(2) / row(3) + 1);
  }

  void SetCameras() {
    Box3 box = bounds_W;
    const Box3 others = actors.CalcBounds();
    if (!others.empty()) {
      box.Include(others.lower);
      box.Include(others.upper);
    }
    if (box.empty()) box = Box3{Vec3{-10}, Vec3{10}};
    const Vec3 eye = camera.eye_W();
    const double reach = 0.5 * glm::length(box.size()) + 1;
    const double middle = glm::dot(box.centre() - eye, camera.forward_W());
    const double far = std::max(10.0, middle + reach);
    const double near = std::max(middle - reach, 0.002 * far);
    vtkCamera& c = *scene->GetActiveCamera();
    const Vec3 target = camera.target_W();
    const Vec3 up = camera.up_W();
    c.SetParallelProjection(camera.parallel() ? 1 : 0);
    c.SetFocalPoint(target.x, target.y, target.z);
    c.SetPosition(eye.x, eye.y, eye.z);
    c.SetViewUp(up.x, up.y, up.z);
    c.SetViewAngle(ViewCamera::kFieldOfView_deg);
    c.SetParallelScale(0.5 * camera.height_mm());
    c.SetClippingRange(near, far);

    corner->SetDraw(cube_box.empty() ? 0 : 1);
    if (cube_box.empty()) return;
    const double width = camera.width();
    const double height = camera.height();
    corner->SetViewport(cube_box.left / width, 1 - (cube_box.top + cube_box.height) / height,
                        (cube_box.left + cube_box.width) / width, 1 - cube_box.top / height);
    vtkCamera& turned = *corner->GetActiveCamera();
    turned.ParallelProjectionOn();
    const Vec3 from = -5.0 * camera.forward_W();
    turned.SetFocalPoint(0, 0, 0);
    turned.SetPosition(from.x, from.y, from.z);
    turned.SetViewUp(up.x, up.y, up.z);
    turned.SetParallelScale(0.95);
    turned.SetClippingRange(1, 10);
  }
};

Viewport::Viewport(vtkRenderWindow& window) : state_(std::make_unique<State>(window)) {
  State& s = *state_;
  window.SetNumberOfLayers(4);
  int layer = 0;
  for (vtkRenderer* renderer : {s.scene.Get(), s.over.Get(), s.corner.Get(), s.flat.Get()}) {
    renderer->SetLayer(layer++);
    renderer->SetInteractive(0);
    window.AddRenderer(renderer);
  }
  set_theme(Theme::kLight);
  s.scene->GradientBackgroundOn();
  s.over->SetActiveCamera(s.scene->GetActiveCamera());
  for (vtkRenderer* renderer : {s.scene.Get(), s.over.Get(), s.corner.Get()}) AddCameraLights(*renderer, kLampPowers);
  s.scene->AddActor(s.bone);
  s.scene->AddActor(s.xray);
  s.scene->AddActor(s.dust);
  s.corner->AddActor(s.cube);
  s.bone->SetPalette(MakePalette(s.materials, s.by));
  const int* size = window.GetSize();
  Resize(std::max(1, size[0]), std::max(1, size[1]), 1);
}

Viewport::~Viewport() {
  State& s = *state_;
  for (vtkRenderer* renderer : {s.scene.Get(), s.over.Get(), s.corner.Get(), s.flat.Get()}) {
    renderer->ReleaseGraphicsResources(&s.window);
    s.window.RemoveRenderer(renderer);
  }
}

void Viewport::Resize(int width, int height, double scale) {
  CheckRange("scale", scale, kDisplayScaleRange, "display");
  if (width < 1 || height < 1) return;  // minimised
  State& s = *state_;
  s.camera.SetSize(width, height);
  ++s.changes;
  s.scale = scale;
  s.actors.SetScale(scale);
  s.window.SetSize(width, height);
}

int Viewport::width() const {
  return state_->camera.width();
}
int Viewport::height() const {
  return state_->camera.height();
}
double Viewport::scale() const {
  return state_->scale;
}

// ---- the bone

void Viewport::BeginBone(const MaterialTable& materials, const Vec3& origin_W, const Box3& bounds_W, double voxel_mm) {
  State& s = *state_;
  ++s.changes;
  s.materials = materials;
  s.bounds_W = bounds_W;
  s.voxel_mm = voxel_mm;
  s.counts_of.clear();
  s.counts = {};
  // A surface may lie beyond the bounds by a cell.
  double reach_mm = 128;
  const double cell_mm = BoneChunks::kSteps.front() * voxel_mm;
  for (int i = 0; i < 3 && !bounds_W.empty(); ++i) {
    reach_mm =
        std::max({reach_mm, bounds_W.upper[i] - origin_W[i] + cell_mm, origin_W[i] - bounds_W.lower[i] + cell_mm});
  }
  s.bone->Begin(origin_W, reach_mm);
  s.bone->SetPalette(MakePalette(materials, s.by));
}

void Viewport::SetChunk(const ChunkMesh& mesh) {
  State& s = *state_;
  ++s.changes;
  s.bone->SetChunk(mesh);
  PaletteCounts here{};
  for (const ChunkVertex& v : mesh.vertices) ++here[v.region + (v.cut > 127 ? 256u : 0u)];
  State::Few& few = s.counts_of[mesh.index];
  for (const auto& [entry, count] : few) s.counts[entry] -= count;
  few.clear();
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (here[i] == 0) continue;
    few.emplace_back(static_cast<std::uint16_t>(i), static_cast<std::uint32_t>(here[i]));
    s.counts[i] += here[i];
  }
}

void Viewport::SetInnerSurfaces(const InnerSurfaces& surfaces) {
  state_->actors.SetInner(surfaces, state_->translucent);
}

void Viewport::set_colour_by(ColourBy by) {
  State& s = *state_;
  if (by == s.by) return;
  s.by = by;
  ++s.changes;
  s.bone->SetPalette(MakePalette(s.materials, by));
}
ColourBy Viewport::colour_by() const {
  return state_->by;
}

void Viewport::set_translucent(bool translucent) {
  state_->Renew(state_->translucent, translucent);
  state_->bone->SetTranslucent(translucent);
  state_->actors.ShowInner(translucent);
}
bool Viewport::translucent() const {
  return state_->translucent;
}
void Viewport::set_bone_hidden(bool hidden) {
  state_->Renew(state_->bone_hidden, hidden);
  state_->bone->SetHidden(hidden);
}

std::vector<LegendEntry> Viewport::legend() const {
  return MakeLegend(state_->materials, state_->by, state_->counts);
}

// ---- tool, plan, pieces

void Viewport::SetTool(const Tool& tool) {
  state_->actors.SetTool(tool);
}
void Viewport::ClearTool() {
  state_->actors.ClearTool();
}
void Viewport::SetToolColour(const Rgb8& colour) {
  state_->actors.SetToolColour(colour);
}
void Viewport::SetToolPose(const Pose& X_WT, double rpm, double angle_rad, double displacement_mm) {
  state_->actors.SetToolPose(X_WT, rpm, angle_rad, displacement_mm);
}
void Viewport::SetGhost(const std::optional<Pose>& X_WH) {
  state_->actors.SetGhost(X_WH);
}
void Viewport::SetForce(const std::optional<ForceArrow>& force) {
  state_->Renew(state_->force, force);
}
void Viewport::SetPlanes(const std::vector<PlaneOverlay>& planes) {
  state_->actors.SetPlanes(planes);
}
void Viewport::SetDepthStops(const std::vector<DepthStopOverlay>& stops) {
  state_->actors.SetDepthStops(stops);
}
void Viewport::SetGuides(const std::vector<GuideOverlay>& guides) {
  state_->actors.SetGuides(guides);
}
void Viewport::SetMeasures(const std::vector<MeasureOverlay>& measures) {
  state_->actors.SetMeasures(measures);
}
void Viewport::SetPieces(const std::vector<PieceShape>& pieces) {
  state_->actors.SetPieces(pieces);
}
void Viewport::SetBridges(const std::vector<BridgeOverlay>& bridges) {
  state_->actors.SetBridges(bridges);
}
void Viewport::SetPoints(const std::vector<PointOverlay>& points) {
  state_->actors.SetPoints(points);
}
void Viewport::SetPlaneHandles(const std::vector<PlaneHandleOverlay>& handles) {
  state_->actors.SetPlaneHandles(handles);
}
void Viewport::SetPlaneLines(const std::vector<PlaneLineOverlay>& lines) {
  state_->actors.SetPlaneLines(lines);
}
void Viewport::SetMarks(const std::vector<MarkOverlay>& marks) {
  state_->actors.SetMarks(marks);
}
void Viewport::SetAlarms(const std::vector<AlarmOverlay>& alarms) {
  state_->actors.SetAlarms(alarms);
}

void Viewport::set_show_handpiece(bool show) {
  state_->show_handpiece = show;
  state_->actors.SetHandpieceShown(show);
}
bool Viewport::show_handpiece() const {
  return state_->show_handpiece;
}
void Viewport::SetHandpieceInBone(bool in_bone) {
  state_->actors.SetHandpieceInBone(in_bone);
}
void Viewport::SetContact(const std::optional<Vec3>& p_W) {
  state_->actors.SetContact(p_W);
}
void Viewport::AddDust(const Vec3& p_W, const Vec3& v_W, double volume_mm3) {
  if (state_->show_dust) state_->cloud.Add(p_W, v_W, volume_mm3);
}
void Viewport::AdvanceDust(double dt_s) {
  if (state_->cloud.size() > 0) ++state_->changes;
  state_->cloud.Advance(dt_s);
}
void Viewport::set_show_dust(bool show) {
  state_->Renew(state_->show_dust, show);
  if (!show) state_->cloud.Clear();
}
bool Viewport::show_dust() const {
  return state_->show_dust;
}

void Viewport::set_theme(Theme theme) {
  State& s = *state_;
  s.theme = theme;
  ++s.changes;
  const SceneColours colours = SceneColoursOf(theme);
  const auto f = [](std::uint8_t v) { return v / 255.0; };
  s.scene->SetBackground(f(colours.bottom[0]), f(colours.bottom[1]), f(colours.bottom[2]));
  s.scene->SetBackground2(f(colours.top[0]), f(colours.top[1]), f(colours.top[2]));
}
Theme Viewport::theme() const {
  return state_->theme;
}

std::vector<SceneRing> Viewport::ListRings() const {
  std::vector<SceneRing> rings;
  for (const AlarmOverlay& alarm : state_->actors.alarms()) {
    const auto at = state_->camera.Project(alarm.p_W);
    if (at && alarm.level != AlarmLevel::kNone) rings.push_back({at->x, at->y, alarm.level});
  }
  return rings;
}
std::optional<ScreenPoint> Viewport::FindCut() const {
  const std::optional<Vec3>& contact_W = state_->actors.contact();
  return contact_W ? state_->camera.Project(*contact_W) : std::nullopt;
}
ScreenBox Viewport::CalcToolBox() const {
  return state_->actors.CalcToolBox(state_->camera);
}

std::vector<ScreenPoint> Viewport::ListMeasuredPoints() const {
  std::vector<ScreenPoint> points;
  for (const MeasureOverlay& measure : state_->actors.measures()) {
    for (const Vec3& p_W : measure.points_W) {
      if (const auto at = state_->camera.Project(p_W)) points.push_back(*at);
    }
  }
  return points;
}

bool Viewport::IsOnTool(const ScreenPoint& at) const {
  return state_->actors.IsOnTool(state_->camera, at);
}

// ---- panels

void Viewport::SetPanels(vtkProp& panels) {
  state_->panels = &panels;
  state_->flat->AddViewProp(&panels);
}
void Viewport::set_panels_shown(bool shown) {
  if (state_->panels != nullptr) state_->panels->SetVisibility(shown ? 1 : 0);
  ++state_->changes;
}
void Viewport::SetAreas(const ScreenBox& scene, const ScreenBox& cube) {
  state_->free = scene;
  state_->Renew(state_->cube_box, cube);
}
std::vector<SceneLabel> Viewport::ListLabels() const {
  state_->actors.SetForce(state_->force, state_->camera, state_->free);  // not that of the last picture
  return state_->actors.MakeLabels(state_->camera);
}

// ---- camera and mouse

ViewCamera& Viewport::camera() {
  return state_->camera;
}
const ViewCamera& Viewport::camera() const {
  return state_->camera;
}

void Viewport::FitAll() {
  State& s = *state_;
  std::vector<Vec3> points;
  if (!s.bone_hidden) points = s.bone->ListCorners();
  for (const PieceShape& piece : s.actors.pieces()) {
    if (piece.hidden || piece.mesh_W == nullptr) continue;
    for (const Vec3& p : piece.mesh_W->points) points.push_back(piece.X_WP.Point(p));
  }
  if (s.bounds_W.empty()) return;
  for (int i = 0; i < 8 && (i > 0 || points.empty()); ++i) {
    points.emplace_back((i & 1) != 0 ? s.bounds_W.upper.x : s.bounds_W.lower.x,
                        (i & 2) != 0 ? s.bounds_W.upper.y : s.bounds_W.lower.y,
                        (i & 4) != 0 ? s.bounds_W.upper.z : s.bounds_W.lower.z);
  }
  if (s.free.empty()) {
    s.camera.Fit(points);
  } else {
    FitPoints(points, s.free);
  }
}

void Viewport::FitPoints(const std::vector<Vec3>& points_W, const ScreenBox& area) {
  if (area.empty()) return;
  // Fits the view into a window of the size of the area, then shifts it to the area's position.
  ViewCamera& camera = state_->camera;
  const int width = camera.width();
  const int height = camera.height();
  camera.SetSize(std::max(1, static_cast<int>(area.width)), std::max(1, static_cast<int>(area.height)));
  camera.Fit(points_W, 0.04);
  const double mm_per_pixel = camera.height_mm() / camera.height();
  camera.SetSize(width, height);
  camera.set_height_mm(mm_per_pixel * height);
  camera.Pan(area.left + 0.5 * area.width - 0.5 * width, area.top + 0.5 * area.height - 0.5 * height);
}

namespace {

// Returns the index of the overlay nearest to a pixel.
template <typename Overlay>
std::optional<int> PickNearest(const std::vector<Overlay>& overlays, const ViewCamera& camera, const ScreenPoint& at,
                               double radius_px) {
  std::optional<int> nearest;
  double least = radius_px;
  for (std::size_t i = 0; i < overlays.size(); ++i) {
    const auto p = camera.Project(overlays[i].p_W);
    if (!p) continue;
    const double away = std::hypot(p->x - at.x, p->y - at.y);
    if (away > least) continue;
    least = away;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace

std::optional<int> Viewport::PickPoint(const ScreenPoint& at, double radius_px) const {
  return PickNearest(state_->actors.points(), state_->camera, at, radius_px);
}

std::optional<int> Viewport::PickHandle(const ScreenPoint& at) const {
  const double symbol_px = 0.5 * kHandleSize_points * state_->scale;  // its radius
  return PickNearest(state_->actors.plane_handles(), state_->camera, at, IsOnTool(at) ? symbol_px : 2 * symbol_px);
}

// ---- drawing

bool Viewport::has_changed() const {
  const State& s = *state_;
  if (!s.drawn_camera || s.drawn_changes != s.changes + s.actors.changes()) return true;
  const ViewCamera& a = s.camera;
  const ViewCamera& b = *s.drawn_camera;
  return a.target_W() != b.target_W() || a.forward_W() != b.forward_W() || a.up_W() != b.up_W() ||
         a.height_mm() != b.height_mm() || a.parallel() != b.parallel();
}

void Viewport::Render() {
  State& s = *state_;
  s.drawn_camera = s.camera;
  s.drawn_changes = s.changes + s.actors.changes();
  if (!s.has_fineness || !s.smooth_edges) {
    // Without a graphics card, the cost of triangles outweighs the loss of quality from coarse cells.
    const std::string name = renderer_name();
    const bool software = name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos;
    if (!s.has_fineness) s.bone->SetFineness(software ? BoneProp::Fineness{1.5, 14, 150'000} : BoneProp::Fineness{});
    s.has_fineness = true;
    if (!s.smooth_edges) s.smooth_edges = !software;
    s.cloud.set_max_grains(software ? 400 : 1500);
    s.scene->SetUseFXAA(*s.smooth_edges);
  }
  s.bone->SetPixel(s.camera.WorldPerPixel(s.camera.target_W()), s.scale, s.voxel_mm);
  s.actors.SetForce(s.force, s.camera, s.free);
  s.SetCameras();
  s.actors.MoveToolLast();
  if (const std::optional<Vec3>& contact = s.actors.contact()) {
    // A little behind the place itself, because the disc's own rim is there.
    s.actors.UpdateSightHoles(s.camera,
                              s.CalcDepth(*contact + 1.0 * s.camera.CalcRay(*s.camera.Project(*contact)).direction_W));
  } else {
    s.actors.UpdateSightHoles(s.camera, 0);
  }
  // A dual mesh of cells of this edge deviates from the surface by less than half an edge.
  const double surface_mm = 0.25 + 0.5 * s.bone->counts().step * s.voxel_mm;
  s.xray->SetList(s.actors.MakeXrayList(surface_mm, s.theme), s.scale);
  s.dust->SetGrains(s.cloud.MakeGrains(), s.scale);
  s.window.Render();
  const BoneProp::Counts& counts = s.bone->counts();
  s.stats = {counts.chunks, counts.drawn, counts.triangles, counts.bytes, counts.step};
}

Image Viewport::Grab() {
  State& s = *state_;
  Image image;
  image.width = s.camera.width();
  image.height = s.camera.height();
  const vtkNew<vtkUnsignedCharArray> raw;
  s.window.GetPixelData(0, 0, image.width - 1, image.height - 1, 0, raw.Get(), 0);
  if (raw->GetNumberOfTuples() != vtkIdType{image.width} * image.height) {
    throw Error("the window picture could not be read back");
  }
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const auto row_bytes = static_cast<std::size_t>(image.width) * 3;
  for (int row = 0; row < image.height; ++row) {
    // OpenGL counts rows from the bottom.
    const unsigned char* from = raw->GetPointer(0) + static_cast<std::size_t>(image.height - 1 - row) * row_bytes;
    for (int column = 0; column < image.width; ++column) {
      Rgb8& to = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                              static_cast<std::size_t>(column)];
      for (std::size_t c = 0; c < 3; ++c) to[c] = from[3 * static_cast<std::size_t>(column) + c];
    }
  }
  return image;
}

const ViewStats& Viewport::stats() const {
  return state_->stats;
}

void Viewport::set_smooth_edges(bool smooth) {
  state_->smooth_edges = smooth;
  ++state_->changes;
  state_->scene->SetUseFXAA(smooth);
}

void Viewport::SetFineness(double cell_points, double coarsest_cell_points, std::size_t triangles) {
  state_->bone->SetFineness({cell_points, std::max(cell_points, coarsest_cell_points), triangles});
  state_->has_fineness = true;
  ++state_->changes;
}

std::string Viewport::renderer_name() const {
  state_->window.MakeCurrent();
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name != nullptr ? name : "unknown";
}

}  // namespace kerf
