// The hand of a user who makes the cut of a scene with an emulated device. It homes the device, waits until it has the
// tool, then moves as `kerf loop`'s simulated hand does. If the device must be homed again, the hand homes it and
// agrees by pressing a button.
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
  /// `profile` is that of the emulated device, whose mass and friction the hand feels. Throws Error.
  SceneHand(const Scene& scene, const DeviceProfile& profile);

  void Home();
  /// `commands` returns the number of commands that the device has received. While the program stalls, the hand stops
  /// too; the tool would not follow a handle that moves in the meantime, and the path would be shortened.
  void SetCommandCount(std::function<std::uint64_t()> commands) { commands_ = std::move(commands); }
  /// Makes the hand stop at the time `path_s` of its path, until a later time is set.
  void StopAt(double path_s) { stop_at_s_ = path_s; }
  /// Sets whether the device's lamp shows that the hand has the tool.
  void SetEngaged(bool engaged);
  /// Sets whether a homed device waits for the user. While it does, the hand presses a button briefly and repeatedly.
  void SetWaiting(bool waiting) { waiting_ = waiting; }

  void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) override;
  Pose handle() const override { return X_DH_; }
  std::uint32_t buttons() const override;
  Vec3 f_D_N() const { return f_D_N_; }
  double path_s() const { return path_s_; }
  long strokes() const { return motion_.strokes(); }

 private:
  Scene scene_;
  LoopSetup setup_;
  Path path_;
  Workspace workspace_;
  SimulatedDevice device_;  // in the world frame
  HandMotion motion_;
  ScriptedHand at_rest_;  // in frame D; for homing and waiting
  std::function<std::uint64_t()> commands_;
  std::uint64_t heard_ = 0;
  double since_heard_s_ = 0;
  bool engaged_ = false;
  bool on_path_ = false;  // the hand is on its path: neither homing nor waiting for the tool
  bool waiting_ = false;
  double engaged_s_ = 0;
  double waiting_s_ = 0;
  double path_s_ = 0;
  double stop_at_s_ = std::numeric_limits<double>::infinity();
  Pose X_DH_;
  Vec3 f_D_N_{0};
};

}  // namespace kerf::test
