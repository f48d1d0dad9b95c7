#include "base/core/word_list.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(JoinWords, SeparatesWithCommasAndAnd) {
  EXPECT_EQ(JoinWords({}), "");
  EXPECT_EQ(JoinWords({"a"}), "a");
  EXPECT_EQ(JoinWords({"a", "b"}), "a and b");
  EXPECT_EQ(JoinWords({"a", "b", "c"}), "a, b and c");
}

}  // namespace
}  // namespace kerf
