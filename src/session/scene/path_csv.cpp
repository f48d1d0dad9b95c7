#include "session/scene/path_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/core/foreign_format.h"
#include "base/toml/faults.h"
#include "kerf/error.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::size_t kColumns = 8;
constexpr std::array<std::string_view, kColumns> kHeader{"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
constexpr std::string_view kHeaderLine = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz";
constexpr std::size_t kMaxLine = 1000;  // characters of a line in which the reason of a fault is searched
constexpr double kUnitTolerance = 1e-3;
/// Minimum time between two rows; rows that are closer indicate a fault of the recording. Far above the rounding errors
/// of times within kMaxDuration_s.
constexpr double kMinStep_s = 1e-6;

struct Field {
  std::string_view text;
  int column;  // starting at 1
};

bool IsBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

Field Trim(std::string_view line, std::size_t begin, std::size_t end) {
  while (begin < end && IsBlank(line[begin])) ++begin;
  while (end > begin && IsBlank(line[end - 1])) --end;
  return {line.substr(begin, end - begin), static_cast<int>(begin) + 1};
}

/// Returns the fields of a line, at most one more than a valid row has, so that a line with very many commas does not
/// take long.
std::vector<Field> Split(std::string_view line) {
  std::vector<Field> fields;
  std::size_t begin = 0;
  while (fields.size() <= kColumns) {
    const std::size_t comma = std::min(line.find(',', begin), line.size());
    fields.push_back(Trim(line, begin, comma));
    if (comma == line.size()) break;
    begin = comma + 1;
  }
  return fields;
}

/// Returns text from a file, shortened for a message and without control characters.
std::string Show(std::string_view text) {
  std::string shown(text.substr(0, 40));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  return fmt::format("\"{}\"{}", shown, text.size() > 40 ? "..." : "");
}

std::optional<double> ParseNumber(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

class PathParser {
 public:
  PathParser(const std::string& file, std::size_t rows) : faults_(file) { poses_.reserve(rows); }

  void Line(int number, std::string_view line) {
    if (Trim(line, 0, line.size()).text.empty() || line.front() == '#') return;
    const std::vector<Field> fields = Split(line);
    if (!header_seen_) return Header(number, line, fields);
    if (fields.size() != kColumns) {
      return Fault(number, 1,
                   fmt::format("{} columns; a row has 8: {}{}",
                               fields.size() > kColumns ? "more than 8" : fmt::format("{}", fields.size()), kHeaderLine,
                               fields.size() > kColumns ? DescribeForeignTable(line.substr(0, kMaxLine)) : ""));
    }
    std::array<double, kColumns> row{};
    bool good = true;
    for (std::size_t i = 0; i < kColumns; ++i) {
      const std::optional<double> value = ParseNumber(fields[i].text);
      if (!value) {
        Fault(number, fields[i].column,
              fmt::format("{} = {} is not a finite number{}", kHeader[i], Show(fields[i].text),
                          DescribeForeignNumber(fields[i].text)));
        good = false;
      } else if (i >= 1 && i <= 3 && !kCoordinateRange_mm.Contains(*value)) {
        Fault(number, fields[i].column,
              fmt::format("{} = {} {}", kHeader[i], *value, FindRangeFault(*value, kCoordinateRange_mm, "mm")));
        good = false;
      } else {
        row[i] = *value;
      }
    }
    if (good) Row(number, fields, row);
  }

  std::vector<TimedPose> Finish(int last_line) {
    if (!header_seen_) faults_.Add(last_line, 1, fmt::format("no header; it must be {}", kHeaderLine));
    if (faults_.empty()) {
      if (poses_.size() < 2) {
        faults_.Add(last_line, 1, fmt::format("{} rows; a path has at least 2", poses_.size()));
      } else if (poses_.back().time_s - poses_.front().time_s > kMaxDuration_s) {
        faults_.Add(last_line, 1,
                    fmt::format("the path takes {:.0f} s; at most {:.0f} s",
                                poses_.back().time_s - poses_.front().time_s, kMaxDuration_s));
      }
    }
    faults_.ThrowIfAny();
    return std::move(poses_);
  }

  bool too_many_faults() const { return faults_.full(); }

 private:
  void Header(int number, std::string_view line, const std::vector<Field>& fields) {
    header_seen_ = true;
    const bool same =
        fields.size() == kColumns && std::equal(fields.begin(), fields.end(), kHeader.begin(),
                                                [](const Field& f, std::string_view h) { return f.text == h; });
    if (!same) {
      Fault(number, 1,
            fmt::format("the header must be {}{}", kHeaderLine, DescribeForeignTable(line.substr(0, kMaxLine))));
    }
  }

  void Row(int number, const std::vector<Field>& fields, const std::array<double, kColumns>& row) {
    const double time_s = row[0];
    if (!poses_.empty() && !(time_s - poses_.back().time_s >= kMinStep_s)) {
      return Fault(number, fields[0].column,
                   fmt::format("time_s = {} is not at least {} s after the previous row, {}", time_s, kMinStep_s,
                               poses_.back().time_s));
    }
    const Quat R(row[4], row[5], row[6], row[7]);
    const double length = glm::length(R);
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      return Fault(number, fields[4].column, fmt::format("the quaternion has length {:.6g}; it must be 1", length));
    }
    poses_.push_back({time_s, Pose{R / length, {row[1], row[2], row[3]}}});
  }

  void Fault(int line, int column, const std::string& what) { faults_.Add(line, column, what); }

  Faults faults_;
  std::vector<TimedPose> poses_;
  bool header_seen_ = false;
};

}  // namespace

std::vector<TimedPose> ParsePathCsv(const std::string& text, const std::string& file) {
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  if (lines > kMaxPathRows + 1000) {
    throw Error(fmt::format("{}: {} lines; a path has at most {} rows", file, lines, kMaxPathRows));
  }
  PathParser parser(file, lines);
  std::string_view rest = text;
  int number = 0;
  while (!rest.empty() && !parser.too_many_faults()) {
    ++number;
    const std::size_t end = rest.find('\n');
    parser.Line(number, rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return parser.Finish(std::max(number, 1));
}

std::string FormatPathCsv(const std::vector<TimedPose>& poses) {
  std::string text = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
  for (const TimedPose& pose : poses) {
    const Vec3& p = pose.X_WT.p_AB;
    const Quat& q = pose.X_WT.R_AB;
    text += fmt::format("{},{},{},{},{},{},{},{}\n", pose.time_s, p.x, p.y, p.z, q.w, q.x, q.y, q.z);
  }
  return text;
}

}  // namespace kerf
