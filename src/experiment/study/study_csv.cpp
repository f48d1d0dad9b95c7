#include "experiment/study/study_csv.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "base/core/csv.h"
#include "experiment/study/record_json.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_columns.h"
#include "kerf/version.h"

namespace kerf {
namespace {

std::string Words(std::string text) {
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = ' ';
  }
  return FormatCsvField(text);
}

// Adds the shortest text that reads back as the same double.
void AddNumber(std::string& csv, double value) {
  fmt::format_to(std::back_inserter(csv), ",{}", value);
}

void AddErrors(std::string& csv, const CaseRecord& record) {
  for (const ErrorColumn& column : kErrorColumns) {
    const bool jnd = column.jnd_name != nullptr;
    if (!record.errors) {
      csv += jnd ? ",," : ",";
      continue;
    }
    const double value = *record.errors.*column.value;
    AddNumber(csv, value);
    if (jnd) AddNumber(csv, value / column.per_jnd);
  }
  for (const OptionalErrorColumn& column : kOptionalErrorColumns) {
    if (record.errors && *record.errors.*column.value)
      AddNumber(csv, *(*record.errors.*column.value));
    else
      csv += ",";
  }
}

void AddCosts(std::string& csv, const CaseRecord& record) {
  if (!record.costs) {
    csv.append(1 + kPercentilesColumns.size() * (1 + kPercentileColumns.size()) + kCostColumns.size(), ',');
    return;
  }
  fmt::format_to(std::back_inserter(csv), ",{}", record.costs->ticks);
  for (const PercentilesColumns& columns : kPercentilesColumns) {
    const Percentiles& times = *record.costs.*columns.value;
    fmt::format_to(std::back_inserter(csv), ",{}", times.count);
    for (const PercentileColumn& column : kPercentileColumns) AddNumber(csv, times.*column.value);
  }
  for (const CostColumn& column : kCostColumns) AddNumber(csv, *record.costs.*column.value);
}

}  // namespace

std::string FormatCasesCsv(const StudyResults& study) {
  std::string csv = "id,holding,path,knob,value,number,state,why";
  for (const ErrorColumn& column : kErrorColumns) {
    csv += fmt::format(",{}", column.name);
    if (column.jnd_name != nullptr) csv += fmt::format(",{}", column.jnd_name);
  }
  for (const OptionalErrorColumn& column : kOptionalErrorColumns) csv += fmt::format(",{}", column.name);
  csv += ",ticks";
  for (const PercentilesColumns& columns : kPercentilesColumns) {
    csv += fmt::format(",{}count", columns.prefix);
    for (const PercentileColumn& column : kPercentileColumns) csv += fmt::format(",{}{}", columns.prefix, column.name);
  }
  for (const CostColumn& column : kCostColumns) csv += fmt::format(",{}", column.name);
  csv += ",force_hash,bone_hash\n";
  for (const CaseRecord& record : study.cases) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{}", Words(record.id), ToString(record.holding),
                   Words(record.path), Words(record.knob), Words(record.value));
    AddNumber(csv, record.number);
    fmt::format_to(std::back_inserter(csv), ",{},{}", ToString(record.state), Words(record.why));
    AddErrors(csv, record);
    AddCosts(csv, record);
    fmt::format_to(std::back_inserter(csv), ",{:016x},{:016x}\n", record.force_hash, record.bone_hash);
  }
  return csv;
}

std::string FormatTimesCsv(const StudyResults& study) {
  std::string csv = "id,bucket,upper_edge_us,count\n";
  for (const CaseRecord& record : study.cases) {
    if (!record.costs) continue;
    for (const auto& [bucket, count] : record.costs->histogram) {
      fmt::format_to(std::back_inserter(csv), "{},{},{},{}\n", Words(record.id), bucket,
                     LogHistogram::UpperEdge_us(static_cast<std::size_t>(bucket)), count);
    }
  }
  return csv;
}

std::string FormatReferencesCsv(const StudyResults& study) {
  std::string csv =
      "holding,path,variant,input_hash,force_hash,steps_per_tick,error_bar,error_bar_l2,volume_bar,seconds,note\n";
  for (const ReferenceRecord& r : study.references) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{:016x},{:016x},{}", ToString(r.holding), Words(r.path),
                   Words(r.variant), r.input_hash, r.force_hash, r.steps_per_tick);
    for (const double value : {r.error_bar, r.error_bar_l2, r.volume_bar, r.seconds}) AddNumber(csv, value);
    fmt::format_to(std::back_inserter(csv), ",{}\n", Words(r.note));
  }
  return csv;
}

std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files) {
  using nlohmann::ordered_json;
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", study.commit}, {"build", study.build}};
  json["schema"] = 1;
  json["name"] = study.name;
  json["title"] = study.title;
  json["command"] = study.command;
  json["machine"] = {{"cpu", study.machine.cpu}, {"cores", study.machine.cores}, {"load", study.machine.load}};
  json["seconds"] = study.seconds;
  for (const Knob& knob : StudyKnobs()) json["base"][knob.name] = ValueOf(study.base, knob.name);
  json["paths"] = study.paths;
  json["path_titles"] = study.path_titles;
  json["knobs"] = study.knobs;
  json["left_out"] = ordered_json::array();  // for the user; cases.csv contains the same
  for (const CaseRecord& record : study.cases) {
    if (record.state == CaseState::kDone) continue;
    json["left_out"].push_back({{"id", record.id}, {"state", ToString(record.state)}, {"why", record.why}});
  }
  json["files"] = files;
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
