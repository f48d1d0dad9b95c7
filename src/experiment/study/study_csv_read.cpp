#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "base/core/csv.h"
#include "base/files/files.h"
#include "base/files/json_text.h"
#include "experiment/study/knobs.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_columns.h"
#include "experiment/study/study_csv.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

/// A column that is derived from another one counts as damaged if it deviates by more than this fraction.
constexpr double kSame = 1e-9;

/// Reads the fields of a row one after another, and knows the names of their columns.
class Row {
 public:
  Row(const std::vector<std::string>& names, const std::vector<std::string>& fields, const CsvPlace& place)
      : names_(names), fields_(fields), place_(place) {}

  const std::string& Text() { return fields_[next_++]; }
  bool NextIsEmpty() const { return fields_[next_].empty(); }
  double Number() {
    const char* name = names_[next_].c_str();
    const std::string& text = Text();
    if (text == "nan" || text == "-nan") return std::numeric_limits<double>::quiet_NaN();
    if (text == "inf") return std::numeric_limits<double>::infinity();
    if (text == "-inf") return -std::numeric_limits<double>::infinity();
    return ParseCsvNumber(text, 0, name, place_);
  }
  template <typename Whole>
  Whole WholeNumber(int base = 10) {
    const std::string& name = names_[next_];
    const std::string& text = Text();
    Whole value{};
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (code != std::errc() || end != text.data() + text.size()) {
      place_.Fail(fmt::format("{} = {} is not a whole number{}", name, Quote(text), base == 16 ? " in base 16" : ""));
    }
    return value;
  }
  void Empty(const char* why) {
    const std::string& name = names_[next_];
    const std::string& text = Text();
    if (!text.empty()) place_.Fail(fmt::format("{} = {} must be empty in a row {}", name, Quote(text), why));
  }
  Holding ParseHolding() {
    const std::string& text = Text();
    if (text == ToString(Holding::kHand)) return Holding::kHand;
    if (text != ToString(Holding::kPath)) {
      place_.Fail(fmt::format("holding = {} is neither \"hand\" nor \"path\"", Quote(text)));
    }
    return Holding::kPath;
  }
  CaseState ParseState() {
    const std::string& text = Text();
    if (text == "done") return CaseState::kDone;
    if (text == "failed") return CaseState::kFailed;
    if (text != "omitted") {
      place_.Fail(fmt::format("state = {} is not \"done\", \"failed\" or \"omitted\"", Quote(text)));
    }
    return CaseState::kOmitted;
  }
  const std::string& name() const { return names_[next_]; }
  const CsvPlace& place() const { return place_; }

 private:
  const std::vector<std::string>& names_;
  const std::vector<std::string>& fields_;
  const CsvPlace& place_;
  std::size_t next_ = 0;
};

std::optional<ErrorFigures> ReadErrors(Row& row) {
  const bool none = row.NextIsEmpty();
  constexpr const char* kWhy = "that has no errors";
  ErrorFigures errors;
  for (const ErrorColumn& column : kErrorColumns) {
    if (none) {
      row.Empty(kWhy);
      if (column.jnd_name != nullptr) row.Empty(kWhy);
      continue;
    }
    const double value = row.Number();
    errors.*column.value = value;
    if (column.jnd_name == nullptr) continue;
    const std::string name = row.name();
    const double jnd = row.Number() * column.per_jnd;
    if (std::isfinite(value) && !(std::abs(jnd - value) <= kSame * std::abs(value))) {
      row.place().Fail(fmt::format("{} = {} is not {} = {} in just-noticeable differences", name, jnd / column.per_jnd,
                                   column.name, value));
    }
  }
  for (const OptionalErrorColumn& column : kOptionalErrorColumns) {
    if (row.name() != column.name) continue;  // the file was written by a version without this column
    if (none)
      row.Empty(kWhy);
    else if (row.NextIsEmpty())
      row.Empty("");
    else
      errors.*column.value = row.Number();
  }
  return none ? std::nullopt : std::optional(errors);
}

std::optional<CostFigures> ReadCosts(Row& row) {
  if (row.NextIsEmpty()) {
    const std::size_t columns = 1 + kPercentilesColumns.size() * (1 + kPercentileColumns.size()) + kCostColumns.size();
    for (std::size_t i = 0; i < columns; ++i) row.Empty("that has no costs");
    return std::nullopt;
  }
  CostFigures costs;
  costs.ticks = row.WholeNumber<std::uint64_t>();
  for (const PercentilesColumns& columns : kPercentilesColumns) {
    Percentiles& times = costs.*columns.value;
    times.count = row.WholeNumber<std::size_t>();
    for (const PercentileColumn& column : kPercentileColumns) times.*column.value = row.Number();
  }
  for (const CostColumn& column : kCostColumns) costs.*column.value = row.Number();
  return costs;
}

bool IsKnob(const std::string& name) {
  const std::vector<Knob>& knobs = StudyKnobs();
  return std::any_of(knobs.begin(), knobs.end(), [&](const Knob& knob) { return knob.name == name; });
}

void ReadCases(const std::string& folder, StudyResults& study, std::map<std::string, std::size_t>& index) {
  const std::string file = folder + "/cases.csv";
  const std::string csv = ReadTextFile(file);
  std::vector<std::string> names = NamesOf(CaseColumns());
  // Files of earlier versions lack this column, and their cases lack this figure.
  if (csv.substr(0, csv.find('\n')).find(kImpulseSigned) == std::string::npos) std::erase(names, kImpulseSigned);
  ReadCsv(csv, file, names, [&](const std::vector<std::string>& fields, const CsvPlace& place) {
    Row row(names, fields, place);
    CaseRecord record;
    record.id = row.Text();
    record.holding = row.ParseHolding();
    record.path = row.Text();
    record.knob = row.Text();
    if (record.knob != "default" && !IsKnob(record.knob)) {
      place.Fail(fmt::format("there is no knob {}; was the study written by a newer kerf?", Quote(record.knob)));
    }
    record.value = row.Text();
    record.number = row.Number();
    record.state = row.ParseState();
    record.why = row.Text();
    record.errors = ReadErrors(row);
    record.costs = ReadCosts(row);
    record.force_hash = row.WholeNumber<std::uint64_t>(16);
    record.bone_hash = row.WholeNumber<std::uint64_t>(16);
    if (!index.emplace(record.id, study.cases.size()).second) {
      place.Fail(fmt::format("the case {} is present twice", Quote(record.id)));
    }
    study.cases.push_back(std::move(record));
  });
}

void ReadTimes(const std::string& folder, StudyResults& study, const std::map<std::string, std::size_t>& index) {
  const std::string file = folder + "/cases_times.csv";
  const std::vector<std::string> names = NamesOf(BucketColumns());
  ReadCsv(ReadTextFile(file), file, names, [&](const std::vector<std::string>& fields, const CsvPlace& place) {
    Row row(names, fields, place);
    const auto found = index.find(row.Text());
    if (found == index.end()) place.Fail(fmt::format("there is no case {} in cases.csv", Quote(fields[0])));
    CaseRecord& record = study.cases[found->second];
    if (!record.costs) place.Fail(fmt::format("the case {} has no costs in cases.csv", Quote(record.id)));
    const int bucket = row.WholeNumber<int>();
    if (bucket < 0 || static_cast<std::size_t>(bucket) >= LogHistogram::kBuckets) {
      place.Fail(fmt::format("bucket = {} is not one of 0 to {}", bucket, LogHistogram::kBuckets - 1));
    }
    const double edge_us = row.Number();
    const double expected_us = LogHistogram::UpperEdge_us(static_cast<std::size_t>(bucket));
    if (edge_us != expected_us) {
      place.Fail(fmt::format("upper_edge_us = {} is not the upper edge of bucket {}, which is {}", edge_us, bucket,
                             expected_us));
    }
    record.costs->histogram.emplace_back(bucket, row.WholeNumber<std::uint64_t>());
  });
}

void ReadReferences(const std::string& folder, StudyResults& study) {
  const std::string file = folder + "/references.csv";
  const std::vector<std::string> names = NamesOf(ReferenceColumns());
  ReadCsv(ReadTextFile(file), file, names, [&](const std::vector<std::string>& fields, const CsvPlace& place) {
    Row row(names, fields, place);
    ReferenceRecord record;
    record.holding = row.ParseHolding();
    record.path = row.Text();
    record.variant = row.Text();
    record.input_hash = row.WholeNumber<std::uint64_t>(16);
    record.force_hash = row.WholeNumber<std::uint64_t>(16);
    record.steps_per_tick = row.WholeNumber<int>();
    record.error_bar = row.Number();
    record.error_bar_l2 = row.Number();
    record.volume_bar = row.Number();
    record.seconds = row.Number();
    record.note = row.Text();
    study.references.push_back(std::move(record));
  });
}

/// Returns the value of a key. If it is invalid, throws Error with the context that the exception of the JSON library
/// lacks.
template <typename Value>
Value Get(const Json& object, const char* key, const std::string& file) {
  const auto found = object.find(key);
  if (found == object.end()) throw Error(fmt::format("{}: \"{}\" is missing", file, key));
  try {
    if constexpr (std::is_same_v<Value, int>) return GetInt(*found);
    return found->get<Value>();
  } catch (const std::exception&) {  // an exception of the JSON library, or Error
    throw Error(fmt::format("{}: \"{}\" = {} is not a valid value in a study", file, key, Quote(found->dump())));
  }
}

void ReadJson(const std::string& folder, StudyResults& study) {
  const std::string file = folder + "/study.json";
  const std::string text = ReadTextFile(file);
  CheckJsonDepth(text, file);
  Json all;
  try {
    all = Json::parse(text);
  } catch (const Json::parse_error& e) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(e.byte, text.size()));
    throw Error(fmt::format("{}:{}: this is not JSON", file, 1 + std::count(text.begin(), end, '\n')));
  } catch (const Json::exception&) {
    throw Error(fmt::format("{}: a number in it is too large", file));
  }
  if (!all.is_object()) throw Error(fmt::format("{}:1: this is not a study", file));
  if (const int schema = Get<int>(all, "schema", file); schema != 1) {
    throw Error(fmt::format("{}: schema {} is not supported; this kerf reads 1", file, schema));
  }
  const Json kerf = Get<Json>(all, "kerf", file);
  const Json machine = Get<Json>(all, "machine", file);
  study.commit = Get<std::string>(kerf, "commit", file);
  study.build = Get<std::string>(kerf, "build", file);
  study.name = Get<std::string>(all, "name", file);
  study.title = Get<std::string>(all, "title", file);
  study.command = Get<std::string>(all, "command", file);
  study.machine.cpu = Get<std::string>(machine, "cpu", file);
  study.machine.cores = Get<int>(machine, "cores", file);
  study.machine.load = Get<double>(machine, "load", file);
  study.seconds = Get<double>(all, "seconds", file);
  study.paths = Get<std::vector<std::string>>(all, "paths", file);
  study.path_titles = Get<std::map<std::string, std::string>>(all, "path_titles", file);
  study.knobs = Get<std::vector<std::string>>(all, "knobs", file);
  for (const auto& [knob, value] : Get<std::map<std::string, std::string>>(all, "base", file)) {
    try {
      SetValue(study.base, knob, value);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: in \"base\", {}", file, e.what()));
    }
  }
  for (const std::string& knob : study.knobs) {
    if (!IsKnob(knob))
      throw Error(fmt::format("{}: there is no knob {}; was the study written by a newer kerf?", file, Quote(knob)));
  }
}

}  // namespace

StudyResults ReadStudyResults(const std::string& folder) {
  StudyResults study;
  std::map<std::string, std::size_t> index;
  ReadJson(folder, study);
  ReadCases(folder, study, index);
  ReadTimes(folder, study, index);
  ReadReferences(folder, study);
  return study;
}

}  // namespace kerf
