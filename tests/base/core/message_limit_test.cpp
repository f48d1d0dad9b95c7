// Of messages that differ only in their numbers, only the first few are shown.
#include "base/core/message_limit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kerf {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(MessageLimit, ShowsTheFirstMessagesOfAKindAndCountsTheRest) {
  constexpr int kLeaps = 763;
  MessageLimit limit(10);
  int shown = 0;
  for (int i = 0; i < kLeaps; ++i) {
    const auto text = limit.Take(fmt::format("at {:.3f} s: a leap of {} mm", 0.001 * i, -1e-7 * i));
    if (text) ++shown;
    if (i < 10) {
      EXPECT_THAT(text.value_or(""), HasSubstr(fmt::format("at {:.3f} s", 0.001 * i)));
    } else if (i == 10) {
      EXPECT_THAT(text.value_or(""), AllOf(HasSubstr("at 0.010 s"), HasSubstr("only counted")));
    }
    // Messages of a different kind are counted separately.
    if (i % 100 == 0) {
      EXPECT_EQ(limit.Take(fmt::format("row {} is missing", i)), fmt::format("row {} is missing", i));
    }
  }
  EXPECT_EQ(shown, 11);
  EXPECT_THAT(limit.TakeSuppressed(),
              ElementsAre(fmt::format("{} more messages like this one were not shown: at 0.000 s: a leap of -0 mm",
                                      kLeaps - 11)));
  EXPECT_TRUE(limit.TakeSuppressed().empty());
}

TEST(MessageLimit, WordsMakeTheKindAndNumbersDoNot) {
  MessageLimit limit(1);
  EXPECT_EQ(limit.Take("grid \"phi\" has 3 voxels"), "grid \"phi\" has 3 voxels");
  EXPECT_EQ(limit.Take("grid \"hu\" has 3 voxels"), "grid \"hu\" has 3 voxels");
  EXPECT_NE(limit.Take("grid \"hu\" has 4.5e-3 voxels"), "grid \"hu\" has 4.5e-3 voxels");
  EXPECT_EQ(limit.Take("grid \"hu\" has -1e12 voxels"), std::nullopt);
  EXPECT_EQ(limit.TakeSuppressed().size(), 1u);
}

}  // namespace
}  // namespace kerf
