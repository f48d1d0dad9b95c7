#include "base/core/printable.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(PrintableText, ContainsNoTerminalCommands) {
  EXPECT_EQ(Printable(""), "");
  EXPECT_EQ(Printable("Ida \xc3\x85s, \xe2\x82\xac 5, \xf0\x9f\x98\x80"),
            "Ida \xc3\x85s, \xe2\x82\xac 5, \xf0\x9f\x98\x80");
  EXPECT_EQ(Printable(std::string("a\0b\x1b[2J\a\n\t\x7f", 11)), "a?b?[2J????");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "2J\xc2\xa0"),
            "?2J\xc2\xa0");  // U+009B, and a no-break space, which is kept
  EXPECT_EQ(Printable("a\xe2\x80\xae"
                      "b\xe2\x81\xa6"
                      "c"),
            "a?b?c");  // U+202E, U+2066
  EXPECT_EQ(Printable("a\x9b"
                      "2J\xff\xc0\x9b"),
            "a?2J???");                                                            // not UTF-8
  EXPECT_EQ(Printable("\xe2\x1b\x9b"), "???");                                     // an incomplete character
  EXPECT_EQ(Printable("\xe0\x80\x80\xed\xa0\x80\xf4\x90\x80\x80"), "??????????");  // overlong, surrogate, too large
}

}  // namespace
}  // namespace kerf
