#include "experiment/uncertainty/fit_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/files/json_text.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kFitSchema = 1;
constexpr double kSixDigits = 1e-5;  // relative rounding of law.toml, doubled

FitInterval MakeInterval(const LawParameter& p, const nlohmann::json& ends, const char* basis) {
  const auto [lower, upper] = ends.get<std::array<double, 2>>();
  if (ends.size() != 2 || !(lower <= upper)) {
    throw Error(fmt::format("{} is not an interval of {}", ends.dump(), p.key));
  }
  return {p.key, std::clamp(lower, p.lower, p.upper), std::clamp(upper, p.lower, p.upper), basis};
}

}  // namespace

std::vector<FitInterval> ParseFit(const std::string& text, const std::string& file, const ForceLaw& law) {
  const nlohmann::json json = ParseJson(text, file);
  try {
    if (GetInt(json.at("schema")) != kFitSchema) throw Error("it has another version of the format");
    if (const std::string fitted = json.at("law"); fitted != law.name()) {
      throw Error(fmt::format("it is a fit of the law {}, and the scene has {}", fitted, law.name()));
    }
    const bool of_specimens = json.at("bootstrap").at("of") == "specimens";
    std::vector<FitInterval> fit;
    for (const nlohmann::json& parameter : json.at("parameters")) {
      const std::string key = parameter.at("key");
      const std::string state = parameter.at("state");
      if (state == "kept" || state == "not determined") continue;
      if (state != "fitted" && state != "at 0") throw Error(fmt::format("{} has the unknown state {}", key, state));
      if (std::ranges::find(fit, key, &FitInterval::key) != fit.end()) throw Error(key + " is listed twice");
      const double value = parameter.at("value");
      if (const double own = law.Get(key); !(std::abs(own - value) <= kSixDigits * std::abs(value))) {
        throw Error(
            fmt::format("its {} is {:g}, and the scene has {:g}; use the [force] of law.toml", key, value, own));
      }
      const LawParameter& p = *std::ranges::find(law.info().parameters, key, &LawParameter::key);
      const nlohmann::json& bootstrap = parameter.at("bootstrap_interval");
      const nlohmann::json& interval = parameter.at("interval");
      if (of_specimens && !bootstrap.is_null()) {
        fit.push_back(MakeInterval(p, bootstrap, "95 % interval of the fit, bootstrap over specimens"));
      } else if (!interval.is_null()) {
        fit.push_back(MakeInterval(p, interval, "95 % interval of the fit, t distribution"));
      } else {
        throw Error(key + " has no interval");
      }
    }
    return fit;
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: is not a calibrate.json of 'kerf calibrate', or is damaged", file));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: cannot be used as the fit: {}", file, e.what()));
  }
}

}  // namespace kerf
