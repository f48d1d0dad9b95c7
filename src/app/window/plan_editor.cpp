#include "app/window/plan_editor.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "kerf/error.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr double kPickRadius = 12;  // of points, points of the screen
constexpr Rgb8 kNerveColour{0, 114, 178};
constexpr Rgb8 kToothColour{204, 121, 167};
constexpr Rgb8 kOtherColour{0, 130, 95};

const Range kDepthRange_mm = FindRange<DepthStop>("depth_mm");

Rgb8 ColourOf(MarkKind kind) {
  return kind == MarkKind::kNerve || kind == MarkKind::kCanal  ? kNerveColour
         : kind == MarkKind::kTooth || kind == MarkKind::kRoot ? kToothColour
                                                               : kOtherColour;
}

/// Returns the smallest rotation from one unit vector to another, less than half a turn.
Quat RotationBetween(const Vec3& from, const Vec3& to) {
  const Vec3 axis = glm::cross(from, to);
  return glm::normalize(Quat{1 + glm::dot(from, to), axis.x, axis.y, axis.z});
}

std::optional<double> ParseDepth(const std::string& text) {
  double depth_mm = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), depth_mm);
  if (error != std::errc{} || end != text.data() + text.size() || !kDepthRange_mm.Contains(depth_mm)) return {};
  return depth_mm;
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

const char* NameOf(PlaneState state) {
  return state == PlaneState::kDone ? Tr("done") : state == PlaneState::kInProgress ? Tr("in progress") : Tr("planned");
}

const PlanesReport::Row* FindRow(const PlanesReport* report, const std::string& name) {
  if (report == nullptr) return nullptr;
  const auto at = std::find_if(report->planes.begin(), report->planes.end(),
                               [&](const PlanesReport::Row& row) { return row.name == name; });
  return at != report->planes.end() ? &*at : nullptr;
}

}  // namespace

// ---- contents

const PlannedPlane* PlanEditor::plane() const {
  return plane_ < plan().planes.size() ? &plan().planes[plane_] : nullptr;
}

void PlanEditor::Load(Plan plan, std::vector<Mark> marks) {
  steps_ = UndoStack<Content>(Content{std::move(plan), std::move(marks)});
  plane_ = 0;
  mark_.reset();
  placing_.reset();
  drag_.reset();
  Changed();
  unsaved_ = false;
}

void PlanEditor::Add(std::vector<PlannedPlane> planes) {
  Content next = steps_.now();
  for (PlannedPlane& plane : planes) {
    plane.name = MakeUniquePlaneName(next.plan, plane.name);
    next.plan.planes.push_back(std::move(plane));
  }
  plane_ = next.plan.planes.empty() ? 0 : next.plan.planes.size() - 1;
  Change(std::move(next), Tr("new plane"));
}

void PlanEditor::Change(Content next, const std::string& what) {
  CheckPlan(next.plan);
  CheckMarks(next.marks);
  steps_.Push(std::move(next), what);
  Changed();
}

bool PlanEditor::is_latest_change() const {
  return steps_.can_undo() && changes_at_edit_ == viewer_.figures().changes;
}

void PlanEditor::Amend(Content next) {
  steps_.Amend(std::move(next));
  Changed();
}

void PlanEditor::Changed() {
  unsaved_ = true;
  changes_at_edit_ = viewer_.figures().changes;
  const Content& now = steps_.now();
  plane_ = std::min(plane_, now.plan.planes.empty() ? 0 : now.plan.planes.size() - 1);
  if (mark_ && *mark_ >= now.marks.size()) mark_.reset();
  tubes_ = MakeMarkTubes(now.marks);
  if (const auto watch = viewer_.cut_watch()) watch->SetPlanes(now.plan.planes);
  viewer_.trace().Write(
      "plan", {{"planes", now.plan.planes.size()}, {"stops", now.plan.stops.size()}, {"marks", now.marks.size()}});
}

// ---- actions

void PlanEditor::AddActions(ActionList& actions, const std::function<bool()>& idle) {
  const auto planned = [this, idle] { return idle() && plane() != nullptr; };
  const auto on_plane = [this](const char* what, const std::function<void(Content&)>& change) {
    return [this, what, change] {
      Content next = steps_.now();
      change(next);
      Change(std::move(next), Tr(what));
    };
  };
  actions.Add({.id = "plan.three_points",
               .menu = Msg("Plan"),
               .label = Msg("Plane through three points"),
               .tip = Msg("click them on the bone"),
               .run = [this] { Place(Placing::kPlane); },
               .enabled = idle,
               .begins_group = true});
  actions.Add({.id = "plan.at_blade",
               .menu = Msg("Plan"),
               .label = Msg("Plane where the blade is"),
               .run = [this] { Add({PlacePlane(MakePlaneName(plan()), viewer_.figures().coupled.X_WT)}); },
               .enabled = idle});
  actions.Add({.id = "plan.stop",
               .menu = Msg("Plan"),
               .label = Msg("Depth stop"),
               .tip = Msg("click its point on the bone"),
               .run = [this] { Place(Placing::kStop); },
               .enabled = idle});
  actions.Add({.id = "plan.align",
               .menu = Msg("Plan"),
               .label = Msg("Turn the saw into the plane"),
               .run = [this] { Align(); },
               .enabled = planned});
  actions.Add({.id = "plan.next",
               .menu = Msg("Plan"),
               .label = Msg("Next plane"),
               .run = [this] { plane_ = (plane_ + 1) % plan().planes.size(); },
               .enabled = [this, idle] { return idle() && plan().planes.size() > 1; }});
  actions.Add({.id = "plan.remove",
               .menu = Msg("Plan"),
               .label = Msg("Remove this plane"),
               .run = on_plane(Msg("plane removed"),
                               [this](Content& next) {
                                 next.plan.planes.erase(next.plan.planes.begin() + static_cast<std::ptrdiff_t>(plane_));
                               }),
               .enabled = planned});
  actions.Add({.id = "plan.mirror",
               .menu = Msg("Plan"),
               .label = Msg("Mirror this plane to the other side"),
               .tip = Msg("at the middle of the bone, left to right"),
               .run = [this] { Add({MirrorPlane(plan(), *plane(), middle_mm_)}); },
               .enabled = planned});
  actions.Add({.id = "plan.remove_stops",
               .menu = Msg("Plan"),
               .label = Msg("Remove all depth stops"),
               .run = on_plane(Msg("depth stops removed"), [](Content& next) { next.plan.stops.clear(); }),
               .enabled = [this, idle] { return idle() && !plan().stops.empty(); }});
  struct MarkAction {
    const char* id;
    const char* label;
    MarkKind kind;
  };
  for (const MarkAction& mark : {MarkAction{"mark.nerve", Msg("Mark a nerve"), MarkKind::kNerve},
                                 MarkAction{"mark.tooth", Msg("Mark a tooth or root"), MarkKind::kTooth},
                                 MarkAction{"mark.other", Msg("Mark another structure"), MarkKind::kOther}}) {
    actions.Add({.id = mark.id,
                 .menu = Msg("Plan"),
                 .label = mark.label,
                 .tip = Msg("click points along it on the bone or in the slices; Enter ends"),
                 .run = [this, kind = mark.kind] { Place(Placing::kMark, kind); },
                 .enabled = idle,
                 .begins_group = mark.kind == MarkKind::kNerve});
  }
  actions.Add({.id = "plan.undo",
               .menu = Msg("Plan"),
               .label = Msg("Undo the last change of the plan"),
               .shortcut = {.key = Key::kZ, .shift = true},
               .run =
                   [this] {
                     viewer_.Say(fmt::format(fmt::runtime(Tr("Undone: {}")), steps_.undo_name()));
                     steps_.Undo();
                     Changed();
                   },
               .enabled = [this, idle] { return idle() && steps_.can_undo(); },
               .begins_group = true});
  actions.Add({.id = "plan.redo",
               .menu = Msg("Plan"),
               .label = Msg("Redo the change of the plan"),
               .shortcut = {.key = Key::kY, .shift = true},
               .run =
                   [this] {
                     viewer_.Say(fmt::format(fmt::runtime(Tr("Redone: {}")), steps_.redo_name()));
                     steps_.Redo();
                     Changed();
                   },
               .enabled = [this, idle] { return idle() && steps_.can_redo(); }});
  actions.Add({.id = "plan.read",
               .menu = Msg("Plan"),
               .label = Msg("Read planes of 3D Slicer"),
               .tip = Msg("a file .mrk.json"),
               .run = [this] { AskFile(); },
               .enabled = idle,
               .begins_group = true});
  actions.Add({.id = "plan.write",
               .menu = Msg("Plan"),
               .label = Msg("Write the plan"),
               .tip = Msg("into plan.mrk.json, for 3D Slicer"),
               .run = [this] { Write(); },
               .enabled = [this, idle] { return idle() && !plan().empty(); }});
}

void PlanEditor::AskFile() {
  viewer_.dialogs().ChooseFile(viewer_.ui(), Tr("Planes of 3D Slicer (.mrk.json)"), ".", {".mrk.json"}, false, "",
                               [this](const std::string& file) {
                                 try {
                                   Add(ReadPlannedPlanes(file));
                                 } catch (const Error& e) {
                                   viewer_.Say(e.what());
                                 }
                               });
}

void PlanEditor::Write() {
  const std::string file = viewer_.options().folder + "/plan.mrk.json";
  WritePlaneMarkups(file, MakeMarkups(plan()));
  viewer_.Say(fmt::format(fmt::runtime(Tr("Plan: {}")), file));
}

void PlanEditor::Align() {
  const PlannedPlane* planned = plane();
  if (planned == nullptr || !viewer_.is_running()) return;
  // Aligns the spindle with the plane's normal by the smaller rotation and moves the disc's centre into the plane.
  Pose X = viewer_.figures().coupled.X_WT;
  const Vec3 spindle = X.Vector({0, 0, 1});
  Vec3 normal = planned->plane.normal_W;
  if (glm::dot(normal, spindle) < 0) normal = -normal;
  X.R_AB = glm::normalize(RotationBetween(spindle, normal) * X.R_AB);
  X.p_AB -= glm::dot(X.p_AB - planned->plane.p_W, normal) * normal;
  viewer_.controls().Set(X);
  viewer_.Say(fmt::format(fmt::runtime(Tr("The saw is turning into {}; keep it clear of the bone")), planned->name));
}

void PlanEditor::AskDepth(const Vec3& p_W) {
  viewer_.AskText(Tr("Depth in mm:"), "5", [this, p_W](const std::optional<std::string>& text) {
    if (!text) return;
    const std::optional<double> depth_mm = ParseDepth(*text);
    if (!depth_mm) {
      return viewer_.Say(
          fmt::format(fmt::runtime(Tr("The depth must be a number from {}")), ShowRange(kDepthRange_mm, "mm")));
    }
    Content next = steps_.now();
    DepthStop stop;
    stop.name = MakeStopName(next.plan);
    stop.p_W_mm = p_W;
    // The direction into the bone: from the blade's current centre to the point.
    stop.direction_W = CalcDirection(p_W - viewer_.figures().coupled.X_WT.p_AB).value_or(viewer_.MakeBasis().forward_W);
    stop.depth_mm = *depth_mm;
    next.plan.stops.push_back(stop);
    Change(std::move(next), Tr("new depth stop"));
  });
}

// ---- points and handles

void PlanEditor::Place(Placing what, MarkKind kind) {
  viewer_.controls().Release();
  viewer_.SetSpindle(false);
  placing_ = Placement{what, kind, {}};
  mark_.reset();
}

std::optional<Vec3> PlanEditor::PickBone(const ScreenPoint& at) const {
  if (viewer_.surface() == nullptr) return std::nullopt;
  return viewer_.surface()->Pick(viewer_.view().camera().CalcRay(at));
}

bool PlanEditor::TakePoint(const Vec3& p_W) {
  if (!placing_) return false;
  placing_->points_W.push_back(p_W);
  viewer_.trace().Write("point", {{"mm", {p_W.x, p_W.y, p_W.z}}});
  // A plane of three points can still be changed; its points are confirmed with Enter.
  if (placing_->what == Placing::kStop) {
    placing_.reset();
    AskDepth(p_W);
  } else if (placing_->what == Placing::kPlane && placing_->points_W.size() == 3) {
    FinishPlacing();
  }
  return true;
}

void PlanEditor::FinishPlacing() {
  const Placement placed = *std::exchange(placing_, std::nullopt);
  try {
    if (placed.what == Placing::kPlane && placed.points_W.size() >= 3) {
      Add({PlacePlane(MakePlaneName(plan()), placed.points_W[0], placed.points_W[1], placed.points_W[2])});
    } else if (placed.what == Placing::kMark && !placed.points_W.empty()) {
      Content next = steps_.now();
      Mark mark;
      mark.name = MakeMarkName(next.marks, placed.kind);
      mark.kind = placed.kind;
      mark.radius_mm = placed.kind == MarkKind::kTooth ? 2.5 : 1.0;
      for (const Vec3& p_W : placed.points_W) AddPoint(mark, p_W);
      next.marks.push_back(std::move(mark));
      mark_ = next.marks.size() - 1;
      Change(std::move(next), Tr("new mark"));
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

std::vector<Vec3> PlanEditor::ListPoints() const {
  if (placing_) return placing_->points_W;
  if (mark_ && *mark_ < marks().size()) return marks()[*mark_].points_W;
  return {};
}

bool PlanEditor::TakePress(const ScreenPoint& at) {
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
  if (viewer_.spindle_on()) return false;
  const std::optional<int> handle = viewer_.view().PickHandle(at);
  if (!handle || plane() == nullptr || static_cast<std::size_t>(*handle) >= handles_.size()) return false;
  Drag drag;
  drag.handle = handles_[static_cast<std::size_t>(*handle)];
  drag.plane = *plane();
  drag.from = at;
  drag_ = drag;
  return true;
}

void PlanEditor::TakeMotion(const ScreenPoint& at) {
  Drag& drag = *drag_;
  const bool first = !std::exchange(drag.moved, true);
  try {
    if (drag.what == Drag::What::kPlacedPoint) {
      if (const std::optional<Vec3> p_W = PickBone(at)) placing_->points_W[drag.index] = *p_W;
      return;
    }
    Content next = steps_.now();
    if (drag.what == Drag::What::kMarkPoint) {
      // On the bone if there is any under the mouse, otherwise at the point's depth.
      const Vec3 before_W = next.marks[*mark_].points_W[drag.index];
      const ViewCamera& camera = viewer_.view().camera();
      const std::optional<Vec3> on_bone_W = PickBone(at);
      const auto spot = camera.Project(before_W);
      const Vec3 moved_W = spot ? before_W + camera.WorldMotion(at.x - spot->x, at.y - spot->y, before_W) : before_W;
      MovePoint(next.marks[*mark_], drag.index, on_bone_W.value_or(moved_W));
    } else {
      const auto sight = [&](const ScreenPoint& p) {
        const Ray ray = viewer_.view().camera().CalcRay(p);
        return SightLine{ray.origin_W, ray.direction_W};
      };
      next.plan.planes[plane_] = DragHandle(drag.plane, drag.handle, sight(drag.from), sight(at));
    }
    if (first) {
      Change(std::move(next), drag.what == Drag::What::kHandle ? Tr("plane moved") : Tr("point moved"));
    } else {
      Amend(std::move(next));
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

bool PlanEditor::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  const ScreenPoint at{event.x, event.y};
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
        if (!placing_->points_W.empty()) placing_->points_W.pop_back();
        return true;
      default:
        return false;
    }
  }
  return false;
}

void PlanEditor::OpenContextMenu(const ScreenPoint& at) {
  context_W_ = PickBone(at);
  opens_context_ = true;
}

// ---- the picture

void PlanEditor::Show(const PlanesReport* report) {
  Viewport& view = viewer_.view();
  const Content& now = steps_.now();
  std::vector<PlaneOverlay> planes;
  for (std::size_t i = 0; i < now.plan.planes.size(); ++i) {
    const PlannedPlane& p = now.plan.planes[i];
    planes.push_back({.name = p.name,
                      .p_W = p.plane.p_W,
                      .normal_W = p.plane.normal_W,
                      .width_mm = p.width_mm,
                      .height_mm = p.height_mm,
                      .up_W = CalcPlaneAxes(p).up_W,
                      .selected = i == plane_});
  }
  view.SetPlanes(planes);
  viewer_.RequestPlaneLines(planes);
  std::vector<DepthStopOverlay> stops;
  for (const DepthStop& stop : now.plan.stops) {
    stops.push_back(
        {.name = stop.name, .p_W = stop.p_W_mm + stop.depth_mm * stop.direction_W, .normal_W = -stop.direction_W});
  }
  view.SetDepthStops(stops);

  handles_.clear();
  std::vector<PlaneHandleOverlay> handles;
  // A turning saw needs the picture for itself.
  if (plane() != nullptr && !placing_ && !viewer_.spindle_on()) handles_ = PlaneHandles(*plane());
  for (const PlaneHandle& handle : handles_) {
    const bool hot = drag_ && drag_->what == Drag::What::kHandle && drag_->handle.kind == handle.kind &&
                     drag_->handle.corner == handle.corner;
    handles.push_back({handle.p_W, ToHandleKind(handle.kind), hot});
  }
  view.SetPlaneHandles(handles);

  std::vector<PointOverlay> points;
  const std::vector<Vec3> listed = ListPoints();
  for (std::size_t i = 0; i < listed.size(); ++i) {
    points.push_back({.p_W = listed[i],
                      .kind = placing_ && placing_->what != Placing::kMark ? PointKind::kPlan : PointKind::kMark,
                      .label = fmt::format("{}", i + 1),
                      .selected = drag_ && drag_->what != Drag::What::kHandle && drag_->index == i});
  }
  view.SetPoints(points);

  std::vector<MarkOverlay> marks;
  for (std::size_t i = 0; i < tubes_.size(); ++i) {
    marks.push_back({.points_W = tubes_[i].curve_W(),
                     .radius_mm = tubes_[i].radius_mm(),
                     .colour = ColourOf(tubes_[i].kind()),
                     .label = tubes_[i].name(),
                     .selected = mark_ == i});
  }
  view.SetMarks(marks);

  std::vector<BridgeOverlay> bridges;
  if (report != nullptr) {
    for (const PlanesReport::Row& row : report->planes) {
      // Before a plane is cut, all of it holds.
      if (row.state.fraction() < 0.02) continue;
      for (const Bridge& bridge : row.state.bridges) {
        BridgeOverlay overlay;
        overlay.centre_W = bridge.centre_W;
        overlay.label = fmt::format(fmt::runtime(Tr("still holds: {} mm²")), ShowNumber(bridge.area_mm2, 0));
        for (const std::array<Vec3, 4>& patch : bridge.patches) {
          const auto first = static_cast<std::uint32_t>(overlay.points_W.size());
          overlay.points_W.insert(overlay.points_W.end(), patch.begin(), patch.end());
          overlay.triangles.push_back({first, first + 1, first + 2});
          overlay.triangles.push_back({first, first + 2, first + 3});
        }
        bridges.push_back(std::move(overlay));
      }
    }
  }
  view.SetBridges(bridges);
}

void PlanEditor::Hide() {
  viewer_.view().SetPlaneHandles({});
  viewer_.view().SetPoints({});
  viewer_.view().SetBridges({});
  viewer_.HidePlaneLines();
  handles_.clear();
}

// ---- panels

void PlanEditor::DrawPlane(Ui& ui, std::size_t i, const PlanesReport* report) {
  const PlannedPlane& p = plan().planes[i];
  ImGui::PushID(static_cast<int>(i));
  if (ImGui::Selectable("##plane", i == plane_, ImGuiSelectableFlags_AllowItemOverlap)) {
    plane_ = i;
    reference_.reset();
  }
  ui.Note(fmt::format("plane {}", i + 1));
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
  const PlanesReport::Row* row = FindRow(report, p.name);
  const std::string state = row != nullptr && row->state.fraction() > 0
                                ? fmt::format(fmt::runtime(Tr("{} % cut")), ShowNumber(100 * row->state.fraction(), 0))
                                : NameOf(p.state);
  const float width = ImGui::GetContentRegionAvail().x;
  const float state_width = ImGui::CalcTextSize(state.c_str()).x;
  FittedText(ui, fmt::format("{}. {}", i + 1, p.name), width - state_width - 8 * ui.scale());
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + width - state_width);
  ImGui::TextDisabled("%s", state.c_str());
  ImGui::PopID();
}

void PlanEditor::DrawFields(Ui& ui) {
  const std::size_t i = plane_;
  Content next = steps_.now();
  PlannedPlane& p = next.plan.planes[i];
  const std::string what = Tr("plane changed");
  const float number_width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  const auto number = [&](const char* id, double& value, const char* format, const char* note) {
    ImGui::SetNextItemWidth(number_width);
    ImGui::InputDouble(id, &value, 0, 0, format, ImGuiInputTextFlags_EnterReturnsTrue);
    ui.Note(note);
  };
  ImGui::SetNextItemWidth(-1);
  std::string name = p.name;
  const bool renamed =
      ImGui::InputText("##name", &name, ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  ui.Note("plane.name");
  PlaneFields fields = reference_ ? CalcPlaneFields(p, *reference_) : CalcPlaneFields(p);
  const PlaneFields before = fields;
  const auto row = [&](const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    Tooltip(ui, label);
  };
  // x to the patient's left, y to the back, z to the head.
  row(Tr("Middle: left, back, up (mm)"));
  number("##x", fields.p_W_mm.x, "%.2f", "plane.x");
  ImGui::SameLine();
  number("##y", fields.p_W_mm.y, "%.2f", "plane.y");
  ImGui::SameLine();
  number("##z", fields.p_W_mm.z, "%.2f", "plane.z");
  row(Tr("Pitch, roll (°)"));
  number("##pitch", fields.pitch_deg, "%.2f", "plane.pitch");
  ImGui::SameLine();
  number("##roll", fields.roll_deg, "%.2f", "plane.roll");
  row(Tr("Width, height, margin (mm)"));
  number("##width", p.width_mm, "%.1f", "plane.width");
  ImGui::SameLine();
  number("##height", p.height_mm, "%.1f", "plane.height");
  ImGui::SameLine();
  number("##margin", p.margin_mm, "%.2f", "plane.margin");
  const bool edits = fields.p_W_mm != before.p_W_mm || fields.pitch_deg != before.pitch_deg ||
                     fields.roll_deg != before.roll_deg || p.margin_mm != plan().planes[i].margin_mm ||
                     p.width_mm != plan().planes[i].width_mm || p.height_mm != plan().planes[i].height_mm;
  auto state = static_cast<int>(p.state);
  std::string list;
  for (const PlaneState s : {PlaneState::kPlanned, PlaneState::kInProgress, PlaneState::kDone}) {
    list += NameOf(s);
    list.push_back('\0');
  }
  ImGui::SetNextItemWidth(120 * ui.scale());
  const bool restated = ImGui::Combo("##state", &state, list.c_str());
  ui.Note("plane.state");
  ImGui::SameLine();
  ImGui::BeginDisabled(i == 0);
  const bool earlier = ImGui::ArrowButton("##earlier", ImGuiDir_Up);
  ImGui::EndDisabled();
  ui.Note("plane.earlier");
  Tooltip(ui, Tr("Cut this plane earlier"));
  ImGui::SameLine();
  ImGui::BeginDisabled(i + 1 >= plan().planes.size());
  const bool later = ImGui::ArrowButton("##later", ImGuiDir_Down);
  ImGui::EndDisabled();
  ui.Note("plane.later");
  Tooltip(ui, Tr("Cut this plane later"));
  try {
    if (renamed && name != p.name) {
      RenamePlane(next.plan, i, name);
      Change(std::move(next), Tr("plane renamed"));
    } else if (restated) {
      p.state = static_cast<PlaneState>(state);
      Change(std::move(next), what);
    } else if (earlier || later) {
      const std::size_t to = earlier ? i - 1 : i + 1;
      ReorderPlane(next.plan, i, to);
      plane_ = to;
      Change(std::move(next), Tr("order of planes changed"));
    } else if (edits) {
      if (!reference_) reference_ = before.reference;
      const double width_mm = kPlaneSizeRange_mm.Clamp(p.width_mm);
      const double height_mm = kPlaneSizeRange_mm.Clamp(p.height_mm);
      p = SetPlaneFields(p, fields);
      p.width_mm = width_mm;
      p.height_mm = height_mm;
      Change(std::move(next), what);
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

void PlanEditor::DrawMarks(Ui& ui) {
  for (std::size_t i = 0; i < marks().size(); ++i) {
    const Mark& mark = marks()[i];
    ImGui::PushID(static_cast<int>(1000 + i));
    if (ImGui::Selectable("##mark", mark_ == i, ImGuiSelectableFlags_AllowItemOverlap)) {
      mark_ = mark_ == i ? std::nullopt : std::optional(i);
    }
    ui.Note(fmt::format("mark {}", i + 1));
    ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
    Swatch(ui, ColourOf(mark.kind));
    ImGui::SameLine();
    FittedText(ui, mark.name, ImGui::GetContentRegionAvail().x);
    ImGui::PopID();
  }
  if (!mark_) return;
  Content next = steps_.now();
  Mark& mark = next.marks[*mark_];
  ImGui::SetNextItemWidth(74 * ui.scale());
  const bool resized = ImGui::InputDouble(fmt::format("{}##radius", Tr("radius in mm")).c_str(), &mark.radius_mm, 0, 0,
                                          "%.2f", ImGuiInputTextFlags_EnterReturnsTrue);
  ui.Note("mark.radius");
  const bool extended = ImGui::Button(Tr("Remove last point"));
  ui.Note("mark.remove_point");
  ImGui::SameLine();
  const bool removed = ImGui::Button(Tr("Delete"));
  ui.Note("mark.delete");
  try {
    if (removed) {
      next.marks.erase(next.marks.begin() + static_cast<std::ptrdiff_t>(*mark_));
      mark_.reset();
      Change(std::move(next), Tr("mark removed"));
    } else if (extended && mark.points_W.size() > 1) {
      RemovePoint(mark, mark.points_W.size() - 1);
      Change(std::move(next), Tr("point removed"));
    } else if (resized) {
      mark.radius_mm = kMarkRadiusRange_mm.Clamp(mark.radius_mm);
      Change(std::move(next), Tr("radius changed"));
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

void PlanEditor::DrawSections(Ui& ui, const PlanesReport* report) {
  if (!plan().planes.empty() && BeginSection(ui, fmt::format("{}###plan", Tr("Plan")).c_str())) {
    for (std::size_t i = 0; i < plan().planes.size(); ++i) DrawPlane(ui, i, report);
    if (report != nullptr) {
      const std::string pieces = report->piece_count <= 1
                                     ? std::string(Tr("The bone is in one piece"))
                                     : fmt::format(fmt::runtime(Tr("The bone is in {} pieces")), report->piece_count);
      ImGui::TextDisabled("%s", pieces.c_str());
    }
    if (plane() != nullptr) {
      const bool open = ImGui::TreeNodeEx(fmt::format("{}###fields", Tr("Values of this plane")).c_str(),
                                          ImGuiTreeNodeFlags_NoTreePushOnOpen);
      ui.Note("plane.fields");
      if (open) DrawFields(ui);
    }
  }
  if (!marks().empty() && BeginSection(ui, fmt::format("{}###marks", Tr("Marks")).c_str())) DrawMarks(ui);
}

void PlanEditor::DrawWindows(Ui& ui, ActionList& actions) {
  if (std::exchange(opens_context_, false)) ImGui::OpenPopup("context");
  if (!ImGui::BeginPopup("context")) return;
  if (context_W_) {
    if (ImGui::MenuItem(Tr("Turn the view about this place"))) viewer_.view().camera().set_target_W(*context_W_);
    ui.Note("context look");
    if (ImGui::MenuItem(Tr("Depth stop here"))) AskDepth(*context_W_);
    ui.Note("context stop");
    if (ImGui::MenuItem(Tr("Mark a nerve from here"))) {
      Place(Placing::kMark, MarkKind::kNerve);
      TakePoint(*context_W_);
    }
    ui.Note("context nerve");
    ImGui::Separator();
  }
  actions.DrawEntries(ui, "Plan");
  ImGui::EndPopup();
}

void PlanEditor::Fill(HudState& hud) const {
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

void PlanEditor::Describe(nlohmann::json& state) const {
  state["planes"] = plan().planes.size();
  state["plane"] = plane_;
  state["stops"] = plan().stops.size();
  state["marks"] = marks().size();
  state["placed"] = placing_ ? static_cast<int>(placing_->points_W.size()) : -1;
  state["handles"] = nlohmann::json::array();
  for (const PlaneHandle& handle : handles_) {
    const auto at = viewer_.view().camera().Project(handle.p_W);
    if (at) state["handles"].push_back({std::round(at->x), std::round(at->y)});
  }
  state["plane_mm"] = nlohmann::json::array();
  for (const PlannedPlane& p : plan().planes) {
    state["plane_mm"].push_back({std::round(100 * p.plane.p_W.x) / 100, std::round(100 * p.plane.p_W.y) / 100,
                                 std::round(100 * p.plane.p_W.z) / 100});
  }
}

}  // namespace kerf
