// The drive of a stroke, compared with brute force over single teeth and with closed forms.
#include "cut/tool/drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace kerf {
namespace {

constexpr double kPi = std::numbers::pi;

Drive MakeDrive(double pitch_mm, double stroke_mm) {
  ReciprocatingBlade blade;
  blade.pitch_mm = pitch_mm;
  blade.stroke_mm = stroke_mm;
  return Drive(blade);
}

/// Time since any tooth of a long row last passed the place where a tooth is now, from times of passing alone: tooth k
/// is at k pitch + stroke / 2 sin(phase). As a phase.
double FindSincePassed(double pitch_mm, double stroke_mm, double phase_rad) {
  const double place_mm = 0.5 * stroke_mm * std::sin(phase_rad);
  double latest = -std::numeric_limits<double>::infinity();
  for (int k = -60; k <= 60; ++k) {
    const double sine = (place_mm - k * pitch_mm) / (0.5 * stroke_mm);
    if (std::abs(sine) > 1) continue;
    const double rising = std::asin(sine);
    for (const double at : {rising, kPi - rising}) {
      // The last time before now at which this tooth is at the place.
      const double before = at + 2 * kPi * std::floor((phase_rad - 1e-9 - at) / (2 * kPi));
      latest = std::max(latest, before);
    }
  }
  return phase_rad - latest;
}

TEST(Drive, RotationHasNoStroke) {
  EXPECT_FALSE(Drive(DiscSaw{}).strokes());
  EXPECT_FALSE(Drive(BallBurr{}).strokes());
  EXPECT_TRUE(Drive(ReciprocatingBlade{}).strokes());
}

TEST(Drive, RangeHoldsTheExtremesOfThePart) {
  const Drive drive = MakeDrive(1.41, 3);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  for (int n = 0; n < 300; ++n) {
    const double from = 2 * kPi * number(random);
    const double advance = 8 * number(random) * number(random);
    double least = 1e9, most = -1e9, way = 0;
    constexpr int kSteps = 20000;
    double last = drive.CalcDisplacement(from);
    for (int i = 0; i <= kSteps; ++i) {
      const double s = 1.5 * std::sin(from + advance * i / kSteps);
      least = std::min(least, s);
      most = std::max(most, s);
      way += std::abs(s - last);
      last = s;
    }
    const SlideRange range = drive.CalcRange(from, advance);
    const double step = advance / kSteps;
    EXPECT_NEAR(range.least_mm, least, 1.5 * step * step);  // a turn lies between two samples
    EXPECT_LE(range.least_mm, least + 1e-12);
    EXPECT_NEAR(range.most_mm, most, 1.5 * step * step);
    EXPECT_GE(range.most_mm, most - 1e-12);
    EXPECT_NEAR(drive.CalcWay(from, advance), way, 1e-5);
  }
}

TEST(Drive, TimeSinceAPlaceWasPassedIsThatOfSingleTeeth) {
  for (const double pitch : {0.2, 0.7, 1.41, 2.9, 4.0}) {
    const Drive drive = MakeDrive(pitch, 3);
    double whole = 0;
    constexpr int kParts = 400;
    for (int i = 0; i < kParts; ++i) {
      const double from = 2 * kPi * i / kParts;
      constexpr int kSteps = 50;
      double mean = 0, jump = 0, last = 0;
      for (int k = 0; k < kSteps; ++k) {
        const double since = FindSincePassed(pitch, 3, from + 2 * kPi / kParts * (k + 0.5) / kSteps);
        mean += since / kSteps;
        if (k > 0) jump = std::max(jump, std::abs(since - last));
        last = since;
      }
      const double got = drive.CalcMeanSincePassed(from, 2 * kPi / kParts);
      // Midpoint rule; it is off by at most a jump in one of the steps.
      EXPECT_NEAR(got, mean, 2e-4 + jump / kSteps) << pitch << " " << i;
      EXPECT_GT(got, 0);
      whole += mean / kParts;
    }
    EXPECT_NEAR(drive.CalcMeanSincePassed(0.3, 2 * kPi) / whole, 1, 2e-4) << pitch;
    EXPECT_NEAR(drive.CalcMeanSincePassed(1.1, 20 * kPi) / whole, 1, 2e-4) << pitch;
  }
}

TEST(Drive, BiteTimesWayOfAStrokeIsPitchTimesTheFeedOfHalfAPeriod) {
  // In short parts; bite = feed speed / passes_per_s.
  constexpr double kRpm = 1200, kFeed_mm_per_s = 2;
  for (const double pitch : {0.3, 1.41, 2.99}) {
    const Drive drive = MakeDrive(pitch, 3);
    constexpr int kParts = 20000;
    const double part_s = 0.5 * 60 / kRpm / kParts;
    double sum_mm2 = 0;
    for (int i = 0; i < kParts; ++i) {
      const double phase_rad = -0.5 * kPi + kPi * i / kParts;
      sum_mm2 += kFeed_mm_per_s / drive.CalcBites(phase_rad, kRpm, part_s, part_s).passes_per_s *
                 drive.CalcStep(phase_rad, kRpm, part_s, part_s).speed_mm_per_s * part_s;
    }
    EXPECT_NEAR(sum_mm2 / (pitch * kFeed_mm_per_s * 0.5 * 60 / kRpm), 1, 1e-4) << pitch;
  }
}

TEST(Drive, BiteOverTheWayIsThatOfSingleTeeth) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(0, 1);
  for (const double pitch : {0.2, 0.7, 1.41, 2.9, 4.0}) {
    const Drive drive = MakeDrive(pitch, 3);
    for (int n = 0; n < 20; ++n) {
      const double from = 2 * kPi * number(random);
      const double advance = 0.05 + 8 * number(random) * number(random);
      constexpr int kSteps = 4000;
      double in_time = 0, on_way = 0, way = 0;
      for (int k = 0; k < kSteps; ++k) {
        const double phase = from + advance * (k + 0.5) / kSteps;
        const double since = FindSincePassed(pitch, 3, phase);
        in_time += since;
        on_way += since * std::abs(std::cos(phase));
        way += std::abs(std::cos(phase));
      }
      // Midpoint rule, as above.
      EXPECT_NEAR(drive.CalcWayBite(from, advance), on_way / way / (in_time / kSteps), 2e-3) << pitch << " " << n;
    }
  }
  // A short part has one bite; right after a turn it grows with the time: 2 int t^2 dt / (int t dt)^2 = 4/3.
  EXPECT_NEAR(MakeDrive(1.41, 3).CalcWayBite(0.3, 1e-4), 1, 1e-4);
  EXPECT_NEAR(MakeDrive(1.41, 3).CalcWayBite(0.5 * kPi, 2e-3), 4.0 / 3, 1e-4);
  EXPECT_EQ(MakeDrive(1.41, 3).CalcWayBite(0.5 * kPi, 1e-5), 1);  // the edge does not move
}

TEST(Drive, WorkOfAStrokeDoesNotDependOnItsParts) {
  // Bite over the way times way, summed over a stroke, in few parts: pitch times the feed of half a period, as above,
  // up to the rule that integrates the bite over the time (below 1e-6).
  for (const double pitch : {0.3, 1.41, 2.99}) {
    const Drive drive = MakeDrive(pitch, 3);
    const auto bite_times_speed = [&](double phase_rad, double rpm, double time_s) {
      const StrokeBites bites = drive.CalcBites(phase_rad, rpm, time_s, 1e-3);
      double way_bite = 0;
      for (const BitePart& part : bites.span()) way_bite += part.way_share * part.way_bite;
      return way_bite / bites.passes_per_s * drive.CalcStep(phase_rad, rpm, time_s, 1e-3).speed_mm_per_s;
    };
    for (int parts = 1; parts < 9; ++parts) {
      double sum_mm = 0;
      for (int i = 0; i < parts; ++i) {
        sum_mm += bite_times_speed(0.4 + 2 * kPi * i / parts, 1200, 0.05 / parts) * 0.05 / parts;
      }
      EXPECT_NEAR(sum_mm / (pitch * 0.05), 1, 2e-6) << pitch << " " << parts;
    }
    EXPECT_NEAR(bite_times_speed(0.4, 31000, 5e-4) / pitch, 1, 2e-6);
    // In a hand: the mean over a whole stroke.
    EXPECT_NEAR(drive.CalcPassRate(1200) * pitch, 2 * 3 * 20, 1e-9);
  }
}

TEST(Drive, BiteIsZeroRightAfterATurnAndAStrokeIsNotAveraged) {
  const Drive drive = MakeDrive(1.41, 3);
  // 15000 double strokes a minute and ticks of 1 ms: four ticks to a period.
  EXPECT_GT(drive.CalcBites(0.5 * kPi, 15000, 1e-6, 1e-3).passes_per_s, 1e5);
  const DriveStep tick = drive.CalcStep(0, 15000, 1e-3, 1e-3);
  EXPECT_NEAR(tick.range.least_mm, 0, 1e-12);
  EXPECT_NEAR(tick.range.most_mm, 1.5, 1e-12);
  EXPECT_NEAR(tick.speed_mm_per_s, 1500, 1e-9);
  EXPECT_NEAR(tick.middle_mm, 1.5 * std::sin(0.25 * kPi), 1e-12);
  // Above half the tick rate: the mean, whatever the phase.
  for (const double phase : {0.0, 1.0, 4.0}) {
    const DriveStep mean = drive.CalcStep(phase, 31000, 5e-4, 1e-3);
    EXPECT_EQ(mean.range.least_mm, -1.5);
    EXPECT_EQ(mean.range.most_mm, 1.5);
    EXPECT_EQ(mean.middle_mm, 0);
    EXPECT_NEAR(mean.speed_mm_per_s, 2 * 3 * 31000 / 60.0, 1e-9);
    const double passes_per_s = drive.CalcBites(phase, 31000, 5e-4, 1e-3).passes_per_s;
    EXPECT_NEAR(passes_per_s * drive.CalcMeanSincePassed(0, 2 * kPi), 2 * kPi * 31000 / 60, 1e-6);
  }
}

TEST(Drive, AToothThatDoesNotReachTheNextPassesItsPlacesTwiceAPeriod) {
  const Drive drive = MakeDrive(4, 3);
  EXPECT_EQ(drive.CalcPassRate(1200), 2 * 20);
  EXPECT_NEAR(drive.CalcBites(0, 1200, 0.05, 1).passes_per_s, 2 * 20, 1e-9);
}

TEST(Drive, PhaseReturnsAfterAPeriodAndHasNoDirection) {
  EXPECT_NEAR(Drive::Advance(1, 1200, 0.0125), 1 + 0.5 * kPi, 1e-12);
  EXPECT_NEAR(Drive::Advance(1, 1200, 0.05), 1, 1e-9);
  EXPECT_EQ(Drive::Advance(1, -1200, 0.01), Drive::Advance(1, 1200, 0.01));
}

}  // namespace
}  // namespace kerf
