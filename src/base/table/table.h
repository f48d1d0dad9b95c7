// Tables of results. A list of columns describes each column of a file once: its name, which ends in the unit, the
// format of its values and its meaning. The CSV file, the JSON array and the description in docs/formats.md are derived
// from that list:
//
//   const Columns<Minute> kColumns{{"minute", "{}", "1, 2, ...", &Minute::number},
//                                  {"p50_us", "{:.2f}", "median time of a tick", &Minute::p50_us}};
//
// A TextTable is for people: its cells are texts, and it is printed on a terminal or as Markdown.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace kerf {

/// The value of a cell: nothing, a truth value, a number or a text.
class TableCell {
 public:
  using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string>;

  TableCell() = default;
  template <typename T>
  TableCell(const T& value) {  // NOLINT(google-explicit-constructor): any value is a cell
    if constexpr (std::is_same_v<T, bool>) {
      value_ = value;
    } else if constexpr (std::floating_point<T>) {
      value_ = static_cast<double>(value);
    } else if constexpr (std::unsigned_integral<T>) {
      value_ = static_cast<std::uint64_t>(value);
    } else if constexpr (std::integral<T>) {
      value_ = static_cast<std::int64_t>(value);
    } else if constexpr (std::is_convertible_v<T, std::string_view>) {
      value_ = std::string(std::string_view(value));
    } else if (value) {  // optional
      *this = TableCell(*value);
    }
  }
  const Value& value() const { return value_; }

 private:
  Value value_;
};

/// Appends the value, formatted with `format` of fmt; nothing if the cell is empty.
void AppendCell(const TableCell& cell, const std::string& format, std::string& text);
/// Appends a field of a CSV. A text with the format "{}" is written by FormatCsvField().
void AppendCsvField(const TableCell& cell, const std::string& format, std::string& csv);

template <typename Row>
struct Column {
  std::string name;
  std::string format;
  std::string meaning;
  std::function<TableCell(const Row&)> value;
};
template <typename Row>
using Columns = std::vector<Column<Row>>;

/// Returns a column for each part of a vector or of a quaternion: `parts` has a letter for each, which replaces the {}
/// of `name`. `get` returns the parts, in that order, for a row.
template <typename Row, typename Get>
Columns<Row> PartsOf(const std::string& name, std::string_view parts, const std::string& format,
                     const std::string& meaning, Get get) {
  Columns<Row> columns;
  for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
    std::string part = name;
    part.replace(part.find("{}"), 2, 1, parts[static_cast<std::size_t>(i)]);
    columns.push_back(
        {std::move(part), format, meaning, [get, i](const Row& row) -> TableCell { return std::invoke(get, row)[i]; }});
  }
  return columns;
}
/// Returns the parts of a quaternion in the order w, x, y, z.
template <typename Quaternion>
auto PartsOfQuat(const Quaternion& q) {
  return std::array{q.w, q.x, q.y, q.z};
}
template <typename Row>
Columns<Row> JoinColumns(std::initializer_list<Columns<Row>> lists) {
  Columns<Row> columns;
  for (const Columns<Row>& list : lists) columns.insert(columns.end(), list.begin(), list.end());
  return columns;
}

template <typename Row>
std::vector<std::string> NamesOf(const Columns<Row>& columns) {
  std::vector<std::string> names;
  for (const Column<Row>& column : columns) names.push_back(column.name);
  return names;
}

/// Returns the names, separated by commas, without an end of line.
template <typename Row>
std::string CsvHeader(const Columns<Row>& columns) {
  std::string csv;
  for (const Column<Row>& column : columns) csv.append(csv.empty() ? "" : ",").append(column.name);
  return csv;
}
/// Appends the row's values, separated by commas, without an end of line.
template <typename Row>
void AppendCsv(const Columns<Row>& columns, const Row& row, std::string& csv) {
  const char* separator = "";
  for (const Column<Row>& column : columns) {
    csv += separator;
    AppendCsvField(column.value(row), column.format, csv);
    separator = ",";
  }
}
template <typename Row>
std::string FormatCsv(const Columns<Row>& columns, const std::vector<Row>& rows) {
  std::string csv = CsvHeader(columns) + "\n";
  for (const Row& row : rows) {
    AppendCsv(columns, row, csv);
    csv += '\n';
  }
  return csv;
}
/// `columns` get the number of the row.
inline std::string FormatCsv(const Columns<std::size_t>& columns, std::size_t rows) {
  std::vector<std::size_t> numbers(rows);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return FormatCsv(columns, numbers);
}

/// A table for people.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> headings) : headings_(std::move(headings)) {}
  /// The last cells may be left out; they are empty.
  void Add(const std::vector<TableCell>& cells);
  bool empty() const { return rows_.empty(); }
  /// Returns a line for the headings and one for each row, with aligned columns: numbers on the right, columns that
  /// contain words on the left, without the marks ` and *. Each line begins with `indent`.
  std::string FormatTerminal(std::string_view indent = "") const;
  std::string FormatMarkdown() const;

 private:
  std::vector<std::string> headings_;
  std::vector<std::vector<std::string>> rows_;
};

/// Escapes bars, which would otherwise end a cell of a Markdown table.
std::string EscapeBars(std::string_view text);
/// Returns a Markdown table of names and meanings; `heading` is that of the names. Neighbours of the same meaning share
/// a row.
std::string DescribeColumns(const std::vector<std::pair<std::string, std::string>>& columns,
                            const std::string& heading);
template <typename Row>
std::string DescribeColumns(const Columns<Row>& columns, const std::string& heading = "column") {
  std::vector<std::pair<std::string, std::string>> names;
  for (const Column<Row>& column : columns) names.emplace_back(column.name, column.meaning);
  return DescribeColumns(names, heading);
}

}  // namespace kerf
