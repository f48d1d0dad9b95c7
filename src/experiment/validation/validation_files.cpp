#include "experiment/validation/validation_files.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/table/table_json.h"
#include "kerf/version.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr const char* kTextFiles[] = {"report.md", "values.csv", "trends.csv", "teeth.csv", "blades.csv"};

TableCell Finite(double value) {
  return std::isfinite(value) ? TableCell(value) : TableCell();
}

const char* Use(bool calibration) {
  return calibration ? "calibration" : "validation";
}

ordered_json LawsJson(const Validation& v) {
  ordered_json laws = ordered_json::array();
  for (std::size_t k = 0; k < v.laws.size(); ++k) {
    const ForceLaw& law = v.laws[k];
    ordered_json parameters = ordered_json::object();
    for (std::size_t i = 0; i < law.info().parameters.size(); ++i) {
      parameters[law.info().parameters[i].key] = law.values()[i];
    }
    laws.push_back({{"law", v.names[k]}, {"has_cutting_force", HasCuttingForce(law)}, {"parameters", parameters}});
  }
  return laws;
}

ordered_json SetsJson(const Validation& v) {
  ordered_json sets = ordered_json::array();
  for (const MeasuredSet& set : v.sets) {
    ordered_json remarks = ordered_json::array();
    for (const MeasuredRemark& r : set.remarks) remarks.push_back({{"text", r.text}, {"obtained", r.obtained}});
    sets.push_back({{"set", set.name},
                    {"title", set.title},
                    {"citation", set.citation},
                    {"doi", set.doi},
                    {"specimen", set.specimen},
                    {"setup", set.setup},
                    {"licence", set.licence},
                    {"tool", set.tool.kind},
                    {"assumptions", set.assumptions},
                    {"calibrated", set.calibrated},
                    {"remarks", remarks}});
  }
  return sets;
}

ordered_json CountsJson(const Validation& v) {
  ordered_json counts = ordered_json::array();
  for (const LawCounts& c : v.counts) {
    counts.push_back({{"law", v.names[c.law]},
                      {"values", c.values},
                      {"values_agree", c.values_agree},
                      {"trends", c.trends},
                      {"trends_right", c.trends_right},
                      {"calibration_values", c.calibration_values},
                      {"calibration_values_agree", c.calibration_values_agree},
                      {"calibration_trends", c.calibration_trends},
                      {"calibration_trends_right", c.calibration_trends_right}});
  }
  return counts;
}

ordered_json CarriedJson(const Validation& v) {
  ordered_json carried = ordered_json::array();
  for (const CarriedTeeth& c : v.carried) {
    carried.push_back(
        {{"set", v.sets[c.set].name}, {"law", v.names[c.law]}, {"force_N", c.force_N}, {"teeth", NumberJson(c.teeth)}});
  }
  return carried;
}

}  // namespace

Columns<ValueComparison> ValueColumns(const Validation& v) {
  using C = ValueComparison;
  Columns<C> columns{
      {"set", "{}", "name of the set", [&v](const C& c) { return v.sets[c.set].name; }},
      {"row", "{}", "number of the value in its file, counted from 1", [](const C& c) { return c.row + 1; }},
      {"law", "{}", "force law", [&v](const C& c) { return v.names[c.law]; }},
      {"quantity", "{}", "what was measured, with its unit", [&v](const C& c) { return v.value_of(c).quantity; }},
      {"conditions", "{}", "conditions of the measurement",
       [&v](const C& c) { return ShowConditions(JoinConditions(v.value_of(c).at, v.sets[c.set].conditions)); }},
      {"material", "{}", "material that was cut", [&v](const C& c) { return v.value_of(c).material; }},
      {"measured", "{:.9g}", "measured mean and its standard deviation, if known",
       [&v](const C& c) { return Finite(v.value_of(c).value); }},
      {"sd", "{:.9g}", "measured mean and its standard deviation, if known",
       [&v](const C& c) { return Finite(v.value_of(c).sd); }},
      {"low", "{:.9g}", "measured range, if a range is known instead",
       [&v](const C& c) { return Finite(v.value_of(c).low); }},
      {"high", "{:.9g}", "measured range, if a range is known instead",
       [&v](const C& c) { return Finite(v.value_of(c).high); }},
      {"obtained", "{}", "`read`, `derived` or `recalled`", [&v](const C& c) { return v.value_of(c).obtained; }},
      {"use", "{}", "`calibration` if the law's parameters were derived from this set, else `validation`",
       [](const C& c) { return Use(c.calibration); }},
      {"simulated", "{:.9g}", "value of the law; for a tooth, from a cut in the contact and removal code",
       [](const C& c) { return Finite(c.simulated.value); }},
      {"law_value", "{:.9g}", "value from the law's formula alone", [](const C& c) { return Finite(c.law_value); }},
      {"difference_sd", "{:.6g}", "(simulated - measured) / standard deviation",
       [](const C& c) { return Finite(c.difference_sd); }},
      {"factor", "{:.6g}", "simulated / measured mean, or / nearest end of the range; 1 inside the range",
       [](const C& c) { return Finite(c.factor); }},
      {"agrees", "{}",
       "true: within two standard deviations, or inside the range; empty: no scatter is known, or not "
       "compared",
       [](const C& c) { return TableCell(c.agrees); }},
      {"assumed_ratio", "{}", "true: the law has no cutting force, which is taken as thrust / 1.6",
       [](const C& c) { return c.simulated.assumed_ratio; }},
      {"verdict", "{}", "in words", [](const C& c) { return c.verdict; }}};
  return columns;
}

Columns<TrendComparison> TrendColumns(const Validation& v) {
  using C = TrendComparison;
  return {{"set", "{}", "name of the set", [&v](const C& c) { return v.sets[c.set].name; }},
          {"row", "{}", "number of the trend in its file, counted from 1", [](const C& c) { return c.row + 1; }},
          {"law", "{}", "force law", [&v](const C& c) { return v.names[c.law]; }},
          {"quantity", "{}", "what was measured, with its unit", [&v](const C& c) { return v.trend_of(c).quantity; }},
          {"against", "{}", "condition that changes, with its unit; from, to",
           [&v](const C& c) { return v.trend_of(c).against; }},
          {"from", "{:.9g}", "condition that changes, with its unit; from, to", [](const C& c) { return c.from; }},
          {"to", "{:.9g}", "condition that changes, with its unit; from, to", [](const C& c) { return c.to; }},
          {"measured_sign", "{}", "`rises`, `falls` or `constant`", [&v](const C& c) { return v.trend_of(c).sign; }},
          {"measured_ratio", "{:.9g}", "quantity at `to` divided by that at `from`, if known",
           [&v](const C& c) { return Finite(v.trend_of(c).ratio); }},
          {"obtained", "{}", "`read`, `derived` or `recalled`", [&v](const C& c) { return v.trend_of(c).obtained; }},
          {"use", "{}", "`calibration` if the law's parameters were derived from this set, else `validation`",
           [](const C& c) { return Use(c.calibration); }},
          {"sign", "{}",
           "simulated; a change of at most 10 % counts as constant if it was measured as constant, of at "
           "most 0.1 % otherwise",
           [](const C& c) { return c.sign; }},
          {"ratio", "{:.9g}", "simulated", [](const C& c) { return Finite(c.ratio); }},
          {"right", "{}", "whether the simulated sign is the measured one; empty: not compared",
           [](const C& c) { return TableCell(c.right); }},
          {"assumed_ratio", "{}", "true: the law has no cutting force, which is taken as thrust / 1.6",
           [](const C& c) { return c.at_from.assumed_ratio; }},
          {"verdict", "{}", "in words", [](const C& c) { return c.verdict; }}};
}

Columns<ToothCheck> ToothColumns(const Validation& v) {
  using C = ToothCheck;
  return {{"law", "{}", "force law", [&v](const C& c) { return v.names[c.law]; }},
          {"width_mm", "{:.9g}", "width of the tooth", [](const C& c) { return c.run.width_mm; }},
          {"bite_um", "{:.9g}", "nominal bite: feed per turn", [](const C& c) { return c.run.bite_um; }},
          {"speed_mm_per_s", "{:.9g}", "speed of the tooth", [](const C& c) { return c.run.speed_mm_per_s; }},
          {"removed_bite_um", "{:.6g}", "volume removed per turn, divided by length of the rib and width of the tooth",
           [](const C& c) { return c.run.removed_bite_um; }},
          {"reported_bite_um", "{:.6g}", "mean bite of the engaged teeth in the output of the ticks",
           [](const C& c) { return c.run.reported_bite_um; }},
          {"thrust_N", "{:.6g}", "sum of the tooth forces divided by the number of engaged teeth",
           [](const C& c) { return c.run.thrust_N; }},
          {"law_N", "{:.9g}", "thrust of the law at the nominal bite", [](const C& c) { return c.run.law_N; }}};
}

Columns<BladeCheck> BladeColumns(const Validation& v) {
  using C = BladeCheck;
  return {
      {"set", "{}", "name of the set", [&v](const C& c) { return v.sets[v.trends[c.trend].set].name; }},
      {"row", "{}", "number of the trend in its file, counted from 1",
       [&v](const C& c) { return v.trends[c.trend].row + 1; }},
      {"law", "{}", "force law", [&v](const C& c) { return v.names[v.trends[c.trend].law]; }},
      {"teeth", "{:.9g}", "engaged at once", [](const C& c) { return c.cut.teeth; }},
      {"cycles_per_min", "{:.9g}", "speed of the blade at the end of the trend",
       [](const C& c) { return c.cut.cycles_per_min(); }},
      {"bite_from_um", "{:.6g}", "mean bite over the way of the teeth, from the removed volume; from, to",
       [](const C& c) { return c.from.bite_um; }},
      {"bite_to_um", "{:.6g}", "mean bite over the way of the teeth, from the removed volume; from, to",
       [](const C& c) { return c.to.bite_um; }},
      {"thrust_from_N", "{:.6g}", "mean thrust of an engaged tooth; from, to",
       [](const C& c) { return c.from.thrust_N; }},
      {"thrust_to_N", "{:.6g}", "mean thrust of an engaged tooth; from, to", [](const C& c) { return c.to.thrust_N; }},
      {"rate_from_mm3_per_s", "{:.6g}", "removal rate; from, to", [](const C& c) { return c.from.removal_mm3_per_s; }},
      {"rate_to_mm3_per_s", "{:.6g}", "removal rate; from, to", [](const C& c) { return c.to.removal_mm3_per_s; }},
      {"rise_from_K", "{:.6g}", "rise of the hottest bone's temperature; from, to; 0: the trend is of another quantity",
       [](const C& c) { return c.from.rise_K; }},
      {"rise_to_K", "{:.6g}", "rise of the hottest bone's temperature; from, to; 0: the trend is of another quantity",
       [](const C& c) { return c.to.rise_K; }},
      {"ratio", "{:.9g}", "of the trend's quantity; empty: the blade cut nothing",
       [](const C& c) { return Finite(c.ratio); }},
      {"sign", "{}", "as in trends.csv, or `cuts nothing`", [](const C& c) { return c.sign; }},
      {"right", "{}", "whether the sign is the measured one", [](const C& c) { return TableCell(c.right); }}};
}

std::string FormatValidationJson(const Validation& v) {
  ordered_json json;
  json["kerf"] = VersionString();
  json["commit"] = CommitString();
  json["compiler"] = CompilerString();
  json["schema"] = 1;
  json["laws"] = LawsJson(v);
  json["sets"] = SetsJson(v);
  json["counts"] = CountsJson(v);
  json["values"] = RowsJson(ValueColumns(v), v.values);
  json["trends"] = RowsJson(TrendColumns(v), v.trends);
  json["teeth"] = RowsJson(ToothColumns(v), v.teeth);
  json["blades"] = RowsJson(BladeColumns(v), v.blades);
  json["carried"] = CarriedJson(v);
  return DumpJson(json);
}

void CheckValidationInputsNotOverwritten(const std::vector<std::string>& inputs, const std::string& folder) {
  std::vector<std::string> outputs{folder + "/validate.json"};
  for (const char* name : kTextFiles) outputs.push_back(folder + "/" + name);
  CheckInputsNotOverwritten(inputs, outputs);
}

std::vector<std::string> WriteValidation(const Validation& v, const std::string& folder) {
  MakeFolder(folder);
  FileBatch results(folder, "validate.json");
  const std::string in = folder + "/";
  std::vector<std::string> files(std::begin(kTextFiles), std::end(kTextFiles));
  for (const ValidationFigure& figure : MakeValidationFigures(v)) {
    files.push_back(figure.name + ".png");
    WritePlot(figure.plot, in + files.back());
  }
  WriteTextFile(in + "values.csv", FormatCsv(ValueColumns(v), v.values));
  WriteTextFile(in + "trends.csv", FormatCsv(TrendColumns(v), v.trends));
  WriteTextFile(in + "teeth.csv", FormatCsv(ToothColumns(v), v.teeth));
  WriteTextFile(in + "blades.csv", FormatCsv(BladeColumns(v), v.blades));
  WriteTextFile(in + "report.md", FormatValidationReport(v));
  files.emplace_back("validate.json");
  WriteTextFile(in + files.back(), FormatValidationJson(v));
  results.Commit();
  return files;
}

}  // namespace kerf
