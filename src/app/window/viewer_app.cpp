#include "app/window/viewer_app.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "kerf/error.h"
#include "view/live/palette.h"

namespace kerf {
namespace {

constexpr double kFrame_s = 1.0 / 60;
constexpr double kStillFrame_s = 1.0 / 20;  // between frames while nothing changes
// While a bone is made, a pause follows each picture that is this multiple of its time, and not longer than
// kMaxPause_s.
constexpr double kPauseFactor = 8;
constexpr double kMaxPause_s = 0.5;
constexpr double kSettled_s = 0.3;  // time without a change after which nothing is expected to change soon
constexpr double kMessage_s = 6;
constexpr double kWarning_s = 10;
constexpr double kLeave_s = 0.5;  // time that loading gets to end by itself when the window is closed

double SecondsSince(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

ViewerApp::ViewerApp(const ViewerOptions& options)
    : options_(options),
      trace_(options.log),
      window_({.title = options.title, .width = options.width, .height = options.height}),
      view_(std::make_unique<Viewport>(window_.render_window())),
      bone_(*view_, trace_),
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
  ui_.SetSize(window_.width(), window_.height(), options_.scale);
  ui_.set_text_size(settings_.text_size);
  view_->SetPanels(ui_.prop());
  ApplySettings();
  AddActions();
  if (!fault.empty()) Say(fault);
}

ViewerApp::~ViewerApp() {
  session_.reset();
  window_.BeginFrame();
  view_.reset();
}

void ViewerApp::ApplySettings() {
  SetLanguage(settings_.language);
  ui_.set_theme(settings_.theme);
  view_->set_theme(settings_.theme);
  sound_.SetVolume(100 * settings_.volume);
  sound_.SetMuted(settings_.mute);
}

void ViewerApp::KeepSettings() {
  try {
    WriteSettings(settings_, settings_file_);
  } catch (const Error& e) {
    Say(e.what());
  }
}

void ViewerApp::EndTourStep(const std::string& action) {
  if (!tour_.is_open()) return;
  tour_.EndStep(action);
  NoteTour();
}

void ViewerApp::RestartTour() {
  if (tour_.is_open()) tour_.Start(activity_->tour());
}

/// Notes in the settings that the tour was shown, once it has ended.
void ViewerApp::NoteTour() {
  if (tour_.is_open() || settings_.tour_shown) return;
  settings_.tour_shown = true;
  KeepSettings();
}

void ViewerApp::Quit() {
  if (!quitting_) quitting_since_s_ = now_s_;
  quitting_ = true;
  End();
}

// ---- a frame

void ViewerApp::Update(double dt_s) {
  FollowSession();
  RunWaiting();
  if (device_ && session_ && began_) FollowDevice(dt_s);
  if (is_running() && began_) {
    if (!steers()) controls_->Release();
    if (controls_->TakeHeldByLock()) Say(Tr("The plane lock holds the saw. L: lock off"));
    controls_->Advance(dt_s, MakeKeyBasis(), figures_.coupled.X_WT, touches());
    session_->SetTarget(controls_->wanted(), controls_->holds());
  }
  FollowSaw(dt_s);
  FollowTurn(dt_s);
  activity_->Update(dt_s);
  UpdateToolInPicture(dt_s);
  if (trace_) trace_.WriteState(MakeState());
}

nlohmann::json ViewerApp::MakeState() const {
  const Vec3& p = figures_.coupled.X_WT.p_AB;
  const auto tenth = [](double v) { return std::round(10 * v) / 10; };
  const auto list = [tenth](const Vec3& v) { return nlohmann::json{tenth(v.x), tenth(v.y), tenth(v.z)}; };
  nlohmann::json state{
      {"running", is_running()},
      {"spindle", spindle_on()},
      {"rpm", figures_.in.rpm},
      {"removed_mm3", tenth(figures_.removed_mm3)},
      {"force_N", tenth(glm::length(figures_.coupled.f_H_W_N))},
      {"saw_mm", {tenth(p.x), tenth(p.y), tenth(p.z)}},
      {"holds", controls_->holds()},
      {"held", held_reason()},
      {"help", help_},
      {"settings", settings_shown_},
      {"entry", dialogs_.asks_text()},
      {"dialog", dialogs_.is_open()},
      {"tour", tour_.step()},
      {"slices_mm", {slices_.offset_mm(0), slices_.offset_mm(1), slices_.offset_mm(2)}},
      {"slice_middles_mm", {list(slices_.middle_W(0)), list(slices_.middle_W(1)), list(slices_.middle_W(2))}},
      {"slice_enlarged", slices_.is_enlarged()},
      {"ct_window_HU", {slices_.window().level_HU, slices_.window().width_HU}},
      {"has_ct", bone_.surface() && bone_.surface()->has_hu()},
      {"colours", LegendTitle(view_->colour_by())},
      {"message", now_s_ < said_until_s_ ? said_ : ""},
      {"warning", now_s_ < warned_until_s_ ? warned_ : ""},
      {"saw_outside", IsSawOutside()},
      {"hub_in_bone", holder_.hub_in_bone()},
      {"turning", is_turning()},
      {"retracting", retracting_},
      {"translucent", view_->translucent()},
      {"view_mm", tenth(view_->camera().height_mm())},
      {"chunks_left", bone_.surface() ? bone_.surface()->counts().first_left : 1}};
  const ScreenBox tool = view_->CalcToolBox();
  state["saw_px"] = {std::round(tool.left), std::round(tool.top), std::round(tool.width), std::round(tool.height)};
  state["scene_px"] = {areas_.scene.left, areas_.scene.top, areas_.scene.width, areas_.scene.height};
  state["legend"] = nlohmann::json::array();
  for (const LegendEntry& entry : view_->legend()) state["legend"].push_back(entry.text);
  if (const auto& released = figures_.released) {
    const Vec3& at = released->p_W_mm;
    state["released"] = {{"saw_mm", {tenth(at.x), tenth(at.y), tenth(at.z)}},
                         {"removed_mm3", tenth(released->removed_mm3)}};
  }
  activity_->Describe(state);
  return state;
}

void ViewerApp::Draw() {
  const auto began = std::chrono::steady_clock::now();
  ui_.BeginFrame(frame_s_);
  ui_.set_tooltips(!dialogs_.is_open() && !help_);
  DrawUi(MakeHud());
  ui_.EndFrame();
  const auto box = [](const UiBox& b) { return ScreenBox{b.left, b.top, b.width, b.height}; };
  // The cube gives way to the tool.
  const ScreenBox tool = is_running() && activity_->cuts() ? view_->CalcToolBox() : ScreenBox{};
  const bool covers = Overlap(areas_.cube, {tool.left, tool.top, tool.width, tool.height});
  view_->SetAreas(box(areas_.scene), covers ? ScreenBox{} : box(areas_.cube));
  FollowPlace();
  const std::uint64_t hash = ui_.CalcFrameHash();
  if (std::exchange(redraws_, false) || view_->has_changed()) frames_to_draw_ = 2;
  if (hash != frame_hash_) frames_to_draw_ = std::max(frames_to_draw_, 1);
  if (frames_to_draw_ > 0) {
    --frames_to_draw_;
    frame_hash_ = hash;
    changed_s_ = now_s_;
    window_.BeginFrame();
    view_->Render();
    window_.Present();
    times_.frame.Add(std::llround(1e9 * SecondsSince(began)));
  }
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
  if (!settings_.tour_shown && !options_.scripted && activity.begins_with_tour()) tour_.Start(activity.tour());
  const auto start = std::chrono::steady_clock::now();
  double last_s = 0;
  double event_s = 0;     // time of the last event
  double may_draw_s = 0;  // time from which on changed panels are drawn while a bone is made
  bool first_picture = false;
  while (!done_) {
    const double spent_s = SecondsSince(start) - now_s_;
    // While a bone is made, draw fewer frames, to leave processor time for it.
    const bool makes_bone = session_ && !is_running() && !goes_on_;
    const bool still = now_s_ > changed_s_ + kSettled_s;
    const double frame_s = makes_bone ? 0.1 : still ? kStillFrame_s : kFrame_s;
    const double wait_s = minimised_ ? 0.05 : std::max(0.0, frame_s - spent_s);
    std::vector<WindowEvent> events = window_.Poll(wait_s);
    // Events end the wait early, also those of a mouse whose motion changes nothing.
    if (const double early_s = kFrame_s - (SecondsSince(start) - now_s_); !events.empty() && early_s > 0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(early_s));
      for (WindowEvent& event : window_.Poll(0)) events.push_back(std::move(event));
    }
    for (const WindowEvent& event : events) Take(event);
    ignores_text_ = false;
    if (options_.interrupt != nullptr && options_.interrupt->load() && !quitting_) Quit();
    now_s_ = SecondsSince(start);
    if (!events.empty()) event_s = now_s_;
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
    // A picture that is drawn by the processor takes much of what the bone needs, and only the progress has changed.
    if (!makes_bone || now_s_ > may_draw_s || now_s_ < event_s + kSettled_s || panel_frames_ > 0 ||
        view_->has_changed()) {
      Draw();
      may_draw_s = now_s_ + std::min(kMaxPause_s, kPauseFactor * (SecondsSince(start) - now_s_));
      TakePictures();
      if (RunPanelKeys()) event_s = now_s_;
    }
    if (!first_picture && bone_.surface() && bone_.surface()->first_done()) {
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

// ---- messages

void ViewerApp::Say(const std::string& message) {
  said_ = message;
  said_until_s_ = now_s_ + kMessage_s;
  trace_.Write("message", {{"text", message}});
}

void ViewerApp::SayAlso(const std::string& message) {
  constexpr double kJustNow_s = 1;
  const bool just_now = said_until_s_ > now_s_ + kMessage_s - kJustNow_s && said_until_s_ <= now_s_ + kMessage_s;
  Say(just_now ? fmt::format("{}\n{}", said_, message) : message);
}

void ViewerApp::Warn(const std::string& warning) {
  warned_ = warning;
  warned_until_s_ = now_s_ + kWarning_s;
  said_until_s_ = 0;
  trace_.Write("message", {{"text", warning}});
}

void ViewerApp::AskText(const std::string& question, const std::string& initial,
                        std::function<void(std::optional<std::string>)> done) {
  controls_->Release();
  ignores_text_ = true;
  dialogs_.AskText(ui_, question, initial, std::move(done));
}

}  // namespace kerf
