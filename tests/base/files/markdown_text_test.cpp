// Escaping of names and titles in a report.
#include "base/files/markdown_text.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(MarkdownText, EscapesHtmlMarkupAndCellSeparators) {
  EXPECT_EQ(EscapeMarkdown("<img src=x onerror=alert(1)>"), "&lt;img src=x onerror=alert(1)&gt;");
  EXPECT_EQ(EscapeMarkdown("a | b\n# c\r\n"), "a \\| b # c  ");
  EXPECT_EQ(EscapeMarkdown("[a](javascript:b) E* `d` &lt;\\"), "\\[a\\](javascript:b) E* \\`d\\` &amp;lt;\\\\");
  EXPECT_EQ(EscapeMarkdown("plane_offset_mm, 3.5 N (90 %)"), "plane_offset_mm, 3.5 N (90 %)");
}

TEST(MarkdownText, CodeSpansContainNothingThatEndsThem) {
  EXPECT_EQ(MarkdownCode("skull_block"), "`skull_block`");
  EXPECT_EQ(MarkdownCode("a`<b>"), "a\\`&lt;b&gt;");
  EXPECT_EQ(MarkdownCodeLine("kerf compare 'a\n```\n<b>'"), "kerf compare 'a ``` <b>'");
}

}  // namespace
}  // namespace kerf
