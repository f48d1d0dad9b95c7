// A session under way: RunLoop in a thread of its own, seen and steered from the window's.
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

#include "loop/haptics/mouse_hand.h"
#include "session/held_device/hold_tool.h"
#include "session/run/run_loop.h"

namespace kerf {

/// The newest of everything, for drawing.
struct LiveFigures {
  double time_s = 0;
  Pose X_WT;         // the tool
  Pose X_WH;         // where the hand has the handle
  Vec3 f_hand_N{0};  // on the hand, simulated
  double engaged_teeth = 0;
  std::uint64_t changes = 0;  // leaves of the bone that have changed so far, by cuts, undo and redo
  double removed_mm3 = 0;     // so far
  double feed_mm_per_s = 0;   // of the tool's middle, over the last tenth of a second
  double rpm = 0;
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  // deadlines
  std::uint32_t status = 0;
  std::vector<double> channels;  // of the effects
};

/// A point of the force's curve: the largest of some ticks.
struct ForceMoment {
  double time_s = 0;
  double force_N = 0;
};

enum class LiveStage : std::uint8_t { kLoading, kRunning, kEnding, kEnded };

struct LiveOptions {
  std::string record;             // empty: none
  std::string scene_file;         // that the recording names
  bool scripted = false;          // the scene's own hand along its path, with the spindle on; else the mouse's
  DeviceServo* device = nullptr;  // holds the saw in place of the mouse's hand; null: none
  double seconds = kMostLoop_s;
  std::function<void(const LeafMessage&)> leaf;  // of the bone, in the session's thread; may be empty
  /// In the session's thread before all else; may be empty.
  std::function<void()> prepare;
  /// The bone is there, in the session's thread, before the first tick; may be empty.
  std::function<void(const Bone&, const EffectPlan&)> begin;
};

class LiveSession final : private LoopPeer {
 public:
  /// Begins at once.
  LiveSession(Scene scene, LiveOptions options);
  /// Stops and waits.
  ~LiveSession() override;

  // ---- the window's thread
  LiveStage stage() const { return stage_.load(); }
  /// What is being done while loading and ending, and how much of it.
  std::pair<std::string, double> progress() const;
  /// A sentence; empty unless it failed. After kEnded.
  const std::string& failure() const { return failure_; }
  LiveFigures figures() const;
  /// Of the curve, since the last call.
  std::vector<ForceMoment> TakeForces();
  /// What was done or could not be done, since the last call.
  struct Answer {
    LoopAction action;
    std::string failure;  // a sentence; empty when it is done
  };
  std::vector<Answer> TakeAnswers();
  /// What the user is to do with the device, since the last call.
  std::vector<std::string> TakeNotes();
  void SetTarget(const Pose& X_WH) { target_.Publish(X_WH); }
  void Ask(LoopAction action);
  void SetSpindle(double rpm);
  double rpm() const { return rpm_.load(); }
  /// A copy of the bone as it is now.
  std::future<Bone> AskBone();
  const Scene& scene() const { return scene_; }
  /// How near its force law is to what was measured.
  std::string MakeForceNote() const;

  /// The loop ends; stage() says when it has.
  void Stop() { stop_.store(true); }
  /// Waits for the end. Once, after that.
  LoopSummary TakeSummary();

 private:
  void Begin(const LoopBeginning& beginning) override;
  void TakeLeaf(const LeafMessage& leaf) override;
  std::optional<LoopAction> NextAction() override;
  void Done(const LoopAction& action, const std::string& failure) override;
  void TakeTick(const LoopSample& sample, std::span<const double> channels);
  void Run();

  Scene scene_;
  LiveOptions options_;
  HandTarget target_;
  std::atomic<bool> stop_{false};
  std::atomic<LiveStage> stage_{LiveStage::kLoading};
  std::atomic<double> rpm_;
  std::string failure_;
  std::optional<LoopSummary> summary_;
  const Bone* mirror_ = nullptr;  // the session's thread

  mutable std::mutex mutex_;  // of all below
  std::string doing_ = "making the bone";
  double share_ = 0;
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
  std::vector<std::string> notes_;
  std::vector<std::promise<Bone>> bones_asked_;

  std::thread thread_;
};

}  // namespace kerf
