// An exercise that is done with keys alone: the saw follows the feed of the keys. Headless and in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <glm/geometric.hpp>
#include <memory>

#include "app/window/saw_controls.h"
#include "loop/haptics/mouse_hand.h"
#include "session/plan/plan.h"
#include "session/practise/exercises.h"
#include "session/run/run_loop.h"
#include "session/score/feed_meter.h"

namespace kerf {
namespace {

constexpr double kFrame_s = 1.0 / 60;
/// Time for which Down is held at the depth stop, so that the saw presses with the greatest force.
constexpr double kPress_s = 4;

/// Holds Down until the saw presses against the depth stop, and then Right, too, to the end of the line.
class KeyHand final : public HandDriver {
 public:
  KeyHand(SimulatedDevice& device, const Vec3& p_TC_mm, const WantedCut& cut, const Pose& X_start, double feed_mm_per_s,
          std::atomic<bool>& done)
      : cut_(cut), controls_(X_start), hand_(device, target_, X_start, p_TC_mm), X_WT_(X_start), done_(done) {
    controls_.set_feed_mm_per_s(feed_mm_per_s);
    controls_.set_in_blade_plane(true);
    controls_.set_lock_plane(cut.plane());
  }

  void Advance(double dt_s) noexcept override {
    time_s_ += dt_s;
    if (time_s_ >= next_frame_s_) {
      next_frame_s_ += kFrame_s;
      PressKeys();
      controls_.Advance(kFrame_s, view_, X_WT_, touches_);
      target_.Publish({.X_WH = controls_.wanted(), .holds = controls_.holds()});
    }
    hand_.Advance(dt_s);
  }
  void Follow(const Pose& X_WT, bool touches, bool turns) noexcept override {
    X_WT_ = X_WT;
    touches_ = touches;
    hand_.Follow(X_WT, touches, turns);
  }
  bool holds() const noexcept override { return hand_.holds(); }

 private:
  void Press(Key key) {
    WindowEvent event;
    event.kind = WindowEvent::Kind::kKeyDown;
    event.key = key;
    controls_.Take(event, view_);
  }
  void PressKeys() {
    const Vec3 p = cut_.ToCut(X_WT_.p_AB);
    Press(Key::kDown);
    if (p.y + cut_.radius_mm < cut_.depth_mm - 0.15) deep_s_ = time_s_;
    if (time_s_ > deep_s_ + kPress_s) Press(Key::kRight);
    if (p.x > cut_.length_mm) done_ = true;
  }

  WantedCut cut_;
  ViewBasis view_ = AlignWithCut({.right_W = cut_.along_W}, cut_.along_W, cut_.into_W);
  SawControls controls_;
  HandTarget target_;
  MouseHand hand_;
  Pose X_WT_;
  bool touches_ = false;
  double time_s_ = 0;
  double next_frame_s_ = 0;
  double deep_s_ = 0;  // when the saw was last above the depth
  std::atomic<bool>& done_;
};

// Pressing down does not slow the motion along the line: the second exercise can be done with the arrow keys alone.
TEST(KeyFeed, IsThatOfTheSawWhileItIsPressedAgainstTheStop) {
  constexpr double kFeed_mm_per_s = 3;
  Scene scene = MakeExerciseScene("follow_line", 1);
  ASSERT_EQ(scene.exercise.feed_mm_per_s, kFeed_mm_per_s);
  const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
  const DepthStop stop{.name = "goal", .p_W_mm = cut.start_W, .direction_W = cut.into_W, .depth_mm = cut.depth_mm};
  EffectChoice guide = MakeGuide(nullptr, &stop);
  guide.Set("stiffness_N_per_mm", 200.0);
  guide.Set("max_force_N", 100.0);
  scene.effects.push_back(std::move(guide));
  std::atomic<bool> done{false};
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = 60;
  loop.output.log = LoopLog::kNone;
  loop.stop = &done;
  loop.driver.make_hand = [&](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm, double) {
    DeviceSample sample;
    device.Read(sample);
    return std::make_unique<KeyHand>(device, p_TC_mm, cut, sample.X_WH, kFeed_mm_per_s, done);
  };
  FeedMeter meter(cut);
  double slowest_mm_per_s = 1e9, fastest_mm_per_s = 0, force_N = 0;
  loop.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) {
    const std::optional<double> feed = meter.Take(tick.time_s, tick.coupled.X_WT);
    if (!feed) return;
    slowest_mm_per_s = std::min(slowest_mm_per_s, *feed);
    fastest_mm_per_s = std::max(fastest_mm_per_s, *feed);
    force_N = std::max(force_N, glm::length(tick.coupled.f_H_W_N));
  };
  RunLoop(scene, loop, {});
  EXPECT_TRUE(done);
  EXPECT_GT(force_N, 7);
  EXPECT_NEAR(slowest_mm_per_s, kFeed_mm_per_s, 0.1);
  EXPECT_NEAR(fastest_mm_per_s, kFeed_mm_per_s, 0.1);
}

}  // namespace
}  // namespace kerf
