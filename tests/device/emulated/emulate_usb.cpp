// emulate_usb: runs an unmodified program on a machine that appears to have haptic devices plugged in.
#include <fmt/format.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <thread>
#include <utility>

#include "device/devices/profiles.h"
#include "device/emulated/emulated_devices.h"
#include "device/emulated/emulated_kernel.h"
#include "device/emulated/scene_hand.h"
#include "device/emulation/scripted_hand.h"
#include "kerf/error.h"

namespace kerf::test {
namespace {

constexpr double kFelt_N = 0.5;

struct Options {
  std::string device = "falcon";
  EmulatedDeviceOptions emulated;
  EmulatedSocket socket;
  ScriptedHandOptions hand;
  std::string firmware_file;
  std::string hand_model = "H3";
  std::string scene;
  std::string way = "still";
  std::vector<std::string> presses;
  std::string start_file;
  bool leaves_buttons = false;
  std::string felt_file;
  std::string report_file;
  double unplug_at_s = -1;
  std::uint64_t unplug_after = 0;
  double plug_in_at_s = -1;
  double unplug_on_way_s = -1;
  double plug_in_later_s = -1;
  double interrupt_on_way_s = -1;
  double silent_at_s = -1;
  double loud_at_s = -1;
  bool no_homing = false;
};

/// Passes everything on to a hand and records the largest force on it.
class ForceRecorder final : public Mechanism {
 public:
  explicit ForceRecorder(Mechanism& hand) : hand_(hand) {}
  void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) override {
    force_N_ = glm::length(f_D_N);
    peak_N_ = std::max(peak_N_, force_N_);
    hand_.Move(dt_s, f_D_N, tau_D_Nmm);
  }
  Pose handle() const override { return hand_.handle(); }
  std::uint32_t buttons() const override { return hand_.buttons(); }
  double force_N() const { return force_N_; }
  double peak_N() const { return peak_N_; }

 private:
  Mechanism& hand_;
  double force_N_ = 0;
  double peak_N_ = 0;
};

std::vector<std::uint8_t> ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(fmt::format("{}: can't be read", path));
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

HandPress ReadPress(const std::string& text) {
  HandPress press;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%u@%lf-%lf%c", &press.buttons, &press.from_s, &press.to_s, &rest) != 3) {
    throw Error(fmt::format("--press {}: must be BITS@FROM-TO, in seconds of path time", text));
  }
  return press;
}

/// Reads the options; returns the last part of `argv`, which is the program to run.
std::vector<std::string> ReadOptions(int argc, char** argv, Options& options) {
  CLI::App app{"Runs a program with an emulated haptic device (umockdev)", "emulate_usb"};
  app.add_option("--device", options.device, "Emulated device")->check(CLI::IsMember(NamesOfEmulatedDevices()));
  app.add_option("--firmware", options.firmware_file, "The only firmware file that a Falcon accepts; default: any");
  app.add_flag("--firmware-there", options.emulated.firmware_is_there, "The firmware runs already");
  app.add_flag("--homed", options.emulated.homed, "The device is homed");
  app.add_option("--wrong-echoes", options.emulated.wrong_echoes, "Number of firmware uploads that fail");
  app.add_flag("--no-permission", options.socket.no_permission, "The device's file can't be opened");
  app.add_option("--driver", options.socket.driver, "Kernel driver that has the device");
  app.add_flag("--driver-holds", options.socket.driver_holds, "The kernel driver can't be detached");
  app.add_option("--unplug-at", options.unplug_at_s, "Time after the program's start, s");
  app.add_option("--unplug-after", options.unplug_after, "Number of packets sent before it is unplugged; 0: never");
  app.add_option("--plug-in-at", options.plug_in_at_s,
                 "Time after the program's start at which it is plugged in again, s");
  app.add_option("--unplug-on-way", options.unplug_on_way_s, "Path time of a hand that cuts a scene, s");
  app.add_option("--plug-in-later", options.plug_in_later_s,
                 "Time after the unplugging at which it is plugged in again, s");
  app.add_option("--silent-at", options.silent_at_s, "Time from which it does not answer, s");
  app.add_option("--loud-at", options.loud_at_s, "Time from which it answers again, s");
  app.add_option("--hand", options.way, "Motion of the hand once the program exchanges: still, circle, line")
      ->check(CLI::IsMember({"still", "circle", "line"}));
  app.add_option("--scene", options.scene, "The hand cuts this scene once the device's lamp is green");
  app.add_option("--hand-model", options.hand_model, "H0 to H4");
  app.add_option("--radius", options.hand.radius_mm, "Radius of the circle, mm");
  app.add_option("--period", options.hand.period_s, "s");
  app.add_option("--press", options.presses, "BITS@FROM-TO: buttons, in seconds of path time");
  app.add_flag("--no-homing", options.no_homing, "The hand does not home the device");
  app.add_option("--interrupt-on-way", options.interrupt_on_way_s,
                 "Path time at which the program receives SIGINT, as by Ctrl-C, s");
  app.add_option("--wait-for", options.start_file, "The hand that cuts a scene waits until this file exists");
  app.add_flag("--leaves-buttons", options.leaves_buttons, "The hand never confirms by a button");
  app.add_option("--felt", options.felt_file, fmt::format("File that is created once the hand has felt {} N", kFelt_N));
  app.add_option("--report", options.report_file, "Output file with a summary of the device's run, JSON");
  const auto end = std::find_if(argv, argv + argc, [](const char* word) { return std::strcmp(word, "--") == 0; });
  std::vector<std::string> program(std::min(end + 1, argv + argc), argv + argc);
  try {
    app.parse(static_cast<int>(end - argv), argv);
    if (program.empty()) throw CLI::ValidationError("no program to run: emulate_usb [OPTIONS] -- PROGRAM ...");
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    std::exit(code == 0 ? 0 : 2);
  }
  return program;
}

/// Drops the capabilities that let root open every file, and runs the program.
[[noreturn]] void Become(std::vector<std::string>& program, bool no_permission) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_TIMERSLACK, 1);
  if (no_permission) {
    prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE);
    prctl(PR_CAPBSET_DROP, CAP_DAC_READ_SEARCH);
  }
  std::vector<char*> words;
  for (std::string& word : program) words.push_back(word.data());
  words.push_back(nullptr);
  // ALSA tries to open 32 sound cards, and umockdev 0.17 ends the program at a file that it can't track.
  setenv("ALSA_CONFIG_PATH", "/dev/null", 1);
  execvp(words[0], words.data());
  std::fprintf(stderr, "emulate_usb: %s can't be run: %s\n", words[0], std::strerror(errno));
  _exit(127);
}

volatile std::sig_atomic_t child = 0;

void ForwardSignal(int signal) {
  if (child > 0) kill(child, signal);
}

int Run(int argc, char** argv) {
  Options options;
  std::vector<std::string> program = ReadOptions(argc, argv, options);
  if (!options.firmware_file.empty()) options.emulated.firmware = ReadBytes(options.firmware_file);
  for (const std::string& press : options.presses) options.hand.presses.push_back(ReadPress(press));
  options.hand.path = std::map<std::string, ScriptedPath>{
      {"still", ScriptedPath::kStill}, {"circle", ScriptedPath::kCircle}, {"line", ScriptedPath::kLine}}[options.way];
  ScriptedHand hand(FindDeviceProfile("falcon"), FindHandModel(options.hand_model), options.hand);
  if (!options.scene.empty() && options.device != "falcon") {
    throw Error("--scene: --device must be falcon, because only its lamp shows that the hand has the tool");
  }
  std::optional<SceneHand> cutting;
  if (!options.scene.empty()) cutting.emplace(ReadScene(options.scene), FindDeviceProfile("falcon"));
  ForceRecorder handle(cutting ? static_cast<Mechanism&>(*cutting) : hand);
  const std::unique_ptr<EmulatedDevice> device = MakeEmulatedDevice(options.device, handle, options.emulated);
  if (cutting) cutting->SetCommandCount([&] { return device->packets(); });
  // At this point of its path, the hand waits until the device is unplugged, however late that is.
  if (cutting && options.unplug_on_way_s >= 0) cutting->StopAt(options.unplug_on_way_s);
  EmulatedKernel kernel;
  const int socket = kernel.PlugIn(device->model(), options.socket);

  struct Event {
    double at_s;
    std::function<void()> what;
  };
  std::vector<Event> events = {{options.unplug_at_s, [&] { kernel.Unplug(socket); }},
                               {options.plug_in_at_s, [&] { kernel.PlugInAgain(socket); }},
                               {options.silent_at_s, [&] { kernel.SetSilent(socket, true); }},
                               {options.loud_at_s, [&] { kernel.SetSilent(socket, false); }}};
  std::erase_if(events, [](const Event& event) { return event.at_s < 0; });
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  // Events at time 0 happen before the program starts.
  for (; !events.empty() && events.front().at_s <= 0; events.erase(events.begin())) events.front().what();

  const pid_t id = fork();
  if (id == 0) Become(program, options.socket.no_permission);
  child = id;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, ForwardSignal);

  const auto begin = std::chrono::steady_clock::now();
  int status = 0;
  double again_at_s = -1;
  bool plugged_in = true;
  std::optional<double> unplugged_on_way_s;
  double before_s = 0;
  while (waitpid(id, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const std::chrono::duration<double> now = std::chrono::steady_clock::now() - begin;
    while (!events.empty() && now.count() >= events.front().at_s) {
      events.front().what();
      events.erase(events.begin());
    }
    bool felt = false;
    bool pull = false;
    bool interrupt = false;
    kernel.Look([&] {
      interrupt = cutting && options.interrupt_on_way_s >= 0 && cutting->path_s() >= options.interrupt_on_way_s;
      pull = (options.unplug_after > 0 && device->packets() >= options.unplug_after) ||
             (cutting && options.unplug_on_way_s >= 0 && cutting->path_s() >= options.unplug_on_way_s);
    });
    if (interrupt) {
      options.interrupt_on_way_s = -1;
      kill(id, SIGINT);
    }
    if (pull) {
      options.unplug_after = 0;
      options.unplug_on_way_s = -1;
      kernel.Unplug(socket);
      plugged_in = false;
      kernel.Look([&] {
        if (!cutting) return;
        unplugged_on_way_s = cutting->path_s();
        cutting->SetEngaged(false);
        cutting->StopAt(std::numeric_limits<double>::infinity());
      });
      again_at_s = options.plug_in_later_s >= 0 ? now.count() + options.plug_in_later_s : -1;
    }
    if (again_at_s >= 0 && now.count() >= again_at_s) {
      again_at_s = -1;
      kernel.PlugInAgain(socket);
      plugged_in = true;
    }
    if (!options.start_file.empty() && std::filesystem::exists(options.start_file)) options.start_file.clear();
    kernel.Look([&] {
      device->Follow(handle, now.count() - before_s);
      before_s = now.count();
      if (cutting) {
        // The hand stops when the device is unplugged.
        cutting->SetEngaged(plugged_in && device->engaged() && options.start_file.empty());
        cutting->SetWaiting(!options.leaves_buttons && device->waits());
        if (device->wants_homing()) cutting->Home();
      } else if (device->wants_homing() && !options.no_homing) {
        hand.Home();
      } else if (device->driven()) {
        hand.Begin();
      }
      felt = handle.peak_N() > kFelt_N;
    });
    if (felt && !options.felt_file.empty()) std::ofstream(std::exchange(options.felt_file, ""));
  }
  child = 0;
  if (!options.report_file.empty()) {
    nlohmann::ordered_json report;
    kernel.Look([&] {
      report = device->Report();
      report["peak_force_N"] = handle.peak_N();
      report["force_at_end_N"] = handle.force_N();
      report["way_s"] = cutting ? cutting->path_s() : hand.path_s();
      if (cutting) report["strokes"] = cutting->strokes();
      if (unplugged_on_way_s) report["unplugged_on_way_s"] = *unplugged_on_way_s;
    });
    report["unknown_calls"] = kernel.unknown_calls();
    std::ofstream(options.report_file) << report.dump(2) << '\n';
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace
}  // namespace kerf::test

int main(int argc, char** argv) {
  if (const std::string failure = kerf::test::RunUnderUmockdev(argv); !failure.empty()) {
    std::fprintf(stderr, "emulate_usb: %s\n", failure.c_str());
    return 1;
  }
  try {
    return kerf::test::Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "emulate_usb: %s\n", error.what());
    return 1;
  }
}
