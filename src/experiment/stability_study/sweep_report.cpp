// Output and files of `kerf stability --sweep`.
#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "base/table/table_json.h"
#include "experiment/stability_study/sweep.h"
#include "kerf/version.h"

namespace kerf {
namespace {

constexpr SweepVerdict kVerdicts[] = {SweepVerdict::kPass,    SweepVerdict::kFail,      SweepVerdict::kWarned,
                                      SweepVerdict::kRefused, SweepVerdict::kNotJudged, SweepVerdict::kNotRun};

/// Returns the verdict as a word of a file: "not_run".
std::string Word(SweepVerdict verdict) {
  std::string word = ToString(verdict);
  for (char& c : word) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

}  // namespace

std::string DescribeSettings(const std::vector<SweepSetting>& settings) {
  std::string text;
  for (const SweepSetting& setting : settings) {
    text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", setting.key, setting.value);
  }
  return text.empty() ? "unchanged" : text;
}

std::string FormatSweepTable(const SweepStudy& study) {
  std::string text;
  for (const SweepRow& row : study.rows) {
    fmt::format_to(std::back_inserter(text), "  {:<10} {}{}{}\n", ToString(row.verdict), DescribeSettings(row.settings),
                   row.reason.empty() ? "" : ": ", row.reason);
  }
  fmt::format_to(std::back_inserter(text), "\n  {} keys, {} cases, seed {}:", study.keys, study.rows.size(),
                 study.seed);
  const char* separator = " ";
  for (const SweepVerdict verdict : kVerdicts) {
    fmt::format_to(std::back_inserter(text), "{}{} {}", separator, study.Count(verdict), ToString(verdict));
    separator = ", ";
  }
  return text + "\n";
}

const Columns<SweepRow>& SweepColumns() {
  const auto key = [](std::size_t i) {
    return [i](const SweepRow& r) { return i < r.settings.size() ? TableCell(r.settings[i].key) : TableCell(); };
  };
  const auto value = [](std::size_t i) {
    return [i](const SweepRow& r) { return i < r.settings.size() ? TableCell(r.settings[i].value) : TableCell(); };
  };
  const char* const kSettings = "the changed keys of the scene and their values; empty if fewer were changed";
  static const Columns<SweepRow> kColumns{
      {"verdict", "{}", "`pass`, `fail`, `warned`, `refused`, `not_judged` or `not_run`",
       [](const SweepRow& r) { return Word(r.verdict); }},
      {"key_1", "{}", kSettings, key(0)},
      {"value_1", "{:.9g}", kSettings, value(0)},
      {"key_2", "{}", kSettings, key(1)},
      {"value_2", "{:.9g}", kSettings, value(1)},
      {"wall_s", "{:.3f}", "time of the case", &SweepRow::wall_s},
      {"reason", "{}", "one line; empty if passed", &SweepRow::reason}};
  return kColumns;
}

std::string FormatSweepJson(const SweepStudy& study) {
  using nlohmann::ordered_json;
  ordered_json rows = ordered_json::array();
  for (const SweepRow& row : study.rows) {
    ordered_json settings = ordered_json::object();
    for (const SweepSetting& setting : row.settings) settings[setting.key] = setting.value;
    rows.push_back({{"settings", settings},
                    {"verdict", Word(row.verdict)},
                    {"reason", row.reason},
                    {"warnings", row.warnings},
                    {"wall_s", row.wall_s}});
  }
  ordered_json counts;
  for (const SweepVerdict verdict : kVerdicts) counts[Word(verdict)] = study.Count(verdict);
  const ordered_json json = {{"kerf", VersionString()},
                             {"commit", CommitString()},
                             {"schema", 1},
                             {"scene", study.scene},
                             {"title", study.title},
                             {"keys", study.keys},
                             {"seed", study.seed},
                             {"complete", study.complete},
                             {"counts", counts},
                             {"rows", rows}};
  return DumpJson(json);
}

}  // namespace kerf
