// Base of the window applications: window, picture and session, and everything that rehearsing and practising share.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/actions.h"
#include "app/window/activity.h"
#include "app/window/beeper.h"
#include "app/window/camera_mouse.h"
#include "app/window/dialogs.h"
#include "app/window/gl_window.h"
#include "app/window/hand_device.h"
#include "app/window/held_saw.h"
#include "app/window/holder_watch.h"
#include "app/window/live_session.h"
#include "app/window/saw_controls.h"
#include "app/window/saw_turn.h"
#include "app/window/settings.h"
#include "app/window/shown_bone.h"
#include "app/window/slices_panel.h"
#include "app/window/tour.h"
#include "app/window/trace.h"
#include "base/core/log_histogram.h"
#include "session/scene/saws.h"
#include "session/scene/scene.h"
#include "session/watch/cut_watch.h"
#include "view/live/cut_place.h"
#include "view/live/nearest.h"
#include "view/live/surface_worker.h"
#include "view/live/viewport.h"
#include "view/ui/panels.h"
#include "view/ui/picture_marks.h"
#include "view/ui/translate.h"
#include "view/ui/ui.h"

namespace kerf {

class FolderLock;

struct ViewerOptions {
  std::string title;                 // title of the window
  std::string folder;                // existing folder for recordings, pictures and bones
  std::shared_ptr<FolderLock> lock;  // lock of the folder; optional
  std::string log;                   // file of the Trace; empty: none
  int width = 1280;
  int height = 720;
  double scale = 0;       // scale of text and lines; 0: that of the display
  bool scripted = false;  // the scene's own hand follows its path; the mouse controls only the view
  bool watch = false;     // watches planned planes and pieces that come free: cut_watch()
  bool ghost = true;      // shows the handle of a coupled simulation
  const std::atomic<bool>* interrupt = nullptr;  // ends the program if set; optional
  std::shared_ptr<DeviceServo> device;           // device that holds or moves the saw; null: only mouse and keys
  std::shared_ptr<SlicerLink> link;              // shows the session elsewhere; null: none
};

/// Durations of drawing frames and of updating the surface.
struct FrameTimes {
  LogHistogram frame;  // from the beginning of drawing to presenting
  LogHistogram upload;
};

class ViewerApp {
 public:
  /// Throws Error if there is no display.
  explicit ViewerApp(const ViewerOptions& options);
  ~ViewerApp();
  ViewerApp(const ViewerApp&) = delete;
  ViewerApp& operator=(const ViewerApp&) = delete;

  /// Runs until the window is closed. Throws the activity's errors, and Error if a session fails.
  void Run(Activity& activity);
  /// Makes Run() return after the session has ended.
  void Quit();
  bool quitting() const { return quitting_; }
  /// Valid after Run(): true if a step of loading could not be interrupted and is still running. The destructor waits
  /// for it; the program may end at once instead.
  bool left_work() const { return left_work_; }

  // ---- the session
  /// Begins a new session after the end of the previous one. It is recorded as folder/session.kerf, session-2.kerf, ...
  /// `same_bone`: true if the session continues with the bone that is shown. `bone`: that of the scene, which is then
  /// neither made nor read from its file, which need not exist yet; null if it is to be made or read.
  void Begin(const Scene& scene, const std::string& scene_file, bool same_bone = false,
             std::shared_ptr<const Bone> bone = nullptr);
  /// Sets a function that the next session calls with each tick, in the session's thread.
  void set_take_tick(std::function<void(const LoopTick&)> take) { take_tick_ = std::move(take); }
  /// The same for each leaf of the bone that has changed, in another thread of the session.
  void set_take_leaf(std::function<void(const LeafMessage&)> take) { take_leaf_ = std::move(take); }
  /// Ends the session; Activity::Ended() follows, or Cancelled() if its bone was not ready yet.
  void End();
  /// Removes the bone and everything else from the picture. Call it only without a session.
  void Clear();
  /// Returns the work in progress while a session is loading or ending.
  std::optional<WorkProgress> progress() const;
  LiveSession* session() { return session_.get(); }
  bool steers() const;   // mouse and keys control the saw
  bool touches() const;  // a force acts on the saw
  /// Turns the saw to the last pose of a way, as the hand would. Until it is there, or cannot get there, the spindle
  /// does not start and the keys and buttons of disabled actions wait. `way`: corners of the way to it; not empty.
  void TurnSaw(std::vector<Pose> way);
  bool is_turning() const { return turn_.is_turning(); }
  /// Returns true while the saw is brought back into view.
  bool is_retracting() const { return retracting_; }
  /// Returns why the saw does not follow the hand and what to do about it; empty if it follows.
  std::string held_reason() const;
  Beeper& sound() { return sound_; }
  bool is_running() const { return session_ && session_->stage() == LiveStage::kRunning; }
  const LiveFigures& figures() const { return figures_; }
  /// Returns where what holds the blade was inside the bone during the cuts of the last session.
  const HolderPlaces& holder_places() const { return holder_.places(); }
  const std::string& recording() const { return recording_; }
  int sessions() const { return sessions_; }
  void SetSpindle(bool on);
  bool spindle_on() const;
  /// Force curve of the last session, thinned to one point per 20 ms.
  const std::vector<PlotPoint>& forces() const { return forces_; }
  /// Returns the bone at the start of the first session; null before that.
  std::shared_ptr<const Bone> bone_at_start() const { return bone_.at_start(); }
  /// Returns the watch of the bone; null before the bone is ready, and if the options do not ask for it.
  std::shared_ptr<CutWatch> cut_watch();

  // ---- picture and text
  Viewport& view() { return *view_; }
  /// Returns the bone that is shown. A bone can be shown before its session begins; if it is final, the session begins
  /// with it (`same_bone`).
  ShownBone& bone() { return bone_; }
  SawControls& controls() { return *controls_; }
  /// Requests the lines in which planes meet the bone; renewed while it is cut. Called once per frame.
  void RequestPlaneLines(const std::vector<PlaneOverlay>& planes);
  void HidePlaneLines();
  SlicesPanel& slices() { return slices_; }
  const std::vector<PlaneOverlay>& lined_planes() const { return lined_planes_; }
  ViewBasis MakeBasis() const;
  /// Returns the directions in which keys and mouse move the saw.
  ViewBasis MakeKeyBasis() const { return activity_->MakeKeyBasis(MakeBasis()); }
  Trace& trace() { return trace_; }
  const ViewerOptions& options() const { return options_; }
  /// Shows a message at the bottom for some seconds.
  void Say(const std::string& message);
  /// The same, but below a message that was shown within the last second, which the user could not yet read.
  void SayAlso(const std::string& message);
  /// The same for a warning, which Say() does not replace.
  void Warn(const std::string& warning);
  /// Asks for a line of text. `done` receives it, or nullopt if the input was cancelled.
  void AskText(const std::string& question, const std::string& initial,
               std::function<void(std::optional<std::string>)> done);
  Dialogs& dialogs() { return dialogs_; }
  Ui& ui() { return ui_; }
  ActionList& actions() { return actions_; }
  const UiAreas& areas() const { return areas_; }
  /// Sets the whole CT of the bone, which the slices show; an empty function: none.
  void ShowCt(CtSource ct);
  /// Sets the bone with which the cuts of the next session are compared; null: its bone at the start.
  void set_original(std::shared_ptr<const Bone> bone) { original_ = std::move(bone); }
  /// Returns the bone before all cuts, also those of sessions before; null before the first session.
  std::shared_ptr<const Bone> uncut_bone() const { return original_ ? original_ : bone_.at_start(); }
  /// Shows points, and the tool while it cuts, in the part of the scene that `free` returns for the area between the
  /// panels. Does so again when that part changes or the tool leaves it, until the user turns, shifts or zooms the
  /// view.
  struct ShownPlace {
    std::vector<Vec3> points_W;
    std::function<UiBox(const UiBox& scene)> free;
  };
  void ShowPlace(ShownPlace place);
  /// Shows the bone uncut again, as at the start, for another session on the same bone.
  void ShowUncut();
  /// Keeps the camera as it is when a bone is shown that was not yet complete.
  void KeepView() { view_changed_ = true; }
  WindowSettings& settings() { return settings_; }
  void KeepSettings();
  /// Says what the user has done, which ends a step of the tour: TourStep::action.
  void EndTourStep(const std::string& action);
  /// Begins an open tour again, with the steps of the activity's present state.
  void RestartTour();
  bool is_in_tour() const { return tour_.is_open(); }
  /// Returns a picture of the whole bone from the current direction, as PNG bytes: bright and in the middle, without
  /// panels, but with labels and a scale bar. Labels keep clear of the places `clear_W`, if possible. Call it between
  /// two frames.
  std::string GrabScene(const std::vector<Vec3>& clear_W);

 private:
  void ApplySettings();
  void Take(const WindowEvent& event);
  void AddActions();
  void AddLastActions();
  bool WaitsForSession(const WindowEvent& event) const;
  void RunWaiting();
  bool RunPanelKeys();
  void LookNext(int by);
  void ToggleHelp();
  void TakeInScene(const WindowEvent& event);
  void AskToQuit();
  void NoteTour();
  void Retract();
  void FollowTurn(double dt_s);
  void TurnOn();
  std::string ForgetWaiting();
  bool waits() const { return activity_->is_restarting() || is_turning(); }
  bool IsSawOutside() const;
  void ShowSaw();
  std::string DescribeStaying() const;
  std::string DescribeHolder() const;
  /// Returns true if this warning is shown.
  bool is_warning(const std::string& text) const { return now_s_ < warned_until_s_ && warned_ == text; }
  void LoseFocus(const char* why);
  void Update(double dt_s);
  void FollowSession();
  void FollowRunning();
  void ShowAnswer(const LiveSession::Answer& answer);
  void TakeForces();
  void TakeBone(bool at_once = false);
  void FollowBone();
  void FollowDevice(double dt_s);
  void FollowSaw(double dt_s);
  void FollowPlace();
  void UpdateToolInPicture(double dt_s);
  void UpdateCutInPicture(const Tool& tool, double dt_s);  // contact, dust, alarms, lines of planes
  void Draw();
  void TakePictures();
  HudState MakeHud();
  std::vector<HudKeyGroup> ListHelp() const;
  void DrawUi(const HudState& hud);
  PictureMarks MakePictureMarks() const;
  UiBox CalcBox(const std::vector<Vec3>& points_W) const;
  static std::vector<std::string> ListStatusTexts(const HudStatus& status);
  void DrawStatusTexts(const HudStatus& status, float left);
  SliceScene MakeSliceScene() const;
  nlohmann::json MakeState() const;

  ViewerOptions options_;
  Trace trace_;
  GlWindow window_;
  WindowSettings settings_;
  std::string settings_file_;
  Ui ui_;
  Dialogs dialogs_;
  Tour tour_;
  ActionList actions_;
  std::unique_ptr<Viewport> view_;
  ShownBone bone_;
  Activity* activity_ = nullptr;

  Beeper sound_;
  HeldSawWatch held_saw_;
  SawTurn turn_;
  std::vector<Pose> turn_way_;  // corners after the goal of turn_, the next one last
  bool retracting_ = false;
  std::optional<HandDevice> device_;
  std::unique_ptr<LiveSession> session_;
  std::shared_ptr<const Bone> original_;
  mutable std::mutex mutex_;                      // protects watch_
  std::shared_ptr<CutWatch> watch_;               // set by the session's thread
  std::shared_ptr<SurfaceWorker> leaf_receiver_;  // used by the session's thread
  std::shared_ptr<CutWatch> leaf_watch_;          // the same
  std::unique_ptr<SawControls> controls_;
  LiveFigures figures_;
  CutPlace cut_place_;
  HolderWatch holder_;            // compared with the bone with which the session began
  bool holds_in_bone_ = false;    // DescribeHolder() was not empty then
  std::optional<Pose> X_holder_;  // pose at which it was last compared
  double shown_removed_mm3_ = 0;  // volume that has become dust in the picture
  std::optional<Pose> X_home_;    // pose of the saw at the start of the first session with this bone
  std::vector<PlotPoint> forces_;
  std::string recording_;
  std::function<void(const LeafMessage&)> take_leaf_;  // of the next session
  std::function<void(const LoopTick&)> take_tick_;     // of the next session
  int sessions_ = 0;
  bool goes_on_ = false;  // this session continues with the bone of the one before
  bool began_ = false;    // Activity::Began() of this session was called
  bool fitted_ = false;   // the view was fitted to a bone
  bool fit_again_ = false;
  bool view_changed_ = false;              // the user has changed the view since
  std::optional<ShownPlace> shown_place_;  // none: the view is chosen by the user, or fitted to the bone
  UiBox shown_in_;                         // part of the scene in which it is shown
  Box3 fitted_bounds_W_;                   // of that bone
  int panel_frames_ = 0;                   // frames until the panels have noticed a click or Tab
  unsigned int left_field_ = 0;            // field that had the input when Tab was pressed; 0: after a click
  std::vector<WindowEvent> panel_keys_;    // pressed meanwhile, for a text field; and the mouse after them
  std::vector<WindowEvent> waiting_;       // keys and clicks while a session restarted, for the next one

  bool quitting_ = false;
  double quitting_since_s_ = 0;
  bool left_work_ = false;
  bool done_ = false;
  bool minimised_ = false;
  bool help_ = false;
  bool settings_shown_ = false;
  bool values_shown_ = true;  // the left column
  bool slices_lack_room_ = false;
  bool slices_shown_ = true;
  SlicesPanel slices_;
  std::optional<std::uint64_t> sliced_changes_;  // changes to the bone when slices were last requested; none: not yet
  double sliced_s_ = 0;
  std::vector<PlaneOverlay> lined_planes_;
  std::uint64_t lined_changes_ = 0;
  double lined_s_ = 0;
  UiAreas areas_;
  HudState values_before_;         // what the left column showed before a session restarted
  std::optional<int> picked_row_;  // row of the activity's list that was clicked in this frame
  std::vector<Language> languages_;
  enum class MouseOwner { kNone, kPanels, kScene };
  MouseOwner mouse_owner_ = MouseOwner::kNone;  // who received the button that is held
  ScreenPoint pressed_at_;
  bool moved_since_press_ = false;
  CameraMouse camera_mouse_;
  double spin_rad_ = 0;
  int pictures_ = 0;
  int pictures_asked_ = 0;  // to be taken once the window has been drawn
  int drawn_frames_ = 0;    // since the start of the program, up to kFirstFrames
  std::size_t view_index_ = 0;
  std::string seen_from_;  // message of the last view that was chosen
  std::string said_;
  double said_until_s_ = 0;
  std::string warned_;
  double warned_until_s_ = 0;
  double now_s_ = 0;
  double frame_s_ = 1.0 / 60;
  bool ignores_text_ = false;     // the character of a key that has just opened a text field
  bool redraws_ = true;           // the next frame is drawn even if nothing seems to have changed
  int frames_to_draw_ = 0;        // the scene may take two frames to settle
  std::uint64_t frame_hash_ = 0;  // of the panels that were last drawn
  double changed_s_ = 0;          // time of the last frame that was drawn
  nlohmann::json noted_;          // places of buttons that were last written to the trace
  FrameTimes times_;
};

}  // namespace kerf
