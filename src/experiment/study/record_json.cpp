#include "experiment/study/record_json.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "base/files/json_text.h"
#include "experiment/study/settings.h"
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

// The only list of these names, for both reading and writing.
template <typename Figures, typename Visit>
void DescribeErrors(Figures& f, Visit&& visit) {
  visit("force_l2", f.force_l2);
  visit("force_worst_N", f.force_worst_N);
  visit("force_p95", f.force_p95);
  visit("force_worst", f.force_worst);
  visit("direction_p95_deg", f.direction_p95_deg);
  visit("direction_worst_deg", f.direction_worst_deg);
  visit("impulse", f.impulse);
  visit("noise_N", f.noise_N);
  visit("volume", f.volume);
  visit("surface_mean_mm", f.surface_mean_mm);
  visit("surface_p95_mm", f.surface_p95_mm);
  visit("surface_max_mm", f.surface_max_mm);
}

template <typename Figures, typename Visit>
void DescribeCosts(Figures& f, Visit&& visit) {
  visit("p50_us", f.tick.p50_us);
  visit("p99_us", f.tick.p99_us);
  visit("p999_us", f.tick.p999_us);
  visit("max_us", f.tick.max_us);
  visit("misses_per_million", f.misses_per_million);
  visit("memory_MB", f.memory_MB);
  visit("setup_s", f.setup_s);
  visit("whole_s", f.whole_s);
}

template <typename Figures, typename Visit>
void DescribeReference(Figures& f, Visit&& visit) {
  visit("error_bar", f.error_bar);
  visit("error_bar_l2", f.error_bar_l2);
  visit("volume_bar", f.volume_bar);
  visit("seconds", f.seconds);
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
  DescribeErrors(errors, [&](const char* key, double value) { json[key] = value; });
  if (errors.breakthrough_ms) json["breakthrough_ms"] = *errors.breakthrough_ms;
  if (errors.impulse_signed) json["impulse_signed"] = *errors.impulse_signed;
  if (errors.temperature_K) json["temperature_K"] = *errors.temperature_K;
  if (errors.temperature_bar_K) json["temperature_bar_K"] = *errors.temperature_bar_K;
  return json;
}

ErrorFigures ErrorsFromJson(const Json& json) {
  ErrorFigures errors;
  DescribeErrors(errors, [&](const char* key, double& value) { value = FigureFrom(json, key); });
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
  Json json{{"holding", ToString(reference.holding)},
            {"path", reference.path},
            {"variant", reference.variant},
            {"input_hash", ShowHash(reference.input_hash)},
            {"force_hash", ShowHash(reference.force_hash)},
            {"steps_per_tick", reference.steps_per_tick}};
  DescribeReference(reference, [&](const char* key, double value) { json[key] = value; });
  json["note"] = reference.note;
  return json;
}

ReferenceRecord ReferenceFromJson(const Json& json) {
  ReferenceRecord reference;
  reference.holding = HoldingFromString(json.at("holding"));
  reference.path = json.at("path");
  reference.variant = json.at("variant");
  reference.input_hash = HashFromText(json.at("input_hash"));
  reference.force_hash = HashFromText(json.at("force_hash"));
  reference.steps_per_tick = GetInt(json.at("steps_per_tick"));
  DescribeReference(reference, [&](const char* key, double& value) { value = FigureFrom(json, key); });
  reference.note = json.at("note");
  return reference;
}

Json ToJson(const MachineState& machine) {
  return {{"cpu", machine.cpu}, {"cores", machine.cores}, {"load", machine.load}};
}

MachineState MachineFromJson(const Json& json) {
  return {json.at("cpu"), GetInt(json.at("cores")), NumberFrom(json.at("load"))};
}

}  // namespace kerf
