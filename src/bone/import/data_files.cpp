// Images whose voxels are in several files.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>

#include "bone/import/image_fields.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// A name with one number: "slice_%03d.raw" is {"slice_", 3, true, ".raw"}.
struct NamePattern {
  std::string before;
  int width = 0;
  bool zeros = false;
  std::string after;
};

std::optional<NamePattern> ParsePattern(const std::string& text) {
  NamePattern pattern;
  const std::size_t percent = text.find('%');
  if (percent == std::string::npos) return std::nullopt;
  pattern.before = text.substr(0, percent);
  std::size_t at = percent + 1;
  pattern.zeros = at < text.size() && text[at] == '0';
  while (at < text.size() && text[at] >= '0' && text[at] <= '9' && pattern.width < 100) {
    pattern.width = 10 * pattern.width + (text[at++] - '0');
  }
  if (at >= text.size() || std::string("diu").find(text[at]) == std::string::npos || pattern.width > 20) {
    return std::nullopt;
  }
  pattern.after = text.substr(at + 1);
  if (pattern.after.find('%') != std::string::npos) return std::nullopt;
  return pattern;
}

std::string MakeName(const NamePattern& pattern, long number) {
  const std::string digits =
      pattern.zeros ? fmt::format("{:0{}}", number, pattern.width) : fmt::format("{:{}}", number, pattern.width);
  return pattern.before + digits + pattern.after;
}

// Splits "name_%03d.raw 1 45 1" at the blank before its numbers; the name may have blanks.
std::optional<std::vector<std::string>> ExpandPattern(const std::string& data_file, double& subdimensions,
                                                      const std::string& path) {
  const std::size_t percent = data_file.find('%');
  const std::size_t blank = percent == std::string::npos ? percent : data_file.find_first_of(" \t", percent);
  if (blank == std::string::npos) return std::nullopt;
  const std::vector<double> numbers = ParseNumbers(data_file.substr(blank));
  const std::optional<NamePattern> pattern = ParsePattern(data_file.substr(0, blank));
  const bool whole =
      std::all_of(numbers.begin(), numbers.end(), [](double n) { return n == std::floor(n) && std::abs(n) < 1e9; });
  if (!pattern || numbers.size() < 2 || numbers.size() > 4 || !whole) {
    throw Error(
        fmt::format("{}: the names of the data files, '{}', are not a pattern with one number, such as "
                    "'slice_%03d.raw 1 45 1'",
                    path, data_file));
  }
  const double step = numbers.size() > 2 ? numbers[2] : numbers[1] < numbers[0] ? -1 : 1;
  if (numbers.size() > 3) subdimensions = numbers[3];
  const double count = step == 0 ? -1 : std::floor((numbers[1] - numbers[0]) / step) + 1;
  if (!(count >= 1) || count > static_cast<double>(kMaxDataFiles)) {
    throw Error(fmt::format("{}: the header's '{}' names {:.0f} data files; kerf reads 1 to {}", path, data_file,
                            std::max(count, 0.0), kMaxDataFiles));
  }
  std::vector<std::string> names;
  for (double n = 0; n < count; ++n) names.push_back(MakeName(*pattern, static_cast<long>(numbers[0] + n * step)));
  return names;
}

}  // namespace

std::vector<std::string> ListDataFiles(const std::string& data_file, const std::vector<std::string>& files,
                                       const std::vector<double>& sizes, const std::string& path) {
  double subdimensions = 0;
  std::vector<std::string> names;
  const std::size_t word = data_file.find_first_of(" \t");
  if (Lower(data_file.substr(0, word)) == "list") {
    names = files;
    if (word != std::string::npos) {
      if (const std::vector<double> number = ParseNumbers(data_file.substr(word)); number.size() == 1)
        subdimensions = number[0];
    }
  } else if (std::optional<std::vector<std::string>> expanded = ExpandPattern(data_file, subdimensions, path)) {
    names = *std::move(expanded);
  } else {
    return {};
  }
  // The last axis is divided evenly, or the files run over all axes from `subdimensions` on.
  double parts = sizes.empty() ? 0 : sizes.back();
  for (std::size_t a = sizes.size(); a-- > 1 && subdimensions >= 1 && static_cast<double>(a) > subdimensions;) {
    parts *= sizes[a - 1];
  }
  const auto count = static_cast<double>(names.size());
  const bool fits = count >= 1 && (subdimensions == 0 || subdimensions >= static_cast<double>(sizes.size())
                                       ? std::fmod(parts, count) == 0
                                       : parts == count);
  if (!fits || names.size() > kMaxDataFiles) {
    throw Error(fmt::format("{}: the header names {} data files for {:.0f} slices; each file must have as many of them",
                            path, names.size(), parts));
  }
  // A file named often could take much more memory than it has bytes.
  if (std::set<std::string>(names.begin(), names.end()).size() != names.size())
    throw Error(fmt::format("{}: the header names a data file twice", path));
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

}  // namespace kerf
