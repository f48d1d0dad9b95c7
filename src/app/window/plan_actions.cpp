#include "app/window/plan_actions.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "app/window/saw_turn.h"
#include "kerf/error.h"
#include "session/run/clear_pose.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr double kClear_mm = 0.2;  // from the bone, for a saw that is turned
constexpr double kMaxLift_mm = 30;
constexpr double kMaxWay_mm = 80;

/// Returns the smallest rotation from one unit vector to another, less than half a turn.
Quat RotationBetween(const Vec3& from, const Vec3& to) {
  const Vec3 axis = glm::cross(from, to);
  return glm::normalize(Quat{1 + glm::dot(from, to), axis.x, axis.y, axis.z});
}

}  // namespace

void PlanActions::Add(ActionList& actions, const std::function<bool()>& idle) {
  const auto planned = [this, idle] { return idle() && document_.plane() != nullptr; };
  const auto on_plane = [this](const char* what, const std::function<void(PlanContent&)>& change) {
    return [this, what, change] {
      PlanContent next = document_.now();
      change(next);
      document_.Change(std::move(next), Tr(what));
    };
  };
  actions.Add({.id = "plan.three_points",
               .menu = Msg("Plan"),
               .label = Msg("Plane through three points"),
               .tip = Msg("click them on the bone"),
               .run = [this] { gestures_.Place(PlanGestures::Placing::kPlane); },
               .enabled = idle,
               .begins_group = true});
  actions.Add({.id = "plan.at_blade",
               .menu = Msg("Plan"),
               .label = Msg("Plane where the blade is"),
               .run =
                   [this] {
                     const Pose& X_WT = viewer_.figures().coupled.X_WT;
                     document_.AddFitted(PlacePlane(MakePlaneName(document_.plan()), X_WT), {X_WT.p_AB});
                   },
               .enabled = idle});
  actions.Add({.id = "plan.stop",
               .menu = Msg("Plan"),
               .label = Msg("Depth stop"),
               .tip = Msg("click its point on the bone"),
               .run = [this] { gestures_.Place(PlanGestures::Placing::kStop); },
               .enabled = idle});
  actions.Add({.id = "plan.align",
               .menu = Msg("Plan"),
               .label = Msg("Turn the saw into the plane"),
               .shortcut = {.key = Key::kG, .shift = true},
               .run = [this] { Align(); },
               .enabled = planned});
  actions.Add(
      {.id = "plan.next",
       .menu = Msg("Plan"),
       .label = Msg("Next plane"),
       .run = [this] { document_.set_plane_index((document_.plane_index() + 1) % document_.plan().planes.size()); },
       .enabled = [this, idle] { return idle() && document_.plan().planes.size() > 1; }});
  actions.Add({.id = "plan.remove",
               .menu = Msg("Plan"),
               .label = Msg("Remove this plane"),
               .run = on_plane(Msg("plane removed"),
                               [this](PlanContent& next) {
                                 next.plan.planes.erase(next.plan.planes.begin() +
                                                        static_cast<std::ptrdiff_t>(document_.plane_index()));
                               }),
               .enabled = planned});
  actions.Add({.id = "plan.mirror",
               .menu = Msg("Plan"),
               .label = Msg("Mirror this plane to the other side"),
               .tip = Msg("at the middle of the bone, left to right"),
               .run = [this] { document_.Add({MirrorPlane(document_.plan(), *document_.plane(), middle_mm_)}); },
               .enabled = planned});
  actions.Add({.id = "plan.remove_stops",
               .menu = Msg("Plan"),
               .label = Msg("Remove all depth stops"),
               .run = on_plane(Msg("depth stops removed"), [](PlanContent& next) { next.plan.stops.clear(); }),
               .enabled = [this, idle] { return idle() && !document_.plan().stops.empty(); }});
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
                 .run = [this, kind = mark.kind] { gestures_.Place(PlanGestures::Placing::kMark, kind); },
                 .enabled = idle,
                 .begins_group = mark.kind == MarkKind::kNerve});
  }
  actions.Add({.id = "mark.import",
               .menu = Msg("Plan"),
               .label = Msg("Import marks..."),
               .tip = Msg("Curves of 3D Slicer (.mrk.json), or a segmentation as a label map (.nrrd, .nii, .mha)"),
               .run = [this] { marks_.AskFile(); },
               .enabled = [this, idle] { return idle() && !marks_.is_reading(); }});
  actions.Add({.id = "plan.undo",
               .menu = Msg("Plan"),
               .label = Msg("Undo the last change of the plan"),
               .shortcut = {.key = Key::kZ, .shift = true},
               .run =
                   [this] {
                     viewer_.Say(fmt::format(fmt::runtime(Tr("Undone: {}")), document_.steps().undo_name()));
                     document_.Undo();
                   },
               .enabled = [this, idle] { return idle() && document_.steps().can_undo(); },
               .begins_group = true});
  actions.Add({.id = "plan.redo",
               .menu = Msg("Plan"),
               .label = Msg("Redo the change of the plan"),
               .shortcut = {.key = Key::kY, .shift = true},
               .run =
                   [this] {
                     viewer_.Say(fmt::format(fmt::runtime(Tr("Redone: {}")), document_.steps().redo_name()));
                     document_.Redo();
                   },
               .enabled = [this, idle] { return idle() && document_.steps().can_redo(); }});
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
               .enabled = [this, idle] { return idle() && !document_.plan().empty(); }});
}

void PlanActions::AskFile() {
  viewer_.dialogs().ChooseFile(viewer_.ui(), Tr("Planes of 3D Slicer (.mrk.json)"), ".", {".mrk.json"}, false, "",
                               [this](const std::string& file) {
                                 try {
                                   document_.Add(ReadPlannedPlanes(file));
                                 } catch (const Error& e) {
                                   viewer_.Say(e.what());
                                 }
                               });
}

void PlanActions::Write() {
  const std::string file = viewer_.options().folder + "/plan.mrk.json";
  WritePlaneMarkups(file, MakeMarkups(document_.plan()));
  viewer_.Say(fmt::format(fmt::runtime(Tr("Plan: {}")), file));
}

void PlanActions::Align() {
  const PlannedPlane* planned = document_.plane();
  if (planned == nullptr || !viewer_.is_running()) return;
  // Aligns the spindle with the plane's normal by the smaller rotation and moves the disc's centre into the plane.
  Pose X = viewer_.figures().coupled.X_WT;
  const Vec3 spindle = X.Vector({0, 0, 1});
  Vec3 normal = planned->plane.normal_W;
  if (glm::dot(normal, spindle) < 0) normal = -normal;
  X.R_AB = glm::normalize(RotationBetween(spindle, normal) * X.R_AB);
  X.p_AB -= glm::dot(X.p_AB - planned->plane.p_W, normal) * normal;
  const Tool tool = MakeTool(viewer_.session()->scene());
  if (SawTurn::CalcBeside(viewer_.figures().coupled.X_WT, X, CalcReach(tool)) < SawTurn::kThere_mm) {
    return viewer_.Say(fmt::format(fmt::runtime(Tr("The saw lies in {} already")), ShowName(planned->name)));
  }
  // A spindle that turns would saw its way into the plane.
  const bool stops = viewer_.spindle_on();
  if (stops) viewer_.SetSpindle(false);
  viewer_.TurnSaw(FindWay(X, tool));
  viewer_.Say(fmt::format(
      "{}{}", stops ? fmt::format("{} ", Tr("The spindle is stopped.")) : "",
      fmt::format(fmt::runtime(Tr("The saw is turning into {}; keep it clear of the bone")), ShowName(planned->name))));
}

/// Returns the corners of a way to the pose, or to the nearest one in the same plane at which the tool is clear of the
/// uncut bone.
std::vector<Pose> PlanActions::FindWay(const Pose& X_WT, const Tool& tool) const {
  const std::shared_ptr<const Bone> bone = viewer_.uncut_bone();
  if (!bone) return {X_WT};
  const PhiSampler phi(*bone);
  const Vec3 middle_W = bone->CalcBounds().centre();
  Pose X_clear = X_WT;
  if (!IsClear(phi, tool, X_WT, 0)) {
    X_clear = FindNearestClearPose(phi, tool, X_WT, middle_W, kClear_mm, kMaxLift_mm);
    // A saw that comes to rest beside its goal is still clear.
    const Vec3 out = X_clear.p_AB - X_WT.p_AB;
    const Pose X_further{X_clear.R_AB, X_clear.p_AB + SawTurn::kThere_mm / std::max(glm::length(out), 1e-9) * out};
    if (IsClear(phi, tool, X_further, 0)) X_clear = X_further;
  }
  const Pose& X_now = viewer_.figures().coupled.X_WT;
  if (std::vector<Pose> way = FindClearWay(phi, tool, X_now, X_clear, middle_W, 0, kMaxWay_mm); !way.empty())
    return way;
  // In the bone, or between its parts: the saw is lifted as far as its goal is.
  return {{X_now.R_AB, X_now.p_AB + X_clear.p_AB - X_WT.p_AB}, X_clear};
}

void PlanActions::OpenContextMenu(const ScreenPoint& at) {
  context_W_ = gestures_.PickBone(at);
  opens_context_ = true;
}

void PlanActions::DrawContextMenu(Ui& ui) {
  if (std::exchange(opens_context_, false)) ImGui::OpenPopup("context");
  if (!ImGui::BeginPopup("context")) return;
  if (context_W_) {
    if (ImGui::MenuItem(Tr("Turn the view about this place"))) viewer_.view().camera().set_target_W(*context_W_);
    ui.Note("context look");
    if (ImGui::MenuItem(Tr("Depth stop here"))) gestures_.AskDepth(*context_W_);
    ui.Note("context stop");
    if (ImGui::MenuItem(Tr("Mark a nerve from here"))) {
      gestures_.Place(PlanGestures::Placing::kMark, MarkKind::kNerve);
      gestures_.TakePoint(*context_W_);
    }
    ui.Note("context nerve");
    ImGui::Separator();
  }
  viewer_.actions().DrawEntries(ui, "Plan");
  ImGui::EndPopup();
}

}  // namespace kerf
