// A study as it is stored in its folder.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/files/json_text.h"
#include "experiment/study/record_json.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_file.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

Json WordsOf(const std::vector<Holding>& holdings) {
  Json words = Json::array();
  for (const Holding holding : holdings) words.push_back(ToString(holding));
  return words;
}

std::vector<Holding> HoldingsFrom(const Json& words) {
  std::vector<Holding> holdings;
  for (const std::string word : words) holdings.push_back(HoldingFromString(word));
  return holdings;
}

/// Returns the part of a specification that the results depend on.
Json CoreOf(const StudySpec& spec) {
  Json json;
  json["paths"] = spec.paths;
  json["scenes"] = Json::array();
  for (const StudyScene& scene : spec.scenes) {
    json["scenes"].push_back({{"name", scene.name}, {"content_hash", ShowHash(scene.content_hash)}});
  }
  json["holdings"] = WordsOf(spec.holdings);
  json["cost_paths"] = spec.cost_paths;
  json["ticks_per_case"] = spec.ticks_per_case;
  json["ticks_of_defaults"] = spec.ticks_of_defaults;
  json["reference_tolerance"] = spec.reference_tolerance;
  for (const Knob& knob : StudyKnobs()) json["base"][knob.name] = ValueOf(spec.base, knob.name);
  json["knobs"] = Json::array();
  for (const KnobSweep& sweep : spec.knobs) {
    json["knobs"].push_back({{"knob", sweep.knob},
                             {"values", sweep.values},
                             {"paths", sweep.paths},
                             {"holdings", WordsOf(sweep.holdings)}});
  }
  return json;
}

}  // namespace

Json SpecToJson(const StudySpec& spec) {
  Json json{{"name", spec.name}, {"title", spec.title}};
  json.update(CoreOf(spec));
  for (std::size_t i = 0; i < spec.scenes.size(); ++i) json["scenes"][i]["file"] = spec.scenes[i].file;
  return json;
}

std::uint64_t HashOf(const StudySpec& spec) {
  return HashText(CoreOf(spec).dump());
}

StudySpec SpecFromJson(const Json& json) {
  try {
    StudySpec spec;
    spec.name = json.at("name");
    spec.title = json.at("title");
    spec.paths = json.at("paths");
    for (const Json& item : json.at("scenes")) {
      spec.scenes.push_back({item.at("name"), item.at("file"), HashFromText(item.at("content_hash"))});
    }
    spec.holdings = HoldingsFrom(json.at("holdings"));
    spec.cost_paths = json.at("cost_paths");
    spec.ticks_per_case = GetInt(json.at("ticks_per_case"));
    spec.ticks_of_defaults = GetInt(json.at("ticks_of_defaults"));
    spec.reference_tolerance = json.at("reference_tolerance");
    for (const auto& [knob, value] : json.at("base").items()) SetValue(spec.base, knob, value);
    for (const Json& item : json.at("knobs")) {
      spec.knobs.push_back({item.at("knob"), item.at("values"), item.at("paths"), HoldingsFrom(item.at("holdings"))});
    }
    return spec;
  } catch (const nlohmann::json::exception& e) {
    throw Error(fmt::format("it is not a study description ({})", e.what()));
  }
}

}  // namespace kerf
