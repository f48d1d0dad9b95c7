#include "app/window/plan_document.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bone/grid/removed.h"
#include "session/plan/edit_plane.h"
#include "session/plan/section_line.h"
#include "view/ui/translate.h"

namespace kerf {
const PlannedPlane* PlanDocument::plane() const {
  return plane_ < plan().planes.size() ? &plan().planes[plane_] : nullptr;
}

void PlanDocument::Load(Plan plan, std::vector<Mark> marks) {
  steps_ = UndoStack<PlanContent>(PlanContent{std::move(plan), std::move(marks)});
  plane_ = 0;
  mark_.reset();
  Changed();
  unsaved_ = false;
}

void PlanDocument::Add(std::vector<PlannedPlane> planes) {
  PlanContent next = now();
  for (PlannedPlane& plane : planes) {
    plane.name = MakeUniquePlaneName(next.plan, plane.name);
    next.plan.planes.push_back(std::move(plane));
  }
  Change(std::move(next), Tr("new plane"));
  plane_ = plan().planes.empty() ? 0 : plan().planes.size() - 1;
}

void PlanDocument::AddFitted(const PlannedPlane& plane, const std::vector<Vec3>& near_W) {
  const std::shared_ptr<const Bone> bone = viewer_.bone_at_start();
  Add({bone ? FitToSection(PhiSampler(*bone), plane, near_W) : plane});
}

void PlanDocument::Change(PlanContent next, const std::string& what) {
  CheckPlan(next.plan);
  CheckMarks(next.marks);
  steps_.Push(std::move(next), what);
  Changed();
}

void PlanDocument::Amend(PlanContent next) {
  steps_.Amend(std::move(next));
  Changed();
}

void PlanDocument::Undo() {
  steps_.Undo();
  Changed();
}

void PlanDocument::Redo() {
  steps_.Redo();
  Changed();
}

bool PlanDocument::is_latest_change() const {
  return steps_.can_undo() && changes_at_edit_ == viewer_.figures().changes;
}

void PlanDocument::Changed() {
  unsaved_ = true;
  ++changes_;
  changes_at_edit_ = viewer_.figures().changes;
  plane_ = std::min(plane_, plan().planes.empty() ? 0 : plan().planes.size() - 1);
  if (mark_ && *mark_ >= marks().size()) mark_.reset();
  tubes_ = MakeMarkTubes(marks());
  if (const auto watch = viewer_.cut_watch()) {
    watch->SetPlanes(plan().planes);
    watch->SetMarks(marks());
  }
  viewer_.trace().Write("plan",
                        {{"planes", plan().planes.size()}, {"stops", plan().stops.size()}, {"marks", marks().size()}});
}

void PlanDocument::Describe(nlohmann::json& state) const {
  state["planes"] = plan().planes.size();
  state["plane"] = plane_;
  state["stops"] = plan().stops.size();
  state["marks"] = marks().size();
  state["plane_mm"] = nlohmann::json::array();
  state["plane_size_mm"] = nlohmann::json::array();
  state["plane_deg"] = nlohmann::json::array();
  for (const PlannedPlane& p : plan().planes) {
    state["plane_mm"].push_back({std::round(100 * p.plane.p_W.x) / 100, std::round(100 * p.plane.p_W.y) / 100,
                                 std::round(100 * p.plane.p_W.z) / 100});
    const PatientAngles angles = CalcPatientAngles(p);
    state["plane_deg"].push_back({std::round(100 * angles.sagittal_deg) / 100,
                                  std::round(100 * angles.coronal_deg) / 100,
                                  std::round(100 * angles.axial_deg) / 100});
    state["plane_size_mm"].push_back({std::round(10 * p.width_mm) / 10, std::round(10 * p.height_mm) / 10});
  }
}

}  // namespace kerf
