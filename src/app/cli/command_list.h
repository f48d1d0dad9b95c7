// List of all commands: their order and groups in the help, and an example for each.
#pragma once

#include <CLI/CLI.hpp>

namespace kerf::cli {

/// Adds all commands to `app`, in the order of `kerf --help`, each with its group and an example in its help.
void AddCommands(CLI::App& app);

/// Finds a command by its full name without "kerf", such as "device test"; "" is `app` itself. Returns nullptr if there
/// is none.
CLI::App* FindCommand(CLI::App& app, const std::string& name);

}  // namespace kerf::cli
