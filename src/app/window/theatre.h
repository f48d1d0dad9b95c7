// The operating theatre: window, picture and session together, with all that rehearsing and practising have in common.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/gl_window.h"
#include "app/window/hand_device.h"
#include "app/window/live_session.h"
#include "app/window/saw_controls.h"
#include "app/window/text_entry.h"
#include "app/window/trace.h"
#include "base/core/log_histogram.h"
#include "session/scene/saws.h"
#include "session/scene/scene.h"
#include "view/live/surface_worker.h"
#include "view/live/viewport.h"

namespace kerf {

class FolderLock;

struct TheatreOptions {
  std::string title;                 // of the window
  std::string folder;                // is there; recordings, pictures and bones go there
  std::shared_ptr<FolderLock> lock;  // of the folder; may be null
  std::string log;                   // Trace; empty: none
  int width = 1280;
  int height = 720;
  double scale = 0;       // of words and lines; 0: the display's
  bool scripted = false;  // the scene's own hand goes along its path; the mouse has the view alone
  bool ghost = true;      // where the handle leads the tool it is shown
  const std::atomic<bool>* interrupt = nullptr;  // ends it; may be null
  std::shared_ptr<DeviceServo> device;           // that holds the saw, or moves it; null: mouse and keys alone
};

/// How long frames took to draw, and the surface to follow.
struct FrameTimes {
  LogHistogram frame;  // from beginning to draw to showing
  LogHistogram upload;
};

class Theatre;

/// What is done in the theatre: rehearsing, practising.
class Activity {
 public:
  Activity() = default;
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;
  virtual ~Activity() = default;

  /// Before the theatre's own keys. True: it was for the activity.
  virtual bool Take(const WindowEvent& event) = 0;
  /// Once a frame; `dt_s` since the last.
  virtual void Update(double dt_s) = 0;
  /// What it shows, over what the theatre has filled in.
  virtual void Fill(HudState& hud) = 0;
  /// Its own keys, for the help.
  virtual std::vector<HudKeyGroup> help() const = 0;
  /// The bone is there, in the window's thread.
  virtual void Began() = 0;
  /// The session is over, as was asked or by itself.
  virtual void Ended(LoopSummary summary) = 0;
  /// Of the trace.
  virtual void Describe(nlohmann::json& state) const = 0;
  /// The saw may be moved and switched now.
  virtual bool cuts() const = 0;
};

class Theatre {
 public:
  /// Throws Error where there is no display.
  explicit Theatre(const TheatreOptions& options);
  ~Theatre();
  Theatre(const Theatre&) = delete;
  Theatre& operator=(const Theatre&) = delete;

  /// Until the window is closed. Throws what the activity throws, and Error when a session fails.
  void Run(Activity& activity);
  /// Run() comes back after the session's end.
  void Quit();
  bool quitting() const { return quitting_; }

  // ---- the session
  /// A new one, after the end of the one before. It is recorded as folder/session.kerf, session-2.kerf, ...
  /// `same_bone`: it goes on with the bone that is in the picture, as it was left.
  void Begin(const Scene& scene, const std::string& scene_file, bool same_bone = false);
  /// Activity::Ended() follows.
  void End();
  LiveSession* session() { return session_.get(); }
  bool steers() const;  // the mouse and the keys have the saw
  bool is_running() const { return session_ && session_->stage() == LiveStage::kRunning; }
  const LiveFigures& figures() const { return figures_; }
  const std::string& recording() const { return recording_; }
  int sessions() const { return sessions_; }
  void SetSpindle(bool on);
  bool spindle_on() const;
  /// The curve of the last session, thinned to a point each 20 ms.
  const std::vector<PlotPoint>& forces() const { return forces_; }
  /// As the first session began; null before.
  std::shared_ptr<const Bone> bone_at_start();

  // ---- picture and words
  Viewport& view() { return *view_; }
  SurfaceWorker* surface() { return surface_.get(); }
  SawControls& controls() { return *controls_; }
  ViewBasis MakeBasis() const;
  Trace& trace() { return trace_; }
  const TheatreOptions& options() const { return options_; }
  const FrameTimes& times() const { return times_; }
  /// For some seconds at the bottom.
  void Say(const std::string& message);
  const std::string& said() const { return said_; }
  /// What is being done, over the picture; empty text: nothing.
  void ShowWork(const std::string& title, const std::string& stage, std::optional<double> share);
  void HideWork() { work_.reset(); }
  /// Asks for a line of text; `done` gets it, or nothing when it was left.
  void AskText(const std::string& question, const std::string& preset,
               std::function<void(std::optional<std::string>)> done);
  /// A picture of the window as it is, in the folder; its path.
  std::string TakePicture();
  /// PNG bytes of the picture without panels.
  std::string GrabScene();
  bool slices_shown() const { return slices_shown_; }

 private:
  void Take(const WindowEvent& event);
  bool TakeKey(const WindowEvent& event);
  bool TakeMouse(const WindowEvent& event);
  void LoseFocus(const char* why);
  void Update(double dt_s);
  void FollowSession();
  void FollowDevice(double dt_s);
  void PutToolInPicture(double dt_s);
  void Draw();
  HudState MakeHud();
  nlohmann::json MakeState() const;

  TheatreOptions options_;
  Trace trace_;
  GlWindow window_;
  std::unique_ptr<Viewport> view_;
  Activity* activity_ = nullptr;

  std::optional<HandDevice> device_;
  std::unique_ptr<LiveSession> session_;
  std::mutex mutex_;  // of made_
  struct Made {
    std::shared_ptr<SurfaceWorker> surface;
    MaterialTable materials;
    double voxel_mm = 0.1;
  };
  std::optional<Made> made_;  // by the session's thread, as the next
  std::optional<InnerSurfaces> inner_made_;
  std::shared_ptr<const Bone> at_start_;
  bool real_made_ = false;                    // not only the preview
  std::shared_ptr<SurfaceWorker> leaves_to_;  // the session's thread
  std::shared_ptr<SurfaceWorker> surface_;
  std::unique_ptr<SawControls> controls_;
  LiveFigures figures_;
  Pose X_start_;            // of the saw
  bool returning_ = false;  // it goes there
  std::vector<PlotPoint> forces_;
  std::string recording_;
  int sessions_ = 0;
  bool began_ = false;   // Activity::Began() of this session was called
  bool fitted_ = false;  // the view was, to a bone
  bool fit_again_ = false;
  bool looked_about_ = false;  // somebody has turned the view since

  bool quitting_ = false;
  bool done_ = false;
  bool minimised_ = false;
  bool help_ = false;
  bool slices_shown_ = true;
  bool orbiting_ = false;
  bool panning_ = false;
  double mouse_x_ = 0;
  double mouse_y_ = 0;
  double spin_rad_ = 0;
  int pictures_ = 0;
  std::size_t view_index_ = 0;
  std::string said_;
  double said_until_s_ = 0;
  double now_s_ = 0;
  std::optional<HudProgress> work_;
  std::optional<TextEntry> entry_;
  bool entry_is_new_ = false;  // of the events that are being taken
  std::function<void(std::optional<std::string>)> entry_done_;
  FrameTimes times_;
};

}  // namespace kerf
