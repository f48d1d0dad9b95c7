// Options that say how a CT is read.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "bone/import/import.h"

namespace kerf::cli {

/// Adds `--series`, `--as-ct`, `--frame` and `--spacing-z` to `command`. `group`: of the help. An unknown frame is
/// reported as bad usage.
void AddCtOptions(CLI::App& command, ImportOptions& import, const std::string& group);

/// Throws CLI::ValidationError with `why` if one of these options was given.
void RejectCtOptions(const CLI::App& command, const std::string& why);

}  // namespace kerf::cli
