// Tests of kerf run --uncertain: what is drawn, the band, and the shards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/files/files.h"
#include "experiment/uncertainty/band.h"
#include "experiment/uncertainty/shard_file.h"
#include "experiment/uncertainty/uncertain.h"
#include "experiment/uncertainty/uncertain_files.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/run_scene.h"
#include "support/block_scene.h"
#include "support/folder.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The block consists of region 24.
const std::string kPlunge = test::MakeBlockScene({6.2, 5.2, 20});
const std::string kEdgeOnly =
    kPlunge + "[material]\nkind = \"uniform\"\n[force]\nlaw = \"edge_plus_chip\"\nchip_N_per_mm2 = 0\n";

Scene Parse(const std::string& text) {
  return ParseScene(text, "scene.toml");
}

UncertainRun RunWith(const Scene& scene, const UncertainParams& params, std::optional<Shard> shard = std::nullopt) {
  return RunUncertain(scene, params, shard, nullptr);
}

std::vector<std::string> NamesOfDrawn(const Drawing& drawing) {
  std::vector<std::string> names;
  for (const DrawnQuantity& q : drawing.drawn) names.push_back(q.name);
  return names;
}

/// A scene whose bone has the regions of a table: 1 and 2 are estimates, 3 is measured, all cortical.
Scene ParseWithTable(const test::Folder& folder, const std::string& more = "") {
  const std::string header = "id,name,tissue,E_GPa,nu,estimate,source,E_lower_GPa,E_upper_GPa\n";
  WriteTextFile(folder.file("own.csv"), header +
                                            "1,a,cortical,17,0.3,yes,s,10,30\n"
                                            "2,b,cortical,20,0.3,yes,s,16,24\n"
                                            "3,c,cortical,20,0.3,no,s,19,21\n"
                                            "24,absent from the bone,cortical,20,0.3,yes,s,19,21\n");
  std::string text = kPlunge;
  text.replace(text.find("model = \"block\""), 15,
               fmt::format("model = \"block\"\nmaterials = \"{}\"", folder.file("own.csv")));
  const std::string layers = test::LayerToml(1, 1) + test::LayerToml(1, 2) + test::LayerToml(1, 3);
  text.insert(text.find("[tool]"), layers);
  return Parse(text + more);
}

TEST(Uncertain, ThreadsAndShardsGiveTheSameBits) {
  const Scene scene = Parse(kPlunge + "[force]\nlaw = \"two_component\"\n");
  UncertainParams params{.samples = 11, .seed = 7, .jobs = 1};
  const UncertainRun one = RunWith(scene, params);
  params.jobs = 4;
  const UncertainRun four = RunWith(scene, params);
  EXPECT_EQ(one.head, four.head);
  EXPECT_EQ(one.samples, four.samples);
  ASSERT_EQ(one.samples.size(), 11u);
  EXPECT_NE(one.samples[0].mean_N, one.samples[1].mean_N);

  const test::Folder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string in = FolderOfShard(folder.path(), {i, 3});
    MakeFolder(in);
    WriteTextFile(in + "/" + kSamplesFile, FormatSamples(RunWith(scene, params, Shard{i, 3}), Shard{i, 3}));
  }
  const MergedRun merged = MergeSamples(folder.path(), scene, params);
  EXPECT_EQ(merged.files, 3u);
  EXPECT_EQ(merged.twice, 0u);
  EXPECT_TRUE(merged.missing.empty());
  EXPECT_EQ(merged.run.head, one.head);
  EXPECT_EQ(merged.run.samples, one.samples);
  const UncertainResult a = CalcUncertainResult(one);
  const UncertainResult b = CalcUncertainResult(merged.run);
  EXPECT_EQ(FormatBandCsv(a), FormatBandCsv(b));
  EXPECT_EQ(FormatUncertainJson(one, a), FormatUncertainJson(merged.run, b));

  params.seed = 8;
  EXPECT_NE(RunWith(scene, params).samples[0].fractions, one.samples[0].fractions);
}

TEST(Uncertain, MergeNamesWhatIsMissingAndRefusesWhatContradicts) {
  const Scene scene = Parse(kEdgeOnly);
  const UncertainParams params{.samples = 5, .seed = 1, .jobs = 1};
  const test::Folder folder;
  const auto message = [&](const Scene& of, const UncertainParams& with) {
    return test::MessageOf([&] { MergeSamples(folder.path(), of, with); });
  };
  EXPECT_THAT(message(scene, params), HasSubstr("contains no shards; make them with --shard"));
  const auto write = [&](const char* in, const std::string& text) {
    MakeFolder(folder.file(in));
    WriteTextFile(folder.file(in) + "/" + kSamplesFile, text);
  };
  const UncertainRun first = RunWith(scene, params, Shard{0, 2});
  write("shard-0-of-2", FormatSamples(first, Shard{0, 2}));
  const MergedRun half = MergeSamples(folder.path(), scene, params);
  EXPECT_THAT(half.missing, ElementsAre(1, 3));
  EXPECT_THAT(DescribeMissing(half, folder.path()), HasSubstr("2 of 5 samples are missing: those of shard 1/2"));

  EXPECT_THAT(message(Parse(kEdgeOnly + "edge_N_per_mm = 9\n"), params), HasSubstr("belongs to another scene"));
  UncertainParams other = params;
  other.seed = 2;
  EXPECT_THAT(message(scene, other), HasSubstr("was made with --uncertain 5 --seed 1, not with 5 and 2"));

  write("shard-1-of-2", FormatSamples(first, Shard{1, 2}));
  EXPECT_EQ(MergeSamples(folder.path(), scene, params).twice, 3u);
  UncertainRun changed = first;
  changed.samples[1].force_N[0] += 1;
  write("shard-1-of-2", FormatSamples(changed, Shard{1, 2}));
  EXPECT_THAT(message(scene, params), HasSubstr("differ in sample 2"));
  changed = first;
  changed.head.bone_hash += 1;
  write("shard-1-of-2", FormatSamples(changed, Shard{1, 2}));
  EXPECT_THAT(message(scene, params), HasSubstr("differ in the bone, the intervals or the nominal run"));
  write("shard-1-of-2", "{}");
  EXPECT_THAT(message(scene, params), HasSubstr("is not a shard of 'kerf run --uncertain'"));
}

TEST(Uncertain, ForceThatIsLinearInOneDrawnParameterHasThePercentilesOfTheUniformDistribution) {
  // Without the chip term the force is proportional to the edge term, which is uniform from 9.28 to 10.05 N/mm.
  constexpr int kSamples = 200;
  const Scene scene = Parse(kEdgeOnly);
  const UncertainRun run = RunWith(scene, {.samples = kSamples, .seed = 3, .jobs = 0});
  EXPECT_THAT(NamesOfDrawn(run.head.drawing), ElementsAre("edge_N_per_mm"));
  const double lower = 9.28;
  const double upper = 10.05;
  const UncertainSample& nominal = run.head.nominal;  // at 9.28
  ASSERT_GT(nominal.mean_N, 0.1);
  for (const UncertainSample& s : run.samples) {
    const double ratio = (lower + s.fractions[0] * (upper - lower)) / lower;
    ASSERT_NEAR(s.mean_N, nominal.mean_N * ratio, 1e-9 * nominal.mean_N);  // rounding of sums over 50 ticks
    ASSERT_NEAR(*s.cutting_J, *nominal.cutting_J * ratio, 1e-9 * *nominal.cutting_J);
  }
  const UncertainResult result = CalcUncertainResult(run);
  // The number of samples at or below the true percentile p is binomial, so the fraction of the interval at which the
  // sample's percentile lies has a standard deviation of sqrt(p (1 - p) / n). Four of them are exceeded once in 16000
  // seeds. The nearest rank adds at most 1 / n.
  const auto check = [&](const Spread& spread) {
    for (const auto& [p, value] : {std::pair(0.05, spread.p5), {0.5, spread.p50}, {0.95, spread.p95}}) {
      const double fraction = (value / spread.nominal * lower - lower) / (upper - lower);
      EXPECT_NEAR(fraction, p, 4 * std::sqrt(p * (1 - p) / kSamples) + 1.0 / kSamples);
    }
  };
  check(result.mean_N);
  check(result.peak_N);
  check(result.work_mJ);
  int in_bone = 0;
  for (const BandRow& row : result.rows) {
    if (row.force_N.nominal < 1e-6) continue;
    check(row.force_N);
    check(row.thrust_N);
    ++in_bone;
  }
  EXPECT_GT(in_bone, 10);
  ASSERT_TRUE(result.rank_correlations[0].has_value());
  EXPECT_NEAR(*result.rank_correlations[0], 1, 1e-9);
}

TEST(Uncertain, ForcesOfHertzFollowTheReducedModulus) {
  const Scene scene = Parse(kPlunge + "[force]\nlaw = \"hertz_chip\"\n");
  const UncertainRun run = RunWith(scene, {.samples = 20, .seed = 3, .jobs = 0});
  EXPECT_THAT(NamesOfDrawn(run.head.drawing), ElementsAre("E_GPa of region 24"));
  const auto modulus = [](double E_MPa) { return CalcReducedModulus(205e3, 0.28, E_MPa, 0.28); };
  const UncertainSample& nominal = run.head.nominal;
  ASSERT_GT(nominal.mean_N, 0.1);
  for (const UncertainSample& s : run.samples) {
    const double ratio = modulus(10e3 + s.fractions[0] * 20e3) / modulus(19.3e3);
    ASSERT_NEAR(s.mean_N, nominal.mean_N * ratio, 1e-9 * nominal.mean_N);  // rounding of sums over 50 ticks
  }
}

TEST(Uncertain, NominalRunEqualsKerfRun) {
  const test::Folder folder;
  const Scene scene = Parse(kPlunge + "[force]\nlaw = \"two_component\"\n[effects.tangential_force]\n");
  const RunSummary summary = RunScene(scene, folder.file("out"), {}, {}, {}, 0);
  const UncertainSample nominal = RunWith(scene, {.samples = 2, .seed = 1, .jobs = 1}).head.nominal;
  EXPECT_EQ(nominal.peak_N, summary.force.peak_N);
  EXPECT_EQ(nominal.mean_N, summary.force.mean_N);
  EXPECT_EQ(nominal.work_mJ, summary.force.work_Nmm);
  EXPECT_EQ(nominal.cutting_J, summary.cutting.work_J);
  ASSERT_TRUE(nominal.cutting_J.has_value());
  EXPECT_GT(*nominal.cutting_J, 0);
}

TEST(Uncertain, RowsAreMeansOverConsecutiveTicksOfAStroke) {
  const std::string path = test::StrokeToml({0, 0, 6.2}, {0, 0, 5.7}, 20, {1, 0, 0}) +
                           test::StrokeToml({1, 0, 6.2}, {1, 0, 5.7}, 20, {1, 0, 0});
  const std::string text = test::BlockToml({6, 4, 3}, 0.25) + test::SawToml(12, 0.5, 16) + path +
                           "[force]\nlaw = \"edge_plus_chip\"\n[output]\npictures = false\n";
  const Scene every = Parse(text);
  Scene fourth = every;
  fourth.output.forces_every_ticks = 4;
  const UncertainParams params{.samples = 2, .seed = 1, .jobs = 1};
  const UncertainRun a = RunWith(every, params);
  const UncertainRun b = RunWith(fourth, params);
  ASSERT_EQ(a.head.rows.time_s.size(), 50u);  // two strokes of 0.5 mm at 20 mm/s and 1000 Hz
  ASSERT_EQ(b.head.rows.time_s.size(), 14u);  // each of 25 ticks: six rows of four and one of the rest
  EXPECT_EQ(b.head.rows.segment[6], 0u);
  EXPECT_EQ(b.head.rows.segment[7], 1u);
  EXPECT_EQ(b.head.rows.time_s[6], a.head.rows.time_s[24]);
  const std::vector<double>& f = a.samples[1].force_N;
  EXPECT_NEAR(b.samples[1].force_N[5], (f[20] + f[21] + f[22] + f[23]) / 4, 1e-12 * f[23]);
  EXPECT_GT(f[23], 0);
  EXPECT_EQ(b.samples[1].force_N[6], f[24]);
}

TEST(Uncertain, ParameterThatTheSceneSetsIsNotDrawn) {
  const auto drawing = [](const std::string& force) {
    const Scene scene = Parse(kPlunge + "[force]\nlaw = \"edge_plus_chip\"\n" + force);
    MaterialSummary material;
    const Bone bone = MakeSceneBone(scene, nullptr, &material);
    return FindDrawing(scene, bone, material.ct_regions);
  };
  EXPECT_THAT(NamesOfDrawn(drawing("")), ElementsAre("edge_N_per_mm", "chip_N_per_mm2", "E_GPa of region 24"));
  EXPECT_TRUE(drawing("").fixed.empty());
  // Also if the value lies within the interval.
  const Drawing set = drawing("edge_N_per_mm = 9.5\n");
  EXPECT_THAT(NamesOfDrawn(set), ElementsAre("chip_N_per_mm2", "E_GPa of region 24"));
  ASSERT_EQ(set.fixed.size(), 1u);
  EXPECT_EQ(set.fixed[0].name, "edge_N_per_mm");
  EXPECT_EQ(set.fixed[0].why, "the scene sets 9.5; the default is 9.28");
  // The draws of the other parameter stay the same.
  EXPECT_EQ(DrawFractions(drawing(""), 1, 5)[1], DrawFractions(set, 1, 5)[0]);
}

TEST(Uncertain, QuantityWithoutEffectIsNotDrawn) {
  const test::Folder folder;
  const auto drawing = [&](const std::string& more) {
    const Scene scene = ParseWithTable(folder, "[force]\nlaw = \"two_component\"\n" + more);
    return FindDrawing(scene, MakeSceneBone(scene, nullptr), {});
  };
  // All regions are cortical, the osteons are unknown, and the law does not read E.
  const std::vector<std::string> five{"thrust_edge_N_per_mm", "thrust_chip_N_per_mm2", "cutting_edge_N_per_mm",
                                      "cutting_chip_N_per_mm2", "crossover_share"};
  const Drawing isotropic = drawing("");
  EXPECT_EQ(NamesOfDrawn(isotropic), five);
  ASSERT_EQ(isotropic.fixed.size(), 2u);
  EXPECT_EQ(isotropic.fixed[0].name,
            "cancellous_factor, tooth_factor, canal_factor, other_factor, osteon_along_factor, osteon_into_factor, "
            "osteon_across_factor");
  EXPECT_EQ(isotropic.fixed[1].name, "E_GPa of regions 1, 2, 3");
  EXPECT_EQ(isotropic.fixed[1].why, "the law two_component does not depend on E");
  const Drawing with_direction = drawing("[material]\nosteon_direction = [0.0, 0.0, 1.0]\n");
  EXPECT_EQ(with_direction.drawn.size(), 8u);
  EXPECT_EQ(with_direction.drawn[5].name, "osteon_along_factor");
}

TEST(Uncertain, EstimatedRegionsOfOneTissueShareOneFraction) {
  const test::Folder folder;
  const Scene scene =
      ParseWithTable(folder, "[material]\nosteon_direction = [0.0, 0.0, 2.0]\n[force]\nlaw = \"hertz_chip\"\n");
  MaterialSummary material;
  const Bone bone = MakeSceneBone(scene, nullptr, &material);
  const Drawing drawing = FindDrawing(scene, bone, material.ct_regions);
  ASSERT_THAT(NamesOfDrawn(drawing), ElementsAre("E_GPa of estimated cortical regions", "E_GPa of region 3"));
  EXPECT_THAT(drawing.drawn[0].regions, ElementsAre(1, 2));
  EXPECT_EQ(drawing.drawn[0].lower, 10);
  EXPECT_EQ(drawing.drawn[0].upper, 30);
  EXPECT_FALSE(drawing.drawn[0].nominal.has_value());
  EXPECT_EQ(drawing.drawn[1].nominal, 20);
  const MaterialTable table = ApplyToMaterials(drawing, {0.25, 0.5}, bone.materials());
  EXPECT_DOUBLE_EQ(table.At(1).E_MPa, 15000);
  EXPECT_DOUBLE_EQ(table.At(2).E_MPa, 18000);
  EXPECT_DOUBLE_EQ(table.At(3).E_MPa, 20000);
  EXPECT_EQ(table.At(24).E_MPa, 20000);
  EXPECT_EQ(table.At(1).nu, 0.3);
  ASSERT_TRUE(table.osteon_direction().has_value());
  EXPECT_EQ(table.osteon_direction()->z, 1);

  // A law proportional to E*: the force of each sample lies between those of the ends.
  const UncertainRun run = RunWith(scene, {.samples = 20, .seed = 1, .jobs = 0});
  EXPECT_NE(run.samples[0].mean_N, run.samples[1].mean_N);
  const UncertainResult result = CalcUncertainResult(run);
  EXPECT_GT(result.rank_correlations[0].value(), 0.9);  // the plunge ends in the first layer
}

TEST(Uncertain, FactorOfCancellousBoneIsDrawnFromItsRatioToCorticalBone) {
  // The block is cancellous and all other parameters are set, so that the force is proportional to the factor.
  const Scene scene = Parse(test::MakeBlockScene({6.2, 5.2, 20}, test::LayerToml(20, 32)) +
                            "[force]\nlaw = \"two_component\"\nthrust_edge_N_per_mm = 9\nthrust_chip_N_per_mm2 = "
                            "400\ncutting_edge_N_per_mm = 6\ncutting_chip_N_per_mm2 = 100\ncrossover_share = 0.2\n");
  const UncertainRun run = RunWith(scene, {.samples = 10, .seed = 3, .jobs = 0});
  ASSERT_THAT(NamesOfDrawn(run.head.drawing), ElementsAre("cancellous_factor"));
  const double lower = 1.0 / 50;  // cortical bone has 2.3 to 50 times the force
  const double upper = 1 / 2.3;
  ASSERT_GT(run.head.nominal.mean_N, 0.1);
  for (const UncertainSample& s : run.samples) {
    const double factor = lower + s.fractions[0] * (upper - lower);
    EXPECT_NEAR(s.mean_N, run.head.nominal.mean_N * factor / 0.25, 1e-9 * run.head.nominal.mean_N);  // sum of ticks
  }
}

TEST(Uncertain, UniformMaterialIsNotDrawn) {
  const test::Folder folder;
  const Scene scene = ParseWithTable(folder, "[material]\nkind = \"uniform\"\n[force]\nlaw = \"hertz_chip\"\n");
  EXPECT_THAT(test::MessageOf([&] { RunWith(scene, {}); }),
              testing::AllOf(HasSubstr("nothing to draw"), HasSubstr("one E for the whole bone")));
}

TEST(Uncertain, SaysWhatItCannotDo) {
  const Scene slab = Parse(kPlunge + "[simulation]\nmode = \"slab\"\n[slab]\ndirection = [0, 0, -1]\n");
  EXPECT_THAT(test::MessageOf([&] { RunWith(slab, {}); }), HasSubstr("--uncertain works in voxel mode only"));
}

TEST(Uncertain, FractionsAreUniformAndIndependent) {
  // Kolmogorov and Smirnov: the largest distance from the uniform distribution exceeds 1.95 / sqrt(n) once in a
  // thousand samples. Correlations of independent numbers have a standard deviation of 1 / sqrt(n).
  constexpr int kCount = 20000;
  std::vector<double> a;
  std::vector<double> b;
  std::vector<double> other_seed;
  for (int i = 0; i < kCount; ++i) {
    a.push_back(DrawFraction(1, i, 0));
    b.push_back(DrawFraction(1, i, 1));
    other_seed.push_back(DrawFraction(2, i, 0));
  }
  for (const std::vector<double>* list : {&a, &b, &other_seed}) {
    std::vector<double> sorted = *list;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_GE(sorted.front(), 0);
    EXPECT_LT(sorted.back(), 1);
    double worst = 0;
    for (int i = 0; i < kCount; ++i) {
      const double at = sorted[static_cast<std::size_t>(i)];
      worst = std::max({worst, std::abs(at - (i + 1.0) / kCount), std::abs(at - double{1} * i / kCount)});
    }
    EXPECT_LT(worst, 1.95 / std::sqrt(kCount));
  }
  std::vector<double> next(a.begin() + 1, a.end());
  next.push_back(a.front());
  for (const std::vector<double>* list : {&b, &other_seed, &next}) {
    EXPECT_LT(std::abs(CalcRankCorrelation(a, *list).value()), 4 / std::sqrt(kCount));
  }
}

TEST(Band, RankCorrelationOfKnownLists) {
  // The textbook example of Spearman's coefficient: IQ against hours of television, -29/165.
  EXPECT_NEAR(
      CalcRankCorrelation({106, 100, 86, 101, 99, 103, 97, 113, 112, 110}, {7, 27, 2, 50, 28, 29, 20, 12, 6, 17})
          .value(),
      -29.0 / 165, 1e-12);
  // With ties: ranks 1, 2.5, 2.5, 4 and 1, 2, 3, 4: covariance 4.5, variances 4.5 and 5.
  EXPECT_NEAR(CalcRankCorrelation({1, 2, 2, 3}, {1, 2, 3, 4}).value(), 4.5 / std::sqrt(4.5 * 5), 1e-12);
  EXPECT_EQ(CalcRankCorrelation({1, 2, 3}, {3, 2, 1}), -1);
  EXPECT_EQ(CalcRankCorrelation({1, 2, 3}, {5, 5, 5}), std::nullopt);
  EXPECT_EQ(CalcRankCorrelation({1, 2}, {1, 2}), std::nullopt);
}

TEST(Band, SpreadIsOfTheNearestRank) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Spread spread = CalcSpread(values, 7);
  EXPECT_EQ(spread.p5, 5);
  EXPECT_EQ(spread.p50, 50);
  EXPECT_EQ(spread.p95, 95);
  EXPECT_EQ(spread.nominal, 7);
}

TEST(UncertainFiles, FigureShowsTravelOfOneStrokeAndTimeOfSeveral) {
  const Scene one = Parse(kEdgeOnly);
  const UncertainRun run = RunWith(one, {.samples = 3, .seed = 1, .jobs = 1});
  const PlotSpec plot = MakeBandPlot(run, CalcUncertainResult(run));
  EXPECT_THAT(plot.x.label, HasSubstr("travel"));
  ASSERT_EQ(plot.series.size(), 3u);
  const double widest = *std::max_element(plot.series[0].y.begin(), plot.series[0].y.end());
  const double median = *std::max_element(plot.series[1].y.begin(), plot.series[1].y.end());
  EXPECT_GT(widest, median);
  EXPECT_DOUBLE_EQ(plot.series[0].x.back(), plot.series[1].x.back());

  const Scene two = Parse(kEdgeOnly + test::StrokeToml({1, 0, 6.2}, {1, 0, 5.7}, 20, {1, 0, 0}));
  const UncertainRun again = RunWith(two, {.samples = 2, .seed = 1, .jobs = 1});
  EXPECT_THAT(MakeBandPlot(again, CalcUncertainResult(again)).x.label, HasSubstr("time (s)"));
}

TEST(UncertainFiles, AreWrittenAndTheirInputsAreKept) {
  const test::Folder folder;
  const Scene scene = Parse(kEdgeOnly);
  const UncertainRun run = RunWith(scene, {.samples = 3, .seed = 1, .jobs = 1});
  const UncertainResult result = CalcUncertainResult(run);
  EXPECT_THAT(WriteUncertain(run, result, folder.path(), false),
              ElementsAre("band.csv", "report.md", "uncertain.json"));
  const std::string csv = ReadTextFile(folder.file("band.csv"));
  EXPECT_TRUE(
      csv.starts_with("time_s,segment,travel_mm,force_p5_N,force_p50_N,force_p95_N,force_nominal_N,thrust_p5_N,"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), result.rows.size() + 1);
  const std::string report = ReadTextFile(folder.file("report.md"));
  EXPECT_THAT(report, HasSubstr("`chip_N_per_mm2`: the scene sets 0; the default is 530"));
  EXPECT_THAT(DescribeUncertain(run, result), HasSubstr("not drawn chip_N_per_mm2: the scene sets 0"));
  EXPECT_THROW(CheckUncertainInputsNotOverwritten({folder.file("band.csv")}, folder.path()), Error);
}

}  // namespace
}  // namespace kerf
