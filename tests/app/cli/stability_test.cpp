// Tests of kerf stability, run as a program.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;
using testing::Not;

const std::string kStabilityBlock = test::BlockToml({26, 6, 26}, 0.25);
const std::string kStroke = test::StrokeToml({0, 0, 12}, {0, 0, 4}, 3, {0, 1, 0});

class StabilityCommand : public test::ProgramTest {
 protected:
#ifdef KERF_IO_FAULTS
  /// Runs the command with a preloaded library that raises SIGINT as soon as the command is ready for it: after the
  /// second handler that the program sets, the first being that of every command.
  ProgramResult Interrupted() const {
    return KerfWithin(fmt::format("LD_PRELOAD='{}' KERF_FAULT_CALL=sigaction KERF_FAULT_AT=2 KERF_FAULT_SIGNAL={}",
                                  KERF_IO_FAULTS, SIGINT),
                      "stability s.toml -o out");
  }
#endif
};

TEST_F(StabilityCommand, HelpNamesItsOptions) {
  const ProgramResult help = Kerf("stability --help");
  EXPECT_EQ(help.code, 0);
  for (const char* option :
       {"SCENE", "--output", "--profile", "--profiles", "--hand", "--quick", "--as-asked", "--json"}) {
    EXPECT_THAT(help.out, HasSubstr(option));
  }
  EXPECT_THAT(Kerf("--help").out, HasSubstr("stability"));
}

#ifdef KERF_IO_FAULTS
TEST_F(StabilityCommand, InterruptedRunKeepsEarlierResults) {
  Write("s.toml", kStabilityBlock + kStroke);
  std::filesystem::create_directories(folder_ / "out");
  Write("out/stability.json", "earlier");
  const ProgramResult result = Interrupted();
  EXPECT_EQ(result.code, 1) << result.err;
  EXPECT_THAT(result.err, HasSubstr("kerf: the earlier results in out/ are kept"));
  EXPECT_EQ(Slurp(folder_ / "out/stability.json"), "earlier");
  EXPECT_FALSE(Exists("out/report.md"));
}

TEST_F(StabilityCommand, InterruptedRunWritesPartialResults) {
  Write("s.toml", kStabilityBlock + kStroke);
  const ProgramResult result = Interrupted();
  ASSERT_EQ(result.code, 1) << result.err;
  EXPECT_THAT(result.err, HasSubstr("stopped before anything was examined"));
  EXPECT_THAT(Slurp(folder_ / "out/report.md"), HasSubstr("**Stopped before anything was examined.**"));
  EXPECT_EQ(Json::parse(Slurp(folder_ / "out/stability.json"))["stable"], nullptr);
}
#endif

TEST_F(StabilityCommand, WritesTablesFiguresAndTheSameJsonForAStableScene) {
  Write("s.toml", std::string("title = \"A block\"\n") + kStabilityBlock + kStroke);
  const ProgramResult result = Kerf("stability s.toml --quick -o out --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, Slurp(folder_ / "out/stability.json"));
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["stable"], true);
  EXPECT_EQ(json["complete"], true);
  EXPECT_TRUE(json["findings"].empty());
  EXPECT_EQ(json["device"], "omega_6");
  EXPECT_EQ(json["hand"], "H3");
  // The rim moves down from 1 mm above the block's top, which is at z = 0.
  EXPECT_NEAR(json["first_touch"]["time_s"].get<double>(), 1.0 / 3, 0.15);
  EXPECT_GT(json["first_touch"]["start_mm"][2].get<double>(), 11.0);
  EXPECT_LT(json["first_touch"]["start_mm"][2].get<double>(), 12.0);
  EXPECT_NEAR(json["first_touch"]["into"][2].get<double>(), -1, 1e-9);
  // Every scenario that was run has results, and all limits hold.
  EXPECT_GE(json["scenarios"].size(), 5U);
  for (const Json& scenario : json["scenarios"]) {
    if (scenario["skipped"]) continue;
    EXPECT_EQ(scenario["holds"], true) << scenario["name"];
    EXPECT_FALSE(scenario["figures"].empty()) << scenario["name"];
    for (const Json& figure : scenario["figures"]) {
      const bool below = figure["value"] <= figure["bound"];
      const bool above = figure["value"] >= figure["bound"];
      EXPECT_EQ(figure["holds"].get<bool>(), figure["kind"] == "at_most" ? below : above) << figure;
    }
  }
  // With --quick, the scene's hand and a released one are examined in three states, nonlinear and linearised.
  EXPECT_EQ(json["margins"].size(), 2U * 3 * 2);
  std::set<std::string> hands;
  for (const Json& row : json["margins"]) {
    hands.insert(row["hand"]);
    if (row["own"]) {
      EXPECT_GE(row["gain"].get<double>(), 2) << row;
      EXPECT_GE(row["delay_ticks"].get<int>(), 1) << row;
    }
  }
  EXPECT_EQ(hands, (std::set<std::string>{"H0", "H3"}));
  const Json& map = json["map"];
  ASSERT_EQ(map["behaviour_by_damping_then_stiffness"].size(), map["damping_Ns_per_mm"].size());
  std::set<std::string> seen;
  for (const Json& row : map["behaviour_by_damping_then_stiffness"]) {
    ASSERT_EQ(row.size(), map["stiffness_N_per_mm"].size());
    for (const Json& point : row) seen.insert(point);
  }
  EXPECT_TRUE(seen.contains("stable"));
  EXPECT_GE(seen.size(), 2U);  // the map includes the boundary of stability
  const std::set<std::string> expected = {"report.md", "stability.json", "scene.toml", "figures.csv", "margins.csv",
                                          "map.csv",   "margins.png",    "delays.png", "map.png",     "worst_1.png"};
  const auto files = json["files"].get<std::set<std::string>>();
  for (const std::string& file : expected) {
    EXPECT_TRUE(files.contains(file)) << file;
    EXPECT_TRUE(Exists("out/" + file)) << file;
  }
  for (const char* file : {"report.md", "stability.json", "figures.csv", "margins.csv", "map.csv"}) {
    EXPECT_THAT(Slurp(folder_ / "out" / file), Not(HasSubstr(folder_.string()))) << file;
  }
  EXPECT_THAT(Slurp(folder_ / "out/report.md"), HasSubstr("**Stable.**"));

  // A second run that fails at once because its scene is missing leaves everything unchanged; a complete run replaces
  // the results.
  Write("out/worst_9.png", "old");
  Json earlier = json;
  earlier["files"].push_back("worst_9.png");
  Write("out/stability.json", earlier.dump());
  EXPECT_EQ(Kerf("stability none.toml --quick -o out").code, 1);
  EXPECT_TRUE(Exists("out/worst_9.png"));
  const ProgramResult again = Kerf("stability s.toml --quick -o out --json");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_FALSE(Exists("out/worst_9.png"));
  Json second = Json::parse(again.out);
  Json first = json;
  for (Json* both : {&first, &second}) both->erase("wall_s");
  EXPECT_EQ(first, second);
}

// The device is user-defined, with exaggerated rated values. It is light, almost without damping or friction, and held
// in the lightest grip that exists. Its encoder is so coarse (steps of 0.4 mm, or 0.24 N, ten times the perceptible
// noise) that cutting cannot be smooth.
TEST_F(StabilityCommand, UnstableSceneIsReportedWithExitCode1AndAllResults) {
  Write("mine.csv",
        "name,degrees_of_freedom,peak_force_N,continuous_force_N,peak_torque_Nmm,continuous_torque_Nmm,"
        "max_stiffness_N_per_mm,max_damping_Ns_per_mm,max_torsion_Nmm_per_rad,max_torsion_damping_Nmms,resolution_mm,"
        "workspace_radius_mm,friction_N,mass_kg,own_damping_Ns_per_mm,source\n"
        "boast,3,40 A,none,none,none,1000 A,1 A,none,none,0.4 A,100 A,none,0.05 A,1e-5 A,\"made up\"\n");
  Write("s.toml", kStabilityBlock + "[coupling]\nstiffness_N_per_mm = 4.0\ndamping_Ns_per_mm = 0.1\n" +
                      "[device]\nprofile = \"boast\"\nfile = \"mine.csv\"\n[hand]\nmodel = \"H1\"\n" + kStroke);
  const ProgramResult result = Kerf("stability s.toml --quick -o out");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("kerf: not stable: "));
  EXPECT_THAT(result.out, HasSubstr("Not stable at "));
  EXPECT_THAT(result.out, HasSubstr("boast"));
  for (const char* file : {"report.md", "stability.json", "figures.csv", "margins.csv", "map.csv", "map.png"}) {
    EXPECT_TRUE(Exists(std::string("out/") + file)) << file;
  }
  const Json json = Json::parse(Slurp(folder_ / "out/stability.json"));
  EXPECT_EQ(json["stable"], false);
  EXPECT_FALSE(json["findings"].empty());
  const Json& fraction = json["worst"]["share_of_bound"];
  EXPECT_TRUE(fraction.is_null() || fraction > 1) << fraction;  // null: beyond a bound of 0
  // The table is an input and is never overwritten.
  Write("map.csv", Slurp(folder_ / "mine.csv"));
  Write("t.toml", kStabilityBlock + "[device]\nprofile = \"boast\"\nfile = \"map.csv\"\n" + kStroke);
  const ProgramResult over = Kerf("stability t.toml --quick -o .");
  EXPECT_EQ(over.code, 1);
  EXPECT_THAT(over.err, HasSubstr("map.csv"));
  EXPECT_EQ(Slurp(folder_ / "map.csv"), Slurp(folder_ / "mine.csv"));
}

TEST_F(StabilityCommand, RefusesBadUsageInOneSentence) {
  EXPECT_EQ(Kerf("stability").code, 2);
  Write("s.toml", kStabilityBlock + kStroke);
  EXPECT_EQ(Kerf("stability s.toml --hand H9").code, 2);
  EXPECT_EQ(Kerf("stability s.toml --profiles --profile touch").code, 2);
  const auto refused = [&](const std::string& scene, const std::string& sentence) {
    Write("r.toml", scene);
    ExpectRefusal(Kerf("stability r.toml -o out"), sentence);
    EXPECT_FALSE(Exists("out/report.md"));
  };
  const auto stroke = [](const std::string& start, const std::string& end, const std::string& normal) {
    return "[[path.stroke]]\nstart_mm = " + start + "\nend_mm = " + end +
           "\nfeed_mm_per_s = 3.0\ndisc_normal = " + normal + "\n";
  };
  refused(kStabilityBlock + stroke("[0, 0, 20]", "[0, 0, 12]", "[0, 1, 0]"),
          "r: the path never touches the bone, so there is nothing to examine");
  refused(kStabilityBlock + stroke("[0, 0, 5]", "[0, 0, 0]", "[0, 1, 0]"),
          "r: the path begins inside the bone, at 0.000 s; begin it clear of the bone");
  refused(kStabilityBlock + std::string("[tool]\nrpm = 0\n") + kStroke,
          "[tool] rpm = 0: a stopped tool cuts nothing; set the speed for cutting; 'kerf stability' also tests the "
          "stopped tool");
  refused("[simulation]\nmode = \"slab\"\n[slab]\ndirection = [0, 0, -1]\n" + kStabilityBlock + kStroke,
          "[simulation] mode = \"slab\" has no tool coupled to a handle; set mode = \"voxel\" for 'kerf stability'");
  Write("r.toml", kStabilityBlock + stroke("[0, 8, -5]", "[0, 0, -5]", "[0, 1, 0]"));
  const ProgramResult flat = Kerf("stability r.toml");
  EXPECT_EQ(flat.code, 1);
  EXPECT_THAT(flat.err, HasSubstr("r: the disc touches the bone with its flat, at "));
  const ProgramResult none = Kerf("stability s.toml --profile tuoch");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("\"touch\""));
}

// 10 N/mm are requested at 250 Hz in a light hand. The loop allows 1 N/mm on the device, and by default 0.3 is used.
TEST_F(StabilityCommand, ExaminesTheRequestedCoupling) {
  Write("s.toml", kStabilityBlock + "[coupling]\nstiffness_N_per_mm = 10.0\n[loop]\nrate_hz = 250.0\n" + kStroke);
  const ProgramResult result = Kerf("stability s.toml --quick --hand H1 --as-asked --json");
  EXPECT_EQ(result.code, 1);
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["coupling"]["stiffness_N_per_mm"], 10.0);
  EXPECT_EQ(json["coupling"]["lowered_for_loop"], false);
  EXPECT_EQ(json["stable"], false);
}

TEST_F(StabilityCommand, RefusesAnInvalidSeed) {
  Write("s.toml", kStabilityBlock + kStroke);
  for (const auto& [seed, message] : {std::pair{"-1", "-1 is below 0; valid range 0 to 1000000000"},
                                      {"1.5", "'1.5' is not a whole number"},
                                      {"x", "'x' is not a number; valid range 0 to 1000000000"}}) {
    const ProgramResult result = Kerf(std::string("stability s.toml --seed ") + seed);
    EXPECT_EQ(result.code, 2) << seed;
    EXPECT_THAT(result.err, HasSubstr(message)) << seed;
  }
}

}  // namespace
}  // namespace kerf
