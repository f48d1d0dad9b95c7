#include "app/window/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/plan_picture.h"
#include "kerf/error.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::chrono::milliseconds kEnd{300};  // time that other threads get to end when the window is closed

std::unique_ptr<ViewerApp> MakeViewer(ViewerOptions options) {
  options.watch = true;
  return std::make_unique<ViewerApp>(options);
}

/// Returns the guide along the plan; the end of the scene's effects if it has none.
std::vector<EffectChoice>::const_iterator FindGuide(const Scene& scene) {
  return std::find_if(scene.effects.begin(), scene.effects.end(),
                      [](const EffectChoice& e) { return std::string_view(e.name()) == "guide"; });
}

/// Returns the name of a file or folder.
std::string ShowFileName(const std::string& path) {
  const std::filesystem::path normal = std::filesystem::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).filename().string();
}

std::vector<PlannedPlane> ReadPlans(const std::vector<std::string>& files) {
  std::vector<PlannedPlane> planes;
  for (const std::string& file : files) {
    for (PlannedPlane& plane : ReadPlannedPlanes(file)) planes.push_back(std::move(plane));
  }
  return planes;
}

}  // namespace

Rehearsal::Rehearsal(const RehearsalOptions& options)
    : options_(options), given_planes_(ReadPlans(options.plans)), viewer_(MakeViewer(options.viewer)) {}

RehearsalResult Rehearsal::Run() {
  BeginOpening(options_.input);
  viewer_->Run(*this);
  EndWork();
  return result_;
}

/// Ends what other threads still do: a file that is being written is completed, and loading is cancelled.
void Rehearsal::EndWork() {
  if (loader_.is_opening()) Cancel();
  writer_.FinishExport();
  result_.take_away = writer_.take_away();
  for (std::string& sentence : saver_.Finish()) result_.warnings.push_back(std::move(sentence));
  const auto until = std::chrono::steady_clock::now() + kEnd;
  result_.left_work = viewer_->left_work() || !distances_.WaitUntil(until) || !loader_.WaitUntil(until) ||
                      !editor_.marks.WaitUntil(until);
}

bool Rehearsal::cuts() const {
  return !in_pieces_ && !editor_.gestures.is_placing() && !menu_;
}

// ---- opening

void Rehearsal::BeginOpening(const std::string& input) {
  const int session = viewer_->sessions() + 1;
  const std::string& folder = options_.viewer.folder;
  loader_.Begin(
      input,
      {.bone_file = fmt::format("{}/bone{}.vdb", folder, session == 1 ? "" : fmt::format("-{}", session)),
       .voxel_mm = options_.voxel_mm,
       .project_folder = fmt::format("{}/project{}", folder, inputs_ == 0 ? "" : fmt::format("-{}", inputs_ + 1))});
}

void Rehearsal::Open(const std::string& path) {
  if (IsCurvesPath(path)) {
    if (viewer_->is_running() && !change_.is_pending()) return editor_.marks.Read(path);
    return viewer_->dialogs().Ask(Tr("Curves of 3D Slicer become marks on a bone. Open the bone first."),
                                  {{Tr("OK"), nullptr}});
  }
  try {
    CheckInput(path);  // a wrong file must not end the session
  } catch (const Error& e) {
    return viewer_->dialogs().Ask(e.what(), {{Tr("OK"), nullptr}});
  }
  if (is_loading()) Cancel();
  to_open_ = path;
  change_.Drop();
  if (viewer_->session() != nullptr) {
    viewer_->SetSpindle(false);
    viewer_->End();
  }
}

void Rehearsal::Cancel() {
  if (loader_.is_opening()) {
    loader_.Cancel();
    Reset();
  } else if (is_loading()) {
    viewer_->End();  // Cancelled() follows
  }
}

bool Rehearsal::is_loading() const {
  const LiveSession* session = viewer_->session();
  return loader_.is_opening() || (session != nullptr && session->stage() == LiveStage::kLoading && is_new_bone_);
}

/// Empties the window and forgets everything that belongs to the bone.
void Rehearsal::Reset() {
  if (in_pieces_) LeavePieces();
  pieces_.Reset();
  menu_.reset();
  change_.Drop();
  to_save_.reset();
  checkpoints_.clear();
  editor_.document.Load({}, {});
  editor_.gestures.Reset();
  editor_.marks.Reset();
  cut_.reset();
  guided_ = false;
  saw_is_listed_ = false;
  saw_ = 0;
  saw_name_.clear();
  before_.reset();
  original_.reset();
  earlier_recordings_.clear();
  sessions_.clear();
  distances_.Reset();
  viewer_->Clear();
}

void Rehearsal::FollowOpening() {
  if (to_open_ && viewer_->session() == nullptr && !change_.is_making() && !viewer_->quitting()) {
    const std::string input = *std::exchange(to_open_, std::nullopt);
    Reset();
    is_command_line_ = false;
    BeginOpening(input);
  }
  std::optional<OpenedInput> opened;
  try {
    opened = loader_.Take();
  } catch (const Error& e) {
    if (is_command_line_) throw;
    Reset();
    viewer_->Say(e.what());
    return;
  }
  if (!opened || viewer_->quitting()) return;
  if (!loader_.input().empty()) {
    AddRecent(viewer_->settings(), loader_.input());
    viewer_->KeepSettings();
  }
  scene_ = std::move(opened->scene);
  scene_file_ = opened->scene_file;
  original_ = opened->original;
  viewer_->set_original(original_);
  guided_ = FindGuide(scene_) != scene_.effects.end();
  project_file_ = opened->project ? std::filesystem::absolute(loader_.input()).string() : "";
  views_ = opened->project ? opened->project->views : std::vector<ProjectView>();
  pieces_json_ = opened->project ? opened->project->pieces_json : "";
  earlier_recordings_ = opened->project ? opened->project->recordings : std::vector<std::string>();
  sessions_ = opened->project ? ListSessions(*opened->project) : std::vector<ProjectSession>();
  if (opened->project) TakeSettings(opened->project->settings);
  editor_.document.Load(scene_.plan, opened->project ? opened->project->marks : std::vector<Mark>());
  if (!given_planes_.empty()) editor_.document.Add(std::exchange(given_planes_, {}));
  editor_.document.set_unsaved(false);
  if (opened->bone && !opened->bone_is_saved) to_save_ = ToSave{opened->bone, scene_.bone.file};
  shows_import_ = !opened->warnings.empty();
  is_new_bone_ = true;
  ++inputs_;
  first_recording_ = result_.recordings.size();
  Restart(std::move(opened->bone), opened->bone_was_shown);
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
  session_saw_ =
      saw_name_.empty() ? DescribeTool(scene_.tool) : fmt::format("{}: {}", saw_name_, DescribeTool(scene_.tool));
  result_.recordings.push_back("");
  viewer_->Begin(scene_, scene_file_, same_bone, std::move(bone));
  result_.recordings.back() = viewer_->recording();
}

void Rehearsal::Began() {
  const bool first = std::exchange(is_new_bone_, false);
  before_ = original_ ? original_ : viewer_->bone_at_start();
  checkpoints_ = {"start"};
  if (to_save_) saver_.Save(std::move(to_save_->bone), to_save_->path);
  to_save_.reset();
  if (first) {
    distances_.SetBone(before_);
    const bool lacks_ct = !project_file_.empty() && IsFromCt(*before_) && !before_->has_hu();
    viewer_->Say(lacks_ct ? Tr("This project does not contain the CT, so the slices show the bone's tissues.")
                          : Tr("Space starts the saw; drag with the left button to move it; F1 for help"));
  } else if (change_.is_pending()) {
    viewer_->Say(change_.Finish());
  }
  if (const auto watch = viewer_->cut_watch()) watch->SetPlanes(editor_.document.plan().planes);
  if (first && std::exchange(shows_import_, false)) ShowImportNotes();
  if (first && !views_.empty()) {
    const ProjectView& view = views_.front();
    ViewCamera& camera = viewer_->view().camera();
    camera.Look(view.toward_eye_W, view.up_W);
    camera.set_target_W(view.target_W_mm);
    camera.set_height_mm(view.height_mm);
    viewer_->KeepView();
  }
  if (first && !pieces_json_.empty()) pieces_.set_earlier(std::exchange(pieces_json_, {}));
  const Box3 bounds_W = before_->CalcBounds();
  editor_.actions.set_middle_mm(bounds_W.centre().x);
  editor_.marks.set_bone_W(bounds_W);
}

void Rehearsal::ContinueWith(const std::string& what, std::function<void(Scene&)> change) {
  if (!viewer_->is_running() || change_.is_pending()) return;
  change_.Request(what, std::move(change));
  viewer_->SetSpindle(false);
  viewer_->End();
}

void Rehearsal::Ended(LoopSummary summary) {
  sessions_.push_back(MakeSession());
  if (summary.recorded && !summary.recorded->failure.empty()) {
    result_.warnings.push_back(summary.recorded->failure);
    viewer_->dialogs().Ask(
        fmt::format(fmt::runtime(Tr("The session has ended, because its recording could not be written: {}")),
                    summary.recorded->failure),
        {{Tr("OK"), nullptr}});
  }
  if (!change_.is_pending() || viewer_->quitting()) return;
  // The next session begins with the bone in memory. It is saved while that session runs, because the recording refers
  // to its file.
  change_.Make(scene_, std::move(summary.after), viewer_->figures().coupled.X_WT, options_.viewer.folder,
               viewer_->sessions() + 1);
}

void Rehearsal::FollowChange() {
  for (const std::string& sentence : saver_.TakeFailures()) {
    viewer_->Say(
        fmt::format(fmt::runtime(Tr("The bone could not be saved; it is tried again at the end. {}")), sentence));
  }
  std::optional<ChangedScene> changed = change_.Take();
  if (!changed || viewer_->quitting() || to_open_) return;
  scene_ = std::move(changed->scene);
  to_save_ = ToSave{changed->bone, scene_.bone.file};
  Restart(std::move(changed->bone), true);
}

void Rehearsal::SelectSaw(std::size_t number) {
  if (number >= options_.saws.size() || (saw_is_listed_ && number == saw_)) return;
  if (!viewer_->is_running() || change_.is_pending()) return;
  const Saw& saw = options_.saws[number];
  ContinueWith(fmt::format(fmt::runtime(Tr("Saw: {}")), Tr(saw.name.c_str())),
               [saw](Scene& scene) { UseSaw(scene, saw); });
  saw_ = number;
  saw_is_listed_ = true;
  saw_name_ = saw.name;
}

void Rehearsal::ToggleGuide() {
  if (!viewer_->is_running() || change_.is_pending()) return;
  const PlannedPlane* planned = editor_.document.plane();
  const std::vector<DepthStop>& stops = editor_.document.plan().stops;
  const DepthStop* stop = stops.empty() ? nullptr : &stops.front();
  if (!guided_ && planned == nullptr && stop == nullptr) {
    viewer_->Say(Tr("There is no plan to guide the saw yet; press N"));
    return;
  }
  try {
    const std::optional<EffectChoice> guide = guided_ ? std::nullopt : std::optional(MakeGuide(planned, stop));
    guided_ = !guided_;
    ContinueWith(guided_ ? Tr("The guide keeps the saw in the planned plane") : Tr("The guide is off"),
                 [guide](Scene& scene) {
                   if (const auto old = FindGuide(scene); old != scene.effects.end()) scene.effects.erase(old);
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
  if (in_pieces_) return pieces_.Undo();
  // The latest change is undone, whether of the plan or of the bone.
  if (editor_.document.is_latest_change()) return viewer_->actions().Find("plan.undo")->run();
  GoBack("");
}

// ---- the plan

void Rehearsal::FollowCut() {
  const std::shared_ptr<CutWatch> watch = viewer_->cut_watch();
  if (!watch) return;
  if (std::optional<PlanesReport> report = watch->Fetch()) cut_ = std::move(report);
  for (const FreedPiece& piece : watch->TakeFreed()) {
    viewer_->Say(fmt::format(fmt::runtime(Tr("A piece of {} came free.")), ShowVolume(piece.volume_mm3)));
    viewer_->trace().Write("came_free", {{"mm3", piece.volume_mm3}});
  }
}

// ---- pieces

void Rehearsal::EnterPieces() {
  if (!viewer_->is_running() || change_.is_pending()) return;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  pieces_.Enter();
  in_pieces_ = true;
}

void Rehearsal::LeavePieces() {
  pieces_.Leave();
  in_pieces_ = false;
}

// ---- events

void Rehearsal::PickPieceRow(int row) {
  if (in_pieces_ && pieces_.is_ready()) pieces_.PickPieceRow(row);
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
  if (!in_pieces_) return viewer_->is_running() && editor_.gestures.Take(event);
  if (pieces_.Take(event)) return true;
  if (escape) return LeavePieces(), true;
  return false;
}

// ---- frames

void Rehearsal::Update(double /*dt_s*/) {
  FollowChange();
  FollowOpening();
  distances_.Update();
  writer_.Update();
  if (viewer_->is_running() && !viewer_->dialogs().is_open()) editor_.marks.Update();
  FollowCut();
  if (in_pieces_) {
    pieces_.Update();
    editor_.gestures.Hide();
    HidePlanOnBone(*viewer_);
  } else if (viewer_->is_running()) {
    ShowPlan(*viewer_, editor_.document, cut_ ? &*cut_ : nullptr);
    editor_.gestures.Show();
  }
}

void Rehearsal::Fill(HudState& hud) {
  hud.status.mode = in_pieces_ ? Tr("Pieces") : Tr("Rehearse");
  if (!saw_name_.empty()) hud.status.saw = Tr(saw_name_.c_str());
  distances_.Fill(hud);
  distances_.SoundAlarms();
  if (to_open_) {
    // The file is opened when the work in progress has ended, which can take seconds.
    hud.progress = HudProgress{.title = fmt::format(fmt::runtime(Tr("Opening {}")), ShowFileName(*to_open_)),
                               .stage = Tr("ending what is in progress"),
                               .fraction = {}};
  } else if (loader_.is_opening()) {
    const WorkProgress now = loader_.progress();
    const std::string name = ShowFileName(loader_.input());
    hud.progress =
        HudProgress{.title = name.empty() ? Tr("Opening") : fmt::format(fmt::runtime(Tr("Opening {}")), name),
                    .stage = Tr(now.stage.c_str()),
                    .fraction = now.fraction,
                    .left_s = now.seconds_left,
                    .can_cancel = true};
  } else if (change_.is_pending()) {
    hud.progress.reset();  // it takes less than a second
  } else if (writer_.is_exporting()) {
    hud.progress = HudProgress{.title = Tr("Exporting"),
                               .stage = Tr("pieces, planes, pictures and report"),
                               .fraction = writer_.export_progress()};
  } else if (writer_.is_saving()) {
    hud.progress = HudProgress{.title = Tr("Saving the project"), .stage = Tr("bones, plan, marks and recordings")};
  } else if (editor_.marks.is_reading()) {
    hud.progress = HudProgress{.title = Tr("Importing marks"), .stage = Tr("reading the label map")};
  } else if (hud.progress && is_loading()) {
    hud.progress->can_cancel = true;
  }
  editor_.gestures.Fill(hud);
  if (menu_) hud.menu = menu_->Show();
  if (in_pieces_) pieces_.Fill(hud);
}

void Rehearsal::DrawSections(Ui& ui) {
  if (!in_pieces_) editor_.panel.Draw(ui, cut_ ? &*cut_ : nullptr);
}

void Rehearsal::DrawWindows(Ui& ui) {
  if (loader_.is_opening()) preview_.Draw(ui, viewer_->areas().right, loader_.ct());
  if (in_pieces_) return;
  editor_.gestures.DrawHint(ui);
  editor_.actions.DrawContextMenu(ui);
}

void Rehearsal::OpenContextMenu(const ScreenPoint& at) {
  if (viewer_->is_running() && !in_pieces_) editor_.actions.OpenContextMenu(at);
}

void Rehearsal::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  distances_.AddAlarms(alarms);
}

bool Rehearsal::TakeSlicePoint(const Vec3& p_W) {
  return viewer_->is_running() && !in_pieces_ && editor_.gestures.TakePoint(p_W);
}

void Rehearsal::FillSlices(SliceScene& scene) const {
  for (const MarkTube& tube : editor_.document.mark_tubes()) {
    scene.marks.push_back({.points_W = tube.curve_W(), .radius_mm = tube.radius_mm(), .label = tube.name()});
  }
  scene.planes = viewer_->lined_planes();
}

bool Rehearsal::takes_escape() const {
  return menu_ || editor_.gestures.is_placing() || in_pieces_ || is_loading();
}

std::string Rehearsal::DescribeUnsaved() const {
  if (!viewer_->is_running()) return {};
  return editor_.document.is_unsaved() || pieces_.is_unsaved()
             ? Tr("The plan, the marks or the pieces have changed since they were last saved. Save the project before "
                  "you quit?")
             : "";
}

void Rehearsal::Save() {
  SaveProject(true);
}

void Rehearsal::Describe(nlohmann::json& state) const {
  state["mode"] = menu_ ? "menu" : editor_.gestures.is_placing() ? "picking" : in_pieces_ ? "pieces" : "cutting";
  if (menu_) state["menu"] = menu_->title();
  editor_.document.Describe(state);
  editor_.gestures.Describe(state);
  state["guided"] = guided_;
  state["plane_cut"] = nlohmann::json::array();
  if (cut_) {
    for (const PlanesReport::Row& row : cut_->planes) state["plane_cut"].push_back(row.state.fraction());
  }
  state["saw"] = saw_name_;
  if (in_pieces_) pieces_.Describe(state);
}

}  // namespace kerf
