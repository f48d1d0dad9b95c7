#include "view/live/scene_actors.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkPropCollection.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "cut/tool/edge_motion.h"
#include "cut/tool/looks.h"
#include "cut/tool/shape.h"
#include "view/live/overlay_colours.h"
#include "view/live/palette.h"
#include "view/live/scene_shapes.h"
#include "view/picture/handpiece.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

using Actors = std::vector<vtkSmartPointer<vtkActor>>;

constexpr Rgb8 kGhostColour{0, 114, 178};
constexpr Rgb8 kStopColour{160, 90, 0};
constexpr Rgb8 kReachedColour{190, 40, 20};
constexpr Rgb8 kHandpieceColour{206, 212, 219};
constexpr Rgb8 kGuardColour{150, 160, 172};
constexpr double kSeenStrokes_per_min = 600;  // faster strokes are not seen one by one
constexpr Rgb8 kPassedColour{230, 120, 30};
constexpr double kPassedOpacity = 0.3;

Rgb8 Lighter(const Rgb8& c, double fraction, const Rgb8& to) {
  Rgb8 mixed{};
  for (std::size_t i = 0; i < 3; ++i) mixed[i] = static_cast<std::uint8_t>(c[i] + fraction * (to[i] - c[i]));
  return mixed;
}

std::vector<Vec3> Closed(std::vector<Vec3> corners) {
  if (!corners.empty()) corners.push_back(corners.front());
  return corners;
}

/// Returns the corners of the outline of all that a blade passes in a stroke.
std::vector<Vec3> MakeStrokeCorners(const Tool& tool, const Pose& X_WT) {
  const ConvexOutline outline = MakeStrokeOutline(tool);
  std::vector<Vec3> corners;
  for (int i = 0; i < outline.size(); ++i) corners.push_back(X_WT.Point({outline.corner(i).x, outline.corner(i).y, 0}));
  return corners;
}

/// Returns the closed line around a tool in the picture: a disc's rim, all that a blade with a stroke passes, the
/// silhouette of any other tool.
std::vector<Vec3> MakeToolOutline(const Tool& tool, const Pose& X_WT, const ViewCamera& camera, int corners) {
  if (CalcStroke(tool) > 0) return Closed(MakeStrokeCorners(tool, X_WT));
  if (IsBlade(tool)) return Closed(MakeCircle(X_WT.p_AB, X_WT.Vector({0, 0, 1}), CalcReach(tool), corners));
  std::vector<Vec3> outline = MakeCircle(Vec3(0), camera.forward_W(), 1, corners);
  std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  if (solid) solid->side_cuts = true;  // the head is seen whether its side cuts or not
  for (Vec3& p : outline) {
    const Vec3 n_T = X_WT.InverseVector(p);
    p = X_WT.Point(solid ? solid->FindDeepest(n_T) : FindDeepest(tool, n_T));
  }
  return Closed(std::move(outline));
}

void Include(const std::vector<Vec3>& points, Box3& box) {
  for (const Vec3& p : points) box.Include(p);
}

}  // namespace

struct SceneActors::State {
  State(vtkRenderer& s, vtkRenderer& o) : scene(s), over(o) {}

  vtkRenderer& scene;
  vtkRenderer& over;
  double scale = 1;
  Actors inner;
  Box3 inner_box;
  bool inner_shown = false;
  std::optional<Tool> tool;
  std::vector<Vec3> outline_T;  // of the tool
  Pose X_WT;
  double rpm = 0;
  double angle_rad = 0;
  double displacement_mm = 0;  // of a stroke
  vtkSmartPointer<vtkActor> toothed, turning, blur, passed, passed_rim, ghost, handpiece, guard;
  bool handpiece_shown = true;
  bool handpiece_in_bone = false;
  std::optional<Vec3> contact_W;
  bool tool_is_last = true;
  bool ghost_shown = false;
  std::optional<ForceArrow> force;
  Vec3 force_tail_W{0};
  vtkSmartPointer<vtkActor> arrow;
  std::vector<PlaneOverlay> planes;
  std::vector<DepthStopOverlay> stops;
  std::vector<GuideOverlay> guides;
  std::vector<MeasureOverlay> measures;
  std::vector<BridgeOverlay> bridges;
  std::vector<PointOverlay> points;
  std::vector<PlaneHandleOverlay> handles;
  std::vector<PlaneLineOverlay> plane_lines;
  std::vector<MarkOverlay> marks;
  std::vector<AlarmOverlay> alarms;
  Actors plane_actors, stop_actors, guide_actors, mark_actors;
  std::vector<PieceShape> pieces;
  struct PieceActor {
    std::shared_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const std::vector<Rgb8>> colours;
    vtkSmartPointer<vtkActor> actor;
    vtkSmartPointer<vtkActor> frame;
    Box3 box;
  };
  std::map<int, PieceActor> piece_actors;

  std::uint64_t changes = 0;

  /// Sets a value. Returns false if it is the same as before.
  template <typename T>
  bool Renew(T& kept, const T& next) {
    if (kept == next) return false;
    kept = next;
    ++changes;
    return true;
  }
  /// Whether teeth pass too fast to be seen separately; they are drawn blurred.
  bool Whirls() const { return turning != nullptr && std::abs(rpm) * CountPassesPerTurn(*tool) / 60 > 15; }
  void Remove(vtkRenderer& from, Actors& actors) {
    for (const auto& actor : actors) from.RemoveActor(actor);
    actors.clear();
  }
  void Add(vtkRenderer& to, Actors& actors, const vtkSmartPointer<vtkActor>& actor) {
    to.AddActor(actor);
    actors.push_back(actor);
    tool_is_last = false;
  }
  std::vector<vtkActor*> ToolActors() const {
    std::vector<vtkActor*> all;
    for (const auto* actor : {&toothed, &turning, &blur, &passed, &passed_rim, &guard, &handpiece}) {
      if (*actor != nullptr) all.push_back(*actor);
    }
    return all;
  }
  // Turns the guard to the side away from the cut; without a cut, upwards.
  void PlaceHandpiece() {
    if (handpiece != nullptr) {
      SetPose(*handpiece, X_WT);
      handpiece->SetVisibility(handpiece_shown);
    }
    if (guard == nullptr) return;
    guard->SetVisibility(handpiece_shown);
    const Vec3 away_T = contact_W ? -X_WT.InversePoint(*contact_W) : X_WT.InverseVector({0, 0, 1});
    const double angle = std::hypot(away_T.x, away_T.y) > 1e-3 ? std::atan2(away_T.y, away_T.x) : 0;
    SetPose(*guard, {X_WT.R_AB * glm::angleAxis(angle, Vec3{0, 0, 1}), X_WT.p_AB});
  }
  void ShowTool() {
    if (toothed == nullptr) return;
    const bool whirls = Whirls();
    toothed->SetVisibility(!whirls);
    if (turning != nullptr) turning->SetVisibility(whirls);
    if (blur != nullptr) blur->SetVisibility(whirls);
    for (const auto& actor : {passed, passed_rim}) {
      if (actor != nullptr) actor->SetVisibility(std::abs(rpm) > kSeenStrokes_per_min);
    }
  }
  /// Pose of the blade where its stroke has it.
  Pose EdgePose() const { return EdgeMotion(tool ? CalcSwingRadius(*tool) : 0).Move(X_WT, displacement_mm); }
};

SceneActors::SceneActors(vtkRenderer& scene, vtkRenderer& over) : state_(std::make_unique<State>(scene, over)) {}
SceneActors::~SceneActors() = default;

std::uint64_t SceneActors::changes() const {
  return state_->changes;
}

void SceneActors::SetScale(double scale) {
  state_->scale = scale;
}

void SceneActors::SetInner(const InnerSurfaces& surfaces, bool shown) {
  State& s = *state_;
  ++s.changes;
  s.Remove(s.scene, s.inner);
  s.inner_box = {};
  if (!surfaces.canal_W.triangles.empty()) {
    s.Add(s.scene, s.inner, MakeMeshActor(surfaces.canal_W, TissueColour(Tissue::kCanal), 1, Finish::kMatt));
  }
  if (!surfaces.teeth_W.triangles.empty()) {
    s.Add(s.scene, s.inner, MakeMeshActor(surfaces.teeth_W, TissueColour(Tissue::kTooth), 1, Finish::kMatt));
  }
  Include(surfaces.canal_W.points, s.inner_box);
  Include(surfaces.teeth_W.points, s.inner_box);
  ShowInner(shown);
}

void SceneActors::ShowInner(bool shown) {
  state_->Renew(state_->inner_shown, shown);
  for (const auto& actor : state_->inner) actor->SetVisibility(shown);
}

void SceneActors::SetTool(const Tool& tool) {
  ClearTool();
  State& s = *state_;
  s.tool = tool;
  const ToolLooks looks = MakeToolLooks(tool);
  s.outline_T = looks.outline;
  s.toothed = MakeMeshActor(looks.whole, kSteelColour, 1, Finish::kMetal);
  s.ghost = MakeMeshActor(looks.whole, kGhostColour, 0.3, Finish::kMatt);
  s.ghost->SetVisibility(false);
  s.ghost->GetProperty()->BackfaceCullingOn();
  s.scene.AddActor(s.toothed);
  s.over.AddActor(s.ghost);
  if (looks.blur) {
    s.turning = MakeMeshActor(looks.turning, kSteelColour, 1, Finish::kMetal);
    s.blur = MakeBlurActor(*looks.blur);
    for (const auto& actor : {s.toothed, s.turning, s.blur}) AddSightHole(*actor);
  }
  if (!looks.guard.triangles.empty()) {
    s.guard = MakeMeshActor(looks.guard, kGuardColour, 1, Finish::kMetal);
    AddSightHole(*s.guard);
  }
  if (CalcStroke(tool) > 0) {
    const std::vector<Vec3> corners = MakeStrokeCorners(tool, {});
    s.passed = MakeMeshActor(MakePolygon(corners), kPassedColour, kPassedOpacity, Finish::kFlat);
    s.passed_rim = MakeLineActor({Closed(corners)}, kPassedColour, 2.5 * s.scale);
  }
  for (const auto& actor : {s.turning, s.blur, s.passed, s.passed_rim, s.guard}) {
    if (actor != nullptr) s.scene.AddActor(actor);
  }
  s.handpiece = MakeMeshActor(MakeHandpieceMesh(tool), kHandpieceColour, 1, Finish::kMatt);
  AddSightHole(*s.handpiece);
  s.scene.AddActor(s.handpiece);
  s.tool_is_last = true;
  s.ShowTool();
  s.PlaceHandpiece();
}

void SceneActors::ClearTool() {
  State& s = *state_;
  ++s.changes;
  for (auto* actor : {&s.toothed, &s.turning, &s.blur, &s.passed, &s.passed_rim, &s.guard, &s.handpiece}) {
    if (*actor != nullptr) s.scene.RemoveActor(*actor);
    *actor = nullptr;
  }
  if (s.ghost != nullptr) s.over.RemoveActor(s.ghost);
  s.ghost = nullptr;
  s.ghost_shown = false;
  s.tool.reset();
  s.contact_W.reset();
  s.displacement_mm = 0;
}

void SceneActors::MoveToolLast() {
  State& s = *state_;
  if (std::exchange(s.tool_is_last, true)) return;
  // Not RemoveActor(), which would release the actor's buffers on the graphics card.
  vtkPropCollection& props = *s.scene.GetViewProps();
  for (vtkActor* actor : s.ToolActors()) {
    props.RemoveItem(actor);
    props.AddItem(actor);
  }
}

void SceneActors::SetHandpieceShown(bool shown) {
  ++state_->changes;
  state_->handpiece_shown = shown;
  state_->PlaceHandpiece();
}

void SceneActors::SetHandpieceInBone(bool in_bone) {
  if (std::exchange(state_->handpiece_in_bone, in_bone) != in_bone) ++state_->changes;
}

void SceneActors::SetContact(const std::optional<Vec3>& p_W) {
  state_->Renew(state_->contact_W, p_W);
  state_->PlaceHandpiece();
}

const std::optional<Vec3>& SceneActors::contact() const {
  return state_->contact_W;
}

void SceneActors::UpdateSightHoles(const ViewCamera& camera, double depth) {
  State& s = *state_;
  if (!s.tool || s.handpiece == nullptr) return;
  SightHole hole;
  // A window that contains the whole handpiece, at every depth.
  const SightHole ghostly{.x_px = 0, .y_px = 0, .depth = 2, .radius_px = 1e6, .strength = 1, .alpha = 0.3};
  const auto at = s.contact_W ? camera.Project(*s.contact_W) : std::nullopt;
  if (at) {
    hole.x_px = at->x;
    hole.y_px = camera.height() - at->y;
    hole.depth = depth;
    const double mm = camera.WorldPerPixel(*s.contact_W);
    const auto radius = [&](double of_tool, double least, double most) {
      return std::clamp(of_tool * CalcReach(*s.tool) / mm, least * s.scale, most * s.scale);
    };
    hole.strength = 1;
    hole.alpha = 0.08;
    hole.radius_px = radius(1.2, 40, 180);
    SetSightHole(*s.handpiece, s.handpiece_in_bone ? ghostly : hole);
    if (s.guard == nullptr) return;
    SetSightHole(*s.guard, hole);
    // A disc that is seen edge-on hides nothing.
    const Vec3 sight = glm::normalize(camera.CalcRay(*at).direction_W);
    const double facing = std::abs(glm::dot(sight, s.X_WT.Vector({0, 0, 1})));
    hole.strength = std::clamp((facing - 0.15) / 0.35, 0.0, 1.0);
    hole.alpha = 0.25;
    hole.radius_px = radius(0.5, 16, 90);
    for (const auto& actor : {s.toothed, s.turning, s.blur}) SetSightHole(*actor, hole);
    return;
  }
  SetSightHole(*s.handpiece, s.handpiece_in_bone ? ghostly : hole);
  if (s.guard == nullptr) return;
  for (const auto& actor : {s.guard, s.toothed, s.turning, s.blur}) SetSightHole(*actor, hole);
}

void SceneActors::SetToolPose(const Pose& X_WT, double rpm, double angle_rad, double displacement_mm) {
  State& s = *state_;
  const bool moved = s.X_WT.p_AB != X_WT.p_AB || s.X_WT.R_AB != X_WT.R_AB;
  s.X_WT = X_WT;
  const bool whirled = s.Whirls();
  s.rpm = rpm;
  const double shown_rad =
      s.Whirls() || s.passed != nullptr ? s.angle_rad : angle_rad;  // looks the same at every angle
  const bool slid = std::exchange(s.displacement_mm, displacement_mm) != displacement_mm;
  if (moved || slid || s.Whirls() != whirled || shown_rad != s.angle_rad) ++s.changes;
  s.angle_rad = shown_rad;
  s.PlaceHandpiece();
  if (s.toothed == nullptr) return;
  const bool strokes = s.passed != nullptr;
  SetPose(*s.toothed, strokes ? s.EdgePose() : Pose{X_WT.R_AB * glm::angleAxis(angle_rad, Vec3{0, 0, 1}), X_WT.p_AB});
  if (strokes) {
    SetPose(*s.passed, X_WT);
    SetPose(*s.passed_rim, X_WT);
  }
  if (s.turning != nullptr) SetPose(*s.turning, X_WT);
  if (s.blur != nullptr) SetPose(*s.blur, X_WT);
  s.ShowTool();
}

void SceneActors::SetToolColour(const Rgb8& colour) {
  ++state_->changes;
  for (auto* actor : {&state_->toothed, &state_->turning}) {
    if (*actor != nullptr) (*actor)->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  }
}

void SceneActors::SetGhost(const std::optional<Pose>& X_WH) {
  State& s = *state_;
  if (s.ghost == nullptr) return;
  if (X_WH || s.ghost_shown) ++s.changes;
  s.ghost_shown = X_WH.has_value();
  s.ghost->SetVisibility(s.ghost_shown);
  if (X_WH) SetPose(*s.ghost, *X_WH);
}

void SceneActors::SetForce(const std::optional<ForceArrow>& force, const ViewCamera& camera, const ScreenBox& area) {
  State& s = *state_;
  s.force = force;
  if (s.arrow != nullptr) s.over.RemoveActor(s.arrow);
  s.arrow = nullptr;
  if (!force || !(glm::length(force->f_W_N) > 0.02)) {
    s.force.reset();
    return;
  }
  const double mm_per_point = camera.WorldPerPixel(force->p_W) * s.scale;
  const double N = glm::length(force->f_W_N);
  const Vec3 back_W = -force->f_W_N / N;
  const double wanted = std::clamp(kArrow_mm_per_N * N, 26 * mm_per_point, kMaxArrow_mm);
  const double length = CalcArrowLength(camera, force->p_W, back_W, wanted, area);
  s.force_tail_W = force->p_W + length * back_W;
  const double shaft = std::min(2.6 * mm_per_point, 0.06 * length);
  s.arrow = MakeMeshActor(MakeArrowMesh(s.force_tail_W, force->p_W, shaft), kForceColour, 1, Finish::kMatt);
  s.over.AddActor(s.arrow);
}

void SceneActors::SetPlanes(const std::vector<PlaneOverlay>& planes) {
  State& s = *state_;
  if (!s.Renew(s.planes, planes)) return;
  s.Remove(s.scene, s.plane_actors);
  for (const PlaneOverlay& plane : planes) {
    const std::vector<Vec3> corners =
        MakeRectangle(plane.p_W, plane.normal_W, plane.up_W, plane.width_mm, plane.height_mm);
    s.Add(s.scene, s.plane_actors,
          MakeLineActor({Closed(corners)}, plane.colour, (plane.selected ? 4.0 : 2.0) * s.scale));
    s.Add(s.scene, s.plane_actors,
          MakeMeshActor(MakePolygon(corners), plane.colour,
                        plane.faint      ? 0.05
                        : plane.selected ? 0.34
                                         : 0.22,
                        Finish::kFlat));
  }
}

void SceneActors::SetDepthStops(const std::vector<DepthStopOverlay>& stops) {
  State& s = *state_;
  if (!s.Renew(s.stops, stops)) return;
  s.Remove(s.scene, s.stop_actors);
  for (const DepthStopOverlay& stop : stops) {
    const Rgb8 colour = stop.reached ? kReachedColour : kStopColour;
    const std::vector<Vec3> circle = MakeCircle(stop.p_W, stop.normal_W, stop.radius_mm, 72);
    // Hatched, to distinguish it from the planes of the plan.
    std::vector<std::vector<Vec3>> lines{Closed(circle)};
    for (std::size_t i = 4; i < 36; i += 4) lines.push_back({circle[i], circle[72 - i]});
    s.Add(s.scene, s.stop_actors, MakeLineActor(lines, colour, (stop.reached ? 3.0 : 1.6) * s.scale));
    s.Add(s.scene, s.stop_actors, MakeMeshActor(MakePolygon(circle), colour, 0.16, Finish::kFlat));
  }
}

void SceneActors::SetGuides(const std::vector<GuideOverlay>& guides) {
  State& s = *state_;
  if (!s.Renew(s.guides, guides)) return;
  s.Remove(s.over, s.guide_actors);
  for (const GuideOverlay& guide : guides) {
    if (guide.points_W.size() < 2) continue;
    s.Add(s.over, s.guide_actors, MakeLineActor({guide.points_W}, guide.colour, 3 * s.scale));
  }
}

void SceneActors::SetMeasures(const std::vector<MeasureOverlay>& measures) {
  state_->Renew(state_->measures, measures);
}

void SceneActors::SetPieces(const std::vector<PieceShape>& pieces) {
  State& s = *state_;
  ++s.changes;
  s.pieces = pieces;
  std::map<int, State::PieceActor> kept;
  for (const PieceShape& piece : pieces) {
    if (piece.mesh_W == nullptr) continue;
    State::PieceActor& to = kept[piece.id];
    const auto at = s.piece_actors.find(piece.id);
    if (at != s.piece_actors.end() && at->second.mesh == piece.mesh_W && at->second.colours == piece.point_colours) {
      to = at->second;
      s.piece_actors.erase(at);
    } else {
      to.mesh = piece.mesh_W;
      to.colours = piece.point_colours;
      to.actor = MakeMeshActor(*piece.mesh_W, piece.colour, 1, Finish::kMatt, piece.point_colours.get());
      Include(piece.mesh_W->points, to.box);
      to.frame = MakeLineActor(MakeBoxEdges(to.box.Grown(0.4)), kForceColour, 1.6 * s.scale);
      s.scene.AddActor(to.actor);
      s.scene.AddActor(to.frame);
      s.tool_is_last = false;
    }
    const Rgb8 colour = piece.selected ? Lighter(piece.colour, 0.3, {255, 255, 255}) : piece.colour;
    to.actor->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
    to.actor->GetProperty()->SetAmbient(piece.selected ? 0.34 : 0.22);
    to.actor->SetVisibility(!piece.hidden);
    to.frame->SetVisibility(piece.selected && !piece.hidden);
    SetPose(*to.actor, piece.X_WP);
    SetPose(*to.frame, piece.X_WP);
  }
  for (const auto& [id, gone] : s.piece_actors) {
    s.scene.RemoveActor(gone.actor);
    s.scene.RemoveActor(gone.frame);
  }
  s.piece_actors = std::move(kept);
}

const std::vector<PieceShape>& SceneActors::pieces() const {
  return state_->pieces;
}

void SceneActors::SetBridges(const std::vector<BridgeOverlay>& bridges) {
  state_->Renew(state_->bridges, bridges);
}
void SceneActors::SetPoints(const std::vector<PointOverlay>& points) {
  state_->Renew(state_->points, points);
}
const std::vector<PointOverlay>& SceneActors::points() const {
  return state_->points;
}
void SceneActors::SetPlaneHandles(const std::vector<PlaneHandleOverlay>& handles) {
  state_->Renew(state_->handles, handles);
}
const std::vector<PlaneHandleOverlay>& SceneActors::plane_handles() const {
  return state_->handles;
}
void SceneActors::SetPlaneLines(const std::vector<PlaneLineOverlay>& lines) {
  state_->Renew(state_->plane_lines, lines);
}
void SceneActors::SetAlarms(const std::vector<AlarmOverlay>& alarms) {
  state_->Renew(state_->alarms, alarms);
}
const std::vector<AlarmOverlay>& SceneActors::alarms() const {
  return state_->alarms;
}

void SceneActors::SetMarks(const std::vector<MarkOverlay>& marks) {
  State& s = *state_;
  if (!s.Renew(s.marks, marks)) return;
  s.Remove(s.scene, s.mark_actors);
  for (const MarkOverlay& mark : marks) {
    const TriangleMesh tube = MakeTubeMesh(mark.points_W, mark.radius_mm);
    if (tube.triangles.empty()) continue;
    s.Add(s.scene, s.mark_actors, MakeMeshActor(tube, mark.colour, 1, Finish::kMatt));
    if (mark.selected) s.mark_actors.back()->GetProperty()->SetAmbient(0.5);
  }
}

XrayList SceneActors::MakeXrayList(double surface_mm, Theme theme) const {
  const State& s = *state_;
  XrayList list;
  AddBridges(s.bridges, list);
  AddPlaneLines(s.plane_lines, surface_mm, list);
  AddMarkLines(s.marks, list);
  AddMeasures(s.measures, list);
  if (s.tool) AddToolOutline(s.outline_T, s.EdgePose(), CalcThickness(*s.tool), theme, list);
  AddPoints(s.points, list);
  AddPlaneHandles(s.handles, list);
  return list;
}

ScreenBox SceneActors::CalcToolBox(const ViewCamera& camera) const {
  const State& s = *state_;
  if (!s.tool) return {};
  Box3 box;
  for (const Vec3& p_W : MakeToolOutline(*s.tool, s.X_WT, camera, 16)) {
    if (const auto at = camera.Project(p_W)) box.Include({at->x, at->y, 0});
  }
  if (box.empty()) return {};
  return {box.lower.x, box.lower.y, box.size().x, box.size().y};
}

bool SceneActors::IsOnTool(const ViewCamera& camera, const ScreenPoint& at) const {
  const State& s = *state_;
  if (!s.tool) return false;
  bool inside = false;
  std::optional<ScreenPoint> last;
  for (const Vec3& p_W : MakeToolOutline(*s.tool, s.X_WT, camera, 48)) {
    const auto p = camera.Project(p_W);
    if (!p) return false;
    // Counts the edges that a line from the pixel to the right crosses.
    if (last && (last->y > at.y) != (p->y > at.y)) {
      const double x = last->x + (at.y - last->y) / (p->y - last->y) * (p->x - last->x);
      if (x > at.x) inside = !inside;
    }
    last = *p;
  }
  return inside;
}

const std::vector<MeasureOverlay>& SceneActors::measures() const {
  return state_->measures;
}

Box3 SceneActors::CalcBounds() const {
  const State& s = *state_;
  Box3 box;
  if (s.inner_shown && !s.inner_box.empty()) {
    box.Include(s.inner_box.lower);
    box.Include(s.inner_box.upper);
  }
  if (s.tool) {
    const double reach = std::max(5 * CalcReach(*s.tool), s.handpiece_shown ? CalcHandpieceReach(*s.tool) : 0);
    box.Include(s.X_WT.p_AB - reach);
    box.Include(s.X_WT.p_AB + reach);
  }
  for (const PlaneOverlay& p : s.planes) {
    Include(MakeRectangle(p.p_W, p.normal_W, p.up_W, p.width_mm, p.height_mm), box);
  }
  for (const DepthStopOverlay& stop : s.stops) {
    box.Include(stop.p_W - stop.radius_mm);
    box.Include(stop.p_W + stop.radius_mm);
  }
  for (const GuideOverlay& guide : s.guides) Include(guide.points_W, box);
  for (const MarkOverlay& mark : s.marks) Include(mark.points_W, box);
  for (const MeasureOverlay& measure : s.measures) Include(measure.points_W, box);
  if (s.force) {
    box.Include(s.force_tail_W);
    box.Include(s.force->p_W);
  }
  for (const PieceShape& piece : s.pieces) {
    const auto at = s.piece_actors.find(piece.id);
    if (piece.hidden || at == s.piece_actors.end() || at->second.box.empty()) continue;
    const double reach = 0.5 * glm::length(at->second.box.size());
    const Vec3 middle = piece.X_WP.Point(at->second.box.centre());
    box.Include(middle - reach);
    box.Include(middle + reach);
  }
  return box;
}

std::vector<SceneLabel> SceneActors::MakeLabels(const ViewCamera& camera) const {
  const State& s = *state_;
  std::vector<SceneLabel> labels;
  const auto add = [&](const std::string& text, const Vec3& p_W, const Rgb8& colour, bool matters = false) {
    const auto at = camera.Project(p_W);
    if (!text.empty() && at) labels.push_back({text, at->x, at->y, colour, matters});
  };
  // The most important first: they get the best places.
  for (const AlarmLevel level : {AlarmLevel::kDanger, AlarmLevel::kWarning, AlarmLevel::kNotice}) {
    for (const AlarmOverlay& alarm : s.alarms) {
      if (alarm.level == level) add(alarm.label, alarm.p_W, AlarmColour(level), level != AlarmLevel::kNotice);
    }
  }
  if (s.force) {
    const double N = glm::length(s.force->f_W_N);
    add(s.force->label.empty() ? fmt::format("{:.1f} N on your hand", N) : s.force->label, s.force_tail_W, kForceColour,
        true);
  }
  for (const BridgeOverlay& bridge : s.bridges) {
    add(bridge.label, bridge.centre_W, kBridgeColour, &bridge == &s.bridges.front());
  }
  for (const PointOverlay& point : s.points) add(point.label, point.p_W, PointColour(point.kind));
  for (const MarkOverlay& mark : s.marks) {
    if (!mark.points_W.empty()) add(mark.label, mark.points_W.front(), mark.colour);
  }
  for (const MeasureOverlay& measure : s.measures) {
    if (measure.points_W.empty()) continue;
    const bool angle = measure.points_W.size() > 2;
    const Vec3 at = angle ? measure.points_W[1] : 0.5 * (measure.points_W.front() + measure.points_W.back());
    add(measure.label, at, kMeasureColour);
  }
  for (const PlaneOverlay& p : s.planes) {
    add(p.name, MakeRectangle(p.p_W, p.normal_W, p.up_W, p.width_mm, p.height_mm)[2], p.colour);
  }
  for (const DepthStopOverlay& stop : s.stops) {
    const Rgb8 colour = stop.reached ? kReachedColour : kStopColour;
    add(stop.reached ? stop.name + " (reached)" : stop.name, MakeCircle(stop.p_W, stop.normal_W, stop.radius_mm, 8)[1],
        colour);
  }
  return labels;
}

double CalcArrowLength(const ViewCamera& camera, const Vec3& tip_W, const Vec3& back_W, double wanted_mm,
                       const ScreenBox& area) {
  const double most_px = std::min(camera.width(), camera.height()) / 3.0;
  const auto tip = camera.Project(tip_W);
  if (!tip) return wanted_mm;
  const auto is_in_area = [&](const ScreenPoint& p) {
    constexpr double kRim_px = 12;
    return area.empty() || (p.x >= area.left + kRim_px && p.x <= area.left + area.width - kRim_px &&
                            p.y >= area.top + kRim_px && p.y <= area.top + area.height - kRim_px);
  };
  const bool tip_is_in_area = is_in_area(*tip);
  const auto fits = [&](double length_mm) {
    const auto tail = camera.Project(tip_W + length_mm * back_W);
    return tail && std::hypot(tail->x - tip->x, tail->y - tip->y) <= most_px && (!tip_is_in_area || is_in_area(*tail));
  };
  if (fits(wanted_mm)) return wanted_mm;
  // An arrow to the eye appears longer the longer it is, so the longest that fits is found by bisection.
  double fitting = 0;
  double over = wanted_mm;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (fitting + over);
    (fits(middle) ? fitting : over) = middle;
  }
  return fitting;
}

}  // namespace kerf
