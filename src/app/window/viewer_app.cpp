#include "app/window/viewer_app.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "app/window/viewer_help.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"

namespace kerf {
namespace {

constexpr double kFrame_s = 1.0 / 60;
constexpr double kMessage_s = 6;
constexpr std::size_t kMaxForces = 200'000;  // maximum number of points: more than an hour of the force curve
constexpr double kPreviewVoxel_mm = 0.8;
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
}

ViewerApp::~ViewerApp() {
  session_.reset();
  window_.BeginFrame();
  view_.reset();
}

// ---- the session

void ViewerApp::Begin(const Scene& scene, const std::string& scene_file, bool same_bone) {
  const bool goes_on = same_bone && surface_ != nullptr;
  session_.reset();
  began_ = false;
  ++sessions_;
  recording_ = fmt::format("{}/session{}.kerf", options_.folder, sessions_ == 1 ? "" : fmt::format("-{}", sessions_));
  leaf_receiver_ = goes_on ? surface_ : nullptr;
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
  };
  live.scripted = options_.scripted;
  if (device_ && device_->holds()) live.device = &device_->servo();
  live.begin = [this, goes_on, file = scene.bone.source == BoneSource::kFile ? scene.bone.file : ""](
                   const Bone& bone, const EffectPlan&) {
    if (goes_on) return;
    leaf_receiver_ = std::make_shared<SurfaceWorker>(WithCtNumbers(bone, file));
    {
      const std::lock_guard lock(mutex_);
      made_ = Made{.surface = leaf_receiver_, .materials = bone.materials(), .voxel_mm = bone.voxel_mm()};
      at_start_ = std::make_shared<const Bone>(bone);
    }
    InnerSurfaces inner = MakeInnerSurfaces(bone);
    const std::lock_guard lock(mutex_);
    inner_made_ = std::move(inner);
  };
  // A coarse bone is ready within a second; the final one takes longer.
  if (!goes_on && scene.bone.source == BoneSource::kMandible) {
    live.prepare = [this, coarse = scene]() mutable {
      coarse.bone.mandible.voxel_mm = std::max(coarse.bone.mandible.voxel_mm, kPreviewVoxel_mm);
      const Bone bone = MakeSceneBone(coarse, {});
      auto surface = std::make_shared<SurfaceWorker>(bone);
      const std::lock_guard lock(mutex_);
      made_ = Made{.surface = surface, .materials = bone.materials(), .voxel_mm = bone.voxel_mm()};
    };
  }
  trace_.Write("session", {{"recording", recording_}, {"tool", DescribeTool(scene.tool)}});
  session_ = std::make_unique<LiveSession>(scene, std::move(live));
}

std::shared_ptr<const Bone> ViewerApp::bone_at_start() {
  const std::lock_guard lock(mutex_);
  return at_start_;
}

void ViewerApp::End() {
  if (session_) session_->Stop();
}

void ViewerApp::Quit() {
  quitting_ = true;
  End();
}

bool ViewerApp::spindle_on() const {
  return session_ && session_->rpm() != 0;
}

bool ViewerApp::steers() const {
  return is_running() && activity_->cuts() && !options_.scripted;
}

void ViewerApp::SetSpindle(bool on) {
  if (!is_running() || on == spindle_on()) return;
  session_->SetSpindle(on ? session_->scene().tool.rpm : 0);
  trace_.Write("spindle", {{"on", on}});
}

void ViewerApp::FollowSession() {
  {
    const std::lock_guard lock(mutex_);
    if (made_) {
      surface_ = std::move(made_->surface);
      inner_.reset();
      view_->BeginBone(made_->materials, surface_->origin_W(), surface_->bounds_W(), made_->voxel_mm);
      if (!fitted_) {
        view_->camera().Look(kViews[view_index_]);
        view_->FitAll();
      }
      fitted_ = true;
      fit_again_ = !view_changed_;
      made_.reset();
      trace_.Write("bone");
    }
    if (inner_made_) {
      inner_ = std::make_shared<const InnerSurfaces>(std::move(*inner_made_));
      view_->SetInnerSurfaces(*inner_);
      if (surface_) surface_->SetInnerSurfaces(inner_);
    }
    inner_made_.reset();
  }
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
    figures_ = session_->figures();
    if (!began_) {
      began_ = true;
      controls_->Set(figures_.coupled.X_WT);
      X_start_ = figures_.coupled.X_WT;
      returning_ = false;
      view_->SetTool(MakeTool(session_->scene()));
      activity_->Began();
      trace_.Write("running");
    }
    for (const ForceMoment& moment : session_->TakeForces()) {
      if (forces_.size() < kMaxForces) forces_.push_back({moment.time_s, moment.force_N});
    }
    for (const LiveSession::Answer& answer : session_->TakeAnswers()) {
      if (answer.action.kind == LoopAction::Kind::kSpindle) continue;
      const char* what = answer.action.kind == LoopAction::Kind::kUndo   ? "Undone"
                         : answer.action.kind == LoopAction::Kind::kRedo ? "Redone"
                                                                         : "Checkpoint";
      const std::string name = answer.action.name.empty() ? "" : fmt::format(": {}", answer.action.name);
      Say(answer.failure.empty() ? what + name : answer.failure);
      trace_.Write("answer", {{"what", what}, {"name", answer.action.name}, {"failure", answer.failure}});
      if (answer.failure.empty() && answer.action.kind != LoopAction::Kind::kCheckpoint) {
        controls_->Set(session_->figures().coupled.X_WT);
      }
    }
  } else if (stage == LiveStage::kEnded) {
    const std::string failure = session_->failure();
    if (!failure.empty()) {
      trace_.Write("ended", {{"failure", failure}, {"recording", recording_}});
      throw Error(failure);
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

// ---- events

void ViewerApp::LoseFocus(const char* why) {
  controls_->Release();
  orbiting_ = panning_ = false;
  if (!spindle_on()) return;
  SetSpindle(false);
  Say(fmt::format("{}: the spindle was stopped", why));
}

bool ViewerApp::TakeKey(const WindowEvent& event) {
  const bool fresh = !event.repeat;
  if (event.control) {
    if (event.key != Key::kQ) return false;
    Quit();
    return true;
  }
  switch (event.key) {
    case Key::kF12:
      try {
        if (fresh) Say(fmt::format("Picture: {}", TakePicture()));
      } catch (const Error& e) {
        Say(e.what());
      }
      return true;
    case Key::kEnter:
      if (!device_ || !device_->waits()) return false;
      if (fresh) device_->Agree();
      return true;
    case Key::kSpace:
      if (fresh && activity_->cuts()) SetSpindle(!spindle_on());
      return true;
    case Key::kR:
      if (!steers()) return false;
      if (spindle_on()) {
        Say("The saw returns to its start only with the spindle off; turn it off first");
      } else if (device_ && device_->holds()) {
        controls_->Set({X_start_.R_AB, figures_.coupled.X_WT.p_AB});
        Say("The saw has its initial orientation; the handle sets its position");
      } else {
        controls_->Set(X_start_);
        returning_ = true;
      }
      return true;
    case Key::kHome:
      view_->FitAll();
      return true;
    case Key::kLeftBracket:
      controls_->set_feed_mm_per_s(controls_->feed_mm_per_s() / 1.25);
      Say(fmt::format("Keys move the saw at {:.1f} mm/s", controls_->feed_mm_per_s()));
      return true;
    case Key::kRightBracket:
      controls_->set_feed_mm_per_s(controls_->feed_mm_per_s() * 1.25);
      Say(fmt::format("Keys move the saw at {:.1f} mm/s", controls_->feed_mm_per_s()));
      return true;
    case Key::kT:
      if (fresh) view_->set_translucent(!view_->translucent());
      return true;
    case Key::kM:
      if (fresh) {
        const ColourBy next = view_->colour_by() == ColourBy::kPlain    ? ColourBy::kTissue
                              : view_->colour_by() == ColourBy::kTissue ? ColourBy::kRegion
                                                                        : ColourBy::kPlain;
        view_->set_colour_by(next);
      }
      return true;
    case Key::kX:
      if (!fresh) return true;
      slices_shown_ = !slices_shown_;
      if (!slices_shown_) view_->SetSlices(std::nullopt);
      if (surface_ && !surface_->has_hu()) Say("This bone has no CT numbers: import it with --keep-hu");
      return true;
    case Key::kV:
      view_index_ = (view_index_ + (event.shift ? kViews.size() - 1 : 1)) % kViews.size();
      view_->camera().Look(kViews[view_index_]);
      view_->FitAll();
      Say(fmt::format("Seen from: {}", ToString(kViews[view_index_])));
      return true;
    case Key::kL:
      if (!fresh) return true;
      controls_->set_in_blade_plane(!controls_->in_blade_plane());
      Say(controls_->in_blade_plane() ? "The saw moves in the blade's plane only" : "The saw moves freely");
      return true;
    default:
      return false;
  }
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
      Quit();
      return;
    case Kind::kResize:
      if (window_.width() > 0 && window_.height() > 0) {
        view_->Resize(window_.width(), window_.height(), options_.scale);
        trace_.Write("resized", {{"width", window_.width()}, {"height", window_.height()}});
      }
      return;
    case Kind::kFocus:
      trace_.Write("focus", {{"on", event.on}});
      if (!event.on) LoseFocus("The window lost focus");
      return;
    case Kind::kMinimise:
      minimised_ = event.on;
      trace_.Write("minimised", {{"on", event.on}});
      if (event.on) LoseFocus("The window was minimised");
      return;
    default:
      break;
  }
  // Taking a picture and closing the window are always possible, whatever is open.
  const bool leaves = event.kind == Kind::kKeyDown && event.control && event.key == Key::kQ;
  if (leaves || (event.kind == Kind::kKeyDown && event.key == Key::kF12)) {
    TakeKey(event);
    return;
  }
  if (entry_) {
    if (event.kind == Kind::kText && entry_is_new_) return;  // the character of the key that opened the text input
    const TextEntry::State state = entry_->Take(event);
    if (state == TextEntry::State::kOpen) return;
    const std::string text = entry_->text();
    entry_.reset();
    const auto done = std::exchange(entry_done_, nullptr);
    done(state == TextEntry::State::kDone ? std::optional(text) : std::nullopt);
    return;
  }
  const bool question = event.kind == Kind::kText && event.character == U'?';
  const bool f1 = event.kind == Kind::kKeyDown && event.key == Key::kF1 && !event.repeat;
  if (question || f1) {
    help_ = !help_;
    controls_->Release();
    return;
  }
  if (help_ && event.kind == Kind::kKeyDown) {
    if (event.key == Key::kEscape) help_ = false;
    if (event.key == Key::kSpace && spindle_on()) SetSpindle(false);
    return;
  }
  if (activity_->Take(event)) return;
  if (event.kind == Kind::kKeyDown && TakeKey(event)) return;
  const bool turns =
      event.kind == Kind::kScroll || (event.kind == Kind::kMouseDown && event.button != MouseButton::kLeft);
  view_changed_ = view_changed_ || turns;
  const bool on_panel = event.kind == Kind::kMouseDown && view_->IsOnPanel({event.x, event.y});
  if (steers() && !on_panel && controls_->Take(event, MakeBasis())) {
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
  view_->SetForce(force_N > 0.05
                      ? std::optional(ForceArrow{.p_W = figures_.coupled.X_WT.p_AB, .f_W_N = figures_.coupled.f_H_W_N})
                      : std::nullopt);
  if (!surface_ || !surface_->has_hu() || !slices_shown_) return;
  surface_->RequestSlices(tool, figures_.coupled.X_WT, std::max(40.0, 2.4 * CalcReach(tool)), 180);
  if (std::optional<CtSlices> slices = surface_->FetchSlices()) view_->SetSlices(slices);
}

void ViewerApp::UpdateCutInPicture(const Tool& tool, double dt_s) {
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
      alarms.push_back({.p_W = nerve->p_W,
                        .level = AlarmLevelFor(nerve->distance_mm),
                        .label = fmt::format("nerve: {:.1f} mm", std::max(0.0, nerve->distance_mm))});
    }
  }
  view_->set_alarm_level(alarms.empty() ? AlarmLevel::kNone : alarms.front().level);
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

void ViewerApp::Update(double dt_s) {
  FollowSession();
  if (device_ && session_ && began_) FollowDevice(dt_s);
  if (steers() && began_) {
    if (returning_) controls_->Set(X_start_);
    returning_ = returning_ && !spindle_on() && glm::length(figures_.coupled.X_WT.p_AB - X_start_.p_AB) > 0.5;
    controls_->Advance(dt_s, MakeBasis(), figures_.coupled.X_WT);
    session_->SetTarget(controls_->wanted());
  }
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
  hud.status.right = missed > 0.02 ? fmt::format("machine too slow: {:.0f} % of ticks late   F1 help", 100 * missed)
                                   : std::string("F1 help");
  if (help_) {
    hud.show_help = true;
    hud.help = ViewerHelp();
    if (!activity_->cuts()) hud.help.erase(hud.help.begin());  // the saw's keys
    if (device_ && !options_.scripted) hud.help.push_back(device_->MakeHelp());
    for (HudKeyGroup& group : activity_->help()) hud.help.push_back(std::move(group));
  }
  if (session_ && !is_running()) {
    const auto [stage, fraction] = session_->progress();
    const bool loading = session_->stage() == LiveStage::kLoading;
    hud.progress =
        HudProgress{.title = loading ? "Loading" : "Ending the session", .stage = stage, .fraction = fraction};
  }
  activity_->Fill(hud);
  if (device_ && is_running() && !options_.scripted) {
    if (std::optional<HudBanner> banner = device_->MakeBanner()) hud.banner = std::move(banner);
  }
  if (entry_) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kQuestion,
                           .text = fmt::format("{} {}_", entry_->question(), entry_->text()),
                           .answers = "Enter: done   Esc: cancel"};
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
                       {"help", help_},
                       {"entry", entry_.has_value()},
                       {"message", now_s_ < said_until_s_ ? said_ : ""},
                       {"chunks_left", surface_ ? surface_->counts().first_left : 1}};
  activity_->Describe(state);
  return state;
}

void ViewerApp::Draw() {
  const auto began = std::chrono::steady_clock::now();
  view_->SetHud(MakeHud());
  window_.BeginFrame();
  view_->Render();
  window_.Present();
  times_.frame.Add(std::llround(1e9 * SecondsSince(began)));
}

void ViewerApp::Run(Activity& activity) {
  activity_ = &activity;
  const auto start = std::chrono::steady_clock::now();
  double last_s = 0;
  bool first_picture = false;
  while (!done_) {
    const double spent_s = SecondsSince(start) - now_s_;
    // While a bone is made, draw fewer frames, to leave processor time for it.
    const double frame_s = session_ && !is_running() ? 0.1 : kFrame_s;
    const double wait_s = minimised_ ? 0.05 : std::max(0.0, frame_s - spent_s);
    for (const WindowEvent& event : window_.Poll(wait_s)) Take(event);
    entry_is_new_ = false;
    if (options_.interrupt != nullptr && options_.interrupt->load() && !quitting_) Quit();
    now_s_ = SecondsSince(start);
    Update(now_s_ - last_s);
    last_s = now_s_;
    if (quitting_ && !session_) done_ = true;
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
  entry_.emplace(question, initial);
  entry_is_new_ = true;
  entry_done_ = std::move(done);
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
  HudState none;
  none.show_values = none.show_plot = false;
  view_->SetHud(none);
  window_.BeginFrame();
  view_->Render();
  const TemporaryFolder folder("kerf_scene");
  const std::string path = folder.path() + "/picture.png";
  WritePng(view_->Grab(), path);
  return ReadTextFile(path);
}

}  // namespace kerf
