// The option that states the frame of a file's coordinates.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kerf::cli {

/// Adds `--frame` to `command`; an unknown frame is bad use.
CLI::Option* AddFrameOption(CLI::App& command, std::string& frame);

}  // namespace kerf::cli
