// Base of the window applications: window, picture and session, and everything that rehearsing and practising share.
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/actions.h"
#include "app/window/beeper.h"
#include "app/window/dialogs.h"
#include "app/window/gl_window.h"
#include "app/window/hand_device.h"
#include "app/window/held_saw.h"
#include "app/window/live_session.h"
#include "app/window/saw_controls.h"
#include "app/window/settings.h"
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
};

/// Durations of drawing frames and of updating the surface.
struct FrameTimes {
  LogHistogram frame;  // from the beginning of drawing to presenting
  LogHistogram upload;
};

class ViewerApp;

/// Activity in the viewer: rehearsing or practising.
class Activity {
 public:
  Activity() = default;
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;
  virtual ~Activity() = default;

  /// Adds the activity's actions, once, before the first frame.
  virtual void AddActions(ActionList& actions) = 0;
  /// Called before the viewer handles the event. Returns true if the event was for the activity.
  virtual bool Take(const WindowEvent& event) = 0;
  /// Called once per frame; `dt_s`: time since the last frame.
  virtual void Update(double dt_s) = 0;
  /// Adds the activity's contents to what the viewer has already filled in.
  virtual void Fill(HudState& hud) = 0;
  /// Called when a row of the activity's list was clicked.
  virtual void PickMenuRow(int row) = 0;
  virtual void PickPieceRow(int /*row*/) {}
  /// Takes a point that was clicked in a slice. Returns false if it is not needed.
  virtual bool TakeSlicePoint(const Vec3& /*p_W*/) { return false; }
  /// Returns false if the activity has no use for slices.
  virtual bool has_slices() const { return false; }
  /// Adds alarms to those of the bone's own nerve canal.
  virtual void AddAlarms(std::vector<AlarmOverlay>& /*alarms*/) {}
  /// Adds what else is drawn in slices.
  virtual void FillSlices(SliceScene& /*scene*/) const {}
  /// Adds the activity's own sections to the left column, and its own windows.
  virtual void DrawSections(Ui& /*ui*/) {}
  virtual void DrawWindows(Ui& /*ui*/) {}
  /// Called for a right click in the picture without a drag.
  virtual void OpenContextMenu(const ScreenPoint& /*at*/) {}
  /// Opens a file or folder that was dropped into the window.
  virtual void Open(const std::string& path) = 0;
  /// Returns true if Escape ends something of the activity.
  virtual bool takes_escape() const { return false; }
  /// Returns what would be lost at the end, as a sentence; empty: nothing.
  virtual std::string DescribeUnsaved() const { return {}; }
  /// Saves that. Returns false if the user has to decide something first.
  virtual void Save() {}
  /// Cancels what is in progress.
  virtual void Cancel() {}
  /// Returns the steps of the first-run tour.
  virtual std::vector<TourStep> tour() const { return {}; }
  /// Returns the mouse's and the held keys' functions that are not actions, for the help.
  virtual std::vector<HudKeyGroup> help() const { return {}; }
  /// Called when the bone is ready, in the window's thread.
  virtual void Began() = 0;
  /// Called when the session has ended, whether or not this was requested.
  virtual void Ended(LoopSummary summary) = 0;
  /// Called when the session was cancelled before its bone was ready.
  virtual void Cancelled() {}
  /// Called when the session failed. Returns true if the window stays open.
  virtual bool TakeFailure(const std::string& /*sentence*/) { return false; }
  /// Adds the activity's state to the trace.
  virtual void Describe(nlohmann::json& state) const = 0;
  /// Returns true if the saw may be moved and switched now.
  virtual bool cuts() const = 0;
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
  /// `same_bone`: true if the session continues with the bone that is shown. `bone`: the content of the scene's bone
  /// file, which is then not read and need not exist yet; null if it is to be read.
  void Begin(const Scene& scene, const std::string& scene_file, bool same_bone = false,
             std::shared_ptr<const Bone> bone = nullptr);
  /// Sets a function that the next session calls with each tick, in the session's thread.
  void set_take_tick(std::function<void(const LoopTick&)> take) { take_tick_ = std::move(take); }
  /// Ends the session; Activity::Ended() follows, or Cancelled() if its bone was not ready yet.
  void End();
  /// Shows a bone before its session begins. May be called by any thread. `final`: the session begins with this bone
  /// (`same_bone`); otherwise it is a preview, which the session's bone replaces.
  std::shared_ptr<SurfaceWorker> ShowBone(std::shared_ptr<const Bone> bone, bool final);
  /// Removes the bone and everything else from the picture. Call it only without a session.
  void Clear();
  /// Returns the work in progress while a session is loading or ending.
  std::optional<WorkProgress> progress() const;
  LiveSession* session() { return session_.get(); }
  bool steers() const;   // mouse and keys control the saw
  bool touches() const;  // a force acts on the saw
  /// Returns why the saw does not follow the hand and what to do about it; empty if it follows.
  std::string held_reason() const;
  Beeper& sound() { return sound_; }
  bool is_running() const { return session_ && session_->stage() == LiveStage::kRunning; }
  const LiveFigures& figures() const { return figures_; }
  const std::string& recording() const { return recording_; }
  int sessions() const { return sessions_; }
  void SetSpindle(bool on);
  bool spindle_on() const;
  /// Force curve of the last session, thinned to one point per 20 ms.
  const std::vector<PlotPoint>& forces() const { return forces_; }
  /// Returns the bone at the start of the first session; null before that.
  std::shared_ptr<const Bone> bone_at_start();
  /// Returns the watch of the bone; null before the bone is ready, and if the options do not ask for it.
  std::shared_ptr<CutWatch> cut_watch();

  // ---- picture and text
  Viewport& view() { return *view_; }
  SurfaceWorker* surface() { return surface_.get(); }
  SawControls& controls() { return *controls_; }
  /// Requests the lines in which planes meet the bone; renewed while it is cut. Called once per frame.
  void RequestPlaneLines(const std::vector<PlaneOverlay>& planes);
  void HidePlaneLines();
  const std::vector<PlaneOverlay>& lined_planes() const { return lined_planes_; }
  ViewBasis MakeBasis() const;
  Trace& trace() { return trace_; }
  const ViewerOptions& options() const { return options_; }
  const FrameTimes& times() const { return times_; }
  /// Shows a message at the bottom for some seconds.
  void Say(const std::string& message);
  const std::string& said() const { return said_; }
  /// Asks for a line of text. `done` receives it, or nullopt if the input was cancelled.
  void AskText(const std::string& question, const std::string& initial,
               std::function<void(std::optional<std::string>)> done);
  Dialogs& dialogs() { return dialogs_; }
  Ui& ui() { return ui_; }
  ActionList& actions() { return actions_; }
  const UiAreas& areas() const { return areas_; }
  /// Sets the bone with which the cuts of the next session are compared; null: its bone at the start.
  void set_original(std::shared_ptr<const Bone> bone) { original_ = std::move(bone); }
  /// Keeps the camera as it is when a bone is shown that was not yet complete.
  void KeepView() { view_changed_ = true; }
  WindowSettings& settings() { return settings_; }
  void KeepSettings();
  /// Writes a picture of the window to the folder. Returns its path.
  std::string TakePicture();
  /// Returns the picture without panels as PNG bytes.
  std::string GrabScene();

 private:
  void Take(const WindowEvent& event);
  void AddActions();
  void AddLastActions();
  void LookNext(int by);
  void ToggleHelp();
  void TakeInScene(const WindowEvent& event);
  bool TakeMouse(const WindowEvent& event);
  void AskToQuit();
  void Retract();
  void LetGo();
  void LoseFocus(const char* why);
  void Update(double dt_s);
  void TakeMade();
  void FollowSession();
  void FollowRunning();
  void FollowDevice(double dt_s);
  void FollowSaw(double dt_s);
  void UpdateToolInPicture(double dt_s);
  void UpdateCutInPicture(const Tool& tool, double dt_s);  // contact, dust, alarms, lines of planes
  void Draw();
  HudState MakeHud();
  std::vector<HudKeyGroup> ListHelp() const;
  void DrawUi(const HudState& hud);
  void DrawSettings();
  void DrawStatusTexts(const HudStatus& status);
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
  Activity* activity_ = nullptr;

  Beeper sound_;
  bool said_no_sound_ = false;
  HeldSawWatch held_saw_;
  std::optional<HandDevice> device_;
  std::unique_ptr<LiveSession> session_;
  mutable std::mutex mutex_;  // protects made_, at_start_ and watch_
  struct Made {
    std::shared_ptr<SurfaceWorker> surface;
    std::shared_ptr<const Bone> bone;  // to make the inner surfaces of; null for a preview
    MaterialTable materials;
    double voxel_mm = 0.1;
  };
  std::optional<Made> made_;  // set by another thread, like the next two
  std::shared_ptr<const Bone> at_start_;
  std::shared_ptr<const Bone> original_;
  std::shared_ptr<CutWatch> watch_;
  std::future<InnerSurfaces> making_inner_;
  std::vector<std::future<InnerSurfaces>> unused_inner_;  // of earlier bones; end by themselves
  std::shared_ptr<SurfaceWorker> leaf_receiver_;          // used by the session's thread
  std::shared_ptr<CutWatch> leaf_watch_;                  // the same
  std::shared_ptr<SurfaceWorker> surface_;
  std::shared_ptr<const InnerSurfaces> inner_;  // of the bone in `surface_`; null until they are made
  std::unique_ptr<SawControls> controls_;
  LiveFigures figures_;
  CutPlace cut_place_;
  double shown_removed_mm3_ = 0;  // volume that has become dust in the picture
  Pose X_start_;                  // pose of the saw at the start
  bool start_is_clear_ = true;    // the start is outside the bone
  bool returning_ = false;        // the saw is returning to that pose
  std::vector<PlotPoint> forces_;
  std::string recording_;
  std::function<void(const LoopTick&)> take_tick_;  // of the next session
  int sessions_ = 0;
  bool goes_on_ = false;  // this session continues with the bone of the one before
  bool began_ = false;    // Activity::Began() of this session was called
  bool fitted_ = false;   // the view was fitted to a bone
  bool fit_again_ = false;
  bool view_changed_ = false;  // the user has changed the view since

  bool quitting_ = false;
  double quitting_since_s_ = 0;
  bool left_work_ = false;
  bool done_ = false;
  bool minimised_ = false;
  bool help_ = false;
  bool settings_shown_ = false;
  bool values_shown_ = true;  // the left column
  bool slices_shown_ = true;
  SlicesPanel slices_;
  std::uint64_t sliced_changes_ = 0;  // number of changes to the bone when slices and lines were last requested
  double sliced_s_ = 0;
  std::vector<PlaneOverlay> lined_planes_;
  std::uint64_t lined_changes_ = 0;
  double lined_s_ = 0;
  UiAreas areas_;
  std::optional<int> picked_row_;  // row of the activity's list that was clicked in this frame
  std::vector<Language> languages_;
  enum class MouseOwner { kNone, kPanels, kScene };
  MouseOwner mouse_owner_ = MouseOwner::kNone;  // who received the button that is held
  ScreenPoint pressed_at_;
  bool moved_since_press_ = false;
  bool orbiting_ = false;
  bool panning_ = false;
  double mouse_x_ = 0;
  double mouse_y_ = 0;
  double spin_rad_ = 0;
  int pictures_ = 0;
  std::size_t view_index_ = 0;
  std::string said_;
  double said_until_s_ = 0;
  std::string staying_;  // message that stays while its cause lasts
  double now_s_ = 0;
  double frame_s_ = 1.0 / 60;
  bool ignores_text_ = false;  // the character of a key that has just opened a text field
  nlohmann::json noted_;       // places of buttons that were last written to the trace
  FrameTimes times_;
};

}  // namespace kerf
