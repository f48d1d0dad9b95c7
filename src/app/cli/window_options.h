// Options of the commands that open a window.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "app/cli/device_option.h"
#include "app/window/viewer_app.h"

namespace kerf::cli {

struct WindowOptions {
  std::string folder;
  std::string log;
  DeviceOption device;
  std::string size = "1280x720";
  double scale = 0;
};

void AddWindowOptions(CLI::App& command, WindowOptions& options);
/// Opens the device, if any, and creates the session's folder: the one given, or kerf/`kind`-DATE-TIME in the user's
/// data folder. Throws Error, or CLI::ValidationError for an invalid size.
ViewerOptions MakeViewerOptions(const WindowOptions& options, const std::string& title, const std::string& kind);

}  // namespace kerf::cli
