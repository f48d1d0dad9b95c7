// Option for the frame of a file's coordinates.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kerf::cli {

/// Adds `--frame` to `command`. An unknown frame is reported as bad usage.
CLI::Option* AddFrameOption(CLI::App& command, std::string& frame);

}  // namespace kerf::cli
