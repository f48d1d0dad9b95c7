// Reference of the command line, read from the parser; source of Markdown, JSON, man pages and shell completions.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace kerf::cli {

struct OptionReference {
  std::vector<std::string> names;  // with dashes, short ones first; for a positional argument, its name
  std::string value;               // "TEXT", "FLOAT", ...; "" for a flag
  std::string default_value;       // "" if there is none
  std::string help;
  std::vector<std::string> choices;  // values accepted; empty if any
  bool required = false;
  bool positional = false;
};

struct CommandReference {
  std::string name;  // with its parents: "kerf device test"
  std::string group;
  std::string help;
  std::string example;  // "" if there is none
  std::vector<OptionReference> options;
  std::vector<CommandReference> commands;
};

/// Reads the reference of `app` and of its commands from the parser.
CommandReference MakeReference(const CLI::App& app);

/// Formats a page for the documentation: a table of the commands by group, and then each command with its options.
std::string FormatReferenceMarkdown(const CommandReference& root);
std::string FormatReferenceJson(const CommandReference& root);
/// Formats the manual page (roff, section 1) of one command. `version`: shown in its footer.
std::string FormatManPage(const CommandReference& command, const std::string& version);
/// Returns the file name of that page, such as "kerf-device-test.1".
std::string ManPageName(const CommandReference& command);

/// These format a completion script for a shell. All three complete commands, options, choices and file names.
std::string FormatBashCompletion(const CommandReference& root);
std::string FormatZshCompletion(const CommandReference& root);
std::string FormatFishCompletion(const CommandReference& root);

}  // namespace kerf::cli
