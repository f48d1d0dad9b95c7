// Reads the files of a session with a device.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "support/running.h"

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

/// Waits until the loop has run for a while, as shown by the growth of its recording. Returns false if the program ends
/// first.
inline bool WaitForProgress(Running& kerf, const std::filesystem::path& recording) {
  const auto bytes = [&recording] {
    std::error_code none_yet;
    const std::uintmax_t size = std::filesystem::file_size(recording, none_yet);
    return none_yet ? 0 : size;
  };
  for (int i = 0; i < 2; ++i) {  // the first growth may be due to earlier work
    if (!kerf.Until([&, before = bytes()] { return bytes() > before; })) return false;
  }
  return true;
}

}  // namespace kerf::test
