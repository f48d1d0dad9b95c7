#include "session/held_device/hold_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "base/files/files.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kSamePeak = 1 + 1e-6;  // allows for the rounding of a peak that a bridge reports as a float
constexpr double kGateSlewFraction = 0.9;

constexpr std::size_t kMaxProfileBytes = std::size_t{1} << 20;

/// Returns the peak force of the scene's profile. Returns 0 if the table cannot be read; the loop reports that error
/// with its place in the scene.
double FindPeak(const SceneDevice& device) {
  if (device.file.empty()) {
    try {
      return FindDeviceProfile(device.profile).peak_force_N;
    } catch (const Error& e) {
      throw Error(fmt::format("{}; set [device] file in the scene to a table that contains it", e.what()));
    }
  }
  try {
    const std::string table = ReadTextFile(device.file, kMaxProfileBytes);
    return FindDeviceProfile(ParseDeviceProfiles(table, device.file), device.profile).peak_force_N;
  } catch (const Error&) {
    return 0;
  }
}

void ChooseProfile(SceneDevice& device, const DeviceServo& servo) {
  if (const std::string& requested = servo.options().profile; !requested.empty()) {
    device.profile = FindDeviceProfile(requested).name;
    device.file.clear();
    return;
  }
  if (!device.file.empty()) return;
  const std::string& name = servo.profile().name;
  const std::vector<DeviceProfile>& table = DeviceProfiles();
  if (std::any_of(table.begin(), table.end(), [&](const DeviceProfile& p) { return p.name == name; })) {
    device.profile = name;
  } else if (!device.given) {
    throw Error(
        fmt::format("the device reports the name '{}', for which there is no profile; name a similar one with "
                    "--profile ('kerf devices --profiles' lists them) or in the scene's [device]",
                    name));
  }
}

Pose ReadPose(SimulatedDevice& device) {
  DeviceSample sample;
  device.Read(sample);
  return sample.X_WH;
}

}  // namespace

DeviceServoOptions MakeServoOptions(const Scene& scene) {
  DeviceServoOptions options;
  options.motion_scale = scene.device.motion_scale;
  options.R_WD = scene.device.orientation;
  options.left_handed = scene.device.left_handed;
  return options;
}

void SetDevice(Scene& scene, const DeviceServo& servo) {
  if (!servo.traits().makes_force) return;
  const DeviceProfile& actual = servo.profile();
  scene.device.motion_scale = servo.options().motion_scale;
  scene.device.left_handed = servo.options().left_handed;
  // The safety gate would report a higher slew rate as a fault.
  scene.device.slew_N_per_s =
      std::min(scene.device.slew_N_per_s, kGateSlewFraction * SafetyGateOptions{}.max_slew_per_s * actual.peak_force_N);
  ChooseProfile(scene.device, servo);
  scene.device.given = true;  // so that it is recorded
  const double peak_N = FindPeak(scene.device);
  if (peak_N > kSamePeak * actual.peak_force_N) {
    throw Error(
        fmt::format("the device outputs at most {:g} N, but the profile '{}' states {:g} N: set [device] file in the "
                    "scene to a table with the device's figures",
                    actual.peak_force_N, scene.device.profile, peak_N));
  }
  // The device's cycle and the loop's tick are not synchronised, so the delay is at most one cycle plus one tick.
  const double round_ticks = std::ceil(scene.loop.rate_hz / servo.traits().rate_hz - 1e-9);
  if (1 + round_ticks > kMaxDelay_ticks) {
    throw Error(fmt::format(
        "the device accepts {:g} commands a second, too few for a loop of {:g} Hz: [loop] rate_hz must be {:g} at most",
        servo.traits().rate_hz, scene.loop.rate_hz, (kMaxDelay_ticks - 1) * servo.traits().rate_hz));
  }
  scene.device.delay_ticks = std::max(scene.device.delay_ticks, 1 + static_cast<int>(round_ticks));
}

LoopDevice MakeLoopDevice(DeviceServo& servo, const std::atomic<bool>* stop,
                          const std::function<void(const std::string&)>& say) {
  LoopDevice device;
  device.begin = [&servo, stop, say](const Pose& X_WT, const CouplingParams& coupling, double force_scale) -> Device& {
    servo.SetTool(X_WT, {.p_TC_mm = coupling.p_TC_mm, .stiffness_N_per_mm = force_scale * coupling.stiffness_N_per_mm});
    HandleAtRest at_rest(servo);
    bool reported = false;
    for (;;) {
      for (const std::string& message : servo.TakeMessages()) say(message);
      const ServoState state = servo.state();
      if (state == ServoState::kEngaged) return servo;
      if (state == ServoState::kWaiting && servo.traits().makes_force) {
        if (!std::exchange(reported, true)) {
          say(fmt::format("{}: hold the handle still in the middle, or press a button on it, to take the tool",
                          servo.name()));
        }
        if (at_rest.Update(servo.TakeSample())) servo.Agree();
      }
      if (stop != nullptr && stop->load()) throw Error("stopped while waiting for the device's handle");
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  };
  device.figures = [&servo] {
    const DeviceServo::Counts counts = servo.counts();
    const ServoCounts& rounds = counts.rounds;
    const LogHistogram& times = servo.round_times();
    const auto number = [](std::uint64_t count) { return static_cast<double>(count); };
    const auto gate = [&counts](GateReason reason) { return counts.gate[static_cast<std::size_t>(reason)]; };
    // The single stale event before the loop's first command is not counted.
    const std::uint64_t stale = std::max<std::uint64_t>(gate(GateReason::kStale), 1) - 1;
    return std::vector<std::pair<std::string, double>>{{"rounds", number(rounds.rounds)},
                                                       {"without_an_answer", number(rounds.no_answers)},
                                                       {"with_a_bad_one", number(rounds.bad_answers)},
                                                       {"silences", number(rounds.silences)},
                                                       {"leaps", number(rounds.jumps)},
                                                       {"loop_stood_still", number(stale)},
                                                       {"round_stood_still", number(gate(GateReason::kClock))},
                                                       {"largest_sent_N", rounds.largest_N},
                                                       {"round_p50_us", times.CalcPercentile_us(0.5)},
                                                       {"round_p99_us", times.CalcPercentile_us(0.99)},
                                                       {"round_max_us", times.max_us()}};
  };
  return device;
}

Pose MoveByDeflection(const Pose& X_WH, const std::array<double, 6>& deflection, const Quat& R_WD, const Vec3& p_TC_mm,
                      const DeflectionSpeeds& speeds, double dt_s) {
  const Vec3 translation_W = R_WD * (speeds.mm_per_s * dt_s * Vec3(deflection[0], deflection[1], deflection[2]));
  const Vec3 rotation_W = R_WD * (speeds.rad_per_s * dt_s * Vec3(deflection[3], deflection[4], deflection[5]));
  Pose X = X_WH;
  const Vec3 p_WC = X_WH.Point(p_TC_mm) + translation_W;
  if (const double angle = glm::length(rotation_W); angle > 0) {
    X.R_AB = glm::normalize(glm::angleAxis(angle, rotation_W / angle) * X_WH.R_AB);
  }
  X.p_AB = p_WC - X.R_AB * p_TC_mm;
  return X;
}

DeflectionHand::DeflectionHand(SimulatedDevice& device, DeviceServo& servo, const Quat& R_WD, const Vec3& p_TC_mm,
                               const DeflectionSpeeds& speeds)
    : servo_(servo),
      R_WD_(R_WD),
      p_TC_mm_(p_TC_mm),
      speeds_(speeds),
      X_WH_(ReadPose(device)),
      target_({X_WH_, true}),
      hand_(device, target_, X_WH_, p_TC_mm) {}

void DeflectionHand::Advance(double dt_s) noexcept {
  const std::array<double, 6> deflection = servo_.ReadDeflection();
  X_WH_ = MoveByDeflection(X_WH_, deflection, R_WD_, p_TC_mm_, speeds_, dt_s);
  target_.Publish({X_WH_, true});
  hand_.Advance(dt_s);
}

}  // namespace kerf
