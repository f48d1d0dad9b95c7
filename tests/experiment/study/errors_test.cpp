#include "experiment/study/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "experiment/study/paths.h"

namespace kerf {
namespace {

std::vector<Vec3> MakeSeries(std::size_t count, double dt_s, const std::function<Vec3(double)>& force) {
  std::vector<Vec3> series;
  for (std::size_t i = 1; i <= count; ++i) series.push_back(force(dt_s * static_cast<double>(i)));
  return series;
}

ErrorFigures Compare(const std::vector<Vec3>& f, const std::vector<Vec3>& reference, double dt_s = 0.001) {
  ErrorFigures errors;
  CalcForceErrors(f, reference, dt_s, errors);
  return errors;
}

TEST(ForceErrors, OfAConstantOffset) {
  const auto reference = MakeSeries(1000, 0.001, [](double) { return Vec3(0, 0, 4); });
  const auto f = MakeSeries(1000, 0.001, [](double) { return Vec3(0.3, 0, 4); });
  const ErrorFigures errors = Compare(f, reference);
  EXPECT_NEAR(errors.force_l2, 0.075, 1e-12);
  EXPECT_NEAR(errors.force_p95, 0.075, 1e-12);
  EXPECT_NEAR(errors.force_worst, 0.075, 1e-12);
  EXPECT_NEAR(errors.force_worst_N, 0.3, 1e-12);
  EXPECT_NEAR(errors.impulse, 0.075, 1e-12);
  EXPECT_NEAR(errors.noise_N, 0, 1e-12);
  EXPECT_NEAR(errors.direction_p95_deg, std::atan(0.075) * 180 / std::numbers::pi, 1e-9);
  EXPECT_FALSE(errors.breakthrough_ms);
}

// Equally long errors of opposite sign cancel only in the signed figure. A sideways force hardly affects that figure.
TEST(ForceErrors, ImpulseHasASign) {
  const auto reference = MakeSeries(1000, 0.001, [](double) { return Vec3(0, 0, -4); });
  const auto signed_of = [&](const std::function<Vec3(double)>& force) {
    return Compare(MakeSeries(1000, 0.001, force), reference).impulse_signed.value();
  };
  EXPECT_NEAR(signed_of([](double) { return Vec3(0, 0, -4.4); }), 0.1, 1e-12);
  EXPECT_NEAR(signed_of([](double) { return Vec3(0, 0, -3.44); }), -0.14, 1e-12);
  EXPECT_NEAR(signed_of([](double t) { return Vec3(0, 0, t < 0.5005 ? -5 : -3); }), 0, 1e-12);
  EXPECT_NEAR(signed_of([](double) { return Vec3(0.04, 0, -4); }), 0.5 * 0.01 * 0.01, 1e-8);
  // For a tenth of the time there is a force where the reference has none.
  const auto ends = MakeSeries(1000, 0.001, [](double t) { return t < 0.5005 ? Vec3(2, 0, 0) : Vec3(0); });
  const auto late = MakeSeries(1000, 0.001, [](double t) { return t < 0.6005 ? Vec3(2, 0, 0) : Vec3(0); });
  EXPECT_NEAR(Compare(late, ends).impulse_signed.value(), 0.2, 1e-12);
}

TEST(ForceErrors, OfOneTickInTwenty) {
  // Six of a hundred ticks have an error of 1 N: the 95th percentile is among them. With five it is not.
  for (const int bad : {6, 5}) {
    auto f = MakeSeries(100, 0.001, [](double) { return Vec3(2, 0, 0); });
    const auto reference = f;
    for (int i = 0; i < bad; ++i) f[17 * static_cast<std::size_t>(i)].x = 3;
    const ErrorFigures errors = Compare(f, reference);
    EXPECT_NEAR(errors.force_p95, bad == 6 ? 0.5 : 0, 1e-12);
    EXPECT_NEAR(errors.force_worst, 0.5, 1e-12);
    EXPECT_NEAR(errors.force_l2, std::sqrt(0.01 * bad) / 2, 1e-12);
    EXPECT_NEAR(errors.impulse, 0.01 * bad / 2, 1e-12);
  }
}

TEST(ForceErrors, NoiseIsTheFastPart) {
  const auto reference = MakeSeries(2000, 0.001, [](double t) { return Vec3(5 * t, 1, 2); });
  const auto wave = [&](double Hz) {
    auto f = reference;
    for (std::size_t i = 0; i < f.size(); ++i) {
      f[i] += Vec3(0.03, 0.04, 0) * std::sin(2 * std::numbers::pi * Hz * 0.001 * static_cast<double>(i));
    }
    return Compare(f, reference).noise_N;
  };
  // The wave is 0.05 N along a line, so the expected value is its root mean square. A second-order filter, applied
  // forwards and backwards, removes 1/41 at 50 Hz and leaves 1/257 at 5 Hz.
  EXPECT_NEAR(wave(50), 0.05 / std::sqrt(2) * (1 - 1.0 / 41), 2e-4);
  EXPECT_LT(wave(5), 0.05 / std::sqrt(2) / 200);
}

TEST(ForceErrors, DirectionCountsOnlyWhereThereIsAForce) {
  const auto reference = MakeSeries(100, 0.001, [](double t) { return t < 0.0505 ? Vec3(0, 3, 0) : Vec3(0, 0.4, 0); });
  const auto f = MakeSeries(100, 0.001, [](double t) {
    return t < 0.0505 ? Vec3(3 * std::sin(std::numbers::pi / 9), 3 * std::cos(std::numbers::pi / 9), 0)
                      : Vec3(0.4, 0, 0);
  });
  const ErrorFigures errors = Compare(f, reference);
  EXPECT_NEAR(errors.direction_p95_deg, 20, 1e-9);
  EXPECT_NEAR(errors.direction_worst_deg, 20, 1e-9);
}

TEST(ForceErrors, ZeroForceCountsAsHalfANewton) {
  const std::vector<Vec3> nothing(50, Vec3(0));
  const std::vector<Vec3> f(50, Vec3(0, 0.05, 0));
  const ErrorFigures errors = Compare(f, nothing);
  EXPECT_NEAR(errors.force_l2, 0.1, 1e-12);
  EXPECT_NEAR(errors.force_p95, 0.1, 1e-12);
  EXPECT_NEAR(errors.impulse, 0.1, 1e-12);
  const ErrorFigures none = Compare(nothing, nothing);
  EXPECT_EQ(none.force_l2, 0);
  EXPECT_EQ(none.impulse, 0);
  EXPECT_EQ(none.impulse_signed, 0);
  EXPECT_EQ(none.direction_p95_deg, 0);
}

TEST(ForceErrors, BreakthroughIsWhenTheForceFallsForGood) {
  // The force falls from 5 N to 0 within 20 ms and reaches a tenth of the peak after 18 ms. An earlier gap does not
  // count.
  const auto falls_at = [](double start_s) {
    return MakeSeries(800, 0.001, [start_s](double t) {
      if (t > 0.1 && t < 0.15) return Vec3(0);
      return Vec3(5 * std::clamp(1 - (t - start_s) / 0.02, 0.0, 1.0), 0, 0);
    });
  };
  EXPECT_NEAR(*FindBreakthrough(falls_at(0.4), 0.001), 0.418, 1e-9);
  const ErrorFigures errors = Compare(falls_at(0.4123), falls_at(0.4));
  ASSERT_TRUE(errors.breakthrough_ms);
  EXPECT_NEAR(*errors.breakthrough_ms, 12.3, 1e-6);
}

TEST(ForceErrors, VolumeIsAFractionOfTheReferences) {
  EXPECT_NEAR(CalcVolumeError(9, 10), 0.1, 1e-12);
  EXPECT_NEAR(CalcVolumeError(11, 10), 0.1, 1e-12);
  EXPECT_EQ(CalcVolumeError(0, 0), 0);
  EXPECT_EQ(CalcVolumeError(0.2, 0), 0.2);
}

TEST(ForceErrors, ReferenceIsSampledLikeTheTicks) {
  StudyReference reference;
  reference.tick_s = 0.00025;
  // With f = t, the mean of a tick is the value at its middle.
  for (int i = 1; i <= 4000; ++i) {
    ReferenceTick tick;
    tick.f_W_N = Vec3(0.00025 * i, 0, 0);
    reference.ticks.push_back(tick);
  }
  for (const double rate_hz : {500.0, 1000.0, 4000.0, 1500.0}) {
    const auto in_hand = SampleReference(reference, Holding::kHand, rate_hz, 200);
    for (std::size_t k = 0; k < 200; ++k) EXPECT_NEAR(in_hand[k].x, static_cast<double>(k + 1) / rate_hz, 1e-9);
  }
  for (ReferenceTick& tick : reference.ticks) tick.f_W_N.x -= 0.000125;
  for (const double rate_hz : {500.0, 1000.0, 4000.0, 2000.0}) {
    const auto led = SampleReference(reference, Holding::kPath, rate_hz, 200);
    for (std::size_t k = 0; k < 200; ++k) EXPECT_NEAR(led[k].x, (static_cast<double>(k) + 0.5) / rate_hz, 1e-9);
  }
}

TEST(SurfaceErrors, OfTwoListsAreTheWorseOfBoth) {
  ErrorFigures errors;
  CalcSurfaceErrors({0.1, 0.1, 0.1, 0.1}, {0.2, 0.4}, errors);
  EXPECT_NEAR(errors.surface_mean_mm, 0.2, 1e-12);
  EXPECT_NEAR(errors.surface_p95_mm, 0.4, 1e-12);
  EXPECT_NEAR(errors.surface_max_mm, 0.4, 1e-12);
}

/// A disc's kerf in a block, exact and in voxels that were cut `beside_mm` away from it along the spindle.
struct BesideCase {
  explicit BesideCase(double beside_mm) {
    block.size_mm = {24, 10, 6};
    X = {glm::normalize(glm::angleAxis(0.3, Vec3(0, 0, 1)) * glm::angleAxis(-0.5 * std::numbers::pi, Vec3(1, 0, 0))),
         {0.1, 0.05, 8}};
    const Pose X_beside{X.R_AB, X.Point({0, 0, beside_mm})};
    path = MakePlainPath("beside", "");
    const auto was_cut = [X_beside, saw = path.saw](const Vec3& p_W) {
      const Vec3 p_T = X_beside.InversePoint(p_W);
      const double across = std::hypot(p_T.x, p_T.y) - saw.radius_mm();
      const double along = std::abs(p_T.z) - 0.5 * saw.thickness_mm;
      return -(across > 0 && along > 0 ? std::hypot(across, along) : std::max(across, along));
    };
    SetBlock(path, block, {.shape = nullptr, .was_cut = was_cut});
    StudyPath uncut = MakePlainPath("uncut", "");
    SetBlock(uncut, block);
    exact = std::make_unique<ExactBone>(uncut.solid, path.saw);
    for (int i = 0; i < 400; ++i) {
      ReferenceTick tick;
      tick.X_WT = {X.R_AB, X.p_AB + Vec3(0, 0, 0.5 - 0.00125 * (i + 1))};
      exact->Sweep({X.R_AB, X.p_AB + Vec3(0, 0, 0.5 - 0.00125 * i)}, tick.X_WT, 0);
      ticks.push_back(tick);
    }
  }
  BlockParams block;
  Pose X;
  StudyPath path;
  std::unique_ptr<ExactBone> exact;
  std::vector<ReferenceTick> ticks;
};

TEST(SurfaceErrors, DistanceOfParallelKerfsIsTheirOffset) {
  const BesideCase there(0);
  ErrorFigures none;
  CalcCutSurfaceErrors(there.path.make_bone(0.05, 3), *there.exact, there.ticks, there.path.saw, 0, none);
  // Flats are exact to within the grid's rounding; the corners of the floor are rounded by about a third of a voxel.
  EXPECT_LT(none.surface_mean_mm, 0.002);
  EXPECT_LT(none.surface_max_mm, 0.03);
  EXPECT_GT(none.surface_max_mm, 0);
  const BesideCase beside(0.03);
  ErrorFigures errors;
  CalcCutSurfaceErrors(beside.path.make_bone(0.05, 3), *beside.exact, beside.ticks, beside.path.saw, 0, errors);
  // The flats have more than eight tenths of the points. Along the floor both surfaces coincide.
  EXPECT_GT(errors.surface_mean_mm, 0.8 * 0.03);
  EXPECT_LT(errors.surface_mean_mm, 0.031);
  EXPECT_NEAR(errors.surface_p95_mm, 0.03, 0.001);
}

}  // namespace
}  // namespace kerf
