// kerf run --uncertain.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace kerf::cli {

/// What `kerf run` passes on.
struct UncertainRequest {
  std::string scene;
  std::string folder;
  bool json = false;
  bool no_pictures = false;
};

/// Adds the options --uncertain, --seed, --jobs, --shard, --fit and --merge, or only --uncertain if this build lacks
/// them, which then fails. Returns a function that makes the uncertain run and returns true, or returns false without
/// --uncertain. `others`: options of kerf run that exclude it.
std::function<bool(const UncertainRequest&)> AddUncertainOptions(CLI::App& command,
                                                                 const std::vector<CLI::Option*>& others);

}  // namespace kerf::cli
