// Tests of the descriptions of parameters: checks, messages, ranges by key.
#include "kerf/describe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

struct Params {
  double length_mm = 2;
  int count = 3;
  std::uint64_t ticks = 10;
  double slew_N_per_s = 0;
  Vec3 point_mm{1, 2, 3};
  std::optional<double> budget_us;
  std::vector<double> sizes_mm{1, 2};
  std::string word = "one";
  std::string title = "text";
  bool on = true;
  Quat rotation{1, 0, 0, 0};
};
template <typename V>
void Describe(Params& p, V&& visit) {
  visit("length_mm", p.length_mm, Range{1, 4}, "length");
  visit("count", p.count, Range{1, 9}, "count");
  visit("ticks", p.ticks, Range{1, 1e7}, "ticks");
  visit("slew_N_per_s", p.slew_N_per_s, Range{5, 8, kOrZero}, "slew");
  visit("point_mm", p.point_mm, kDirectionRange, "point");
  visit("budget_us", p.budget_us, Range{1, 1e6}, "budget");
  visit("sizes_mm", p.sizes_mm, Range{0.5, 3}, "sizes");
  visit("word", p.word, Choices{{"one", "two"}}, "word");
  visit("title", p.title, TextLimit{10}, "title");
  visit("on", p.on, "switch");
  visit("rotation", p.rotation, "rotation");
}

/// Returns the message of CheckParameters() for defaults with one change; "" if they are accepted.
template <typename Change>
std::string MessageOf(Change change, std::string_view whose = {}) {
  Params params;
  change(params);
  return test::MessageOf([&] { CheckParameters(params, whose); });
}

TEST(Describe, BothEndsAreAcceptedAndValuesBeyondRefused) {
  for (const double end : {1.0, 4.0}) EXPECT_EQ(MessageOf([=](Params& p) { p.length_mm = end; }), "");
  EXPECT_EQ(MessageOf([](Params& p) { p.length_mm = 0.5; }), "length_mm = 0.5 is below 1; valid range 1 to 4 mm");
  EXPECT_EQ(MessageOf([](Params& p) { p.length_mm = 4.5; }), "length_mm = 4.5 is above 4; valid range 1 to 4 mm");
  EXPECT_NE(MessageOf([](Params& p) { p.length_mm = std::nextafter(4.0, 5.0); }), "");
  EXPECT_EQ(MessageOf([](Params& p) { p.length_mm = std::nan(""); }),
            "length_mm = nan is not a finite number; valid range 1 to 4 mm");
  EXPECT_EQ(MessageOf([](Params& p) { p.length_mm = std::numeric_limits<double>::infinity(); }),
            "length_mm = inf is not a finite number; valid range 1 to 4 mm");
  EXPECT_EQ(MessageOf([](Params& p) { p.count = 10; }), "count = 10 is above 9; valid range 1 to 9");
  EXPECT_EQ(MessageOf([](Params& p) { p.ticks = 0; }), "ticks = 0 is below 1; valid range 1 to 10000000");
  EXPECT_EQ(MessageOf([](Params& p) { p.count = 0; }, "saw"), "saw: count = 0 is below 1; valid range 1 to 9");
}

TEST(Describe, ZeroMayBeValidOutsideTheRange) {
  EXPECT_EQ(MessageOf([](Params& p) { p.slew_N_per_s = 5; }), "");
  EXPECT_EQ(MessageOf([](Params& p) { p.slew_N_per_s = 1; }),
            "slew_N_per_s = 1 is below 5; valid range 5 to 8 N/s, or 0");
}

TEST(Describe, VectorsListsAndOptionalNumbersAreChecked) {
  EXPECT_EQ(MessageOf([](Params& p) { p.point_mm.y = -2000; }),
            "point_mm[1] = -2000 is below -1000; valid range -1000 to 1000 mm");
  EXPECT_EQ(MessageOf([](Params& p) { p.budget_us = 5; }), "");
  EXPECT_EQ(MessageOf([](Params& p) { p.budget_us = 0; }), "budget_us = 0 is below 1; valid range 1 to 1000000 us");
  EXPECT_EQ(MessageOf([](Params& p) { p.sizes_mm = {1, 4}; }), "sizes_mm = 4 is above 3; valid range 0.5 to 3 mm");
  EXPECT_EQ(MessageOf([](Params& p) { p.word = "three"; }),
            "word = \"three\" is unknown; it must be \"one\" or \"two\"");
}

TEST(Describe, RangesAreFoundByKeyAndConverted) {
  const Range range = FindRange<Params>("length_mm");
  EXPECT_EQ(range.lower, 1);
  EXPECT_EQ(range.upper, 4);
  EXPECT_TRUE(FindRange<Params>("slew_N_per_s").or_zero);
  EXPECT_THROW(FindRange<Params>("width_mm"), Error);
  EXPECT_THROW(FindRange<Params>("word"), Error);
  const Range in_um = 1000 * range;
  EXPECT_EQ(in_um.lower, 1000);
  EXPECT_EQ(in_um.upper, 4000);
  EXPECT_EQ(range.Clamp(0), 1);
  EXPECT_EQ(range.Clamp(3), 3);
  EXPECT_EQ(range.Clamp(9), 4);
}

TEST(Describe, UnitsAreThoseAtTheEndOfTheKey) {
  EXPECT_EQ(UnitOfKey("voxel_mm"), "mm");
  EXPECT_EQ(UnitOfKey("feed_mm_per_s"), "mm/s");
  EXPECT_EQ(UnitOfKey("damping_Ns_per_mm"), "N s/mm");
  EXPECT_EQ(UnitOfKey("teeth"), "");
  EXPECT_EQ(ShowRange({0.02, 10}, "mm"), "0.02 to 10 mm");
  EXPECT_EQ(ShowRange({1, 2}, ""), "1 to 2");
}

}  // namespace
}  // namespace kerf
