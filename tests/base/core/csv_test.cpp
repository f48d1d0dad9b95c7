// Text in tables: no field starts a formula in a spreadsheet, and kerf reads every field back.
#include "base/core/csv.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

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

}  // namespace
}  // namespace kerf
