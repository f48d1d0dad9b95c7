#include "view/live/scene_actors.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cut/tool/shape.h"
#include "kerf/tool.h"
#include "view/live/overlay_colours.h"
#include "view/live/palette.h"
#include "view/live/scene_actors_state.h"
#include "view/live/scene_shapes.h"
#include "view/picture/colours.h"
#include "view/picture/handpiece.h"

namespace kerf {
namespace {

constexpr Rgb8 kStopColour{160, 90, 0};
constexpr Rgb8 kReachedColour{190, 40, 20};

Rgb8 Lighter(const Rgb8& c, double fraction, const Rgb8& to) {
  Rgb8 mixed{};
  for (std::size_t i = 0; i < 3; ++i) mixed[i] = static_cast<std::uint8_t>(c[i] + fraction * (to[i] - c[i]));
  return mixed;
}

void Include(const std::vector<Vec3>& points, Box3& box) {
  for (const Vec3& p : points) box.Include(p);
}

}  // namespace

void SceneActors::State::Remove(vtkRenderer& from, Actors& actors) {
  for (const auto& actor : actors) from.RemoveActor(actor);
  actors.clear();
}

void SceneActors::State::Add(vtkRenderer& to, Actors& actors, const vtkSmartPointer<vtkActor>& actor) {
  to.AddActor(actor);
  actors.push_back(actor);
  tool_is_last = false;
}

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

}  // namespace kerf
