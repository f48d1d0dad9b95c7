// Tests every command that writes, on a disk that is full or read-only, or with a file size limit. Each prints one
// message, damages no earlier file and leaves no incomplete file.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "support/block_scene.h"
#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using test::MakeBlockScene;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

const std::string kFullDiskScene =
    MakeBlockScene({.from_mm = 6.5, .feed_mm_per_s = 6}, "[slab]\ndirection = [0, 0, -1]\n");
constexpr char kEffects[] = "[effects.sound]\n[effects.tangential_force]\n[effects.heat]\n[effects.chips]\n";
constexpr char kOld[] = "old\n";
constexpr char kStudy[] = R"(
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
values = [1, 2]
)";

/// `arguments`: IN stands for the folder of inputs; results go to the current folder. `earlier`: true if results of an
/// earlier run may be there.
struct Command {
  const char* name;
  std::string arguments;
  bool earlier = true;
  const char* list = nullptr;  // file that describes the others, if the command writes several into a folder
};

std::vector<Command> ListCommands() {
  return {{"run", "run IN/effects.toml -o o", true, "o/summary.json"},
          {"run_slab", "run IN/slab.toml -o o", true, "o/summary.json"},
          {"loop", "loop IN/effects.toml --virtual --seconds 1 -o o", true, "o/loop.json"},
          {"slab", "slab IN/b.vdb --plane 0,0,4,1,0,0 --thickness 1 -o o", true, "o/parts.json"},
          {"model", "model block --size 8,8,8 -o b.vdb"},
          {"import", "import IN/b.stl -o b.vdb --voxel 0.2 --units mm"},
          {"export_stl", "export IN/b.vdb -o x.stl"},
          {"export_obj", "export IN/b.vdb -o x.obj"},
          {"export_ply", "export IN/b.vdb -o x.ply"},
          {"picture", "picture IN/b.vdb -o p.png"},
          {"compare", "compare IN/s.toml -o o --repeat 1 --depth-step 0.5", true, "o/compare.json"},
          {"tune", "tune s.toml --in-place --budget-us 1000000 --led --ticks 1000 --voxels 0.4,0.3", false},
          {"study", "study IN/study.toml -o o", false}};
}

class FullDisk : public test::ProgramTest, public testing::WithParamInterface<Command> {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("kerf_full_disk_{}_{}", GetParam().name, getpid());
    fs::remove_all(folder_);
    for (const char* name : {"in", "whole", "small", "after"}) fs::create_directories(folder_ / name);
    Write("in/s.toml", kFullDiskScene);
    Write("in/effects.toml", kFullDiskScene + kEffects);
    Write("in/slab.toml", kFullDiskScene + "[simulation]\nmode = \"slab\"\n");
    Write("in/study.toml", kStudy);
    ASSERT_EQ(Kerf("model block --size 8,8,8 -o in/b.vdb").code, 0);
    ASSERT_EQ(Kerf("export in/b.vdb -o in/b.stl").code, 0);
    arguments_ = GetParam().arguments;
    for (std::size_t at = 0; (at = arguments_.find("IN/", at)) != std::string::npos;) {
      arguments_.replace(at, 2, (folder_ / "in").string());
    }
    // tune edits its scene.
    Write("whole/s.toml", kFullDiskScene);
    const ProgramResult whole = Shell("cd whole && PROGRAM");
    SkipIfNotBuilt(whole);
    ASSERT_EQ(whole.code, 0) << whole.err;
    for (const auto& file : fs::recursive_directory_iterator(folder_ / "whole")) {
      if (file.is_regular_file()) files_.push_back(fs::relative(file.path(), folder_ / "whole").string());
    }
    ASSERT_FALSE(files_.empty());
  }

  /// Runs shell commands in folder_, in which PROGRAM stands for the program with its arguments. Returns their exit
  /// code.
  ProgramResult Shell(std::string commands, const std::string& within = "") const {
    const std::string program = std::string("env -u DISPLAY '" KERF_PROGRAM "' ") + arguments_ + " >/dev/null 2>'" +
                                (folder_ / "err.txt").string() + "' </dev/null";
    if (const std::size_t at = commands.find("PROGRAM"); at != std::string::npos) commands.replace(at, 7, program);
    Write("commands.sh", "cd '" + folder_.string() + "' || exit 99\n" + commands + "\n");
    const int status = std::system((within + "sh '" + (folder_ / "commands.sh").string() + "' 2>/dev/null").c_str());
    ProgramResult result;
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.err = Slurp(folder_ / "err.txt");
    return result;
  }

  /// Does the same in a separate mount namespace, whose mounts disappear with it.
  ProgramResult InNamespace(const std::string& commands) const { return Shell(commands, "unshare -m "); }

  /// Returns commands that put an earlier run's results into the current folder.
  std::string PutEarlier() const {
    std::string text = "cp '" + (folder_ / "in/s.toml").string() + "' s.toml || exit 99\n";
    for (const std::string& file : files_) {
      if (!GetParam().earlier || file == "s.toml") continue;
      text += fmt::format("mkdir -p '{}' && echo old > '{}' || exit 99\n", fs::path("./" + file).parent_path().string(),
                          file);
    }
    return text;
  }

  /// Checks the folder `place` after a run that failed.
  void ExpectOneSentenceAndWholeFiles(const ProgramResult& result, const std::string& place) const {
    EXPECT_EQ(result.code, 1);
    int sentences = 0;
    std::istringstream lines(result.err);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("kerf: warning: ") || line.starts_with("kerf: note: ")) continue;
      ++sentences;
      EXPECT_THAT(line, testing::StartsWith("kerf: "));
      EXPECT_THAT(line, testing::AnyOf(HasSubstr("can't be written"), HasSubstr("can't be created"),
                                       HasSubstr("cases failed"),  // the cases and reasons are printed on stdout

                                       HasSubstr("the picture can't be written")));
    }
    EXPECT_EQ(sentences, 1) << result.err;
    for (const auto& file : fs::recursive_directory_iterator(folder_ / place)) {
      if (!file.is_regular_file()) continue;
      const std::string name = fs::relative(file.path(), folder_ / place).string();
      EXPECT_FALSE(file.path().filename().string().starts_with(".")) << "a temporary file was left: " << name;
      const std::string now = Slurp(file.path());
      if (now == kOld || (name == "s.toml" && now == kFullDiskScene)) continue;
      ExpectWhole(name, now);
    }
    if (!GetParam().earlier) return;
    // The earlier files are still there. If there is a list, all are old, or those in the new list are new: never some
    // of each. (A loop writes what still fits.)
    const auto is_old = [&](const std::string& file) { return Slurp(folder_ / place / file) == kOld; };
    for (const std::string& file : files_) {
      EXPECT_TRUE(fs::exists(folder_ / place / file)) << file;
      if (GetParam().list != nullptr && is_old(GetParam().list) && file != "s.toml") {
        EXPECT_TRUE(is_old(file)) << file;
      }
    }
    if (GetParam().list == nullptr || is_old(GetParam().list)) return;
    EXPECT_STREQ(GetParam().name, "loop");
    for (const auto& name : nlohmann::json::parse(Slurp(folder_ / place / GetParam().list))["files"]) {
      EXPECT_FALSE(is_old("o/" + name.get<std::string>())) << name;
    }
  }

  void ExpectWhole(const std::string& name, const std::string& now) const {
    const std::string kind = fs::path(name).extension().string();
    const bool same_size = kind == ".stl" || kind == ".obj" || kind == ".ply" || kind == ".wav";
    if (same_size) {
      EXPECT_EQ(now.size(), fs::file_size(folder_ / "whole" / name)) << name;
    }
    if (kind == ".vdb") {
      EXPECT_EQ(Kerf("info '" + (folder_ / "after" / name).string() + "'").code, 0) << name;
    }
    if (kind == ".png") {
      EXPECT_EQ(now.substr(now.size() - 8, 4), "IEND") << name;
    }
    if (kind == ".json") {
      EXPECT_TRUE(nlohmann::json::accept(now)) << name;
    }
    if (kind == ".csv" || kind == ".md" || kind == ".toml" || kind == ".svg") {
      EXPECT_EQ(now.back(), '\n') << name;
    }
    EXPECT_GT(now.size(), 4U) << name;
  }

  std::string arguments_;
  std::vector<std::string> files_;  // written by a successful run
};

TEST_P(FullDisk, LeavesEveryEarlierFileWhole) {
  if (Shell("unshare -m mount -t tmpfs none small").code != 0) {
    GTEST_SKIP() << "no file system may be mounted here";
  }
  int full = 0;
  for (const int room_kB : {0, 24, 120, 400, 1600, 100'000}) {
    SCOPED_TRACE(fmt::format("room for {} kB", room_kB));
    fs::remove_all(folder_ / "after");
    fs::create_directories(folder_ / "after");
    // Pages are 4 kB, and each file and folder takes at least one.
    const auto size_kB = 4 * (GetParam().earlier ? files_.size() : 1) + 4 + static_cast<std::size_t>(room_kB);
    const std::string inside = fmt::format(
        "mount -t tmpfs -o size={}k none small && cd small || exit 99\n{}\nPROGRAM\ncode=$?\ncp -a . ../after || exit "
        "99\nexit $code",
        size_kB, PutEarlier());
    const ProgramResult result = InNamespace(inside);
    ASSERT_NE(result.code, 99);
    if (result.code == 0) break;
    ++full;
    ExpectOneSentenceAndWholeFiles(result, "after");
  }
  EXPECT_GE(full, 1);
}

TEST_P(FullDisk, AReadOnlyFolderIsRefused) {
  if (Shell("unshare -m mount -t tmpfs none small").code != 0) {
    GTEST_SKIP() << "no file system may be mounted here";
  }
  const ProgramResult result =
      InNamespace("mount -t tmpfs none small && cd small || exit 99\n" + PutEarlier() +
                  "mount -o remount,ro none . || exit 99\nPROGRAM\ncode=$?\ncp -a . ../after || exit 99\nexit $code");
  ASSERT_NE(result.code, 99);
  ExpectOneSentenceAndWholeFiles(result, "after");
  for (const std::string& file : files_) {
    if (!GetParam().earlier) continue;
    EXPECT_EQ(Slurp(folder_ / "after" / file), file == "s.toml" ? kFullDiskScene : kOld) << file;
  }
}

TEST_P(FullDisk, FileSizeLimitIsReported) {
  int limited = 0;
  for (const int blocks : {1, 16, 128, 1024, 16'384}) {
    SCOPED_TRACE(fmt::format("files of {} blocks at most", blocks));
    fs::remove_all(folder_ / "after");
    fs::create_directories(folder_ / "after");
    const ProgramResult result =
        Shell(fmt::format("cd after || exit 99\n{}\nulimit -f {}\nPROGRAM", PutEarlier(), blocks));
    ASSERT_NE(result.code, 99);
    if (result.code == 0) break;
    ++limited;
    // The message is also written to a file.
    ExpectOneSentenceAndWholeFiles(result, "after");
  }
  EXPECT_GE(limited, 1);
}

INSTANTIATE_TEST_SUITE_P(Commands, FullDisk, testing::ValuesIn(ListCommands()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace kerf
