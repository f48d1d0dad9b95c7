// Tests of the program's exit codes and of its output on stdout and stderr. Wrong input is answered with one clear
// sentence.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;
using testing::StartsWith;

class Program : public test::ProgramTest {
 protected:
  static constexpr char kBlock[] = R"([bone]
model = "block"
[bone.block]
size_x_mm = 4.0
size_y_mm = 4.0
size_z_mm = 4.0
)";
  static inline const std::string kStroke = test::StrokeToml({0, 0, 11.2}, {0, 0, 6}, 20, {0, 1, 0});
  static constexpr char kNoPictures[] = "[output]\npictures = false\n";
};

TEST_F(Program, VersionNamesCommitCompilerAndLibraries) {
  const ProgramResult result = Kerf("--version");
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, StartsWith("kerf 0."));
  for (const char* name : {"commit ", "GCC ", "OpenVDB 1", "TBB ", "GLM ", "toml++ ", "CLI11 ", "fmt "}) {
    EXPECT_THAT(result.out, HasSubstr(name));
  }
  EXPECT_EQ(result.out.find("ITK ") != std::string::npos, bool{KERF_WITH_IMPORT});
  EXPECT_EQ(result.out.find("VTK ") != std::string::npos, bool{KERF_WITH_PICTURES});
}

TEST_F(Program, EveryCommandHasHelpOnStdout) {
  for (const char* command : {"", "check", "export", "import", "info", "materials", "model", "model mandible",
                              "model block", "model plate", "paper", "picture", "run", "scene"}) {
    const ProgramResult result = Kerf(std::string(command) + " --help");
    EXPECT_EQ(result.code, 0) << command;
    EXPECT_EQ(result.err, "") << command;
    EXPECT_THAT(result.out, HasSubstr("Usage:")) << command;
  }
}

TEST_F(Program, BadUsageHasExitCode2) {
  for (const char* arguments : {"", "saw", "run", "run --colour", "info a b", "scene --defaults --nonsense"}) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
    EXPECT_NE(result.err, "") << arguments;
  }
}

TEST_F(Program, UnknownCommandIsNamedWithTheNearest) {
  const ProgramResult result = Kerf("imprt x -o y");
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(result.err, "kerf: unknown command \"imprt\"; the nearest is \"import\"; 'kerf --help' lists them\n");
}

TEST_F(Program, UnknownOptionIsNamedWithTheNearest) {
  const auto expect = [&](const std::string& arguments, const std::string& message) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(result.err, "kerf: unknown option " + message + "\n");
  };
  expect("run s.toml --no-picture", "--no-picture; the nearest is --no-pictures; see 'kerf run --help'");
  expect("model block --voxl=0.2", "--voxl; the nearest is --voxel; see 'kerf model block --help'");
  expect("model --siz 1 block -o b.vdb", "--siz; see 'kerf model --help'");
  expect("--verson", "--verson; the nearest is --version; see 'kerf --help'");
  expect("loop s.toml --xy", "--xy; see 'kerf loop --help'");
}

TEST_F(Program, ResultsOfAnEarlierRunAreRemoved) {
  std::string shallow = kStroke;
  shallow.replace(shallow.find("6.0]"), 4, "9.0]");
  Write("two.toml", std::string(kBlock) + shallow + kNoPictures);
  Write("one.toml", std::string(kBlock) + kStroke + "[output]\npictures = false\nbone = false\n");
  ASSERT_EQ(Kerf("run one.toml -o results").code, 0);
  EXPECT_TRUE(Exists("results/piece_2.stl"));
  Write("results/mine.stl", "not kerf's");
  ASSERT_EQ(Kerf("run two.toml -o results").code, 0);
  EXPECT_TRUE(Exists("results/bone.vdb"));
  EXPECT_FALSE(Exists("results/piece_2.stl"));
  EXPECT_EQ(test::Slurp(folder_ / "results/mine.stl"), "not kerf's");
}

TEST_F(Program, WarnsOfAPathThatMissesTheBoneOrBeginsInIt) {
  std::string stroke = kStroke;
  stroke.replace(stroke.find("[0.0, 0.0, 11.2]"), 16, "[0.0, 50.0, 12.0]");
  stroke.replace(stroke.find("[0.0, 0.0, 6.0]"), 15, "[0.0, 50.0, 9.0]");
  Write("miss.toml", std::string(kBlock) + stroke);
  const ProgramResult miss = Kerf("run miss.toml -o miss");
  EXPECT_EQ(miss.code, 0);
  EXPECT_THAT(miss.err, HasSubstr("kerf: warning: the saw touched no bone on its path\n"));
  EXPECT_FALSE(Exists("miss/cut.png"));
  stroke = kStroke;
  stroke.replace(stroke.find("11.2]"), 5, "10.0]");
  Write("inside.toml", std::string(kBlock) + stroke + kNoPictures);
  EXPECT_THAT(Kerf("run inside.toml -o inside").err, HasSubstr("set down inside the bone"));
}

TEST_F(Program, RunRefusesToOverwriteItsInput) {
  std::filesystem::create_directory(folder_ / "work");
  Write("work/scene.toml", std::string(kBlock) + kStroke + kNoPictures);
  const std::string before = test::Slurp(folder_ / "work/scene.toml");
  ExpectRefusal(Kerf("run work/scene.toml -o work"),
                "work/scene.toml: is an input and would be overwritten by work/scene.toml; choose another output");
  EXPECT_EQ(test::Slurp(folder_ / "work/scene.toml"), before);
  ASSERT_EQ(Kerf("model block -o work/bone.vdb").code, 0);
  const std::string bone = test::Slurp(folder_ / "work/bone.vdb");
  Write("s.toml", std::string("[bone]\nfile = \"work/bone.vdb\"\n") + kStroke + kNoPictures);
  const ProgramResult result = Kerf("run s.toml -o work");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("work/bone.vdb: is an input and would be overwritten by work/bone.vdb"));
  EXPECT_EQ(test::Slurp(folder_ / "work/bone.vdb"), bone);
}

TEST_F(Program, FullDiskKeepsTheEarlierBone) {
  // A file size limit simulates a full disk: writes beyond the limit fail.
  ASSERT_EQ(Kerf("model block --size 4,4,4 -o b.vdb").code, 0);
  const std::string before = test::Slurp(folder_ / "b.vdb");
  const ProgramResult result = KerfWithin("ulimit -f 64;", "model block --size 30,30,30 -o b.vdb");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("b.vdb: can't be written"));
  EXPECT_EQ(test::Slurp(folder_ / "b.vdb"), before);
  for (const auto& file : std::filesystem::directory_iterator(folder_)) {
    EXPECT_NE(file.path().filename().string()[0], '.') << "a temporary file was left: " << file.path();
  }
}

TEST_F(Program, OutputMustBeARegularFileAndLinksAreFollowed) {
  ExpectRefusal(Kerf("scene --defaults -o /dev/null"), "/dev/null: can't be written: it is not a regular file");
  Write("target.toml", "old");
  std::filesystem::create_symlink("target.toml", folder_ / "link.toml");
  std::filesystem::permissions(folder_ / "target.toml",
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  ASSERT_EQ(Kerf("scene --defaults -o link.toml").code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.toml"));
  EXPECT_THAT(test::Slurp(folder_ / "target.toml"), HasSubstr("[bone]"));
  EXPECT_EQ(std::filesystem::status(folder_ / "target.toml").permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(Program, RunsAScene) {
  Write("scene.toml", std::string(kBlock) + kStroke);
  const ProgramResult result = Kerf("run scene.toml -o results");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("ticks     260 in"));
  for (const char* file : {"forces.csv", "summary.json", "scene.toml", "bone.vdb", "piece_1.stl", "before.png",
                           "after.png", "cut.png", "force.png"}) {
    EXPECT_TRUE(Exists(std::string("results/") + file)) << file;
  }
  const ProgramResult info = Kerf("info results/bone.vdb --json");
  EXPECT_EQ(info.code, 0) << info.err;
  const auto json = nlohmann::json::parse(info.out);
  const auto summary = nlohmann::json::parse(test::Slurp(folder_ / "results/summary.json"));
  EXPECT_EQ(json["hash"], summary["bone"]["hash_after"]);
  EXPECT_NEAR(json["volume_mm3"].get<double>(), summary["bone"]["volume_after_mm3"].get<double>(), 1e-9 * 64);
}

TEST_F(Program, RunOmitsPicturesAndWritesFullPiecesOnRequest) {
  Write("scene.toml", std::string(kBlock) + kStroke);
  const ProgramResult reduced = Kerf("run scene.toml -o reduced --no-pictures");
  ASSERT_EQ(reduced.code, 0) << reduced.err;
  EXPECT_THAT(reduced.out, HasSubstr("within 0.02 mm of the full ones"));
  const ProgramResult full = Kerf("run scene.toml -o full --no-pictures --full");
  ASSERT_EQ(full.code, 0) << full.err;
  EXPECT_THAT(full.out, HasSubstr("at full resolution"));
  for (const std::filesystem::path folder : {"reduced", "full"}) {
    for (const auto& file : std::filesystem::directory_iterator(folder_ / folder)) {
      EXPECT_NE(file.path().extension(), ".png") << file.path();
    }
  }
  EXPECT_LT(std::filesystem::file_size(folder_ / "reduced/piece_1.stl"),
            std::filesystem::file_size(folder_ / "full/piece_1.stl"));
  // Only the surfaces depend on the setting.
  EXPECT_EQ(test::Slurp(folder_ / "reduced/forces.csv"), test::Slurp(folder_ / "full/forces.csv"));
}

TEST_F(Program, LoopAndReplayReducePiecesByDefault) {
  Write("scene.toml", std::string(kBlock) + kStroke + kNoPictures);
  ASSERT_EQ(Kerf("loop scene.toml --virtual --seconds 0.3 --record a.rec -o reduced").code, 0);
  ASSERT_EQ(Kerf("loop scene.toml --virtual --seconds 0.3 -o full --full").code, 0);
  ASSERT_EQ(Kerf("replay a.rec -o again").code, 0);
  ASSERT_EQ(Kerf("replay a.rec -o again_full --full").code, 0);
  const auto piece = [&](const char* folder) { return test::Slurp(folder_ / folder / "piece_1.stl"); };
  EXPECT_LT(piece("reduced").size(), piece("full").size());
  EXPECT_EQ(piece("again"), piece("reduced"));
  EXPECT_EQ(piece("again_full"), piece("full"));
}

TEST_F(Program, SlabModeAcceptsFull) {
  Write("scene.toml", std::string(kBlock) + kStroke + kNoPictures +
                          "[simulation]\nmode = \"slab\"\n[slab]\ndirection = [0.0, 0.0, -1.0]\n");
  const ProgramResult reduced = Kerf("run scene.toml -o reduced");
  ASSERT_EQ(reduced.code, 0) << reduced.err;
  EXPECT_THAT(reduced.out, HasSubstr("within 0.02 mm of the full ones"));
  const ProgramResult full = Kerf("run scene.toml -o full --full");
  ASSERT_EQ(full.code, 0) << full.err;
  EXPECT_THAT(full.out, HasSubstr("at full resolution"));
  EXPECT_LT(std::filesystem::file_size(folder_ / "reduced/left.stl"),
            std::filesystem::file_size(folder_ / "full/left.stl"));
}

TEST_F(Program, JsonOnStdoutEqualsTheSummary) {
  Write("scene.toml", std::string(kBlock) + kStroke + kNoPictures);
  const ProgramResult result = Kerf("run scene.toml -o results --json");
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(nlohmann::json::parse(result.out), nlohmann::json::parse(test::Slurp(folder_ / "results/summary.json")));
}

TEST_F(Program, DefaultSceneIsValid) {
  const ProgramResult defaults = Kerf("scene --defaults");
  ASSERT_EQ(defaults.code, 0);
  Write("scene.toml", defaults.out);
  const ProgramResult check = Kerf("check scene.toml");
  EXPECT_EQ(check.code, 0) << check.err;
}

TEST_F(Program, UnknownKeyIsReportedWithPositionAndNearestKey) {
  Write("scene.toml", std::string(kBlock) + kStroke + "[tool]\nthicknes_mm = 0.3\n");
  for (const char* command : {"run", "check"}) {
    const ProgramResult result = Kerf(std::string(command) + " scene.toml");
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, StartsWith("kerf: scene.toml:13:1: "));
    EXPECT_THAT(result.err, HasSubstr("thicknes_mm"));
    EXPECT_THAT(result.err, HasSubstr("thickness_mm"));
    EXPECT_FALSE(Exists("out"));  // nothing was started
  }
}

TEST_F(Program, NegativeThicknessIsReportedWithTheRange) {
  Write("scene.toml", std::string(kBlock) + kStroke + "[tool]\nthickness_mm = -0.1\n");
  const ProgramResult result = Kerf("run scene.toml");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, StartsWith("kerf: scene.toml:13:1: thickness_mm = -0.1 "));
  EXPECT_THAT(result.err, HasSubstr("0.02 to 10"));
}

TEST_F(Program, NanInAPathIsReportedWithFileLineAndColumn) {
  Write("path.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,20,1,0,0,0\n1,nan,0,19,1,0,0,0\n");
  Write("scene.toml", std::string(kBlock) + "[path]\nfile = \"path.csv\"\n");
  const ProgramResult result = Kerf("run scene.toml");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("path.csv:3:3: "));
  EXPECT_THAT(result.err, HasSubstr("nan"));
}

TEST_F(Program, MissingOrForeignFilesAreRefusedInOneSentence) {
  ExpectRefusal(
      Kerf("info none.vdb"),
      "none.vdb: there is no such file; 'kerf import INPUT -o none.vdb' makes it from a CT or a closed surface");
  Write("text.vdb", "no volume at all");
  const ProgramResult foreign = Kerf("info text.vdb");
  EXPECT_EQ(foreign.code, 1);
  EXPECT_THAT(foreign.err, StartsWith("kerf: text.vdb: not a valid OpenVDB file ("));
  Write("scene.toml", std::string("[bone]\nfile = \"none.vdb\"\n") + kStroke);
  const ProgramResult scene = Kerf("run scene.toml");
  EXPECT_EQ(scene.code, 1);
  EXPECT_THAT(scene.err, HasSubstr("none.vdb"));
}

TEST_F(Program, OutputThatCannotBeWrittenIsRefused) {
  Write("scene.toml", std::string(kBlock) + kStroke + kNoPictures);
  Write("results", "a file where the folder should be");
  const ProgramResult result = Kerf("run scene.toml -o results");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("results"));
  EXPECT_EQ(test::Slurp(folder_ / "results"), "a file where the folder should be");
}

TEST_F(Program, NoCommandOverwritesAnInput) {
  // The same file is given under different names or through a link.
  std::filesystem::create_directory(folder_ / "out");
  const std::string scene = std::string(kBlock) + kStroke + kNoPictures;
  Write("s.toml", scene);
  std::filesystem::create_symlink("../s.toml", folder_ / "out/scene.toml");
  const auto refused = [this](const std::string& arguments, const std::string& input, const std::string& output) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 1) << arguments;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, testing::EndsWith(input + ": is an input and would be overwritten by " + output +
                                              "; choose another output\n"));
  };
  refused("run s.toml -o out", "s.toml", "out/scene.toml");
  refused("scene s.toml -o out/scene.toml", "s.toml", "out/scene.toml");
  // The table of a force law, with the name of a result of each command.
  const std::string table = test::Slurp(KERF_SOURCE_DIR "/volumes/force_table.csv");
  std::filesystem::create_directory(folder_ / "in");
  for (const auto& [name, command] :
       {std::pair{"forces.csv", "run"}, {"forces.csv", "loop --virtual --seconds 1"}, {"teeth.csv", "validate"}}) {
    Write(std::string("in/") + name, table);
    Write("law.toml", fmt::format("{}[force]\nlaw = \"tabulated\"\nfile = \"in/{}\"\n", scene, name));
    refused(fmt::format("{} law.toml -o in", command), fmt::format("in/{}", name), fmt::format("in/{}", name));
    EXPECT_EQ(test::Slurp(folder_ / "in" / name), table);
  }
  // A fit, by the band that is made with it.
  ASSERT_EQ(Kerf("calibrate " KERF_SOURCE_DIR "/examples/synthetic_forces.csv --bootstrap 0 -o fit").code, 0);
  std::filesystem::rename(folder_ / "fit/calibrate.json", folder_ / "in/uncertain.json");
  Write("fitted.toml", scene + test::Slurp(folder_ / "fit/law.toml"));
  const ProgramResult band = Kerf("run fitted.toml --uncertain 2 --fit in/uncertain.json -o in");
  EXPECT_EQ(band.code, 1);
  EXPECT_THAT(band.err, HasSubstr("in/uncertain.json: is an input and would be overwritten"));
  EXPECT_EQ(test::Slurp(folder_ / "s.toml"), scene);
  for (const char* name : {"slice.stl", "cut.png", "piece_7.stl"}) {
    Write(std::string("out/") + name, "a table");
    std::filesystem::remove(folder_ / "out/scene.toml");
    Write("t.toml", fmt::format("[bone]\nmaterials = \"out/{}\"\nmodel = \"block\"\n{}", name, kStroke + kNoPictures));
    refused("run t.toml -o out", fmt::format("out/{}", name), fmt::format("out/{}", name));
    EXPECT_EQ(test::Slurp(folder_ / "out" / name), "a table");
  }
  ASSERT_EQ(Kerf("model block --size 4,4,4 -o b.vdb").code, 0);
  const std::string bone = test::Slurp(folder_ / "b.vdb");
  for (const char* name : {"b.png", "b.stl", "b-1.stl"}) std::filesystem::create_symlink("b.vdb", folder_ / name);
  refused("picture b.vdb -o b.png", "b.vdb", "b.png");
  refused("export b.vdb -o b.stl", "b.vdb", "b.stl");
  std::filesystem::remove(folder_ / "b.stl");
  refused("export b.vdb --pieces -o b.stl", "b.vdb", "b-1.stl");
  std::filesystem::copy(KERF_SOURCE_DIR "/volumes/mandible_regions.csv", folder_ / "m.csv");
  std::filesystem::create_symlink("m.csv", folder_ / "m.vdb");
  refused("model block --materials m.csv -o m.vdb", "m.csv", "m.vdb");
  std::filesystem::create_symlink("b.vdb", folder_ / "b.nrrd");
  refused("import b.nrrd -o b.vdb", "b.nrrd", "b.vdb");
  EXPECT_EQ(test::Slurp(folder_ / "b.vdb"), bone);
}

#ifdef KERF_IO_FAULTS
TEST_F(Program, SignalThatEndsTheProgramLeavesNoTemporaryFile) {
  // A preloaded library raises the signal at each moment of writing a bone: after a file is opened, before a write, the
  // flush and the rename. The bone is whole or absent, and nothing else is in the folder.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    int ended = 0;
    for (const char* call : {"open", "write", "sync", "rename"}) {
      for (int at = 1;; ++at) {
        ASSERT_LT(at, 200) << call;
        const std::string environment =
            fmt::format("LD_PRELOAD='{}' KERF_FAULT_ROOT='{}' KERF_FAULT_CALL={} KERF_FAULT_AT={} KERF_FAULT_SIGNAL={}",
                        KERF_IO_FAULTS, folder_.string(), call, at, signal);
        const int status = std::system(fmt::format("cd '{}' && {} '" KERF_PROGRAM
                                                   "' model block --size 4,4,4 -o b.vdb >/dev/null 2>&1",
                                                   folder_.string(), environment)
                                           .c_str());
        const bool is_whole = std::filesystem::remove(folder_ / "b.vdb");
        EXPECT_TRUE(std::filesystem::is_empty(folder_)) << call << " " << at << ", signal " << signal;
        if (WEXITSTATUS(status) == 0) {  // no further call of this kind
          EXPECT_TRUE(is_whole);
          break;
        }
        EXPECT_EQ(WEXITSTATUS(status), 128 + signal) << call << " " << at;
        ++ended;
        at += at / 8;  // consecutive calls are similar
      }
    }
    EXPECT_GE(ended, 4) << signal;
  }
}
#endif

TEST_F(Program, LostOutputIsAFailure) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full here";
  ASSERT_EQ(Kerf("model block --size 4,4,4 -o b.vdb").code, 0);
  for (const char* command : {"paper", "paper --json", "info b.vdb", "scene --defaults", "materials", "--help"}) {
    const std::string line =
        "cd '" + folder_.string() + "' && '" KERF_PROGRAM "' " + command + " >/dev/full 2>stderr.txt";
    const int status = std::system(line.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << command;
    EXPECT_THAT(test::Slurp(folder_ / "stderr.txt"),
                testing::MatchesRegex("kerf: standard output can't be written(: No space left on device)?\n"))
        << command;
  }
}

TEST_F(Program, CheckRecognisesAStudy) {
  const ProgramResult result = Kerf("check " KERF_SOURCE_DIR "/scenes/study_quick.toml");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("this is a study, not a scene; 'kerf study "));
  EXPECT_EQ(result.err.find("unknown key"), std::string::npos);
}

}  // namespace
}  // namespace kerf
