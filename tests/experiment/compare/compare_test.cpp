// Tests of a complete comparison on a small block, from the scene to the output files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/files/files.h"
#include "bone/grid/ct_modulus.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/vdb/bonefile.h"
#include "cut/force/measured.h"
#include "experiment/compare/compare_files.h"
#include "experiment/compare/run_cases.h"
#include "kerf/error.h"
#include "made_up.h"
#include "session/run/make_bone.h"
#include "session/run/run.h"
#include "session/run/run_slab.h"
#include "support/block_scene.h"
#include "support/message_of.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// A block of two materials on one side of the disc's centre (x from 0 to 12 mm), which is cut straight down.
const std::string kScene = test::BlockToml({12, 2, 6}, 0.2) + "top_mm = [6.0, 0.0, 0.0]\n" + test::LayerToml(3, 24) +
                           test::LayerToml(3, 6) + test::StrokeToml({0, 0, 11.5}, {0, 0, 4}, 12, {0, 1, 0});
const std::string kSlab = "[slab]\ndirection = [0, 0, -1]\n";

Scene Parse(const std::string& more = "") {
  return ParseScene(kScene + more, "scene.toml");
}

std::string MessageOf(const Scene& scene, const CompareParams& params) {
  return test::MessageOf([&] { CompareScene(scene, params, {}); });
}

TEST(Compare, SameLawInBothModesGivesTheSameForceWhereTheArcsAreTheSame) {
  // The slab's corrected reading uses the law hertz_constant_bite. Down to a depth of 11 mm, the rim's arc in the block
  // is the arc over which the slab counts teeth, so the sums of the tooth forces agree. The first 0.5 mm and the border
  // between the layers are excluded, because there the grid has an edge while the slab's border is sharp. With voxels
  // of 0.2 mm the free edge at the disc's centre is rounded by up to 0.14 mm, on an arc of at least 3.4 mm. The kerf is
  // 1.25 voxels wide, and its corners extend into the region that the teeth sample, which adds up to 1 %.
  const Comparison c = CompareScene(Parse(kSlab + "[force]\nlaw = \"hertz_constant_bite\"\n"), {{}, 0.1, 1}, {});
  ASSERT_EQ(c.cases.size(), 3u);
  const CaseResult& voxel = c.cases[0];
  const CaseResult& corrected = c.cases[2];
  int checked = 0;
  for (const std::size_t i : c.slice_bins) {
    const double h = c.grid.Centre(i);
    if (h < 0.5 || std::abs(h - 3) < 0.4 || h > 5.2) continue;
    const double arc_mm = 11 * std::acos(1 - h / 11);
    EXPECT_NEAR(voxel.curve.thrust_N[i] / corrected.curve.thrust_N[i], 1, 0.14 / arc_mm + 0.01) << "at " << h;
    ++checked;
  }
  EXPECT_GT(checked, 30);
  // Checks the component along the cut. For teeth spread evenly over the arc alpha = acos(1 - h/R), it is sin(alpha) /
  // alpha of the sum of their forces. This is checked in one material, down to 3 mm.
  for (const std::size_t i : c.slice_bins) {
    const double h = c.grid.Centre(i);
    if (h < 0.5 || h > 2.6) continue;
    const double alpha = std::acos(1 - h / 11);
    EXPECT_NEAR(voxel.curve.force_N[i] / voxel.curve.thrust_N[i], std::sin(alpha) / alpha, 0.01) << "at " << h;
  }
  // In both modes the work is the integral of the force over the depth. Compares the curve's integral with the sum over
  // the ticks. The tolerance of 2 % covers the bins of 0.1 mm at the onset and the part beyond the last bin.
  double integral_mJ = 0;
  for (const double force : voxel.curve.force_N) integral_mJ += force * c.grid.step_mm;
  EXPECT_NEAR(integral_mJ / voxel.work_mJ, 1, 0.02);
}

TEST(Compare, CasesAreTheScenesLawTheRequestedLawsAndBothSlabs) {
  const auto ids = [](const std::vector<std::string>& laws) {
    std::string text;
    for (const CompareCase& what : MakeCompareCases(ForceLaw("edge_plus_chip"), laws)) text += what.id + " ";
    return text;
  };
  EXPECT_EQ(ids({}), "voxel_edge_plus_chip voxel_hertz_constant_bite slab_as_computed slab_corrected ");
  EXPECT_EQ(ids({"hertz_chip", "edge_plus_chip", "hertz_chip"}),
            "voxel_edge_plus_chip voxel_hertz_chip voxel_hertz_constant_bite slab_as_computed slab_corrected ");
  std::string all = "voxel_edge_plus_chip ";
  for (const ForceLawInfo* law : ForceLaws()) {
    if (std::string(law->name) != "edge_plus_chip") all += "voxel_" + std::string(law->name) + " ";
  }
  EXPECT_EQ(ids({"all"}), all + "slab_as_computed slab_corrected ");
  EXPECT_THROW(ids({"hertz"}), Error);
}

TEST(Compare, OneVoxelCaseUsesTheSlabsLawWhateverTheScenesLaw) {
  SlabParams slab;
  slab.contact_share_of_pitch = 0.02;
  ForceLaw own("hertz_constant_bite");
  const auto last_voxel = [&] {
    const std::vector<CompareCase> cases = MakeCompareCases(own, {}, slab);
    return cases.at(cases.size() - 3);
  };
  EXPECT_EQ(last_voxel().id, "voxel_slab_law");
  EXPECT_EQ(last_voxel().law.Get("contact_share_of_pitch"), 0.02);
  own.Set("contact_share_of_pitch", 0.02);
  EXPECT_EQ(last_voxel().id, "voxel_hertz_constant_bite");
  EXPECT_EQ(MakeCompareCases(own, {}, slab).size(), 3u);
}

TEST(Compare, ReferenceDoesNotDifferFromItselfAndRepetitionsAgree) {
  const Comparison c = CompareScene(Parse(kSlab), {{}, 0.1, 2}, {});
  EXPECT_EQ(c.reference().slice.rms_N, 0);
  EXPECT_EQ(c.reference().slice.peak_N, 0);
  EXPECT_EQ(c.rms_between_N[0][0], 0);
  EXPECT_EQ(c.rms_between_N[0][1], c.rms_between_N[1][0]);
  EXPECT_EQ(c.rms_between_N[0][1], c.cases[1].slice.rms_N);
  for (const CaseResult& r : c.cases) {
    EXPECT_EQ(r.p50_us.size(), 2u);
    EXPECT_EQ(r.ticks, 625u);
    EXPECT_EQ(r.ticks_on_curve, 625u);
  }
  EXPECT_NE(c.cases[1].force_hash, c.cases[2].force_hash);
}

TEST(Compare, EveryTickOfAPathCountsOnceWhateverTheStrokes) {
  // The path goes down, up again through the kerf, and down a second time. The curve uses only the first way down.
  const std::string more =
      "[[path.stroke]]\nend_mm = [0.0, 0.0, 10.0]\nfeed_mm_per_s = 12.0\nretract = false\n"
      "[[path.stroke]]\nend_mm = [0.0, 0.0, 4.0]\nfeed_mm_per_s = 12.0\nretract = false\n";
  const Comparison once = CompareScene(Parse(kSlab), {{}, 0.1, 1}, {});
  const Comparison three_passes = CompareScene(Parse(more + kSlab), {{}, 0.1, 1}, {});
  ASSERT_EQ(once.grid.count, three_passes.grid.count);
  EXPECT_EQ(once.reference().curve.force_N, three_passes.reference().curve.force_N);
  EXPECT_EQ(three_passes.reference().ticks_on_curve, once.reference().ticks_on_curve);
  EXPECT_GT(three_passes.reference().ticks, once.reference().ticks + 900);
}

TEST(Compare, BinInWhichTheSliceEndsIsNotCounted) {
  // The cut is 6 mm deep, in bins of 4 mm: the first bin lies within the slice, and the slice ends inside the second
  // one.
  std::string deep = kScene;
  const std::string end = "end_mm = [0.0, 0.0, 4.0]";
  deep.replace(deep.find(end), end.size(), "end_mm = [0.0, 0.0, -2.0]");
  const Comparison c = CompareScene(ParseScene(deep + kSlab, "scene.toml"), {{}, 4, 1}, {});
  ASSERT_EQ(c.grid.count, 3u);
  EXPECT_EQ(c.slice_bins, std::vector<std::size_t>{0});
  EXPECT_EQ(c.beyond_bins, std::vector<std::size_t>{2});
  EXPECT_EQ(c.region_of_bin[1], 0);
  std::string thin = deep;
  thin.replace(thin.find("size_z_mm = 6.0"), 15, "size_z_mm = 3.8");
  EXPECT_THAT(
      MessageOf(ParseScene(thin + kSlab, "scene.toml"), {{}, 4, 1}),
      testing::MatchesRegex("scene: the slice is 3.* mm long, less than a depth step of 4 mm; choose a smaller step"));
}

TEST(Compare, TimesAreThoseOfTheFastestRepetition) {
  const Comparison c = CompareScene(Parse(kSlab), {{}, 0.5, 4}, {});
  for (const CaseResult& r : c.cases) {
    EXPECT_EQ(r.times.p99_us, *std::min_element(r.p99_us.begin(), r.p99_us.end())) << r.what.label;
  }
}

TEST(Compare, ForceBelongsToTheMiddleOfTheTickInBothModes) {
  const Scene scene = Parse(kSlab);
  const Bone bone = MakeSceneBone(scene, {});
  const SlabProfile profile = MakeSlabProfile(scene, bone);
  const auto cases = MakeCompareCases(scene.force, {});
  const CaseRun voxel = RunCase(cases[0], scene, bone, profile, {});
  const CaseRun slab = RunCase(cases[1], scene, bone, profile, {});
  ASSERT_EQ(voxel.samples.size(), slab.samples.size());
  // Above the bone the slab's blade follows the hand, which moves 12 um per tick. The first oscillation of the spring
  // has decayed.
  int checked = 0;
  for (std::size_t i = 0; i < slab.samples.size(); ++i) {
    const double depth_mm = -0.5 + 0.012 * (static_cast<double>(i) + 0.5);
    if (depth_mm < -0.25 || depth_mm > -0.05) continue;
    EXPECT_NEAR(voxel.samples[i].depth_mm, depth_mm, 0.001);  // accuracy of the profile's entry depth
    EXPECT_NEAR(slab.samples[i].depth_mm, depth_mm, 0.001);
    ++checked;
  }
  EXPECT_GT(checked, 10);
}

TEST(Compare, MemoryIsTheLargerOfTheBoneBeforeAndAfter) {
  // The grid is wide enough to have an interior. Of the interior's voxels, only those that are cut are stored
  // individually.
  std::string wide = kScene;
  wide.replace(wide.find("size_y_mm = 2.0"), 15, "size_y_mm = 12.0");
  const Scene scene = ParseScene(wide + kSlab, "scene.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const CaseRun run = RunCase(MakeCompareCases(scene.force, {})[0], scene, bone, MakeSlabProfile(scene, bone), {});
  const Bone after =
      RunPath(bone, MakeSimulationParams(scene), MakePath(scene), scene.simulation.rate_hz, scene.tool.rpm, {}).bone;
  ASSERT_NE(bone.CalcMemoryBytes(), after.CalcMemoryBytes());
  EXPECT_EQ(run.memory_bytes, std::max(bone.CalcMemoryBytes(), after.CalcMemoryBytes()));
}

TEST(Compare, DoesNotWarnOfTheVoxelLawsInSlabMode) {
  for (const std::string& warning : CompareScene(Parse(kSlab), {{"edge_plus_chip"}, 0.1, 1}, {}).warnings) {
    EXPECT_THAT(warning, testing::Not(HasSubstr("is not used in slab mode")));
  }
}

TEST(Compare, ScenesThatCannotBeComparedAreRefused) {
  EXPECT_EQ(MessageOf(Parse(), {}),
            "scene: to compare with slab mode the scene needs the cut direction; add [slab] with direction = [0, 0, "
            "-1], the direction of its first stroke, or another");
  EXPECT_EQ(MessageOf(Parse(kSlab + "segments_move = true\nhold = \"right\"\n"), {}),
            "scene: [slab] hold = \"right\" leaves the blade where the path starts, but a comparison must move it "
            "along the path; set hold = \"slice\"");
  EXPECT_EQ(MessageOf(Parse(kSlab), {{}, 0.001, 3}), "depth_step_mm = 0.001 is below 0.005; valid range 0.005 to 5 mm");
  EXPECT_EQ(MessageOf(Parse(kSlab), {{}, std::nan(""), 3}),
            "depth_step_mm = nan is not a finite number; valid range 0.005 to 5 mm");
  EXPECT_EQ(MessageOf(Parse(kSlab), {{}, 0.05, 0}), "repetitions = 0 is below 1; valid range 1 to 100");
  EXPECT_EQ(
      MessageOf(Parse(kSlab), {{"herz"}, 0.05, 1}),
      "there is no force law \"herz\"; available: two_component, hertz_chip, hertz_constant_bite, edge_plus_chip, "
      "tabulated");
  EXPECT_EQ(MessageOf(Parse(kSlab + "[tool]\nrpm = 0\n"), {}), "scene: rpm = 0: a stopped saw makes no cut to compare");
  EXPECT_THAT(MessageOf(Parse("[slab]\ndirection = [0, 1, 0]\n"), {}), HasSubstr("degrees out of the disc's plane"));
  // The direction is upwards, so the path starts behind the bone to be cut.
  EXPECT_THAT(MessageOf(Parse("[slab]\ndirection = [0, 0, 1]\n"), {{}, 0.05, 1}),
              HasSubstr("start it before the bone along the cut direction"));
  // The cut is 0.05 mm deep.
  std::string shallow = kScene;
  const std::string end = "end_mm = [0.0, 0.0, 4.0]";
  shallow.replace(shallow.find(end), end.size(), "end_mm = [0.0, 0.0, 10.95]");
  EXPECT_THAT(MessageOf(ParseScene(shallow + kSlab, "scene.toml"), {{}, 0.05, 1}),
              HasSubstr("goes less than 0.1 mm into the bone, too little to compare; the path must go into the bone "
                        "along this direction"));
}

TEST(Compare, SuggestedDirectionHasUnitLength) {
  std::string scene = kScene;
  const std::string start = "start_mm = [0.0, 0.0, 11.5]";
  scene.replace(scene.find(start), start.size(), "start_mm = [-31.5, 0.0, 46.0]");
  EXPECT_THAT(MessageOf(ParseScene(scene, "scene.toml"), {}), HasSubstr("direction = [0.6, 0, -0.8], the direction"));
}

TEST(Compare, PathThatEndsInsideTheSliceIsComparedToItsEndWithAWarning) {
  // The path goes down only 2 mm into the slice of 6 mm.
  std::string short_path = kScene;
  short_path.replace(short_path.find("0.0, 4.0]"), 9, "0.0, 9.0]");
  const Comparison c = CompareScene(ParseScene(short_path + kSlab, "scene.toml"), {{}, 0.1, 1}, {});
  ASSERT_FALSE(c.warnings.empty());
  EXPECT_THAT(c.warnings.back(), testing::MatchesRegex("the path goes through 1.9 mm of the slice's 6(.0.)? mm; .*"));
  EXPECT_TRUE(c.beyond_bins.empty());
  EXPECT_EQ(c.regions.size(), 1u);
}

TEST(Compare, NamesTheSourceOfTheStiffness) {
  const Comparison regions = CompareScene(Parse(kSlab), {{}, 0.5, 1}, {});
  EXPECT_EQ(regions.material, "E by region, from the bone's own table");
  const Comparison uniform =
      CompareScene(Parse(kSlab + "[material]\nkind = \"uniform\"\nE_GPa = 5.0\nnu = 0.2\n"), {{}, 0.5, 1}, {});
  EXPECT_EQ(uniform.material, "uniform, E 5 GPa, nu 0.2");
  EXPECT_THAT(FormatCompareReport(uniform), HasSubstr("- Material: uniform, E 5 GPa, nu 0.2.\n"));
  const auto json = nlohmann::json::parse(FormatCompareJson(uniform));
  EXPECT_EQ(json["material"]["kind"], "uniform");
  EXPECT_EQ(json["material"]["E_GPa"], 5);
}

TEST(Compare, CommandContainsTheRequestAndNoFolder) {
  const CompareParams params{{"hertz_chip", "edge_plus_chip"}, 0.25, 2};
  EXPECT_EQ(CompareScene(Parse(kSlab), params, {}, "scenes of mine/it's a cut.toml").command,
            "kerf compare 'it'\\''s a cut.toml' --laws hertz_chip,edge_plus_chip --depth-step 0.25 --repeat 2");
  EXPECT_EQ(CompareScene(Parse(kSlab), {{}, 0.5, 1}, {}).command,
            "kerf compare scene.toml --depth-step 0.5 --repeat 1");
}

using CompareFiles = test::ResultFolderTest;

TEST_F(CompareFiles, AgreeWithEachOtherAndWithTheComparison) {
  const Comparison c = CompareScene(Parse(kSlab + "[force]\nlaw = \"hertz_chip\"\n"), {{"all"}, 0.1, 1}, {});
  const std::vector<std::string> files = WriteComparison(c, folder_);
  for (const std::string& file : files) EXPECT_TRUE(fs::exists(folder_ + "/" + file)) << file;
  for (const char* png : {"force_depth.png", "difference.png", "cost.png"}) {
    EXPECT_LT(fs::file_size(folder_ + "/" + png), 300'000u) << png;
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/compare.json"));
  ASSERT_EQ(json["cases"].size(), c.cases.size());
  EXPECT_EQ(json["reference"], "voxel_hertz_chip");
  std::istringstream csv(ReadTextFile(folder_ + "/compare.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "depth_mm,region,voxel_hertz_chip_N,voxel_two_component_N,voxel_hertz_constant_bite_N,"
            "voxel_edge_plus_chip_N,voxel_tabulated_N,slab_as_computed_N,slab_corrected_N");
  std::size_t row = 0;
  std::vector<double> squares(c.cases.size(), 0);
  for (; std::getline(csv, line); ++row) {
    std::vector<double> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(std::stod(cell));
    ASSERT_EQ(cells.size(), 2 + c.cases.size()) << line;
    EXPECT_NEAR(cells[0], c.grid.Centre(row), 1e-6);
    EXPECT_EQ(static_cast<int>(cells[1]), c.region_of_bin[row]);
    for (std::size_t k = 0; k < c.cases.size(); ++k) {
      EXPECT_NEAR(json["cases"][k]["force_N"][row].get<double>(), cells[2 + k], 1e-4 * std::abs(cells[2 + k]));
      if (cells[0] < c.profile.end_mm) squares[k] += std::pow(cells[2 + k] - cells[2], 2);
    }
  }
  EXPECT_EQ(row, c.grid.count);
  for (std::size_t k = 0; k < c.cases.size(); ++k) {
    // Recomputes the rms from the table, which has six significant figures.
    const double rms = std::sqrt(squares[k] / static_cast<double>(c.slice_bins.size()));
    EXPECT_NEAR(json["cases"][k]["slice"]["rms_difference_N"].get<double>(), rms, 1e-4);
    EXPECT_EQ(json["cases"][k]["memory_bytes"].get<std::uint64_t>(), c.cases[k].memory_bytes);
  }
  const std::string report = ReadTextFile(folder_ + "/report.md");
  for (const CaseResult& r : c.cases) EXPECT_THAT(report, HasSubstr("| " + r.what.label + " |"));
  for (const char* figure : {"(force_depth.png)", "(difference.png)", "(cost.png)"}) {
    EXPECT_THAT(report, HasSubstr(figure));
  }
}

TEST_F(CompareFiles, NameTheCtLawItsRangeAndAllItsWarnings) {
  // A block with CT numbers. In the lowest 1.2 mm of the 5 mm of cancellous bone they are below the law's minimum of
  // 100 HU.
  fs::create_directories(folder_);
  BlockParams block;
  block.size_mm = {8, 2, 6};
  block.voxel_mm = 0.2;
  block.layers = {{1, 24}, {5, 32}};
  Bone bone = MakeBlock(block, DefaultMandibleTable());
  SetHu(
      bone, [](const Vec3& p) { return p.z < -4.8 ? 50 : 1000; }, 0.25);
  WriteBone(bone, folder_ + "/hu.vdb");
  WriteTextFile(folder_ + "/laws.csv",
                "name,tissue,density,calibration,bands,tag,source\n"
                "linear,test,qct,0:0 3000:3,0.1 to 3: 2000 rho^1,R,made up\n");
  const Scene scene = ParseScene(
      "[bone]\nfile = \"hu.vdb\"\n[material]\nkind = \"ct\"\nct_law = \"linear\"\nct_law_file = \"laws.csv\"\n"
      "[[path.stroke]]\nstart_mm = [0, 0, 11.5]\nend_mm = [0, 0, 8]\nfeed_mm_per_s = 20.0\ndisc_normal = [0, 1, 0]\n" +
          kSlab,
      folder_ + "/scene.toml");
  const Comparison c = CompareScene(scene, {{}, 0.5, 1}, {});
  EXPECT_THAT(c.material, testing::MatchesRegex("E of cancellous regions from the CT by linear: 0.2 to 2 GPa, median 2 "
                                                "GPa; [0-9.]+ % outside its range .100 to 3000 HU."));
  MaterialSummary material;
  MakeSceneBone(scene, {}, &material);
  ASSERT_EQ(material.warnings.size(), 2u);  // fraction outside the range; unverified law
  const std::string report = FormatCompareReport(c);
  EXPECT_THAT(report, HasSubstr("- Material: " + c.material + ".\n"));
  Comparison named = c;
  named.title = "<b>a | b</b>";
  named.regions[0].name = "<i>x|y</i>";
  const std::string escaped = FormatCompareReport(named);
  EXPECT_THAT(escaped, HasSubstr("# &lt;b&gt;a \\| b&lt;/b&gt;: the same cut"));
  EXPECT_THAT(escaped, HasSubstr(" &lt;i&gt;x\\|y&lt;/i&gt; ("));
  EXPECT_THAT(escaped, testing::Not(HasSubstr("<b>")));
  EXPECT_THAT(escaped, testing::Not(HasSubstr("<i>")));
  const auto json = nlohmann::json::parse(FormatCompareJson(c));
  const std::string kept = report.substr(report.find("Caveats:"), report.find("## Force and work"));
  for (const std::string& warning : material.warnings) {
    EXPECT_THAT(c.warnings, testing::Contains(warning));
    EXPECT_THAT(kept, HasSubstr("- " + warning + "\n"));
    EXPECT_THAT(json["warnings"].get<std::vector<std::string>>(), testing::Contains(warning));
  }
  // The file also lists the accuracy of each law, including the scene's own law, which has no other warning.
  for (const CaseResult& result : c.cases) {
    if (result.what.slab) continue;
    const ForceLaw& law = result.what.law;
    EXPECT_THAT(kept, HasSubstr(fmt::format("- {}: {}; {}; {}\n", law.name(), DescribeAccuracy(law, DiscSaw{}),
                                            DescribeBlades(law, DiscSaw{}), FindCaveat(law.info()).good_for)));
  }
  EXPECT_THAT(kept, HasSubstr("- slab: one tooth alone has the force of hertz_constant_bite: thrust 1/"));
  EXPECT_EQ(json["material"], nlohmann::json(MaterialJson(scene, material)));
  EXPECT_EQ(json["material"]["law"], "linear");
  EXPECT_NEAR(json["material"]["share_below_range"].get<double>(), 1.2 / 5, 0.05);  // CT voxels of 0.25 mm in 5 mm
  EXPECT_EQ(json["material"]["valid_HU"][0], 100);
  EXPECT_THAT(report, Not(HasSubstr(folder_)));
}

TEST_F(CompareFiles, NameTheRegionTableWithoutItsFolder) {
  fs::create_directories(folder_);
  fs::copy_file(std::string(KERF_SOURCE_DIR) + "/volumes/mandible_regions.csv", folder_ + "/own.csv");
  std::string text = kScene + kSlab;
  text.replace(text.find("model = \"block\""), 0, "materials = \"own.csv\"\n");
  const Comparison c = CompareScene(ParseScene(text, folder_ + "/scene.toml"), {{}, 0.5, 1}, {});
  EXPECT_EQ(c.material, "E by region, from own.csv");
  EXPECT_EQ(nlohmann::json::parse(FormatCompareJson(c))["material"]["source"], "own.csv");
}

TEST_F(CompareFiles, NeverReplaceAnInput) {
  Scene scene = Parse(kSlab);
  scene.path.file = folder_ + "/compare.csv";
  EXPECT_THAT(test::MessageOf([&] { CheckCompareInputsNotOverwritten(scene, "scene.toml", folder_); }),
              HasSubstr("compare.csv: is an input and would be overwritten by " + folder_ + "/compare.csv"));
  scene.path.file = folder_ + "/path.csv";
  scene.material.ct_law_file = folder_ + "/report.md";
  EXPECT_THROW(CheckCompareInputsNotOverwritten(scene, "scene.toml", folder_), Error);
  scene.material.ct_law_file = folder_ + "/laws.csv";
  EXPECT_NO_THROW(CheckCompareInputsNotOverwritten(scene, "scene.toml", folder_));
}

TEST_F(CompareFiles, BothDepthFiguresHaveTheSameRange) {
  test::MadeUpCase a, b;
  a.force_N = b.force_N = [](double) { return 1.0; };
  const Comparison c = test::MakeUp({a, b});
  for (const PlotSpec& plot : {MakeForceDepthPlot(c), MakeDifferencePlot(c)}) {
    ASSERT_TRUE(plot.x.lower && plot.x.upper) << plot.title;
    EXPECT_EQ(*plot.x.lower, 0) << plot.title;
    EXPECT_NEAR(*plot.x.upper, 12, 1e-9) << plot.title;
  }
}

TEST_F(CompareFiles, ForcesFarApartAreDrawnLogarithmically) {
  test::MadeUpCase a, b;
  a.label = "a";
  b.label = "b";
  a.force_N = [](double) { return 1.0; };
  b.force_N = [](double) { return 5.0; };
  EXPECT_FALSE(MakeForceDepthPlot(test::MakeUp({a, b})).y.log);
  b.force_N = [](double) { return 50.0; };
  const PlotSpec plot = MakeForceDepthPlot(test::MakeUp({a, b}));
  EXPECT_TRUE(plot.y.log);
  EXPECT_LT(*plot.y.lower, 1);
  EXPECT_GT(*plot.y.upper, 50);
  // The bands are the regions: 0 to 4 mm and 4 to 10 mm.
  ASSERT_EQ(plot.bands.size(), 2u);
  EXPECT_NEAR(plot.bands[0].x1, 4, 1e-9);
  EXPECT_NEAR(plot.bands[1].x1, 10, 1e-9);
  EXPECT_EQ(plot.bands[1].label, "32 lower");
}

}  // namespace
}  // namespace kerf
