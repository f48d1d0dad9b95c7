// Rate at which a blade with a stroke cuts under a constant push, compared with single teeth that cut a floor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <numeric>
#include <vector>

#include "cut/tool/edge_down.h"
#include "kerf/coupled.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr double kBlock_mm = 12;  // along the edge
constexpr double kBone_MPa = 19300, kBoneNu = 0.28;

/// What the tooth-and-floor model knows of a blade.
struct Row {
  double pitch_mm, stroke_mm, swing_radius_mm;     // 0: straight
  std::function<double(double bite_mm)> thrust_N;  // of a tooth
};

/// Returns the rate at which single teeth lower the floor of a block, mm/s. The blade has no mass: at each moment it is
/// where the teeth in the block carry the push. A tooth bites what stands above it of the floor that the tooth before
/// has left at its place. The blade is carried along its edge slowly, by a pitch in all, so that each place is passed
/// equally often.
double CalcFloorRate(const Row& row, double strokes_per_min, double push_N) {
  constexpr int kPeriods = 47, kSteps = 500;
  // All teeth come to their next cells at the same moment; otherwise each would keep what the others' steps push it in.
  const double cell_mm = row.pitch_mm / 47;
  std::vector<double> floor_mm(static_cast<std::size_t>(std::lround(kBlock_mm / cell_mm)), 0.0);
  const int reach = static_cast<int>(std::ceil((0.5 * kBlock_mm + row.stroke_mm) / row.pitch_mm)) + 1;
  struct ToothAt {
    long cell = -1;
    double found_mm = 0;  // floor of the cell when the tooth came to it
    double cosine = 1;    // between the tooth's direction and the feed
  };
  std::vector<ToothAt> teeth(static_cast<std::size_t>(2 * reach + 1));
  const auto is_in_block = [&](const ToothAt& tooth) {
    return tooth.cell >= 0 && tooth.cell < static_cast<long>(floor_mm.size());
  };
  double z_mm = 0, before_mm = 0;
  for (int i = 0; i < 2 * kPeriods * kSteps; ++i) {
    if (i == kPeriods * kSteps) before_mm = std::accumulate(floor_mm.begin(), floor_mm.end(), 0.0);
    const double periods = static_cast<double>(i) / kSteps;
    const double slide_mm =
        0.5 * row.stroke_mm * std::sin(2 * std::numbers::pi * periods) + row.pitch_mm * periods / kPeriods;
    for (int k = -reach; k <= reach; ++k) {
      const int at = k + reach;
      ToothAt& tooth = teeth[static_cast<std::size_t>(at)];
      const double y_mm = (k - 1) * row.pitch_mm + slide_mm;
      const long cell = static_cast<long>(std::floor((y_mm + 0.5 * kBlock_mm) / cell_mm));
      if (cell == tooth.cell) continue;
      tooth.cell = cell;
      tooth.cosine = row.swing_radius_mm > 0 ? std::cos(std::asin(y_mm / row.swing_radius_mm)) : 1;
      if (is_in_block(tooth)) tooth.found_mm = floor_mm[static_cast<std::size_t>(cell)];
    }
    double low_mm = z_mm - 0.3, high_mm = z_mm + 0.3;
    while (high_mm - low_mm > 1e-7) {
      z_mm = 0.5 * (low_mm + high_mm);
      double carried_N = 0;
      for (const ToothAt& tooth : teeth) {
        if (is_in_block(tooth))
          carried_N += tooth.cosine * row.thrust_N(std::max(0.0, tooth.cosine * (z_mm - tooth.found_mm)));
      }
      (carried_N < push_N ? low_mm : high_mm) = z_mm;
    }
    for (const ToothAt& tooth : teeth) {
      if (!is_in_block(tooth)) continue;
      double& floor = floor_mm[static_cast<std::size_t>(tooth.cell)];
      floor = std::max(floor, z_mm);
    }
  }
  return (std::accumulate(floor_mm.begin(), floor_mm.end(), 0.0) - before_mm) * cell_mm / kBlock_mm /
         (kPeriods * 60 / strokes_per_min);
}

/// Returns the rate at which the simulated blade sinks, mm/s.
double CalcSinkRate(const CoupledParams& params, double strokes_per_min, double push_N, double tick_s) {
  Bone bone = test::MakeBox({}, {kBlock_mm, 3, 6}, 0.1);
  bone.set_materials(test::OneRegionTable(24, kBone_MPa, kBoneNu));
  CoupledParams pushed = params;
  pushed.coupling.max_force_N = push_N;
  pushed.coupling.stiffness_N_per_mm = push_N;  // the handle is so far away that the push is the coupling's maximum
  pushed.coupling.damping_Ns_per_mm = 0;
  const auto pose = [](double z_mm) { return Pose{CalcEdgeDown(), Vec3(0, 0, z_mm)}; };
  double z_mm = 2;
  CoupledSimulation simulation(bone, pushed, pose(z_mm));
  const double ticks_per_period = 60 / strokes_per_min / tick_s;
  const int measured = static_cast<int>(std::lround(std::ceil(0.2 / tick_s / ticks_per_period) * ticks_per_period));
  double from_mm = 0;
  for (int i = 0; i < 2 * measured; ++i) {
    if (i == measured) from_mm = z_mm;
    CoupledInput in;
    in.X_WH = pose(z_mm - 20);
    in.dt_s = tick_s;
    in.rpm = strokes_per_min;
    z_mm = simulation.Tick(in).X_WT.p_AB.z;
  }
  return (from_mm - z_mm) / (measured * tick_s);
}

TEST(StrokeHand, SinksAsSingleTeethThatCutAFloorDo) {
  ReciprocatingBlade straight;
  OscillatingBlade swinging;
  swinging.width_mm = 16;
  const double steel = (1 - straight.nu * straight.nu) / straight.E_MPa;
  const double E_star_MPa = 1 / (steel + (1 - kBoneNu * kBoneNu) / kBone_MPa);
  const auto hertz = [=](double radius_mm) {
    return [=](double bite_mm) { return 4 / 3. * E_star_MPa * std::sqrt(radius_mm) * std::pow(bite_mm, 1.5); };
  };
  const auto two_component = [](double bite_mm) {
    return 0.4 * (9.66 * std::min(1.0, bite_mm / 0.002) + 468 * bite_mm);  // teeth 0.4 mm wide
  };
  // The straight blade is 30 mm long: half of it stands for Hertz's radius.
  struct RateCase {
    Tool tool;
    const char* law;
    Row row;
  };
  const double swing_mm = swinging.radius_mm * swinging.swing_deg * std::numbers::pi / 180;
  const RateCase cases[] = {
      {straight, "hertz_chip", {1.41, 3, 0, hertz(15)}},
      {straight, "two_component", {1.41, 3, 0, two_component}},
      {swinging, "hertz_chip", {1, swing_mm, 25, hertz(25)}},
      {swinging, "two_component", {1, swing_mm, 25, two_component}},
  };
  double error = 0;
  for (const RateCase& one : cases) {
    CoupledParams params;
    params.tool = one.tool;
    params.law = ForceLaw(one.law);
    for (const double push_N : {3.0, 20.0}) {
      // In the model the floor is lowered by the same depth in each pass, whatever the rate.
      const double per_stroke_mm = CalcFloorRate(one.row, 60, push_N);
      for (const double rate : {5000.0, 15000.0, 20000.0}) {
        for (const double tick_s : {1e-3, 5e-4, 2.5e-4}) {
          const double got = CalcSinkRate(params, rate, push_N, tick_s) / (per_stroke_mm * rate / 60);
          // 1 % is left by the model's cells and periods: with twice as many it is within 0.1 % of its closed form.
          EXPECT_NEAR(got, 1, 0.03) << DescribeTool(one.tool) << ", " << one.law << ", " << push_N << " N, " << rate
                                    << ", " << tick_s;
          error = std::max(error, std::abs(got - 1));
        }
      }
    }
  }
  std::printf("largest error of the rate: %.2f %%\n", 100 * error);
}

}  // namespace
}  // namespace kerf
