#include "kerf/force.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kerf/error.h"
#include "kerf/material.h"

namespace kerf {
namespace {

const DiscSaw kSaw;
const double kEStar24 = CalcReducedModulus(205000, 0.28, 19300, 0.28);

ForceLaw Law(ForceLawKind kind) {
  ForceLaw law;
  law.kind = kind;
  return law;
}

TEST(Force, ConstantBiteIsThePapersForceOnOneTooth) {
  // Tables 3 to 6 at 1.1 mm: one tooth. Region 24 and the others, printed to five figures.
  const ToothForce force = MakeToothForce(Law(ForceLawKind::kHertzConstantBite), kSaw);
  const auto newton = [&](double E, double nu) { return force(1e-3, CalcReducedModulus(205000, 0.28, E, nu)); };
  EXPECT_NEAR(newton(19300, 0.28), 0.05541, 1e-5);
  EXPECT_NEAR(newton(20500, 0.25), 0.05763, 1e-5);
  EXPECT_NEAR(newton(19300, 0.25), 0.05455, 1e-5);
  EXPECT_NEAR(newton(17300, 0.38), 0.05365, 1e-5);
}

TEST(Force, ChipBiteOfTwoAndAHalfMicrometresIsTheReferencesTenNewton) {
  // docs/physics.md: R = 11 mm, region 24, 2.5 um: 10.6 N a tooth, and 84 N at 10 um.
  const ToothForce force = MakeToothForce(Law(ForceLawKind::kHertzChip), kSaw);
  EXPECT_NEAR(force(2.5e-3, kEStar24), 10.6, 0.05);
  EXPECT_NEAR(force(10e-3, kEStar24), 84.6, 0.5);
}

TEST(Force, ConstantBiteIsTheChipBiteOfItsOwnDepth) {
  // a^2 = R delta: the paper's contact radius is a bite of 0.0754 um.
  const double a = 0.01 * kSaw.pitch_mm();
  const double bite = a * a / kSaw.radius_mm();
  EXPECT_NEAR(bite, 7.54e-5, 1e-7);
  EXPECT_NEAR(MakeToothForce(Law(ForceLawKind::kHertzChip), kSaw)(bite, kEStar24),
              MakeToothForce(Law(ForceLawKind::kHertzConstantBite), kSaw)(1, kEStar24), 1e-12);
}

TEST(Force, ScalesExactlyWithModulusBiteAndRadius) {
  ForceLaw law = Law(ForceLawKind::kHertzChip);
  const double base = MakeToothForce(law, kSaw)(1e-3, 10000);
  EXPECT_NEAR(MakeToothForce(law, kSaw)(1e-3, 20000) / base, 2, 1e-12);
  EXPECT_NEAR(MakeToothForce(law, kSaw)(2e-3, 10000) / base, std::pow(2, 1.5), 1e-12);
  law.contact_radius_mm = 4 * 11;
  EXPECT_NEAR(MakeToothForce(law, kSaw)(1e-3, 10000) / base, 2, 1e-12);
  ForceLaw constant = Law(ForceLawKind::kHertzConstantBite);
  const double paper = MakeToothForce(constant, kSaw)(1e-3, 10000);
  EXPECT_EQ(MakeToothForce(constant, kSaw)(9e-3, 10000), paper);  // whatever the bite
  constant.contact_share_of_pitch = 0.02;
  EXPECT_NEAR(MakeToothForce(constant, kSaw)(1e-3, 10000) / paper, 8, 1e-12);
}

TEST(Force, NoBiteNoForce) {
  for (const ForceLawKind kind : {ForceLawKind::kHertzChip, ForceLawKind::kHertzConstantBite}) {
    EXPECT_EQ(MakeToothForce(Law(kind), kSaw)(0, kEStar24), 0);
    EXPECT_EQ(MakeToothForce(Law(kind), kSaw)(-1e-3, kEStar24), 0);
  }
}

TEST(Force, ParametersOutOfRangeAreRefused) {
  ForceLaw law;
  law.contact_radius_mm = -1;
  EXPECT_THROW(MakeToothForce(law, kSaw), Error);
  law = {};
  law.contact_share_of_pitch = 0;
  EXPECT_THROW(MakeToothForce(law, kSaw), Error);
  law.contact_share_of_pitch = std::nan("");
  EXPECT_THROW(MakeToothForce(law, kSaw), Error);
}

TEST(Saw, PitchIsThePapers) {
  EXPECT_NEAR(kSaw.pitch_mm(), 2.87979, 1e-5);
}

TEST(Saw, EachValueOutOfRangeIsNamed) {
  const auto message = [](auto change) {
    DiscSaw saw;
    change(saw);
    try {
      saw.Validate();
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](DiscSaw& s) { s.thickness_mm = -0.1; }),
            "thickness_mm = -0.1 is out of range; valid range 0.02 to 10");
  EXPECT_EQ(message([](DiscSaw& s) { s.teeth = 0; }), "teeth = 0 is out of range; valid range 1 to 1000");
  EXPECT_EQ(message([](DiscSaw& s) { s.nu = 0.51; }), "nu = 0.51 is out of range; valid range 0 to 0.5");
  EXPECT_EQ(message([](DiscSaw& s) { s.diameter_mm = std::nan(""); }),
            "diameter_mm = nan is out of range; valid range 1 to 200");
  EXPECT_EQ(message([](DiscSaw& s) { s.nu = 0.5; }), "accepted");
}

}  // namespace
}  // namespace kerf
