// Tests of the plots of a run: what they say about curves whose values are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cut/effects/tooth_vibration.h"
#include "cut/path_sim/internals.h"
#include "session/run/make_bone.h"
#include "session/run/run_pictures.h"
#include "session/run/spectrum_picture.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A plunge of 5 mm in steps of 0.001 mm, with a force of `mean_N` that changes by `ripple_N` up and down in 4 ticks.
std::vector<TickRecord> MakePlunge(double mean_N, double ripple_N) {
  std::vector<TickRecord> ticks(5000);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double ripple[] = {0, ripple_N, 0, -ripple_N};
    ticks[i].travel_mm = 1e-3 * static_cast<double>(i);
    ticks[i].touched = true;
    ticks[i].out.f_T_W_N = Vec3(0, 0, mean_N + ripple[i % 4]);
    ticks[i].out.engaged_teeth = 4;
  }
  return ticks;
}

TEST(ForcePlot, ShowsMeanAndRangeOfAFastRipple) {
  const PlotSpec plot = MakeForcePlot(MakePlunge(8, 1), {}, "plunge", OscillatingBlade{});
  ASSERT_EQ(plot.series.size(), 3U);
  const PlotSeries &range = plot.series[0], &force = plot.series[1], &teeth = plot.series[2];
  EXPECT_THAT(range.label, HasSubstr("lowest to highest force in each 0.01 mm"));
  EXPECT_EQ(force.label, "force, mean");
  EXPECT_EQ(*std::min_element(range.y.begin(), range.y.end()), 7);
  EXPECT_EQ(*std::max_element(range.y.begin(), range.y.end()), 9);
  EXPECT_LT(force.y.size(), 520U);
  for (const double y : force.y) EXPECT_NEAR(y, 8, 0.21);  // ten ticks are two and a half periods
  EXPECT_EQ(teeth.label, "engaged teeth");
  EXPECT_EQ(teeth.y.front(), 4);
  EXPECT_GT(*plot.y_right.upper, 1.5 * 4) << "below the curve of the force";
}

TEST(ForcePlot, ShowsEachTickOfASmoothForce) {
  const PlotSpec plot = MakeForcePlot(MakePlunge(8, 0), {}, "plunge", DiscSaw{});
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_EQ(plot.series[0].label, "force");
  EXPECT_EQ(plot.series[0].y.size(), 5000U);
}

TEST(ForcePlot, ShowsTheLengthOfLipsInMillimetres) {
  const PlotSpec plot = MakeForcePlot(MakePlunge(8, 0), {}, "hole", TwistDrill{});
  EXPECT_EQ(plot.y_right.label, "engaged length of the lips (mm)");
  EXPECT_DOUBLE_EQ(plot.series[1].y.front(), 4 * CalcTooth(TwistDrill{}).width_mm);
}

TEST(SpectrumPlot, NamesOnlyTheLinesThatTheToolHas) {
  SpectrumTrack::Spectrum spectrum;
  spectrum.seconds = 1;
  spectrum.spindle_Hz = 17;
  spectrum.teeth = 2;
  spectrum.carried_Hz = 400;
  spectrum.mN.assign(512, 0.01);
  spectrum.mN[17] = 3926;
  spectrum.mN[34] = 100;
  const PlotSpec plot = MakeSpectrumPlot(spectrum, "hole");
  ASSERT_FALSE(plot.notes.empty());
  EXPECT_EQ(plot.notes[0].text, "n / 60, runout\n17 Hz: 3926 mN");
  for (const PlotNote& note : plot.notes) EXPECT_THAT(note.text, Not(HasSubstr(", set")));
  EXPECT_THAT(plot.caption, HasSubstr("before the limit max_N"));
}

/// Ticks of 1 ms of a scene's path with tooth vibration, and the spectrum of those after `from`.
struct VibratingCut {
  VibratingCut(const Scene& scene, int from, int ticks)
      : path(MakePath(scene)),
        simulation(MakeSceneBone(scene, {}), MakeSimulationParams(scene), path.CalcPose(0, 0)),
        track(plan()) {
    for (int i = 1; i <= ticks; ++i) {
      simulation.Tick({path.CalcPose(0, 0.001 * i), 0.001, scene.tool.rpm});
      if (i > from) track.Take(0.001);
    }
  }
  const EffectPlan& plan() const { return EffectsOf(simulation); }
  const ToothVibrationEffect& effect() const {
    return dynamic_cast<const ToothVibrationEffect&>(*plan().Find("tooth_vibration"));
  }

  Path path;
  Simulation simulation;
  SpectrumTrack track;
};

TEST(SpectrumTrack, HasTheLinesOfTheEffect) {
  // The disc moves along at a constant depth, so the lines have constant amplitudes, which appear in their bins of the
  // spectrum.
  const Scene scene = ParseScene(R"(
[bone]
model = "block"
[bone.block]
size_x_mm = 40.0
size_y_mm = 4.0
size_z_mm = 6.0
voxel_mm = 0.2
[tool]
thickness_mm = 0.5
[[path.stroke]]
start_mm = [-8.0, 0.0, 9.0]
end_mm = [8.0, 0.0, 9.0]
feed_mm_per_s = 8.0
disc_normal = [0.0, 1.0, 0.0]
[effects.tooth_vibration]
)",
                                 "scene.toml");
  const VibratingCut cut(scene, 900, 2000);
  const SpectrumTrack::Spectrum spectrum = cut.track.CalcSpectrum();
  ASSERT_EQ(spectrum.seconds, 1);
  EXPECT_EQ(spectrum.teeth, 24);
  EXPECT_NEAR(spectrum.spindle_Hz, 125, 1e-3);
  EXPECT_NEAR(spectrum.carried_Hz, 400, 1e-4);  // times are stored as floats
  // The grid's ripple along the path moves a few percent of each line to both sides.
  const auto& lines = cut.effect().lines();
  ASSERT_GT(lines[ToothVibrationEffect::kRunout].Magnitude(), 0.01);
  EXPECT_NEAR(spectrum.mN[125] / (1000 * lines[ToothVibrationEffect::kRunout].Magnitude()), 1, 0.1);
  EXPECT_NEAR(spectrum.mN[1500] / (1000 * lines[ToothVibrationEffect::kSet].Magnitude()), 1, 0.1);
  EXPECT_GT(spectrum.mN[3000], 20 * spectrum.mN[2700]);
  EXPECT_GT(spectrum.mN[3000], 20 * spectrum.mN[2000]);
}

TEST(SpectrumTrack, OfAStrokeHasThePowerOfTheEffectAtMultiplesOfItsRate) {
  // The blade plunges into a block at a constant feed, so the lines have constant amplitudes.
  const Scene scene = ParseScene(R"(
[bone]
model = "block"
[bone.block]
size_x_mm = 20.0
size_y_mm = 10.0
size_z_mm = 8.0
voxel_mm = 0.2
[tool]
shape = "oscillating"
radius_mm = 25.0
width_mm = 9.0
pitch_mm = 1.0
swing_deg = 4.0
rpm = 15000.0
[force]
law = "two_component"
[[path.stroke]]
start_mm = [0.0, 0.0, 1.0]
end_mm = [0.0, 0.0, -3.0]
feed_mm_per_s = 1.0
disc_normal = [0.0, 1.0, 0.0]
[effects.tooth_vibration]
)",
                                 "scene.toml");
  const VibratingCut cut(scene, 2500, 3600);
  const SpectrumTrack::Spectrum spectrum = cut.track.CalcSpectrum();
  ASSERT_EQ(spectrum.seconds, 1);
  EXPECT_TRUE(spectrum.strokes);
  EXPECT_NEAR(spectrum.spindle_Hz, 250, 1e-3);
  EXPECT_NEAR(spectrum.passing_Hz, 872.7, 0.1);
  double lines = 0;
  double rest = 0;
  for (std::size_t k = 1; k < spectrum.mN.size(); ++k) {
    const std::size_t away = std::min(k % 250, 250 - k % 250);
    (away <= 2 ? lines : rest) += spectrum.mN[k] * spectrum.mN[k];
  }
  ASSERT_GT(lines, 0);
  EXPECT_LT(rest, 0.05 * lines);

  // The effect's own samples over a period, without their mean.
  constexpr int kSamples = 4000;
  Vec3 sum(0);
  double squares = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec3 f = 1000.0 * cut.effect().Sample(0.004 * i / kSamples);
    sum += f;
    squares += glm::dot(f, f);
  }
  const Vec3 mean = sum / static_cast<double>(kSamples);
  const double variance = squares / kSamples - glm::dot(mean, mean);
  double power = 0;
  for (int k = 250; k < static_cast<int>(spectrum.mN.size()) - 250; k += 250) {
    power += 0.5 * spectrum.mN[static_cast<std::size_t>(k)] * spectrum.mN[static_cast<std::size_t>(k)];
  }
  EXPECT_NEAR(power / variance, 1, 0.15);

  const PlotSpec plot = MakeSpectrumPlot(spectrum, "slot");
  EXPECT_THAT(plot.caption, Not(HasSubstr("N =")));
  EXPECT_THAT(plot.caption, HasSubstr("15000 strokes a minute"));
  ASSERT_EQ(plot.lines.size(), 1U);
  EXPECT_THAT(plot.lines[0].label, HasSubstr("873 Hz"));
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_EQ(plot.series[1].point_labels.size(), 5U);
}

}  // namespace
}  // namespace kerf
