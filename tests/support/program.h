// Runs the program as a user would, in a separate folder.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "test_paths.h"

namespace kerf::test {

struct ProgramResult {
  int code = -1;  // exit code; 128 + signal if killed by a signal
  std::string out;
  std::string err;
};

inline std::string Slurp(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

class ProgramTest : public testing::Test {
 protected:
  /// `files`: names and contents of files that are written to the folder before the test.
  explicit ProgramTest(std::vector<std::pair<std::string, std::string>> files = {}) : files_(std::move(files)) {}
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::temp_directory_path() / ("kerf_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    for (const auto& [name, content] : files_) Write(name, content);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Runs kerf with `arguments` as typed into a shell; the current folder is folder_.
  ProgramResult Kerf(const std::string& arguments) const { return KerfWithin("", arguments); }

  /// Runs kerf after shell commands that set limits.
  ProgramResult KerfWithin(const std::string& limits, const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() + "' && " + limits + " env -u DISPLAY '" KERF_PROGRAM "' " +
                                arguments + " >stdout.txt 2>stderr.txt </dev/null";
    const int status = std::system(command.c_str());
    ProgramResult result;
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.out = Slurp(folder_ / "stdout.txt");
    result.err = Slurp(folder_ / "stderr.txt");
    SkipIfNotBuilt(result);
    return result;
  }

  void Write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  bool Exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  /// Expects one clear sentence on stderr, nothing on stdout, and exit code 1.
  static void ExpectRefusal(const ProgramResult& result, const std::string& sentence) {
    EXPECT_EQ(result.code, 1);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, "kerf: " + sentence + "\n");
  }

  /// Skips the test if the program reports that this build leaves out the requested part (KERF_WITH_...=OFF).
  static void SkipIfNotBuilt(const ProgramResult& result) {
    const bool is_built = result.err.find("this kerf was built without ") == std::string::npos;
    if (is_built && !result.out.starts_with("Not in this build ")) return;
    [&] { GTEST_SKIP() << result.out << result.err; }();
    throw testing::AssertionException(testing::TestPartResult(testing::TestPartResult::kSkip, __FILE__, __LINE__, ""));
  }

  std::filesystem::path folder_;

 private:
  std::vector<std::pair<std::string, std::string>> files_;
};

}  // namespace kerf::test
