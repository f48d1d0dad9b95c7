#include "app/cli/device_option.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/core/sha256.h"
#include "base/files/files.h"
#include "device/devices/played_device.h"
#include "device/devices/profiles.h"
#include "device/drivers/libusb_bus.h"
#include "device/drivers/wooden_config.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/scene/path_csv.h"

namespace kerf::cli {
namespace {

constexpr const char* kNone = "none";
constexpr const char* kScript = "script:";
constexpr const char* kRecording = "recording:";
constexpr double kMaxPlayed = 36e6;  // maximum number of poses: ten hours at 1 kHz
constexpr std::size_t kMaxPathBytes = std::size_t{1} << 28;

bool IsPlayed(const std::string& device) {
  return device == kNone || device.starts_with(kScript) || device.starts_with(kRecording);
}

bool IsTracked(const std::string& device) {
  return device == kTrackedToolName;
}

std::string FileOf(const std::string& device, std::string_view what) {
  std::string file = device.substr(what.size());
  if (file.empty()) throw CLI::ValidationError("--device", fmt::format("\"{}\" must be followed by a file name", what));
  return file;
}

std::uint16_t ReadPort(const std::string& text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || !kPortRange.Contains(port)) {
    throw CLI::ValidationError("--bridge",
                               fmt::format("the port '{}' is not a number from {}", text, ShowRange(kPortRange, "")));
  }
  return static_cast<std::uint16_t>(port);
}

std::vector<PlayedPose> ReadScript(const std::string& file) {
  std::vector<PlayedPose> poses;
  for (const TimedPose& pose : ParsePathCsv(ReadTextFile(file, kMaxPathBytes), file)) {
    poses.push_back({.time_s = pose.time_s, .sample = {.X_WH = pose.X_WT, .buttons = 0}});
  }
  return poses;
}

/// Reads the recorded poses of the handle.
std::vector<PlayedPose> ReadHandle(const std::string& file) {
  RecordingReader recording(file);
  if (recording.header().kind != RecordedKind::kLoop) {
    throw Error(fmt::format("{}: is a recording of 'kerf run', which has no handle", file));
  }
  if (static_cast<double>(recording.steps()) > kMaxPlayed) throw Error(fmt::format("{}: is too long", file));
  std::vector<PlayedPose> poses;
  RecordedBlock block;
  double time_s = 0;
  std::uint64_t next_step = 0;
  for (std::size_t i = 0; recording.ReadBlock(i, block); ++i) {
    if (block.first_step != next_step) time_s = block.first_time_s;
    next_step = block.first_step + block.steps.size();
    for (const RecordedStep& step : block.steps) {
      const double elapsed_s = CalcElapsed(step, recording.header().rate_hz);
      time_s += elapsed_s;
      if (elapsed_s <= 0 || (step.flags & kRecordedReadFailed) != 0) continue;
      poses.push_back({.time_s = time_s, .sample = {.X_WH = step.X, .buttons = step.buttons}});
    }
  }
  if (poses.empty()) throw Error(fmt::format("{}: contains no handle poses", file));
  if (const std::string damage = recording.DescribeDamage(); !damage.empty()) {
    SayWarning("{}: {}; the handle does not move in the missing parts", file, damage);
  }
  return poses;
}

/// Returns true if the command line gives the firmware file. The environment variable may be set for any device.
bool IsFirmwareOptionGiven(const DeviceOption& option) {
  const char* variable = std::getenv(kFalconFirmwareVariable);
  return !option.falcon_firmware.empty() && (variable == nullptr || option.falcon_firmware != variable);
}

void CheckOptionMatchesDevice(std::string_view kind, const char* name, bool given, std::string_view chosen) {
  if (!given || chosen == kind) return;
  throw CLI::ValidationError(name, fmt::format("is for the device \"{}\", not for \"{}\"", kind, chosen));
}

/// Returns the name of the kind that the option names. Throws CLI::ValidationError.
std::string FindKind(const DeviceOption& option) {
  try {
    return FindKnownDevice(option.device).name;
  } catch (const Error& e) {
    throw CLI::ValidationError(option.called, option.called == kDeviceOption
                                                  ? fmt::format("{}; 'kerf loop' also accepts \"none\", "
                                                                "\"script:FILE\" and \"recording:FILE\"",
                                                                e.what())
                                                  : e.what());
  }
}

}  // namespace

void AddDriverOptions(CLI::App& command, DeviceOption& option) {
  command
      .add_option(
          "--falcon-firmware", option.falcon_firmware,
          "Firmware file of the Novint Falcon, from its manufacturer; not needed if another program has loaded it")
      ->envname(kFalconFirmwareVariable);
  command.add_option(
      "--wooden", option.wooden,
      "Dimensions of a WoodenHaptics device (TOML, like volumes/wooden_2016.toml); default: those of 2016");
  CLI::Option* bridge = command.add_option("--bridge", option.bridge,
                                           fmt::format("Address of the bridge program of a device with a "
                                                       "manufacturer's library, ADDRESS[:PORT]; default: 127.0.0.1:{}",
                                                       kBridgePort));
  command
      .add_flag("--bridge-elsewhere", option.bridge_elsewhere,
                "Allow a bridge on another machine; anyone who can send to it can move the device")
      ->needs(bridge);
}

CLI::Option* AddDeviceOption(CLI::App& command, DeviceOption& option, bool played) {
  std::string what =
      "Haptic device to use instead of a simulated one ('kerf devices' lists the connected ones); or \"igtl\": a "
      "tracked tool, whose pose a peer of --igtl sends, without force";
  if (played) {
    what +=
        "; or \"none\": the handle does not move; \"script:FILE\": it follows a table of poses, like [path] file; "
        "\"recording:FILE\": it moves as in a recording";
  }
  CLI::Option* device =
      command.add_option(kDeviceOption, option.device, what)->check([played](const std::string& name) {
        return played || !IsPlayed(name) ? "" : fmt::format("\"{}\" works only with 'kerf loop'", name);
      });
  AddDriverOptions(command, option);
  for (const char* name : {"--wooden", "--bridge"}) command.get_option(name)->needs(device);
  AddNumber(command, "--motion-scale", option, "motion_scale", "motion of the tool per motion of the handle")
      ->needs(device);
  command
      .add_option("--profile", option.profile,
                  "Profile of the device, from 'kerf devices --profiles'; default: the one with its name")
      ->needs(device);
  command.add_flag("--left-handed", option.left_handed, "Mirror the device, and exchange its right and left buttons")
      ->needs(device);
  return device;
}

DriverOptions MakeDriverOptions(const DeviceOption& option) {
  DriverOptions options;
  const bool may_be_falcon = option.device.empty() || option.device.starts_with("falcon");
  if (!option.falcon_firmware.empty() && may_be_falcon) {
    const std::string text = ReadTextFile(option.falcon_firmware, std::size_t{1} << 20);
    options.falcon.firmware.assign(text.begin(), text.end());
    CheckFalconFirmware(options.falcon.firmware, option.falcon_firmware);
  }
  if (!option.wooden.empty()) options.wooden = ReadWoodenConfig(option.wooden);
  options.bridge.allow_remote = option.bridge_elsewhere;
  if (!option.bridge.empty()) {
    const std::size_t colon = option.bridge.rfind(':');
    options.bridge.address = option.bridge.substr(0, colon);
    if (options.bridge.address == "localhost") options.bridge.address = "127.0.0.1";
    if (colon != std::string::npos) options.bridge.port = ReadPort(option.bridge.substr(colon + 1));
  }
  return options;
}

void CheckDeviceOption(const DeviceOption& option) {
  if (option.device.empty() || IsPlayed(option.device)) {
    if (IsFirmwareOptionGiven(option)) throw CLI::ValidationError("--falcon-firmware", "requires --device falcon");
    return;
  }
  std::string kind = kTrackedToolName;
  if (IsTracked(option.device)) {
    if (option.tracked_tool == nullptr) throw CLI::ValidationError(option.called, "\"igtl\" requires --igtl");
    if (option.left_handed || !option.profile.empty()) {
      throw CLI::ValidationError(option.called,
                                 "\"igtl\" gives no force back and has no sides; --profile and "
                                 "--left-handed do not apply");
    }
  } else {
    kind = FindKind(option);
  }
  CheckOptionMatchesDevice("falcon", "--falcon-firmware", IsFirmwareOptionGiven(option), kind);
  CheckOptionMatchesDevice("wooden", "--wooden", !option.wooden.empty(), kind);
  CheckOptionMatchesDevice("bridge", "--bridge", !option.bridge.empty(), kind);
}

std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, const DeviceServoOptions& servo,
                                       const std::atomic<bool>* stop) {
  CheckDeviceOption(option);
  if (option.device.empty() || IsPlayed(option.device)) return nullptr;
  if (!option.profile.empty()) FindDeviceProfile(option.profile);
  const DriverOptions driver = MakeDriverOptions(option);
  if (!driver.falcon.firmware.empty()) {
    Say("{}: {} bytes, SHA-256 {}", option.falcon_firmware, driver.falcon.firmware.size(),
        CalcSha256(driver.falcon.firmware));
  }
  HandleSignalsOfDevices();
  DeviceServoOptions servo_options = servo;
  if (IsTracked(option.device)) {
    servo_options.servo = MakeTrackedToolParams();
    servo_options.R_WD = Quat(1, 0, 0, 0);
    servo_options.reported_orientation = false;
    servo_options.max_sample_age_s = servo_options.servo.silent_s;
    servo_options.restart_after_s = std::numeric_limits<double>::infinity();
    const auto make = [tool = option.tracked_tool] { return std::make_unique<TrackedToolDriver>(tool); };
    return std::make_shared<DeviceServo>("tracked tool", make, servo_options, nullptr);
  }
  servo_options.own_figures = !option.wooden.empty();
  const auto bus = std::make_shared<LibusbBus>();
  StageBars bars;
  return std::make_shared<DeviceServo>(
      option.device, [bus, choice = option.device, driver] { return OpenDriver(*bus, choice, driver); }, servo_options,
      [&bars, stop](const std::string& doing, double fraction) {
        bars.Show(doing, fraction);
        return stop == nullptr || !stop->load();
      });
}

std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, Scene& scene, const std::atomic<bool>* stop) {
  if (option.motion_scale) scene.device.motion_scale = *option.motion_scale;
  if (option.left_handed) scene.device.left_handed = true;
  DeviceServoOptions options = MakeServoOptions(scene);
  options.profile = option.profile;
  std::shared_ptr<DeviceServo> servo = OpenServo(option, options, stop);
  if (servo) SetDevice(scene, *servo);
  return servo;
}

LoopDevice MakePlayedDevice(const DeviceOption& option) {
  LoopDevice device;
  if (!IsPlayed(option.device)) return device;
  if (option.motion_scale || option.left_handed || !option.profile.empty() || !option.wooden.empty() ||
      !option.bridge.empty()) {
    throw CLI::ValidationError("--device", fmt::format("\"{}\" is not a real device; --motion-scale, --left-handed, "
                                                       "--profile, --wooden and --bridge apply to a real device only",
                                                       option.device));
  }
  std::vector<PlayedPose> poses;
  if (option.device.starts_with(kScript)) poses = ReadScript(FileOf(option.device, kScript));
  if (option.device.starts_with(kRecording)) poses = ReadHandle(FileOf(option.device, kRecording));
  const auto played = std::make_shared<std::optional<PlayedDevice>>();
  device.in_real_time = false;
  device.begin = [played, poses = std::move(poses)](const Pose& X_WT, const CouplingParams&, double) -> Device& {
    std::vector<PlayedPose> all = poses;
    if (all.empty()) all.push_back({.time_s = 0, .sample = {.X_WH = X_WT, .buttons = 0}});
    return played->emplace(DeviceProfile{}, std::move(all));
  };
  return device;
}

void FollowServo(DeviceServo& servo, bool& waited) {
  // The state comes first: the request has then been printed before, or is among the messages. Input that was typed
  // before the request was printed does not count as an answer. All of it is discarded before printing, so that an
  // answer that follows at once is kept for the next call.
  if (MayReadTerminal(STDIN_FILENO)) {
    const bool asks = servo.state() == ServoState::kWaiting;
    const bool asked = std::exchange(waited, asks);
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    char line[256];
    while (poll(&input, 1, 0) == 1 && read(STDIN_FILENO, line, sizeof(line)) > 0) {
      if (asks && asked) servo.Agree();
    }
  }
  const bool terminal = isatty(STDERR_FILENO) == 1;
  for (const std::string& message : servo.TakeMessages()) {
    if (terminal) std::fputs("\r\x1b[K", stderr);  // erases a progress bar
    Say("{}", message);
  }
}

}  // namespace kerf::cli
