// Text in tables: no field starts a formula in a spreadsheet, and kerf reads every field back.
#include "base/core/csv.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "support/message_of.h"

namespace kerf {
namespace {

std::string ReadBack(const std::string& field) {
  std::string read;
  int rows = 0;
  ReadCsv("words,number\n" + field + ",1\n", "table.csv", {"words", "number"},
          [&](const std::vector<std::string>& fields, const CsvPlace&) {
            read = fields[0];
            ++rows;
          });
  EXPECT_EQ(rows, 1) << field;
  return read;
}

TEST(Csv, TextFieldsNeverStartAFormula) {
  for (const std::string text : {"=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", " =1", "'=1", "\r=1", "-"}) {
    const std::string field = FormatCsvField(text);
    const std::string cell = field.front() == '"' ? field.substr(1) : field;
    EXPECT_EQ(cell.front(), '\'') << field;
  }
}

TEST(Csv, WordsAndNumbersStayAsTheyAre) {
  for (const std::string text : {"Ida", "O'Hara", "'quoted'", "a=b", "1-2", "-0.5", "-1e-3", "", "'"}) {
    EXPECT_EQ(FormatCsvField(text), text);
  }
}

// Any text reads back unchanged.
TEST(Csv, EachFieldReadsBack) {
  std::mt19937 random(7);
  const std::string letters = "=+-@'\" \t,#a1.e";
  for (int n = 0; n < 20000; ++n) {
    std::string text;
    for (auto size = random() % 7; size > 0; --size) text += letters[random() % letters.size()];
    const std::string field = FormatCsvField(text);
    ASSERT_EQ(ReadBack(field), text) << field;
  }
}

TEST(Csv, TablesOfForeignSpreadsheetsAreNamed) {
  const auto message = [](const std::string& text) {
    return test::MessageOf([&] {
      ReadCsv(text, "t.csv", {"name", "width_mm"}, [](const std::vector<std::string>& fields, const CsvPlace& place) {
        ParseCsvNumber(fields[1], 0, "width_mm", place);
      });
    });
  };
  EXPECT_EQ(message("name;width_mm\na;1,5\n"),
            "t.csv:1: unknown column \"name;width_mm\"; the columns are name,width_mm; the columns are separated by "
            "semicolons: save the table again with commas and decimal points");
  EXPECT_TRUE(message("name\twidth_mm\na\t1.5\n").find("separated by tabs: save the table again") != std::string::npos);
  EXPECT_EQ(
      message("name,width_mm\na,1,5\n"),
      "t.csv:2: 3 fields instead of 2; a field with a comma must be in double quotes; if the numbers have decimal "
      "commas, save the table again with decimal points");
  EXPECT_EQ(message("name,width_mm\na,b,c\n"),
            "t.csv:2: 3 fields instead of 2; a field with a comma must be in double quotes");
  EXPECT_EQ(message("name,width_mm\na,\"1,5\"\n"),
            "t.csv:2: width_mm = \"1,5\" is not a number; its numbers have a decimal comma instead of a point: export "
            "the file again with English number format");
  EXPECT_EQ(message("name,width_mm\na,x\n"), "t.csv:2: width_mm = \"x\" is not a number");
}

}  // namespace
}  // namespace kerf
