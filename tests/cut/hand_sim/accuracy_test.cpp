// Options of the coupled tick that trade accuracy for time: substeps, deferred removal and fewer bits.
#include <gtest/gtest.h>

#include <numeric>

#include "bone/grid/build.h"
#include "cut/hand_sim/hands.h"
#include "cut/hand_sim/internals.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::Handle;

constexpr double kTop = 3;

struct Cut {
  std::vector<CoupledOutput> ticks;
  double removed_mm3 = 0;
  std::uint64_t hash = 0;
  double loss_mm3 = 0;
};

/// Moves the handle down at 20 mm/s and back up, so fast that the tool moves far in a tick.
Cut Plunge(const ComparedParams& params, double tick_s = 0.001, const Bone* given = nullptr, double above_mm = 0.3) {
  const Bone bone = given ? *given : test::MakeBox(Pose{}, {20, 3, 6}, 0.1);
  const double start = kTop + kSaw.radius_mm() + above_mm;
  CoupledSimulation simulation = MakeComparedSimulation(bone, params, DiscPose(Pose{}, {0, 0.013, start}));
  Cut cut;
  const int ticks = static_cast<int>(std::lround(0.4 / tick_s));
  for (int i = 1; i <= ticks; ++i) {
    const double t_s = i * tick_s;
    const double path_mm = 20 * (t_s < 0.2 ? t_s : 0.4 - t_s);
    cut.ticks.push_back(simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.013, start - path_mm}), 7500, tick_s)));
    cut.removed_mm3 += cut.ticks.back().removed_mm3;
  }
  const auto by_region = simulation.CalcRemovedByRegion();
  cut.loss_mm3 = std::accumulate(by_region.begin(), by_region.end(), 0.0);
  cut.hash = simulation.UpdateBone().CalcHash();
  return cut;
}

Cut Plunge(const CoupledParams& params, double tick_s = 0.001, const Bone* given = nullptr, double above_mm = 0.3) {
  return Plunge(ComparedParams{params}, tick_s, given, above_mm);
}

/// Returns the largest difference in force, at the ends of the ticks of `a`.
double CalcWorst(const Cut& a, const Cut& b) {
  const std::size_t stride = b.ticks.size() / a.ticks.size();
  double worst = 0;
  for (std::size_t i = 0; i < a.ticks.size(); ++i) {
    worst = std::max(worst, glm::length(a.ticks[i].f_H_W_N - b.ticks[(i + 1) * stride - 1].f_H_W_N));
  }
  return worst;
}

TEST(CoupledSubsteps, MatchShorterTicksExceptForRounding) {
  // The handle moves uniformly within a tick, so n substeps are the same as n ticks of 1/n ms. Here it reverses at the
  // end of a tick, so that the motion is the same in both runs. They differ only in how time is summed, by rounding.
  CoupledParams params = DiscParams();
  const Cut fine = Plunge(params, 0.00025);
  params.substeps = 4;
  const Cut parts = Plunge(params, 0.001);
  EXPECT_LT(CalcWorst(parts, fine), 1e-6);
  EXPECT_NEAR(parts.removed_mm3, fine.removed_mm3, 1e-6);
}

TEST(CoupledSubsteps, DoublingTheirNumberHalvesTheError) {
  // Implicit Euler is of first order. If the error is exactly proportional to the step, the difference from 32 substeps
  // is proportional to 1/n - 1/32, and the ratios are 31/15 and 15/7. Ticks are long and the coupling is stiff, so that
  // the error is due to the tool's lag within a tick, not to the grid's ripple.
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 20;
  params.substeps = 32;
  // After four ticks of 0.08 mm the rim has begun to enter the bone, which it does 0.0075 mm in front of it, and a
  // quarter of a tick earlier it has not: all runs touch the bone at nearly the same time.
  constexpr double kAbove_mm = 0.32;
  const Cut best = Plunge(params, 0.004, nullptr, kAbove_mm);
  std::vector<double> rms;
  for (const int substeps : {1, 2, 4}) {
    params.substeps = substeps;
    const Cut cut = Plunge(params, 0.004, nullptr, kAbove_mm);
    double sum = 0;
    for (std::size_t i = 0; i < 50; ++i) {  // on the way down only
      const Vec3 error = cut.ticks[i].f_H_W_N - best.ticks[i].f_H_W_N;
      sum += glm::dot(error, error);
    }
    rms.push_back(std::sqrt(sum / 50));
  }
  EXPECT_GT(rms[0], 0.05);  // N: a substantial error
  EXPECT_NEAR(rms[0] / rms[1], 31.0 / 15, 0.4);
  EXPECT_NEAR(rms[1] / rms[2], 15.0 / 7, 0.4);
}

TEST(CoupledSubsteps, EnergyBalanceCloses) {
  CoupledParams params = DiscParams();
  params.substeps = 5;
  for (const CoupledOutput& out : Plunge(params).ticks) {
    EXPECT_NEAR(out.hand_mJ + out.spindle_mJ,
                out.stored_mJ + out.cut_mJ + out.friction_mJ + out.damping_mJ + out.numerical_mJ, 1e-9);
    EXPECT_GE(out.cut_mJ, 0);
  }
}

TEST(CarveInterval, RemovesTheSameBoneAlongTheSameMotion) {
  // With a stiff coupling the tool's motion hardly depends on when bone is removed; the removal rule is independent of
  // order.
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.max_force_N = 1e4;
  const Cut each = Plunge(params);
  for (const int interval : {2, 5, 16}) {
    params.carve_interval_ticks = interval;
    const Cut rare = Plunge(params);
    EXPECT_NEAR(rare.loss_mm3, each.loss_mm3, 0.002 * each.loss_mm3) << interval;
    EXPECT_NEAR(rare.removed_mm3, each.removed_mm3, 0.002 * each.removed_mm3) << interval;
    // Removal is deferred, which leaves many ticks that remove nothing while the tool moves down.
    const auto idle = std::count_if(rare.ticks.begin() + 50, rare.ticks.begin() + 150,
                                    [](const CoupledOutput& out) { return out.removed_mm3 == 0; });
    EXPECT_GE(idle, 20) << interval;  // at 20 mm/s a quarter of a voxel is 1.25 ms
  }
}

TEST(CarveInterval, PendingRemovalIsDoneWhenTheToolIsLiftedOrStopped) {
  const Bone bone = test::MakeBox(Pose{}, {20, 3, 6}, 0.1);
  const double start = kTop + kSaw.radius_mm() + 0.01;
  for (const int what : {0, 1, 2}) {
    std::vector<double> loss_mm3;
    for (const int interval : {1, 64}) {
      CoupledParams params = DiscParams();
      params.coupling.stiffness_N_per_mm = 1000;
      params.carve_interval_ticks = interval;
      CoupledSimulation simulation(bone, params, DiscPose(Pose{}, {0, 0.013, start}));
      for (int i = 1; i <= 21; ++i) simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.013, start - 0.002 * i})));
      if (what == 0) simulation.SetDown(DiscPose(Pose{}, {0, 0.013, start + 30}));
      if (what == 1) simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.013, start - 0.042}), 0));
      const auto by_region = simulation.CalcRemovedByRegion();
      loss_mm3.push_back(std::accumulate(by_region.begin(), by_region.end(), 0.0));
    }
    EXPECT_GT(loss_mm3[0], 0.005);
    EXPECT_NEAR(loss_mm3[1], loss_mm3[0], 0.02 * loss_mm3[0]) << what;
  }
}

TEST(PrecisionBits, EachBitHalvesTheRoundingErrorOfTheBone) {
  // Distances of up to 0.3 mm, rounded to n bits, have a relative error of 2^-n. With all bits of a float, the result
  // is the same as without the option.
  const Bone bone = test::MakeBox(Pose{}, {20, 3, 6}, 0.1);
  ComparedParams params{DiscParams()};
  const Cut whole = Plunge(params, 0.001, &bone);
  params.precision_bits = 24;
  EXPECT_EQ(Plunge(params, 0.001, &bone).hash, whole.hash);
  std::vector<double> worst;
  for (const int bits : {6, 9, 12}) {
    params.precision_bits = bits;
    Bone rounded = bone;
    RoundDistances(rounded, bits);
    worst.push_back(CalcWorst(Plunge(params, 0.001, &rounded), whole));
  }
  EXPECT_GT(worst[0], 2 * worst[1]);
  EXPECT_GT(worst[1], 2 * worst[2]);
  EXPECT_LT(worst[2], 0.05);  // N
}

TEST(BandWidth, AWiderBandCutsTheSame) {
  // The tool looks at most three voxels ahead, so values further away do not matter.
  const auto make = [](int band_voxels) {
    SolidField solid;
    solid.value = [](const Vec3& p) { return test::BoxDistance(p, {10, 1.5, 3}); };
    solid.classify = ClassifyByDistance(solid.value);
    solid.region = [](const Vec3&) { return 24; };
    BuildOptions options;
    options.voxel_mm = options.region_voxel_mm = 0.1;
    options.band_voxels = band_voxels;
    return MakeBone(solid, {{-11, -2.5, -4}, {11, 2.5, 4}}, options, test::OneRegionTable());
  };
  const Bone three = make(3);
  const Bone six = make(6);
  EXPECT_DOUBLE_EQ(three.band_mm(), 3 * 0.1);
  EXPECT_DOUBLE_EQ(six.band_mm(), 6 * 0.1);
  EXPECT_GT(six.CountActiveVoxels(), 1.5 * static_cast<double>(three.CountActiveVoxels()));
  const Cut a = Plunge(DiscParams(), 0.001, &three);
  const Cut b = Plunge(DiscParams(), 0.001, &six);
  EXPECT_LT(CalcWorst(a, b), 1e-3);
  EXPECT_NEAR(a.loss_mm3, b.loss_mm3, 1e-3 * a.loss_mm3);
}

}  // namespace
}  // namespace kerf
