// The paper's law: compared with closed forms, and with its inputs changed in ways whose effect is known exactly.
#include "kerf/paper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "kerf/material.h"

namespace kerf {
namespace {

constexpr PaperReading kReadings[] = {PaperReading::kAsComputed, PaperReading::kCorrected};

// Inputs of the law.
struct Input {
  DiscSaw saw;
  double fraction = 0.01;
  double depth_mm = 0;
  double E_MPa = 0;
  double nu = 0;
};

double Force(const Input& in, PaperReading reading) {
  return CalcPaperForce(in.saw, in.fraction, in.depth_mm, in.E_MPa, in.nu, reading);
}

// Calls `check` for discs of several sizes, steels and tooth counts, at depths up to that of the buried disc, in soft
// and in hard bone.
void ForManyInputs(const std::function<void(const Input&)>& check) {
  for (const double diameter : {8.0, 22.0, 30.0, 101.3}) {
    for (const int teeth : {7, 24, 60}) {
      for (const double E_saw : {205000.0, 70000.0}) {
        for (const double fraction_of_depth : {0.013, 0.05, 0.1, 0.3, 0.5, 0.77, 1.0}) {
          for (const double E : {350.0, 19300.0}) {
            Input in;
            in.saw.diameter_mm = diameter;
            in.saw.teeth = teeth;
            in.saw.E_MPa = E_saw;
            in.depth_mm = fraction_of_depth * diameter;
            in.E_MPa = E;
            in.nu = E < 1000 ? 0.3 : 0.25;
            check(in);
          }
        }
      }
    }
  }
}

// Expects a / b = factor except for the rounding errors of a dozen operations.
void ExpectFactor(double a, double b, double factor) {
  ASSERT_TRUE(std::isfinite(a) && std::isfinite(b));
  EXPECT_NEAR(a, factor * b, 1e-13 * std::abs(factor * b));
}

// Returns the length of the lower right part of the circle up to depth h as the sum of n chords, which are denser near
// the lowest point, where the depth changes slowly along the rim.
double SumChords(double h, double diameter, int n) {
  double sum = 0;
  double x0 = 0;
  double y0 = 0;
  for (int i = 1; i <= n; ++i) {
    const double step = static_cast<double>(i) / n;
    const double y = h * step * step;
    const double x = std::sqrt(std::max(0.0, y * (diameter - y)));
    sum += std::hypot(x - x0, y - y0);
    x0 = x, y0 = y;
  }
  return sum;
}

TEST(PaperArc, TrueArcIsTheLengthOfTheCircleBelowTheSurface) {
  for (const double diameter : {5.0, 22.0, 30.0}) {
    for (const double fraction : {0.001, 0.05, 0.25, 0.3, 0.5, 0.7}) {
      const double h = fraction * diameter;
      const double arc = CalcTrueArc(h, diameter);
      // The chords' error is proportional to the square of their length.
      const double coarse = arc - SumChords(h, diameter, 50);
      const double fine = arc - SumChords(h, diameter, 100);
      EXPECT_GT(fine, 0);
      EXPECT_NEAR(coarse / fine, 4, 0.02) << diameter << " " << fraction;
      EXPECT_NEAR(SumChords(h, diameter, 5000) / arc, 1, 1e-7) << diameter << " " << fraction;
    }
  }
}

TEST(PaperArc, TrueArcHasTheKnownValues) {
  EXPECT_NEAR(CalcTrueArc(5.5, 22), std::numbers::pi * 22 / 6,
              1e-13);  // a sixth of the rim at a quarter of the diameter
  EXPECT_NEAR(CalcTrueArc(11, 22), std::numbers::pi * 22 / 4, 1e-13);
  EXPECT_NEAR(CalcTrueArc(22, 22), std::numbers::pi * 22 / 2,
              1e-13);  // half of the rim, which is what a level feed engages of a buried disc
  // At shallow depths the arc is sqrt(d h) (1 + h / (6 d) + ...), where the next term is 3/40 (h/d)^2. acos loses
  // digits near 1.
  for (const double h : {1e-3, 1e-2, 1e-1}) {
    EXPECT_NEAR(CalcTrueArc(h, 22) / (std::sqrt(22 * h) * (1 + h / 132)), 1, 0.08 * (h / 22) * (h / 22) + 1e-11) << h;
  }
}

TEST(PaperArc, PapersArcIsTheTrueOneOfADiscTwiceAsLargeAtHalfTheDepth) {
  ForManyInputs([](const Input& in) {
    const double d = in.saw.diameter_mm;
    EXPECT_NEAR(CalcPaperArc(in.depth_mm, d), CalcTrueArc(0.5 * in.depth_mm, 2 * d), 1e-12 * d);
    EXPECT_LT(CalcPaperArc(in.depth_mm, d), CalcTrueArc(in.depth_mm, d));
  });
  EXPECT_NEAR(CalcPaperArc(22, 22), std::numbers::pi * 22 / 3,
              1e-13);  // a third of the buried disc's rim: 8 of 24 pitches
}

TEST(PaperArc, DepthIsClampedBetweenTheSurfaceAndTheBuriedDisc) {
  for (const double above : {0.0, -1e-9, -3.0, -std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(CalcPaperArc(above, 22), 0);
    EXPECT_EQ(CalcTrueArc(above, 22), 0);
  }
  for (const double beyond : {22.0, 22.001, 1e9, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(CalcPaperArc(beyond, 22), CalcPaperArc(22, 22));
    EXPECT_EQ(CalcTrueArc(beyond, 22), CalcTrueArc(22, 22));
  }
}

TEST(PaperTeeth, EachToothEngagesWhereTheArcReachesItsPitch) {
  const DiscSaw saw;
  const double d = saw.diameter_mm;
  for (int n = 1; n <= 8; ++n) {
    // The depths follow from arc = n pitch.
    const double paper = 2 * d * (1 - std::cos(n * saw.pitch_mm() / d));
    EXPECT_EQ(CalcPaperTeeth(saw, paper - 1e-6, PaperReading::kAsComputed), n - 1);
    EXPECT_EQ(CalcPaperTeeth(saw, paper, PaperReading::kAsComputed), n);
    EXPECT_EQ(CalcPaperTeeth(saw, paper + 1e-6, PaperReading::kAsComputed), n);
    const double corrected = 0.5 * d * (1 - std::cos(2 * n * saw.pitch_mm() / d));
    EXPECT_NEAR(CalcPaperTeeth(saw, corrected, PaperReading::kCorrected), n, 1e-12);
  }
}

TEST(PaperTeeth, BuriedDiscEngagesAThirdOfItsTeethByThePapersArcAndHalfByTheTrueOne) {
  for (const int teeth : {6, 12, 18, 24, 36, 48, 60, 90, 300, 999}) {
    for (const double diameter : {1.0, 8.0, 22.0, 30.0, 101.3}) {
      DiscSaw saw;
      saw.teeth = teeth;
      saw.diameter_mm = diameter;
      EXPECT_EQ(CalcPaperTeeth(saw, diameter, PaperReading::kAsComputed), teeth / 3) << teeth << " " << diameter;
      EXPECT_NEAR(CalcPaperTeeth(saw, diameter, PaperReading::kCorrected), 0.5 * teeth, 1e-11) << teeth;
    }
  }
}

TEST(PaperForce, IsHertzsForceOfTheSphereOnTheHalfSpace) {
  // F = 4/3 E* a^3 / R, with the reduced modulus of material.h.
  ForManyInputs([](const Input& in) {
    const double a = in.fraction * in.saw.pitch_mm();
    const double E_star = CalcReducedModulus(in.saw.E_MPa, in.saw.nu, in.E_MPa, in.nu);
    ExpectFactor(CalcPaperToothForce(in.saw, in.fraction, in.E_MPa, in.nu), E_star * a * a * a / in.saw.radius_mm(),
                 4.0 / 3);
  });
}

TEST(PaperForce, NTeethGiveNCubedTimesTheForceOfOneAsComputedAndNTimesCorrected) {
  ForManyInputs([](const Input& in) {
    const double F_1 = CalcPaperToothForce(in.saw, in.fraction, in.E_MPa, in.nu);
    const double whole = CalcPaperTeeth(in.saw, in.depth_mm, PaperReading::kAsComputed);
    EXPECT_EQ(whole, std::floor(whole));
    ExpectFactor(Force(in, PaperReading::kAsComputed), F_1, whole * whole * whole);
    const double arc = 0.5 * in.saw.diameter_mm * std::acos(1 - 2 * in.depth_mm / in.saw.diameter_mm);
    ExpectFactor(Force(in, PaperReading::kCorrected), F_1, arc / in.saw.pitch_mm());
  });
}

TEST(PaperForce, DoubledModuliOfBothBodiesDoubleIt) {
  ForManyInputs([](const Input& in) {
    Input harder = in;
    harder.saw.E_MPa *= 2;
    harder.E_MPa *= 2;
    for (const PaperReading reading : kReadings) ExpectFactor(Force(harder, reading), Force(in, reading), 2);
  });
}

TEST(PaperForce, DoubledFractionOfThePitchMakesItEightTimesAsLarge) {
  ForManyInputs([](const Input& in) {
    Input wider = in;
    wider.fraction *= 2;
    for (const PaperReading reading : kReadings) ExpectFactor(Force(wider, reading), Force(in, reading), 8);
  });
}

TEST(PaperForce, DoubledTeethQuarterTheCorrectedForce) {
  // Half the pitch means an eighth of the force on each of twice as many teeth. With the paper's law as computed, n
  // whole teeth become n' and the force changes by (n'/n)^3 / 8: not at all where n' = 2 n.
  int unchanged = 0;
  ForManyInputs([&](const Input& in) {
    Input finer = in;
    finer.saw.teeth *= 2;
    ExpectFactor(Force(finer, PaperReading::kCorrected), Force(in, PaperReading::kCorrected), 0.25);
    const double n = CalcPaperTeeth(in.saw, in.depth_mm, PaperReading::kAsComputed);
    const double n2 = CalcPaperTeeth(finer.saw, in.depth_mm, PaperReading::kAsComputed);
    EXPECT_TRUE(n2 == 2 * n || n2 == 2 * n + 1) << n << " " << n2;
    if (n == 0) return;
    const double ratio = n2 / n;
    ExpectFactor(Force(finer, PaperReading::kAsComputed), Force(in, PaperReading::kAsComputed),
                 ratio * ratio * ratio / 8);
    unchanged += n2 == 2 * n ? 1 : 0;
  });
  EXPECT_GT(unchanged, 50);
}

TEST(PaperForce, IsTheSameInMetresAndPascals) {
  ForManyInputs([](const Input& in) {
    Input si = in;  // contains metres in the fields named mm and Pa in those named MPa
    si.saw.diameter_mm *= 1e-3;
    si.depth_mm *= 1e-3;
    si.saw.E_MPa *= 1e6;
    si.E_MPa *= 1e6;
    ExpectFactor(CalcHertzK(si.saw, si.E_MPa, si.nu), CalcHertzK(in.saw, in.E_MPa, in.nu), 1e-3);
    for (const PaperReading reading : kReadings) ExpectFactor(Force(si, reading), Force(in, reading), 1);
  });
}

TEST(PaperForce, DoubledLengthsMakeItFourTimesAsLarge) {
  ForManyInputs([](const Input& in) {
    Input larger = in;
    larger.saw.diameter_mm *= 2;
    larger.depth_mm *= 2;
    for (const PaperReading reading : kReadings) ExpectFactor(Force(larger, reading), Force(in, reading), 4);
  });
}

TEST(PaperForce, DoesNotDependOnWhichBodyIsWhich) {
  ForManyInputs([](const Input& in) {
    Input swapped = in;
    swapped.saw.E_MPa = in.E_MPa;
    swapped.saw.nu = in.nu;
    swapped.E_MPa = in.saw.E_MPa;
    swapped.nu = in.saw.nu;
    for (const PaperReading reading : kReadings) ExpectFactor(Force(swapped, reading), Force(in, reading), 1);
  });
}

TEST(PaperForce, NeverFallsWithDepthAndIsZeroAboveTheBone) {
  Input in;
  in.E_MPa = 19300;
  in.nu = 0.28;
  for (const PaperReading reading : kReadings) {
    in.depth_mm = -1;
    EXPECT_EQ(Force(in, reading), 0);
    double last = 0;
    for (int i = 0; i <= 4600; ++i) {
      in.depth_mm = 0.005 * i;
      const double force = Force(in, reading);
      ASSERT_GE(force, last) << in.depth_mm;
      // The corrected force is smooth: it increases strictly until the disc is buried.
      if (reading == PaperReading::kCorrected && i > 0 && in.depth_mm < 22) {
        ASSERT_GT(force, last) << in.depth_mm;
      }
      last = force;
    }
  }
}

TEST(PaperForce, GrowsWithStiffnessAndPoissonsRatio) {
  Input in;
  in.depth_mm = 3;
  in.E_MPa = 19300;
  in.nu = 0.28;
  for (const PaperReading reading : kReadings) {
    const double base = Force(in, reading);
    Input stiffer = in;
    stiffer.E_MPa *= 1.01;
    EXPECT_GT(Force(stiffer, reading), base);
    stiffer = in;
    stiffer.nu += 0.01;
    EXPECT_GT(Force(stiffer, reading), base);
    stiffer = in;
    stiffer.saw.E_MPa *= 1.01;
    EXPECT_GT(Force(stiffer, reading), base);
  }
}

TEST(PaperForce, NaNInGivesNaNOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Input in;
  in.depth_mm = 3;
  in.E_MPa = 19300;
  in.nu = 0.28;
  for (double Input::*field : {&Input::depth_mm, &Input::E_MPa, &Input::nu, &Input::fraction}) {
    Input bad = in;
    bad.*field = nan;
    for (const PaperReading reading : kReadings) EXPECT_TRUE(std::isnan(Force(bad, reading)));
  }
}

TEST(PaperReading, NamesRoundTrip) {
  for (const PaperReading reading : kReadings) EXPECT_EQ(PaperReadingFromString(ToString(reading)), reading);
  EXPECT_FALSE(PaperReadingFromString("as computed").has_value());
  EXPECT_FALSE(PaperReadingFromString("").has_value());
}

}  // namespace
}  // namespace kerf
