// Tests that the text of a report agrees with its numbers, with made-up results whose conclusions are known.
#include "experiment/compare/conclusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "made_up.h"

namespace kerf {
namespace {

using test::MadeUpCase;
using test::MakeUp;
using ::testing::HasSubstr;
using ::testing::Not;

std::string AllOf(const std::vector<std::string>& statements) {
  std::string text;
  for (const std::string& s : statements) text += s + "\n";
  return text;
}

MadeUpCase Reference() {
  MadeUpCase made;
  made.label = "voxel A";
  made.force_N = [](double) { return 4.0; };
  return made;
}

MadeUpCase Slab(std::function<double(double)> force_N) {
  MadeUpCase made;
  made.label = "slab B";
  made.slab = true;
  made.force_N = std::move(force_N);
  made.p50_us = 0.5;
  made.p99_us = 0.6;
  made.memory_bytes = 2000;
  made.work_mJ = 25;
  return made;
}

std::string ForceWords(const MadeUpCase& slab) {
  return AllOf(WriteConclusion(MakeUp({Reference(), slab})).force);
}

TEST(Conclusion, LargerAndSmallerForcesAreReported) {
  const std::string more = ForceWords(Slab([](double) { return 12.0; }));
  EXPECT_THAT(more, HasSubstr("**slab B** requires 3.00 times the force of voxel A"));
  EXPECT_THAT(more, HasSubstr("12.0 N against 4.00 N, rms difference 8.00 N, which is 200 % of the reference's peak"));
  EXPECT_THAT(more, HasSubstr("The force is larger at every depth."));
  const std::string less = ForceWords(Slab([](double) { return 1.0; }));
  EXPECT_THAT(less, HasSubstr("**slab B** requires 25.0 % of the force of voxel A"));
  EXPECT_THAT(less, HasSubstr("The force is smaller at every depth."));
  EXPECT_THAT(less, Not(HasSubstr("larger at")));
}

TEST(Conclusion, DepthOfTheLastCrossingIsThatOfTheCurves) {
  // The force rises from 0 to 10 N over 10 mm and is compared with 4 N, so the curves cross at 4 mm.
  const std::string up = ForceWords(Slab([](double h) { return h; }));
  EXPECT_THAT(up, HasSubstr("The force is larger over 60 % of the depth and smaller over 40 %; beyond 4.00 mm it stays "
                            "larger"));
  const std::string down = ForceWords(Slab([](double h) { return 10 - h; }));
  EXPECT_THAT(down, HasSubstr("larger over 60 % of the depth and smaller over 40 %; beyond 6.00 mm it stays smaller"));
}

TEST(Conclusion, EqualDepthsCountAsNeitherLargerNorSmaller) {
  // Both forces are zero over the first and the last millimetre of 10. The other 80 of 100 depths differ, all with the
  // same sign.
  const auto ends = [](double force_N) { return [force_N](double h) { return h < 1 || h > 9 ? 0.0 : force_N; }; };
  MadeUpCase reference = Reference();
  reference.force_N = ends(4);
  const auto words = [&](const std::function<double(double)>& force_N) {
    return AllOf(WriteConclusion(MakeUp({reference, Slab(force_N)})).force);
  };
  EXPECT_THAT(words(ends(1)), HasSubstr("The force is smaller wherever the two differ, at 80 of the 100 depths."));
  EXPECT_THAT(words(ends(9)), HasSubstr("The force is larger wherever the two differ, at 80 of the 100 depths."));
  EXPECT_THAT(words(ends(9)), Not(HasSubstr("every depth")));
  // The force is smaller over 1 to 3 mm, then larger up to 9 mm.
  EXPECT_THAT(words([](double h) { return h < 1 || h > 9 ? 0.0
                                          : h < 3        ? 1.0
                                                         : 9.0; }),
              HasSubstr("The force is larger over 60 % of the depth and smaller over 20 %; beyond 3.00 mm it is larger "
                        "wherever the two differ."));
  // A difference counts as soon as the table shows it. One of 100 depths is 1 %, and 99 of 100 are not reported as all.
  EXPECT_THAT(ForceWords(Slab([](double h) { return h < 0.1 ? 3.9999 : 9.0; })),
              HasSubstr("The force is larger over 99 % of the depth and smaller over 1 %; beyond 0.100 mm it stays "
                        "larger."));
  // A difference that is too small for the table does not count.
  EXPECT_THAT(ForceWords(Slab([](double h) { return h < 0.1 ? 4.0000001 : 9.0; })),
              HasSubstr("The force is larger wherever the two differ, at 99 of the 100 depths."));
}

TEST(Conclusion, SlabsForceBeyondTheSliceIsAttributedToItsSpring) {
  // The force is 27.5 N at the end of the slice, falls with every 0.1 mm and is zero from 10.3 mm on. The spring's
  // stiffness is 100 N/mm.
  MadeUpCase slab = Slab([](double) { return 27.5; });
  slab.beyond_N = [](double h) { return h < 10.1 ? 18.0 : h < 10.2 ? 9.0 : h < 10.3 ? 0.6 : 0.0; };
  const auto words = [&] { return AllOf(WriteConclusion(MakeUp({Reference(), slab})).beyond); };
  EXPECT_EQ(words(),
            "The mean of 1.38 N that slab B shows there is not a cutting force, since the slice is free: it comes from "
            "the hand's spring of 100 N/mm, which carried 27.5 N when the slice came free and relaxed within 0.300 mm "
            "(to below 1 %).\n");
  slab.beyond_N = [](double h) { return h < 10.2 ? 9.0 : 0.2; };
  EXPECT_THAT(words(), HasSubstr("within 0.200 mm (to below 1 %)"));
  slab.beyond_N = [](double) { return 5.0; };
  EXPECT_THAT(words(), HasSubstr("and still carried 5.00 N at the last depth."));
  slab.beyond_N = [](double) { return -1e-9; };
  EXPECT_EQ(words(), "");
  // In the reference case, this force comes from bone next to the disc.
  MadeUpCase reference = Reference();
  reference.beyond_N = [](double) { return 0.5; };
  EXPECT_EQ(AllOf(WriteConclusion(MakeUp({reference, slab})).beyond),
            "There the slice is free, and the disc of voxel A still has bone next to its round rim: 0.500 N on "
            "average.\n");
}

TEST(Conclusion, LargestDifferenceNamesDepthForcesAndTeeth) {
  MadeUpCase slab = Slab([](double h) { return h > 7 && h < 7.1 ? 20.0 : 5.0; });
  slab.teeth = [](double) { return 8.0; };
  EXPECT_THAT(ForceWords(slab), HasSubstr("The difference is largest at 7.05 mm: 20.0 N (8.00 teeth at 2.50 N each) "
                                          "against 4.00 N (2.00 teeth at 2.00 N each)"));
}

TEST(Conclusion, AgreementIsReportedOnlyWithinTwoPercent) {
  EXPECT_THAT(ForceWords(Slab([](double) { return 4.06; })), HasSubstr("**slab B** agrees with voxel A"));
  EXPECT_THAT(ForceWords(Slab([](double) { return 4.1; })), Not(HasSubstr("agrees")));
  // The mean is the same, but there are large differences at each depth.
  EXPECT_THAT(ForceWords(Slab([](double h) { return h < 5 ? 2.0 : 6.0; })), Not(HasSubstr("agrees")));
}

TEST(Conclusion, SlabIsASubstituteOnlyWithinTenPercent) {
  EXPECT_THAT(
      ForceWords(Slab([](double) { return 4.3; })),
      HasSubstr("**In short:** slab mode can replace voxel A on this cut: slab B gives 1.08 times the mean force of "
                "voxel A (4.30 N against 4.00 N; rms difference 0.300 N), in 1/200 of the time per tick."));
  const std::string off = ForceWords(Slab([](double) { return 6.0; }));
  EXPECT_THAT(off, HasSubstr("**In short:** slab mode cannot replace voxel A on this cut: slab B gives 1.50 times the "
                             "mean force of voxel A (6.00 N against 4.00 N; rms difference 2.00 N)"));
  // The report names no cause that was not measured.
  EXPECT_THAT(off, Not(HasSubstr("The cause")));
  // The nearest of several slabs is reported, whatever their order.
  MadeUpCase other = Slab([](double) { return 4.2; });
  other.label = "slab C";
  EXPECT_THAT(AllOf(WriteConclusion(MakeUp({Reference(), Slab([](double) { return 9.0; }), other})).force),
              HasSubstr("slab C gives 1.05 times the mean force"));
  // The report does not call a slower slab faster.
  MadeUpCase slow = Slab([](double) { return 4.1; });
  slow.p50_us = 250;
  EXPECT_THAT(ForceWords(slow), HasSubstr("in 2.50 times the time per tick"));
}

// A slab has 1.2 % of the force. With the slab's law, voxel mode has 1 %, so the slab itself adds a fifth.
TEST(Conclusion, EffectOfTheToothLawIsSeparatedFromThatOfTheSlab) {
  MadeUpCase equal = Reference();
  equal.label = "voxel hertz_constant_bite";
  equal.law = "hertz_constant_bite";
  const auto in_short = [&](double equal_N, double slab_N) {
    equal.force_N = [=](double) { return equal_N; };
    return WriteConclusion(MakeUp({Reference(), equal, Slab([=](double) { return slab_N; })})).force.front();
  };
  const std::string law = in_short(0.04, 0.048);
  EXPECT_THAT(law,
              HasSubstr("slab B gives 1.20 % of the mean force of voxel A (0.0480 N against 4.00 N; rms difference "
                        "3.95 N)"));
  EXPECT_THAT(law, HasSubstr("The cause is the tooth law more than the slab: with the slab's law, voxel mode gives "
                             "1.00 % of the mean force of voxel A; with the same law, slab B gives 1.20 times the mean "
                             "force of voxel hertz_constant_bite (0.0480 N against 0.0400 N)."));
  EXPECT_THAT(law, Not(HasSubstr("peak")));
  const std::string slab = in_short(3, 12);
  EXPECT_THAT(slab,
              HasSubstr("The cause is the slab more than the tooth law: with the same law, slab B gives 4.00 times "
                        "the mean force of voxel hertz_constant_bite (12.0 N against 3.00 N); with the slab's law, "
                        "voxel mode gives 75.0 % of the mean force of voxel A."));
  // The reference itself uses the slab's law.
  MadeUpCase reference = Reference();
  reference.law = "hertz_constant_bite";
  EXPECT_THAT(WriteConclusion(MakeUp({reference, Slab([](double) { return 12.0; })})).force.front(),
              HasSubstr("The cause is the slab: with the same law, slab B gives 3.00 times the mean force of voxel A"));
}

// Of two slabs, the report names the one that is nearer with the same law, not the one whose errors happen to cancel
// those of the law.
TEST(Conclusion, NearestSlabIsChosenAtEqualLaw) {
  MadeUpCase equal = Reference();
  equal.label = "voxel hertz_constant_bite";
  equal.law = "hertz_constant_bite";
  equal.force_N = [](double) { return 0.04; };
  MadeUpCase lucky = Slab([](double) { return 3.0; });
  lucky.label = "slab C";
  const Comparison c = MakeUp({Reference(), equal, lucky, Slab([](double) { return 0.05; })});
  EXPECT_THAT(WriteConclusion(c).force.front(), HasSubstr("slab B gives 1.25 % of the mean force"));
}

TEST(Conclusion, TeethThatReinforceEachOtherAreReported) {
  // The force is n^3 F_1 with n growing from 1 to 3, so a tooth bears 1 N at first and 9 N at the end.
  MadeUpCase cubed = Slab([](double h) { return h < 3 ? 1.0 : h < 6 ? 8.0 : 27.0; });
  cubed.teeth = [](double h) { return h < 3 ? 1.0 : h < 6 ? 2.0 : 3.0; };
  EXPECT_THAT(
      ForceWords(cubed),
      HasSubstr("Here the force on a tooth increases with the number of engaged teeth: 1.00 N at 0.0500 mm with "
                "1.00 teeth, 9.00 N at 6.05 mm with 3.00"));
  MadeUpCase summed = Slab([](double h) { return h < 3 ? 1.0 : h < 6 ? 2.0 : 3.0; });
  summed.teeth = cubed.teeth;
  EXPECT_THAT(ForceWords(summed), Not(HasSubstr("increases with the number of engaged teeth")));
}

TEST(Conclusion, NearestPairIsThatWithTheSmallestRms) {
  MadeUpCase voxel = Reference();
  voxel.label = "voxel C";
  voxel.force_N = [](double) { return 9.0; };
  const Comparison c = MakeUp({Reference(), voxel, Slab([](double) { return 10.0; })});
  EXPECT_THAT(AllOf(WriteConclusion(c).force),
              HasSubstr("Of all cases, voxel C and slab B are closest to each other: rms difference 1.00 N, 10.0 % of "
                        "the larger peak, 10.0 N."));
}

TEST(Conclusion, RegionsAndTissuesAreNamedByTheirDifferences) {
  const auto words = [](double upper, double lower) {
    const Comparison c = MakeUp({Reference(), Slab([=](double h) { return h < 4 ? upper : lower; })});
    return AllOf(WriteConclusion(c).regions);
  };
  EXPECT_THAT(words(7, 5), HasSubstr("slab B differs most in upper (rms 3.00 N; 7.00 N against 4.00 N) and least in "
                                     "lower (rms 1.00 N; 5.00 N against 4.00 N); rms 1.00 N over the layers named "
                                     "cancellous and 3.00 N over the layers named cortical."));
  EXPECT_THAT(words(5, 7), HasSubstr("slab B differs most in lower (rms 3.00 N; 7.00 N against 4.00 N) and least in "
                                     "upper"));
}

TEST(Conclusion, StatesThatLayersAreNamedAfterTheLargestRegion) {
  Comparison c = MakeUp({Reference(), Slab([](double h) { return h < 4 ? 5.0 : 6.0; })});
  const std::string named =
      "A layer is named after the region with the largest share of its area, and its E is the mean over the whole area";
  EXPECT_EQ(
      WriteConclusion(c).regions.front(),
      named + "; so a cancellous layer with cortical walls is stiffer than its name suggests (here lower 1.00 GPa).");
  c.regions[1].E_MPa = 11'140;
  EXPECT_THAT(WriteConclusion(c).regions.front(), HasSubstr("(here lower 11.1 GPa)"));
  c.regions[1].tissue = "cortical";
  EXPECT_EQ(WriteConclusion(c).regions.front(), named + ".");
  c.depth_by = "paper_table_2";
  EXPECT_THAT(WriteConclusion(c).regions.front(), HasSubstr("those of the paper's Table 2"));
}

TEST(Conclusion, CostIsTheRatioOfTheMeasuredFigures) {
  MadeUpCase slab = Slab([](double) { return 4.0; });
  const auto words = [&] { return AllOf(WriteConclusion(MakeUp({Reference(), slab})).cost); };
  EXPECT_THAT(words(), HasSubstr("A tick of **slab B** takes 0.500 us (p50; p99 0.600 us) against 100 us (p99 200 us), "
                                 "200 times less; it accesses 2.00 kB of memory against 1.00 MB, 500 times less."));
  EXPECT_THAT(words(), HasSubstr("Between the 2 repetitions, p50 differed by up to 5.00 %"));
  slab.p50_us = 300;
  slab.memory_bytes = 4'000'000;
  EXPECT_THAT(words(), HasSubstr("3.00 times more; it accesses 4.00 MB of memory against 1.00 MB, 4.00 times more."));
  slab.p50_us = 105;
  slab.memory_bytes = 1'000'000;
  EXPECT_THAT(words(), HasSubstr("slab B costs the same as voxel A, to within 10 %, in time per tick and in memory."));
}

TEST(Conclusion, P99DecidesWhetherTheDeadlineIsMet) {
  MadeUpCase reference = Reference();
  const auto words = [&] { return AllOf(WriteConclusion(MakeUp({reference, Slab([](double) { return 4.0; })})).cost); };
  EXPECT_THAT(words(), HasSubstr("a tick may take 1000 us; cases whose p99 met this limit: voxel A and slab B in every "
                                 "repetition"));
  reference.p99_us = 1500;
  EXPECT_THAT(words(), HasSubstr("slab B in every repetition; voxel A in none"));
  reference.p99_us = 980;  // the second repetition takes 5 % longer
  EXPECT_THAT(words(), HasSubstr("slab B in every repetition; voxel A in some repetitions only"));
}

TEST(Conclusion, CaseAgreesWithItselfWithoutAnyDifference) {
  MadeUpCase same = Reference();
  same.label = "voxel again";
  const Comparison c = MakeUp({Reference(), same});
  EXPECT_EQ(c.cases[1].slice.rms_N, 0);
  EXPECT_EQ(c.cases[1].slice.peak_N, 0);
  EXPECT_THAT(AllOf(WriteConclusion(c).force), HasSubstr("**voxel again** agrees with voxel A"));
  EXPECT_THAT(AllOf(WriteConclusion(c).regions), Not(HasSubstr("differs")));
}

TEST(FinishComparison, SquaresOfTheRegionsSumToThoseOfTheSlice) {
  const Comparison c =
      MakeUp({Reference(), Slab([](double h) { return h * h; }), Slab([](double h) { return std::sin(9 * h); })});
  for (const CaseResult& r : c.cases) {
    double squares = 0;
    double sum = 0;
    std::size_t bins = 0;
    double peak = 0;
    for (const Difference& d : r.regions) {
      squares += d.rms_N * d.rms_N * static_cast<double>(d.bins);
      sum += d.mean_N * static_cast<double>(d.bins);
      bins += d.bins;
      peak = std::max(peak, std::abs(d.peak_N));
    }
    EXPECT_EQ(bins, r.slice.bins);
    const double whole = r.slice.rms_N * r.slice.rms_N * static_cast<double>(r.slice.bins);
    EXPECT_NEAR(squares, whole, 1e-12 * (1 + whole));
    EXPECT_NEAR(sum, r.slice.mean_N * static_cast<double>(r.slice.bins), 1e-10);
    EXPECT_EQ(peak, std::abs(r.slice.peak_N));
  }
  EXPECT_EQ(c.slice_bins.size(), 100u);
  EXPECT_EQ(c.beyond_bins.size(), 20u);
  ASSERT_EQ(c.regions.size(), 2u);
  EXPECT_NEAR(c.regions[0].bottom_mm, 4, 1e-9);
  EXPECT_EQ(c.regions[1].tissue, "cancellous");
}

TEST(ShowFigure, HasThreeFiguresAndNoExponent) {
  EXPECT_EQ(ShowFigure(0.05541), "0.0554");
  EXPECT_EQ(ShowFigure(1), "1.00");
  EXPECT_EQ(ShowFigure(12.345), "12.3");
  EXPECT_EQ(ShowFigure(-12345.6), "-12346");
  EXPECT_EQ(ShowFigure(0), "0");
  EXPECT_EQ(ShowFigure(1e-12), "0");
  EXPECT_EQ(ShowFigure(std::nan("")), "not a number");
  EXPECT_EQ(ShowTime(0.3), "0.300 us");
  EXPECT_EQ(ShowTime(12345), "12.3 ms");
  EXPECT_EQ(ShowMemory(121e6), "121 MB");
  EXPECT_EQ(ShowMemory(1220), "1.22 kB");
  EXPECT_EQ(ShowMemory(96), "96 bytes");
}

}  // namespace
}  // namespace kerf
