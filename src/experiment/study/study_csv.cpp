#include "experiment/study/study_csv.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/table/table_json.h"
#include "experiment/study/record_json.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_columns.h"
#include "kerf/version.h"

namespace kerf {
namespace {

std::string Words(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  return text;
}

/// Adds the column of a figure that cases without `part` (errors, costs) lack.
template <typename Part, typename Get>
void AddFigure(Columns<CaseRecord>& columns, const std::string& name, const std::string& meaning,
               std::optional<Part> CaseRecord::*part, Get get) {
  columns.push_back({name, "{}", meaning, [part, get](const CaseRecord& record) -> TableCell {
                       return record.*part ? TableCell(std::invoke(get, *(record.*part))) : TableCell();
                     }});
}

}  // namespace

const Columns<CaseRecord>& CaseColumns() {
  static const Columns<CaseRecord> kColumns = [] {
    const char* const kKnob = "the varied setting, or `default`; its value, as text and, if it is one, as a number";
    const char* const kState = "`done`, `failed` or `omitted`; the reason";
    Columns<CaseRecord> columns{{"id", "{}", "name of the case", [](const CaseRecord& r) { return Words(r.id); }},
                                {"holding", "{}", "`hand`: coupled to a handle; `path`: on a prescribed path",
                                 [](const CaseRecord& r) { return ToString(r.holding); }},
                                {"path", "{}", "name of the path", [](const CaseRecord& r) { return Words(r.path); }},
                                {"knob", "{}", kKnob, [](const CaseRecord& r) { return Words(r.knob); }},
                                {"value", "{}", kKnob, [](const CaseRecord& r) { return Words(r.value); }},
                                {"number", "{}", kKnob, &CaseRecord::number},
                                {"state", "{}", kState, [](const CaseRecord& r) { return ToString(r.state); }},
                                {"why", "{}", kState, [](const CaseRecord& r) { return Words(r.why); }}};
    for (const ErrorColumn& c : kErrorColumns) {
      AddFigure(columns, c.name, c.meaning, &CaseRecord::errors, c.value);
      if (c.jnd_name == nullptr) continue;
      AddFigure(columns, c.jnd_name, c.meaning, &CaseRecord::errors,
                [c](const ErrorFigures& errors) { return errors.*c.value / c.per_jnd; });
    }
    for (const OptionalErrorColumn& c : kOptionalErrorColumns) {
      AddFigure(columns, c.name, c.meaning, &CaseRecord::errors, c.value);
    }
    AddFigure(columns, "ticks", "number of ticks of a pass along the path", &CaseRecord::costs, &CostFigures::ticks);
    for (const PercentilesColumns& c : kPercentilesColumns) {
      AddFigure(columns, fmt::format("{}count", c.prefix), c.meaning, &CaseRecord::costs,
                [c](const CostFigures& costs) { return (costs.*c.value).count; });
      for (const PercentileColumn& p : kPercentileColumns) {
        AddFigure(columns, fmt::format("{}{}", c.prefix, p.name), c.meaning, &CaseRecord::costs,
                  [c, p](const CostFigures& costs) { return costs.*c.value.*p.value; });
      }
    }
    for (const CostColumn& c : kCostColumns) AddFigure(columns, c.name, c.meaning, &CaseRecord::costs, c.value);
    const char* const kHashes = "hashes of the force of every tick and of the bone at the end";
    columns.push_back({"force_hash", "{}", kHashes, [](const CaseRecord& r) { return ShowHash(r.force_hash); }});
    columns.push_back({"bone_hash", "{}", kHashes, [](const CaseRecord& r) { return ShowHash(r.bone_hash); }});
    return columns;
  }();
  return kColumns;
}

const Columns<BucketRow>& BucketColumns() {
  const char* const kBucket = "number of the bucket of times, of which an octave has 32; its upper edge";
  static const Columns<BucketRow> kColumns{
      {"id", "{}", "name of the case", [](const BucketRow& r) { return Words(r.id); }},
      {"bucket", "{}", kBucket, &BucketRow::bucket},
      {"upper_edge_us", "{}", kBucket,
       [](const BucketRow& r) { return LogHistogram::UpperEdge_us(static_cast<std::size_t>(r.bucket)); }},
      {"count", "{}", "number of ticks in it", &BucketRow::count}};
  return kColumns;
}

const Columns<ReferenceRecord>& ReferenceColumns() {
  using Record = ReferenceRecord;
  const char* const kBar = "difference of the last two refinements: `force_p95`, `force_l2`, `volume`";
  static const Columns<Record> kColumns{
      {"holding", "{}", "as in `cases.csv`", [](const Record& r) { return ToString(r.holding); }},
      {"path", "{}", "as in `cases.csv`", [](const Record& r) { return Words(r.path); }},
      {"variant", "{}", "law, unless it is hertz_chip, and material, unless it is that of the regions",
       [](const Record& r) { return Words(r.variant); }},
      {"input_hash", "{}", "hash of the poses", [](const Record& r) { return ShowHash(r.input_hash); }},
      {"force_hash", "{}", "hash of the forces", [](const Record& r) { return ShowHash(r.force_hash); }},
      {"steps_per_tick", "{}", "of the last refinement", &Record::steps_per_tick},
      {"error_bar", "{}", kBar, &Record::error_bar},
      {"error_bar_l2", "{}", kBar, &Record::error_bar_l2},
      {"volume_bar", "{}", kBar, &Record::volume_bar},
      {"seconds", "{}", "time of the computation", &Record::seconds},
      {"note", "{}", "a remark, for example that it did not converge", [](const Record& r) { return Words(r.note); }}};
  return kColumns;
}

std::vector<BucketRow> ListBuckets(const StudyResults& study) {
  std::vector<BucketRow> rows;
  for (const CaseRecord& record : study.cases) {
    if (!record.costs) continue;
    for (const auto& [bucket, count] : record.costs->histogram) rows.push_back({record.id, bucket, count});
  }
  return rows;
}

std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files) {
  using nlohmann::ordered_json;
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", study.commit}, {"build", study.build}};
  json["schema"] = 1;
  json["name"] = study.name;
  json["title"] = study.title;
  json["command"] = study.command;
  json["machine"] = ToJson(study.machine);
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
  return DumpJson(json);
}

}  // namespace kerf
