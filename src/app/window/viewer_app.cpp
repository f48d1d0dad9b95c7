#include "app/window/viewer_app.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <system_error>
#include <utility>

#include "app/window/is_ready.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "bone/grid/ct_modulus.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/clear_pose.h"
#include "session/run/make_bone.h"
#include "view/live/palette.h"
#include "view/ui/picture_marks.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr double kFrame_s = 1.0 / 60;
constexpr double kMessage_s = 6;
constexpr double kSlicePeriod_s = 0.25;      // of slices while the bone is cut
constexpr double kLinePeriod_s = 1;          // of the planes' lines on the bone
constexpr std::size_t kMaxForces = 200'000;  // maximum number of points: more than an hour of the force curve
constexpr double kPreviewVoxel_mm = 0.8;
constexpr double kLeave_s = 0.5;  // time that loading gets to end by itself when the window is closed
constexpr std::array<View, 7> kViews{View::kThreeQuarter, View::kFront, View::kLeft,  View::kRight,
                                     View::kTop,          View::kBack,  View::kBottom};

/// Returns the bone with the CT numbers of the bone file, if it has any. The slices need them, but the loop does not.
Bone WithCtNumbers(const Bone& bone, const std::string& file) {
  if (file.empty() || bone.has_hu()) return bone;
  Bone read = ReadBone(file, {.hu = true});
  return read.has_hu() ? read : bone;
}

double SecondsSince(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

ViewerApp::ViewerApp(const ViewerOptions& options)
    : options_(options),
      trace_(options.log),
      window_({.title = options.title, .width = options.width, .height = options.height}),
      view_(std::make_unique<Viewport>(window_.render_window())),
      controls_(std::make_unique<SawControls>(Pose{})) {
  const double scale = options_.scale > 0 ? options_.scale : std::max(1.0, window_.content_scale());
  options_.scale = kDisplayScaleRange.Clamp(scale);
  view_->Resize(window_.width(), window_.height(), options_.scale);
  if (options_.device) device_.emplace(options_.device);
  settings_file_ = FindSettingsFile();
  std::string fault;
  try {
    settings_ = ReadSettings(settings_file_);
  } catch (const Error& e) {
    fault = e.what();
  }
  SetLanguage(settings_.language);
  ui_.SetSize(window_.width(), window_.height(), options_.scale);
  ui_.set_theme(settings_.theme);
  ui_.set_text_size(settings_.text_size);
  view_->SetPanels(ui_.prop());
  view_->set_theme(settings_.theme);
  sound_.SetVolume(100 * settings_.volume);
  sound_.SetMuted(settings_.mute);
  AddActions();
  if (!fault.empty()) Say(fault);
}

ViewerApp::~ViewerApp() {
  session_.reset();
  window_.BeginFrame();
  view_.reset();
}

// ---- the session

std::shared_ptr<SurfaceWorker> ViewerApp::ShowBone(std::shared_ptr<const Bone> bone, bool final) {
  auto surface = std::make_shared<SurfaceWorker>(*bone);
  Made made{
      .surface = surface, .bone = final ? bone : nullptr, .materials = bone->materials(), .voxel_mm = bone->voxel_mm()};
  const std::lock_guard lock(mutex_);
  made_ = std::move(made);
  if (final) at_start_ = std::move(bone);
  return surface;
}

void ViewerApp::Clear() {
  {
    const std::lock_guard lock(mutex_);
    made_.reset();
    at_start_.reset();
    watch_.reset();
  }
  leaf_watch_.reset();
  if (making_inner_.valid()) unused_inner_.push_back(std::move(making_inner_));
  surface_.reset();
  leaf_receiver_.reset();
  figures_ = {};
  forces_.clear();
  fitted_ = fit_again_ = false;
  view_->BeginBone({}, Vec3{0}, Box3{}, 1);
  view_->SetInnerSurfaces({});
  view_->ClearTool();
  view_->SetGhost(std::nullopt);
  view_->SetForce(std::nullopt);
  view_->SetContact(std::nullopt);
  view_->SetAlarms({});
  view_->SetPlaneLines({});
  cut_place_.Clear();
  inner_.reset();
  slices_ = {};
  lined_planes_.clear();
}

void ViewerApp::Begin(const Scene& scene, const std::string& scene_file, bool same_bone,
                      std::shared_ptr<const Bone> bone) {
  TakeMade();
  const bool goes_on = same_bone && surface_ != nullptr;
  goes_on_ = goes_on;
  session_.reset();
  began_ = false;
  ++sessions_;
  recording_ = fmt::format("{}/session{}.kerf", options_.folder, sessions_ == 1 ? "" : fmt::format("-{}", sessions_));
  leaf_receiver_ = goes_on ? surface_ : nullptr;
  leaf_watch_ = goes_on ? cut_watch() : nullptr;
  figures_ = {};
  cut_place_.Clear();
  shown_removed_mm3_ = 0;
  forces_.clear();
  fitted_ = fitted_ && goes_on;
  LiveOptions live;
  live.record = recording_;
  live.scene_file = scene_file;
  live.leaf = [this](const LeafMessage& leaf) {
    if (leaf_receiver_) leaf_receiver_->Offer(leaf);
    if (leaf_watch_) leaf_watch_->Offer(leaf.index, leaf.values);
  };
  live.tick = std::exchange(take_tick_, nullptr);
  live.scripted = options_.scripted;
  if (device_ && device_->holds()) live.device = &device_->servo();
  live.begin = [this, goes_on, with_hu = bone && bone->has_hu() ? bone : nullptr,
                file = scene.bone.source == BoneSource::kFile && !bone ? scene.bone.file : ""](
                   const Bone& made, const EffectPlan&) mutable {
    if (!goes_on) {
      auto shown = std::make_shared<Bone>(WithCtNumbers(made, file));
      if (with_hu && !shown->has_hu()) CopyHu(*shown, *with_hu);
      leaf_receiver_ = ShowBone(std::move(shown), true);
    }
    with_hu.reset();
    if (!options_.watch || leaf_watch_) return;
    leaf_watch_ = std::make_shared<CutWatch>(original_ ? original_ : bone_at_start(), made);
    const std::lock_guard lock(mutex_);
    watch_ = leaf_watch_;
  };
  // A coarse bone is ready within a second; the final one takes longer.
  if (!goes_on && scene.bone.source == BoneSource::kMandible) {
    live.prepare = [this, coarse = scene](const std::function<void(double)>& progress) mutable {
      coarse.bone.mandible.voxel_mm = std::max(coarse.bone.mandible.voxel_mm, kPreviewVoxel_mm);
      ShowBone(std::make_shared<const Bone>(MakeSceneBone(coarse, progress)), false);
    };
  }
  live.bone = std::move(bone);
  trace_.Write("session", {{"recording", recording_}, {"tool", DescribeTool(scene.tool)}});
  session_ = std::make_unique<LiveSession>(scene, std::move(live));
}

std::shared_ptr<const Bone> ViewerApp::bone_at_start() {
  const std::lock_guard lock(mutex_);
  return at_start_;
}

std::shared_ptr<CutWatch> ViewerApp::cut_watch() {
  const std::lock_guard lock(mutex_);
  return watch_;
}

void ViewerApp::End() {
  if (session_) session_->Stop();
}

std::optional<WorkProgress> ViewerApp::progress() const {
  if (!session_ || is_running()) return std::nullopt;
  return session_->progress();
}

void ViewerApp::Quit() {
  if (!quitting_) quitting_since_s_ = now_s_;
  quitting_ = true;
  End();
}

bool ViewerApp::spindle_on() const {
  return session_ && session_->rpm() != 0;
}

bool ViewerApp::steers() const {
  return is_running() && activity_->cuts() && !options_.scripted && !session_->moves_saw();
}

bool ViewerApp::touches() const {
  return Touches(figures_.coupled);
}

void ViewerApp::SetSpindle(bool on) {
  if (!is_running() || on == spindle_on()) return;
  session_->SetSpindle(on ? session_->scene().tool.rpm : 0);
  trace_.Write("spindle", {{"on", on}});
  if (!on || sound_.has_sound() || std::exchange(said_no_sound_, true)) return;
  Say(Tr("No sound can be played, because no audio device was found."));
}

/// Draws the bone that another thread has made.
void ViewerApp::TakeMade() {
  std::optional<Made> made;
  {
    const std::lock_guard lock(mutex_);
    made.swap(made_);
  }
  if (!made) return;
  surface_ = std::move(made->surface);
  inner_.reset();
  view_->BeginBone(made->materials, surface_->origin_W(), surface_->bounds_W(), made->voxel_mm);
  if (!fitted_) {
    view_->camera().Look(kViews[view_index_]);
    view_->FitAll();
  }
  fitted_ = true;
  fit_again_ = !view_changed_;
  slices_.Reset(surface_->bounds_W());
  lined_planes_.clear();
  trace_.Write("bone", {{"final", made->bone != nullptr}, {"voxel_mm", made->voxel_mm}});
  if (!made->bone) return;
  if (making_inner_.valid()) unused_inner_.push_back(std::move(making_inner_));
  making_inner_ = std::async(std::launch::async, [bone = std::move(made->bone)] { return MakeInnerSurfaces(*bone); });
}

void ViewerApp::FollowSession() {
  TakeMade();
  if (IsReady(making_inner_)) {
    inner_ = std::make_shared<const InnerSurfaces>(making_inner_.get());
    view_->SetInnerSurfaces(*inner_);
    if (surface_) surface_->SetInnerSurfaces(inner_);
  }
  std::erase_if(unused_inner_, [](const std::future<InnerSurfaces>& making) { return IsReady(making); });
  // The view was fitted to the bone's box; fit it again now that the surface is available.
  if (fit_again_ && !view_changed_ && surface_->first_done()) {
    fit_again_ = false;
    view_->FitAll();
  }
  if (surface_) {
    for (const ChunkMesh& chunk : surface_->Fetch()) {
      const auto began = std::chrono::steady_clock::now();
      view_->SetChunk(chunk);
      if (chunk.cut) times_.upload.Add(std::llround(1e9 * SecondsSince(began)));
    }
  }
  if (!session_) return;
  const LiveStage stage = session_->stage();
  if (stage == LiveStage::kRunning) {
    FollowRunning();
  } else if (stage == LiveStage::kEnded) {
    if (session_->cancelled()) {
      trace_.Write("cancelled", {{"recording", recording_}});
      --sessions_;
      session_.reset();
      activity_->Cancelled();
      return;
    }
    const std::string failure = session_->failure();
    if (!failure.empty()) {
      trace_.Write("ended", {{"failure", failure}, {"recording", recording_}});
      session_.reset();
      if (!activity_->TakeFailure(failure)) throw Error(failure);
      return;
    }
    LoopSummary summary = session_->TakeSummary();
    trace_.Write("ended", {{"failure", ""},
                           {"recording", recording_},
                           {"ticks", summary.counts.ticks},
                           {"missed", summary.counts.missed},
                           {"scheduling", summary.grants.scheduling},
                           {"lateness_p50_us", summary.lateness.p50_us},
                           {"lateness_p99_us", summary.lateness.p99_us},
                           {"lateness_p999_us", summary.lateness.p999_us},
                           {"lateness_max_us", summary.lateness.max_us},
                           {"tick_p50_us", summary.tick.p50_us},
                           {"tick_p99_us", summary.tick.p99_us}});
    // The activity may have begun a new session; otherwise the ended one is removed.
    const LiveSession* over = session_.get();
    activity_->Ended(std::move(summary));
    if (session_.get() == over) session_.reset();
    if (quitting_ && !session_) done_ = true;
  }
}

void ViewerApp::FollowRunning() {
  figures_ = session_->figures();
  if (!began_) {
    began_ = true;
    controls_->Set(figures_.coupled.X_WT);
    controls_->Release();
    X_start_ = figures_.coupled.X_WT;
    returning_ = false;
    const Tool tool = MakeTool(session_->scene());
    const std::shared_ptr<const Bone> bone = bone_at_start();
    // A session may begin with the saw in the bone; then there is no start to return to.
    start_is_clear_ = !bone || IsClear(PhiSampler(*bone), tool, X_start_, 0);
    view_->SetTool(tool);
    activity_->Began();
    trace_.Write("running");
  }
  for (const ForceMoment& moment : session_->TakeForces()) {
    if (forces_.size() < kMaxForces) forces_.push_back({moment.time_s, moment.force_N});
  }
  for (const LiveSession::Answer& answer : session_->TakeAnswers()) {
    if (answer.action.kind == LoopAction::Kind::kSpindle) continue;
    const char* what = answer.action.kind == LoopAction::Kind::kUndo      ? "Undone"
                       : answer.action.kind == LoopAction::Kind::kRedo    ? "Redone"
                       : answer.action.kind == LoopAction::Kind::kRetract ? "Retracted"
                                                                          : "Checkpoint";
    const std::string name = answer.action.name.empty() ? "" : fmt::format(": {}", answer.action.name);
    Say(answer.failure.empty() ? what + name : answer.failure);
    trace_.Write("answer", {{"what", what}, {"name", answer.action.name}, {"failure", answer.failure}});
    if (answer.action.kind == LoopAction::Kind::kCheckpoint || !answer.failure.empty()) continue;
    figures_ = session_->figures();
    if (answer.action.kind == LoopAction::Kind::kRetract && start_is_clear_) {
      controls_->Set(X_start_);
      returning_ = true;
    }
  }
}

// ---- events

void ViewerApp::LetGo() {
  controls_->Release();
  returning_ = false;
}

void ViewerApp::LoseFocus(const char* why) {
  LetGo();
  orbiting_ = panning_ = false;
  mouse_owner_ = MouseOwner::kNone;
  if (!spindle_on()) return;
  SetSpindle(false);
  Say(why);
}

void ViewerApp::Retract() {
  if (spindle_on()) {
    Say(Tr("The saw returns to its start only with the spindle off; turn it off first"));
  } else if (device_ && device_->holds()) {
    controls_->Set({X_start_.R_AB, figures_.coupled.X_WT.p_AB});
    Say(Tr("The saw has its initial orientation; the handle sets its position"));
  } else {
    LetGo();
    session_->Ask({.kind = LoopAction::Kind::kRetract, .name = ""});
  }
}

void ViewerApp::AddActions() {
  const auto cuts = [this] { return activity_->cuts(); };
  const auto steered = [this] { return steers(); };
  const auto feed = [this](double factor) {
    controls_->set_feed_mm_per_s(factor * controls_->feed_mm_per_s());
    Say(fmt::format(fmt::runtime(Tr("Keys move the saw at {} mm/s")), ShowNumber(controls_->feed_mm_per_s(), 1)));
  };
  // ---- saw
  actions_.Add({.id = "saw.spindle",
                .menu = Msg("Saw"),
                .label = Msg("Start or stop the spindle"),
                .shortcut = {Key::kSpace},
                .tip = Msg("A turning saw cuts what it touches; a stopped saw only pushes"),
                .run = [this] { SetSpindle(!spindle_on()); },
                .enabled = [this] { return activity_->cuts() && is_running(); },
                .on = [this] { return spindle_on(); },
                .button = Msg("Spindle"),
                .indicator = Msg("Spindle")});
  actions_.Add(
      {.id = "saw.plane_lock",
       .menu = Msg("Saw"),
       .label = Msg("Stay in the blade's plane"),
       .shortcut = {Key::kL},
       .tip = Msg("Mouse and keys move the saw only within the plane of its blade: a straight cut stays straight"),
       .run =
           [this] {
             controls_->set_in_blade_plane(!controls_->in_blade_plane());
             Say(controls_->in_blade_plane() ? Tr("The saw moves in the blade's plane only")
                                             : Tr("The saw moves freely"));
           },
       .enabled = cuts,
       .on = [this] { return controls_->in_blade_plane(); },
       .indicator = Msg("Plane lock")});
  actions_.Add({.id = "saw.retract",
                .menu = Msg("Saw"),
                .label = Msg("Return the saw to its start"),
                .shortcut = {Key::kR},
                .tip = Msg("With the spindle off, the saw leaves the bone and returns to where it began"),
                .run = [this] { Retract(); },
                .enabled = steered,
                .button = Msg("Retract")});
  actions_.Add({.id = "saw.slower",
                .menu = Msg("Saw"),
                .label = Msg("Keys move the saw slower"),
                .shortcut = {Key::kLeftBracket},
                .run = [feed] { feed(1 / 1.25); },
                .enabled = cuts,
                .repeats = true});
  actions_.Add({.id = "saw.faster",
                .menu = Msg("Saw"),
                .label = Msg("Keys move the saw faster"),
                .shortcut = {Key::kRightBracket},
                .run = [feed] { feed(1.25); },
                .enabled = cuts,
                .repeats = true});
  const auto louder = [this](double percent) {
    sound_.SetVolume(sound_.volume_percent() + percent);
    settings_.volume = 0.01 * sound_.volume_percent();
    KeepSettings();
    Say(fmt::format(fmt::runtime(Tr("The volume is {} %.")), ShowNumber(sound_.volume_percent(), 0)));
  };
  actions_.Add({.id = "sound.mute",
                .menu = Msg("Saw"),
                .label = Msg("Sound"),
                .shortcut = {Key::kU},
                .run =
                    [this] {
                      sound_.SetMuted(!sound_.muted());
                      settings_.mute = sound_.muted();
                      KeepSettings();
                      Say(sound_.muted() ? Tr("The sound is off.") : Tr("The sound is on."));
                    },
                .on = [this] { return !sound_.muted(); },
                .indicator = Msg("Sound"),
                .begins_group = true});
  actions_.Add({.id = "sound.quieter",
                .menu = Msg("Saw"),
                .label = Msg("Quieter"),
                .shortcut = {Key::kMinus},
                .run = [louder] { louder(-10); },
                .repeats = true});
  actions_.Add({.id = "sound.louder",
                .menu = Msg("Saw"),
                .label = Msg("Louder"),
                .shortcut = {Key::kEqual},
                .run = [louder] { louder(10); },
                .repeats = true});
  // ---- view
  actions_.Add({.id = "view.next",
                .menu = Msg("View"),
                .label = Msg("Next view: front, left, right, top"),
                .shortcut = {Key::kV},
                .run = [this] { LookNext(1); },
                .button = Msg("View")});
  actions_.Add({.id = "view.previous",
                .menu = Msg("View"),
                .label = Msg("Previous view"),
                .shortcut = {.key = Key::kV, .shift = true},
                .run = [this] { LookNext(-1); }});
  actions_.Add(
      {.id = "view.all", .menu = Msg("View"), .label = Msg("Show all"), .shortcut = {Key::kHome}, .run = [this] {
         view_->FitAll();
       }});
  actions_.Add({.id = "view.translucent",
                .menu = Msg("View"),
                .label = Msg("Translucent bone: nerve and roots"),
                .shortcut = {Key::kT},
                .tip = Msg("Draws the bone like glass, so that the nerve canal and the roots of the teeth are visible"),
                .run =
                    [this] {
                      view_->set_translucent(!view_->translucent());
                      Say(view_->translucent() ? Tr("The bone is drawn translucent") : Tr("The bone is drawn solid"));
                    },
                .on = [this] { return view_->translucent(); },
                .indicator = Msg("Translucent"),
                .begins_group = true});
  actions_.Add({.id = "view.colours",
                .menu = Msg("View"),
                .label = Msg("Next colours: plain, tissue, region"),
                .shortcut = {Key::kM},
                .run = [this] {
                  const ColourBy next = view_->colour_by() == ColourBy::kPlain    ? ColourBy::kTissue
                                        : view_->colour_by() == ColourBy::kTissue ? ColourBy::kRegion
                                                                                  : ColourBy::kPlain;
                  view_->set_colour_by(next);
                  Say(next == ColourBy::kPlain    ? Tr("Colours: plain bone, cut faces by tissue")
                      : next == ColourBy::kTissue ? Tr("Colours: by tissue")
                                                  : Tr("Colours: by region of the material table"));
                }});
  actions_.Add({.id = "view.slices",
                .menu = Msg("View"),
                .label = Msg("Slices"),
                .shortcut = {Key::kX},
                .run =
                    [this] {
                      slices_shown_ = !slices_shown_;
                      if (slices_shown_ && surface_ && !surface_->has_hu()) {
                        Say(Tr("This bone has no CT numbers: the slices show its tissues"));
                      }
                    },
                .on = [this] { return slices_shown_; }});
  actions_.Add({.id = "view.panels",
                .menu = Msg("View"),
                .label = Msg("Side panel"),
                .shortcut = {Key::kF4},
                .run = [this] { values_shown_ = !values_shown_; },
                .on = [this] { return values_shown_; }});
  actions_.Add({.id = "view.full_screen",
                .menu = Msg("View"),
                .label = Msg("Full screen"),
                .shortcut = {Key::kF11},
                .run = [this] { window_.set_full_screen(!window_.full_screen()); },
                .on = [this] { return window_.full_screen(); }});
  actions_.Add({.id = "view.picture",
                .menu = Msg("View"),
                .label = Msg("Save a picture"),
                .shortcut = {Key::kF12},
                .run =
                    [this] {
                      try {
                        Say(fmt::format(fmt::runtime(Tr("Picture: {}")), TakePicture()));
                      } catch (const Error& e) {
                        Say(e.what());
                      }
                    },
                .begins_group = true});
  actions_.Add({.id = "view.settings",
                .menu = Msg("View"),
                .label = Msg("Settings"),
                .shortcut = {Key::kF10},
                .tip = Msg("Colours, size of text, language, sound"),
                .run = [this] { settings_shown_ = !settings_shown_; },
                .on = [this] { return settings_shown_; }});
}

void ViewerApp::AddLastActions() {
  // These come after the activity's, so that its menus stand between View and Help.
  actions_.Add({.id = "help.keys",
                .menu = Msg("Help"),
                .label = Msg("Keys and mouse"),
                .shortcut = {Key::kF1},
                .run = [this] { ToggleHelp(); },
                .button = Msg("Help")});
  if (!activity_->tour().empty()) {
    actions_.Add({.id = "help.tour", .menu = Msg("Help"), .label = Msg("Tour of the window"), .run = [this] {
                    tour_.Start(activity_->tour());
                  }});
  }
  actions_.Add({.id = "file.quit",
                .menu = Msg("File"),
                .label = Msg("Quit"),
                .shortcut = {.key = Key::kQ, .control = true},
                .run = [this] { AskToQuit(); },
                .begins_group = true});
}

void ViewerApp::LookNext(int by) {
  const auto count = static_cast<int>(kViews.size());
  view_index_ = static_cast<std::size_t>((static_cast<int>(view_index_) + by + count) % count);
  view_->camera().Look(kViews[view_index_]);
  view_->FitAll();
  view_changed_ = true;
  Say(fmt::format(fmt::runtime(Tr("Seen from: {}")), Tr(ToString(kViews[view_index_]))));
}

void ViewerApp::ToggleHelp() {
  help_ = !help_;
  controls_->Release();
}

void ViewerApp::AskToQuit() {
  const std::string unsaved = activity_->DescribeUnsaved();
  if (unsaved.empty()) return Quit();
  SetSpindle(false);
  dialogs_.Ask(unsaved, {{Tr("Save"), [this] { activity_->Save(); }},
                         {Tr("Quit without saving"), [this] { Quit(); }},
                         {Tr("Stay"), nullptr}});
}

bool ViewerApp::TakeMouse(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  switch (event.kind) {
    case Kind::kMouseDown:
      mouse_x_ = event.x;
      mouse_y_ = event.y;
      if (event.button == MouseButton::kRight) orbiting_ = true;
      if (event.button == MouseButton::kMiddle) panning_ = true;
      return event.button != MouseButton::kLeft;
    case Kind::kMouseUp:
      if (event.button == MouseButton::kRight) orbiting_ = false;
      if (event.button == MouseButton::kMiddle) panning_ = false;
      return event.button != MouseButton::kLeft;
    case Kind::kMouseMove: {
      const double dx = event.x - std::exchange(mouse_x_, event.x);
      const double dy = event.y - std::exchange(mouse_y_, event.y);
      if (orbiting_ && event.shift) {
        view_->camera().Pan(dx, dy);
      } else if (orbiting_) {
        view_->camera().Orbit(dx, dy);
      }
      if (panning_) view_->camera().Pan(dx, dy);
      return orbiting_ || panning_;
    }
    case Kind::kScroll:
      view_->camera().Zoom(std::pow(1.15, event.amount), {event.x, event.y});
      return true;
    default:
      return false;
  }
}

void ViewerApp::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  switch (event.kind) {
    case Kind::kClose:
      trace_.Write("closed");
      AskToQuit();
      return;
    case Kind::kDrop:
      trace_.Write("dropped", {{"file", event.path}});
      activity_->Open(event.path);
      return;
    case Kind::kResize:
      if (window_.width() > 0 && window_.height() > 0) {
        view_->Resize(window_.width(), window_.height(), options_.scale);
        ui_.SetSize(window_.width(), window_.height(), options_.scale);
        trace_.Write("resized", {{"width", window_.width()}, {"height", window_.height()}});
      }
      return;
    case Kind::kFocus:
      trace_.Write("focus", {{"on", event.on}});
      ui_.Take(event);
      if (!event.on) LoseFocus(Tr("The window lost focus: the spindle was stopped"));
      return;
    case Kind::kMinimise:
      minimised_ = event.on;
      trace_.Write("minimised", {{"on", event.on}});
      if (event.on) LoseFocus(Tr("The window was minimised: the spindle was stopped"));
      return;
    default:
      break;
  }
  using Owner = MouseOwner;
  const bool down = event.kind == Kind::kKeyDown;
  const bool mouse = event.kind == Kind::kMouseDown || event.kind == Kind::kMouseUp || event.kind == Kind::kMouseMove ||
                     event.kind == Kind::kScroll;
  if (mouse) {
    if (event.kind == Kind::kMouseDown && mouse_owner_ == Owner::kNone) {
      mouse_owner_ = dialogs_.is_open() || ui_.IsOnPanel(event.x, event.y) ? Owner::kPanels : Owner::kScene;
      pressed_at_ = {event.x, event.y};
      moved_since_press_ = false;
    }
    const Owner owner = mouse_owner_ != Owner::kNone      ? mouse_owner_
                        : ui_.IsOnPanel(event.x, event.y) ? Owner::kPanels
                                                          : Owner::kScene;
    moved_since_press_ = moved_since_press_ || std::abs(event.x - pressed_at_.x) > 4 * options_.scale ||
                         std::abs(event.y - pressed_at_.y) > 4 * options_.scale;
    if (event.kind == Kind::kMouseUp) mouse_owner_ = Owner::kNone;
    // The panels see every motion, so that they notice when the mouse leaves them.
    if (owner == Owner::kPanels || event.kind == Kind::kMouseMove) ui_.Take(event);
    if (owner == Owner::kScene || (event.kind == Kind::kMouseMove && !dialogs_.is_open())) TakeInScene(event);
    return;
  }
  // Taking a picture is always possible, whatever is open.
  if (down && event.key == Key::kF12) {
    actions_.Take(event);
    return;
  }
  if (down && event.control && event.key == Key::kQ) {
    if (dialogs_.is_open()) return Quit();
    return AskToQuit();
  }
  if (event.kind == Kind::kText && ignores_text_) return;
  if (dialogs_.is_open()) {
    dialogs_.Take(ui_, event);
    if (!dialogs_.is_open()) ui_.DropText();
    return;
  }
  if (event.kind == Kind::kKeyUp) {
    ui_.Take(event);
    TakeInScene(event);
    return;
  }
  if (ui_.is_popup_open() || ui_.takes_text()) {
    if (down && event.key == Key::kEscape) return ui_.ClosePopups();
    if (ui_.takes_text() || event.kind != Kind::kText) ui_.Take(event);
    if (!ui_.takes_text() && down) {
      ui_.ClosePopups();
    } else {
      return;
    }
  }
  const bool question = event.kind == Kind::kText && event.character == U'?';
  if (question || (down && event.key == Key::kF1 && !event.repeat)) return ToggleHelp();
  if (down && tour_.is_open() && !activity_->takes_escape() && tour_.Take(event)) return;
  if (help_ && down) {
    if (event.key == Key::kEscape) help_ = false;
    if (event.key == Key::kSpace && spindle_on()) SetSpindle(false);
    return;
  }
  if (down && event.key == Key::kEscape && slices_.is_enlarged()) return slices_.Shrink();
  if (settings_shown_ && down && event.key == Key::kEscape) {
    settings_shown_ = false;
    return;
  }
  TakeInScene(event);
}

void ViewerApp::TakeInScene(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (activity_->Take(event)) return;
  if (event.kind == Kind::kKeyDown) {
    if (event.key == Key::kEnter && device_ && device_->waits()) {
      if (!event.repeat) device_->Agree();
      return;
    }
    if (actions_.Take(event)) return;
  }
  const bool turns =
      event.kind == Kind::kScroll || (event.kind == Kind::kMouseDown && event.button != MouseButton::kLeft);
  view_changed_ = view_changed_ || turns;
  if (event.kind == Kind::kMouseUp && event.button == MouseButton::kRight && !moved_since_press_) {
    activity_->OpenContextMenu({event.x, event.y});
  }
  if (steers() && controls_->Take(event, MakeBasis())) {
    returning_ = false;
    return;
  }
  TakeMouse(event);
}

// ---- a frame

ViewBasis ViewerApp::MakeBasis() const {
  const ViewCamera& camera = view_->camera();
  return {.right_W = camera.right_W(),
          .up_W = camera.up_W(),
          .forward_W = camera.forward_W(),
          .mm_per_pixel = camera.WorldPerPixel(figures_.coupled.X_WT.p_AB)};
}

void ViewerApp::UpdateToolInPicture(double dt_s) {
  if (!session_ || !began_) return;
  spin_rad_ = std::fmod(spin_rad_ + figures_.in.rpm / 60 * 2 * std::numbers::pi * dt_s, 2 * std::numbers::pi);
  const Pose& X_WT = figures_.coupled.X_WT;
  view_->SetToolPose(X_WT, figures_.in.rpm, spin_rad_);
  const Tool tool = MakeTool(session_->scene());
  UpdateCutInPicture(tool, dt_s);
  const bool leads =
      options_.ghost && !options_.scripted && glm::length(controls_->wanted().p_AB - figures_.coupled.X_WT.p_AB) > 1;
  view_->SetGhost(leads ? std::optional(controls_->wanted()) : std::nullopt);
  const double force_N = glm::length(figures_.coupled.f_H_W_N);
  view_->SetForce(force_N > 0.05 && activity_->cuts()
                      ? std::optional(ForceArrow{
                            .p_W = figures_.coupled.X_WT.p_AB,
                            .f_W_N = figures_.coupled.f_H_W_N,
                            .label = fmt::format(fmt::runtime(Tr("{} N on your hand")), ShowNumber(force_N, 1))})
                      : std::nullopt);
  if (!surface_ || !slices_shown_) return;
  const bool renew = figures_.changes != sliced_changes_ && now_s_ > sliced_s_ + kSlicePeriod_s;
  if (renew) {
    sliced_changes_ = figures_.changes;
    sliced_s_ = now_s_;
  }
  // The slices go through the place of contact or, without contact, through the rim's point that faces the bone.
  Vec3 focus_W = X_WT.p_AB;
  if (cut_place_.p_W()) {
    focus_W = *cut_place_.p_W();
  } else {
    const Vec3 spindle_W = X_WT.Vector({0, 0, 1});
    const Vec3 to_bone_W = surface_->bounds_W().centre() - X_WT.p_AB;
    if (const auto in_plane_W = CalcDirection(to_bone_W - glm::dot(to_bone_W, spindle_W) * spindle_W)) {
      focus_W += CalcReach(tool) * *in_plane_W;
    }
  }
  slices_.Update(*surface_, MakeSliceScene(), focus_W, renew);
}

SliceScene ViewerApp::MakeSliceScene() const {
  SliceScene scene;
  if (session_ && began_) {
    scene.tool = MakeTool(session_->scene());
    scene.X_WT = figures_.coupled.X_WT;
  }
  activity_->FillSlices(scene);
  return scene;
}

void ViewerApp::RequestPlaneLines(const std::vector<PlaneOverlay>& planes) {
  if (!surface_) return;
  const bool changed = figures_.changes != lined_changes_ && now_s_ > lined_s_ + kLinePeriod_s;
  if (planes == lined_planes_ && !changed) return;
  lined_planes_ = planes;
  lined_changes_ = figures_.changes;
  lined_s_ = now_s_;
  surface_->RequestPlaneLines(planes);
}

void ViewerApp::HidePlaneLines() {
  lined_planes_.clear();
  view_->SetPlaneLines({});
}

void ViewerApp::UpdateCutInPicture(const Tool& tool, double dt_s) {
  if (!activity_->cuts()) {  // the tool is not shown
    view_->SetContact(std::nullopt);
    view_->SetAlarms({});
    view_->AdvanceDust(dt_s);
    return;
  }
  const Pose& X_WT = figures_.coupled.X_WT;
  cut_place_.Update(tool, X_WT, figures_.coupled.f_cut_W_N + figures_.coupled.f_face_W_N, dt_s);
  view_->SetContact(cut_place_.p_W());
  const double removed_mm3 = figures_.removed_mm3 - std::exchange(shown_removed_mm3_, figures_.removed_mm3);
  if (cut_place_.p_W()) {
    const Vec3 spin_W = figures_.in.rpm / 60 * 2 * std::numbers::pi * X_WT.Vector({0, 0, 1});
    view_->AddDust(*cut_place_.p_W(), glm::cross(spin_W, *cut_place_.p_W() - X_WT.p_AB), removed_mm3);
  }
  view_->AdvanceDust(dt_s);
  std::vector<AlarmOverlay> alarms;
  if (inner_) {
    if (const std::optional<NearestPlace> nerve = FindNearest(tool, X_WT, inner_->canal_W)) {
      alarms.push_back(
          {.p_W = nerve->p_W,
           .level = AlarmLevelFor(nerve->distance_mm),
           .label = fmt::format(fmt::runtime(Tr("nerve: {} mm")), ShowNumber(std::max(0.0, nerve->distance_mm), 1))});
    }
  }
  activity_->AddAlarms(alarms);
  view_->SetAlarms(alarms);
  if (!surface_) return;
  if (std::optional<std::vector<PlaneLineOverlay>> lines = surface_->FetchPlaneLines()) view_->SetPlaneLines(*lines);
}

void ViewerApp::FollowDevice(double dt_s) {
  const HandDeviceFrame frame = device_->Update(dt_s, MakeBasis(), figures_.coupled.X_WT, *controls_);
  for (const std::string& message : frame.messages) Say(message);
  for (const std::string& note : session_->TakeNotes()) Say(note);
  if (frame.switches_spindle && steers()) SetSpindle(!spindle_on());
}

/// Finds out why the saw is held, and makes its sound.
void ViewerApp::FollowSaw(double dt_s) {
  const bool cuts = is_running() && began_ && activity_->cuts();
  sound_.SetSaw(cuts ? figures_.in.rpm : 0, glm::length(figures_.coupled.f_H_W_N));
  HeldSawInput in;
  if (began_ && steers() && !(device_ && device_->holds())) {
    in.tool = MakeTool(session_->scene());
    in.X_WT = figures_.coupled.X_WT;
    in.X_wanted = controls_->wanted();
    in.holds = controls_->holds();
    in.spindle_on = spindle_on();
    in.coupled = figures_.coupled;
    in.guide_force_N = figures_.guide_force_N;
    in.guide_normal_W = session_->guide_normal_W();
  }
  const std::optional<HeldReason> before = held_saw_.reason();
  held_saw_.Update(dt_s, in);
  if (held_saw_.reason() == before) return;
  staying_ = held_reason();
  trace_.Write("held", {{"reason", staying_}});
}

std::string ViewerApp::held_reason() const {
  return held_saw_.reason() ? Tr(DescribeHeldReason(*held_saw_.reason())) : "";
}

void ViewerApp::Update(double dt_s) {
  FollowSession();
  if (device_ && session_ && began_) FollowDevice(dt_s);
  if (is_running() && began_) {
    if (!steers()) LetGo();
    if (returning_ && (spindle_on() || glm::length(figures_.coupled.X_WT.p_AB - X_start_.p_AB) < 0.5)) LetGo();
    if (returning_) controls_->Set(X_start_);
    controls_->Advance(dt_s, MakeBasis(), figures_.coupled.X_WT, touches());
    session_->SetTarget(controls_->wanted(), controls_->holds());
  }
  FollowSaw(dt_s);
  activity_->Update(dt_s);
  UpdateToolInPicture(dt_s);
  trace_.WriteState(MakeState());
}

HudState ViewerApp::MakeHud() {
  HudState hud;
  hud.show_values = session_ != nullptr && began_;
  hud.show_plot = hud.show_values;
  hud.values.feed_mm_per_s = figures_.feed_mm_per_s;
  hud.values.rpm = figures_.in.rpm;
  hud.values.force_N = glm::length(figures_.coupled.f_H_W_N);
  hud.now_s = figures_.time_s;
  if (session_) hud.force_note = session_->MakeForceNote(figures_.coupled.mean_bite_mm);
  const auto recent = std::lower_bound(forces_.begin(), forces_.end(), figures_.time_s - 10.5,
                                       [](const PlotPoint& p, double t) { return p.time_s < t; });
  hud.force.assign(recent, forces_.end());
  hud.status.spindle_on = spindle_on();
  if (session_) hud.status.saw = DescribeTool(session_->scene().tool);
  if (now_s_ < said_until_s_) hud.status.message = said_;
  if (is_running()) hud.status.recording_s = figures_.time_s;
  // Some deadlines are missed on every machine, without harm; a noticeable fraction is reported.
  const double missed =
      static_cast<double>(figures_.missed) / static_cast<double>(figures_.number + figures_.missed + 1);
  if (missed > 0.02) {
    hud.status.right = fmt::format(fmt::runtime(Tr("machine too slow: {:.0f} % of ticks late")), 100 * missed);
  }
  hud.legend = view_->legend();
  hud.legend_title = LegendTitle(view_->colour_by());
  if (const std::optional<WorkProgress> now = progress()) {
    const bool loading = session_->stage() == LiveStage::kLoading;
    hud.progress = HudProgress{.title = loading ? Tr("Loading") : Tr("Ending the session"),
                               .stage = Tr(now->stage.c_str()),
                               .fraction = now->fraction};
  }
  activity_->Fill(hud);
  if (device_ && is_running() && !options_.scripted) {
    if (std::optional<HudBanner> banner = device_->MakeBanner()) hud.banner = std::move(banner);
  }
  return hud;
}

nlohmann::json ViewerApp::MakeState() const {
  const Vec3& p = figures_.coupled.X_WT.p_AB;
  const auto tenth = [](double v) { return std::round(10 * v) / 10; };
  nlohmann::json state{{"running", is_running()},
                       {"spindle", spindle_on()},
                       {"rpm", figures_.in.rpm},
                       {"removed_mm3", tenth(figures_.removed_mm3)},
                       {"force_N", tenth(glm::length(figures_.coupled.f_H_W_N))},
                       {"saw_mm", {tenth(p.x), tenth(p.y), tenth(p.z)}},
                       {"holds", controls_->holds()},
                       {"held", held_reason()},
                       {"help", help_},
                       {"entry", dialogs_.asks_text()},
                       {"dialog", dialogs_.is_open()},
                       {"tour", tour_.step()},
                       {"message", now_s_ < said_until_s_ ? said_ : ""},
                       {"chunks_left", surface_ ? surface_->counts().first_left : 1}};
  activity_->Describe(state);
  return state;
}

std::vector<HudKeyGroup> ViewerApp::ListHelp() const {
  std::vector<HudKeyGroup> help;
  if (activity_->cuts()) {
    help.push_back({Tr("Moving the saw"),
                    {{Tr("left drag"), Tr("move across the picture")},
                     {Tr("Shift + left drag"), Tr("move into the picture")},
                     {Tr("Ctrl + left drag"), Tr("turn")},
                     {Tr("arrows, PgUp PgDn"), Tr("the same with keys; with Shift fast")},
                     {"W S  A D  Q E", Tr("tilt, swing, roll")}}});
  }
  help.push_back({Tr("Turning the view"),
                  {{Tr("right drag"), Tr("turn")},
                   {Tr("middle drag"), Tr("shift (or Shift + right drag)")},
                   {Tr("wheel"), Tr("zoom")},
                   {Tr("right click"), Tr("menu for this place")}}});
  if (device_ && !options_.scripted) help.push_back(device_->MakeHelp());
  for (HudKeyGroup& group : activity_->help()) help.push_back(std::move(group));
  for (HudKeyGroup& group : actions_.ListKeys()) help.push_back(std::move(group));
  return help;
}

void ViewerApp::DrawSettings() {
  const float s = ui_.scale();
  ImGui::SetNextWindowPos(
      {static_cast<float>(areas_.scene.left) + 30 * s, static_cast<float>(areas_.scene.top) + 30 * s});
  ImGui::SetNextWindowSize({360 * s, 262 * s});
  ImGui::Begin(
      fmt::format("{}###settings", Tr("Settings")).c_str(), &settings_shown_,
      ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
  bool changed = false;
  ImGui::TextUnformatted(Tr("Colours of the window"));
  for (const auto& [theme, name] : {std::pair{Theme::kLight, Tr("light")}, std::pair{Theme::kDark, Tr("dark")}}) {
    if (ImGui::RadioButton(name, settings_.theme == theme)) {
      settings_.theme = theme;
      ui_.set_theme(theme);
      view_->set_theme(theme);
      changed = true;
    }
    ui_.Note(theme == Theme::kLight ? "setting light" : "setting dark");
    if (theme == Theme::kLight) ImGui::SameLine();
  }
  ImGui::TextUnformatted(Tr("Size of text"));
  for (const double size : {0.85, 1.0, 1.2, 1.5}) {
    if (ImGui::RadioButton(fmt::format("{:.0f} %", 100 * size).c_str(), settings_.text_size == size)) {
      settings_.text_size = size;
      changed = true;
    }
    ui_.Note(fmt::format("setting text {:.0f}", 100 * size));
    if (size < 1.5) ImGui::SameLine();
  }
  ImGui::TextUnformatted(Tr("Language"));
  for (const Language& language : languages_) {
    if (ImGui::RadioButton(language.name.c_str(), CurrentLanguage() == language.code)) {
      settings_.language = language.code;
      SetLanguage(language.code);
      changed = true;
    }
    ui_.Note(fmt::format("setting language {}", language.code));
    ImGui::SameLine();
  }
  ImGui::NewLine();
  ImGui::TextUnformatted(Tr("Sound"));
  auto volume = static_cast<float>(100 * settings_.volume);
  ImGui::SetNextItemWidth(180 * s);
  if (ImGui::SliderFloat("##volume", &volume, 0, 100, "%.0f %%")) {
    settings_.volume = std::clamp(0.01 * static_cast<double>(volume), 0.0, 1.0);
    changed = true;
  }
  ui_.Note("setting volume");
  ImGui::SameLine();
  changed = ImGui::Checkbox(Tr("mute"), &settings_.mute) || changed;
  ui_.Note("setting mute");
  ImGui::End();
  if (changed) {
    sound_.SetVolume(100 * settings_.volume);
    sound_.SetMuted(settings_.mute);
    trace_.Write("settings", {{"text_size", settings_.text_size},
                              {"language", CurrentLanguage()},
                              {"theme", settings_.theme == Theme::kDark ? "dark" : "light"},
                              {"mute", settings_.mute}});
    KeepSettings();
  }
}

void ViewerApp::KeepSettings() {
  try {
    WriteSettings(settings_, settings_file_);
  } catch (const Error& e) {
    Say(e.what());
  }
}

void ViewerApp::DrawUi(const HudState& hud) {
  const bool column = values_shown_ && (hud.show_values || !hud.pieces.empty());
  const UiAreas before = std::exchange(areas_, CalcUiAreas(ui_, column, slices_shown_ && activity_->has_slices()));
  // Until the user turns the view, the whole bone is shown.
  if (before.scene.width != areas_.scene.width && !view_changed_) fit_again_ = surface_ != nullptr;
  // Labels first: they are drawn in the background.
  PictureMarks marks;
  for (const SceneLabel& label : view_->ListLabels()) {
    marks.labels.push_back({label.text, label.x, label.y, label.colour});
  }
  for (const SceneRing& ring : view_->ListRings()) {
    const HudLevel level = ring.level == AlarmLevel::kDanger    ? HudLevel::kBad
                           : ring.level == AlarmLevel::kWarning ? HudLevel::kWarn
                                                                : HudLevel::kPlain;
    marks.rings.push_back({ring.x, ring.y, level});
    if (level == HudLevel::kBad || (level == HudLevel::kWarn && marks.alarm != HudLevel::kBad)) marks.alarm = level;
  }
  const ScreenBox tool = view_->CalcToolBox();
  marks.tool = {tool.left, tool.top, tool.width, tool.height};
  marks.mm_per_pixel = view_->camera().WorldPerPixel(view_->camera().target_W());
  DrawPictureMarks(ui_, marks, areas_.scene);

  if (ImGui::BeginMainMenuBar()) {
    actions_.DrawMenus(ui_);
    ImGui::EndMainMenuBar();
  }
  if (BeginPanel(ui_, "toolbar", areas_.toolbar, false)) {
    actions_.DrawToolbar(ui_);
    ImGui::End();
  }
  if (column && BeginPanel(ui_, "left", areas_.left, true)) {
    GaugeSection(ui_, hud);
    ValuesSection(ui_, hud);
    if (const std::optional<int> row = PiecesSection(ui_, hud)) activity_->PickPieceRow(*row);
    activity_->DrawSections(ui_);
    ForceSection(ui_, hud);
    LegendSection(ui_, hud);
    ImGui::End();
  }
  if (slices_shown_ && activity_->has_slices() && slices_.has_slices()) {
    slices_.Draw(ui_, areas_.right, areas_.scene, MakeSliceScene(),
                 [this](const Vec3& p_W) { return activity_->TakeSlicePoint(p_W); });
  }
  if (BeginPanel(ui_, "status", areas_.status, false)) {
    actions_.DrawIndicators(ui_);
    DrawStatusTexts(hud.status);
    ImGui::End();
  }
  if (hud.banner) DrawBanner(ui_, *hud.banner, areas_.scene);
  DrawMessage(ui_, hud.status.message, staying_, areas_.scene);
  if (hud.progress && DrawProgressBox(ui_, *hud.progress, areas_.scene)) activity_->Cancel();
  if (hud.menu) {
    if (const std::optional<int> row = DrawMenuDialog(ui_, *hud.menu)) picked_row_ = row;
  }
  activity_->DrawWindows(ui_);
  if (settings_shown_) DrawSettings();
  if (tour_.is_open()) {
    tour_.Draw(ui_, areas_.scene);
    if (!tour_.is_open() && !settings_.tour_shown) {
      settings_.tour_shown = true;
      KeepSettings();
    }
  }
  if (help_) DrawHelpDialog(ui_, ListHelp());
  dialogs_.Draw(ui_);
}

void ViewerApp::DrawStatusTexts(const HudStatus& status) {
  std::string text;
  const auto add = [&](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : "   |   ") + part;
  };
  add(status.right);
  add(status.mode);
  add(status.saw);
  if (status.recording_s) {
    const long seconds = std::lround(std::max(0.0, *status.recording_s));
    add(fmt::format(fmt::runtime(Tr("recording {}:{:02}")), seconds / 60, seconds % 60));
  }
  const float from = ImGui::GetItemRectMax().x + 12 * ui_.scale();
  const float room = ImGui::GetWindowWidth() - from - 10 * ui_.scale();
  if (room < 60 * ui_.scale()) return;
  const std::string shown = FitText(text, room);
  ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(shown.c_str()).x - 10 * ui_.scale());
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", shown.c_str());
  if (shown != text) Tooltip(ui_, text);
}

void ViewerApp::Draw() {
  const auto began = std::chrono::steady_clock::now();
  ui_.BeginFrame(frame_s_);
  ui_.set_tooltips(!dialogs_.is_open() && !help_);
  DrawUi(MakeHud());
  ui_.EndFrame();
  const auto box = [](const UiBox& b) { return ScreenBox{b.left, b.top, b.width, b.height}; };
  view_->SetAreas(box(areas_.scene), box(areas_.cube));
  window_.BeginFrame();
  view_->Render();
  window_.Present();
  times_.frame.Add(std::llround(1e9 * SecondsSince(began)));
  actions_.RunChosen();
  dialogs_.RunDecided();
  if (const std::optional<int> row = std::exchange(picked_row_, std::nullopt)) activity_->PickMenuRow(*row);
  if (settings_.text_size != ui_.text_size()) ui_.set_text_size(settings_.text_size);
  if (!trace_) return;
  nlohmann::json noted;
  for (const auto& [name, at] : ui_.noted()) {
    noted[name] = {std::round(at.left), std::round(at.top), std::round(at.width), std::round(at.height)};
  }
  if (noted == noted_) return;
  noted_ = noted;
  trace_.Write("items", {{"items", std::move(noted)}});
}

void ViewerApp::Run(Activity& activity) {
  activity_ = &activity;
  activity.AddActions(actions_);
  AddLastActions();
  languages_ = ListLanguages();
  if (!settings_.tour_shown && !options_.scripted) tour_.Start(activity.tour());
  const auto start = std::chrono::steady_clock::now();
  double last_s = 0;
  bool first_picture = false;
  while (!done_) {
    const double spent_s = SecondsSince(start) - now_s_;
    // While a bone is made, draw fewer frames, to leave processor time for it.
    const double frame_s = session_ && !is_running() && !goes_on_ ? 0.1 : kFrame_s;
    const double wait_s = minimised_ ? 0.05 : std::max(0.0, frame_s - spent_s);
    for (const WindowEvent& event : window_.Poll(wait_s)) Take(event);
    ignores_text_ = false;
    if (options_.interrupt != nullptr && options_.interrupt->load() && !quitting_) Quit();
    now_s_ = SecondsSince(start);
    frame_s_ = now_s_ - last_s;
    Update(frame_s_);
    last_s = now_s_;
    if (quitting_ && !session_) done_ = true;
    if (quitting_ && session_ && session_->stage() == LiveStage::kLoading && now_s_ > quitting_since_s_ + kLeave_s) {
      // A step that cannot be interrupted is left alone. No tick was recorded.
      left_work_ = done_ = true;
      std::error_code ignored;
      std::filesystem::remove(recording_, ignored);
      trace_.Write("left", {{"stage", session_->progress().stage}});
    }
    if (done_ || minimised_ || window_.width() == 0) continue;
    Draw();
    if (!first_picture && surface_ && surface_->first_done()) {
      first_picture = true;
      trace_.Write("first_picture", {{"after_s", SecondsSince(start)}});
    }
  }
  trace_.Write("frames", {{"frames", times_.frame.total()},
                          {"p50_ms", 1e-3 * times_.frame.CalcPercentile_us(0.5)},
                          {"p95_ms", 1e-3 * times_.frame.CalcPercentile_us(0.95)},
                          {"max_ms", 1e-3 * times_.frame.max_us()},
                          {"upload_p50_ms", 1e-3 * times_.upload.CalcPercentile_us(0.5)},
                          {"upload_p99_ms", 1e-3 * times_.upload.CalcPercentile_us(0.99)},
                          {"upload_max_ms", 1e-3 * times_.upload.max_us()},
                          {"uploads", times_.upload.total()},
                          {"renderer", view_->renderer_name()}});
}

// ---- messages and pictures

void ViewerApp::Say(const std::string& message) {
  said_ = message;
  said_until_s_ = now_s_ + kMessage_s;
  trace_.Write("message", {{"text", message}});
}

void ViewerApp::AskText(const std::string& question, const std::string& initial,
                        std::function<void(std::optional<std::string>)> done) {
  controls_->Release();
  ignores_text_ = true;
  dialogs_.AskText(ui_, question, initial, std::move(done));
}

std::string ViewerApp::TakePicture() {
  std::string path;
  do {
    path = fmt::format("{}/picture-{:03d}.png", options_.folder, ++pictures_);
  } while (std::filesystem::exists(path));
  WritePng(view_->Grab(), path);
  trace_.Write("picture", {{"file", path}});
  return path;
}

std::string ViewerApp::GrabScene() {
  view_->set_panels_shown(false);
  window_.BeginFrame();
  view_->Render();
  view_->set_panels_shown(true);
  const TemporaryFolder folder("kerf_scene");
  const std::string path = folder.path() + "/picture.png";
  WritePng(view_->Grab(), path);
  return ReadTextFile(path);
}

}  // namespace kerf
