// The hand of somebody who cuts what a scene says with an emulated device: homes it, waits until it has the tool, then
// moves as `kerf loop`'s simulated hand does; when the device lost it, homes it again and agrees by a button.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <utility>

#include "device/devices/workspace.h"
#include "device/emulation/mechanism.h"
#include "device/emulation/scripted_hand.h"
#include "session/run/hand_motion.h"
#include "session/run/loop_setup.h"
#include "session/scene/scene.h"

namespace kerf::test {

class SceneHand final : public Mechanism {
 public:
  /// `profile`: of the emulated device, whose mass and friction the hand feels. Throws Error.
  SceneHand(const Scene& scene, const DeviceProfile& profile);

  void Home();
  /// How often the device was told something. While the program stands still, so does the hand: what a handle does
  /// meanwhile does not move the tool, and the way would be that much shorter.
  void SetHears(std::function<std::uint64_t()> commands) { commands_ = std::move(commands); }
  /// It goes no further on its way, until it is told of a place that is further.
  void StopAt(double way_s) { stop_at_s_ = way_s; }
  /// Whether the device's lamp says that the hand has the tool.
  void SetEngaged(bool engaged);
  /// A device that is there, homed and not engaged: a button is pressed for a moment, time and again.
  void SetWaiting(bool waiting) { waiting_ = waiting; }

  void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) override;
  Pose handle() const override { return X_DH_; }
  std::uint32_t buttons() const override;
  Vec3 f_D_N() const { return f_D_N_; }
  double way_s() const { return way_s_; }
  long strokes() const { return motion_.strokes(); }

 private:
  Scene scene_;
  LoopSetup setup_;
  Path path_;
  Workspace workspace_;
  SimulatedDevice device_;  // in the world
  HandMotion motion_;
  ScriptedHand at_rest_;  // in frame D: homing and waiting
  std::function<std::uint64_t()> commands_;
  std::uint64_t heard_ = 0;
  double since_heard_s_ = 0;
  bool engaged_ = false;
  bool at_way_ = false;  // not homing, nor before it had the tool
  bool waiting_ = false;
  double engaged_s_ = 0;
  double waiting_s_ = 0;
  double way_s_ = 0;
  double stop_at_s_ = std::numeric_limits<double>::infinity();
  Pose X_DH_;
  Vec3 f_D_N_{0};
};

}  // namespace kerf::test
