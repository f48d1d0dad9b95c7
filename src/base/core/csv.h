// Tables as CSV text: a header, then one row per line. Every error message gives the line.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Position of an error: "file:line".
struct CsvPlace {
  const std::string& file;
  int line;

  [[noreturn]] void Fail(const std::string& what) const;
};

std::string_view Trim(std::string_view s);
/// Returns user input in double quotes, shortened for use in a message.
std::string Quote(std::string_view s);

/// First line of a table that is neither empty nor a comment.
struct CsvHeaderLine {
  std::vector<std::string> names;
  int line = 0;
};
/// Returns the names in the header, without a check: ReadCsv() checks them.
CsvHeaderLine ReadCsvHeader(std::string_view text);

/// Calls visit(fields, place) for each row below the header, with the fields in the order of `columns`, regardless of
/// their order in the file. '#' starts a comment line. A field that contains a comma must be in double quotes. `file`
/// is the file name in messages. The fields of `optional` follow those of `columns`; those of a column that the file
/// lacks are empty. Throws kerf::Error with file:line at the first error.
void ReadCsv(const std::string& text, const std::string& file, const std::vector<std::string>& columns,
             const std::function<void(const std::vector<std::string>& fields, const CsvPlace& place)>& visit,
             const std::vector<std::string>& optional = {});

/// Parses decimal text times 10^shift, rounded once. Fails unless the whole text is a finite number. `name` is used in
/// the message.
double ParseCsvNumber(std::string_view text, int shift, const char* name, const CsvPlace& place);

/// Returns the shortest decimal text of value / 10^shift that ParseCsvNumber(text, shift) converts to the same bits.
std::string FormatCsvNumber(double value, int shift);
/// Formats a text field (a name, a title, a source) so that it reads back as `text`; line breaks become spaces. Text
/// that a spreadsheet would evaluate as a formula because it begins with = + - @ or a tab gets a leading apostrophe,
/// which ReadCsv() removes. Every writer of such fields uses this function. Numbers are written unchanged.
std::string FormatCsvField(const std::string& text);

}  // namespace kerf
