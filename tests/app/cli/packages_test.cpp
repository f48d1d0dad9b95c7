// Tests of the two lists of packages: those for building and running kerf, and the additional ones for tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using testing::Contains;
using testing::Not;

class Packages : public test::ProgramTest {
 protected:
  std::vector<std::string> List(const std::string& options) const {
    const std::string file = (folder_ / "list.txt").string();
    EXPECT_EQ(std::system((KERF_SOURCE_DIR "/tools/setup --list " + options + " >'" + file + "'").c_str()), 0);
    std::vector<std::string> names;
    std::istringstream lines(test::Slurp(file));
    for (std::string name; std::getline(lines, name);) names.push_back(name);
    return names;
  }
};

TEST_F(Packages, TestPackagesAreNotInTheBuildList) {
  const std::vector<std::string> build = List("");
  const std::vector<std::string> all = List("--tests");
  ASSERT_GT(build.size(), 20u);
  for (const char* of_tests :
       {"slurm-wlm", "munge", "umockdev", "libumockdev-dev", "xvfb", "xdotool", "librapidcheck-dev", "libgtest-dev"}) {
    EXPECT_THAT(build, Not(Contains(of_tests)));
    EXPECT_THAT(all, Contains(of_tests));
  }
  // CI uses these on Debian 12; later ones don't have them.
  const bool bookworm = test::Slurp("/etc/os-release").find("VERSION_CODENAME=bookworm\n") != std::string::npos;
  for (const char* clang : {"clang-14", "clang-tidy-14", "clang-format-14"}) {
    EXPECT_THAT(build, Not(Contains(clang)));
    EXPECT_EQ(std::count(all.begin(), all.end(), clang), bookworm ? 1 : 0) << clang;
  }
  for (const std::string& name : build) EXPECT_THAT(all, Contains(name));
  for (const std::string& name : all) EXPECT_EQ(std::count(all.begin(), all.end(), name), 1) << name;
}

TEST_F(Packages, EachScriptInstallsItsOwnList) {
  const auto script = [](const char* name) { return test::Slurp(std::string(KERF_SOURCE_DIR) + name); };
  EXPECT_THAT(script("/tools/run"), testing::HasSubstr("\ntools/setup\n"));
  for (const char* name : {"/tools/test", "/.ci/run"}) {
    EXPECT_THAT(script(name), testing::HasSubstr("\ntools/setup --tests\n"));
    // In these scripts a missing package is an error; it must not reduce the number of tests.
    EXPECT_THAT(script(name), testing::HasSubstr("cmake --preset release -DKERF_BUILD_TESTS=ON"));
  }
}

}  // namespace
}  // namespace kerf
