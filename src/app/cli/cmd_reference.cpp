#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/reference.h"
#include "base/files/files.h"
#include "kerf/version.h"

namespace kerf::cli {
namespace {

/// Makes the reference of the whole program. `command`: any of its commands.
CommandReference MakeProgramReference(const CLI::App& command) {
  return MakeReference(*command.get_parent());
}

void WriteManPages(const CommandReference& command, const std::string& folder) {
  WriteTextFile((std::filesystem::path(folder) / ManPageName(command)).string(),
                FormatManPage(command, VersionString()));
  for (const CommandReference& child : command.commands) WriteManPages(child, folder);
}

}  // namespace

void AddReferenceCommand(CLI::App& app) {
  struct Options {
    std::string folder;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "reference", "Print the reference of all commands as Markdown, or write the manual pages into a folder");
  CLI::Option* man =
      command->add_option("--man", options->folder, "Write manual pages (kerf.1, kerf-run.1, ...) into this folder");
  command->add_flag("--json", options->json, "Print as JSON")->excludes(man);
  command->callback([options, command] {
    const CommandReference root = MakeProgramReference(*command);
    if (!options->folder.empty()) {
      MakeFolder(options->folder);
      WriteManPages(root, options->folder);
    } else {
      fmt::print("{}", options->json ? FormatReferenceJson(root) : FormatReferenceMarkdown(root));
    }
  });
}

void AddCompletionCommand(CLI::App& app) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "Print a completion script for a shell: commands, options, files");
  command->add_option("SHELL", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell, command] {
    const CommandReference root = MakeProgramReference(*command);
    fmt::print("{}", *shell == "bash"  ? FormatBashCompletion(root)
                     : *shell == "zsh" ? FormatZshCompletion(root)
                                       : FormatFishCompletion(root));
  });
}

}  // namespace kerf::cli
