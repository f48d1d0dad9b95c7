// Tests that the program that users start is small: --version and --help work without the libraries of the whole
// program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Front : public test::ProgramTest {
 protected:
  /// Returns the output of a shell command in the test's folder.
  std::string Shell(const std::string& command) const {
    const std::string file = (folder_ / "shell.txt").string();
    const int status = std::system(("cd '" + folder_.string() + "' && " + command + " >'" + file + "' 2>&1").c_str());
    return test::Slurp(file) + (status == 0 ? "" : "failed");
  }
};

TEST_F(Front, PrintsTheSameAsTheWholeProgram) {
  for (const char* option : {"--version", "--help", "-h"}) {
    const test::ProgramResult result = Kerf(option);
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.out, Shell(std::string(KERF_PROGRAM "_program ") + option)) << option;
  }
}

TEST_F(Front, LoadsNoneOfTheLibraries) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  if (!KERF_WITH_IMPORT) GTEST_SKIP() << "this build imports no CT";
  // With this variable the loader prints its list instead of running the program. Loading takes nearly all of the 0.1
  // s.
  const std::string loaded = Shell("LD_TRACE_LOADED_OBJECTS=1 '" KERF_PROGRAM "'");
  EXPECT_THAT(loaded, HasSubstr("libc.so"));
  for (const char* library : {"libvtk", "libITK", "libopenvdb", "libgdcm"}) {
    EXPECT_THAT(loaded, Not(HasSubstr(library)));
    EXPECT_THAT(Shell("LD_TRACE_LOADED_OBJECTS=1 '" KERF_PROGRAM "_program'"), HasSubstr(library));
  }
}

TEST_F(Front, WorksThroughALink) {
  fs::create_symlink(KERF_PROGRAM, folder_ / "saw");
  EXPECT_EQ(Shell("./saw --version"), Kerf("--version").out);
  EXPECT_EQ(Shell("./saw scene --defaults"), Kerf("scene --defaults").out);
}

TEST_F(Front, ReportsTheMissingProgram) {
  fs::copy(KERF_PROGRAM, folder_ / "kerf");
  // The front program answers these two itself, without loading anything.
  EXPECT_EQ(Shell("./kerf --version"), Kerf("--version").out);
  EXPECT_EQ(Shell("./kerf --help"), Kerf("--help").out);
  EXPECT_THAT(Shell("./kerf info x.vdb"),
              testing::MatchesRegex("kerf: .*/kerf_program, a part of kerf, can't be started: No such file or "
                                    "directory\nfailed"));
}

}  // namespace
}  // namespace kerf
