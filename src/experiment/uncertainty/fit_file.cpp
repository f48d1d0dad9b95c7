#include "experiment/uncertainty/fit_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/files/json_text.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kFitSchema = 1;
constexpr double kSixDigits = 1e-5;  // relative rounding of law.toml, doubled

FitInterval MakeInterval(const LawParameter& p, double value, const nlohmann::json& ends, const char* basis) {
  const auto [lower, upper] = ends.get<std::array<double, 2>>();
  if (ends.size() != 2 || !(lower <= value && value <= upper)) {
    throw Error(fmt::format("{} is not an interval about {} = {:g}", ends.dump(), p.key, value));
  }
  return {p.key, std::clamp(lower, p.lower, p.upper), std::clamp(upper, p.lower, p.upper), basis};
}

}  // namespace

std::vector<FitInterval> ParseFit(const std::string& text, const std::string& file, const ForceLaw& law,
                                  double edge_radius_um) {
  const nlohmann::json json = ParseJson(text, file);
  try {
    if (GetInt(json.at("schema")) != kFitSchema) throw Error("it has another version of the format");
    if (const std::string fitted = json.at("law"); fitted != law.name()) {
      throw Error(fmt::format("it is a fit of the law {}, and the scene has {}", fitted, law.name()));
    }
    const bool of_specimens = json.at("bootstrap").at("of") == "specimens";
    std::vector<FitInterval> fit;
    std::set<std::string> listed;
    for (const nlohmann::json& parameter : json.at("parameters")) {
      const std::string key = parameter.at("key");
      const std::string state = parameter.at("state");
      const bool of_tool = key == "edge_radius_um";
      const double value = parameter.at("value");
      const double own = of_tool ? edge_radius_um : law.Get(key);
      if (!(std::abs(own - value) <= kSixDigits * std::abs(value))) {
        throw Error(fmt::format("its {} is {:g}, and the scene has {:g}; use {}", key, value, own,
                                of_tool ? "a tool with that edge" : "the [force] of law.toml"));
      }
      if (!listed.insert(key).second) throw Error(key + " is listed twice");
      // The intervals of the others hold for a parameter at 0.
      if (state == "kept" || state == "not determined" || state == "at 0") continue;
      if (state != "fitted") throw Error(fmt::format("{} has the unknown state {}", key, state));
      const LawParameter& p = *std::ranges::find(law.info().parameters, key, &LawParameter::key);
      const nlohmann::json& bootstrap = parameter.at("bootstrap_interval");
      const nlohmann::json& interval = parameter.at("interval");
      if (of_specimens && !bootstrap.is_null()) {
        fit.push_back(MakeInterval(p, value, bootstrap, "95 % interval of the fit, bootstrap over specimens"));
      } else if (!interval.is_null()) {
        fit.push_back(MakeInterval(p, value, interval, "95 % interval of the fit, t distribution"));
      } else {
        throw Error(key + " has no interval");
      }
    }
    if (fit.empty()) throw Error("it has no fitted parameter");
    return fit;
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: is not a calibrate.json of 'kerf calibrate', or is damaged", file));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: cannot be used as the fit: {}", file, e.what()));
  }
}

}  // namespace kerf
