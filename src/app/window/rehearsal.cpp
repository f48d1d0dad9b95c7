#include "app/window/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include "app/window/export_order.h"
#include "app/window/is_ready.h"
#include "app/window/pieces_mode.h"
#include "base/core/cancelled.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"
#include "session/scene/path_csv.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Returns the smallest rotation from one unit vector to another, less than half a turn.
Quat RotationBetween(const Vec3& from, const Vec3& to) {
  const Vec3 axis = glm::cross(from, to);
  return glm::normalize(Quat{1 + glm::dot(from, to), axis.x, axis.y, axis.z});
}

constexpr double kEnd_s = 0.3;  // time that the work of other threads gets to end when the window is closed

const Range kDepthRange_mm = FindRange<DepthStop>("depth_mm");

std::optional<double> ParseDepth(const std::string& text) {
  double depth_mm = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), depth_mm);
  if (error != std::errc{} || end != text.data() + text.size() || !kDepthRange_mm.Contains(depth_mm)) return {};
  return depth_mm;
}

}  // namespace

Rehearsal::Rehearsal(const RehearsalOptions& options) : options_(options) {
  for (const std::string& file : options_.plans) {
    for (PlannedPlane& plane : ReadPlannedPlanes(file)) plan_.planes.push_back(std::move(plane));
  }
  options_.viewer.watch = true;
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
  pieces_ = std::make_unique<PiecesMode>(*viewer_);
}

Rehearsal::~Rehearsal() {
  if (loading_) Cancel();
}

RehearsalResult Rehearsal::Run() {
  BeginOpening(options_.input);
  viewer_->Run(*this);
  EndWork();
  return result_;
}

/// Ends what other threads still do: a file that is being written is completed, and loading is cancelled.
void Rehearsal::EndWork() {
  if (loading_) Cancel();
  if (exporting_.valid()) FollowExport();
  for (std::string& sentence : saver_.Finish()) result_.warnings.push_back(std::move(sentence));
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kEnd_s);
  const auto ends = [&](const auto& future) {
    return !future.valid() || future.wait_until(until) == std::future_status::ready;
  };
  if (making_nerve_.valid()) unused_.push_back(std::move(making_nerve_));
  result_.left_work = viewer_->left_work();
  for (const auto& making : unused_) result_.left_work = result_.left_work || !ends(making);
  for (const std::shared_ptr<Loading>& loading : cancelled_) {
    result_.left_work = result_.left_work || !ends(loading->opened);
  }
}

bool Rehearsal::cuts() const {
  return !in_pieces_ && !picking_ && !menu_;
}

// ---- opening

void Rehearsal::BeginOpening(const std::string& input) {
  auto loading = std::make_shared<Loading>();
  loading->input = input;
  loading->progress.Set("opening", 0, ProgressMeter::Now_s());
  const int session = viewer_->sessions() + 1;
  OpenOptions options;
  options.voxel_mm = options_.voxel_mm;
  options.bone_file =
      fmt::format("{}/bone{}.vdb", options_.viewer.folder, session == 1 ? "" : fmt::format("-{}", session));
  OpenWatcher watcher;
  Loading* const at = loading.get();  // outlives its thread
  watcher.progress = [at](const std::string& stage, double fraction) {
    const std::lock_guard lock(at->mutex);
    if (at->cancelled) throw kerf::Cancelled();
    at->progress.Set(stage, fraction, ProgressMeter::Now_s());
  };
  watcher.bone = [this, at](std::shared_ptr<const Bone> bone, bool final) {
    const std::lock_guard lock(at->mutex);
    if (at->cancelled) throw kerf::Cancelled();
    viewer_->ShowBone(std::move(bone), final);
  };
  watcher.ct = [at](std::shared_ptr<const Volume> ct) {
    const std::lock_guard lock(at->mutex);
    at->ct = std::move(ct);
  };
  loading->opened =
      std::async(std::launch::async, [input, options, watcher] { return OpenInput(input, options, watcher); });
  loading_ = std::move(loading);
  viewer_->trace().Write("opening", {{"input", input}});
}

void Rehearsal::Open(const std::string& path) {
  if (is_loading()) Cancel();
  to_open_ = path;
  change_.reset();
  if (viewer_->session() != nullptr) {
    viewer_->SetSpindle(false);
    viewer_->End();
  }
}

void Rehearsal::Cancel() {
  if (loading_) {
    {
      const std::lock_guard lock(loading_->mutex);
      loading_->cancelled = true;
    }
    cancelled_.push_back(std::exchange(loading_, nullptr));
    viewer_->trace().Write("cancelled", {{"input", cancelled_.back()->input}});
    Reset();
  } else if (is_loading()) {
    viewer_->End();  // Cancelled() follows
  }
}

bool Rehearsal::is_loading() const {
  const LiveSession* session = viewer_->session();
  return loading_ != nullptr || (session != nullptr && session->stage() == LiveStage::kLoading && is_new_bone_);
}

std::optional<WorkProgress> Rehearsal::progress() const {
  if (!loading_) return viewer_->progress();
  const std::lock_guard lock(loading_->mutex);
  return loading_->progress.Get(ProgressMeter::Now_s());
}

std::shared_ptr<const Volume> Rehearsal::ct() const {
  if (!loading_) return ct_;
  const std::lock_guard lock(loading_->mutex);
  return loading_->ct;
}

/// Empties the window and forgets everything that belongs to the bone.
void Rehearsal::Reset() {
  if (in_pieces_) LeavePieces();
  pieces_->Reset();
  menu_.reset();
  picking_.reset();
  change_.reset();
  to_save_.reset();
  checkpoints_.clear();
  plan_ = {};
  plan_is_unsaved_ = false;
  plane_ = 0;
  cut_.reset();
  guided_ = false;
  saw_is_listed_ = false;
  saw_ = 0;
  before_.reset();
  original_.reset();
  marks_.clear();
  mark_tubes_.clear();
  sampler_.reset();
  nerve_.reset();
  if (making_nerve_.valid()) unused_.push_back(std::move(making_nerve_));
  ct_.reset();
  viewer_->Clear();
  ShowPlanInPicture();
}

void Rehearsal::FollowOpening() {
  std::erase_if(unused_, [](const auto& making) { return IsReady(making); });
  std::erase_if(cancelled_, [](const std::shared_ptr<Loading>& loading) { return IsReady(loading->opened); });
  if (to_open_ && viewer_->session() == nullptr && !changing_.valid() && !viewer_->quitting()) {
    const std::string input = *std::exchange(to_open_, std::nullopt);
    Reset();
    is_command_line_ = false;
    BeginOpening(input);
  }
  if (!loading_ || !IsReady(loading_->opened)) return;
  const std::shared_ptr<Loading> loading = std::exchange(loading_, nullptr);
  OpenedInput opened;
  try {
    opened = loading->opened.get();
  } catch (const Error& e) {
    if (is_command_line_) throw;
    Reset();
    viewer_->Say(e.what());
    return;
  }
  if (viewer_->quitting()) return;
  ct_ = std::exchange(loading->ct, nullptr);
  scene_ = std::move(opened.scene);
  scene_file_ = opened.scene_file;
  if (opened.project) {
    marks_ = opened.project->marks;
    mark_tubes_ = MakeMarkTubes(marks_);
    original_ = opened.original;
  }
  for (const PlannedPlane& planned : scene_.plan.planes) plan_.planes.push_back(planned);
  for (const DepthStop& stop : scene_.plan.stops) plan_.stops.push_back(stop);
  if (opened.bone && !opened.bone_is_saved) to_save_ = ToSave{opened.bone, scene_.bone.file};
  is_new_bone_ = true;
  ++inputs_;
  first_recording_ = result_.recordings.size();
  Restart(std::move(opened.bone), opened.bone_was_shown);
}

void Rehearsal::Cancelled() {
  result_.recordings.pop_back();
  if (is_new_bone_) --inputs_;
  if (!viewer_->quitting()) Reset();
}

bool Rehearsal::TakeFailure(const std::string& sentence) {
  if (is_command_line_ || !is_new_bone_) return false;
  result_.recordings.pop_back();
  --inputs_;
  Reset();
  viewer_->Say(sentence);
  return true;
}

// ---- sessions

void Rehearsal::Restart(std::shared_ptr<const Bone> bone, bool same_bone) {
  result_.recordings.push_back("");
  viewer_->Begin(scene_, scene_file_, same_bone, std::move(bone));
  result_.recordings.back() = viewer_->recording();
}

void Rehearsal::Began() {
  const bool first = std::exchange(is_new_bone_, false);
  before_ = original_ ? original_ : viewer_->bone_at_start();
  if (!sampler_) sampler_ = std::make_unique<PhiSampler>(*before_);
  checkpoints_ = {"start"};
  if (to_save_) saver_.Save(std::move(to_save_->bone), to_save_->path);
  to_save_.reset();
  if (first) {
    making_nerve_ = std::async(std::launch::async,
                               [bone = before_] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
    viewer_->Say(Tr("Space starts the saw; drag with the left button to move it; F1 for help"));
  } else if (change_) {
    viewer_->Say(std::exchange(change_, std::nullopt)->what);
  }
  ShowPlanInPicture();
}

void Rehearsal::ContinueWith(const std::string& what, std::function<void(Scene&)> change) {
  if (!viewer_->is_running() || change_) return;
  change_ = Change{.what = what, .apply = std::move(change)};
  viewer_->SetSpindle(false);
  viewer_->End();
}

void Rehearsal::Ended(LoopSummary summary) {
  if (!change_ || viewer_->quitting()) return;
  const Pose X_WT = viewer_->figures().coupled.X_WT;
  // The next session begins with the bone in memory. It is saved while that session runs, because the recording refers
  // to its file.
  changing_ = std::async(std::launch::async, [this, X_WT, scene = scene_, apply = change_->apply,
                                              bone = std::make_shared<const Bone>(std::move(summary.after))]() mutable {
    const int session = viewer_->sessions() + 1;
    scene.bone.source = BoneSource::kFile;
    scene.bone.file = fs::absolute(fmt::format("{}/bone-{}.vdb", options_.viewer.folder, session)).string();
    apply(scene);
    const Tool tool = MakeTool(scene);
    const Pose X_clear = FindClearPose(*bone, tool, X_WT);
    // The tool starts at the first pose of the path, and the hand continues from there.
    scene.path = {};
    scene.path.poses = {{.time_s = 0, .X_WT = X_clear}, {.time_s = 1, .X_WT = X_clear}};
    scene.path.poses.back().X_WT.p_AB.z += 1;
    const std::string path = fmt::format("{}/path-{}.csv", options_.viewer.folder, session);
    WriteTextFile(path, FormatPathCsv(scene.path.poses));
    scene.path.file = fs::absolute(path).string();
    return Changed{std::move(scene), std::move(bone)};
  });
}

void Rehearsal::FollowChange() {
  for (const std::string& sentence : saver_.TakeFailures()) {
    viewer_->Say(
        fmt::format(fmt::runtime(Tr("The bone could not be saved; it is tried again at the end. {}")), sentence));
  }
  if (!IsReady(changing_)) return;
  Changed changed = changing_.get();
  if (viewer_->quitting() || to_open_) return;
  scene_ = std::move(changed.scene);
  to_save_ = ToSave{changed.bone, scene_.bone.file};
  Restart(std::move(changed.bone), true);
}

void Rehearsal::SelectSaw(std::size_t number) {
  if (number >= options_.saws.size() || (saw_is_listed_ && number == saw_)) return;
  if (!viewer_->is_running() || change_) return;
  const Saw& saw = options_.saws[number];
  ContinueWith(fmt::format(fmt::runtime(Tr("Saw: {}")), saw.name), [saw](Scene& scene) { UseSaw(scene, saw); });
  saw_ = number;
  saw_is_listed_ = true;
}

void Rehearsal::ToggleGuide() {
  if (!viewer_->is_running() || change_) return;
  const PlannedPlane* planned = plane();
  const DepthStop* stop = plan_.stops.empty() ? nullptr : &plan_.stops.front();
  if (!guided_ && planned == nullptr && stop == nullptr) {
    viewer_->Say(Tr("There is no plan to guide the saw yet; press N"));
    return;
  }
  try {
    const std::optional<EffectChoice> guide = guided_ ? std::nullopt : std::optional(MakeGuide(planned, stop));
    guided_ = !guided_;
    ContinueWith(
        guided_ ? Tr("The guide keeps the saw in the planned plane") : Tr("The guide is off"), [guide](Scene& scene) {
          std::erase_if(scene.effects, [](const EffectChoice& e) { return std::string_view(e.name()) == "guide"; });
          if (guide) scene.effects.push_back(*guide);
        });
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

// ---- undo

void Rehearsal::RequestCheckpoint() {
  viewer_->AskText(Tr("Name of the checkpoint:"), fmt::format("cut {}", checkpoints_.size()),
                   [this](const std::optional<std::string>& name) {
                     if (!name || name->empty() || !viewer_->is_running()) return;
                     checkpoints_.push_back(*name);
                     viewer_->session()->Ask({.kind = LoopAction::Kind::kCheckpoint, .name = *name});
                   });
}

void Rehearsal::GoBack(const std::string& name) {
  if (!viewer_->is_running()) return;
  // A spinning saw would cut the restored bone.
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kUndo, .name = name});
}

void Rehearsal::GoForward() {
  if (!viewer_->is_running()) return;
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kRedo, .name = ""});
}

void Rehearsal::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (auto name = checkpoints_.rbegin(); name != checkpoints_.rend(); ++name) {
    items.push_back({.name = *name, .detail = "", .choose = [this, back = *name] { GoBack(back); }});
  }
  SetMenu(Menu(Tr("Go back to"), std::move(items)));
}

// ---- the plan

const PlannedPlane* Rehearsal::plane() const {
  return plane_ < plan_.planes.size() ? &plan_.planes[plane_] : nullptr;
}

void Rehearsal::ShowPlanInPicture() {
  std::vector<PlaneOverlay> planes;
  for (std::size_t i = 0; i < plan_.planes.size(); ++i) {
    const PlannedPlane& p = plan_.planes[i];
    planes.push_back({.name = p.name,
                      .p_W = p.plane.p_W,
                      .normal_W = p.plane.normal_W,
                      .width_mm = p.width_mm,
                      .height_mm = p.height_mm,
                      .up_W = CalcPlaneAxes(p).up_W,
                      .selected = i == plane_});
  }
  viewer_->view().SetPlanes(planes);
  if (const auto watch = viewer_->cut_watch()) watch->SetPlanes(plan_.planes);
  if (viewer_->surface() != nullptr) viewer_->surface()->RequestPlaneLines(planes);
  std::vector<DepthStopOverlay> stops;
  for (const DepthStop& stop : plan_.stops) {
    stops.push_back(
        {.name = stop.name, .p_W = stop.p_W_mm + stop.depth_mm * stop.direction_W, .normal_W = -stop.direction_W});
  }
  viewer_->view().SetDepthStops(stops);
}

void Rehearsal::FollowCut() {
  const std::shared_ptr<CutWatch> watch = viewer_->cut_watch();
  if (!watch) return;
  if (std::optional<PlanesReport> report = watch->Fetch()) cut_ = std::move(report);
  for (const FreedPiece& piece : watch->TakeFreed()) {
    viewer_->Say(fmt::format("A piece of {:.0f} mm\u00b3 came free", piece.volume_mm3));
    viewer_->trace().Write("came_free", {{"mm3", piece.volume_mm3}});
  }
}

void Rehearsal::PickPoints(const std::string& prompt, std::size_t count,
                           std::function<void(const std::vector<Vec3>&)> done) {
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  picking_ = Picking{.prompt = prompt, .count = count, .points = {}, .done = std::move(done)};
}

void Rehearsal::AlignToPlane() {
  const PlannedPlane* planned = plane();
  if (planned == nullptr) return viewer_->Say(Tr("No plane is planned yet; press N"));
  if (!viewer_->is_running()) return;
  // Aligns the spindle with the plane's normal by the smaller rotation and moves the disc's centre into the plane.
  Pose X = viewer_->figures().coupled.X_WT;
  const Vec3 spindle = X.Vector({0, 0, 1});
  Vec3 normal = planned->plane.normal_W;
  if (glm::dot(normal, spindle) < 0) normal = -normal;
  X.R_AB = glm::normalize(RotationBetween(spindle, normal) * X.R_AB);
  X.p_AB -= glm::dot(X.p_AB - planned->plane.p_W, normal) * normal;
  viewer_->controls().Set(X);
  viewer_->Say(fmt::format(fmt::runtime(Tr("The saw is turning into {}; keep it clear of the bone")), planned->name));
}

void Rehearsal::WritePlan() {
  const std::string file = options_.viewer.folder + "/plan.mrk.json";
  WritePlaneMarkups(file, MakeMarkups(plan_));
  viewer_->Say(fmt::format(fmt::runtime(Tr("Plan: {}")), file));
}

void Rehearsal::AddPlane(PlannedPlane planned) {
  plan_.planes.push_back(std::move(planned));
  plane_ = plan_.planes.size() - 1;
  PlanChanged();
}

void Rehearsal::PlanChanged() {
  plan_is_unsaved_ = true;
  plane_ = std::min(plane_, plan_.planes.empty() ? 0 : plan_.planes.size() - 1);
  ShowPlanInPicture();
  viewer_->trace().Write("plan", {{"planes", plan_.planes.size()}, {"stops", plan_.stops.size()}});
}

void Rehearsal::ShowPlan() {
  // The same entries as in the menu, with numbers.
  std::vector<MenuItem> items;
  for (const char* id : {"plan.three_points", "plan.at_blade", "plan.stop", "plan.align", "plan.next", "plan.remove",
                         "plan.remove_stops", "plan.read", "plan.write"}) {
    const Action* action = viewer_->actions().Find(id);
    items.push_back(
        {.name = Tr(action->label), .detail = Tr(action->tip), .enabled = action->is_enabled(), .choose = action->run});
  }
  SetMenu(Menu(Tr("Plan"), std::move(items)));
}

void Rehearsal::AddActions(ActionList& actions) {
  const auto running = [this] { return viewer_->is_running() && !change_; };
  const auto cutting = [this, running] { return running() && cuts(); };
  const auto in_pieces = [this] { return in_pieces_ && pieces_->is_ready(); };
  const auto either = [cutting, in_pieces] { return cutting() || in_pieces(); };
  // ---- file
  actions.Add(
      {.id = "file.open",
       .menu = Mark("File"),
       .label = Mark("Open a bone, a scene or a CT"),
       .shortcut = {.key = Key::kO, .control = true},
       .tip = Mark("A scene, a .vdb bone, a surface, a CT file or a folder with a DICOM series; or drop it here"),
       .run = [this] { AskOpen(); },
       .button = Mark("Open")});
  actions.Add({.id = "file.save",
               .menu = Mark("File"),
               .label = Mark("Save the project"),
               .shortcut = {.key = Key::kS, .control = true},
               .tip = Mark("One file with bone, plan, marks, recordings, pieces and views"),
               .run = [this] { SaveProject(); },
               .enabled = [this, running] { return running() && !saving_.valid(); },
               .button = Mark("Save")});
  actions.Add({.id = "file.export",
               .menu = Mark("File"),
               .label = Mark("Export pieces, planes and report"),
               .shortcut = {Key::kF9},
               .tip = Mark("Writes the pieces as surfaces, the planned and achieved planes, and a report"),
               .run = [this] { Export(); },
               .enabled = [this, running] { return running() && !exporting_.valid(); },
               .button = Mark("Export")});
  // ---- edit
  actions.Add({.id = "edit.undo",
               .menu = Mark("Edit"),
               .label = Mark("Undo"),
               .shortcut = {.key = Key::kZ, .control = true},
               .run = [this] { in_pieces_ ? pieces_->Undo() : GoBack(""); },
               .enabled = either,
               .button = Mark("Undo")});
  actions.Add({.id = "edit.redo",
               .menu = Mark("Edit"),
               .label = Mark("Redo"),
               .shortcut = {.key = Key::kY, .control = true},
               .run = [this] { in_pieces_ ? pieces_->Redo() : GoForward(); },
               .enabled = either,
               .button = Mark("Redo")});
  actions.Add({.id = "edit.redo_too",
               .menu = "",
               .shortcut = {.key = Key::kZ, .control = true, .shift = true},
               .run = [this] { in_pieces_ ? pieces_->Redo() : GoForward(); },
               .enabled = either});
  actions.Add({.id = "edit.checkpoint",
               .menu = Mark("Edit"),
               .label = Mark("Make a checkpoint with a name"),
               .shortcut = {Key::kC},
               .run = [this] { in_pieces_ ? pieces_->AskCheckpoint() : RequestCheckpoint(); },
               .enabled = either,
               .button = Mark("Checkpoint")});
  actions.Add({.id = "edit.back",
               .menu = Mark("Edit"),
               .label = Mark("Return to a checkpoint"),
               .shortcut = {Key::kB},
               .run = [this] { in_pieces_ ? pieces_->ShowCheckpoints() : ShowCheckpoints(); },
               .enabled = either});
  // ---- saws
  for (std::size_t i = 0; i < options_.saws.size(); ++i) {
    Action saw{.id = fmt::format("saw.{}", i + 1),
               .menu = Mark("Saw"),
               .label = options_.saws[i].name.c_str(),
               .run = [this, i] { SelectSaw(i); },
               .enabled = cutting,
               .on = [this, i] { return saw_is_listed_ && saw_ == i; },
               .begins_group = i == 0};
    if (i < 9) saw.shortcut.key = static_cast<Key>('1' + i);
    actions.Add(std::move(saw));
  }
  actions.Add({.id = "saw.next",
               .menu = Mark("Saw"),
               .label = Mark("Next saw"),
               .shortcut = {Key::kTab},
               .run = [this] { SelectSaw(saw_is_listed_ ? (saw_ + 1) % options_.saws.size() : 0); },
               .enabled = cutting});
  // ---- plan
  actions.Add({.id = "plan.show",
               .menu = Mark("Plan"),
               .label = Mark("Plan: planes and depth stops"),
               .shortcut = {Key::kN},
               .run = [this] { ShowPlan(); },
               .enabled = cutting,
               .button = Mark("Plan")});
  actions.Add({.id = "plan.guide",
               .menu = Mark("Plan"),
               .label = Mark("Guide the saw along the plan"),
               .shortcut = {Key::kG},
               .tip = Mark("Holds the saw in the planned plane and above the depth stop"),
               .run = [this] { ToggleGuide(); },
               .enabled = cutting,
               .on = [this] { return guided_; },
               .indicator = Mark("Guide")});
  actions.Add({.id = "plan.three_points",
               .menu = Mark("Plan"),
               .label = Mark("Plane through three points"),
               .tip = Mark("click them on the bone"),
               .run =
                   [this] {
                     PickPoints(Tr("Click a point of the plane on the bone"), 3, [this](const std::vector<Vec3>& p) {
                       AddPlane(PlacePlane(MakePlaneName(plan_), p[0], p[1], p[2]));
                     });
                   },
               .enabled = running,
               .begins_group = true});
  actions.Add({.id = "plan.at_blade",
               .menu = Mark("Plan"),
               .label = Mark("Plane where the blade is"),
               .run = [this] { AddPlane(PlacePlane(MakePlaneName(plan_), viewer_->figures().coupled.X_WT)); },
               .enabled = running});
  actions.Add({.id = "plan.stop",
               .menu = Mark("Plan"),
               .label = Mark("Depth stop"),
               .tip = Mark("click its point on the bone"),
               .run =
                   [this] {
                     PickPoints(Tr("Click where the cut begins on the bone"), 1,
                                [this](const std::vector<Vec3>& p) { AskDepth(p.front()); });
                   },
               .enabled = running});
  actions.Add({.id = "plan.align",
               .menu = Mark("Plan"),
               .label = Mark("Turn the saw into the plane"),
               .run = [this] { AlignToPlane(); },
               .enabled = [this, running] { return running() && plane() != nullptr; }});
  actions.Add({.id = "plan.next",
               .menu = Mark("Plan"),
               .label = Mark("Next plane"),
               .run =
                   [this] {
                     plane_ = (plane_ + 1) % plan_.planes.size();
                     ShowPlanInPicture();
                   },
               .enabled = [this, running] { return running() && plan_.planes.size() > 1; }});
  actions.Add({.id = "plan.remove",
               .menu = Mark("Plan"),
               .label = Mark("Remove this plane"),
               .run =
                   [this] {
                     plan_.planes.erase(plan_.planes.begin() + static_cast<std::ptrdiff_t>(plane_));
                     PlanChanged();
                   },
               .enabled = [this, running] { return running() && plane() != nullptr; }});
  actions.Add({.id = "plan.remove_stops",
               .menu = Mark("Plan"),
               .label = Mark("Remove all depth stops"),
               .run =
                   [this] {
                     plan_.stops.clear();
                     PlanChanged();
                   },
               .enabled = [this, running] { return running() && !plan_.stops.empty(); }});
  actions.Add({.id = "plan.read",
               .menu = Mark("Plan"),
               .label = Mark("Read planes of 3D Slicer"),
               .tip = Mark("a file .mrk.json"),
               .run = [this] { AskPlanFile(); },
               .enabled = running,
               .begins_group = true});
  actions.Add({.id = "plan.write",
               .menu = Mark("Plan"),
               .label = Mark("Write the plan"),
               .tip = Mark("into plan.mrk.json, for 3D Slicer"),
               .run = [this] { WritePlan(); },
               .enabled = [this, running] { return running() && !plan_.empty(); }});
  // ---- pieces
  actions.Add({.id = "pieces.enter",
               .menu = Mark("Pieces"),
               .label = Mark("Work with the pieces, or return to cutting"),
               .shortcut = {Key::kP},
               .tip = Mark("Splits the bone where it is cut through; pieces can be moved, hidden and measured"),
               .run = [this] { in_pieces_ ? LeavePieces() : EnterPieces(); },
               .enabled = [this, cutting] { return cutting() || in_pieces_; },
               .on = [this] { return in_pieces_; },
               .button = Mark("Pieces")});
  pieces_->AddActions(actions);
}

void Rehearsal::AskPlanFile() {
  viewer_->dialogs().ChooseFile(viewer_->ui(), Tr("Planes of 3D Slicer (.mrk.json)"), ".", {".mrk.json"}, false, "",
                                [this](const std::string& file) {
                                  try {
                                    for (PlannedPlane& p : ReadPlannedPlanes(file)) AddPlane(std::move(p));
                                  } catch (const Error& e) {
                                    viewer_->Say(e.what());
                                  }
                                });
}

void Rehearsal::AskOpen() {
  viewer_->controls().Release();
  viewer_->dialogs().ChooseFile(viewer_->ui(),
                                Tr("Open a bone, a scene, a surface, a CT, or a folder with a DICOM series"), ".", {},
                                false, "", [this](const std::string& path) { Open(path); });
}

void Rehearsal::AskDepth(const Vec3& p_W) {
  viewer_->AskText(Tr("Depth in mm:"), "5", [this, p_W](const std::optional<std::string>& text) {
    if (!text) return;
    const std::optional<double> depth_mm = ParseDepth(*text);
    if (!depth_mm)
      return viewer_->Say(
          fmt::format(fmt::runtime(Tr("The depth must be a number from {}")), ShowRange(kDepthRange_mm, "mm")));
    DepthStop stop;
    stop.name = MakeStopName(plan_);
    stop.p_W_mm = p_W;
    // The direction into the bone: from the blade's current centre to the point.
    stop.direction_W =
        CalcDirection(p_W - viewer_->figures().coupled.X_WT.p_AB).value_or(viewer_->MakeBasis().forward_W);
    stop.depth_mm = *depth_mm;
    plan_.stops.push_back(stop);
    PlanChanged();
  });
}

// ---- pieces and export

void Rehearsal::EnterPieces() {
  if (!viewer_->is_running() || change_) return;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  pieces_->Enter();
  in_pieces_ = true;
}

void Rehearsal::LeavePieces() {
  pieces_->Leave();
  in_pieces_ = false;
}

void Rehearsal::Export() {
  if (!viewer_->is_running() || exporting_.valid() || change_) return;
  viewer_->SetSpindle(false);
  ExportOrder order;
  order.folder = fmt::format("{}/take-away{}", options_.viewer.folder, inputs_ == 1 ? "" : fmt::format("-{}", inputs_));
  order.obj = options_.obj;
  order.scene = viewer_->session()->scene();
  order.recordings = {result_.recordings.begin() + static_cast<std::ptrdiff_t>(first_recording_),
                      result_.recordings.end()};
  order.plan = plan_;
  order.marks = marks_;
  if (saw_is_listed_) order.saw_name = options_.saws[saw_].name;
  order.before = before_;
  order.forces = viewer_->forces();
  try {
    order.pictures.emplace_back("As seen in the window", viewer_->GrabScene());
  } catch (const Error& e) {
    return viewer_->Say(e.what());
  }
  if (pieces_->is_up_to_date()) order.pieces_json = pieces_->pieces()->FormatJson();
  order.measures = pieces_->measures();
  order.after = viewer_->session()->AskBone();
  viewer_->Say(Tr("Exporting pieces, planes and report"));
  exporting_ = std::async(std::launch::async,
                          [order = std::make_shared<ExportOrder>(std::move(order))] { return RunExport(*order); });
}

/// Waits for the end of the export.
void Rehearsal::FollowExport() {
  try {
    result_.take_away = exporting_.get();
    viewer_->Say(fmt::format(fmt::runtime(Tr("Exported: {}")), result_.take_away));
    viewer_->trace().Write("taken_away", {{"folder", result_.take_away}});
  } catch (const std::exception& e) {  // the session has ended in the meantime and returns no bone
    viewer_->Say(fmt::format(fmt::runtime(Tr("Nothing was exported: {}")), e.what()));
    viewer_->trace().Write("taken_away", {{"failure", e.what()}});
  }
}

void Rehearsal::FollowSaving() {
  try {
    const std::string file = saving_.get();
    viewer_->Say(fmt::format(fmt::runtime(Tr("Project: {}")), file));
    viewer_->trace().Write("project", {{"file", file}});
    plan_is_unsaved_ = false;
  } catch (const std::exception& e) {
    viewer_->Say(fmt::format(fmt::runtime(Tr("The project was not saved: {}")), e.what()));
    viewer_->trace().Write("project", {{"failure", e.what()}});
  }
}

void Rehearsal::SaveProject() {
  if (!viewer_->is_running() || saving_.valid() || change_) return;
  viewer_->SetSpindle(false);
  auto project = std::make_shared<Project>();
  project->title = scene_.TitleOrName();
  project->scene = viewer_->session()->scene();
  project->scene.plan = plan_;
  project->marks = marks_;
  for (const std::string& recording : result_.recordings) {
    if (std::filesystem::exists(recording)) project->recordings.push_back(recording);  // a session that has ended
  }
  if (pieces_->is_up_to_date()) project->pieces_json = pieces_->pieces()->FormatJson();
  std::shared_future<Bone> now = viewer_->session()->AskBone().share();
  viewer_->Say(Tr("Saving the project"));
  saving_ = std::async(std::launch::async, [project, now, before = before_, folder = options_.viewer.folder] {
    project->bone_file = folder + "/bone-before.vdb";
    project->cut_bone_file = folder + "/bone-now.vdb";
    WriteBone(*before, project->bone_file);
    WriteBone(now.get(), project->cut_bone_file);
    const std::string file = folder + "/case" + kProjectExtension;
    WriteProject(file, *project);
    return file;
  });
}

// ---- events

void Rehearsal::SetMenu(Menu menu) {
  viewer_->controls().Release();
  menu_ = std::move(menu);
}

bool Rehearsal::TakeClick(const WindowEvent& event) {
  if (event.kind != WindowEvent::Kind::kMouseDown || event.button != MouseButton::kLeft) return false;
  const ScreenPoint at{event.x, event.y};
  if (viewer_->surface() == nullptr) return false;
  const std::optional<Vec3> p_W = viewer_->surface()->Pick(viewer_->view().camera().CalcRay(at));
  if (!p_W) {
    viewer_->Say(Tr("There is no bone under the mouse"));
    return true;
  }
  picking_->points.push_back(*p_W);
  viewer_->trace().Write("point", {{"mm", {p_W->x, p_W->y, p_W->z}}});
  if (picking_->points.size() < picking_->count) return true;
  const Picking picked = *std::exchange(picking_, std::nullopt);
  try {
    picked.done(picked.points);
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
  return true;
}

void Rehearsal::PickMenuRow(int row) {
  if (in_pieces_) return pieces_->PickMenuRow(row);
  if (!menu_ || menu_->Pick(row) != Menu::State::kChosen) return;
  ChooseFromMenu(*std::exchange(menu_, std::nullopt));
}

void Rehearsal::ChooseFromMenu(const Menu& menu) {
  if (!menu.chosen().choose) return;
  try {
    menu.chosen().choose();
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

void Rehearsal::PickPieceRow(int row) {
  if (in_pieces_ && pieces_->is_ready()) pieces_->PickPieceRow(row);
}

bool Rehearsal::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (menu_) {
    const Menu::State state = menu_->Take(event);
    if (state == Menu::State::kOpen) return event.kind != Kind::kScroll && event.kind != Kind::kKeyUp;
    const Menu done = *std::exchange(menu_, std::nullopt);
    if (state == Menu::State::kChosen) ChooseFromMenu(done);
    return true;
  }
  if (picking_) {
    if (event.kind == Kind::kKeyDown && event.key == Key::kEscape) {
      picking_.reset();
      return true;
    }
    return TakeClick(event);
  }
  const bool escape = event.kind == Kind::kKeyDown && event.key == Key::kEscape && !event.control;
  if (escape && is_loading()) return Cancel(), true;
  if (!in_pieces_) return false;
  if (pieces_->Take(event)) return true;
  if (escape) return LeavePieces(), true;
  return false;
}

// ---- frames

void Rehearsal::Update(double /*dt_s*/) {
  FollowChange();
  FollowOpening();
  if (IsReady(making_nerve_)) nerve_ = making_nerve_.get();
  if (IsReady(exporting_)) FollowExport();
  if (IsReady(saving_)) FollowSaving();
  FollowCut();
  if (in_pieces_) pieces_->Update();
}

void Rehearsal::Fill(HudState& hud) {
  hud.status.mode = in_pieces_ ? Tr("Pieces") : Tr("Rehearse");
  if (saw_is_listed_) hud.status.saw = options_.saws[saw_].name;
  if (viewer_->is_running()) {
    const Tool tool = MakeTool(viewer_->session()->scene());
    const Pose& X_WT = viewer_->figures().coupled.X_WT;
    const NearestStructure nerve = FindNearestStructure(nerve_.get(), Tr("nerve"), mark_tubes_, tool, X_WT);
    hud.values.nerve_mm = nerve.distance_mm;
    hud.values.nerve_is_marked = nerve.distance_mm.has_value() || !nerve_;
    if (sampler_) hud.values.depth_mm = CalcBladeDepth(*sampler_, tool, X_WT);
    if (const PlannedPlane* planned = plane()) {
      const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
      hud.values.plan_offset_mm = off.offset_mm;
      hud.values.plan_angle_deg = off.angle_deg;
    }
    if (!plan_.stops.empty()) {
      const StopDeviation stop = CalcDeviation(plan_.stops.front(), tool, X_WT);
      HudGauge gauge;
      gauge.title = plan_.stops.front().name;
      gauge.upper = std::max(1.0, 1.5 * plan_.stops.front().depth_mm);
      gauge.value = stop.depth_mm;
      gauge.goal = plan_.stops.front().depth_mm;
      gauge.level = stop.left_mm < -1     ? HudLevel::kBad
                    : stop.left_mm < -0.3 ? HudLevel::kWarn
                    : stop.left_mm < 0.3  ? HudLevel::kGood
                    : stop.left_mm < 1    ? HudLevel::kWarn
                                          : HudLevel::kPlain;
      gauge.word = stop.left_mm < -0.3  ? Tr("too deep")
                   : stop.left_mm < 0.3 ? Tr("stop")
                   : stop.left_mm < 1   ? Tr("slow down")
                                        : Tr("continue");
      hud.gauge = gauge;
    }
  }
  SoundAlarms();
  if (loading_) {
    const WorkProgress now = *progress();
    hud.progress = HudProgress{.title = Tr("Opening"), .stage = Tr(now.stage.c_str()), .fraction = now.fraction};
  } else if (change_) {
    hud.progress.reset();  // it takes less than a second
  }
  if (picking_) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kQuestion,
                           .text = fmt::format(fmt::runtime(Tr("{} ({} of {})")), picking_->prompt,
                                               picking_->points.size() + 1, picking_->count),
                           .answers = Tr("left click   Esc: cancel")};
  }
  if (menu_) hud.menu = menu_->Show();
  if (in_pieces_) pieces_->Fill(hud);
}

/// Sounds the alarms of a saw that touches bone.
void Rehearsal::SoundAlarms() {
  std::optional<double> depth_mm;
  std::optional<double> nerve_mm;
  std::optional<double> margin_mm;
  if (viewer_->is_running() && viewer_->spindle_on() && viewer_->touches()) {
    const Tool tool = MakeTool(viewer_->session()->scene());
    const Pose& X_WT = viewer_->figures().coupled.X_WT;
    if (nerve_ && !nerve_->empty()) nerve_mm = nerve_->Calc(tool, X_WT);
    if (!plan_.stops.empty()) depth_mm = CalcDeviation(plan_.stops.front(), tool, X_WT).left_mm;
    if (const PlannedPlane* planned = plane()) {
      margin_mm = planned->margin_mm - std::abs(CalcDeviation(*planned, tool, X_WT).offset_mm);
    }
  }
  viewer_->sound().SetAlarm(AlarmKind::kDepth, depth_mm);
  viewer_->sound().SetAlarm(AlarmKind::kStructure, nerve_mm);
  viewer_->sound().SetAlarm(AlarmKind::kMargin, margin_mm);
}

std::vector<HudKeyGroup> Rehearsal::help() const {
  return in_pieces_ ? PiecesMode::help() : std::vector<HudKeyGroup>();
}

std::vector<TourStep> Rehearsal::tour() const {
  return {
      {Tr("Look around"), Tr("Drag with the right mouse button to turn the bone, turn the wheel to zoom. "
                             "V shows the next side, T makes the bone translucent.")},
      {Tr("Open your own CT"), Tr("File > Open reads a folder with a DICOM series, a CT file, a surface or a bone. "
                                  "You can also drop it into this window.")},
      {Tr("Plan a cut"), Tr("Plan > Plane through three points: click three points on the bone. G then guides the "
                            "saw along the plane.")},
      {Tr("Cut"), Tr("Space starts the saw. Drag with the left mouse button to move it, with Shift into the picture, "
                     "with Ctrl to turn it. Release the button, and the saw stops.")},
      {Tr("Undo"), Tr("Ctrl+Z takes back a cut. R returns the saw to its start while the spindle is off.")},
      {Tr("Pieces and results"), Tr("P splits the bone where it is cut through, and lets you move and measure the "
                                    "pieces. F9 exports pieces, planes and a report.")}};
}

void Rehearsal::Describe(nlohmann::json& state) const {
  state["mode"] = menu_ ? "menu" : picking_ ? "picking" : in_pieces_ ? "pieces" : "cutting";
  if (menu_) state["menu"] = menu_->title();
  state["planes"] = plan_.planes.size();
  state["stops"] = plan_.stops.size();
  state["guided"] = guided_;
  state["plane_cut"] = nlohmann::json::array();
  if (cut_) {
    for (const PlanesReport::Row& row : cut_->planes) state["plane_cut"].push_back(row.state.fraction());
  }
  state["saw"] = saw_is_listed_ ? options_.saws[saw_].name : "";
  if (in_pieces_) pieces_->Describe(state);
}

}  // namespace kerf
