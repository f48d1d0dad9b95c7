#include "device/emulated/scene_hand.h"

#include <algorithm>
#include <cmath>

#include "session/scene/path.h"

namespace kerf::test {
namespace {

constexpr double kLongestStep_s = 0.01;
constexpr double kGrasp_s = 0.5;  // from getting the tool to moving it
constexpr double kPress_s = 1;    // until a button is pressed
constexpr double kPressed_s = 0.3;
constexpr double kMaxSilence_s = 0.005;  // without a command; well below the time after which a device is silent

WorkspaceParams MakeParams(const Scene& scene, const LoopSetup& setup) {
  const SceneDevice& device = scene.device;
  const Quat R_WD = device.left_handed ? MirrorForLeftHand(device.orientation) : device.orientation;
  return {device.motion_scale, R_WD, setup.fitted.coupling.p_TC_mm, false};
}

SimulatedDeviceOptions MakeOptions(const LoopSetup& setup) {
  SimulatedDeviceOptions options;
  options.p_TC_mm = setup.fitted.coupling.p_TC_mm;
  options.quantise = false;  // the encoders' model does that
  return options;
}

}  // namespace

SceneHand::SceneHand(const Scene& scene, const DeviceProfile& profile)
    : scene_(scene),
      setup_(MakeLoopSetup(scene)),
      path_(MakePath(scene)),
      workspace_(MakeParams(scene, setup_)),
      device_(ScaleProfile(profile, scene.device.motion_scale), setup_.hand, path_.CalcPose(0, 0), MakeOptions(setup_)),
      motion_(device_, path_, scene.hand, setup_.fitted.coupling.p_TC_mm,
              setup_.fitted.coupling.stiffness_N_per_mm * setup_.force_scale),
      at_rest_(profile, setup_.hand, {}) {}

void SceneHand::Home() {
  on_path_ = false;
  engaged_s_ = 0;
  at_rest_.Home();
}

void SceneHand::SetEngaged(bool engaged) {
  if (engaged && !engaged_) {
    DeviceSample sample;
    device_.Read(sample);
    workspace_.Anchor(X_DH_, sample.X_WH);  // as kerf does
  }
  engaged_ = engaged;
}

void SceneHand::Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) {
  f_D_N_ = f_D_N;
  if (!(dt_s > 0)) return;
  waiting_s_ = waiting_ ? waiting_s_ + dt_s : 0;
  if (!on_path_) {
    engaged_s_ += engaged_ ? dt_s : 0;
    on_path_ = engaged_s_ >= kGrasp_s;
    at_rest_.Move(dt_s, f_D_N, tau_D_Nmm);
    X_DH_ = at_rest_.handle();
    return;
  }
  since_heard_s_ += dt_s;
  if (commands_) {
    const std::uint64_t before = std::exchange(heard_, commands_());
    if (heard_ != before) since_heard_s_ = 0;
  }
  if (!engaged_ || path_s_ >= stop_at_s_ || (commands_ && since_heard_s_ > kMaxSilence_s)) return;
  const Vec3 f_W_N = workspace_.ToWorld(f_D_N);
  if (commands_) dt_s = std::min(dt_s, kMaxSilence_s);  // a stall of this program is a silence too
  while (dt_s > 0 && path_s_ < stop_at_s_) {
    const double step_s = std::min(dt_s, kLongestStep_s);
    dt_s -= step_s;
    path_s_ += step_s;
    motion_.Advance(step_s);
    device_.Write(f_W_N, Vec3{0});
    device_.Elapse(step_s);
  }
  DeviceSample sample;
  if (device_.Read(sample)) X_DH_ = workspace_.CalcHandlePose(sample.X_WH);
}

std::uint32_t SceneHand::buttons() const {
  // The button is pressed repeatedly, because a program that stalls at that moment misses it.
  return std::fmod(waiting_s_, kPress_s + kPressed_s) > kPress_s ? 1u : 0u;
}

}  // namespace kerf::test
