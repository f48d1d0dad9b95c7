// Tests of sentences that are translated as a whole.
#include "base/core/message.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(Message, TranslationMayChangeTheOrderButNotTheFields) {
  const Message message{"You cut {0} too deep at {1}.", {Quantity{1.25, 2, "mm"}, std::string("the end")}};
  EXPECT_EQ(FormatMessage(message), "You cut 1.25 mm too deep at the end.");
  const auto in = [&](const std::string& sentence) {
    return FormatMessage(
        message, [&](const std::string& text) { return text == "the end" ? "das Ende" : sentence; }, ",");
  };
  EXPECT_EQ(in("An {1}: {0}"), "An das Ende: 1,25 mm");
  EXPECT_EQ(in("broken {7}"), "You cut 1,25 mm too deep at das Ende.");
}

}  // namespace
}  // namespace kerf
