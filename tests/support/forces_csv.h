// Reads forces.csv.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace kerf::test {

/// Values of a row of forces.csv, by column name.
using ForceRow = std::map<std::string, double>;

/// Returns the complete rows.
inline std::vector<ForceRow> ReadForces(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<ForceRow> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line) && !file.eof();) {
    std::istringstream cells(line);
    std::vector<std::string> values;
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(cell);
    if (names.empty()) {
      if (values.at(0) == "time_s") names = values;
      continue;
    }
    EXPECT_LE(values.size(), names.size()) << line;
    ForceRow row;
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
      char* end = nullptr;
      const double number = std::strtod(values[i].c_str(), &end);
      if (!values[i].empty() && *end == '\0') row[names[i]] = number;
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace kerf::test
