// The actors of SceneActors that show the tool: blade, handpiece, ghost, and the force on it.
#include <vtkActor.h>
#include <vtkPropCollection.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "cut/tool/edge_motion.h"
#include "cut/tool/looks.h"
#include "cut/tool/shape.h"
#include "kerf/tool.h"
#include "view/live/scene_actors.h"
#include "view/live/scene_actors_state.h"
#include "view/live/scene_shapes.h"
#include "view/picture/colours.h"
#include "view/picture/handpiece.h"
#include "view/picture/turn_arrow.h"

namespace kerf {
namespace {

constexpr Rgb8 kGhostColour{0, 114, 178};
constexpr Rgb8 kHandpieceColour{206, 212, 219};
constexpr Rgb8 kGuardColour{150, 160, 172};
constexpr double kSeenStrokes_per_min = 600;  // faster strokes are not seen one by one
constexpr Rgb8 kPassedColour{230, 120, 30};
constexpr double kPassedOpacity = 0.3;

/// Bent arrow around the neck of the handpiece of a tool that turns.
struct TurnArrowPlace {
  double z_mm;
  double radius_mm;
};
TurnArrowPlace FindTurnArrowPlace(const Tool& tool) {
  const double radius = CalcRadius(tool);
  if (const auto solid = CalcRoundSolid(tool)) return {solid->top_z_mm + 2.5, std::max(1.6 * radius, 2.5)};
  return IsBlade(tool) ? TurnArrowPlace{0.3 * radius, 0.4 * radius} : TurnArrowPlace{1.3 * radius, 1.1 * radius};
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

}  // namespace

bool SceneActors::State::Whirls() const {
  return turning != nullptr && std::abs(rpm) * CountPassesPerTurn(*tool) / 60 > 15;
}

std::vector<vtkActor*> SceneActors::State::ToolActors() const {
  std::vector<vtkActor*> all;
  for (const auto* actor : {&toothed, &turning, &blur, &passed, &passed_rim, &guard, &handpiece, &turn_arrow}) {
    if (*actor != nullptr) all.push_back(*actor);
  }
  return all;
}

void SceneActors::State::PlaceHandpiece() {
  if (handpiece != nullptr) {
    SetPose(*handpiece, X_WT);
    handpiece->SetVisibility(handpiece_shown);
  }
  if (turn_arrow != nullptr) {
    // Drawn for a positive speed; half a turn about an axis across the spindle reverses it.
    const Quat R_TA = rpm < 0 ? Quat{0, 1, 0, 0} : Quat{1, 0, 0, 0};
    SetPose(*turn_arrow, {X_WT.R_AB * R_TA, X_WT.Point({0, 0, FindTurnArrowPlace(*tool).z_mm})});
    turn_arrow->SetVisibility(handpiece_shown && rpm != 0);
  }
  if (guard == nullptr) return;
  guard->SetVisibility(handpiece_shown);
  const Vec3 away_T = contact_W ? -X_WT.InversePoint(*contact_W) : X_WT.InverseVector({0, 0, 1});
  const double angle = std::hypot(away_T.x, away_T.y) > 1e-3 ? std::atan2(away_T.y, away_T.x) : 0;
  SetPose(*guard, {X_WT.R_AB * glm::angleAxis(angle, Vec3{0, 0, 1}), X_WT.p_AB});
}

void SceneActors::State::ShowTool() {
  if (toothed == nullptr) return;
  const bool whirls = Whirls();
  toothed->SetVisibility(!whirls);
  if (turning != nullptr) turning->SetVisibility(whirls);
  if (blur != nullptr) blur->SetVisibility(whirls);
  for (const auto& actor : {passed, passed_rim}) {
    if (actor != nullptr) actor->SetVisibility(std::abs(rpm) > kSeenStrokes_per_min);
  }
}

Pose SceneActors::State::EdgePose() const {
  return EdgeMotion(tool ? CalcSwingRadius(*tool) : 0).Move(X_WT, displacement_mm);
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
  if (GetDrive(tool) == DriveMotion::kRotation) {
    constexpr double kEnd_rad = 2.6;
    const double radius = FindTurnArrowPlace(tool).radius_mm;
    s.turn_arrow =
        MakeMeshActor(MakeTurnArrowMesh(radius, 0.08 * radius, -kEnd_rad, kEnd_rad), kTurnColour, 1, Finish::kMatt);
  } else {
    const std::vector<Vec3> corners = MakeStrokeCorners(tool, {});
    s.passed = MakeMeshActor(MakePolygon(corners), kPassedColour, kPassedOpacity, Finish::kFlat);
    s.passed_rim = MakeLineActor({Closed(corners)}, kPassedColour, 2.5 * s.scale);
  }
  for (const auto& actor : {s.turning, s.blur, s.passed, s.passed_rim, s.guard, s.turn_arrow}) {
    if (actor != nullptr) s.scene.AddActor(actor);
  }
  s.handpiece = MakeMeshActor(MakeHandpieceMesh(tool), kHandpieceColour, 1, Finish::kMatt);
  AddSightHole(*s.handpiece);
  s.scene.AddActor(s.handpiece);
  for (const auto& actor : {s.toothed, s.turning, s.guard, s.handpiece}) {  // the backs of closed surfaces are hidden
    if (actor != nullptr) actor->GetProperty()->BackfaceCullingOn();
  }
  s.tool_is_last = true;
  s.ShowTool();
  s.PlaceHandpiece();
}

void SceneActors::ClearTool() {
  State& s = *state_;
  ++s.changes;
  for (auto* actor :
       {&s.toothed, &s.turning, &s.blur, &s.passed, &s.passed_rim, &s.guard, &s.handpiece, &s.turn_arrow}) {
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
  const bool was_stopped = std::exchange(s.rpm, rpm) == 0;
  const double shown_rad =
      s.Whirls() || s.passed != nullptr ? s.angle_rad : angle_rad;  // looks the same at every angle
  const bool slid = std::exchange(s.displacement_mm, displacement_mm) != displacement_mm;
  if (moved || slid || s.Whirls() != whirled || shown_rad != s.angle_rad || was_stopped != (rpm == 0)) {
    ++s.changes;
  }
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
