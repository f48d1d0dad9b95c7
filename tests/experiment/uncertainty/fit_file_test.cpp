// Tests of the intervals of a fit: what is taken from calibrate.json, and the band that they give.
#include "experiment/uncertainty/fit_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "../calibration/made_up_forces.h"
#include "experiment/calibration/calibration_files.h"
#include "experiment/uncertainty/band.h"
#include "experiment/uncertainty/uncertain.h"
#include "session/run/make_bone.h"
#include "support/block_scene.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

constexpr double kEdgeRadius_um = 8;
const std::string kFitPlunge = test::MakeBlockScene({6.2, 5.2, 20});

Scene ParseWithForce(const std::string& force) {
  return ParseScene(kFitPlunge + "[material]\nkind = \"uniform\"\n" + force, "scene.toml");
}

/// Returns a fit of edge_plus_chip in which only the edge term was fitted, to `value`.
std::string MakeFitText(double value, double lower, double upper, const std::string& bootstrap = "null",
                        const std::string& of = "rows") {
  return fmt::format(
      R"({{"schema": 1, "law": "edge_plus_chip", "bootstrap": {{"of": "{}"}}, "parameters": [
        {{"key": "edge_N_per_mm", "state": "fitted", "value": {}, "interval": [{}, {}], "bootstrap_interval": {}}},
        {{"key": "chip_N_per_mm2", "state": "kept", "value": 0, "interval": null, "bootstrap_interval": null}}]}})",
      of, value, lower, upper, bootstrap);
}

const std::string kFittedEdge = "[force]\nlaw = \"edge_plus_chip\"\nedge_N_per_mm = 9\nchip_N_per_mm2 = 0\n";

TEST(FitFile, BandOfALinearLawIsAsWideAsTheIntervalOfItsCoefficient) {
  // Without the chip term the force is proportional to the edge term, which is uniform from 7 to 11 N/mm about 9.
  constexpr int kSamples = 100;
  const Scene scene = ParseWithForce(kFittedEdge);
  UncertainParams params{.samples = kSamples, .seed = 5, .jobs = 0};
  params.fit = ParseFit(MakeFitText(9, 7, 11), "calibrate.json", scene.force, kEdgeRadius_um);
  const UncertainRun run = RunUncertain(scene, params, std::nullopt, nullptr);
  ASSERT_EQ(run.head.drawing.drawn.size(), 1u);
  EXPECT_EQ(run.head.drawing.drawn[0].name, "edge_N_per_mm");
  EXPECT_EQ(run.head.drawing.drawn[0].nominal, 9);
  const double nominal_N = run.head.nominal.mean_N;
  ASSERT_GT(nominal_N, 0.1);
  for (const UncertainSample& s : run.samples) {
    EXPECT_NEAR(s.mean_N, nominal_N * (7 + 4 * s.fractions[0]) / 9, 1e-9 * nominal_N);  // rounding of a sum of ticks
  }
  // Each percentile is that of the uniform distribution to within four standard deviations of its rank.
  const Spread mean = CalcUncertainResult(run).mean_N;
  EXPECT_LT(mean.p5, nominal_N);
  EXPECT_GT(mean.p95, nominal_N);
  const double scatter = 4 * std::sqrt(2 * 0.05 * 0.95 / kSamples) + 2.0 / kSamples;
  EXPECT_NEAR((mean.p95 - mean.p5) / nominal_N, 0.9 * 4 / 9, scatter * 4 / 9);
}

TEST(FitFile, BootstrapOverSpecimensIsPreferredAndEndsAreWithinTheRange) {
  const ForceLaw law = ParseWithForce(kFittedEdge).force;
  const auto interval = [&](const std::string& of) {
    const auto fit = ParseFit(MakeFitText(9, -2, 11, "[8, 10]", of), "calibrate.json", law, kEdgeRadius_um);
    return std::pair(fit.at(0).lower, fit.at(0).upper);
  };
  EXPECT_EQ(interval("specimens"), std::pair(8.0, 10.0));
  EXPECT_EQ(interval("rows"), std::pair(0.0, 11.0));  // the scene's key begins at 0
}

TEST(FitFile, FilesOfKerfCalibrateAreDrawnFromTheirIntervals) {
  const LinearLaw linear = MakeLinearLaw("two_component");
  std::mt19937_64 random(3);
  const Measurements data = test::MakeUpForces(linear, test::kTrueCoefficients, 6, 0.2, false, random);
  const Calibration c = CalibrateLaw(linear, data, {.bootstrap = 0}, "forces.csv");
  const Scene scene = ParseWithForce(FormatLawBlock(c));
  const auto fit = ParseFit(FormatCalibrationJson(c), "calibrate.json", scene.force, kEdgeRadius_um);
  const Drawing drawing = FindDrawing(scene, MakeSceneBone(scene, nullptr), {}, fit);
  ASSERT_GE(drawing.drawn.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(drawing.drawn[i].name, c.parameters[i].key);
    EXPECT_EQ(drawing.drawn[i].lower, std::max(0.0, c.parameters[i].interval->lower));
    EXPECT_EQ(drawing.drawn[i].upper, c.parameters[i].interval->upper);
    EXPECT_EQ(drawing.drawn[i].basis, "95 % interval of the fit, t distribution");
    EXPECT_LE(drawing.drawn[i].lower, *drawing.drawn[i].nominal);
    EXPECT_GE(drawing.drawn[i].upper, *drawing.drawn[i].nominal);
  }
  // Without the fit, values that differ from the defaults are not drawn.
  const Drawing alone = FindDrawing(scene, MakeSceneBone(scene, nullptr), {});
  EXPECT_EQ(alone.drawn.size() + 4, drawing.drawn.size());
}

TEST(FitFile, AFitOfOtherValuesIsRefused) {
  const ForceLaw law = ParseWithForce(kFittedEdge).force;
  const auto message = [](const std::string& text, const ForceLaw& of) {
    return test::MessageOf([&] { ParseFit(text, "calibrate.json", of, kEdgeRadius_um); });
  };
  EXPECT_EQ(
      message(MakeFitText(9.01, 7, 11), law),
      "calibrate.json: cannot be used as the fit: its edge_N_per_mm is 9.01, and the scene has 9; use the [force] "
      "of law.toml");
  EXPECT_THAT(message(MakeFitText(9, 7, 11), ForceLaw("two_component")),
              HasSubstr("it is a fit of the law edge_plus_chip, and the scene has two_component"));
  EXPECT_THAT(message("{}", law), HasSubstr("is not a calibrate.json of 'kerf calibrate', or is damaged"));
  EXPECT_THAT(message("edge", law), HasSubstr("calibrate.json"));
  EXPECT_THAT(message(MakeFitText(9, 11, 7), law), HasSubstr("[11,7] is not an interval about edge_N_per_mm = 9"));
  EXPECT_THAT(message(MakeFitText(9, 7, 11, "[7, 8, 9]", "specimens"), law), HasSubstr("is not an interval"));
  EXPECT_THAT(message(MakeFitText(9, 10, 11), law), HasSubstr("[10,11] is not an interval about edge_N_per_mm = 9"));
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = MakeFitText(9, 7, 11);
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(message(changed("[7, 11]", "null"), law), HasSubstr("edge_N_per_mm has no interval"));
  EXPECT_THAT(message(changed("\"fitted\"", "\"sure\""), law), HasSubstr("has the unknown state sure"));
  std::string twice = changed("\"chip_N_per_mm2\", \"state\": \"kept\", \"value\": 0",
                              "\"edge_N_per_mm\", \"state\": \"fitted\", \"value\": 9");
  EXPECT_THAT(message(twice, law), HasSubstr("edge_N_per_mm is listed twice"));
  EXPECT_THAT(message(changed("\"fitted\"", "\"kept\""), law), HasSubstr("it has no fitted parameter"));
  const auto of_an_edge = [&](double edge_um) {
    return changed("\"chip_N_per_mm2\", \"state\": \"kept\", \"value\": 0",
                   fmt::format("\"edge_radius_um\", \"state\": \"kept\", \"value\": {}", edge_um));
  };
  EXPECT_THAT(message(of_an_edge(20), law),
              HasSubstr("its edge_radius_um is 20, and the scene has 8; use a tool with that edge"));
  EXPECT_EQ(message(of_an_edge(kEdgeRadius_um), law), "");
}

}  // namespace
}  // namespace kerf
