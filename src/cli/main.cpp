#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>

#include "cli/commands.h"
#include "kerf/error.h"
#include "kerf/version.h"

namespace {

constexpr int kFailed = 1;
constexpr int kUsage = 2;

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"kerf: a simulator of cutting bone with a saw", "kerf"};
  app.require_subcommand(1);
  app.set_version_flag("--version", [] {
    return fmt::format("kerf {} (commit {}; {})\nbuilt with {}", kerf::VersionString(), kerf::CommitString(),
                       kerf::CompilerString(), kerf::LibrariesString());
  });
  kerf::cli::AddCheckCommand(app);
  kerf::cli::AddExportCommand(app);
  kerf::cli::AddPictureCommand(app);
  kerf::cli::AddInfoCommand(app);
  kerf::cli::AddRunCommand(app);
  kerf::cli::AddImportCommand(app);
  kerf::cli::AddModelCommand(app);
  kerf::cli::AddSceneCommand(app);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    // --help and --version come as "errors" with exit code 0; everything else is bad use.
    const int code = app.exit(e);
    return code == 0 ? 0 : kUsage;
  } catch (const kerf::Error& e) {
    fmt::print(stderr, "kerf: {}\n", e.what());
    return kFailed;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "kerf: not enough memory\n");
    return kFailed;
  } catch (const std::exception& e) {
    fmt::print(stderr, "kerf: {}\n", e.what());
    return kFailed;
  }
}
