// Laws whose force follows the density of the bone: (density / reference)^n with E ~ density^b.
#include <gtest/gtest.h>

#include <cmath>

#include "cut/force/measured.h"
#include "kerf/force.h"
#include "support/saw.h"

namespace kerf {
namespace {

constexpr double kDensityBites_mm[] = {1e-4, 2.5e-3, 2e-2};
/// A power is exact to one unit in the last place of 2.3e-16; E to the 1 / b before it and the products add a few more,
/// times the exponent n ln(E / E_ref), which is below 10 here.
constexpr double kPowerRounding = 1e-14;

ForceLaw MakeDensityLaw(const char* name, double n, double b) {
  ForceLaw law(name);
  law.Set("density_exponent", n);
  law.Set("modulus_exponent", b);
  return law;
}

ToothCut CutBone(double E_MPa, Tissue tissue) {
  return MakeToothCut(E_MPa, CalcReducedModulus(kSaw.E_MPa, kSaw.nu, E_MPa, 0.28), tissue);
}

TEST(DensityLaw, DoubledDensityMultipliesBothForcesByTwoToTheN) {
  for (const char* name : {"edge_plus_chip", "two_component"}) {
    for (const double n : {0.5, 1.0, 2.0}) {
      for (const double b : {1.49, 2.18}) {
        const ToothForce force = MakeToothForce(MakeDensityLaw(name, n, b), kSaw);
        for (const Tissue tissue : {Tissue::kCortical, Tissue::kCancellous}) {
          for (const double h : kDensityBites_mm) {
            const ToothCut once = CutBone(900, tissue);
            const ToothCut twice = CutBone(900 * std::pow(2, b), tissue);
            EXPECT_GT(force(h, once), 0);
            EXPECT_NEAR(force(h, twice) / force(h, once), std::pow(2, n), 4 * kPowerRounding) << name << " " << n;
            if (!force.HasCutting()) continue;
            EXPECT_NEAR(force.Cutting(h, twice) / force.Cutting(h, once), std::pow(2, n), 4 * kPowerRounding) << name;
          }
        }
      }
    }
  }
}

TEST(DensityLaw, BoneOfTheReferenceHasTheMeasuredForce) {
  for (const char* name : {"edge_plus_chip", "two_component"}) {
    const ToothForce plain = MakeToothForce(ForceLaw(name), kSaw);
    const ToothForce force = MakeToothForce(MakeDensityLaw(name, 1.5, 1.93), kSaw);
    ToothCut cut = CutBone(kMeasuredE_MPa, Tissue::kCortical);
    cut.E_star_MPa = kMeasuredEStar_MPa;  // the reference of edge_plus_chip, rounded
    for (const double h : kDensityBites_mm) EXPECT_NEAR(force(h, cut) / plain(h, cut), 1, kPowerRounding) << name;
    // A higher reference lowers the force.
    ForceLaw harder = MakeDensityLaw(name, 1, 2);
    harder.Set("reference_E_MPa", 4 * kMeasuredE_MPa);
    for (const double h : kDensityBites_mm) {
      EXPECT_NEAR(MakeToothForce(harder, kSaw)(h, cut) / plain(h, cut), 0.5, kPowerRounding) << name;
    }
  }
}

TEST(DensityLaw, OnlyBoneIsScaled) {
  const ToothForce plain = MakeToothForce(ForceLaw("two_component"), kSaw);
  const ToothForce force = MakeToothForce(MakeDensityLaw("two_component", 2, 1.93), kSaw);
  for (const Tissue tissue : {Tissue::kTooth, Tissue::kCanal, Tissue::kOther}) {
    EXPECT_EQ(force(0.005, CutBone(500, tissue)), plain(0.005, CutBone(500, tissue)));
  }
  // Cancellous bone has no factor of its own.
  EXPECT_EQ(force(0.005, CutBone(500, Tissue::kCancellous)), force(0.005, CutBone(500, Tissue::kCortical)));
}

TEST(DensityLaw, WithoutTheExponentNothingChanges) {
  for (const char* name : {"edge_plus_chip", "two_component"}) {
    const ToothForce plain = MakeToothForce(ForceLaw(name), kSaw);
    ForceLaw off = MakeDensityLaw(name, 0, 3);
    off.Set("reference_E_MPa", 500);
    const ToothForce force = MakeToothForce(off, kSaw);
    EXPECT_EQ(force.thrust, plain.thrust) << name;  // the same function
    EXPECT_EQ(force.cutting, plain.cutting) << name;
    // Which reads no density: with the same E*, E has no influence.
    ToothCut lighter = CutBone(900, Tissue::kCortical);
    lighter.E_MPa = 100;
    EXPECT_EQ(force(0.005, lighter), force(0.005, CutBone(900, Tissue::kCortical))) << name;
    for (const Tissue tissue : {Tissue::kCortical, Tissue::kCancellous}) {
      for (const double h : kDensityBites_mm)
        EXPECT_EQ(force(h, CutBone(900, tissue)), plain(h, CutBone(900, tissue))) << name;
    }
  }
}

}  // namespace
}  // namespace kerf
