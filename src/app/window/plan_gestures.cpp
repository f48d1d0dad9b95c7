#include "app/window/plan_gestures.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <utility>

#include "app/window/mark_place.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr double kPickRadius = 12;  // of points, points of the screen

const Range kDepthRange_mm = FindRange<DepthStop>("depth_mm");

std::optional<double> ParseDepth(const std::string& text) {
  const std::optional<double> depth_mm = ParseNumber(text);
  if (!depth_mm || !kDepthRange_mm.Contains(*depth_mm)) return {};
  return depth_mm;
}

const char* DescribeHandle(PlaneHandleKind kind) {
  switch (kind) {
    case PlaneHandleKind::kCentre:
      return Tr("Drag to move the rectangle within its plane.");
    case PlaneHandleKind::kNormal:
      return Tr("Drag to move the plane along the arrow.");
    case PlaneHandleKind::kTiltAcross:
    case PlaneHandleKind::kTiltUp:
      return Tr("Drag to tilt the plane about its middle.");
    default:
      return Tr("Drag to change the size of the rectangle.");
  }
}

HandleKind ToHandleKind(PlaneHandleKind kind) {
  switch (kind) {
    case PlaneHandleKind::kTiltAcross:
    case PlaneHandleKind::kTiltUp:
      return HandleKind::kTilt;
    case PlaneHandleKind::kCorner:
      return HandleKind::kSize;
    default:
      return HandleKind::kMove;
  }
}

}  // namespace

void PlanGestures::Place(Placing what, MarkKind kind) {
  viewer_.controls().Release();
  viewer_.SetSpindle(false);
  placing_ = Placement{what, kind, {}, viewer_.slices().is_enlarged()};
  document_.set_mark_index({});
}

std::optional<Vec3> PlanGestures::PickBone(const ScreenPoint& at) const {
  const std::shared_ptr<SurfaceWorker>& surface = viewer_.bone().surface();
  if (!surface) return std::nullopt;
  return surface->Pick(viewer_.view().camera().CalcRay(at));
}

bool PlanGestures::TakePoint(const Vec3& p_W) {
  if (!placing_) return false;
  placing_->points_W.push_back(p_W);
  viewer_.trace().Write("point", {{"mm", {p_W.x, p_W.y, p_W.z}}});
  // A plane of three points can still be changed; its points are confirmed with Enter.
  if (placing_->what == Placing::kStop) {
    placing_.reset();
    AskDepth(p_W);
  } else if (placing_->what == Placing::kPlane && placing_->points_W.size() == 3) {
    FinishPlacing();
  } else if (placing_->what == Placing::kMark) {
    SayPlace(placing_->kind, placing_->points_W.size(), p_W);
  }
  return true;
}

/// Says so if a point of a mark lies where such a structure can hardly be.
void PlanGestures::SayPlace(MarkKind kind, std::size_t number, const Vec3& p_W) {
  const std::shared_ptr<const Bone> bone = viewer_.bone_at_start();
  if (!bone) return;
  const MarkPlace place = FindMarkPlace(*bone, viewer_.bone().ct(), kind, p_W);
  if (place == MarkPlace::kUsual) return;
  viewer_.Warn(place == MarkPlace::kInAir
                   ? fmt::format(fmt::runtime(Tr("Point {} lies in air.")), number)
                   : fmt::format(fmt::runtime(Tr("Point {} lies more than {} mm from the bone.")), number,
                                 ShowNumber(kMarkFar_mm, 0)));
}

void PlanGestures::MoveListed(std::size_t i, const Vec3& p_W, bool first) {
  if (i >= ListPoints().size()) return;
  if (placing_) {
    placing_->points_W[i] = p_W;
    return;
  }
  try {
    PlanContent next = document_.now();
    MovePoint(next.marks[*document_.mark_index()], i, p_W);
    first ? document_.Change(std::move(next), Tr("point moved")) : document_.Amend(std::move(next));
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

void PlanGestures::TakeBackPoint() {
  if (placing_ && !placing_->points_W.empty()) placing_->points_W.pop_back();
}

void PlanGestures::FinishPlacing() {
  const Placement placed = *std::exchange(placing_, std::nullopt);
  if (!placed.was_enlarged) viewer_.slices().Shrink();  // a slice that was enlarged for the points hides the scene
  try {
    if (placed.what == Placing::kPlane && placed.points_W.size() >= 3) {
      const std::vector<Vec3>& p_W = placed.points_W;
      document_.AddFitted(PlacePlane(MakePlaneName(document_.plan()), p_W[0], p_W[1], p_W[2]), p_W);
    } else if (placed.what == Placing::kMark && !placed.points_W.empty()) {
      PlanContent next = document_.now();
      Mark mark;
      mark.name = MakeMarkName(next.marks, placed.kind);
      mark.kind = placed.kind;
      mark.radius_mm = placed.kind == MarkKind::kTooth ? 2.5 : 1.0;
      for (const Vec3& p_W : placed.points_W) AddPoint(mark, p_W);
      next.marks.push_back(std::move(mark));
      document_.Change(std::move(next), Tr("new mark"));
      document_.set_mark_index(document_.marks().size() - 1);
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

std::vector<Vec3> PlanGestures::ListPoints() const {
  if (placing_) return placing_->points_W;
  if (const auto mark = document_.mark_index()) return document_.marks()[*mark].points_W;
  return {};
}

std::optional<Vec3> PlanGestures::latest_point_W() const {
  if (!placing_ || placing_->points_W.empty()) return std::nullopt;
  const bool drags = drag_ && drag_->what == Drag::What::kPlacedPoint && drag_->index < placing_->points_W.size();
  return drags ? placing_->points_W[drag_->index] : placing_->points_W.back();
}

bool PlanGestures::TakePress(const ScreenPoint& at) {
  const double radius_px = kPickRadius * viewer_.options().scale;
  if (const std::optional<int> point = viewer_.view().PickPoint(at, radius_px)) {
    const auto i = static_cast<std::size_t>(*point);
    if (i < ListPoints().size()) {
      Drag drag;
      drag.what = placing_ ? Drag::What::kPlacedPoint : Drag::What::kMarkPoint;
      drag.index = i;
      drag.from = at;
      drag_ = drag;
      return true;
    }
  }
  if (placing_) {
    const std::optional<Vec3> p_W = PickBone(at);
    if (!p_W) {
      viewer_.Say(Tr("There is no bone under the mouse"));
      return true;
    }
    return TakePoint(*p_W);
  }
  // A saw that is in the bone is moved, rather than what lies under it.
  if (viewer_.spindle_on() || (viewer_.touches() && viewer_.view().IsOnTool(at))) return false;
  const std::optional<int> handle = viewer_.view().PickHandle(at);
  if (!handle || document_.plane() == nullptr || static_cast<std::size_t>(*handle) >= handles_.size()) return false;
  Drag drag;
  drag.handle = handles_[static_cast<std::size_t>(*handle)];
  drag.plane = *document_.plane();
  drag.from = at;
  drag_ = drag;
  return true;
}

void PlanGestures::TakeMotion(const ScreenPoint& at) {
  Drag& drag = *drag_;
  const bool first = !std::exchange(drag.moved, true);
  try {
    if (drag.what == Drag::What::kPlacedPoint) {
      if (const std::optional<Vec3> p_W = PickBone(at)) placing_->points_W[drag.index] = *p_W;
      return;
    }
    PlanContent next = document_.now();
    if (drag.what == Drag::What::kMarkPoint) {
      // On the bone if there is any under the mouse, otherwise at the point's depth.
      const Vec3 before_W = next.marks[*document_.mark_index()].points_W[drag.index];
      const ViewCamera& camera = viewer_.view().camera();
      const std::optional<Vec3> on_bone_W = PickBone(at);
      const auto spot = camera.Project(before_W);
      const Vec3 moved_W = spot ? before_W + camera.WorldMotion(at.x - spot->x, at.y - spot->y, before_W) : before_W;
      return MoveListed(drag.index, on_bone_W.value_or(moved_W), first);
    } else {
      const auto sight = [&](const ScreenPoint& p) {
        const Ray ray = viewer_.view().camera().CalcRay(p);
        return SightLine{ray.origin_W, ray.direction_W};
      };
      next.plan.planes[document_.plane_index()] = DragHandle(drag.plane, drag.handle, sight(drag.from), sight(at));
    }
    if (first) {
      document_.Change(std::move(next), Tr("plane moved"));
    } else {
      document_.Amend(std::move(next));
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

bool PlanGestures::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  const ScreenPoint at{event.x, event.y};
  if (event.kind == Kind::kMouseMove) mouse_ = at;
  if (drag_) {
    if (event.kind == Kind::kMouseMove) {
      TakeMotion(at);
      return true;
    }
    if (event.kind == Kind::kMouseUp && event.button == MouseButton::kLeft) {
      drag_.reset();
      return true;
    }
  }
  if (event.kind == Kind::kMouseDown && event.button == MouseButton::kLeft && !event.shift && !event.control) {
    return TakePress(at);
  }
  if (event.kind != Kind::kKeyDown || event.control) return false;
  if (placing_) {
    switch (event.key) {
      case Key::kEscape:
        placing_.reset();
        return true;
      case Key::kEnter:
        FinishPlacing();
        return true;
      case Key::kBackspace:
        TakeBackPoint();
        return true;
      default:
        return false;
    }
  }
  return false;
}

void PlanGestures::AskDepth(const Vec3& p_W) {
  viewer_.AskText(Tr("Depth in mm:"), "5", [this, p_W](const std::optional<std::string>& text) {
    if (!text) return;
    const std::optional<double> depth_mm = ParseDepth(*text);
    if (!depth_mm) {
      return viewer_.Say(
          fmt::format(fmt::runtime(Tr("The depth must be a number from {}")), ShowRange(kDepthRange_mm, "mm")));
    }
    PlanContent next = document_.now();
    DepthStop stop;
    stop.name = MakeStopName(next.plan);
    stop.p_W_mm = p_W;
    // The direction into the bone: from the blade's current centre to the point.
    stop.direction_W = CalcDirection(p_W - viewer_.figures().coupled.X_WT.p_AB).value_or(viewer_.MakeBasis().forward_W);
    stop.depth_mm = *depth_mm;
    next.plan.stops.push_back(stop);
    document_.Change(std::move(next), Tr("new depth stop"));
  });
}

void PlanGestures::Reset() {
  placing_.reset();
  drag_.reset();
}

std::vector<PointOverlay> PlanGestures::ListPointOverlays() const {
  std::vector<PointOverlay> points;
  const std::vector<Vec3> listed = ListPoints();
  for (std::size_t i = 0; i < listed.size(); ++i) {
    points.push_back({.p_W = listed[i],
                      .kind = placing_ && placing_->what != Placing::kMark ? PointKind::kPlan : PointKind::kMark,
                      .label = fmt::format("{}", i + 1),
                      .selected = drag_ && drag_->what != Drag::What::kHandle && drag_->index == i});
  }
  return points;
}

void PlanGestures::Show() {
  handles_.clear();
  std::vector<PlaneHandleOverlay> handles;
  // A turning saw needs the picture for itself.
  if (document_.plane() != nullptr && !placing_ && !viewer_.spindle_on()) handles_ = PlaneHandles(*document_.plane());
  const PlaneHandle* const hovered = FindHovered();
  for (const PlaneHandle& handle : handles_) {
    const bool dragged = drag_ && drag_->what == Drag::What::kHandle && drag_->handle.kind == handle.kind &&
                         drag_->handle.corner == handle.corner;
    const bool hot = dragged || &handle == hovered;
    handles.push_back({handle.p_W, ToHandleKind(handle.kind), hot});
  }
  viewer_.view().SetPlaneHandles(handles);

  viewer_.view().SetPoints(ListPointOverlays());
}

/// Returns the handle under the mouse; null if there is none or another one is dragged.
const PlaneHandle* PlanGestures::FindHovered() const {
  if (drag_ || !mouse_ || handles_.empty() || viewer_.ui().IsOnPanel(mouse_->x, mouse_->y)) return nullptr;
  const std::optional<int> handle = viewer_.view().PickHandle(*mouse_);
  return handle && static_cast<std::size_t>(*handle) < handles_.size() ? &handles_[static_cast<std::size_t>(*handle)]
                                                                       : nullptr;
}

void PlanGestures::DrawHint(const Ui& ui) const {
  const PlaneHandle* const hovered = FindHovered();
  if (hovered == nullptr || !ui.tooltips()) return;
  const bool on_saw = viewer_.view().IsOnTool(*mouse_);
  ImGui::SetTooltip("%s%s%s", DescribeHandle(hovered->kind), on_saw ? "\n" : "",
                    on_saw ? Tr("Beside the handle, drag the blade to move the saw.") : "");
}

void PlanGestures::Hide() {
  viewer_.view().SetPlaneHandles({});
  viewer_.view().SetPoints({});
  handles_.clear();
}

void PlanGestures::Fill(HudState& hud) const {
  if (!placing_) return;
  const std::size_t count = placing_->points_W.size();
  HudBanner banner;
  banner.kind = HudBanner::Kind::kQuestion;
  if (placing_->what == Placing::kPlane) {
    banner.text = fmt::format(fmt::runtime(Tr("Click a point of the plane on the bone ({} of 3)")), count + 1);
    banner.answers = Tr("drag a point to move it   Backspace: remove the last   Esc: cancel");
  } else if (placing_->what == Placing::kStop) {
    banner.text = Tr("Click where the cut begins on the bone");
    banner.answers = Tr("Esc: cancel");
  } else {
    banner.text =
        fmt::format(fmt::runtime(Tr("Click points along the structure, on the bone or in a slice ({} so far)")), count);
    banner.answers = Tr("Enter: done   drag a point to move it   Backspace: remove the last   Esc: cancel");
  }
  hud.banner = banner;
}

void PlanGestures::Describe(nlohmann::json& state) const {
  const PlaneHandle* const hovered = FindHovered();
  state["handle"] = hovered != nullptr ? static_cast<int>(hovered - handles_.data()) : -1;
  state["placed"] = placing_ ? static_cast<int>(placing_->points_W.size()) : -1;
  state["placed_mm"] = nlohmann::json::array();
  for (const Vec3& p : ListPoints()) state["placed_mm"].push_back({p.x, p.y, p.z});
  state["handles"] = nlohmann::json::array();
  for (const PlaneHandle& handle : handles_) {
    const auto at = viewer_.view().camera().Project(handle.p_W);
    if (at) state["handles"].push_back({std::round(at->x), std::round(at->y)});
  }
}

}  // namespace kerf
