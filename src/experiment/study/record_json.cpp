#include "experiment/study/record_json.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "base/files/json_text.h"
#include "base/table/table_json.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_columns.h"
#include "experiment/study/study_csv.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

/// Reads a number, or NaN from null, since JSON has neither infinity nor NaN.
double NumberFrom(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

/// Reads a measured figure; all except the time of a breakthrough are at least 0.
double FigureFrom(const Json& json, const char* key) {
  const double value = NumberFrom(json.at(key));
  if (!(value >= 0 && std::isfinite(value))) throw Error(fmt::format("{} = {} is not a measured value", key, value));
  return value;
}

/// The figures of the costs of a tick in a record.
template <typename Figures, typename Visit>
void DescribeCosts(Figures& f, Visit&& visit) {
  for (const PercentileColumn& column : kPercentileColumns) visit(column.name, f.tick.*column.value);
  for (const CostColumn& column : kCostColumns) visit(column.name, f.*column.value);
}

}  // namespace

std::string_view ToString(CaseState state) {
  switch (state) {
    case CaseState::kDone:
      return "done";
    case CaseState::kFailed:
      return "failed";
    case CaseState::kOmitted:
      return "omitted";
  }
  return "failed";
}

CaseState StateFromString(const std::string& text) {
  for (const CaseState state : {CaseState::kDone, CaseState::kFailed, CaseState::kOmitted}) {
    if (text == ToString(state)) return state;
  }
  throw Error(fmt::format("\"{}\" is not a state of a case", text));
}

Holding HoldingFromString(const std::string& text) {
  for (const Holding holding : {Holding::kHand, Holding::kPath}) {
    if (text == ToString(holding)) return holding;
  }
  throw Error(fmt::format("\"{}\" is not a kind of holding", text));
}

std::uint64_t HashFromText(const std::string& text) {
  std::uint64_t hash = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
  if (error != std::errc() || end != text.data() + text.size()) throw Error(fmt::format("\"{}\" is not a hash", text));
  return hash;
}

Json ToJson(const ErrorFigures& errors) {
  Json json = Json::object();
  for (const ErrorColumn& column : kErrorColumns) json[column.name] = errors.*column.value;
  if (errors.breakthrough_ms) json["breakthrough_ms"] = *errors.breakthrough_ms;
  if (errors.impulse_signed) json["impulse_signed"] = *errors.impulse_signed;
  if (errors.temperature_K) json["temperature_K"] = *errors.temperature_K;
  if (errors.temperature_bar_K) json["temperature_bar_K"] = *errors.temperature_bar_K;
  return json;
}

ErrorFigures ErrorsFromJson(const Json& json) {
  ErrorFigures errors;
  for (const ErrorColumn& column : kErrorColumns) errors.*column.value = FigureFrom(json, column.name);
  if (json.contains("breakthrough_ms")) errors.breakthrough_ms = NumberFrom(json.at("breakthrough_ms"));
  if (json.contains("impulse_signed")) errors.impulse_signed = NumberFrom(json.at("impulse_signed"));
  if (json.contains("temperature_K")) errors.temperature_K = FigureFrom(json, "temperature_K");
  if (json.contains("temperature_bar_K")) errors.temperature_bar_K = FigureFrom(json, "temperature_bar_K");
  return errors;
}

Json ToJson(const CostFigures& costs) {
  Json json{{"ticks", costs.ticks}};
  DescribeCosts(costs, [&](const char* key, double value) { json[key] = value; });
  json["histogram"] = Json::array();
  for (const auto& [bucket, count] : costs.histogram) json["histogram"].push_back({bucket, count});
  return json;
}

CostFigures CostsFromJson(const Json& json) {
  CostFigures costs;
  if (!json.at("ticks").is_number_unsigned()) throw Error("ticks is not a count");
  costs.ticks = json.at("ticks");
  costs.tick.count = costs.ticks;
  DescribeCosts(costs, [&](const char* key, double& value) { value = FigureFrom(json, key); });
  for (const Json& item : json.at("histogram")) {
    if (!item.at(1).is_number_unsigned()) throw Error("the histogram has no count");
    costs.histogram.emplace_back(GetInt(item.at(0)), item.at(1));
  }
  return costs;
}

Json ToJson(const ReferenceRecord& reference) {
  return RowJson(ReferenceColumns(), reference);
}

ReferenceRecord ReferenceFromJson(const Json& json) {
  ReferenceRecord reference;
  reference.holding = HoldingFromString(json.at("holding"));
  reference.path = json.at("path");
  reference.variant = json.at("variant");
  reference.input_hash = HashFromText(json.at("input_hash"));
  reference.force_hash = HashFromText(json.at("force_hash"));
  reference.steps_per_tick = GetInt(json.at("steps_per_tick"));
  reference.error_bar = FigureFrom(json, "error_bar");
  reference.error_bar_l2 = FigureFrom(json, "error_bar_l2");
  reference.volume_bar = FigureFrom(json, "volume_bar");
  reference.seconds = FigureFrom(json, "seconds");
  reference.note = json.at("note");
  return reference;
}

Json ToJson(const RunInfo& machine) {
  return {{"cpu", machine.cpu}, {"cores", machine.cores}, {"load", machine.load}};
}

RunInfo MachineFromJson(const Json& json) {
  RunInfo machine;
  machine.cpu = json.at("cpu");
  machine.cores = GetInt(json.at("cores"));
  machine.load = NumberFrom(json.at("load"));
  return machine;
}

}  // namespace kerf
