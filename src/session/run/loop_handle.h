// What moves the tool of a coupled session.
#pragma once

#include <memory>
#include <optional>

#include "loop/haptics/guarded_device.h"
#include "session/run/hand_motion.h"
#include "session/run/loop_options.h"
#include "session/run/loop_setup.h"
#include "session/run/replay_body.h"

namespace kerf {

struct LoopSummary;

/// The handle that the tool is coupled to: that of a real device, or of a simulated device that is moved by the scene's
/// hand or by another one. While a recording is replayed, the recorded poses take its place.
class LoopHandle {
 public:
  /// `p_TC_mm`: the coupling's point. `felt_stiffness_N_per_mm`: as in MakeHand. `driver` must outlive this object.
  LoopHandle(const Scene& scene, const LoopDriver& driver, const LoopSetup& setup, const Path& path,
             const Vec3& p_TC_mm, double felt_stiffness_N_per_mm);

  GuardedDevice& device() { return guarded_; }
  ReplayDevice& recorded() { return recorded_; }
  /// Returns the hand on a simulated device, null for a real device.
  HandDriver* hand() { return motion_ ? &*motion_ : other_hand_.get(); }
  bool is_real() const { return driver_.device.is_set(); }

  /// Connects the real device, if there is one, to the tool at X_WT. May wait for the user.
  void Connect(const Pose& X_WT, const CouplingParams& coupling, double force_scale);
  /// Call at the end of a replay, whose last tick is `last`: finds out whether the scene's hand has made the recording.
  void EndReplay(const LoopTick& last);
  /// Continues the recording after EndReplay(); the user feels no force at first.
  void TakeOver(const LoopTick& last);
  /// Call after the end of the loop.
  void Summarize(LoopSummary& s) const;

 private:
  const LoopDriver& driver_;
  std::optional<SimulatedDevice> simulated_;
  std::optional<HandMotion> motion_;
  std::unique_ptr<HandDriver> other_hand_;
  ReplayDevice recorded_;
  GuardedDevice guarded_;
  bool follows_path_ = true;  // the handle that counts is that of `motion_`
};

}  // namespace kerf
