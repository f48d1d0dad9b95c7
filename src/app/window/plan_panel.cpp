#include "app/window/plan_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "app/window/plan_picture.h"
#include "kerf/error.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

const char* NameOf(PlaneState state) {
  return state == PlaneState::kDone ? Tr("done") : state == PlaneState::kInProgress ? Tr("in progress") : Tr("planned");
}

const char* DescribeReference(PatientPlane reference) {
  switch (reference) {
    case PatientPlane::kSagittal:
      return Tr("relative to the sagittal plane");
    case PatientPlane::kCoronal:
      return Tr("relative to the coronal plane");
    case PatientPlane::kAxial:
      break;
  }
  return Tr("relative to the axial plane");
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
  const std::string state = row != nullptr && row->state.fraction() > 0
                                ? fmt::format(fmt::runtime(Tr("{} % cut")), ShowNumber(100 * row->state.fraction(), 0))
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
  PlaneFields fields = CalcPlaneFields(p);
  const PlaneFields before = fields;
  const auto row = [&](const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    Tooltip(ui, label);
  };
  // x to the patient's left, y to the back, z to the head.
  row(Tr("Middle: left, back, up (mm)"));
  number("##x", fields.p_W_mm.x, 2, "plane.x");
  ImGui::SameLine();
  number("##y", fields.p_W_mm.y, 2, "plane.y");
  ImGui::SameLine();
  number("##z", fields.p_W_mm.z, 2, "plane.z");
  row(Tr("Pitch, roll (°)"));
  number("##pitch", fields.pitch_deg, 2, "plane.pitch");
  ImGui::SameLine();
  number("##roll", fields.roll_deg, 2, "plane.roll");
  ImGui::PushFont(ui.small());
  ImGui::TextDisabled("%s", DescribeReference(fields.reference));
  ImGui::PopFont();
  row(Tr("Width, height, margin (mm)"));
  number("##width", p.width_mm, 1, "plane.width");
  ImGui::SameLine();
  number("##height", p.height_mm, 1, "plane.height");
  ImGui::SameLine();
  number("##margin", p.margin_mm, 2, "plane.margin");
  const bool edits = fields.p_W_mm != before.p_W_mm || fields.pitch_deg != before.pitch_deg ||
                     fields.roll_deg != before.roll_deg || p.margin_mm != document_.plan().planes[i].margin_mm ||
                     p.width_mm != document_.plan().planes[i].width_mm ||
                     p.height_mm != document_.plan().planes[i].height_mm;
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
      if (!CheckNear(fields.p_W_mm, before.p_W_mm)) return;
      if (!kPlaneSizeRange_mm.Contains(p.width_mm) || !kPlaneSizeRange_mm.Contains(p.height_mm)) {
        viewer_.Say(
            fmt::format(fmt::runtime(Tr("Width and height were limited to {}.")), ShowRange(kPlaneSizeRange_mm, "mm")));
      }
      const double width_mm = kPlaneSizeRange_mm.Clamp(p.width_mm);
      const double height_mm = kPlaneSizeRange_mm.Clamp(p.height_mm);
      p = SetPlaneFields(p, fields);
      p.width_mm = width_mm;
      p.height_mm = height_mm;
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
