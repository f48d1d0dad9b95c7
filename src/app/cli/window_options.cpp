#include "app/cli/window_options.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <memory>

#include "app/cli/numbers.h"
#include "app/cli/signals.h"
#include "base/files/folder_lock.h"
#include "base/files/user_folders.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

/// Returns the user's folder of kerf's data.
std::string DataFolder() {
  if (const std::string data = FindUserFolder(UserFolder::kData); !data.empty()) return data + "/kerf";
  throw Error("neither XDG_DATA_HOME nor HOME is an absolute path: give a folder for recordings with -o");
}

}  // namespace

void AddWindowOptions(CLI::App& command, WindowOptions& options) {
  command.add_option(
      "-o", options.folder,
      "Folder for recordings, pictures and exports; created if missing; default: a new one in ~/.local/share/kerf");
  command.add_option("--size", options.size, "Size of the window, WIDTHxHEIGHT; larger on a display of a larger scale")
      ->capture_default_str();
  AddNumberOption(command, "--scale", options.scale, "scale", kDisplayScaleRange,
                  "scale of text and lines; default: the display's");
  AddDeviceOption(command, options.device, false);
  command.add_option("--log", options.log, "File for the events of the window, a line of JSON each");
}

ViewerOptions MakeViewerOptions(const WindowOptions& options, const std::string& title, const std::string& kind) {
  ViewerOptions viewer;
  viewer.title = title;
  viewer.log = options.log;
  viewer.scale = options.scale;
  viewer.interrupt = &CatchInterrupt();
  const std::vector<double> size = ParseNumbers(options.size, 'x', 2, "--size", "WIDTHxHEIGHT");
  const Range width = FindRange<GlWindowOptions>("width");
  const Range height = FindRange<GlWindowOptions>("height");
  if (!width.Contains(size[0]) || !height.Contains(size[1])) {
    throw CLI::ValidationError("--size", fmt::format("'{}' must be {}x{} to {}x{}", options.size, width.lower,
                                                     height.lower, width.upper, height.upper));
  }
  viewer.width = static_cast<int>(size[0]);
  viewer.height = static_cast<int>(size[1]);
  viewer.folder = options.folder;
  if (viewer.folder.empty()) {
    viewer.folder = fmt::format("{}/{}-{:%Y%m%d-%H%M%S}", DataFolder(), kind, fmt::localtime(std::time(nullptr)));
  }
  if (fs::exists(viewer.folder + "/session.kerf")) {
    throw Error(fmt::format("{}: already contains a session; give another folder", viewer.folder));
  }
  DeviceServoOptions servo;
  servo.motion_scale = options.device.motion_scale.value_or(1);
  servo.left_handed = options.device.left_handed;
  servo.profile = options.device.profile;
  servo.reported_orientation = true;  // from the user's viewpoint
  viewer.device = OpenServo(options.device, servo, viewer.interrupt);
  viewer.lock = std::make_shared<FolderLock>(viewer.folder);
  return viewer;
}

}  // namespace kerf::cli
