// Tests of help, topics, reference, manual pages and shell completions, which are all printed from the parser of the
// command line.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Reference : public test::ProgramTest {
 protected:
  /// Calls `visit` for each command, parents first.
  void ForEachCommand(const std::function<void(const Json&)>& visit) const {
    const ProgramResult result = Kerf("reference --json");
    ASSERT_EQ(result.code, 0) << result.err;
    const std::function<void(const Json&)> walk = [&](const Json& command) {
      visit(command);
      for (const Json& child : command["commands"]) walk(child);
    };
    walk(Json::parse(result.out));
  }

  /// Returns the output of a command of another program, with -1 in `code` if the shell cannot run it.
  ProgramResult Shell(const std::string& command) const {
    const int status =
        std::system(("cd '" + folder_.string() + "' && " + command + " >o.txt 2>e.txt </dev/null").c_str());
    return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
            .out = test::Slurp(folder_ / "o.txt"),
            .err = test::Slurp(folder_ / "e.txt")};
  }
  bool Has(const std::string& program) const { return Shell("command -v " + program).code == 0; }
};

TEST_F(Reference, EveryCommandHasGroupHelpAndAValidExample) {
  const std::set<std::string> groups{"Make a bone", "Cut", "Look", "Practise", "Measure", "Devices", "Help"};
  std::vector<std::string> lacking;
  int commands = 0;
  ForEachCommand([&](const Json& command) {
    const std::string name = command["name"];
    if (name == "kerf" || name == "kerf help") return;
    if (std::string(command["help"]).starts_with("Not in this build")) return;
    ++commands;
    if (std::count(name.begin(), name.end(), ' ') == 1) {
      EXPECT_EQ(groups.count(command["group"]), 1u) << name;
    }
    const std::string example = command["example"];
    if (example.empty()) lacking.push_back(name);
    // An example begins with the command's own name, and each of its options exists.
    EXPECT_TRUE(example.starts_with(name)) << name << ": " << example;
    std::set<std::string> options;
    const std::function<void(const Json&)> add = [&](const Json& at) {
      for (const Json& option : at["options"]) {
        for (const std::string option_name : option["names"]) options.insert(option_name);
      }
      for (const Json& child : at["commands"]) add(child);
    };
    add(command);
    std::istringstream words(example);
    for (std::string word; words >> word;) {
      if (word.starts_with("-")) {
        EXPECT_EQ(options.count(word), 1u) << example;
      }
    }
  });
  EXPECT_THAT(lacking, IsEmpty());
  EXPECT_GT(commands, 20);
}

TEST_F(Reference, HelpListsTheGroupsInOrder) {
  const std::string help = Kerf("--help").out;
  std::size_t at = 0;
  for (const char* group :
       {"\nMake a bone:", "\nCut:", "\nLook:", "\nPractise:", "\nMeasure:", "\nDevices:", "\nHelp:", "\nTopics"}) {
    const std::size_t found = help.find(group, at);
    ASSERT_NE(found, std::string::npos) << group << "\n" << help;
    at = found;
  }
}

TEST_F(Reference, HelpAcceptsTopicsAndCommands) {
  for (const char* topic : {"workflow", "units", "files", "exit-codes", "environment"}) {
    const ProgramResult result = Kerf(std::string("help ") + topic);
    EXPECT_EQ(result.code, 0) << topic;
    EXPECT_GT(result.out.size(), 200u) << topic;
    EXPECT_EQ(result.err, "") << topic;
    EXPECT_THAT(Kerf("help").out, HasSubstr(topic));
  }
  EXPECT_EQ(Kerf("help info").out, Kerf("info --help").out);
  EXPECT_EQ(Kerf("help nonsense").code, 2);
}

TEST_F(Reference, HelpShowsDefaultsAndAnExample) {
  const std::string help = Kerf("model block --help").out;
  EXPECT_THAT(help, HasSubstr("Example:\n  kerf model block"));
  EXPECT_THAT(help, ContainsRegex("--voxel FLOAT(=0\\.1| \\[0\\.1\\]) "));  // CLI11 2.4 writes [0.1]
}

TEST_F(Reference, PagesOfTheDocumentationMatchTheProgram) {
  const ProgramResult reference = Kerf("reference");
  ASSERT_EQ(reference.code, 0) << reference.err;
  if (reference.out.find("Not in this build") != std::string::npos) GTEST_SKIP() << "parts are left out of this build";
  EXPECT_THAT(test::Slurp(KERF_SOURCE_DIR "/docs/commands.md"), HasSubstr(reference.out)) << "run tools/docs --pages";
  EXPECT_THAT(test::Slurp(KERF_SOURCE_DIR "/docs/scene_keys.md"), HasSubstr(Kerf("scene --defaults").out))
      << "run tools/docs --pages";
  const std::string formats = test::Slurp(KERF_SOURCE_DIR "/docs/formats.md");
  const std::string columns = Kerf("reference --columns").out;
  const std::string end = "<!-- end -->\n";
  int sections = 0;
  for (std::size_t from = 0; from < columns.size(); ++sections) {
    const std::size_t to = columns.find(end, from) + end.size();
    EXPECT_THAT(formats, HasSubstr(columns.substr(from, to - from))) << "run tools/docs --pages";
    from = to;
  }
  EXPECT_GE(sections, 18);
}

TEST_F(Reference, ManualPagesAreAcceptedByGroffWithoutWarnings) {
  ASSERT_EQ(Kerf("reference --man man").code, 0);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "man")) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, testing::IsSupersetOf({"kerf.1", "kerf-run.1", "kerf-device-test.1"}));
  const std::string run = test::Slurp(folder_ / "man" / "kerf-run.1");
  EXPECT_THAT(run, HasSubstr(".SH NAME\nkerf\\-run \\- "));
  EXPECT_THAT(run, HasSubstr(".SH EXAMPLE"));
  if (!Has("groff")) GTEST_SKIP() << "groff is not installed";
  const ProgramResult check = Shell("groff -man -Tutf8 -ww -z man/*.1");
  EXPECT_EQ(check.code, 0);
  EXPECT_EQ(check.err, "");
}

TEST_F(Reference, BashCompletesCommandsOptionsAndChoices) {
  const ProgramResult script = Kerf("completion bash");
  ASSERT_EQ(script.code, 0) << script.err;
  Write("kerf.bash", script.out);
  const auto complete = [&](const std::string& line) {
    // These are the words of the line, of which the last one is being completed.
    Write("ask.bash",
          fmt::format("source ./kerf.bash\nCOMP_WORDS=({})\nCOMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n_kerf\n"
                      "printf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
                      line));
    const ProgramResult result = Shell("bash ask.bash");
    EXPECT_EQ(result.err, "") << line;
    return result.out;
  };
  EXPECT_EQ(complete("kerf stab"), "stability\n");
  EXPECT_THAT(complete("kerf run --o"), HasSubstr("--output\n"));
  EXPECT_THAT(complete("kerf device ''"), HasSubstr("test\n"));
  EXPECT_EQ(complete("kerf completion z"), "zsh\n");
  EXPECT_EQ(complete("kerf loop --hand H"), "H0\nH1\nH2\nH3\nH4\n");
  // After an option that takes a file, the completions are files and not options.
  EXPECT_THAT(complete("kerf run -o ''"), HasSubstr("kerf.bash"));
  EXPECT_THAT(complete("kerf run -o ''"), Not(HasSubstr("--")));
  // Where a command, a shell or a number is expected, no files are offered.
  EXPECT_THAT(complete("kerf run ker"), HasSubstr("kerf.bash"));
  EXPECT_EQ(complete("kerf ker"), "\n");
  EXPECT_EQ(complete("kerf completion ker"), "\n");
  EXPECT_EQ(complete("kerf run --seed ''"), "\n");
  EXPECT_EQ(complete("kerf help reh"), "rehearse\n");
}

TEST_F(Reference, ZshAndFishAcceptTheirScripts) {
  for (const std::string shell : {"zsh", "fish"}) {
    const ProgramResult script = Kerf("completion " + shell);
    ASSERT_EQ(script.code, 0) << script.err;
    for (const char* word : {"stability", "seconds", "zsh"}) EXPECT_THAT(script.out, HasSubstr(word));
    Write("kerf." + shell, script.out);
    if (!Has(shell)) continue;
    const ProgramResult check = Shell(fmt::format("{0} -n kerf.{0}", shell));
    EXPECT_EQ(check.code, 0) << check.err;
    EXPECT_EQ(check.err, "");
  }
  if (Has("fish")) {
    EXPECT_THAT(Shell("fish -c 'source kerf.fish; complete -C \"kerf stab\"'").out, testing::StartsWith("stability"));
    EXPECT_THAT(Shell("fish -c 'source kerf.fish; complete -C \"kerf run --out\"'").out, HasSubstr("--output"));
    EXPECT_EQ(Shell("fish -c 'source kerf.fish; complete -C \"kerf help reh\"'").out.substr(0, 8), "rehearse");
  }
}

TEST_F(Reference, BadUsageIsRefused) {
  for (const char* arguments : {"completion", "completion tcsh", "reference --json --man x", "reference x"}) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
  }
  Write("file", "");
  ExpectRefusal(Kerf("reference --man file/man"), "file/man: the folder can't be created: Not a directory");
}

}  // namespace
}  // namespace kerf
