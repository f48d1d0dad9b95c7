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
#include "app/window/open_with_desktop.h"
#include "app/window/pieces_mode.h"
#include "app/window/plan_editor.h"
#include "app/window/plan_picture.h"
#include "base/core/cancelled.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "bone/import/ct_view.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"
#include "session/scene/path_csv.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kOtherCut_mm = 6;  // a cut further beside a plane than this is not meant for it
constexpr double kEnd_s = 0.3;      // time that the work of other threads gets to end when the window is closed

}  // namespace

Rehearsal::Rehearsal(const RehearsalOptions& options) : options_(options) {
  for (const std::string& file : options_.plans) {
    for (PlannedPlane& plane : ReadPlannedPlanes(file)) given_planes_.push_back(std::move(plane));
  }
  options_.viewer.watch = true;
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
  pieces_ = std::make_unique<PiecesMode>(*viewer_);
  editor_ = std::make_unique<PlanEditor>(*viewer_);
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
  return !in_pieces_ && !editor_->gestures.is_placing() && !menu_;
}

// ---- opening

void Rehearsal::BeginOpening(const std::string& input) {
  auto loading = std::make_shared<Loading>();
  loading->input = input;
  loading->progress.Set("opening", 0, ProgressMeter::Now_s());
  const int session = viewer_->sessions() + 1;
  OpenOptions options;
  options.project_folder =
      fmt::format("{}/project{}", options_.viewer.folder, inputs_ == 0 ? "" : fmt::format("-{}", inputs_ + 1));
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
  try {
    CheckInput(path);  // a wrong file must not end the session
  } catch (const Error& e) {
    return viewer_->dialogs().Ask(e.what(), {{Tr("OK"), nullptr}});
  }
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
  change_.reset();
  to_save_.reset();
  checkpoints_.clear();
  editor_->document.Load({}, {});
  editor_->gestures.Reset();
  cut_.reset();
  guided_ = false;
  saw_is_listed_ = false;
  saw_ = 0;
  before_.reset();
  original_.reset();
  sampler_.reset();
  nerve_.reset();
  if (making_nerve_.valid()) unused_.push_back(std::move(making_nerve_));
  ct_.reset();
  viewer_->Clear();
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
  if (!loading->input.empty()) {
    AddRecent(viewer_->settings(), loading->input);
    viewer_->KeepSettings();
  }
  ct_ = std::exchange(loading->ct, nullptr);
  scene_ = std::move(opened.scene);
  scene_file_ = opened.scene_file;
  original_ = opened.original;
  viewer_->set_original(original_);
  views_ = opened.project ? opened.project->views : std::vector<ProjectView>();
  pieces_json_ = opened.project ? opened.project->pieces_json : "";
  editor_->document.Load(scene_.plan, opened.project ? opened.project->marks : std::vector<Mark>());
  if (!given_planes_.empty()) editor_->document.Add(std::exchange(given_planes_, {}));
  editor_->document.set_saved();
  if (opened.bone && !opened.bone_is_saved) to_save_ = ToSave{opened.bone, scene_.bone.file};
  warnings_ = std::move(opened.warnings);
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
  if (const auto watch = viewer_->cut_watch()) watch->SetPlanes(editor_->document.plan().planes);
  if (first && !warnings_.empty()) {
    viewer_->dialogs().Ask(fmt::format("{}", fmt::join(std::exchange(warnings_, {}), "\n\n")), {{Tr("OK"), nullptr}});
  }
  if (first && views_.empty()) viewer_->view().FitAll();  // the bone differs from what was shown while it was loaded
  if (first && !views_.empty()) {
    const ProjectView& view = views_.front();
    ViewCamera& camera = viewer_->view().camera();
    camera.Look(view.toward_eye_W, view.up_W);
    camera.set_target_W(view.target_W_mm);
    camera.set_height_mm(view.height_mm);
    viewer_->KeepView();
  }
  if (first && !pieces_json_.empty()) pieces_->set_earlier(std::exchange(pieces_json_, {}));
  editor_->actions.set_middle_mm(before_->CalcBounds().centre().x);
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
  const PlannedPlane* planned = editor_->document.plane();
  const std::vector<DepthStop>& stops = editor_->document.plan().stops;
  const DepthStop* stop = stops.empty() ? nullptr : &stops.front();
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

void Rehearsal::Undo() {
  if (in_pieces_) return pieces_->Undo();
  // The latest change is undone, whether of the plan or of the bone.
  if (editor_->document.is_latest_change()) return viewer_->actions().Find("plan.undo")->run();
  GoBack("");
}

void Rehearsal::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (auto name = checkpoints_.rbegin(); name != checkpoints_.rend(); ++name) {
    items.push_back({.name = *name, .detail = "", .choose = [this, back = *name] { GoBack(back); }});
  }
  SetMenu(Menu(Tr("Go back to"), std::move(items)));
}

// ---- the plan

void Rehearsal::FollowCut() {
  const std::shared_ptr<CutWatch> watch = viewer_->cut_watch();
  if (!watch) return;
  if (std::optional<PlanesReport> report = watch->Fetch()) cut_ = std::move(report);
  for (const FreedPiece& piece : watch->TakeFreed()) {
    viewer_->Say(fmt::format(fmt::runtime(Tr("A piece of {} mm³ came free")), ShowNumber(piece.volume_mm3, 0)));
    viewer_->trace().Write("came_free", {{"mm3", piece.volume_mm3}});
  }
}

void Rehearsal::ShowPlanMenu() {
  // The same entries as in the menu, with numbers.
  std::vector<MenuItem> items;
  for (const char* id : {"plan.three_points", "plan.at_blade", "plan.stop", "plan.align", "plan.next", "plan.remove",
                         "plan.mirror", "mark.nerve", "mark.tooth"}) {
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
       .menu = Msg("File"),
       .label = Msg("Open a bone, a scene or a CT"),
       .shortcut = {.key = Key::kO, .control = true},
       .tip = Msg("A scene, a .vdb bone, a surface, a CT file or a folder with a DICOM series; or drop it here"),
       .run = [this] { AskOpen(); },
       .button = Msg("Open")});
  recent_ = viewer_->settings().recent;
  for (std::size_t i = 0; i < recent_.size(); ++i) {
    actions.Add({.id = fmt::format("file.recent.{}", i + 1),
                 .menu = Msg("File"),
                 .label = recent_[i].c_str(),
                 .run = [this, i] { Open(recent_[i]); },
                 .begins_group = i == 0});
  }
  actions.Add({.id = "file.save",
               .menu = Msg("File"),
               .label = Msg("Save the project"),
               .shortcut = {.key = Key::kS, .control = true},
               .tip = Msg("One file with bone, plan, marks, recordings, pieces and views"),
               .run = [this] { SaveProject(); },
               .enabled = [this, running] { return running() && !saving_.valid(); },
               .button = Msg("Save")});
  actions.Add({.id = "file.export",
               .menu = Msg("File"),
               .label = Msg("Export pieces, planes and report"),
               .shortcut = {Key::kF9},
               .tip = Msg("Writes the pieces as surfaces, the planned and achieved planes, and a report"),
               .run = [this] { Export(); },
               .enabled = [this, running] { return running() && !exporting_.valid(); },
               .button = Msg("Export")});
  // ---- edit
  actions.Add({.id = "edit.undo",
               .menu = Msg("Edit"),
               .label = Msg("Undo"),
               .shortcut = {.key = Key::kZ, .control = true},
               .run = [this] { Undo(); },
               .enabled = either,
               .button = Msg("Undo")});
  actions.Add({.id = "edit.redo",
               .menu = Msg("Edit"),
               .label = Msg("Redo"),
               .shortcut = {.key = Key::kY, .control = true},
               .run = [this] { in_pieces_ ? pieces_->Redo() : GoForward(); },
               .enabled = either,
               .button = Msg("Redo")});
  actions.Add({.id = "edit.redo_too",
               .menu = "",
               .shortcut = {.key = Key::kZ, .control = true, .shift = true},
               .run = [this] { in_pieces_ ? pieces_->Redo() : GoForward(); },
               .enabled = either});
  actions.Add({.id = "edit.checkpoint",
               .menu = Msg("Edit"),
               .label = Msg("Make a checkpoint with a name"),
               .shortcut = {Key::kC},
               .run = [this] { in_pieces_ ? pieces_->AskCheckpoint() : RequestCheckpoint(); },
               .enabled = either,
               .button = Msg("Checkpoint")});
  actions.Add({.id = "edit.back",
               .menu = Msg("Edit"),
               .label = Msg("Return to a checkpoint"),
               .shortcut = {Key::kB},
               .run = [this] { in_pieces_ ? pieces_->ShowCheckpoints() : ShowCheckpoints(); },
               .enabled = either});
  // ---- saws
  for (std::size_t i = 0; i < options_.saws.size(); ++i) {
    Action saw{.id = fmt::format("saw.{}", i + 1),
               .menu = Msg("Saw"),
               .label = options_.saws[i].name.c_str(),
               .run = [this, i] { SelectSaw(i); },
               .enabled = cutting,
               .on = [this, i] { return saw_is_listed_ && saw_ == i; },
               .begins_group = i == 0};
    if (i < 9) saw.shortcut.key = static_cast<Key>('1' + i);
    actions.Add(std::move(saw));
  }
  actions.Add({.id = "saw.next",
               .menu = Msg("Saw"),
               .label = Msg("Next saw"),
               .shortcut = {Key::kTab},
               .run = [this] { SelectSaw(saw_is_listed_ ? (saw_ + 1) % options_.saws.size() : 0); },
               .enabled = cutting});
  // ---- plan
  actions.Add({.id = "plan.show",
               .menu = Msg("Plan"),
               .label = Msg("Plan: planes and depth stops"),
               .shortcut = {Key::kN},
               .run = [this] { ShowPlanMenu(); },
               .enabled = cutting,
               .button = Msg("Plan")});
  actions.Add({.id = "plan.guide",
               .menu = Msg("Plan"),
               .label = Msg("Guide the saw along the plan"),
               .shortcut = {Key::kG},
               .tip = Msg("Holds the saw in the planned plane and above the depth stop"),
               .run = [this] { ToggleGuide(); },
               .enabled = cutting,
               .on = [this] { return guided_; },
               .indicator = Msg("Guide")});
  editor_->actions.Add(actions, [cutting, this] { return cutting() || (viewer_->is_running() && menu_.has_value()); });
  // ---- pieces
  actions.Add({.id = "pieces.enter",
               .menu = Msg("Pieces"),
               .label = Msg("Work with the pieces, or return to cutting"),
               .shortcut = {Key::kP},
               .tip = Msg("Splits the bone where it is cut through; pieces can be moved, hidden and measured"),
               .run = [this] { in_pieces_ ? LeavePieces() : EnterPieces(); },
               .enabled = [this, cutting] { return cutting() || in_pieces_; },
               .on = [this] { return in_pieces_; },
               .button = Msg("Pieces")});
  pieces_->AddActions(actions);
}

void Rehearsal::AskOpen() {
  viewer_->controls().Release();
  viewer_->dialogs().ChooseFile(viewer_->ui(),
                                Tr("Open a bone, a scene, a surface, a CT, or a folder with a DICOM series"), ".", {},
                                false, "", [this](const std::string& path) { Open(path); });
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
  order.plan = editor_->document.plan();
  order.marks = editor_->document.marks();
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
    // The export contains planes and pieces, but no marks.
    if (editor_->document.marks().empty()) editor_->document.set_saved();
    pieces_->set_saved();
    viewer_->dialogs().Ask(fmt::format(fmt::runtime(Tr("Pieces, planes and the report are in {}")), result_.take_away),
                           {{Tr("Open the folder"), [this] { OpenInDesktop(result_.take_away); }},
                            {Tr("Open the report"), [this] { OpenInDesktop(result_.take_away + "/report.html"); }},
                            {Tr("Close"), nullptr}});
    viewer_->trace().Write("taken_away", {{"folder", result_.take_away}});
  } catch (const std::exception& e) {  // the session has ended in the meantime and returns no bone
    viewer_->Say(fmt::format(fmt::runtime(Tr("Nothing was exported: {}")), e.what()));
    viewer_->trace().Write("taken_away", {{"failure", e.what()}});
  }
}

void Rehearsal::OpenInDesktop(const std::string& path) {
  if (!OpenWithDesktop(path)) viewer_->Say(fmt::format(fmt::runtime(Tr("No program was found that opens {}")), path));
}

void Rehearsal::FollowSaving() {
  try {
    const std::string file = saving_.get();
    viewer_->Say(fmt::format(fmt::runtime(Tr("Project: {}")), file));
    viewer_->trace().Write("project", {{"file", file}});
    editor_->document.set_saved();
    pieces_->set_saved();
    if (quits_after_saving_) viewer_->Quit();
  } catch (const std::exception& e) {
    viewer_->Say(fmt::format(fmt::runtime(Tr("The project was not saved: {}")), e.what()));
    viewer_->trace().Write("project", {{"failure", e.what()}});
    quits_after_saving_ = false;
  }
}

void Rehearsal::SaveProject() {
  if (!viewer_->is_running() || saving_.valid() || change_) return;
  viewer_->SetSpindle(false);
  auto project = std::make_shared<Project>();
  project->title = scene_.TitleOrName();
  project->scene = viewer_->session()->scene();
  project->scene.plan = editor_->document.plan();
  project->marks = editor_->document.marks();
  const ViewCamera& camera = viewer_->view().camera();
  project->views = {{.name = "window",
                     .target_W_mm = camera.target_W(),
                     .toward_eye_W = -camera.forward_W(),
                     .up_W = camera.up_W(),
                     .height_mm = camera.height_mm(),
                     .parallel = camera.parallel()}};
  if (pieces_->is_up_to_date()) project->pieces_json = pieces_->pieces()->FormatJson();
  const std::vector<std::string> recordings{result_.recordings.begin() + static_cast<std::ptrdiff_t>(first_recording_),
                                            result_.recordings.end()};
  std::shared_future<Bone> now = viewer_->session()->AskBone().share();
  viewer_->Say(Tr("Saving the project"));
  saving_ =
      std::async(std::launch::async, [project, now, recordings, before = before_, folder = options_.viewer.folder] {
        // The recording of the running session grows; its part until now replays like a whole one.
        const TemporaryFolder copies("kerf_project");
        for (const std::string& recording : recordings) {
          if (!fs::exists(recording)) continue;
          const std::string copy = copies.path() + "/" + fs::path(recording).filename().string();
          fs::copy_file(recording, copy);
          project->recordings.push_back(copy);
        }
        project->bone_file = folder + "/bone-before.vdb";
        project->cut_bone_file = folder + "/bone-now.vdb";
        WriteBone(*before, project->bone_file);
        WriteBone(now.get(), project->cut_bone_file);
        std::string file = folder + "/case" + kProjectExtension;
        WriteProject(file, *project);
        return file;
      });
}

// ---- events

void Rehearsal::SetMenu(Menu menu) {
  viewer_->controls().Release();
  menu_ = std::move(menu);
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
  const bool escape = event.kind == Kind::kKeyDown && event.key == Key::kEscape && !event.control;
  if (escape && is_loading()) return Cancel(), true;
  if (!in_pieces_) return viewer_->is_running() && editor_->gestures.Take(event);
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
  if (in_pieces_) {
    pieces_->Update();
    editor_->gestures.Hide();
    HidePlanOnBone(*viewer_);
  } else if (viewer_->is_running()) {
    ShowPlan(*viewer_, editor_->document, cut_ ? &*cut_ : nullptr);
    editor_->gestures.Show();
  }
}

void Rehearsal::Fill(HudState& hud) {
  hud.status.mode = in_pieces_ ? Tr("Pieces") : Tr("Rehearse");
  if (saw_is_listed_) hud.status.saw = options_.saws[saw_].name;
  if (viewer_->is_running()) {
    const Tool tool = MakeTool(viewer_->session()->scene());
    const Pose& X_WT = viewer_->figures().coupled.X_WT;
    const NearestStructure nerve =
        FindNearestStructure(nerve_.get(), Tr("nerve"), editor_->document.mark_tubes(), tool, X_WT);
    hud.values.nerve_mm = nerve.distance_mm;
    hud.values.nerve_is_marked = nerve.distance_mm.has_value() || !nerve_;
    if (sampler_) hud.values.depth_mm = CalcBladeDepth(*sampler_, tool, X_WT);
    if (const PlannedPlane* planned = editor_->document.plane()) {
      const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
      hud.values.plan_offset_mm = off.offset_mm;
      hud.values.plan_angle_deg = off.angle_deg;
    }
    if (!editor_->document.plan().stops.empty()) {
      const DepthStop& planned = editor_->document.plan().stops.front();
      const StopDeviation stop = CalcDeviation(planned, tool, X_WT);
      HudGauge gauge;
      gauge.title = planned.name;
      gauge.upper = std::max(1.0, 1.5 * planned.depth_mm);
      gauge.value = stop.depth_mm;
      gauge.goal = planned.depth_mm;
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
    hud.progress = HudProgress{.title = Tr("Opening"),
                               .stage = Tr(now.stage.c_str()),
                               .fraction = now.fraction,
                               .left_s = now.seconds_left,
                               .can_cancel = true};
  } else if (change_) {
    hud.progress.reset();  // it takes less than a second
  } else if (exporting_.valid()) {
    hud.progress = HudProgress{.title = Tr("Exporting"), .stage = Tr("pieces, planes, pictures and report")};
  } else if (saving_.valid()) {
    hud.progress = HudProgress{.title = Tr("Saving the project"), .stage = Tr("bones, plan, marks and recordings")};
  } else if (hud.progress && is_loading()) {
    hud.progress->can_cancel = true;
  }
  editor_->gestures.Fill(hud);
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
    nerve_mm = FindNearestStructure(nerve_.get(), "", editor_->document.mark_tubes(), tool, X_WT).distance_mm;
    if (!editor_->document.plan().stops.empty()) {
      depth_mm = CalcDeviation(editor_->document.plan().stops.front(), tool, X_WT).left_mm;
    }
    if (const PlannedPlane* planned = editor_->document.plane()) {
      margin_mm = planned->margin_mm - std::abs(CalcDeviation(*planned, tool, X_WT).offset_mm);
    }
  }
  viewer_->sound().SetAlarm(AlarmKind::kDepth, depth_mm);
  viewer_->sound().SetAlarm(AlarmKind::kStructure, nerve_mm);
  viewer_->sound().SetAlarm(AlarmKind::kMargin, margin_mm);
}

void Rehearsal::DrawSections(Ui& ui) {
  if (!in_pieces_) editor_->panel.Draw(ui, cut_ ? &*cut_ : nullptr);
}

void Rehearsal::DrawWindows(Ui& ui) {
  if (loading_) DrawCt(ui);
  if (!in_pieces_) editor_->actions.DrawContextMenu(ui);
}

/// Draws slices of the CT while its bone is made.
void Rehearsal::DrawCt(Ui& ui) {
  std::shared_ptr<const Volume> volume;
  {
    const std::lock_guard lock(loading_->mutex);
    volume = loading_->ct;
  }
  const UiBox& area = viewer_->areas().right;
  if (!volume || !BeginPanel(ui, "ct", area, true)) return;
  const Box3 box = CalcScanBox(*volume);
  constexpr std::array kAxes{CtAxis::kZ, CtAxis::kY, CtAxis::kX};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    const int axis = kAxes[i] == CtAxis::kX ? 0 : kAxes[i] == CtAxis::kY ? 1 : 2;
    double& at_mm = ct_at_mm_[i];
    if (volume != drawn_ct_) at_mm = box.centre()[axis];
    const double shown_mm = DrawCtView(ui, i, ct_views_[i], box.lower[axis], box.upper[axis], at_mm);
    if (volume != drawn_ct_ || shown_mm != at_mm) {
      at_mm = shown_mm;
      const CtView view = SliceVolume(*volume, kAxes[i], at_mm, {});
      ct_views_[i] = {Image{view.columns, view.rows, view.pixels}, ct_views_[i].second + 1};
    }
  }
  drawn_ct_ = volume;
  EndPanel();
}

void Rehearsal::OpenContextMenu(const ScreenPoint& at) {
  if (viewer_->is_running() && !in_pieces_) editor_->actions.OpenContextMenu(at);
}

void Rehearsal::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  const Tool tool = MakeTool(viewer_->session()->scene());
  const Pose& X_WT = viewer_->figures().coupled.X_WT;
  for (const MarkTube& tube : editor_->document.mark_tubes()) {
    const MarkTube::Nearest nearest = tube.Find(tool, X_WT);
    alarms.push_back({.p_W = nearest.p_W,
                      .level = AlarmLevelFor(nearest.distance_mm),
                      .label = fmt::format(fmt::runtime(Tr("{}: {} mm")), tube.name(),
                                           ShowNumber(std::max(0.0, nearest.distance_mm), 1))});
  }
  // A saw that cuts beside the selected plane.
  const PlannedPlane* planned = editor_->document.plane();
  if (planned == nullptr || !viewer_->spindle_on() || !viewer_->touches()) return;
  const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
  const double beyond_mm = std::abs(off.offset_mm) - planned->margin_mm;
  if (beyond_mm <= 0 || beyond_mm > kOtherCut_mm) return;
  alarms.push_back(
      {.p_W = off.p_W_mm,
       .level = beyond_mm > planned->margin_mm ? AlarmLevel::kDanger : AlarmLevel::kWarning,
       .label = fmt::format(fmt::runtime(Tr("{} mm beside the plan")), ShowNumber(std::abs(off.offset_mm), 1))});
}

bool Rehearsal::TakeSlicePoint(const Vec3& p_W) {
  return viewer_->is_running() && !in_pieces_ && editor_->gestures.TakePoint(p_W);
}

void Rehearsal::FillSlices(SliceScene& scene) const {
  for (const MarkTube& tube : editor_->document.mark_tubes()) {
    scene.marks.push_back({.points_W = tube.curve_W(), .radius_mm = tube.radius_mm(), .label = tube.name()});
  }
  scene.planes = viewer_->lined_planes();
}

bool Rehearsal::takes_escape() const {
  return menu_ || editor_->gestures.is_placing() || in_pieces_ || is_loading();
}

std::string Rehearsal::DescribeUnsaved() const {
  if (!viewer_->is_running()) return {};
  return editor_->document.is_unsaved() || pieces_->is_unsaved()
             ? Tr("The plan, the marks or the pieces have changed since they were last saved. Save the project before "
                  "you quit?")
             : "";
}

void Rehearsal::Save() {
  quits_after_saving_ = true;
  SaveProject();
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
  state["mode"] = menu_ ? "menu" : editor_->gestures.is_placing() ? "picking" : in_pieces_ ? "pieces" : "cutting";
  if (menu_) state["menu"] = menu_->title();
  editor_->document.Describe(state);
  editor_->gestures.Describe(state);
  state["guided"] = guided_;
  state["plane_cut"] = nlohmann::json::array();
  if (cut_) {
    for (const PlanesReport::Row& row : cut_->planes) state["plane_cut"].push_back(row.state.fraction());
  }
  state["saw"] = saw_is_listed_ ? options_.saws[saw_].name : "";
  if (in_pieces_) pieces_->Describe(state);
}

}  // namespace kerf
