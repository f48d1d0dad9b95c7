// kerf device test: checks that a haptic device works, without a simulation.
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/device_option.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/signals.h"
#include "device/drivers/device_check.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct DeviceArguments {
  DeviceOption device;
  DeviceCheckOptions check;
  bool watch = false;
  bool json = false;
};

/// While an instance exists, keys are delivered immediately and not echoed. Has no effect without a terminal.
class RawKeys {
 public:
  RawKeys() {
    if (!MayReadTerminal(STDIN_FILENO) || tcgetattr(STDIN_FILENO, &before_.emplace()) != 0) {
      before_.reset();
      return;
    }
    termios raw = *before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  ~RawKeys() {
    if (before_) tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
  }
  RawKeys(const RawKeys&) = delete;
  RawKeys& operator=(const RawKeys&) = delete;

  bool Pressed() const {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    char key = 0;
    return before_ && MayReadTerminal(STDIN_FILENO) && poll(&input, 1, 0) == 1 && read(STDIN_FILENO, &key, 1) == 1;
  }

 private:
  std::optional<termios> before_;
};

/// Prints a line. On a terminal it overwrites a previous `transient` line and is cut off at the terminal's width.
void ShowWatched(const std::string& line, bool transient) {
  if (isatty(STDOUT_FILENO) == 1) {
    fmt::print("\r\x1b[K\x1b[?7l{}\x1b[?7h{}", line, transient ? "" : "\n");
  } else {
    fmt::print("{}\n", line);
  }
  std::fflush(stdout);
}

void Run(DeviceArguments& options) {
  const std::atomic<bool>& stop = CatchInterrupt();
  const std::shared_ptr<DeviceServo> servo = OpenServo(options.device, DeviceServoOptions{}, &stop);
  if (!servo) throw CLI::ValidationError("NAME", "must be a connected device: 'kerf devices' lists them");
  DeviceCheckResult result;
  {
    const RawKeys keys;
    options.check.goes_on = [&] { return !stop.load() && !keys.Pressed() && std::ferror(stdout) == 0; };
    if (options.watch) {
      WatchDevice(*servo, options.check.goes_on, ShowWatched);
      return;
    }
    options.check.say = [](const std::string& message) { Say("{}", message); };
    result = CheckDevice(*servo, options.check);
  }
  fmt::print("{}", options.json ? FormatDeviceCheckJson(options.device.device, *servo, result)
                                : FormatDeviceCheck(options.device.device, *servo, result));
  if (result.stopped) throw Error("the test was stopped");
  if (!result.faults.empty()) throw Error(fmt::format("{}: {}", options.device.device, result.faults.front()));
}

}  // namespace

void AddDeviceCommand(CLI::App& app) {
  const auto options = std::make_shared<DeviceArguments>();
  CLI::App* command = app.add_subcommand("device", "Test a haptic device without a simulation");
  command->require_subcommand(1);
  CLI::App* test =
      command->add_subcommand("test",
                              "Test homing, the handle at rest, a slow circle of force within a fifth of the peak, the "
                              "buttons, and the time of a round; any key stops the test and the force");
  options->device.called = "NAME";
  test->add_option(options->device.called, options->device.device, "Device, as 'kerf devices' lists it")->required();
  AddDriverOptions(*test, options->device);
  DeviceCheckOptions& check = options->check;
  AddNumber(*test, "--force", check, "circle_fraction")->capture_default_str();
  test->add_flag("--up", check.up, "Direct the force upwards throughout, to lift a weight: 1 N lifts 102 g");
  AddNumber(*test, "--circle", check, "circle_s")->capture_default_str();
  AddNumber(*test, "--buttons", check, "buttons_s")->capture_default_str();
  AddNumber(*test, "--homing", check, "homing_s")->capture_default_str();
  CLI::Option* json = test->add_flag("--json", options->json, "Print as JSON");
  test->add_flag("--watch", options->watch,
                 "Only show the handle's position and the buttons, ten times a second and without force, until a key "
                 "is pressed")
      ->excludes(json);
  test->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
