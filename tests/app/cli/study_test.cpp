// Tests of kerf study as a user runs it.
#include <fcntl.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// The study is coarse, so that a case takes 0.1 s.
constexpr char kStudyToml[] = R"(
title = "Small"
[study]
paths = ["idle"]
holdings = ["path"]
ticks_per_case = 1000
ticks_of_defaults = 1000
reference_tolerance = 0.05
[base]
voxel_mm = 0.4
[[knob]]
name = "rim_samples_per_pitch"
values = [1, 2, 4]
[[knob]]
name = "carve_interval_ticks"
values = [2, 4]
)";
constexpr std::size_t kRecords = 12;

class Study : public test::ProgramTest {
 protected:
  /// Returns the contents of every record, without the times.
  std::map<std::string, std::string> ReadRecords(const std::string& folder) const {
    std::map<std::string, std::string> records;
    if (!fs::exists(folder_ / folder / "cases")) return records;
    for (const auto& entry : fs::directory_iterator(folder_ / folder / "cases")) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with('.')) continue;
      auto json = nlohmann::json::parse(test::Slurp(entry.path()));
      for (const char* key : {"seconds", "costs"}) json.erase(key);
      records[name] = json.dump();
    }
    return records;
  }

  /// Starts the program and kills it with SIGKILL once it has written `count` records.
  void KillAfter(std::size_t count, const std::string& folder) const {
    const pid_t pid = fork();
    if (pid == 0) {
      const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
      for (const int stream : {0, 1, 2}) dup2(nothing, stream);
      if (chdir(folder_.c_str()) == 0) {
        execl(KERF_PROGRAM, KERF_PROGRAM, "study", "small.toml", "-o", folder.c_str(), nullptr);
      }
      _exit(127);
    }
    ASSERT_GT(pid, 0);
    const auto count_now = [&] {
      std::size_t n = 0;
      std::error_code none;
      for (const auto& entry : fs::directory_iterator(folder_ / folder / "cases", none)) {
        if (!entry.path().filename().string().starts_with('.')) ++n;
      }
      return n;
    };
    int status = 0;
    while (count_now() < count && waitpid(pid, &status, WNOHANG) == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
  }
};

TEST_F(Study, ContinuesAfterAKillWithTheSameResults) {
  Write("small.toml", kStudyToml);
  const auto whole = Kerf("study small.toml -o whole --json");
  ASSERT_EQ(whole.code, 0) << whole.err;
  const auto summary = nlohmann::json::parse(whole.out);
  EXPECT_EQ(summary["cases"], kRecords / 2);
  EXPECT_TRUE(summary["failed"].empty());
  for (const char* file : {"cases.csv", "references.csv", "study.json"}) {
    EXPECT_TRUE(Exists(std::string("whole/") + file)) << file;
  }
  const auto records = ReadRecords("whole");
  ASSERT_EQ(records.size(), kRecords);
  KillAfter(3, "killed");
  const std::size_t there = ReadRecords("killed").size();
  EXPECT_GE(there, 3u);
  KillAfter(8, "killed");
  const auto again = Kerf("study small.toml -o killed");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(ReadRecords("killed"), records);
}

TEST_F(Study, LostShardIsNamedAndCanBeAddedLater) {
  Write("small.toml", kStudyToml);
  for (const char* shard : {"0/3", "2/3"}) {
    const auto result = Kerf(std::string("study small.toml -o out --errors-only --shard ") + shard);
    EXPECT_EQ(result.code, 0) << result.err;
  }
  const auto lost = Kerf("study --merge -o out");
  EXPECT_EQ(lost.code, 1);
  EXPECT_THAT(lost.err, HasSubstr("kerf: shard 1/3 is missing: 2 cases: idle.path."));
  EXPECT_THAT(lost.err, Not(HasSubstr("shard 0/3")));
  EXPECT_EQ(Kerf("study small.toml -o elsewhere --errors-only --shard 1/3").code, 0);
  const auto whole = Kerf("study --merge out elsewhere -o all");
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(ReadRecords("all").size(), kRecords / 2);
}

TEST_F(Study, BadUsageIsReportedAndWritesNothing) {
  Write("small.toml", kStudyToml);
  EXPECT_EQ(Kerf("study").code, 2);
  const auto beyond = Kerf("study small.toml --shard 8/8");
  EXPECT_EQ(beyond.code, 2);
  EXPECT_THAT(beyond.err, HasSubstr("counted from 0 (sbatch --array=0-7)"));
  Write("bad.toml", "[study]\nticks_per_case = 1\n");
  const auto bad = Kerf("study bad.toml -o out");
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.err, HasSubstr("bad.toml:2:1: ticks_per_case = 1 is below 1000"));
  EXPECT_EQ(Kerf("study missing.toml -o out").code, 1);
  EXPECT_EQ(Kerf("study --merge -o out").code, 1);
  const auto file = Kerf("study small.toml --merge -o out");
  EXPECT_EQ(file.code, 2);
  EXPECT_THAT(file.err, HasSubstr("small.toml is not a folder; give the folders of the shards, or none"));
  EXPECT_FALSE(Exists("out"));
}

TEST_F(Study, DryRunOnlyListsTheCases) {
  Write("small.toml", kStudyToml);
  const auto result = Kerf("study small.toml -o out --dry-run --json");
  EXPECT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["cases"].size(), kRecords / 2);
  EXPECT_EQ(json["left"], kRecords);
  EXPECT_GT(json["errors_s"], 0);
  EXPECT_FALSE(Exists("out"));
  EXPECT_THAT(Kerf("study small.toml --dry-run").out, HasSubstr("idle.path.rim_samples_per_pitch-4\n"));
}

TEST_F(Study, DefaultsAreAStudy) {
  const auto defaults = Kerf("study --defaults");
  EXPECT_EQ(defaults.code, 0);
  Write("defaults.toml", defaults.out);
  EXPECT_EQ(Kerf("study defaults.toml --dry-run").code, 0);
  // The same plan results without the file, also as JSON.
  const auto planned = Kerf("study defaults.toml --dry-run --json");
  const auto json = nlohmann::json::parse(planned.out, nullptr, false);
  EXPECT_GT(json["cases"].size(), 100u);
  const auto by_default = Kerf("study --dry-run --json");
  EXPECT_EQ(by_default.code, 0) << by_default.err;
  EXPECT_EQ(nlohmann::json::parse(by_default.out, nullptr, false), json);
}

}  // namespace
}  // namespace kerf
