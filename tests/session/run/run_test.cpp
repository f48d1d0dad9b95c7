#include "session/run/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "bone/mesh/meshfile.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/overall_progress.h"
#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"
#include "session/run/run_warnings.h"
#include "support/block_scene.h"
#include "support/far_apart.h"
#include "support/forces_csv.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// A block of 8 x 4 x 6 mm, which a stroke straight down cuts in two.
const std::string kRunScene =
    test::BlockToml({8, 4, 6}, 0.1) + test::StrokeToml({0, 0, 11.5}, {0, 0, 3}, 10, {0, 1, 0});

class Run : public test::ResultFolderTest {};

TEST_F(Run, CutsABlockInTwoWithConsistentFiles) {
  const Scene scene = ParseScene(kRunScene + "[output]\npictures = false\n", "scene.toml");
  const RunSummary summary = RunScene(scene, folder_, {});
  // The kerf is a cuboid: 8 mm long, 0.25 mm wide, 6 mm deep. Along its 56 mm of edges, the bone is rounded by about
  // 0.2 h^2, which is 0.11 mm^3.
  EXPECT_NEAR(summary.removed_mm3, 8 * 0.25 * 6, 0.02 * 12);
  EXPECT_NEAR(summary.removed_mm3 + summary.volume_after_mm3, summary.volume_before_mm3, 1e-9 * 192);
  ASSERT_EQ(summary.pieces.size(), 2u);
  EXPECT_NEAR(summary.pieces[0].volume_mm3, summary.pieces[1].volume_mm3, 0.01 * 90);
  EXPECT_EQ(summary.ticks, 850u);
  EXPECT_EQ(summary.ticks_with_status, 0u);

  // The log has one row per tick, and its sums are the summary's.
  EXPECT_EQ(ReadTextFile(folder_ + "/forces.csv").substr(0, 30), "time_s,segment,x_mm,y_mm,z_mm,");
  std::vector<test::ForceRow> rows = test::ReadForces(folder_ + "/forces.csv");
  ASSERT_EQ(rows.size(), 850u);
  double removed = 0;
  double peak = 0;
  for (test::ForceRow& row : rows) {
    ASSERT_EQ(row.size(), 24u);
    removed += row["removed_mm3"];
    peak = std::max(peak, std::hypot(row["force_x_N"], row["force_y_N"], row["force_z_N"]));
  }
  EXPECT_NEAR(removed, rows.back()["removed_total_mm3"], 1e-4);  // six figures a row
  // Rows count the occupancy of voxels, the summary the bone's volume. These differ at the kerf's edges.
  EXPECT_NEAR(rows.back()["removed_total_mm3"], summary.removed_mm3, 0.02 * 12);
  EXPECT_NEAR(peak, summary.force.peak_N, 1e-4 * peak);
  EXPECT_NEAR(rows.back()["time_s"], 0.85, 1e-9);
  EXPECT_NEAR(rows.back()["z_mm"], 3, 1e-9);

  // The bone and the pieces on disk are those of the summary.
  const Bone bone = ReadBone(folder_ + "/bone.vdb");
  EXPECT_EQ(bone.CalcHash(), summary.hash_after);
  for (int i = 0; i < 2; ++i) {
    const TriangleMesh mesh = ReadMesh(folder_ + "/piece_" + std::to_string(i + 1) + ".stl");
    EXPECT_EQ(CountOpenEdges(mesh), 0u);
    EXPECT_NEAR(CalcEnclosedVolume(mesh) / summary.pieces[i].volume_mm3, 1,
                0.01);  // edges are bevelled by half a voxel
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"));
  EXPECT_EQ(json["pieces"].size(), 2u);
  EXPECT_NEAR(json["removed"]["total_mm3"].get<double>(), summary.removed_mm3, 1e-12);
  for (const auto& file : json["files"]) EXPECT_TRUE(fs::exists(folder_ + "/" + file.get<std::string>())) << file;

  // The resolved scene next to the results gives the same run.
  const Scene resolved = ReadScene(folder_ + "/scene.toml");
  const RunSummary again = RunScene(resolved, folder_ + "/again", {});
  EXPECT_EQ(again.hash_after, summary.hash_after);
  EXPECT_EQ(again.force.peak_N, summary.force.peak_N);
}

// Two kerfs 0.5 mm wide leave a wall of 0.15 or 0.6 mm between them.
TEST_F(Run, WarnsOfAWallThinnerThanAVoxel) {
  for (const double second_mm : {0.7, 1.15}) {
    const std::string scene = test::kBarToml + test::StrokeToml({0.05, 0, 6.5}, {0.05, 0, 0.5}, 20, {1, 0, 0}) +
                              test::StrokeToml({second_mm, 0, 6.5}, {second_mm, 0, 0.5}, 20, {1, 0, 0}) +
                              "[output]\npictures = false\nbone = false\npieces = false\n";
    const RunSummary summary = RunScene(ParseScene(scene, "scene.toml"), folder_, {});
    const bool is_thin = second_mm < 1;
    EXPECT_EQ(summary.piece_counts.thin_mm3 > 1, is_thin);
    EXPECT_THAT(
        summary.warnings,
        testing::Contains(testing::HasSubstr("a wall is thinner than about a voxel (0.2 mm)")).Times(is_thin ? 1 : 0));
    for (const PieceSummary& piece : summary.pieces) EXPECT_GE(piece.volume_mm3, 1);
    const auto dust = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"))["dust"];
    EXPECT_EQ(dust["volume_mm3"], summary.piece_counts.dust_mm3);
    EXPECT_EQ(dust["before_cut"]["count"], 0);
  }
  PieceCounts counts{.dust_count = 5, .dust_mm3 = 0.404, .old_dust_count = 2, .old_dust_mm3 = 0.1};
  EXPECT_EQ(DescribeCrumbs(counts), "; 5 crumbs of 0.404 mm3 in total, 2 of them (0.1 mm3) from before the cut");
}

TEST_F(Run, WritesSound) {
  // The disc moves down from 0.5 mm above the bone. The sound is that of the idle saw first, and louder in the cut.
  const Scene scene = ParseScene(
      kRunScene +
          "[output]\npictures = false\nbone = false\npieces = false\n[force]\nlaw = \"hertz_chip\"\n[effects.sound]\n",
      "scene.toml");
  const RunSummary summary = RunScene(scene, folder_, {});
  EXPECT_NE(std::find(summary.files.begin(), summary.files.end(), "sound.wav"), summary.files.end());
  SF_INFO info{};
  SNDFILE* file = sf_open((folder_ + "/sound.wav").c_str(), SFM_READ, &info);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(info.samplerate, 48000);
  EXPECT_EQ(info.channels, 1);
  EXPECT_EQ(info.frames, 48 * (850 + 10));
  std::vector<float> x(static_cast<std::size_t>(info.frames));
  EXPECT_EQ(sf_read_float(file, x.data(), info.frames), info.frames);
  sf_close(file);
  float largest = 0;
  for (const float v : x) largest = std::max(largest, std::abs(v));
  EXPECT_LE(largest, 0.9F);
  const auto line = [&](double hz, std::size_t begin, std::size_t count) {
    std::complex<double> sum = 0;
    for (std::size_t i = begin; i < begin + count; ++i)
      sum += static_cast<double>(x[i]) * std::polar(1.0, -2 * std::acos(-1.0) * hz * static_cast<double>(i) / 48000);
    return 2 * std::abs(sum) / static_cast<double>(count);
  };
  // With 24 teeth at 125 Hz, bins of 10 Hz contain whole periods of all lines. The noise is some thousandths per bin.
  EXPECT_GT(line(125, 19200, 4800 * 2), 0.05);
  EXPECT_GT(line(3000, 19200, 4800 * 2), 0.03);
  EXPECT_LT(line(3070, 19200, 4800 * 2), 0.01);
  EXPECT_GT(line(125, 19200, 4800 * 2), 1.2 * line(125, 480, 384 * 4));
  EXPECT_LT(line(3000, 480, 384 * 4), 1e-4);
  // The same run gives the same bytes. A run without the effect removes the file of an earlier run.
  const std::string bytes = ReadTextFile(folder_ + "/sound.wav");
  RunScene(scene, folder_, {});
  EXPECT_EQ(ReadTextFile(folder_ + "/sound.wav"), bytes);
  const Scene silent =
      ParseScene(kRunScene + "[output]\npictures = false\nbone = false\npieces = false\n", "scene.toml");
  RunScene(silent, folder_, {});
  EXPECT_FALSE(fs::exists(folder_ + "/sound.wav"));
}

TEST_F(Run, ShowsSpectrumAndGuide) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const Scene scene = ParseScene(
      kRunScene +
          "[output]\nbone = false\npieces = false\n[effects.tooth_vibration]\n[effects.guide]\nslot_length_mm = 2.0\n",
      "scene.toml");
  const RunSummary summary = RunScene(scene, folder_, {});
  for (const char* name : {"spectrum.png", "guide.png", "deviation.png"}) {
    EXPECT_NE(std::find(summary.files.begin(), summary.files.end(), name), summary.files.end()) << name;
    EXPECT_GT(fs::file_size(folder_ + "/" + name), 5000u) << name;
  }
}

TEST_F(Run, WorkIsTheForceAlongThePath) {
  // The disc moves straight down, so the hand's work is the integral of the vertical force over the distance.
  const Scene scene = ParseScene(kRunScene, "scene.toml");
  const RunResult run = RunPath(MakeSceneBone(scene, {}), MakeSimulationParams(scene), MakePath(scene), 1000, 7500, {});
  double work = 0;
  double impulse = 0;
  for (const TickRecord& t : run.ticks) {
    work += t.out.f_T_W_N.z * 0.01;  // 10 mm/s, 1 ms
    impulse += glm::length(t.out.f_T_W_N) * 0.001;
  }
  const ForceSummary forces = SummarizeForces(run.ticks, 1000);
  ASSERT_GT(work, 0);
  EXPECT_NEAR(forces.work_Nmm, work, 1e-6 * work);
  EXPECT_NEAR(forces.impulse_Ns, impulse, 1e-6 * impulse);
}

TEST_F(Run, PicturesAreWrittenAndNamed) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const Scene scene = ParseScene(kRunScene, "scene.toml");
  const RunSummary summary = RunScene(scene, folder_, {});
  for (const char* name : {"before.png", "after.png", "cut.png", "apart.png", "force.png"}) {
    EXPECT_EQ(std::count(summary.files.begin(), summary.files.end(), name), 1) << name;
    EXPECT_EQ(ReadTextFile(folder_ + "/" + name).substr(1, 3), "PNG");
  }
}

TEST_F(Run, ReportsItsStagesInOrderAndTheirProgress) {
  const Scene scene = ParseScene(kRunScene, "scene.toml");
  std::vector<std::string> expected;
  for (const ExpectedStage& stage : ListRunStages(scene, true)) expected.push_back(stage.name);
  if (!KERF_WITH_PICTURES) expected.pop_back();
  std::vector<std::string> stages;
  std::map<std::string, double> last;
  RunScene(scene, folder_, [&](const std::string& stage, double fraction) {
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
    EXPECT_GE(fraction, last[stage]) << stage;
    EXPECT_LE(fraction, 1) << stage;
    last[stage] = fraction;
  });
  EXPECT_EQ(stages, expected);
  EXPECT_EQ(last["writing the pieces"], 1);
  EXPECT_EQ(last["drawing the pictures"], KERF_WITH_PICTURES ? 1 : 0);
}

TEST(OverallProgress, StageThatWasEndedEarlyCountsOnlyAsFarAsItCame) {
  const std::vector<ExpectedStage> stages{{"first", 10}, {"cutting", 60, true}, {"last", 30}};
  OverallProgress whole(stages);
  EXPECT_DOUBLE_EQ(whole.Advance("first", 0.5), 0.05);
  EXPECT_DOUBLE_EQ(whole.Advance("cutting", 1), 0.7);
  EXPECT_DOUBLE_EQ(whole.Advance("last", 0.5), 0.85);
  OverallProgress ended(stages);
  EXPECT_DOUBLE_EQ(ended.Advance("cutting", 1.0 / 6), 0.2);
  EXPECT_DOUBLE_EQ(ended.Advance("last", 0.5), (10 + 10 + 15) / 50.0);
  EXPECT_DOUBLE_EQ(ended.Advance("last", 1), 1);
  OverallProgress skipped(stages);  // a stage that only reports its start takes its time
  EXPECT_DOUBLE_EQ(skipped.Advance("first", 0), 0);
  EXPECT_DOUBLE_EQ(skipped.Advance("cutting", 0), 0.1);
}

TEST(WaysApart, EachPieceComesFurtherFromTheNext) {
  using testing::ElementsAre;
  EXPECT_THAT(CalcWaysApart(std::vector{3.0, -2.0}, 12), ElementsAre(6, -6));
  // Both beside the cut, at 0.
  EXPECT_THAT(CalcWaysApart(std::vector{3.0, 20.0}, 12), ElementsAre(-6, 6));
  EXPECT_THAT(CalcWaysApart(std::vector{5.0, 9.0, -4.0}, 12), ElementsAre(0, 12, -12));
  EXPECT_THAT(CalcWaysApart(std::vector{5.0}, 12), ElementsAre(0));
}

TEST_F(Run, EarlierResultsAreReplacedOnlyTogether) {
  const std::string changed =
      test::BlockToml({8, 4, 6}, 0.1) + test::StrokeToml({0, 1, 11.5}, {0, 1, 3}, 10, {0, 1, 0});
  RunScene(ParseScene(kRunScene, "scene.toml"), folder_, {});
  const auto read_all = [&] {
    std::map<std::string, std::size_t> contents;  // hashes, because a failure prints them
    for (const auto& file : fs::directory_iterator(folder_)) {
      const std::string name = file.path().filename().string();
      if (!name.starts_with('.')) contents[name] = std::hash<std::string>()(ReadTextFile(file.path().string()));
    }
    return contents;
  };
  const std::map<std::string, std::size_t> earlier = read_all();
  int looks = 0;
  RunScene(ParseScene(changed, "scene.toml"), folder_, [&](const std::string&, double) {
    ++looks;
    EXPECT_EQ(read_all(), earlier);
  });
  EXPECT_GT(looks, 4);
  const std::map<std::string, std::size_t> now = read_all();
  for (const char* name : {"summary.json", "forces.csv", "bone.vdb", "piece_1.stl"}) {
    EXPECT_NE(now.at(name), earlier.at(name)) << name;
  }
}

TEST_F(Run, ReducedPiecesAreSmallerAndWithinTheStatedError) {
  const Scene scene = ParseScene(kRunScene + "[output]\npictures = false\n", "scene.toml");
  const RunSummary summary = RunScene(scene, folder_ + "/reduced", {});
  const RunSummary full = RunScene(scene, folder_ + "/full", {}, {}, {}, 0);
  EXPECT_EQ(summary.surface_error_mm, 0.02);
  EXPECT_EQ(full.surface_error_mm, 0);
  EXPECT_EQ(summary.hash_after, full.hash_after);
  EXPECT_EQ(summary.force.impulse_Ns, full.force.impulse_Ns);
  ASSERT_EQ(summary.pieces.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const TriangleMesh reduced_mesh = ReadMesh(folder_ + "/reduced/" + summary.pieces[i].file);
    const TriangleMesh full_mesh = ReadMesh(folder_ + "/full/" + full.pieces[i].file);
    EXPECT_EQ(reduced_mesh.triangles.size(), summary.pieces[i].triangles);
    EXPECT_EQ(full_mesh.triangles.size(), full.pieces[i].triangles);
    EXPECT_LT(summary.pieces[i].triangles, full.pieces[i].triangles);
    EXPECT_EQ(CountOpenEdges(reduced_mesh), 0u);
    // The files contain floats, whose rounding is 1e-6 mm here.
    EXPECT_LE(test::CalcLargestDistance(full_mesh, reduced_mesh, 0.05), 0.02 + 1e-5);
    EXPECT_LE(test::CalcLargestDistance(reduced_mesh, full_mesh, 0.05), 0.02 + 1e-5);
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/reduced/summary.json"));
  EXPECT_EQ(json["surface_error_mm"], 0.02);
  EXPECT_EQ(json["pieces"][0]["triangles"], summary.pieces[0].triangles);
}

// Coarse voxels, with edges much longer than the error, are also reduced.
TEST_F(Run, ReducedCoarsePiecesAreWithinTheStatedError) {
  std::string text = kRunScene;
  text.replace(text.find("voxel_mm = 0.1"), 14, "voxel_mm = 0.3");
  const Scene scene = ParseScene(text + "[output]\npictures = false\n", "scene.toml");
  const RunSummary summary = RunScene(scene, folder_ + "/reduced", {});
  const RunSummary full = RunScene(scene, folder_ + "/full", {}, {}, {}, 0);
  ASSERT_GE(summary.pieces.size(), 1u);
  EXPECT_LT(summary.pieces[0].triangles, full.pieces[0].triangles);
  const TriangleMesh reduced_mesh = ReadMesh(folder_ + "/reduced/piece_1.stl");
  const TriangleMesh full_mesh = ReadMesh(folder_ + "/full/piece_1.stl");
  EXPECT_LE(test::CalcLargestDistance(full_mesh, reduced_mesh, 0.05), 0.02 + 1e-5);
  EXPECT_LE(test::CalcLargestDistance(reduced_mesh, full_mesh, 0.05), 0.02 + 1e-5);
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/reduced/summary.json"))["surface_error_mm"], 0.02);
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/full/summary.json"))["surface_error_mm"], 0);
}

TEST_F(Run, OmitsSurfacesThatAreNotWritten) {
  const Scene scene = ParseScene(kRunScene + "[output]\npictures = false\npieces = false\n", "scene.toml");
  RunScene(scene, folder_, {});
  EXPECT_FALSE(nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json")).contains("surface_error_mm"));
}

TEST_F(Run, WarningsAreInTheSummary) {
  std::string text = kRunScene;
  text.replace(text.find("end_mm = [0.0, 0.0, 3.0]"), 24, "end_mm = [0.0, 0.0, 11.2]");
  const Scene scene = ParseScene(text + "[output]\npictures = false\n", "scene.toml");
  const RunSummary summary = RunScene(scene, folder_, {});
  EXPECT_EQ(std::count(summary.warnings.begin(), summary.warnings.end(), "the saw touched no bone on its path"), 1);
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"))["warnings"], summary.warnings);
}

TEST(TickWarnings, BoneRemovedWithoutTeethIsNotUntouched) {
  EXPECT_EQ(FindTickWarnings({.tool = NameTool(TwistDrill{})}),
            std::vector<std::string>{"the drill touched no bone on its path"});
  EXPECT_EQ(FindTickWarnings({.removed_mm3 = 308.14, .tool = NameTool(OscillatingBlade{})}),
            std::vector<std::string>{"no tooth cut, but the saw went through bone and removed 308.1 mm3 without a "
                                     "force; move it with its teeth first"});
  EXPECT_TRUE(FindTickWarnings({.touched = true, .removed_mm3 = 308.14}).empty());
}

TEST_F(Run, ReportsFragmentsWithoutChangingTheResults) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const std::string plain = kRunScene + "[output]\npieces = false\nbone = false\n";
  const RunSummary without = RunScene(ParseScene(plain + "pictures = false\n", "scene.toml"), folder_, {});
  EXPECT_FALSE(without.fragments.has_value());
  const RunSummary with =
      RunScene(ParseScene(plain + "[effects.fragments]\nevery_ms = 20\n", "scene.toml"), folder_, {});
  EXPECT_EQ(with.hash_after, without.hash_after);
  ASSERT_TRUE(with.fragments.has_value());
  const FragmentsReport& report = *with.fragments;
  ASSERT_EQ(report.events.size(), 1u);
  // At the block's ends, 4 mm from its centre, the rim is sqrt(11^2 - 4^2) = 10.25 mm below the disc's centre. The rim
  // passes the lower side, z = -6, when the centre is at 4.25, after 0.725 s. The block separates half a voxel earlier,
  // 0.005 s; the detection is up to 0.02 s late.
  EXPECT_GE(report.events[0].time_s, 0.715);
  EXPECT_LE(report.events[0].time_s, 0.745);
  ASSERT_EQ(report.found.pieces.size(), with.pieces.size());
  for (std::size_t i = 0; i < with.pieces.size(); ++i) {
    // The block's faces lie on voxel centres, which count as outside: half a voxel is missing on each.
    const double faces_mm2 = 2 * (8 * 1.875 + 8 * 6 + 1.875 * 6);
    EXPECT_NEAR(report.found.pieces[i].volume_mm3, with.pieces[i].volume_mm3, 0.05 * faces_mm2);
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"));
  EXPECT_EQ(json["fragments"]["events"][0]["time_s"], report.events[0].time_s);
  EXPECT_EQ(json["fragments"]["events"][0]["piece"], 2);
  EXPECT_EQ(json["effects"]["fragments"]["pieces"]["last"], 2);
  // This picture replaces the one without the effect.
  EXPECT_TRUE(fs::exists(folder_ + "/fragments.png"));
  EXPECT_FALSE(fs::exists(folder_ + "/apart.png"));
}

/// A block that a stroke straight down cuts in two at y = 0.5; a later stroke passes through the middle of the smaller
/// part.
const std::string kTwoStrokes =
    test::BlockToml({8, 6, 6}, 0.1) + test::StrokeToml({0, 0.5, 11.5}, {0, 0.5, 3}, 10, {0, 1, 0}) +
    test::StrokeToml({0, 1.8, 11.5}, {0, 1.8, 3}, 10, {0, 1, 0}) + "[force]\nlaw = \"hertz_chip\"\n" +
    "[output]\nbone = false\npictures = false\n[effects.fragments]\n";

class TakingOut : public Run {
 protected:
  RunSummary RunWith(const std::string& more) {
    return RunScene(ParseScene(kTwoStrokes + more, "scene.toml"), folder_, {});
  }
  /// Returns the forces of the ticks of a stroke.
  std::vector<double> ForcesOfStroke(int stroke) const {
    std::vector<double> forces_N;
    for (const test::ForceRow& row : test::ReadForces(folder_ + "/forces.csv")) {
      if (row.at("segment") != stroke) continue;
      forces_N.push_back(std::hypot(row.at("force_x_N"), row.at("force_y_N"), row.at("force_z_N")));
    }
    return forces_N;
  }
};

double Largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

TEST_F(TakingOut, NoForceWhereADeletedPieceWas) {
  const RunSummary held = RunWith("");
  const std::vector<double> first = ForcesOfStroke(1);
  EXPECT_GT(Largest(ForcesOfStroke(2)), 10);
  EXPECT_EQ(held.CalcOut_mm3(), 0);
  EXPECT_EQ(held.pieces.size(), 3u);
  std::uint64_t left = 0;
  for (const std::string fate : {"deleted", "hidden", "moved"}) {
    SCOPED_TRACE(fate);
    const RunSummary s = RunWith("pieces = \"" + fate + "\"\n");
    // With the six figures of the log, the forces are the same until the piece is removed.
    EXPECT_EQ(ForcesOfStroke(1), first);
    EXPECT_EQ(Largest(ForcesOfStroke(2)), 0);
    ASSERT_EQ(s.fragments->out.size(), 1u);
    const PieceOut& out = s.fragments->out[0];
    EXPECT_EQ(out.id, 2);
    EXPECT_EQ(ToString(out.fate), fate);
    EXPECT_EQ(out.time_s, 0.85);  // the end of the first stroke, where the tool is lifted
    // The piece is a cuboid of 8 x 2.375 x 6 mm, whose edges are rounded by about 0.2 h^2.
    EXPECT_NEAR(out.volume_mm3, 8 * 2.375 * 6, 0.02 * 66);
    // The tolerance covers the rounding of the sums.
    EXPECT_NEAR(s.removed_mm3 + s.volume_after_mm3 + s.CalcOut_mm3(), s.volume_before_mm3, 1e-9 * s.volume_before_mm3);
    EXPECT_EQ(s.CalcOut_mm3(), out.volume_mm3);
    EXPECT_NEAR(s.removed_mm3, 8 * 0.25 * 6, 0.02 * 12);
    // The largest piece is bit-identical, whatever happens to the other.
    if (left == 0) left = s.hash_after;
    EXPECT_EQ(s.hash_after, left);
    const bool gone = fate == "deleted";
    EXPECT_EQ(gone ? s.fragments->CalcDeleted_mm3() : s.fragments->CalcSetAside_mm3(), out.volume_mm3);
    ASSERT_EQ(s.pieces.size(), gone ? 1u : 2u);
    EXPECT_EQ(fs::exists(folder_ + "/piece_2.stl"), !gone);
    if (!gone) {
      const TriangleMesh mesh = ReadMesh(folder_ + "/piece_2.stl");
      EXPECT_NEAR(CalcEnclosedVolume(mesh) / out.volume_mm3, 1, 0.01);
      // The piece moves directly away from the larger piece, which lies next to it along y.
      EXPECT_NEAR(glm::length(out.move_mm - Vec3(0, fate == "moved" ? 6 : 0, 0)), 0, 1e-6);
      double lowest = 1e9;
      for (const Vec3& p : mesh.points) lowest = std::min(lowest, p.y);
      EXPECT_NEAR(lowest, 0.625 + (fate == "moved" ? 6 : 0), 0.05);
      EXPECT_NEAR(s.pieces[1].bounds_W.lower.y, lowest, 1e-3);
    }
    const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"));
    EXPECT_EQ(json["fragments"]["taken_out"][0]["place"], fate);
    EXPECT_EQ(json["fragments"][gone ? "deleted_mm3" : "taken_out_mm3"], out.volume_mm3);
    EXPECT_EQ(json["removed"]["removed_plus_remaining_minus_initial_mm3"],
              s.removed_mm3 + s.volume_after_mm3 + s.CalcOut_mm3() - s.volume_before_mm3);
    // Repeats the run.
    const std::string forces = ReadTextFile(folder_ + "/forces.csv");
    EXPECT_EQ(RunWith("pieces = \"" + fate + "\"\n").hash_after, left);
    EXPECT_EQ(ReadTextFile(folder_ + "/forces.csv"), forces);
  }
}

TEST_F(TakingOut, PieceIsMovedAsRequested) {
  const RunSummary s = RunWith("pieces = \"moved\"\nmove_mm = [1, 2, 30]\n");
  ASSERT_EQ(s.pieces.size(), 2u);
  EXPECT_EQ(s.pieces[1].move_mm, Vec3(1, 2, 30));
  EXPECT_NEAR(s.pieces[1].bounds_W.upper.z, 30, 0.05);
}

TEST_F(TakingOut, DustIsRemovedOnRequest) {
  // The smaller part is dust.
  const RunSummary s = RunWith("dust_mm3 = 140\nremove_dust = true\n");
  EXPECT_EQ(Largest(ForcesOfStroke(2)), 0);
  EXPECT_EQ(s.fragments->event_count, 0u);
  EXPECT_EQ(s.fragments->found.dust_count, 0u);
  EXPECT_NEAR(s.fragments->CalcDustOut_mm3(), 8 * 2.375 * 6, 0.02 * 66);
  EXPECT_EQ(s.fragments->CalcDeleted_mm3(), 0);
  EXPECT_NEAR(s.removed_mm3 + s.volume_after_mm3 + s.CalcOut_mm3(), s.volume_before_mm3, 1e-9 * s.volume_before_mm3);
}

// The path goes down, far up, sideways and down again without lifting the tool.
TEST_F(TakingOut, PieceIsRemovedBetweenTwoTicksOnceTheToolIsClear) {
  const std::string text(kTwoStrokes);
  const auto run = [&](const std::string& more) {
    const std::size_t second = text.find("[[path.stroke]]", text.find("[[path.stroke]]") + 1);
    std::string scene = text.substr(0, second);
    const Vec3 stops[] = {{0, 0.5, 3}, {0, 0.5, 25}, {0, 1.8, 25}, {0, 1.8, 3}};
    for (int i = 0; i < 3; ++i) scene += test::StrokeToml(stops[i], stops[i + 1], 40, {0, 1, 0}, "retract = false\n");
    const Scene parsed = ParseScene(scene + "[effects.fragments]\n" + more, "scene.toml");
    return RunPath(MakeSceneBone(parsed, {}), MakeSimulationParams(parsed), MakePath(parsed), 1000, 7500, {});
  };
  const RunResult held = run("");
  const RunResult deleted = run("pieces = \"deleted\"\n");
  ASSERT_EQ(held.ticks.size(), deleted.ticks.size());
  ASSERT_EQ(deleted.fragments->out.size(), 1u);
  const double gone_s = deleted.fragments->out[0].time_s;
  bool met_it_held = false;
  for (std::size_t i = 0; i < held.ticks.size(); ++i) {
    const TickRecord& a = held.ticks[i];
    const TickRecord& b = deleted.ticks[i];
    const Vec3 f_N = b.out.f_T_W_N;
    if (a.time_s <= gone_s) {
      ASSERT_EQ(a.out.f_T_W_N, f_N) << a.time_s;
    } else {
      ASSERT_EQ(f_N, Vec3(0)) << a.time_s;
    }
    if (b.time_s > gone_s - 0.01 && b.time_s < gone_s + 0.01) {
      // The tool is clear of the piece: above its top by the disc's radius of 11 mm, by 2 mm, and by 24 voxels, which
      // are at least two leaves.
      ASSERT_EQ(f_N, Vec3(0));
      ASSERT_GT(b.X_WT.p_AB.z, 11 + 2 + 2.4);
    }
    met_it_held = met_it_held || (a.time_s > gone_s && glm::length(a.out.f_T_W_N) > 10);
  }
  EXPECT_TRUE(met_it_held);
}

TEST_F(Run, RetractedToolDoesNotCutOnItsWay) {
  // The two strokes both stay above the bone, but the straight line from the end of the first to the start of the
  // second passes through it.
  const Scene scene = ParseScene(R"(
[bone]
model = "block"
[bone.block]
size_x_mm = 4.0
size_y_mm = 4.0
size_z_mm = 4.0
[[path.stroke]]
start_mm = [0.0, 0.0, 14.0]
end_mm = [0.0, 0.0, 12.0]
feed_mm_per_s = 10.0
disc_normal = [0.0, 1.0, 0.0]
[[path.stroke]]
start_mm = [0.0, 0.0, -17.0]
end_mm = [0.0, 0.0, -16.0]
feed_mm_per_s = 10.0
disc_normal = [0.0, 1.0, 0.0]
)",
                                 "scene.toml");
  const RunResult run = RunPath(MakeSceneBone(scene, {}), MakeSimulationParams(scene), MakePath(scene), 1000, 7500, {});
  EXPECT_EQ(run.removed_mm3, 0);
}

}  // namespace
}  // namespace kerf
