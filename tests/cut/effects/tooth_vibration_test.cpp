// Tooth vibration: the lines of its spectrum have the frequencies and amplitudes that single teeth produce, and no line
// beats with the tick rate.
#include "cut/effects/tooth_vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/solids.h"

namespace kerf {
namespace {

using Complex = std::complex<double>;

const Pose kToothVibrationAcross{Quat(std::sqrt(0.5), 0, std::sqrt(0.5), 0), Vec3(0)};  // spindle along x

/// Returns the amplitude of a real signal's line, computed over whole periods.
double LineOf(const std::vector<double>& x, double dt_s, double hz) {
  Complex sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    sum += x[i] * std::polar(1.0, -2 * std::numbers::pi * hz * static_cast<double>(i) * dt_s);
  return 2 * std::abs(sum) / static_cast<double>(x.size());
}

/// A disc that moves down into a block at 2 mm/s, 4.8 mm deep, with the vibration on; after GoAlong(), along the block
/// at that depth.
class Cut {
 public:
  explicit Cut(double rpm, double runout_um, double set_share, int teeth = 24, double smoothing_ms = 5, int samples = 8,
               double h = 0.4)
      : rpm_(rpm),
        simulation_(test::MakeBox(Pose{}, {8, 30, 16}, h), Params(runout_um, set_share, teeth, smoothing_ms, samples),
                    At(start_mm_)),
        plain_(test::MakeBox(Pose{}, {8, 30, 16}, h), Params(-1, 0, teeth, 0, samples), At(start_mm_)) {
    for (int i = 0; i < 2500; ++i) Tick();
  }
  static SimulationParams Params(double runout_um, double set_share, int teeth, double smoothing_ms, int samples) {
    SimulationParams params;
    params.law = ForceLaw("hertz_chip");
    params.rim_samples_per_pitch = samples;
    DiscSaw saw;
    saw.teeth = teeth;
    saw.thickness_mm = 1;
    params.tool = saw;
    if (runout_um < 0) return params;
    SetEffect(params.effects, "tooth_vibration", "runout_um", runout_um);
    SetEffect(params.effects, "tooth_vibration", "set_share", set_share);
    SetEffect(params.effects, "tooth_vibration", "smoothing_ms", smoothing_ms);
    SetEffect(params.effects, "tooth_vibration", "max_N", 100);
    return params;
  }
  static Pose At(double z, double y = 0) {
    Pose X = kToothVibrationAcross;
    X.p_AB = {0, y, z};
    return X;
  }
  void GoAlong() {
    along_ = true;
    for (int i = 0; i < 200; ++i) Tick();
  }
  /// Force added by the vibration, in the tool frame.
  Vec3 Tick() {
    (along_ ? y_ : z_) -= 0.002;
    const TickOutput with = simulation_.Tick({At(z_, y_), 0.001, rpm_});
    last_ = plain_.Tick({At(z_, y_), 0.001, rpm_});
    EXPECT_EQ(with.removed_mm3, last_.removed_mm3);
    return kToothVibrationAcross.InverseVector(with.f_T_W_N - last_.f_T_W_N);
  }
  const ToothVibrationEffect& effect() {
    return dynamic_cast<const ToothVibrationEffect&>(*EffectsOf(simulation_).Find("tooth_vibration"));
  }
  const TickOutput& last() const { return last_; }

 private:
  static constexpr double start_mm_ = 8 + 11 + 0.2;
  double rpm_;
  double z_ = start_mm_, y_ = 0;
  bool along_ = false;
  Simulation simulation_, plain_;
  TickOutput last_;
};

TEST(ToothVibration, LinesAreOnlyAtMultiplesOfTheSpindleFrequency) {
  // 1500 rpm: the spindle's line is at 25 Hz and the set teeth's at 300 Hz; the 24 teeth pass at 600 Hz, which ticks of
  // 1 ms cannot represent.
  Cut cut(1500, 5, 0.2);
  cut.GoAlong();
  std::vector<double> x, y, z;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 f = cut.Tick();
    x.push_back(f.x);
    y.push_back(f.y);
    z.push_back(f.z);
  }
  const auto& lines = cut.effect().lines();
  const auto magnitude = [&](int line, int axis) {
    return std::abs(lines[static_cast<std::size_t>(line)].amplitude_N[static_cast<std::size_t>(axis)]);
  };
  ASSERT_GT(magnitude(ToothVibrationEffect::kRunout, 0), 0.01);
  // The arc is constant except for the grid's ripple, which changes a line of high order by a few percent.
  EXPECT_NEAR(LineOf(x, 0.001, 25), magnitude(ToothVibrationEffect::kRunout, 0), 0.02 * lines[0].Magnitude());
  EXPECT_NEAR(LineOf(y, 0.001, 25), magnitude(ToothVibrationEffect::kRunout, 1), 0.02 * lines[0].Magnitude());
  EXPECT_NEAR(LineOf(z, 0.001, 300), magnitude(ToothVibrationEffect::kSet, 2),
              0.1 * magnitude(ToothVibrationEffect::kSet, 2));
  double elsewhere = 0;
  for (double hz = 1; hz < 500; hz += 1) {
    if (std::abs(hz - 25) > 8 && std::abs(hz - 300) > 8) {
      elsewhere = std::max({elsewhere, LineOf(x, 0.001, hz), LineOf(y, 0.001, hz), LineOf(z, 0.001, hz)});
    }
  }
  // The ripple causes small side lines.
  EXPECT_LT(elsewhere, 0.01 * (lines[0].Magnitude() + lines[1].Magnitude()));
}

TEST(ToothVibration, NoLineAliasesWithTheTickAtAnySpeed) {
  // The tooth passing frequency is 0.8 to 8 times the tick rate. An alias would appear somewhere below 500 Hz.
  for (const double rpm : {2000.0, 2490.0, 2510.0, 4999.0, 7500.0, 9970.0, 20000.0}) {
    Cut cut(rpm, 0, 0);
    double largest = 0;
    for (int i = 0; i < 300; ++i) largest = std::max(largest, glm::length(cut.Tick()));
    EXPECT_GT(cut.effect().lines()[ToothVibrationEffect::kPassing].Magnitude(), 1e-3) << rpm;
    EXPECT_EQ(largest, 0) << rpm;
  }
}

TEST(ToothVibration, PassingLineMatchesSimulatedSingleTeeth) {
  // A brute-force saw: N single teeth at their places on the rim at each moment, each with its force from the closed
  // form of the arc: the bite is proportional to the cosine of the angle to the feed, the force to bite^1.5.
  for (const auto& [teeth, h] : {std::pair(8, 0.4), std::pair(24, 0.4), std::pair(24, 0.1)}) {
    Cut cut(3000, 0, 0, teeth, 0.1, 32, h);
    const auto& effect = cut.effect();
    // The engaged arc about the direction of feed follows from the depth of the cut. -z of the world is +x or -x of the
    // tool.
    const double depth_mm = 2500 * 0.002 - 0.2;  // depth of the rim in the block
    const double half_rad = std::acos(1 - depth_mm / 11);
    const double feed_alpha = std::atan2(kToothVibrationAcross.InverseVector({0, 0, -1}).y,
                                         kToothVibrationAcross.InverseVector({0, 0, -1}).x);
    // The largest force on a tooth follows from the mean over all teeth: thrust_sum = N / (2 pi) integral of f.
    double integral = 0;
    const int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
      const double a = -half_rad + (i + 0.5) * 2 * half_rad / kSteps;
      integral += std::pow(std::cos(a), 1.5) * 2 * half_rad / kSteps;
    }
    const double top_N = cut.last().thrust_sum_N / (teeth / (2 * std::numbers::pi) * integral);
    const double fraction = 0.625;
    std::vector<double> x, y;
    const int samples = 240 * teeth;  // per turn
    for (int i = 0; i < samples; ++i) {
      const double theta = 2 * std::numbers::pi * i / samples;
      Vec3 f(0);
      for (int k = 0; k < teeth; ++k) {
        const double alpha = theta + 2 * std::numbers::pi * k / teeth;
        const double off = std::remainder(alpha - feed_alpha, 2 * std::numbers::pi);
        if (std::abs(off) >= half_rad) continue;
        const double thrust = top_N * std::pow(std::cos(off), 1.5);
        f -= thrust * Vec3(std::cos(alpha), std::sin(alpha), 0);
        f -= fraction * thrust * Vec3(-std::sin(alpha), std::cos(alpha), 0);
      }
      x.push_back(f.x);
      y.push_back(f.y);
    }
    // Time is measured in turns instead of seconds.
    const double expected_x = LineOf(x, 1.0 / samples, teeth);
    const double expected_y = LineOf(y, 1.0 / samples, teeth);
    const auto& line = effect.lines()[ToothVibrationEffect::kPassing];
    EXPECT_EQ(line.order, teeth);
    // The grid finds the ends of the arc to a quarter of a voxel, and terms of high order depend mostly on the force
    // near them. This causes an error of 22 % of the line at 0.4 mm and 4 % at 0.1 mm.
    const double both = std::hypot(expected_x, expected_y);
    EXPECT_GT(both, 0.01);
    EXPECT_NEAR(std::abs(line.amplitude_N[0]), expected_x, (h > 0.1 ? 0.25 : 0.05) * both) << teeth;
    EXPECT_NEAR(std::abs(line.amplitude_N[1]), expected_y, (h > 0.1 ? 0.25 : 0.05) * both) << teeth;
  }
}

TEST(ToothVibration, RunoutIsProportionalToEccentricityAndTheLawsSlope) {
  // For small runout, a tooth's force changes by a fraction 1.5 / bite times 2 e sin(pi / N), which is proportional to
  // the runout e.
  Cut small(3000, 0.01, 0), twice(3000, 0.02, 0);
  const double a = small.effect().lines()[ToothVibrationEffect::kRunout].Magnitude();
  const double b = twice.effect().lines()[ToothVibrationEffect::kRunout].Magnitude();
  EXPECT_NEAR(b / a, 2, 1e-3);
  // The line is the rim's resultant weighted with e^(-i alpha); for an arc around the feed direction, it is nearly the
  // full thrust.
  const double bite_um = 1000 * 2.0 / (24 * 3000 / 60.0);
  const double relative = 1.5 * 2 * 0.01 * std::sin(std::numbers::pi / 24) / bite_um;
  EXPECT_NEAR(a, relative * small.last().thrust_sum_N * std::hypot(1, 0.625), 0.35 * a);
}

TEST(ToothVibration, RunoutIsLimitedToTheBite) {
  // The bite is between zero and twice its mean, so the force of hertz_chip is between zero and 2^1.5 times its value
  // at the mean bite.
  Cut large(3000, 50, 0), larger(3000, 500, 0);
  const double a = large.effect().lines()[ToothVibrationEffect::kRunout].Magnitude();
  EXPECT_NEAR(larger.effect().lines()[ToothVibrationEffect::kRunout].Magnitude(), a, 1e-9 * a);
  const double max_N = 0.5 * std::pow(2, 1.5) * large.last().thrust_sum_N * std::hypot(1, 0.625);
  EXPECT_LT(a, 1.02 * max_N);  // 2 % for the grid's ripple from tick to tick
  EXPECT_GT(a, 0.5 * max_N);
}

TEST(ToothVibration, SamplesContainTheLinesAboveTheTickRate) {
  Cut cut(7500, 5, 0.2);  // 125, 1500, 3000, 6000 Hz
  const auto& effect = cut.effect();
  std::vector<double> x, z;
  const double dt_s = 1.0 / 48000;
  for (int i = 0; i < 9600; ++i) {
    x.push_back(effect.Sample(i * dt_s).x);
    z.push_back(effect.Sample(i * dt_s).z);
  }
  const auto at = [&](int line, std::size_t axis) {
    return std::abs(effect.lines()[static_cast<std::size_t>(line)].amplitude_N[axis]);
  };
  // 0.2 s is a whole number of periods of every line.
  EXPECT_NEAR(LineOf(x, dt_s, 3000), at(ToothVibrationEffect::kPassing, 0), 1e-9);
  EXPECT_NEAR(LineOf(x, dt_s, 6000), at(ToothVibrationEffect::kPassing2, 0), 1e-9);
  EXPECT_NEAR(LineOf(z, dt_s, 1500), at(ToothVibrationEffect::kSet, 2), 1e-9);
  EXPECT_NEAR(LineOf(x, dt_s, 125), at(ToothVibrationEffect::kRunout, 0), 1e-9);
  EXPECT_LT(LineOf(x, dt_s, 4000), 1e-9);
}

TEST(ToothVibration, FallsSilentInAir) {
  CoupledParams params;
  params.effects.emplace_back("tooth_vibration");
  CoupledSimulation simulation(test::MakeBox(Pose{}, {8, 30, 16}, 0.4), params, Cut::At(19.2));
  double z = 19.2;
  CoupledOutput out;
  for (int i = 0; i < 1500; ++i) out = simulation.Tick({.X_WH = Cut::At(z -= 0.002)});
  std::array<double, 5> figures{};
  EffectsOf(simulation).Report(figures);
  EXPECT_GT(figures[3], 1e-4);
  EXPECT_EQ(figures[4], 3000);
  for (int i = 0; i < 400; ++i) out = simulation.Tick({.X_WH = Cut::At(z += 0.05)});
  EffectsOf(simulation).Report(figures);
  for (int n = 0; n < 4; ++n) EXPECT_EQ(figures[static_cast<std::size_t>(n)], 0);
  EXPECT_EQ(out.f_H_W_N, Vec3(0));
}

}  // namespace
}  // namespace kerf
