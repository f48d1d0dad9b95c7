// Tests of the cases of `kerf bench tick` with few ticks: errors, hashes and the format of the reports. The times are
// not checked because they depend on the machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "cut/removal/carve.h"
#include "experiment/bench/cut_cases.h"
#include "experiment/bench/other_cases.h"
#include "experiment/bench/tick_cases.h"
#include "experiment/bench/tick_report.h"
#include "experiment/bench/vdb_cut.h"
#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

BenchOptions FewTicks(int ticks) {
  BenchOptions options;
  options.ticks = ticks;
  options.baseline_ticks = 2;
  return options;
}

double Figure(const BenchResult& r, const char* what) {
  const BenchFigure* figure = r.Find(what);
  EXPECT_NE(figure, nullptr) << what;
  return figure ? figure->value : std::nan("");
}

/// Checks what must hold for every cut.
void ExpectGoodCut(const BenchResult& r, int ticks, double feed_mm_per_s) {
  EXPECT_EQ(r.times.count, static_cast<std::size_t>(ticks));
  EXPECT_LE(r.undisturbed.count, r.times.count);
  EXPECT_LE(r.times.p50_us, r.times.p99_us);
  EXPECT_LE(r.times.p99_us, r.times.p999_us);
  EXPECT_LE(r.times.p999_us, r.times.max_us);
  EXPECT_NE(r.hash, 0u);
  EXPECT_EQ(r.note, "");
  EXPECT_NEAR(Figure(r, "feed of the tool"), feed_mm_per_s, 0.01 * feed_mm_per_s);
  EXPECT_EQ(Figure(r, "ticks at a limit"), 0);
  // Occupancy is exact for plane walls. At the floor of the ball's cut its error corresponds to a depth of h^2 / (24
  // r), 0.05 mm in a depth of 2 mm with voxels of 0.3 mm.
  if (r.Find("removed by occupancy minus swept")) {
    EXPECT_NEAR(Figure(r, "removed by occupancy minus swept"), 0, 0.5);
  }
  if (r.Find("removed against dense")) {
    // The walls may deviate by up to a hundredth of a voxel; all other differences are float rounding.
    EXPECT_LE(Figure(r, "phi against dense at the surface, at most"), 0.011);
    EXPECT_NEAR(Figure(r, "removed against dense"), 0, 0.05);
  }
  EXPECT_EQ(r.stages_us.size(), kTickStages);
  const double computed = Figure(r, "voxels computed by removal");
  const double samples = Figure(r, "samples of the bone by contact");
  EXPECT_GT(Figure(r, "voxels changed"), 0);
  EXPECT_LE(Figure(r, "voxels changed"), computed);
  EXPECT_LE(computed, 512 * Figure(r, "leaves visited by removal"));
  EXPECT_GT(samples, 0);
  // A float read and one written of each voxel; eight floats read for each sample.
  EXPECT_NEAR(Figure(r, "bytes of these voxels and corners"), 1e-3 * (8 * computed + 32 * samples), 1e-9 * computed);
  EXPECT_GT(Figure(r, "memory rate of this core"), 0);
  EXPECT_GT(Figure(r, "vector rate of this core, floats"), 0);
  EXPECT_GT(Figure(r, "vector rate of this core, doubles"), 0);
  // Several things can happen in a tick.
  double causes = Figure(r, "of these, with none of this");
  for (const char* cause : {"another program on the core", "a page fault", "a new list of leaves", "a new leaf"}) {
    causes += Figure(r, (std::string("of these, with ") + cause).c_str());
  }
  EXPECT_GE(causes, Figure(r, "ticks over 3 times p50"));
}

TEST(BenchTick, DiscsRemoveTheirSweepAndAgreeWithTheDenseReference) {
  // There are enough ticks for the rim to pass the window of the dense reference.
  ExpectGoodCut(RunCut(MakeDiscCut(0.2), FewTicks(400)), 400, 5);
  ExpectGoodCut(RunCut(MakeThickDiscCut(), FewTicks(300)), 300, 10);
}

TEST(BenchTick, BurRemovesItsSweepAndAgreesWithTheDenseReference) {
  const BenchResult r = RunCut(MakeBurCut(0.1), FewTicks(400));
  ExpectGoodCut(r, 400, 5);
  EXPECT_NEAR(Figure(r, "removed minus swept"), 0, 1);
}

TEST(BenchTick, BuriedDiscCutsAtThePrescribedFeed) {
  const BenchResult r = RunCut(MakeBuriedCut(), FewTicks(150));
  ExpectGoodCut(r, 150, 5);
  // Half of the teeth, those in front, are engaged. The flats are inside bone that they do not cut.
  EXPECT_GT(Figure(r, "removed"), 0);
}

TEST(BenchTick, TremblingHandCutsWithoutReachingALimit) {
  const BenchResult r = RunCut(MakeHandCut(), FewTicks(150));
  EXPECT_EQ(r.times.count, 150u);
  EXPECT_EQ(Figure(r, "ticks at a limit"), 0);
  EXPECT_GT(Figure(r, "removed"), 0);
  EXPECT_NE(r.hash, RunCut(MakeDiscCut(0.1), FewTicks(150)).hash);
}

TEST(BenchTick, BallRemovesTheSameOnEveryGridAndAtEveryFeed) {
  const int ticks = 300;
  double volume_mm3[3];
  int i = 0;
  for (const double h : {0.1, 0.2, 0.3}) {
    const BenchResult r = RunCut(MakeBallCut(h, 10, false), FewTicks(ticks));
    ExpectGoodCut(r, ticks, 10);
    volume_mm3[i++] = Figure(r, "removed");
  }
  EXPECT_NEAR(volume_mm3[1] / volume_mm3[0], 1, 0.01);
  EXPECT_NEAR(volume_mm3[2] / volume_mm3[0], 1, 0.01);
  const BenchResult slow = RunCut(MakeBallCut(0.2, 5, false), FewTicks(2 * ticks));
  ExpectGoodCut(slow, 2 * ticks, 5);
}

TEST(BenchTick, PeersBlockAgreesWithItsDenseArrayThroughout) {
  const BenchResult r = RunCut(MakeBallCut(0.2, 10, true), FewTicks(50));
  ExpectGoodCut(r, 50, 10);
  ASSERT_TRUE(r.baseline);
  EXPECT_EQ(r.baseline->times.count, 50u);
  EXPECT_LE(Figure(r, "phi against dense at the surface, at most"), 1e-4);
}

// The three ways with which the tick is compared remove the same from the bone.
TEST(BenchTick, BaselinesRemoveTheSame) {
  BlockParams block;
  block.size_mm = {12, 6, 8};
  block.voxel_mm = 0.2;
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  const Pose start{glm::angleAxis(-0.5 * std::numbers::pi, Vec3(1, 0, 0)), Vec3(-2, 0.05, 9)};
  VdbCut whole(bone), leaves(bone);
  for (int i = 0; i < 20; ++i) {
    const Pose X_WT{start.R_AB, start.p_AB + Vec3(0.1 * i, 0, 0)};
    whole.MakeTool(DiscSaw{}, X_WT);
    whole.RemoveTool();
    leaves.CutLeaves(DiscSaw{}, X_WT);
  }
  EXPECT_LT(whole.bone().CalcVolume(), bone.CalcVolume() - 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p_W(6 * any(random), 0.5 * any(random), -2 + 2 * any(random));
    // A voxel in a leaf that is wholly within the tool has the band's value in one of them.
    const double band_mm = bone.band_mm();
    EXPECT_NEAR(std::min(whole.bone().SignedDistance(p_W), band_mm),
                std::min(leaves.bone().SignedDistance(p_W), band_mm), 1e-5)
        << p_W.x << " " << p_W.y << " " << p_W.z;
  }
}

TEST(BenchTick, BlockOfAMandibleIsCut) {
  const BenchResult r = RunCut(MakeMandibleCut(false), FewTicks(200));
  ExpectGoodCut(r, 200, 5);
  EXPECT_GT(Figure(r, "removed"), 0.2 * 5 * 0.2 * 5);  // the kerf of a body at least 5 mm thick, 1 mm long
}

TEST(BenchTick, SameBoneFromRunToRunAndAtEveryVectorWidth) {
  CutCase cut = MakeDiscCut(0.2);
  cut.warm_up_mm = 3;  // just into the bone
  const std::uint64_t hash = RunCut(cut, FewTicks(60)).hash;
  EXPECT_EQ(RunCut(cut, FewTicks(60)).hash, hash);
  for (const std::string& target : VectorTargets()) {
    SetVectorTarget(target);
    EXPECT_EQ(RunCut(cut, FewTicks(60)).hash, hash) << target;
  }
  SetVectorTarget("");
  EXPECT_NE(RunCut(cut, FewTicks(61)).hash, hash);  // the hash detects a difference of one tick
}

TEST(BenchTick, MorePassesMeasureMoreTicks) {
  CutCase cut = MakeBallCut(0.3, 10, false);
  cut.measured_mm = 0.5;  // 50 ticks
  EXPECT_EQ(RunCut(cut, FewTicks(120)).times.count, 150u);
}

TEST(BenchTick, TicksSleepFiveMillimetresFromTheBone) {
  const BenchResult r = RunIdle(FewTicks(300));
  EXPECT_EQ(r.times.count, 300u);
  EXPECT_EQ(Figure(r, "ticks asleep"), 100);
}

TEST(BenchTick, ToolThatDoesNotFollowIsReported) {
  CutCase cut = MakeDiscCut(0.2);
  cut.rpm = 0;           // a stopped disc does not cut, and the bone stops it
  cut.warm_up_mm = 1.2;  // shortly after first contact
  const BenchResult r = RunCut(cut, FewTicks(50));
  EXPECT_THAT(r.note, testing::StartsWith("the tool fed at "));
  TickReport report;
  report.results = {r};
  EXPECT_THAT(FindTickWarnings(report), testing::ElementsAre("disc-0.2: " + r.note));
}

TEST(BenchTick, CasesAreChosenByName) {
  const std::vector<BenchResult> results = RunTickCases({"idle", "ball-0.3"}, FewTicks(30));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].name, "ball-0.3");  // in the order of the table
  EXPECT_EQ(results[1].name, "idle");
  EXPECT_THAT(test::MessageOf([&] { RunTickCases({"disk-0.1"}, FewTicks(30)); }),
              testing::StartsWith("there is no case \"disk-0.1\"; the nearest is \"disc-0.1\"; the cases are "
                                  "disc-0.1, disc-0.1-effects, disc-0.1-hand, "));
}

TEST(BenchTick, MissingCoreIsRefused) {
  BenchOptions options = FewTicks(10);
  options.core = 4000;
  EXPECT_EQ(test::MessageOf([&] { RunCut(MakeBallCut(0.3, 10, false), options); }),
            "can't pin this program to core 4000; choose a core that it is allowed to use");
}

TickReport MadeUpReport() {
  BenchResult cut;
  cut.name = "disc-0.1";
  cut.title = "a disc";
  cut.times = {5000, 40, 80, 90, 100};
  cut.undisturbed = {4999, 40, 79, 88, 90};
  cut.baseline = {"the library", {30, 8000, 9000, 9500, 9500}};
  cut.figures = {{"removed minus swept", "%", -0.25},
                 {"removed by occupancy minus swept", "%", 0.125},
                 {"force on the hand, mean", "N", 12.5}};
  cut.targets = {{"p99", "us", 100, 80}, {"speedup over the baseline", "", 300, 200, true}};
  cut.stages_us = {1, 2, 3, 4, 5, 6};
  cut.hash = 0xabc;
  BenchResult memory;
  memory.name = "memory";
  memory.title = "memory";
  TickReport report;
  report.results = {cut, memory};
  report.run.cpu = "a processor";
  report.run.cores = 2;
  report.run.load = 0.25;
  report.run.core = 1;
  report.ticks = 5000;
  report.run.vector_width = "avx2";
  return report;
}

TEST(TickReport, JsonContainsErrorsAndHashNextToTheTimes) {
  const auto json = nlohmann::json::parse(FormatTickJson(MadeUpReport()));
  EXPECT_EQ(json["machine"]["cpu"], "a processor");
  EXPECT_EQ(json["machine"]["vector_width"], "avx2");
  EXPECT_EQ(json["machine"]["core"], 1);
  EXPECT_EQ(json["machine"]["realtime"], false);
  EXPECT_EQ(json["ticks_asked_for"], 5000);
  const auto& cut = json["cases"][0];
  EXPECT_EQ(cut["name"], "disc-0.1");
  EXPECT_EQ(cut["tick"]["ticks"], 5000);
  EXPECT_EQ(cut["tick"]["p50_us"], 40);
  EXPECT_EQ(cut["tick"]["p999_us"], 90);
  EXPECT_EQ(cut["undisturbed"]["p99_us"], 79);
  EXPECT_EQ(cut["baseline"]["p50_us"], 8000);
  EXPECT_EQ(cut["baseline"]["times_faster"], 200);
  EXPECT_EQ(cut["stages_mean_us"]["remove"], 5);
  EXPECT_EQ(cut["figures"][0]["what"], "removed minus swept");
  EXPECT_EQ(cut["figures"][0]["value"], -0.25);
  EXPECT_EQ(cut["targets"][0]["at_most"], 100);
  EXPECT_EQ(cut["targets"][0]["met"], true);
  EXPECT_EQ(cut["targets"][1]["at_least"], 300);
  EXPECT_EQ(cut["targets"][1]["met"], false);
  EXPECT_EQ(cut["bone_hash"], "0000000000000abc");
  EXPECT_TRUE(json["cases"][1]["tick"].is_null());
  EXPECT_TRUE(json["cases"][1]["baseline"].is_null());
  EXPECT_TRUE(json["cases"][1]["bone_hash"].is_null());
  EXPECT_TRUE(json["warnings"].empty());
}

TEST(TickReport, MarkdownHasTheWorkOfCutsOnly) {
  TickReport report = MadeUpReport();
  EXPECT_THAT(FormatTickMarkdown(report), testing::Not(testing::HasSubstr("The work of a tick")));
  for (const auto& [what, value] :
       {std::pair("leaves visited by removal", 79.0), std::pair("voxels computed by removal", 11000.0),
        std::pair("voxels changed", 3400.0), std::pair("samples of the bone by contact", 500.0),
        std::pair("bytes of these voxels and corners", 104.0),
        std::pair("these bytes against this core's memory", 11.0),
        std::pair("samples against this core's vector rate", 3.0), std::pair("memory rate of this core", 16.0),
        std::pair("vector rate of this core, floats", 64.0), std::pair("vector rate of this core, doubles", 32.0)}) {
    report.results[0].figures.push_back({what, "", value});
  }
  const std::string markdown = FormatTickMarkdown(report);
  // Removal has no share of the vector rate here, as for a bur.
  EXPECT_THAT(markdown, testing::HasSubstr("| disc-0.1 | 79.0 | 11000 | 3400 | 500 | 104 | 11.0 | | 3.00 |"));
  EXPECT_THAT(markdown, testing::HasSubstr("of 16.0 GB/s"));
}

TEST(TickReport, TablesMarkMissedLimits) {
  TickReport report = MadeUpReport();
  const std::string table = FormatTickTable(report);
  EXPECT_THAT(table, testing::HasSubstr("met     p99 at most 100 us: 80.0"));
  EXPECT_THAT(table, testing::HasSubstr("MISSED  speedup over the baseline at least 300: 200"));
  const std::string markdown = FormatTickMarkdown(report);
  EXPECT_THAT(markdown, testing::HasSubstr("| volume -0.250 %, by occupancy +0.125 % | `0000000000000abc` |"));
  EXPECT_THAT(markdown, testing::HasSubstr("speedup over the baseline 200, at least 300 **missed**"));
  report.run.load = 3;
  EXPECT_THAT(FindTickWarnings(report), testing::ElementsAre(testing::HasSubstr("the machine was busy")));
}

}  // namespace
}  // namespace kerf
