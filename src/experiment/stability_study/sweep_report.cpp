// Output and files of `kerf stability --sweep`.
#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "base/core/csv.h"
#include "experiment/stability_study/sweep.h"
#include "kerf/version.h"

namespace kerf {
namespace {

constexpr SweepVerdict kVerdicts[] = {SweepVerdict::kPass,    SweepVerdict::kFail,      SweepVerdict::kWarned,
                                      SweepVerdict::kRefused, SweepVerdict::kNotJudged, SweepVerdict::kNotRun};

const char* Word(SweepVerdict verdict) {
  switch (verdict) {
    case SweepVerdict::kPass:
      return "pass";
    case SweepVerdict::kFail:
      return "fail";
    case SweepVerdict::kWarned:
      return "warned";
    case SweepVerdict::kRefused:
      return "refused";
    case SweepVerdict::kNotJudged:
      return "not_judged";
    case SweepVerdict::kNotRun:
      break;
  }
  return "not_run";
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

std::string FormatSweepCsv(const SweepStudy& study) {
  std::string csv = "verdict,key_1,value_1,key_2,value_2,wall_s,reason\n";
  for (const SweepRow& row : study.rows) {
    csv += Word(row.verdict);
    for (std::size_t i = 0; i < 2; ++i) {
      csv += i < row.settings.size() ? fmt::format(",{},{:.9g}", row.settings[i].key, row.settings[i].value) : ",,";
    }
    csv += fmt::format(",{:.3f},{}\n", row.wall_s, FormatCsvField(row.reason));
  }
  return csv;
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
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
