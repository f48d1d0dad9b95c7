// Results as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/table.h"

namespace kerf {

/// Returns null if the value is not finite.
nlohmann::ordered_json NumberJson(double value);
/// Rounds to six significant digits, which exceeds the accuracy of any measurement. Returns null if the value is not
/// finite.
nlohmann::ordered_json RoundedJson(double value, int digits = 6);
/// Returns the number of ticks, and the percentiles in us.
nlohmann::ordered_json TimesJson(const Percentiles& times);
/// Returns the value, or null if there is none.
template <typename T>
nlohmann::ordered_json OrNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

/// Returns the value as the column's format rounds it: null for an empty cell and for a number that is not finite.
nlohmann::ordered_json CellJson(const TableCell& cell, const std::string& format);
template <typename Row>
nlohmann::ordered_json RowJson(const Columns<Row>& columns, const Row& row) {
  nlohmann::ordered_json json;
  for (const Column<Row>& column : columns) json[column.name] = CellJson(column.value(row), column.format);
  return json;
}
/// Returns a list with an object for each row.
template <typename Row>
nlohmann::ordered_json RowsJson(const Columns<Row>& columns, const std::vector<Row>& rows) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Row& row : rows) json.push_back(RowJson(columns, row));
  return json;
}

/// Returns the text of a file, indented by two spaces; bytes that are not UTF-8 are replaced.
std::string DumpJson(const nlohmann::ordered_json& json);

}  // namespace kerf
