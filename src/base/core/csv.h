// Tables as text: a header, a row a line, every fault told with its line.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Where a fault stands: "file:line".
struct CsvPlace {
  const std::string& file;
  int line;

  [[noreturn]] void Fail(const std::string& what) const;
};

std::string_view Trim(std::string_view s);
/// What the user typed, short enough for a message, in double quotes.
std::string Quote(std::string_view s);

/// Calls visit(fields, place) for each row below the header, its fields in the order of `columns` whatever the file's
/// own order. '#' starts a comment line; a field with a comma stands in double quotes. `file` names the text in
/// messages. Throws Error with file:line for the first fault.
void ReadCsv(const std::string& text, const std::string& file, const std::vector<std::string>& columns,
             const std::function<void(const std::vector<std::string>& fields, const CsvPlace& place)>& visit);

/// Decimal text times 10^shift, rounded once; a fault unless all of the text is a finite number. `name`: what it is.
double ParseCsvNumber(std::string_view text, int shift, const char* name, const CsvPlace& place);

/// The shortest decimal text of value / 10^shift that ParseCsvNumber(text, shift) turns into the same bits.
std::string FormatCsvNumber(double value, int shift);
/// A field of words (a name, a title, a source) that reads back as `text`; line breaks become spaces. Of words that a
/// spreadsheet would run as a formula, as they begin with = + - @ or a tab, an apostrophe stands in front, which
/// ReadCsv() takes away. Every writer of such fields uses it; numbers are written as they are.
std::string FormatCsvField(const std::string& text);

}  // namespace kerf
