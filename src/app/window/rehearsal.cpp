#include "app/window/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/injury_texts.h"
#include "app/window/open_input.h"
#include "app/window/plan_picture.h"
#include "bone/material/region_table.h"
#include "kerf/error.h"
#include "session/link/slicer_link.h"
#include "session/project/project.h"
#include "session/run/bone_cache.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

std::unique_ptr<ViewerApp> MakeViewer(const RehearsalOptions& options) {
  // The bone that is seen first is made while the window is opened, which takes one processor.
  if (options.input.empty()) {
    BeginCachedMandible(MakeCoarse(MakeDefaultScene()).bone.mandible, DefaultMandibleTable());
  }
  ViewerOptions viewer = options.viewer;
  viewer.watch = true;
  return std::make_unique<ViewerApp>(viewer);
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
    : options_(options), given_planes_(ReadPlans(options.plans)), viewer_(MakeViewer(options)) {}

RehearsalResult Rehearsal::Run() {
  BeginOpening(options_.input);
  const std::shared_ptr<SlicerLink>& link = options_.viewer.link;
  if (link) link->bone().Open();
  viewer_->Run(*this);
  if (link) link->bone().Close();
  EndWork();
  return result_;
}

bool Rehearsal::cuts() const {
  return !in_pieces_ && !editor_.gestures.is_placing() && !menu_ && !asks_about_ct();
}

// ---- sessions

void Rehearsal::Restart(std::shared_ptr<const Bone> bone, bool same_bone) {
  session_saw_ = choice_.saw_name.empty() ? DescribeTool(scene_.tool.shape)
                                          : fmt::format("{}: {}", choice_.saw_name, DescribeTool(scene_.tool.shape));
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
    plan_link_.Begin(before_->CalcBounds());
    if (!project_file_.empty() && IsFromCt(*before_)) ReadCtAgain();
    if (!begins_in_pieces_) viewer_->Say(Tr("Space starts the saw; drag with the left button to move it; F1 for help"));
  } else if (change_.is_pending()) {
    const std::string done = change_.Finish();
    warns_after_change_ ? viewer_->Warn(done) : viewer_->Say(done);
  }
  if (const auto watch = viewer_->cut_watch()) {
    watch->SetPlanes(editor_.document.plan().planes);
    watch->SetMarks(editor_.document.marks());
  }
  if (first) {
    const PlannedPlane* planned = editor_.document.plane();
    selected_plane_ = planned != nullptr ? planned->name : "";
    guides_other_plane_ = guide_waits_ = said_guide_waits_ = false;
  }
  if (first && !views_.empty()) {
    const ProjectView& view = views_.front();
    ViewCamera& camera = viewer_->view().camera();
    camera.Look(view.toward_eye_W, view.up_W);
    camera.set_target_W(view.target_W_mm);
    camera.set_height_mm(view.height_mm);
    viewer_->KeepView();
  }
  if (first && !pieces_json_.empty()) {
    pieces_.set_earlier(std::exchange(pieces_json_, {}), std::exchange(measurements_, {}));
  }
  const Box3 bounds_W = before_->CalcBounds();
  editor_.actions.set_middle_mm(bounds_W.centre().x);
  editor_.marks.set_bone_W(bounds_W);
  if (first && std::exchange(begins_in_pieces_, false)) EnterPieces();
}

void Rehearsal::ContinueWith(const std::string& what, std::function<void(Scene&)> change) {
  if (!viewer_->is_running() || change_.is_pending()) return;
  former_choice_ = choice_;
  warns_after_change_ = false;
  change_.Request(what, std::move(change));
  viewer_->SetSpindle(false);
  viewer_->End();
}

void Rehearsal::Ended(LoopSummary summary) {
  unsaved_cut_.Follow(viewer_->figures().changes);
  sessions_.push_back(MakeSession());
  auto bone = std::make_shared<const Bone>(std::move(summary.after));
  if (summary.recorded && !summary.recorded->failure.empty()) {
    const std::string& why = summary.recorded->failure;
    return KeepWork(
        fmt::format(fmt::runtime(Tr("The session has ended, because its recording could not be written: {}")), why),
        why, scene_, std::move(bone));
  }
  if (!change_.is_pending() || viewer_->quitting()) return;
  // The next session begins with the bone in memory. It is saved while that session runs, because the recording refers
  // to its file.
  before_change_ = bone;
  change_.Make(scene_, std::move(bone), viewer_->figures().coupled.X_WT, options_.viewer.folder,
               viewer_->sessions() + 1);
}

/// Keeps the work of a session that ended by a failure, and asks what to do with it.
void Rehearsal::KeepWork(const std::string& message, const std::string& failure, Scene scene,
                         std::shared_ptr<const Bone> bone) {
  result_.failures.push_back(failure);
  if (viewer_->quitting() || opened_) return;
  if (in_pieces_) LeavePieces();
  menu_.reset();
  change_.Drop();
  to_save_.reset();
  ended_work_ = EndedWork{.scene = std::move(scene), .bone = std::move(bone)};
  viewer_->trace().Write("work_kept", {{"failure", failure}});
  viewer_->dialogs().Ask(
      fmt::format("{}\n\n{}", message,
                  Tr("The bone as it is now, the plan, the marks and the pieces are kept. Save or export them in "
                     "another place.")),
      {{Tr("Save the project as"), [this] { AskProjectFile(false); }},
       {Tr("Export"), [this] { Export(); }},
       {Tr("Return to the bone"), nullptr}});
}

void Rehearsal::FollowChange() {
  for (const std::string& sentence : saver_.TakeFailures()) {
    viewer_->Say(
        fmt::format(fmt::runtime(Tr("The bone could not be saved; it is tried again at the end. {}")), sentence));
  }
  std::optional<ChangedScene> changed;
  try {
    changed = change_.Take();
  } catch (const Error& e) {
    choice_ = former_choice_;
    return KeepWork(fmt::format(fmt::runtime(Tr("The session could not be continued: {}")), e.what()), e.what(), scene_,
                    std::exchange(before_change_, nullptr));
  }
  if (!changed || viewer_->quitting()) return;
  before_change_.reset();
  scene_ = std::move(changed->scene);
  scene_files_[scene_.path.file] = std::move(changed->path_csv);
  to_save_ = ToSave{changed->bone, scene_.bone.file};
  Restart(std::move(changed->bone), true);
}

void Rehearsal::SelectSaw(std::size_t number) {
  if (number >= options_.saws.size() || (choice_.saw_is_listed && number == choice_.saw)) return;
  if (!viewer_->is_running() || change_.is_pending() || RefuseWhileOpening()) return;
  const Saw& saw = options_.saws[number];
  ContinueWith(fmt::format(fmt::runtime(Tr("Saw: {}")), Tr(saw.name.c_str())),
               [saw](Scene& scene) { UseSaw(scene, saw); });
  choice_ = {.saw = number, .saw_is_listed = true, .saw_name = saw.name, .guided = choice_.guided};
}

void Rehearsal::ToggleGuide() {
  if (!viewer_->is_running() || change_.is_pending() || RefuseWhileOpening()) return;
  if (!choice_.guided && editor_.document.plan().empty()) {
    viewer_->Say(Tr("There is no plan to guide the saw yet; press N"));
    return;
  }
  UseGuide(!choice_.guided);
}

/// Switches the guide off, or on along the selected plane and the first depth stop.
void Rehearsal::UseGuide(bool on) {
  guide_waits_ = false;
  const PlannedPlane* planned = editor_.document.plane();
  const std::vector<DepthStop>& stops = editor_.document.plan().stops;
  const DepthStop* stop = stops.empty() ? nullptr : &stops.front();
  try {
    const std::optional<EffectChoice> guide = on ? std::optional(MakeGuide(planned, stop)) : std::nullopt;
    std::string message =
        viewer_->spindle_on() ? Tr("The guide is off, and the spindle is stopped") : Tr("The guide is off");
    bool is_warning = false;
    if (guide && planned == nullptr) {
      message = Tr("The guide keeps the saw above the depth stop");
    } else if (guide) {
      message = fmt::format(fmt::runtime(Tr("The guide pulls the saw into the planned plane, with a play of {} mm")),
                            ShowNumber(std::min(planned->margin_mm, kGuidePlay_mm), 2));
      const PlaneDeviation off =
          CalcDeviation(*planned, MakeTool(viewer_->session()->scene()), viewer_->figures().coupled.X_WT);
      is_warning = std::abs(off.offset_mm) > planned->margin_mm;
      if (is_warning) {
        message = fmt::format(
            fmt::runtime(Tr("The saw is {0} mm beside the planned plane, and the guide pulls it there: take "
                            "it clear of the bone with {1}, then turn it into the plane with {2}")),
            ShowNumber(std::abs(off.offset_mm), 1), ShowShortcut(viewer_->actions().Find("saw.retract")->shortcut),
            ShowShortcut(viewer_->actions().Find("plan.align")->shortcut));
      }
      if (choice_.guided) {
        message = fmt::format(
            "{} {}", fmt::format(fmt::runtime(Tr("The guide now follows {}.")), ShowName(planned->name)), message);
      }
    }
    ContinueWith(message, [guide](Scene& scene) {
      if (const auto old = FindGuide(scene); old != scene.effects.end()) scene.effects.erase(old);
      if (guide) scene.effects.push_back(*guide);
    });
    warns_after_change_ = is_warning;
    choice_.guided = guide.has_value();
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

/// Moves the guide to a plane that the user has selected, in a new session like ToggleGuide(), once the saw is clear of
/// the bone. A plane that was changed is only mentioned: the new session can't undo the cuts of this one.
void Rehearsal::FollowGuide() {
  if (!viewer_->is_running() || change_.is_pending() || is_new_bone_) return;
  const PlannedPlane* planned = editor_.document.plane();
  const std::string selected = planned != nullptr ? planned->name : "";
  const bool chosen = std::exchange(selected_plane_, selected) != selected;
  const auto guide = FindGuide(scene_);
  const bool other =
      choice_.guided && planned != nullptr && guide != scene_.effects.end() && !IsGuideOf(*guide, *planned);
  const bool begins = other && !std::exchange(guides_other_plane_, other);
  guides_other_plane_ = other;
  if (!other) {
    guide_waits_ = said_guide_waits_ = false;
    return;
  }
  if (chosen) guide_waits_ = true;
  if (chosen) said_guide_waits_ = false;
  if (begins && !guide_waits_) {
    viewer_->Warn(
        fmt::format(fmt::runtime(Tr("The guide still holds the saw in another plane. Press G twice to guide it "
                                    "along {}.")),
                    ShowName(planned->name)));
  }
  if (!guide_waits_ || !cuts() || viewer_->dialogs().is_open()) return;
  if (!distances_.IsInBone()) return UseGuide(true);
  if (std::exchange(said_guide_waits_, true)) return;
  viewer_->Say(fmt::format(
      fmt::runtime(Tr("The saw is in the bone, so the guide still holds it in the plane before. Take it clear of the "
                      "bone, and the guide follows {}.")),
      ShowName(planned->name)));
}

std::vector<EffectChoice>::const_iterator Rehearsal::FindGuide(const Scene& scene) {
  return std::find_if(scene.effects.begin(), scene.effects.end(),
                      [](const EffectChoice& e) { return std::string_view(e.name()) == "guide"; });
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
  if (!viewer_->is_running() || RefuseWhileRetracting()) return;
  // A spinning saw would cut the restored bone.
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kUndo, .name = name});
}

/// Undo and redo bring the saw to where it was, and would take back the way that it is being brought. Returns true,
/// with a message, meanwhile.
bool Rehearsal::RefuseWhileRetracting() {
  if (!viewer_->is_retracting()) return false;
  viewer_->Say(Tr("The saw is being brought back; press the key again after that."));
  return true;
}

void Rehearsal::GoForward() {
  if (!viewer_->is_running() || RefuseWhileRetracting()) return;
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kRedo, .name = ""});
}

void Rehearsal::Undo() {
  if (in_pieces_) return pieces_.Undo();
  // A motion of the pieces may be meant.
  if (std::exchange(left_pieces_at_, std::nullopt) == viewer_->figures().changes) {
    return viewer_->Say(
        Tr("You are back at the saw. Ctrl+Z again takes back its last cut or the last change of the plan; P returns to "
           "the pieces and their own undo."));
  }
  // The latest change is undone, whether of the plan or of the bone.
  if (editor_.document.is_latest_change()) return viewer_->actions().Find("plan.undo")->run();
  GoBack("");
}

std::string Rehearsal::ExplainFailure(const LiveSession::Answer& answer) const {
  std::string why = Activity::ExplainFailure(answer);
  if (answer.action.kind != LoopAction::Kind::kUndo || sessions_.empty()) return why;
  return fmt::format(
      "{}. {}", why,
      Tr("Undo goes back to the last change of the saw or the guide, or to the opening of the project."));
}

// ---- the plan

void Rehearsal::FollowCut() {
  const std::shared_ptr<CutWatch> watch = viewer_->cut_watch();
  if (!watch) return;
  if (std::optional<PlanesReport> report = watch->Fetch()) cut_ = std::move(report);
  for (const FreedPiece& piece : watch->TakeFreed()) {
    viewer_->SayAlso(fmt::format(fmt::runtime(Tr("A piece of {} came free.")), ShowVolume(piece.volume_mm3)));
    viewer_->trace().Write("came_free", {{"mm3", piece.volume_mm3}});
  }
}

/// Lets the slices go through a plane that was selected or changed, until the saw is moved or cuts.
void Rehearsal::FollowPlane() {
  const PlannedPlane* plane = editor_.document.plane();
  const std::optional<Vec3> middle_W = plane != nullptr ? std::optional(plane->plane.p_W) : std::nullopt;
  if (std::exchange(plane_in_slices_W_, middle_W) != middle_W) plane_focus_W_ = middle_W;
  if (viewer_->spindle_on() || viewer_->controls().holds()) plane_focus_W_.reset();
}

// ---- pieces

void Rehearsal::EnterPieces() {
  if (!viewer_->is_running() || change_.is_pending()) return;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  ShowPlan(*viewer_, editor_.document, nullptr);  // planes and marks stay visible
  pieces_.Enter();
  in_pieces_ = true;
}

void Rehearsal::LeavePieces() {
  pieces_.Leave();
  in_pieces_ = false;
  left_pieces_at_ = viewer_->figures().changes;
  if (viewer_->is_running()) viewer_->Say(Tr("Back at the saw. P: the pieces"));
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
  if (asks_for_points() && event.kind == Kind::kKeyDown && event.key == Key::kEnter) return SeparateJaws(), true;
  if (asks_for_points() && event.kind == Kind::kKeyDown && event.key == Key::kBackspace) {
    return separation_->TakeBack(), true;
  }
  if (asks_about_scan() && event.kind == Kind::kKeyDown && event.key == Key::kEnter) {
    if (scan_check_->takes_enter()) ImportChecked();
    return true;
  }
  if (asks_about_ct()) return false;
  if (!in_pieces_) return viewer_->is_running() && editor_.gestures.Take(event);
  if (pieces_.Take(event)) return true;
  if (escape) return LeavePieces(), true;
  return false;
}

// ---- frames

void Rehearsal::Update(double dt_s) {
  FollowChange();
  FollowOpening();
  FollowCtReader();
  distances_.Update();
  writer_.Update();
  FollowSaving();
  unsaved_cut_.Follow(viewer_->figures().changes);
  // The user may have cancelled the saving, and it may have failed.
  if (to_open_once_saved_ && !writer_.is_saving() && save_orders_.empty() && !viewer_->dialogs().is_open()) {
    const std::string input = *std::exchange(to_open_once_saved_, std::nullopt);
    if (DescribeChanges().empty()) OpenNow(input, false);
  }
  if (viewer_->is_running() && !viewer_->dialogs().is_open()) editor_.marks.Update();
  plan_link_.Update(dt_s);
  FollowSentBone();
  // Not over the tour.
  if (shows_import_ && viewer_->is_running() && !is_new_bone_ && !viewer_->dialogs().is_open() &&
      !viewer_->is_in_tour()) {
    shows_import_ = false;
    ShowImportNotes();
  }
  FollowCut();
  FollowPlane();
  FollowGuide();
  if (in_pieces_) {
    pieces_.Update();
    pieces_.MoveMarks(ListMarks(editor_.document));
    viewer_->view().SetPlanes(ListPlanes(editor_.document, true));  // the language of their names may have changed
    editor_.gestures.Hide();
    HidePlanOnBone(*viewer_);
  } else if (viewer_->is_running()) {
    ShowPlan(*viewer_, editor_.document, cut_ ? &*cut_ : nullptr);
    editor_.gestures.Show();
  }
}

void Rehearsal::Fill(HudState& hud) {
  hud.status.mode = in_pieces_ ? Tr("Pieces") : Tr("Rehearse");
  if (!choice_.saw_name.empty()) hud.status.saw = Tr(choice_.saw_name.c_str());
  // Each change of the saw or the guide begins another session, which the user need not know.
  for (const ProjectSession& session : sessions_) {
    if (hud.status.recording_s) *hud.status.recording_s += session.duration_s.value_or(0);
  }
  if (asks_about_ct()) {
    hud.status.mode = fmt::format(fmt::runtime(Tr("Opening {}")), NameCaseOf(loader_.input()));
    hud.status.saw.clear();
    hud.status.recording_s.reset();
  }
  distances_.Fill(hud);
  if (cut_) ShowInjuries(cut_->injuries, hud);
  distances_.SoundAlarms();
  if (to_open_ || opened_) {
    // The work in progress ends first, which can take seconds.
    const std::string name = ShowFileName(to_open_ ? *to_open_ : loader_.input());
    hud.progress =
        HudProgress{.title = name.empty() ? Tr("Opening") : fmt::format(fmt::runtime(Tr("Opening {}")), name),
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
    if (has_case()) {
      hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                             .text = Tr("This is still the case before."),
                             .answers = Tr("The one that is being opened replaces it once it is ready.")};
    }
  } else if (change_.is_pending()) {
    hud.progress = HudProgress{.title = Tr("Preparing the saw"), .stage = Tr("clicks and keys wait until then")};
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
  } else if (viewer_->session() == nullptr && !separation_ && !scan_check_) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = Tr("No bone is open."),
                           .answers = Tr("Ctrl+O: open a bone, a CT, a scene or a project, or drop it here")};
  }
  if (ended_work_) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kWarning,
                           .text = Tr("The session has ended. What was done can still be saved and exported."),
                           .answers = Tr("Ctrl+Shift+S: save the project as   F9: export   Ctrl+O: open")};
  }
  editor_.gestures.Fill(hud);
  if (menu_) hud.menu = menu_->Show();
  if (in_pieces_) pieces_.Fill(hud);
}

void Rehearsal::DrawSections(Ui& ui) {
  if (!in_pieces_) editor_.panel.Draw(ui, cut_ ? &*cut_ : nullptr);
}

void Rehearsal::DrawWindows(Ui& ui) {
  if (asks_about_scan()) {
    switch (scan_check_->Draw(ui, viewer_->areas().scene, viewer_->areas().right, preview_)) {
      case ScanCheck::Answer::kImport:
        return ImportChecked();
      case ScanCheck::Answer::kCancel:
        return Cancel();
      case ScanCheck::Answer::kNone:
        return;
    }
  }
  if (asks_for_points()) {
    switch (separation_->Draw(ui, viewer_->areas().scene, viewer_->areas().right, preview_)) {
      case JawSeparation::Answer::kSeparate:
        return SeparateJaws();
      case JawSeparation::Answer::kCancel:
        return Cancel();
      case JawSeparation::Answer::kNone:
        return;
    }
  }
  // The slices of another case would belong to nothing else that is shown.
  if (loader_.is_opening() && !has_case()) preview_.Draw(ui, viewer_->areas().right, loader_.ct());
  if (in_pieces_) return;
  editor_.gestures.DrawHint(ui);
  editor_.actions.DrawContextMenu(ui);
}

void Rehearsal::OpenContextMenu(const ScreenPoint& at) {
  if ((viewer_->is_running() || change_.is_pending()) && !in_pieces_) editor_.actions.OpenContextMenu(at);
}

void Rehearsal::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  distances_.AddAlarms(alarms);
}

bool Rehearsal::wants_slice_points() const {
  return viewer_->is_running() && !in_pieces_ && editor_.gestures.is_placing();
}

void Rehearsal::TakeSlicePoint(const Vec3& p_W) {
  editor_.gestures.TakePoint(p_W);
}

void Rehearsal::MoveSlicePoint(std::size_t i, const Vec3& p_W, bool first) {
  editor_.gestures.MoveListed(i, p_W, first);
}

void Rehearsal::TakeBackSlicePoint() {
  editor_.gestures.TakeBackPoint();
}

std::optional<Vec3> Rehearsal::slice_point() const {
  return wants_slice_points() ? editor_.gestures.latest_point_W() : std::nullopt;
}

void Rehearsal::FillSlices(SliceScene& scene) const {
  for (const MarkTube& tube : editor_.document.mark_tubes()) {
    scene.marks.push_back({.points_W = tube.curve_W(),
                           .radius_mm = tube.radius_mm(),
                           .colour = {255, 130, 210},  // light: it is drawn on grey
                           .label = tube.name()});
  }
  if (in_pieces_) {
    scene.tool.reset();
    scene.note = Tr("The slices show the bone before pieces were moved.");
  } else {
    scene.points = editor_.gestures.ListPointOverlays();
  }
  scene.planes = viewer_->lined_planes();
}

bool Rehearsal::takes_escape() const {
  return menu_ || editor_.gestures.is_placing() || in_pieces_ || is_loading();
}

void Rehearsal::Save() {
  SaveProject(true);
}

void Rehearsal::Describe(nlohmann::json& state) const {
  state["mode"] = menu_ ? "menu" : editor_.gestures.is_placing() ? "picking" : in_pieces_ ? "pieces" : "cutting";
  if (menu_) state["menu"] = menu_->title();
  editor_.document.Describe(state);
  editor_.gestures.Describe(state);
  state["unsaved"] = !DescribeUnsaved().empty();
  state["opening"] = is_opening();
  if (scan_check_) scan_check_->Describe(state);
  if (separation_) separation_->Describe(state);
  state["work_kept"] = ended_work_.has_value();
  state["guided"] = choice_.guided;
  state["plane_cut"] = nlohmann::json::array();
  if (cut_) {
    for (const PlanesReport::Row& row : cut_->planes) state["plane_cut"].push_back(row.state.fraction());
  }
  state["injuries"] = nlohmann::json::array();
  if (cut_) {
    for (const StructureResult& injury : cut_->injuries) state["injuries"].push_back(DescribeInjury(injury));
  }
  state["saw"] = choice_.saw_name;
  if (in_pieces_) pieces_.Describe(state);
}

}  // namespace kerf
