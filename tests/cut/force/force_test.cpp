#include "kerf/force.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kerf/error.h"
#include "kerf/material.h"
#include "support/message_of.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

const double kEStar24 = CalcReducedModulus(205000, 0.28, 19300, 0.28);

TEST(Force, ConstantBiteIsThePapersForceOnOneTooth) {
  // Tables 3 to 6 of the paper at 1.1 mm, where one tooth cuts: region 24 and the other three, as printed, to five
  // decimals.
  const ToothForce force = MakeToothForce(ForceLaw("hertz_constant_bite"), kSaw);
  const auto newton = [&](double E, double nu) {
    return force(1e-3, Cortical(CalcReducedModulus(205000, 0.28, E, nu)));
  };
  EXPECT_NEAR(newton(19300, 0.28), 0.05541, 1e-5);
  EXPECT_NEAR(newton(20500, 0.25), 0.05763, 1e-5);
  EXPECT_NEAR(newton(19300, 0.25), 0.05455, 1e-5);
  EXPECT_NEAR(newton(17300, 0.38), 0.05365, 1e-5);
}

TEST(Force, ChipLawMatchesTheReferenceForce) {
  // As in docs/physics.md: with R = 11 mm in region 24, 10.6 N per tooth at 2.5 um and 84 N at 10 um.
  const ToothForce force = MakeToothForce(ForceLaw("hertz_chip"), kSaw);
  EXPECT_NEAR(force(2.5e-3, Cortical(kEStar24)), 10.6, 0.05);
  EXPECT_NEAR(force(10e-3, Cortical(kEStar24)), 84.6, 0.5);
}

TEST(Force, ConstantBiteEqualsTheChipLawAtItsOwnDepth) {
  // Since a^2 = R delta, the paper's contact radius corresponds to a bite of 0.0754 um.
  const double a = 0.01 * kSaw.pitch_mm();
  const double bite = a * a / kSaw.radius_mm();
  EXPECT_NEAR(bite, 7.54e-5, 1e-7);
  EXPECT_NEAR(MakeToothForce(ForceLaw("hertz_chip"), kSaw)(bite, Cortical(kEStar24)),
              MakeToothForce(ForceLaw("hertz_constant_bite"), kSaw)(1, Cortical(kEStar24)), 1e-12);
}

TEST(Force, ScalesExactlyWithModulusBiteAndRadius) {
  ForceLaw law = ForceLaw("hertz_chip");
  const double base = MakeToothForce(law, kSaw)(1e-3, Cortical(10000));
  EXPECT_NEAR(MakeToothForce(law, kSaw)(1e-3, Cortical(20000)) / base, 2, 1e-12);
  EXPECT_NEAR(MakeToothForce(law, kSaw)(2e-3, Cortical(10000)) / base, std::pow(2, 1.5), 1e-12);
  law.Set("contact_radius_mm", 4 * 11);
  EXPECT_NEAR(MakeToothForce(law, kSaw)(1e-3, Cortical(10000)) / base, 2, 1e-12);
  ForceLaw constant = ForceLaw("hertz_constant_bite");
  const double paper = MakeToothForce(constant, kSaw)(1e-3, Cortical(10000));
  EXPECT_EQ(MakeToothForce(constant, kSaw)(9e-3, Cortical(10000)), paper);  // does not depend on the bite
  constant.Set("contact_share_of_pitch", 0.02);
  EXPECT_NEAR(MakeToothForce(constant, kSaw)(1e-3, Cortical(10000)) / paper, 8, 1e-12);
}

TEST(Force, EdgePlusChipIsTheLineThroughTheMeasuredThrust) {
  // Resultants of 8 and 11 N at 2.5 and 10 um, of which 0.848 is thrust at a thrust / cutting ratio of 1.6, for a tooth
  // of 0.64 mm: 6.784 and 9.328 N. The defaults are rounded to three digits, hence 0.2 %.
  DiscSaw tested;
  tested.thickness_mm = 0.64;
  const ToothForce force = MakeToothForce(ForceLaw("edge_plus_chip"), tested);
  const double fraction = 1.6 / std::sqrt(1 + 1.6 * 1.6);
  EXPECT_NEAR(force(2.5e-3, Cortical(kEStar24)) / (8 * fraction), 1, 2e-3);
  EXPECT_NEAR(force(10e-3, Cortical(kEStar24)) / (11 * fraction), 1, 2e-3);
  // Computed by hand for the saw's own 0.25 mm at 1 um: 0.25 (9.28 + 530 * 0.001) = 2.4525 N, at E* = 19140 MPa.
  EXPECT_NEAR(MakeToothForce(ForceLaw("edge_plus_chip"), kSaw)(1e-3, Cortical(19140)), 2.4525, 1e-12);
  // The reference E* is that of steel on region 24, to the digits given.
  EXPECT_NEAR(kEStar24, 19140, 0.5);
  // Even the smallest bite has the full edge force.
  EXPECT_NEAR(MakeToothForce(ForceLaw("edge_plus_chip"), kSaw)(1e-12, Cortical(19140)), 0.25 * 9.28, 1e-9);
}

TEST(Force, ParametersOutOfRangeAreRefused) {
  for (const ForceLawInfo* info : ForceLaws()) {
    for (const LawParameter& p : info->parameters) {
      for (const double bad : {std::nextafter(p.lower, -1e300), std::nextafter(p.upper, 1e300), std::nan("")}) {
        ForceLaw law(info->name);
        law.Set(p.key, bad);
        EXPECT_THROW(MakeToothForce(law, kSaw), Error) << info->name << " " << p.key << " " << bad;
      }
    }
  }
  ForceLaw law("hertz_chip");
  law.Set("contact_radius_mm", -1);
  EXPECT_EQ(test::MessageOf([&] { MakeToothForce(law, kSaw); }),
            "contact_radius_mm = -1 is below 0; valid range 0 to 1000 mm");
}

TEST(Force, UnknownLawAndAnotherLawsParameterAreNamed) {
  EXPECT_EQ(test::MessageOf([] { ForceLaw("herz_chip"); }),
            "there is no force law \"herz_chip\"; available: two_component, hertz_chip, hertz_constant_bite, "
            "edge_plus_chip, tabulated");
  EXPECT_EQ(test::MessageOf([] { ForceLaw("hertz_chip").Set("edge_N_per_mm", 1); }),
            "the force law hertz_chip has no parameter edge_N_per_mm; it has contact_radius_mm");
}

TEST(Saw, PitchMatchesThePaper) {
  EXPECT_NEAR(kSaw.pitch_mm(), 2.87979, 1e-5);
}

TEST(Saw, EachValueOutOfRangeIsNamed) {
  const auto message = [](auto change) {
    DiscSaw saw;
    change(saw);
    return test::MessageOf([&] { saw.Validate(); }, "accepted");
  };
  EXPECT_EQ(message([](DiscSaw& s) { s.thickness_mm = -0.1; }),
            "thickness_mm = -0.1 is below 0.02; valid range 0.02 to 10 mm");
  EXPECT_EQ(message([](DiscSaw& s) { s.teeth = 0; }), "teeth = 0 is below 1; valid range 1 to 1000");
  EXPECT_EQ(message([](DiscSaw& s) { s.nu = 0.51; }), "nu = 0.51 is above 0.5; valid range 0 to 0.5");
  EXPECT_EQ(message([](DiscSaw& s) { s.diameter_mm = std::nan(""); }),
            "diameter_mm = nan is not a finite number; valid range 1 to 200 mm");
  EXPECT_EQ(message([](DiscSaw& s) { s.nu = 0.5; }), "accepted");
}

}  // namespace
}  // namespace kerf
