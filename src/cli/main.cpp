#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

#include "cli/commands.h"
#include "cli/signals.h"
#include "core/nearest_name.h"
#include "files/memory.h"
#include "kerf/error.h"
#include "kerf/version.h"

namespace {

constexpr int kFailed = 1;
constexpr int kUsage = 2;

/// A sentence about a first word that is no command; "" when it is one or an option. CLI11 only says that a command is
/// missing.
std::string FindUnknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return "";
  const std::string word = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return "";
  const std::string nearest = kerf::FindNearestName(word, names);
  return fmt::format("unknown command \"{}\"{}; 'kerf --help' lists them", word,
                     nearest.empty() ? "" : fmt::format("; the nearest is \"{}\"", nearest));
}

/// Messages show what stands in files: no control character of theirs may reach the terminal.
std::string ForTerminal(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f; }, '?');
  return text;
}

/// Output that got lost, on a full disk for instance, is a failure.
int FlushOutput(int code) {
  errno = 0;
  std::cout.flush();
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (!lost) return code;
  const std::string reason = errno == 0 ? "" : ": " + std::generic_category().message(errno);
  fmt::print(stderr, "kerf: standard output can't be written{}\n", reason);
  return code == 0 ? kFailed : code;
}

int RunProgram(int argc, char** argv, double free_bytes) {
  CLI::App app{"kerf: a simulator of cutting bone with a saw", "kerf"};
  app.require_subcommand(1);
  app.set_version_flag("--version", [] {
    return fmt::format("kerf {} (commit {}; {})\nbuilt with {}", kerf::VersionString(), kerf::CommitString(),
                       kerf::CompilerString(), kerf::LibrariesString());
  });
  kerf::cli::AddAssessCommand(app);
  kerf::cli::AddBenchCommand(app);
  kerf::cli::AddCheckCommand(app);
  kerf::cli::AddCompareCommand(app);
  kerf::cli::AddDevicesCommand(app);
  kerf::cli::AddDeviceCommand(app);
  kerf::cli::AddEffectsCommand(app);
  kerf::cli::AddExportCommand(app);
  kerf::cli::AddPictureCommand(app);
  kerf::cli::AddInfoCommand(app);
  kerf::cli::AddPaperCommand(app);
  kerf::cli::AddRunCommand(app);
  kerf::cli::AddLoopCommand(app);
  kerf::cli::AddRehearseCommand(app);
  kerf::cli::AddReplayCommand(app);
  kerf::cli::AddScoreCommand(app);
  kerf::cli::AddPractiseCommand(app);
  kerf::cli::AddLogCommand(app);
  kerf::cli::AddImportCommand(app);
  kerf::cli::AddModelCommand(app);
  kerf::cli::AddSceneCommand(app);
  kerf::cli::AddMaterialsCommand(app);
  kerf::cli::AddSlabCommand(app);
  kerf::cli::AddStabilityCommand(app);
  kerf::cli::AddStudyCommand(app);
  kerf::cli::AddTuneCommand(app);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    // --help and --version come as "errors" with exit code 0; everything else is bad use.
    if (const std::string unknown = FindUnknownCommand(app, argc, argv); !unknown.empty()) {
      fmt::print(stderr, "kerf: {}\n", unknown);
      return kUsage;
    }
    const int code = app.exit(e);
    return code == 0 ? 0 : kUsage;
  } catch (const kerf::Error& e) {
    fmt::print(stderr, "kerf: {}\n", ForTerminal(e.what()));
    return kFailed;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "kerf: not enough memory: {:.1f} GB were free; use larger voxels or a shorter run\n",
               1e-9 * free_bytes);
    return kFailed;
  } catch (const std::system_error& e) {
    if (std::ferror(stdout) == 0) fmt::print(stderr, "kerf: {}\n", e.what());  // else FlushOutput says it
    return kFailed;
  } catch (const std::exception& e) {
    fmt::print(stderr, "kerf: {}\n", ForTerminal(e.what()));
    return kFailed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  kerf::cli::HandleSignals();
  const auto free_bytes = static_cast<double>(kerf::LimitMemory());
  return FlushOutput(RunProgram(argc, argv, free_bytes));
}
