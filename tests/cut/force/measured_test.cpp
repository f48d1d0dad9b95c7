// The laws compared with thrusts measured on a saw's tooth, from which the factors in the program and in
// docs/physics.md are calculated.
#include "cut/force/measured.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "kerf/force.h"
#include "kerf/material.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

double Thrust(const char* law, double bite_mm, const DiscSaw& saw = kSaw) {
  return MakeToothForce(ForceLaw(law), saw)(bite_mm, Cortical(kMeasuredEStar_MPa));
}

TEST(Measured, ThrustIsDerivedFromResultantAndRatio) {
  const double fraction = kThrustPerCuttingForce / std::hypot(kThrustPerCuttingForce, 1.0);
  EXPECT_NEAR(kMeasuredThrust[0].thrust_N, 8 * fraction, 5e-4);
  EXPECT_NEAR(kMeasuredThrust[1].thrust_N, 11 * fraction, 5e-4);
  EXPECT_NEAR(kMeasuredEStar_MPa, CalcReducedModulus(205000, 0.28, 19300, 0.28), 0.5);
}

TEST(Measured, FactorsMatchWhatTheLawsState) {
  const auto factor = [](const char* law, std::size_t i) {
    return Thrust(law, kMeasuredThrust[i].bite_mm) / kMeasuredThrust[i].thrust_N;
  };
  EXPECT_NEAR(factor("hertz_chip", 0), 1.6, 0.05);  // "1.6 times at 2.5 um"
  EXPECT_NEAR(factor("hertz_chip", 1), 9, 0.5);     // "9 times at 10 um"
  EXPECT_NEAR(1 / factor("hertz_constant_bite", 0), 120, 5);
  EXPECT_NEAR(1 / factor("hertz_constant_bite", 1), 170, 5);
  // The ends of the ratio's range, 1.4 and 1.8, change the first factor by 4 %.
  for (const double ratio : {1.4, 1.8}) {
    const double thrust = 8 * ratio / std::hypot(ratio, 1.0);
    EXPECT_NEAR(Thrust("hertz_chip", 0.0025) / thrust, 1.56, 0.07);
  }
  // At the end of hertz_chip's range, the law gives twice the thrust on the line through the measured thrusts.
  const double slope = (kMeasuredThrust[1].thrust_N - kMeasuredThrust[0].thrust_N) / 0.0075;
  const double end = ForceLaw("hertz_chip").info().validity.to_mm;
  EXPECT_NEAR(Thrust("hertz_chip", end) / (kMeasuredThrust[0].thrust_N + slope * (end - 0.0025)), 2, 0.05);
  // For a tooth as wide as the tested one, edge_plus_chip is that line.
  DiscSaw tested;
  tested.thickness_mm = kMeasuredToothWidth_mm;
  for (const MeasuredThrust& m : kMeasuredThrust) {
    EXPECT_NEAR(Thrust("edge_plus_chip", m.bite_mm, tested), m.thrust_N, 2e-3 * m.thrust_N);
    EXPECT_NEAR(Thrust("tabulated", m.bite_mm, tested), m.thrust_N, 1e-3 * m.thrust_N);
    // The mean of that line and of the one that grows by 30 % from 2 to 10 um.
    EXPECT_NEAR(Thrust("two_component", m.bite_mm, tested), m.thrust_N, 0.03 * m.thrust_N);
  }
}

TEST(Measured, SpecificEnergyOfEachLaw) {
  const auto energy = [](const char* law, double bite_mm) {
    return CalcSpecificEnergy(
        CalcCuttingForce(MakeToothForce(ForceLaw(law), kSaw), bite_mm, Cortical(kMeasuredEStar_MPa)), kSaw.thickness_mm,
        bite_mm);
  };
  EXPECT_NEAR(energy("hertz_chip", 0.001), 6.7, 0.05);
  EXPECT_NEAR(energy("hertz_chip", 0.0025), 10.6, 0.05);
  EXPECT_NEAR(energy("hertz_chip", 0.010), 21.2, 0.1);
  // With Ke = 9.28 N/mm and Kc = 530 N/mm2, divided by 1.6, the results lie within the 2.4 to 2.9 and 0.83 to 1.0 of
  // independent tests.
  EXPECT_NEAR(energy("edge_plus_chip", 0.0025), 2.65, 0.01);
  EXPECT_NEAR(energy("edge_plus_chip", 0.010), 0.911, 0.001);
  // Kec = 6.83 N/mm and Kcc = 166 N/mm2: 6.83 / 2.5 + 0.166 and 6.83 / 10 + 0.166.
  EXPECT_NEAR(energy("two_component", 0.0025), 2.898, 1e-3);
  EXPECT_NEAR(energy("two_component", 0.010), 0.849, 1e-3);
  EXPECT_LT(energy("hertz_constant_bite", 0.0025), kMinSpecificEnergy_J_per_mm3);
}

TEST(Measured, DependenceOfEachLawOnTheBlade) {
  DiscSaw thick = kSaw;
  thick.thickness_mm = 4 * kSaw.thickness_mm;
  DiscSaw large = kSaw;  // four times the radius, the same pitch
  large.diameter_mm = 4 * kSaw.diameter_mm;
  large.teeth = 4 * kSaw.teeth;
  const auto factor = [](const char* law, const DiscSaw& saw) {
    return Thrust(law, 0.0025, saw) / Thrust(law, 0.0025);
  };
  EXPECT_EQ(factor("hertz_chip", thick), 1);
  EXPECT_EQ(factor("hertz_constant_bite", thick), 1);
  EXPECT_NEAR(factor("edge_plus_chip", thick), 4, 1e-12);
  EXPECT_NEAR(factor("hertz_chip", large), 2, 1e-12);  // the square root of four
  EXPECT_NEAR(factor("hertz_constant_bite", large), 0.25, 1e-12);
  EXPECT_EQ(factor("edge_plus_chip", large), 1);
  large.teeth = kSaw.teeth;  // four times the pitch as well: 4^3 / 4
  EXPECT_NEAR(factor("hertz_constant_bite", large), 16, 1e-12);
}

// The factors depend on the tool and the parameters. For the default 22 mm disc they are 1.56 and 9.07 (hertz_chip),
// and 1/122.4 and 1/168 (hertz_constant_bite).
TEST(Measured, FactorsFollowToolAndParameters) {
  DiscSaw large;  // four times the radius, the same pitch
  large.diameter_mm = 88;
  large.teeth = 96;
  EXPECT_EQ(DescribeAccuracy(ForceLaw("hertz_chip"), large),
            "thrust 3.1 times that measured at a bite of 2.5 um, 18 times that at 10 um (88 mm disc with 96 teeth); "
            "nothing was measured below 2 um");
  EXPECT_THAT(DescribeAccuracy(ForceLaw("hertz_constant_bite"), large),
              testing::StartsWith("thrust 1/490 of that measured at a bite of 2.5 um, 1/673 of that at 10 um"));
  ForceLaw own("hertz_chip");
  own.Set("contact_radius_mm", 0.11);  // a hundredth of the tool's radius, so a tenth of the force
  EXPECT_THAT(DescribeAccuracy(own, kSaw),
              testing::StartsWith("thrust 0.16 times that measured at a bite of 2.5 um, 0.91 times that at 10 um"));
  EXPECT_EQ(DescribeBlades(own, DiscSaw{}),
            "ignores the blade's thickness and the tool's radius: it can't be used to compare blades");
  EXPECT_EQ(DescribeBlades(own, TwistDrill{}),
            "ignores tooth_width_mm and the tool's radius: it can't be used to compare tools");
  EXPECT_EQ(DescribeBlades(ForceLaw("edge_plus_chip"), TwistDrill{}),
            "scales with the length of the lips that cuts, and ignores the tool's radius");
  EXPECT_EQ(DescribeBlades(ForceLaw("two_component"), PiezoInsert{}),
            DescribeBlades(ForceLaw("two_component"), DiscSaw{}));
  DiscSaw thick;
  thick.thickness_mm = 1;
  ForceLaw edge("edge_plus_chip");
  EXPECT_THAT(DescribeAccuracy(edge, thick), testing::StartsWith("thrust for each mm of tooth width: 1 times that"));
  edge.Set("edge_N_per_mm", 2 * edge.Get("edge_N_per_mm"));
  edge.Set("chip_N_per_mm2", 2 * edge.Get("chip_N_per_mm2"));
  EXPECT_THAT(DescribeAccuracy(edge, thick), testing::StartsWith("thrust for each mm of tooth width: 2 times that"));
}

// The bite at which the law gives twice the measured force: 3.0 um with the 22 mm disc; with twice the radius, computed
// by hand, 4/3 19140 sqrt(22) h^1.5 = 2 (5.936 + 339.2 h) is solved by h = 2.33 um. With four times the radius it would
// be 1.82 um, where nothing was measured.
TEST(Measured, LargestValidBiteOfHertzChipDependsOnTheTool) {
  DiscSaw large;
  large.diameter_mm = 44;
  EXPECT_NEAR(FindMaxValidBite(ForceLaw("hertz_chip"), kSaw), 0.0030, 1e-5);
  const double top_mm = FindMaxValidBite(ForceLaw("hertz_chip"), large);
  EXPECT_NEAR(top_mm, 0.00233, 1e-5);
  EXPECT_NEAR(CalcThrustFactor(ForceLaw("hertz_chip"), large, top_mm), 2, 1e-6);
  EXPECT_EQ(FindMaxValidBite(ForceLaw("edge_plus_chip"), large), 0.01);
  large.diameter_mm = 88;
  EXPECT_EQ(FindMaxValidBite(ForceLaw("hertz_chip"), large), kMinMeasuredBite_mm);
  EXPECT_EQ(FindMinValidBite(ForceLaw("hertz_chip")), kMinMeasuredBite_mm);
}

// The ratio is that of the factors, of E* for the laws that are proportional to it, or of densities.
TEST(Measured, CorticalPerCancellousOfEachLaw) {
  const Region& cortical = DefaultMandibleTable().At(24);
  const Region& cancellous = DefaultMandibleTable().At(32);
  const auto E_star = [](const Region& r) { return CalcReducedModulus(kSaw.E_MPa, kSaw.nu, r.E_MPa, r.nu); };
  for (const char* name : {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"}) {
    EXPECT_NEAR(CalcCorticalPerCancellous(ForceLaw(name), kSaw), E_star(cortical) / E_star(cancellous), 1e-12) << name;
  }
  EXPECT_NEAR(CalcCorticalPerCancellous(ForceLaw("hertz_chip"), kSaw), 12.8, 0.05);
  EXPECT_NEAR(CalcCorticalPerCancellous(ForceLaw("two_component"), kSaw), 4, 1e-12);
  ForceLaw by_density("edge_plus_chip");
  by_density.Set("density_exponent", 1);
  EXPECT_NEAR(CalcCorticalPerCancellous(by_density, kSaw), std::pow(cortical.E_MPa / cancellous.E_MPa, 1 / 1.93),
              1e-12);
  // Every default lies within the interval that is stated, which is that of two_component's factor.
  for (const ForceLawInfo* info : ForceLaws()) {
    const double ratio = CalcCorticalPerCancellous(ForceLaw(info->name), kSaw);
    EXPECT_GT(ratio, kCorticalPerCancellous[0]) << info->name;
    EXPECT_LT(ratio, kCorticalPerCancellous[1]) << info->name;
    for (const LawParameter& p : info->parameters) {
      if (std::string_view(p.key) != "cancellous_factor") continue;
      ForceLaw law(info->name);
      law.Set(p.key, p.interval_lower);
      EXPECT_NEAR(CalcCorticalPerCancellous(law, kSaw), kCorticalPerCancellous[1], 1e-9);
      law.Set(p.key, p.interval_upper);
      EXPECT_NEAR(CalcCorticalPerCancellous(law, kSaw), kCorticalPerCancellous[0], 1e-9);
    }
  }
}

}  // namespace
}  // namespace kerf
