#include "app/cli/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/cli/topics.h"
#include "base/files/markdown_text.h"

namespace kerf::cli {
namespace {

using nlohmann::ordered_json;

/// Returns the values listed between braces in a type's name: a and b for "TEXT:{a,b}".
std::vector<std::string> ReadChoices(const std::string& type) {
  const std::size_t open = type.find('{');
  const std::size_t close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  std::vector<std::string> choices = CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
  for (std::string& choice : choices) {
    if (const std::size_t arrow = choice.find("->"); arrow != std::string::npos) choice.resize(arrow);
  }
  return choices;
}

OptionReference ReadOption(const CLI::Option& option) {
  OptionReference out;
  out.positional = option.get_positional();
  if (out.positional) {
    out.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) out.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) out.names.push_back("--" + name);
  }
  if (option.get_type_size() != 0) {
    const std::string type = option.get_type_name();
    out.choices = ReadChoices(type);
    out.value = type.substr(0, type.find(':'));
    out.default_value = option.get_default_str();
  }
  out.help = option.get_description();
  out.required = option.get_required();
  return out;
}

/// Joins the words of a command's name, for the name of a shell function or of a file.
std::string Join(const std::string& name, char separator) {
  std::string joined = name;
  std::replace(joined.begin(), joined.end(), ' ', separator);
  return joined;
}

std::string ToUpper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// Returns the one-line help: the text up to the end of the first sentence, a semicolon, or a reference to a page.
std::string FirstSentence(const std::string& help) {
  std::string text = help;
  for (const char* end : {". ", ";", " (docs/"}) text.resize(std::min(text.size(), text.find(end)));
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

/// Returns the names and the value of an option, such as "-o, --output TEXT", or the name of a positional argument.
std::string FormatNames(const OptionReference& option) {
  const bool has_value = !option.positional && !option.value.empty();
  return fmt::format("{}{}", fmt::join(option.names, ", "), has_value ? " " + option.value : "");
}

/// Returns facts to add to the help, such as " One of: a, b. Default: a.".
std::string FormatFacts(const OptionReference& option) {
  std::string facts;
  if (!option.choices.empty()) facts += fmt::format(" One of: {}.", fmt::join(option.choices, ", "));
  if (option.required) {
    facts += " Required.";
  } else if (!option.default_value.empty()) {
    facts += fmt::format(" Default: {}.", option.default_value);
  }
  return facts;
}

std::string WithPeriod(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

std::string FormatUsage(const CommandReference& command) {
  std::string usage = command.name;
  if (!command.options.empty()) usage += " [OPTIONS]";
  for (const OptionReference& option : command.options) {
    if (option.positional) usage += option.required ? " " + option.names[0] : " [" + option.names[0] + "]";
  }
  if (!command.commands.empty()) usage += " COMMAND";
  return usage;
}

/// Escapes text for a roff page, so that no character begins a request or an escape.
std::string EscapeRoff(const std::string& text) {
  std::string out;
  bool line_start = true;
  for (const char c : text) {
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
    line_start = c == '\n';
  }
  return out;
}

/// Encloses text in single quotes for a shell.
std::string QuoteShell(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Escapes a description for the brackets of zsh's _arguments.
std::string EscapeZsh(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// Returns the last words of the names of the direct subcommands of `command`.
std::vector<std::string> ListWords(const CommandReference& command) {
  std::vector<std::string> words;
  for (const CommandReference& child : command.commands) words.push_back(child.name.substr(child.name.rfind(' ') + 1));
  return words;
}

void ForEach(const CommandReference& command, const std::function<void(const CommandReference&)>& visit) {
  visit(command);
  for (const CommandReference& child : command.commands) ForEach(child, visit);
}

ordered_json MakeJson(const CommandReference& command) {
  ordered_json json;
  json["name"] = command.name;
  json["group"] = command.group;
  json["help"] = command.help;
  json["example"] = command.example;
  json["options"] = ordered_json::array();
  for (const OptionReference& option : command.options) {
    json["options"].push_back({{"names", option.names},
                               {"value", option.value},
                               {"default", option.default_value},
                               {"choices", option.choices},
                               {"required", option.required},
                               {"positional", option.positional},
                               {"help", option.help}});
  }
  json["commands"] = ordered_json::array();
  for (const CommandReference& child : command.commands) json["commands"].push_back(MakeJson(child));
  return json;
}

}  // namespace

CommandReference MakeReference(const CLI::App& app) {
  CommandReference out;
  out.name = app.get_name();
  for (const CLI::App* parent = app.get_parent(); parent != nullptr; parent = parent->get_parent()) {
    out.name = parent->get_name() + " " + out.name;
  }
  out.group = app.get_group();
  out.help = app.get_description();
  if (const std::string footer = app.get_footer(); footer.starts_with("Example:\n  ")) out.example = footer.substr(11);
  for (const CLI::Option* option : app.get_options()) out.options.push_back(ReadOption(*option));
  for (const CLI::App* command : app.get_subcommands({})) out.commands.push_back(MakeReference(*command));
  return out;
}

std::string FormatReferenceMarkdown(const CommandReference& root) {
  std::string out = "| command | what it does |\n|---|---|\n";
  std::string group;
  for (const CommandReference& command : root.commands) {
    if (command.group != group) out += fmt::format("| **{}** | |\n", group = command.group);
    // A command with subcommands has no section, so link to that of its first subcommand.
    const std::string& linked = command.commands.empty() ? command.name : command.commands.front().name;
    out += fmt::format("| [`{}`](#{}) | {} |\n", command.name, Join(linked, '-'),
                       EscapeMarkdown(FirstSentence(command.help)));
  }
  ForEach(root, [&](const CommandReference& command) {
    if (!command.commands.empty()) return;
    out += fmt::format("\n## {}\n\n{}\n\n    {}\n", command.name, EscapeMarkdown(WithPeriod(command.help)),
                       FormatUsage(command));
    if (!command.example.empty()) out += fmt::format("\nExample:\n\n    {}\n", command.example);
    out += "\n| option | meaning |\n|---|---|\n";
    for (const OptionReference& option : command.options) {
      out += fmt::format("| `{}` | {}{} |\n", FormatNames(option), EscapeMarkdown(WithPeriod(option.help)),
                         EscapeMarkdown(FormatFacts(option)));
    }
  });
  return out;
}

std::string FormatReferenceJson(const CommandReference& root) {
  return MakeJson(root).dump(2) + "\n";
}

std::string ManPageName(const CommandReference& command) {
  return Join(command.name, '-') + ".1";
}

std::string FormatManPage(const CommandReference& command, const std::string& version) {
  const std::string title = EscapeRoff(Join(command.name, '-'));
  std::string out = fmt::format(".TH \"{}\" 1 \"\" \"kerf {}\" \"kerf manual\"\n.SH NAME\n{} \\- {}\n", title,
                                EscapeRoff(version), title, EscapeRoff(FirstSentence(command.help)));
  out += fmt::format(".SH SYNOPSIS\n.B {}\n", EscapeRoff(FormatUsage(command)));
  out += fmt::format(".SH DESCRIPTION\n{}\n", EscapeRoff(WithPeriod(command.help)));
  if (!command.commands.empty()) {
    std::string group;
    for (const CommandReference& child : command.commands) {
      if (child.group != group) {
        group = child.group;
        out += fmt::format(".SH \"{}\"\n", group == "Subcommands" ? "COMMANDS" : ToUpper(group));
      }
      out += fmt::format(".TP\n.B {}\n{}\n", EscapeRoff(child.name), EscapeRoff(FirstSentence(child.help)));
    }
  }
  if (!command.options.empty()) {
    out += ".SH OPTIONS\n";
    for (const OptionReference& option : command.options) {
      out += fmt::format(".TP\n.B {}\n{}{}\n", EscapeRoff(FormatNames(option)), EscapeRoff(WithPeriod(option.help)),
                         EscapeRoff(FormatFacts(option)));
    }
  }
  if (!command.example.empty()) out += fmt::format(".SH EXAMPLE\n.nf\n{}\n.fi\n", EscapeRoff(command.example));
  if (command.name == "kerf") {
    for (const Topic& topic : Topics()) {
      out += fmt::format(".SH \"{}\"\n.nf\n{}\n.fi\n", ToUpper(topic.name), EscapeRoff(topic.text));
    }
  } else {
    out += ".SH SEE ALSO\n.BR kerf (1)\n";
  }
  return out;
}

std::string FormatBashCompletion(const CommandReference& root) {
  std::string words;
  std::string values;
  ForEach(root, [&](const CommandReference& command) {
    std::vector<std::string> names = ListWords(command.name == "kerf help" ? root : command);
    bool takes_file = false;
    for (const OptionReference& option : command.options) {
      if (option.positional) {
        names.insert(names.end(), option.choices.begin(), option.choices.end());
        takes_file = takes_file || option.choices.empty();
        continue;
      }
      names.insert(names.end(), option.names.begin(), option.names.end());
      if (option.value.empty()) continue;
      std::string patterns;
      for (const std::string& name : option.names)
        patterns += fmt::format("{}'{}|{}'", patterns.empty() ? "" : "|", command.name, name);
      values += fmt::format("    {}) values={} files={} ;;\n", patterns,
                            QuoteShell(fmt::format("{}", fmt::join(option.choices, " "))),
                            option.choices.empty() && option.value == "TEXT" ? "yes" : "");
    }
    words += fmt::format("      '{}') words={} files={} ;;\n", command.name,
                         QuoteShell(fmt::format("{}", fmt::join(names, " "))), takes_file ? "yes" : "");
  });
  std::string paths;
  ForEach(root, [&](const CommandReference& command) {
    paths += fmt::format("{}'{}'", paths.empty() ? "" : "|", command.name);
  });
  return fmt::format(R"(# Bash completion of kerf, written by 'kerf completion bash'.
_kerf() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} command=kerf i words= values=none files=
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$command ${{COMP_WORDS[i]}}" in
      {paths}) command="$command ${{COMP_WORDS[i]}}" ;;
    esac
  done
  # After an option that takes a value: its choices, a file, or nothing for a number.
  case "$command|${{COMP_WORDS[COMP_CWORD-1]}}" in
{values}  esac
  if [ "$values" = none ]; then
    case $command in
{words}    esac
  else
    words=$values
  fi
  COMPREPLY=($(compgen -W "$words" -- "$current"))
  [[ -z $files || $current == -* ]] || COMPREPLY+=($(compgen -f -- "$current"))
}}
complete -o filenames -F _kerf kerf
)",
                     fmt::arg("paths", paths), fmt::arg("values", values), fmt::arg("words", words));
}

std::string FormatZshCompletion(const CommandReference& root) {
  std::string functions;
  ForEach(root, [&](const CommandReference& command) {
    std::string arguments;
    int position = 0;
    for (const OptionReference& option : command.options) {
      const std::string help = EscapeZsh(FirstSentence(option.help));
      const std::string action = !option.choices.empty()  ? fmt::format("({})", fmt::join(option.choices, " "))
                                 : option.value == "TEXT" ? "_files"
                                                          : "";
      if (option.positional) {
        arguments +=
            fmt::format(" \\\n    {}", QuoteShell(fmt::format("{}:{}:{}", ++position, option.names[0], action)));
        continue;
      }
      for (const std::string& name : option.names) {
        const std::string value = option.value.empty() ? "" : fmt::format(":{}:{}", EscapeZsh(option.value), action);
        arguments += fmt::format(" \\\n    {}", QuoteShell(fmt::format("{}[{}]{}", name, help, value)));
      }
    }
    const std::string function = "_" + Join(command.name, '_');
    if (command.commands.empty()) {
      const std::string rest = command.name == "kerf help"
                                   ? fmt::format("*:command:({})", fmt::join(ListWords(root), " "))
                                   : "*:file:_files";
      functions += fmt::format("{}() {{\n  _arguments{} \\\n    '{}'\n}}\n", function, arguments, rest);
      return;
    }
    std::string list;
    std::string calls;
    for (const CommandReference& child : command.commands) {
      const std::string word = child.name.substr(child.name.rfind(' ') + 1);
      list += fmt::format("    {}\n", QuoteShell(fmt::format("{}:{}", word, EscapeZsh(FirstSentence(child.help)))));
      calls += fmt::format("        {}) _{} ;;\n", word, Join(child.name, '_'));
    }
    functions += fmt::format(
        "{}() {{\n  local line state\n  local -a commands\n  commands=(\n{}  )\n  _arguments -C{} \\\n    '1: "
        ":->command' \\\n"
        "    '*::argument:->argument'\n  case $state in\n    command) _describe command commands ;;\n    argument)\n"
        "      case $line[1] in\n{}      esac\n      ;;\n  esac\n}}\n",
        function, list, arguments, calls);
  });
  return "#compdef kerf\n# Zsh completion of kerf, written by 'kerf completion zsh'.\n" + functions +
         "if [ \"$funcstack[1]\" = _kerf ]; then\n  _kerf \"$@\"\nelse\n  compdef _kerf kerf\nfi\n";
}

std::string FormatFishCompletion(const CommandReference& root) {
  std::string out = "# Fish completion of kerf, written by 'kerf completion fish'.\n";
  ForEach(root, [&](const CommandReference& command) {
    // Shell condition: this command has been typed, but none of its subcommands.
    std::string condition;
    std::vector<std::string> path = CLI::detail::split(command.name, ' ');
    for (std::size_t i = 1; i < path.size(); ++i) {
      condition += fmt::format("{}__fish_seen_subcommand_from {}", condition.empty() ? "" : "; and ", path[i]);
    }
    const std::vector<std::string> children = ListWords(command);
    if (!children.empty()) {
      condition += fmt::format("{}not __fish_seen_subcommand_from {}", condition.empty() ? "" : "; and ",
                               fmt::join(children, " "));
    }
    for (const CommandReference& child : command.commands) {
      out += fmt::format("complete -c kerf -n {} -f -a {} -d {}\n", QuoteShell(condition),
                         child.name.substr(child.name.rfind(' ') + 1), QuoteShell(FirstSentence(child.help)));
    }
    if (command.name == "kerf help") {
      out += fmt::format("complete -c kerf -n {} -f -a {}\n", QuoteShell(condition),
                         QuoteShell(fmt::format("{}", fmt::join(ListWords(root), " "))));
    }
    for (const OptionReference& option : command.options) {
      std::string line = fmt::format("complete -c kerf -n {}", QuoteShell(condition));
      if (option.positional) {
        if (option.choices.empty()) continue;
        out += fmt::format("{} -f -a {}\n", line, QuoteShell(fmt::format("{}", fmt::join(option.choices, " "))));
        continue;
      }
      for (const std::string& name : option.names) {
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!option.value.empty()) line += " -r";
      if (!option.choices.empty())
        line += fmt::format(" -f -a {}", QuoteShell(fmt::format("{}", fmt::join(option.choices, " "))));
      out += fmt::format("{} -d {}\n", line, QuoteShell(FirstSentence(option.help)));
    }
  });
  return out;
}

}  // namespace kerf::cli
