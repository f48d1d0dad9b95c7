// Running session: a LoopSession in a separate thread, observed and controlled by the window's thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "app/window/contact_sums.h"
#include "app/window/progress_meter.h"
#include "app/window/stroke_watch.h"
#include "loop/haptics/mouse_hand.h"
#include "session/held_device/hold_tool.h"
#include "session/link/slicer_link.h"
#include "session/run/overall_progress.h"
#include "session/run/run_loop.h"

namespace kerf {

/// The latest tick, and sums over all ticks, for drawing.
struct LiveFigures : LoopTick, ContactSums {
  std::uint64_t changes = 0;            // leaves of the bone changed so far, by cuts, undo and redo
  double removed_mm3 = 0;               // total so far
  double feed_mm_per_s = 0;             // speed of the tool's centre, mean of the last tenth of a second
  std::uint64_t missed = 0;             // number of missed deadlines
  std::vector<double> channels;         // channels of the effects
  std::optional<double> guide_force_N;  // force of the guide on the tool; none: no guide
  /// Forces of the bone on a disc's hub, and on all that holds the tool with it; none: it meets no resistance.
  std::optional<double> hub_force_N, holder_force_N;
  std::optional<double> metal_touch_s;  // time of the last tick in which the turning saw rested on metal; none: never
  std::optional<double> tooth_cut_s;    // time of the last tick in which the saw cut a tooth of the bone; none: never
  /// Where the tool was, and what had been removed, in the tick in which the hand let go of it or was moved without
  /// holding it.
  struct Release {
    Vec3 p_W_mm{0};
    double removed_mm3 = 0;
  };
  std::optional<Release> released;  // none while a hand holds the tool
};

/// Point of the force curve: the maximum over several ticks.
struct ForceMoment {
  double time_s = 0;
  double force_N = 0;
};

enum class LiveStage : std::uint8_t { kLoading, kRunning, kEnding, kEnded };

struct LiveOptions {
  std::string record;             // file of the recording; empty: none
  std::string scene_file;         // scene file named in the recording
  bool scripted = false;          // the scene's hand follows its path, spindle on; otherwise the mouse moves the saw
  DeviceServo* device = nullptr;  // holds the saw in place of the mouse; null: none
  SlicerLink* link = nullptr;     // shows the session elsewhere; null: none
  double seconds = kMaxLoop_s;
  std::function<void(const LoopTick&)> tick;     // each tick in order, called in the session's thread; optional
  std::shared_ptr<const Bone> bone;              // of the scene, which is then neither read nor made; optional
  std::function<void(const LeafMessage&)> leaf;  // changed leaves of the bone, called in the session's thread; optional
  /// Called in the session's thread before everything else; optional. Must pass on the exceptions of its argument,
  /// which receives the progress.
  std::function<void(const std::function<void(double)>&)> prepare;
  /// Called in the session's thread when the bone is ready, before the first tick; optional.
  std::function<void(const Bone&, const EffectPlan&)> begin;
};

class LiveSession final : private SessionController {
 public:
  /// Starts the session immediately.
  LiveSession(Scene scene, LiveOptions options);
  /// Stops the session and waits for its end, while it is loading until the next report of its progress.
  ~LiveSession() override;

  // ---- window's thread
  LiveStage stage() const { return stage_.load(); }
  /// Returns the work in progress while loading or ending.
  WorkProgress progress() const;
  /// Returns the error message; empty unless the session failed. Valid after kEnded.
  const std::string& failure() const { return failure_; }
  /// Returns true if the session was stopped before the first tick: it then has no summary and no recording. Valid
  /// after kEnded.
  bool cancelled() const { return cancelled_; }
  LiveFigures figures() const;
  /// Returns the points of the force curve since the last call.
  std::vector<ForceMoment> TakeForces();
  /// Result of a requested action. TakeAnswers() returns those since the last call.
  struct Answer {
    LoopAction action;
    std::string failure;                 // error message; empty on success
    std::optional<double> restored_mm3;  // see SessionController::Done()
  };
  std::vector<Answer> TakeAnswers();
  /// Returns the instructions for the user about the device since the last call.
  std::vector<std::string> TakeNotes();
  /// Sets the pose towards which the user moves the saw. `holds`: false if the user has let go of it.
  void SetTarget(const Pose& X_WH, bool holds) { target_.Publish({X_WH, holds}); }
  void Ask(LoopAction action);
  /// True from the request of an undo, a redo or a retraction, which move the saw, until TakeAnswers() returns its
  /// answer.
  bool moves_saw() const { return moves_asked_ > 0; }
  void SetSpindle(double rpm);
  double rpm() const { return rpm_.load(); }
  /// Requests a copy of the current bone.
  std::future<Bone> AskBone();
  const Scene& scene() const { return scene_; }
  /// Returns the normal of the guide's plane, unit length; meaningless without a guide.
  const Vec3& guide_normal_W() const { return guide_normal_W_; }
  /// Returns a note on the force: whether the present bite has been measured, or that the force is not from bone.
  struct ForceNote {
    std::string text;     // a sentence in plain words, in the window's language; empty while nothing is cut
    std::string details;  // law, factors and bite
  };
  ForceNote MakeForceNote(const LiveFigures& figures) const;
  static ForceNote MakeForceNote(const Scene& scene, const LiveFigures& figures);

  /// Requests the end of the loop, or of loading; stage() reports when it has ended.
  void Stop() { stop_.store(true); }
  /// Returns true if TakeSummary() has a result. Valid after kEnded.
  bool has_summary() const { return summary_.has_value(); }
  /// Waits for the end. Must be called at most once, and not if cancelled().
  LoopSummary TakeSummary();

 private:
  void Begin(const LoopInitialState& beginning) override;
  void TakeLeaf(const LeafMessage& leaf) override;
  std::optional<LoopAction> NextAction() override;
  void Done(const LoopAction& action, const std::string& failure, std::optional<double> restored_mm3) override;
  void TakeTick(const LoopTick& tick, std::span<const double> channels);
  void Run();
  void Report(const std::string& stage, double fraction);

  Scene scene_;
  LiveOptions options_;
  HandTarget target_;
  std::atomic<bool> stop_{false};
  std::atomic<LiveStage> stage_{LiveStage::kLoading};
  std::atomic<double> rpm_;
  std::string failure_;
  bool cancelled_ = false;
  std::optional<LoopSummary> summary_;
  const Bone* mirror_ = nullptr;               // used only by the session's thread
  std::optional<std::size_t> guide_channel_;   // of the guide's force; used only by the session's thread
  std::optional<std::size_t> holder_channel_;  // first of the handpiece's; likewise
  Vec3 guide_normal_W_{0, 0, 1};               // set before kRunning
  std::vector<int> teeth_;                     // regions; used only by the session's thread
  StrokeWatch stroke_;                         // used only by the session's thread

  mutable std::mutex mutex_;  // protects everything below
  OverallProgress loading_;
  ProgressMeter progress_;
  std::string working_on_;
  LiveFigures figures_;
  struct Place {
    double time_s;
    Vec3 p_W_mm;
  };
  std::deque<Place> places_;  // of the last tenth of a second
  std::vector<ForceMoment> forces_;
  ForceMoment moment_;
  int in_moment_ = 0;
  std::deque<LoopAction> asked_;
  std::vector<Answer> answers_;
  int moves_asked_ = 0;  // used only by the window's thread
  std::vector<std::string> notes_;
  std::vector<std::promise<Bone>> bones_asked_;

  std::thread thread_;
};

}  // namespace kerf
