#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "app/cli/command_list.h"
#include "app/cli/exit_codes.h"
#include "app/cli/lack_of_memory.h"
#include "app/cli/message.h"
#include "app/cli/signals.h"
#include "app/cli/topics.h"
#include "base/core/errno_text.h"
#include "base/core/nearest_name.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/bone_cache.h"

namespace {

using kerf::cli::kFailed;
using kerf::cli::kUsage;

/// Returns the arguments; "kerf help run" becomes "kerf run --help".
std::vector<std::string> ReadArguments(int argc, char** argv) {
  std::vector<std::string> arguments;
  for (int i = 1; i < argc; ++i) arguments.emplace_back(argv[i]);
  if (!arguments.empty() && arguments.front() == "help") {
    arguments.erase(arguments.begin());
    arguments.emplace_back("--help");
  }
  return arguments;
}

/// Returns a message about a first word that is not a command; "" if it is a command or an option. CLI11 would only
/// report that a command is missing.
std::string FindUnknownCommand(const CLI::App& app, const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments.front().starts_with('-')) return "";
  const std::string& word = arguments.front();
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return "";
  const std::string nearest = kerf::FindNearestName(word, names);
  return fmt::format("unknown command \"{}\"{}; 'kerf --help' lists them", word,
                     nearest.empty() ? "" : fmt::format("; the nearest is \"{}\"", nearest));
}

/// Returns the list of topics at the end of `kerf --help`.
std::string ListTopics() {
  std::string text = "Topics ('kerf help TOPIC'):";
  for (const kerf::cli::Topic& topic : kerf::cli::Topics()) {
    text += fmt::format("\n  {:<28}{}", topic.name, topic.summary);
  }
  return text;
}

/// Returns the part of the command that was parsed, such as "kerf model block".
std::string NameParsedCommand(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
    at = at->get_subcommands().front();
    name += " " + at->get_name();
  }
  return name;
}

/// Returns a message about the first unknown option; "" if there is none. CLI11 would list all words that it did not
/// expect, or report first that something else is missing.
std::string FindUnknownOption(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* at = &app;; at = at->get_subcommands().front(), name += " " + at->get_name()) {
    std::vector<std::string> names;
    for (const CLI::Option* option : at->get_options()) {
      for (const std::string& long_name : option->get_lnames()) names.push_back(long_name);
    }
    for (const std::string& word : at->remaining()) {
      if (word.size() < 3 || !word.starts_with("--")) continue;
      const std::string option = word.substr(2, word.find('=') - 2);
      const std::string nearest = kerf::FindNearestName(option, names);
      return fmt::format("unknown option --{}{}; see '{} --help'", option,
                         nearest.empty() ? "" : fmt::format("; the nearest is --{}", nearest), name);
    }
    if (at->get_subcommands().empty()) return "";
  }
}

/// Flushes the output and returns the exit code. Lost output, for example on a full disk, is a failure.
int FlushOutput(int code) {
  errno = 0;
  std::cout.flush();
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
  if (!lost) return code;
  const std::string reason = errno == 0 ? "" : ": " + kerf::FormatErrno(errno);
  kerf::cli::Say("standard output can't be written{}", reason);
  return code == 0 ? kFailed : code;
}

int RunProgram(int argc, char** argv) {
  CLI::App app{"kerf: a simulator of cutting bone with a saw", "kerf"};
  app.require_subcommand(1);
  app.set_version_flag("--version", [] {
    return fmt::format("kerf {} (commit {}; {})\nbuilt with {}", kerf::VersionString(), kerf::CommitString(),
                       kerf::CompilerString(), kerf::LibrariesString());
  });
  kerf::cli::AddCommands(app);
  kerf::SetBoneCache(kerf::FindBoneCache());
  app.add_subcommand("help", "Show this list, the help of a command or a topic")->group("Help");
  app.footer(ListTopics());

  using kerf::cli::Say;
  const std::vector<std::string> arguments = ReadArguments(argc, argv);
  if (argc == 3 && std::string_view(argv[1]) == "help") {
    if (const kerf::cli::Topic* topic = kerf::cli::FindTopic(argv[2]); topic != nullptr) {
      fmt::print("{}\n\n{}\n", topic->summary, topic->text);
      return 0;
    }
  }
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 takes them in reverse order
    return 0;
  } catch (const CLI::ParseError& e) {
    // --help and --version are "errors" with exit code 0; everything else is bad usage.
    if (const std::string unknown = FindUnknownCommand(app, arguments); !unknown.empty()) {
      Say("{}", unknown);
      return kUsage;
    }
    if (e.get_exit_code() == 0) return app.exit(e);
    if (const std::string unknown = FindUnknownOption(app); !unknown.empty()) {
      Say("{}", unknown);
      return kUsage;
    }
    Say("{}; see '{} --help'", e.what(), NameParsedCommand(app));
    return kUsage;
  } catch (const kerf::cli::ReadDamaged&) {
    return kerf::cli::kReadDamaged;
  } catch (const kerf::Error& e) {
    Say("{}", e.what());
    return kFailed;
  } catch (const std::bad_alloc&) {
    kerf::cli::EndWithoutMemory();
  } catch (const std::system_error& e) {
    if (std::ferror(stdout) == 0) Say("{}", e.what());  // otherwise FlushOutput() reports it
    return kFailed;
  } catch (const std::exception& e) {
    Say("{}", e.what());
    return kFailed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  kerf::cli::HandleSignals();
  kerf::cli::HandleLackOfMemory();
  try {
    const int code = RunProgram(argc, argv);
    kerf::FinishKeepingBones();
    kerf::cli::PrintLeftOutMessages();
    return FlushOutput(code);
  } catch (const std::bad_alloc&) {
    kerf::cli::EndWithoutMemory();
  }
}
