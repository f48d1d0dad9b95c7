// Tests of the program's messages besides its results, and of its hints on usage.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;

class Messages : public test::ProgramTest {};

TEST_F(Messages, HelpIsACommandToo) {
  const ProgramResult all = Kerf("help");
  EXPECT_EQ(all.code, 0);
  EXPECT_EQ(all.err, "");
  EXPECT_EQ(all.out, Kerf("--help").out);
  EXPECT_THAT(all.out, HasSubstr("\n  help "));
  for (const char* command : {"run", "model block"}) {
    const ProgramResult one = Kerf(std::string("help ") + command);
    EXPECT_EQ(one.code, 0) << command;
    EXPECT_EQ(one.out, Kerf(std::string(command) + " --help").out) << command;
    EXPECT_THAT(one.out, HasSubstr("Usage:")) << command;
  }
  const ProgramResult unknown = Kerf("help rnu");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_EQ(unknown.err, "kerf: unknown command \"rnu\"; the nearest is \"run\"; 'kerf --help' lists them\n");
}

TEST_F(Messages, BadUsageRefersToTheCommandsHelp) {
  EXPECT_EQ(Kerf("").err, "kerf: A subcommand is required; see 'kerf --help'\n");
  EXPECT_EQ(Kerf("info").err, "kerf: BONE is required; see 'kerf info --help'\n");
  EXPECT_THAT(Kerf("model block --colour red").err, HasSubstr("; see 'kerf model block --help'\n"));
}

TEST_F(Messages, LostMessagesDoNotChangeTheExitCode) {
  for (const char* lost : {"2>&-", "2>/dev/full"}) {
    for (const auto& [arguments, code] : {std::pair("nosuch", 2), std::pair("info none.vdb", 1)}) {
      const int status = std::system((std::string(KERF_PROGRAM " ") + arguments + " " + lost).c_str());
      EXPECT_EQ(WEXITSTATUS(status), code) << arguments << " " << lost;
    }
  }
}

TEST_F(Messages, OfOneKindAreCountedAfterTheFirstTen) {
  constexpr int kStrokes = 30;
  std::string scene = "[bone]\nmodel = \"block\"\n";
  for (int i = 0; i < kStrokes; ++i) {
    scene += fmt::format(
        "[[path.stroke]]\nstart_mm = [0.0, 0.0, 9.0]\nend_mm = [1.0, 0.0, 9.0]\ndisc_normal = [0.0, 1.0, 0.0]\n"
        "feed_mm_per_s = -{}.5\n",
        i + 1);
  }
  Write("faults.toml", scene + "[nonsense]\n");
  const ProgramResult result = Kerf("check faults.toml");
  EXPECT_NE(result.code, 0);
  int lines = 0;
  std::istringstream err(result.err);
  for (std::string line; std::getline(err, line);) lines += line.find("feed_mm_per_s = -") != std::string::npos ? 1 : 0;
  EXPECT_EQ(lines, 12) << result.err;  // ten messages, one stating that further ones are only counted, and the count
  EXPECT_THAT(result.err, HasSubstr("feed_mm_per_s = -10.5"));
  EXPECT_THAT(result.err, testing::Not(HasSubstr("feed_mm_per_s = -12.5")));
  EXPECT_THAT(result.err,
              HasSubstr(fmt::format("kerf: {} more messages like this one were not shown: ", kStrokes - 11)));
  EXPECT_THAT(result.err, HasSubstr("nonsense"));
}

// Messages quote file contents, but bytes that are not text must not reach the terminal.
TEST_F(Messages, QuoteNoControlCharactersAndNoInvalidUtf8) {
  const auto quoted = [this](const std::string& name) {
    std::string err = Kerf("info '" + name + "'").err;
    return err.substr(0, err.find(':', 6));
  };
  EXPECT_EQ(quoted("b\xc3\xb6n\xe2\x82\xac\xf0\x9f\xa6\xb4"), "kerf: b\xc3\xb6n\xe2\x82\xac\xf0\x9f\xa6\xb4");
  EXPECT_EQ(quoted("a\x1b[31mb\x7f"), "kerf: a?[31mb?");
  EXPECT_EQ(quoted("a\x94z"), "kerf: a?z");
  EXPECT_EQ(quoted("a\xc2\x9bz\xc2\xa0"), "kerf: a?z\xc2\xa0");  // U+009B, and U+00A0, which is not a control character
  EXPECT_EQ(quoted("a\xc1\xbfz\xe0\x80\xafz"), "kerf: a??z???z");          // overlong encodings
  EXPECT_EQ(quoted("a\xed\xa0\x80z\xf4\x90\x80\x80"), "kerf: a???z????");  // a surrogate, and above U+10FFFF
  EXPECT_EQ(quoted("a\xe2\x82"), "kerf: a??");                             // truncated
}

// Filtering stderr by the prefix must find every message.
TEST_F(Messages, EachBeginsWithTheProgramsName) {
  Write("faults.toml", "[bone]\nmodel = \"block\"\nsise = 1\n[tool]\nteeht = 3\n[nonsense]\n");
  Write("not.stl", "solid\n");
  for (const char* arguments : {"",
                                "saw",
                                "run",
                                "run --colour",
                                "info a b",
                                "effects --all",
                                "effects nonsense",
                                "study a.toml b.toml",
                                "study none.toml",
                                "check faults.toml",
                                "run faults.toml -o out",
                                "info none.vdb",
                                "import not.stl -o a.vdb",
                                "import . -o a.vdb",
                                "picture none.vdb -o a.png",
                                "picture none.vdb -o a.txt",
                                "replay none.kerf",
                                "tune none.toml",
                                "export none.vdb",
                                "materials --nonsense"}) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_NE(result.code, 0) << arguments;
    EXPECT_NE(result.err, "") << arguments;
    std::istringstream lines(result.err);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(line.starts_with("kerf: ") || line.starts_with(" ")) << arguments << ": " << line;
    }
  }
}

TEST_F(Messages, SceneWithAMissingBoneSuggestsTheImport) {
  Write("scene.toml",
        "[bone]\nfile = \"jaw.vdb\"\n[[path.stroke]]\nstart_mm = [0, 0, 30]\nend_mm = [0, 0, 20]\n"
        "feed_mm_per_s = 3\ndisc_normal = [0, 1, 0]\n");
  const std::string bone = (folder_ / "jaw.vdb").string();
  for (const char* arguments : {"run scene.toml -o out", "check scene.toml"}) {
    ExpectRefusal(Kerf(arguments),
                  fmt::format("{0}: there is no such file; 'kerf import INPUT -o {0}' makes it from a CT or a closed "
                              "surface",
                              bone));
  }
}

}  // namespace
}  // namespace kerf
