#include "base/table/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/core/csv.h"

namespace kerf {
namespace {

bool IsWord(const std::string& cell) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !cell.empty() && letter(cell.front());
}

}  // namespace

void AppendCell(const TableCell& cell, const std::string& format, std::string& text) {
  std::visit(
      [&](const auto& value) {
        if constexpr (!std::is_same_v<decltype(value), const std::monostate&>) {
          fmt::format_to(std::back_inserter(text), fmt::runtime(format), value);
        }
      },
      cell.value());
}

void AppendCsvField(const TableCell& cell, const std::string& format, std::string& csv) {
  const auto* text = std::get_if<std::string>(&cell.value());
  if (text != nullptr && format == "{}") {
    csv += FormatCsvField(*text);
  } else {
    AppendCell(cell, format, csv);
  }
}

void TextTable::Add(const std::vector<TableCell>& cells) {
  std::vector<std::string>& row = rows_.emplace_back(headings_.size());
  for (std::size_t i = 0; i < cells.size(); ++i) AppendCell(cells[i], "{}", row[i]);
}

std::string TextTable::FormatTerminal(std::string_view indent) const {
  std::vector<std::vector<std::string>> rows = rows_;
  for (auto& row : rows) {
    for (std::string& cell : row) std::erase_if(cell, [](char c) { return c == '`' || c == '*'; });
  }
  std::vector<std::size_t> widths;
  std::vector<bool> left;
  for (std::size_t i = 0; i < headings_.size(); ++i) {
    widths.push_back(headings_[i].size());
    for (const auto& row : rows) widths[i] = std::max(widths[i], row[i].size());
    left.push_back(std::any_of(rows.begin(), rows.end(), [i](const auto& row) { return IsWord(row[i]); }));
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    std::string line(indent);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) line += "  ";
      line += left[i] ? fmt::format("{:<{}}", row[i], widths[i]) : fmt::format("{:>{}}", row[i], widths[i]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  };
  add(headings_);
  for (const auto& row : rows) add(row);
  return text;
}

std::string TextTable::FormatMarkdown() const {
  std::string text;
  const auto add = [&text](const std::vector<std::string>& row) {
    text += '|';
    for (const std::string& cell : row) text.append(cell.empty() ? "" : " ").append(cell).append(" |");
    text += '\n';
  };
  add(headings_);
  text += '|';
  for (std::size_t i = 0; i < headings_.size(); ++i) text += "---|";
  text += '\n';
  for (const auto& row : rows_) add(row);
  return text;
}

std::string EscapeBars(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped.append(c == '|' ? "\\" : "").append(1, c);
  return escaped;
}

std::string DescribeColumns(const std::vector<std::pair<std::string, std::string>>& columns,
                            const std::string& heading) {
  TextTable table({heading, "meaning"});
  std::string names;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    names += (names.empty() ? "`" : ", `") + columns[i].first + "`";
    if (i + 1 < columns.size() && columns[i + 1].second == columns[i].second) continue;
    table.Add({std::exchange(names, {}), EscapeBars(columns[i].second)});
  }
  return table.FormatMarkdown();
}

}  // namespace kerf
