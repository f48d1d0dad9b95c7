#include "app/window/plan_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "app/window/plan_picture.h"
#include "kerf/error.h"
#include "session/marks/structures.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

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

void PlanPanel::DrawPlane(Ui& ui, std::size_t i, const PlanesReport* report) {
  const PlannedPlane& p = document_.plan().planes[i];
  ImGui::PushID(static_cast<int>(i));
  if (ImGui::Selectable("##plane", i == document_.plane_index(), ImGuiSelectableFlags_AllowItemOverlap)) {
    document_.set_plane_index(i);
  }
  ui.Note(fmt::format("plane {}", i + 1));
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
  const PlanesReport::Row* row = FindRow(report, p.name);
  const std::string state =
      row != nullptr && row->state.fraction() > 0
          ? fmt::format(fmt::runtime(Tr("{} % cut")), ShowNumber(std::floor(100 * row->state.fraction() + 1e-6), 0))
          : NameOf(p.state);
  const float width = ImGui::GetContentRegionAvail().x;
  const float state_width = ImGui::CalcTextSize(state.c_str()).x;
  FittedText(ui, fmt::format("{}. {}", i + 1, ShowName(p.name)), width - state_width - 8 * ui.scale());
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + width - state_width);
  ImGui::TextDisabled("%s", state.c_str());
  ImGui::PopID();
}

/// Returns false, with a message, if a plane was moved to where there is no bone far and wide.
bool PlanPanel::CheckNear(const Vec3& p_W, const Vec3& before_W) {
  constexpr double kBeside_mm = 50;
  const std::shared_ptr<SurfaceWorker>& surface = viewer_.bone().surface();
  if (!surface) return true;
  const Box3 box = surface->bounds_W().Grown(kBeside_mm);
  for (int axis = 0; axis < 3; ++axis) {
    const bool inside = p_W[axis] >= box.lower[axis] && p_W[axis] <= box.upper[axis];
    if (inside || p_W[axis] == before_W[axis]) continue;
    viewer_.Say(fmt::format(
        fmt::runtime(Tr("{} mm is too far away from the bone. Enter a number from {} to {}; the plane was not moved.")),
        ShowNumber(p_W[axis], 0), ShowNumber(box.lower[axis], 0), ShowNumber(box.upper[axis], 0)));
    return false;
  }
  return true;
}

void PlanPanel::DrawFields(Ui& ui) {
  const std::size_t i = document_.plane_index();
  PlanContent next = document_.now();
  PlannedPlane& p = next.plan.planes[i];
  const std::string what = Tr("plane changed");
  const float number_width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  const auto number = [&](const char* id, double& value, int decimals, const char* note) {
    ImGui::SetNextItemWidth(number_width);
    NumberField(ui, id, value, decimals);
    ui.Note(note);
  };
  ImGui::SetNextItemWidth(-1);
  std::string name = ShowName(p.name);
  const bool renamed = TextField(ui, "##name", name);
  ui.Note("plane.name");
  const PlannedPlane before = p;
  const auto row = [&](const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    Tooltip(ui, label);
  };
  // x to the patient's left, y to the back, z to the head.
  row(Tr("Middle: left, back, up (mm)"));
  Tooltip(ui, Tr(ExplainPlaces()));
  Vec3& p_W = p.plane.p_W;
  number("##x", p_W.x, 2, "plane.x");
  ImGui::SameLine();
  number("##y", p_W.y, 2, "plane.y");
  ImGui::SameLine();
  number("##z", p_W.z, 2, "plane.z");
  // The angles cannot be entered: two of them determine the third, and they do not tell to which side it is inclined.
  const PatientAngles angles = CalcPatientAngles(p);
  row(Tr("Angle to the patient's planes (°)"));
  struct AlignButton {
    const char* name;
    const char* note;
    PatientPlane with;
    double angle_deg;
  };
  std::optional<PatientPlane> aligned;
  for (const AlignButton& b :
       {AlignButton{Tr("sagittal"), "plane.sagittal", PatientPlane::kSagittal, angles.sagittal_deg},
        AlignButton{Tr("coronal"), "plane.coronal", PatientPlane::kCoronal, angles.coronal_deg},
        AlignButton{Tr("axial"), "plane.axial", PatientPlane::kAxial, angles.axial_deg}}) {
    if (b.with != PatientPlane::kSagittal) ImGui::SameLine();
    const std::string label = fmt::format("{}\n{}°##{}", b.name, ShowNumber(b.angle_deg, 1), b.note);
    if (ImGui::Button(label.c_str(), {number_width, 0})) aligned = b.with;
    ui.Note(b.note);
    Tooltip(ui, Tr("Click to make the plane parallel to this plane of the patient"));
  }
  row(Tr("Turn about width, height, normal (°)"));
  Tooltip(ui, Tr("Enter by how many degrees the plane is turned about its own axis. The field is then 0 again."));
  std::array<double, 3> turns_deg{};
  number("##turn_width", turns_deg[0], 1, "plane.turn_width");
  ImGui::SameLine();
  number("##turn_height", turns_deg[1], 1, "plane.turn_height");
  ImGui::SameLine();
  number("##turn_normal", turns_deg[2], 1, "plane.turn_normal");
  row(Tr("Width, height, margin (mm)"));
  number("##width", p.width_mm, 1, "plane.width");
  ImGui::SameLine();
  number("##height", p.height_mm, 1, "plane.height");
  ImGui::SameLine();
  number("##margin", p.margin_mm, 2, "plane.margin");
  const bool edits = p_W != before.plane.p_W || p.margin_mm != before.margin_mm || p.width_mm != before.width_mm ||
                     p.height_mm != before.height_mm || aligned || turns_deg != std::array<double, 3>{};
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
  ImGui::BeginDisabled(i + 1 >= document_.plan().planes.size());
  const bool later = ImGui::ArrowButton("##later", ImGuiDir_Down);
  ImGui::EndDisabled();
  ui.Note("plane.later");
  Tooltip(ui, Tr("Cut this plane later"));
  try {
    if (renamed) {
      RenamePlane(next.plan, i, name);
      document_.Change(std::move(next), Tr("plane renamed"));
    } else if (restated) {
      p.state = static_cast<PlaneState>(state);
      document_.Change(std::move(next), what);
    } else if (earlier || later) {
      const std::size_t to = earlier ? i - 1 : i + 1;
      ReorderPlane(next.plan, i, to);
      document_.set_plane_index(to);
      document_.Change(std::move(next), Tr("order of planes changed"));
    } else if (edits) {
      if (!CheckNear(p_W, before.plane.p_W)) return;
      if (!kPlaneSizeRange_mm.Contains(p.width_mm) || !kPlaneSizeRange_mm.Contains(p.height_mm)) {
        viewer_.Say(
            fmt::format(fmt::runtime(Tr("Width and height were limited to {}.")), ShowRange(kPlaneSizeRange_mm, "mm")));
      }
      p.width_mm = kPlaneSizeRange_mm.Clamp(p.width_mm);
      p.height_mm = kPlaneSizeRange_mm.Clamp(p.height_mm);
      if (aligned) p = AlignPlane(p, *aligned);
      for (const PlaneAxis axis : {PlaneAxis::kAcross, PlaneAxis::kUp, PlaneAxis::kNormal}) {
        const double turn_deg = turns_deg[static_cast<std::size_t>(axis)];
        if (turn_deg != 0) p = TurnPlane(p, axis, turn_deg);
      }
      document_.Change(std::move(next), what);
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

void PlanPanel::DrawMarks(Ui& ui) {
  for (std::size_t i = 0; i < document_.marks().size(); ++i) {
    const Mark& mark = document_.marks()[i];
    ImGui::PushID(static_cast<int>(1000 + i));
    if (ImGui::Selectable("##mark", document_.mark_index() == i, ImGuiSelectableFlags_AllowItemOverlap)) {
      document_.set_mark_index(document_.mark_index() == i ? std::nullopt : std::optional(i));
    }
    ui.Note(fmt::format("mark {}", i + 1));
    ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
    Swatch(ui, MarkColour(mark.kind));
    ImGui::SameLine();
    FittedText(ui, ShowName(mark.name), ImGui::GetContentRegionAvail().x);
    ImGui::PopID();
  }
  if (!document_.mark_index()) return;
  const std::size_t selected = *document_.mark_index();
  PlanContent next = document_.now();
  Mark& mark = next.marks[selected];
  ImGui::SetNextItemWidth(74 * ui.scale());
  const bool resized = NumberField(ui, fmt::format("{}##radius", Tr("radius in mm")).c_str(), mark.radius_mm, 2);
  ui.Note("mark.radius");
  const bool extended = ImGui::Button(Tr("Remove last point"));
  ui.Note("mark.remove_point");
  ImGui::SameLine();
  const bool removed = ImGui::Button(Tr("Delete"));
  ui.Note("mark.delete");
  try {
    if (removed) {
      next.marks.erase(next.marks.begin() + static_cast<std::ptrdiff_t>(selected));
      document_.set_mark_index({});
      document_.Change(std::move(next), Tr("mark removed"));
    } else if (extended && mark.points_W.size() > 1) {
      RemovePoint(mark, mark.points_W.size() - 1);
      document_.Change(std::move(next), Tr("point removed"));
    } else if (resized) {
      mark.radius_mm = kMarkRadiusRange_mm.Clamp(mark.radius_mm);
      document_.Change(std::move(next), Tr("radius changed"));
    }
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
}

void PlanPanel::Draw(Ui& ui, const PlanesReport* report) {
  if (!document_.plan().planes.empty() && BeginSection(ui, fmt::format("{}###plan", Tr("Plan")).c_str())) {
    for (std::size_t i = 0; i < document_.plan().planes.size(); ++i) DrawPlane(ui, i, report);
    if (report != nullptr) {
      const std::string pieces = report->piece_count <= 1
                                     ? std::string(Tr("The bone is in one piece"))
                                     : fmt::format(fmt::runtime(Tr("The bone is in {} pieces")), report->piece_count);
      ImGui::TextDisabled("%s", pieces.c_str());
    }
    if (document_.plane() != nullptr) {
      const bool open = ImGui::TreeNodeEx(fmt::format("{}###fields", Tr("Values of this plane")).c_str(),
                                          ImGuiTreeNodeFlags_NoTreePushOnOpen);
      ui.Note("plane.fields");
      if (open) DrawFields(ui);
    }
  }
  if (!document_.marks().empty() && BeginSection(ui, fmt::format("{}###marks", Tr("Marks")).c_str())) DrawMarks(ui);
}

}  // namespace kerf
