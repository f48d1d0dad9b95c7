#include "experiment/calibration/calibration_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/core/append_format.h"
#include "base/core/number_text.h"
#include "base/files/files.h"
#include "base/files/markdown_text.h"
#include "base/table/table.h"
#include "base/table/table_json.h"
#include "kerf/version.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFiles[] = {"law.toml", "fit.png", "report.md", "calibrate.json"};

std::string Show(double value) {
  return ShowThree(value);
}

std::string Show(const std::optional<double>& value) {
  return value ? ShowThree(*value) : "-";
}

std::string Show(const std::optional<Interval>& interval) {
  return interval ? fmt::format("{} to {}", ShowThree(interval->lower), ShowThree(interval->upper)) : "-";
}

/// Returns three decimals, without the sign of a rounded zero.
std::string ShowFraction(double value) {
  return fmt::format("{:.3f}", std::round(1000 * value) / 1000 + 0.0);
}

TextTable MakeParameterTable(const Calibration& c) {
  TextTable table(
      {"parameter", "estimate", "standard error", "95 % interval (t)", "95 % interval (bootstrap)", "state"});
  for (const ParameterResult& p : c.parameters) {
    table.Add({p.key, Show(p.value), Show(p.standard_error), Show(p.interval), Show(p.bootstrap), ToString(p.state)});
  }
  return table;
}

TextTable MakeComponentTable(const Calibration& c) {
  TextTable table({"component", "values", "degrees of freedom", "chi2 / dof", "residual SD (N)", "R2",
                   "speed: N/mm per m/s", "speed: p"});
  for (const ComponentResult& r : c.components) {
    const bool errors = r.determined && r.dof > 0;
    table.Add({ToString(r.component), r.values, errors ? fmt::format("{}", r.dof) : "-",
               errors && r.weighted ? Show(r.chi2 / r.dof) : "-", errors ? Show(r.residual_sd_N) : "-",
               r.r2 ? ShowFraction(*r.r2) : "-",
               r.speed ? fmt::format("{:+.2g}", 1000 * r.speed->slope_Ns_per_mm2) : "-",
               r.speed ? fmt::format("{:.2g}", r.speed->p_value) : "-"});
  }
  return table;
}

TextTable MakeCorrelationTable(const Calibration& c) {
  const std::size_t n = c.covariant.size();
  std::vector<std::string> headings{"correlation"};
  for (std::size_t a = 0; a < n; ++a) headings.push_back(fmt::format("{}", a + 1));
  TextTable table(headings);
  for (std::size_t a = 0; a < n; ++a) {
    std::vector<TableCell> row{fmt::format("{} ({})", c.parameters[c.covariant[a]].key, a + 1)};
    for (std::size_t b = 0; b < n; ++b) row.emplace_back(ShowFraction(c.CorrelationOf(a, b)));
    table.Add(row);
  }
  return table;
}

/// Describes the data in a sentence without its full stop.
std::string DescribeData(const Calibration& c) {
  double low = c.data.observations.front().bite_mm;
  double high = low;
  for (const ForceObservation& o : c.data.observations) {
    low = std::min(low, o.bite_mm);
    high = std::max(high, o.bite_mm);
  }
  std::string text = fmt::format("{}, bites of {:g} to {:g} um",
                                 FormatCount(c.data.observations.size(), "value", "values"), 1000 * low, 1000 * high);
  if (c.data.specimens > 0) text += ", " + FormatCount(c.data.specimens, "specimen", "specimens");
  return text;
}

std::string DescribeBootstrap(const Calibration& c) {
  if (c.params.bootstrap == 0) return "no bootstrap";
  return fmt::format("bootstrap: {} resamples of {} {}, seed {}", c.params.bootstrap, c.data.groups,
                     c.data.specimens > 1 ? "specimens" : "rows", c.params.seed);
}

ordered_json IntervalJson(const std::optional<Interval>& interval) {
  if (!interval) return nullptr;
  return {NumberJson(interval->lower), NumberJson(interval->upper)};
}

ordered_json ComponentJson(const ComponentResult& r) {
  const bool errors = r.determined && r.dof > 0;
  ordered_json json = {{"component", r.component == ForceComponent::kThrust ? "thrust" : "cutting"},
                       {"values", r.values},
                       {"determined", r.determined}};
  json["degrees_of_freedom"] = r.determined ? ordered_json(r.dof) : ordered_json();
  json["weighted"] = r.determined ? ordered_json(r.weighted) : ordered_json();
  json["chi2_per_degree_of_freedom"] = errors && r.weighted ? NumberJson(r.chi2 / r.dof) : ordered_json();
  json["chi2_p_value"] = OrNull(r.chi2_p_value);
  json["residual_sd_N"] = errors ? NumberJson(r.residual_sd_N) : ordered_json();
  json["r2"] = OrNull(r.r2);
  json["speed"] = nullptr;
  if (r.speed) {
    json["speed"] = {{"slope_Ns_per_mm2", NumberJson(r.speed->slope_Ns_per_mm2)},
                     {"p_value", NumberJson(r.speed->p_value)}};
  }
  return json;
}

/// Returns the interval within the values that a scene accepts.
std::string ShowClipped(const Interval& interval) {
  return fmt::format("{} to {}", ShowThree(std::max(0.0, interval.lower)), ShowThree(interval.upper));
}

std::string DescribeUncertainty(const ParameterResult& p) {
  if (p.state == ParameterState::kKept) return "kept, not fitted";
  if (p.state == ParameterState::kUndetermined) return "not determined by the data";
  std::string text = p.interval ? "95 % interval " + ShowClipped(*p.interval) : "no interval: too few values";
  if (p.bootstrap) text += "; bootstrap " + ShowClipped(*p.bootstrap);
  return p.state == ParameterState::kAtZero ? "at its limit; " + text : text;
}

void AddMethod(std::string& text, const Calibration& c) {
  const bool weighted = std::any_of(c.components.begin(), c.components.end(),
                                    [](const ComponentResult& r) { return r.determined && r.weighted; });
  AppendFormat(text, "## Method\n\n");
  AppendFormat(text, "- Weighted least squares; weights: {}.\n",
               weighted ? "1 / SD^2 where the data have SDs, otherwise equal" : "equal, as the data have no SDs");
  AppendFormat(text,
               "- The covariance is scaled by chi2 / degrees of freedom; the intervals are those of the t "
               "distribution. {}.\n",
               c.params.bootstrap == 0 ? "There is no bootstrap"
                                       : "The bootstrap's intervals are percentiles; " + DescribeBootstrap(c));
  AppendFormat(text,
               "- The influence of the cutting speed is the slope of one more term, fitted together with the "
               "coefficients; p is the probability of a slope at least that large without an influence. The law does "
               "not contain it.\n");
  AppendFormat(text, "- Generated by kerf {} (commit {}). docs/calibrate.md of kerf explains each figure.\n",
               VersionString(), CommitString());
}

}  // namespace

std::string FormatCalibrationText(const Calibration& c) {
  std::string text = fmt::format("{} fitted to {}: {}\n\n", c.law.name, MarkdownCodeLine(c.file), DescribeData(c));
  text += MakeParameterTable(c).FormatTerminal("  ") + "\n" + MakeComponentTable(c).FormatTerminal("  ");
  if (c.covariant.size() > 1) text += "\n" + MakeCorrelationTable(c).FormatTerminal("  ");
  return text +
         fmt::format("\n  {}; speed: influence of the cutting speed, not part of the law\n", DescribeBootstrap(c));
}

std::string FormatCalibrationJson(const Calibration& c) {
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}};
  json["schema"] = 1;
  json["file"] = c.file;
  json["law"] = c.law.name;
  json["rows"] = c.data.rows();
  json["specimens"] = c.data.specimens;
  json["parameters"] = ordered_json::array();
  for (const ParameterResult& p : c.parameters) {
    json["parameters"].push_back({{"key", p.key},
                                  {"state", ToString(p.state)},
                                  {"value", NumberJson(p.value)},
                                  {"standard_error", OrNull(p.standard_error)},
                                  {"interval", IntervalJson(p.interval)},
                                  {"bootstrap_interval", IntervalJson(p.bootstrap)}});
  }
  json["covariance"] = {{"keys", ordered_json::array()}, {"matrix", ordered_json::array()}};
  const std::size_t n = c.covariant.size();
  for (std::size_t a = 0; a < n; ++a) {
    json["covariance"]["keys"].push_back(c.parameters[c.covariant[a]].key);
    ordered_json row = ordered_json::array();
    for (std::size_t b = 0; b < n; ++b) row.push_back(NumberJson(c.covariance[a * n + b]));
    json["covariance"]["matrix"].push_back(row);
  }
  json["components"] = ordered_json::array();
  for (const ComponentResult& r : c.components) json["components"].push_back(ComponentJson(r));
  json["bootstrap"] = {{"resamples", c.params.bootstrap},
                       {"used", c.resamples_used},
                       {"of", c.data.specimens > 1 ? "specimens" : "rows"},
                       {"seed", c.params.seed}};
  json["law_block"] = FormatLawBlock(c);
  json["warnings"] = c.warnings;
  return DumpJson(json);
}

std::string FormatLawBlock(const Calibration& c) {
  std::string text = fmt::format("# Fitted by kerf calibrate to {}: {}.\n[force]\nlaw = \"{}\"\n",
                                 MarkdownCodeLine(c.file), DescribeData(c), c.law.name);
  for (std::size_t j = 0; j < c.parameters.size(); ++j) {
    const ParameterResult& p = c.parameters[j];
    const bool of_tool = j >= c.law.coefficients.size() && c.law.fixed[j - c.law.coefficients.size()].of_tool;
    if (of_tool) {
      AppendFormat(text, "# The crossover holds for a tool with {} = {:.6g}.\n", p.key, p.value);
    } else if (p.state == ParameterState::kUndetermined && j < c.law.coefficients.size()) {
      AppendFormat(text, "# {}: not determined by the data; the law's default applies\n", p.key);
    } else {
      AppendFormat(text, "{} = {:.6g}  # {}\n", p.key, p.value, DescribeUncertainty(p));
    }
  }
  return text;
}

std::string FormatCalibrationReport(const Calibration& c) {
  std::string text = fmt::format("# Calibration of {}\n\nWritten by `kerf calibrate` from {}: {}.\n\n", c.law.name,
                                 MarkdownCode(c.file), DescribeData(c));
  if (!c.warnings.empty()) {
    AppendFormat(text, "Warnings:\n\n");
    for (const std::string& warning : c.warnings) AppendFormat(text, "- {}\n", EscapeMarkdown(warning));
    AppendFormat(text, "\n");
  }
  AppendFormat(text, "## Parameters\n\n{}\n", MakeParameterTable(c).FormatMarkdown());
  if (c.covariant.size() > 1) AppendFormat(text, "{}\n", MakeCorrelationTable(c).FormatMarkdown());
  AppendFormat(text, "## Fit\n\n{}\n", MakeComponentTable(c).FormatMarkdown());
  AppendFormat(
      text,
      "![Data, fit and residuals](fit.png)\n\nThe band is the 95 % interval of the fitted curve, not of single "
      "values.\n\n");
  AppendFormat(text, "## For a scene\n\n```toml\n{}```\n\n", FormatLawBlock(c));
  AddMethod(text, c);
  return text;
}

void CheckCalibrationInputNotOverwritten(const std::string& data_file, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kFiles) outputs.push_back(folder + "/" + name);
  CheckInputsNotOverwritten({data_file}, outputs);
}

std::vector<std::string> WriteCalibration(const Calibration& c, const std::string& folder) {
  MakeFolder(folder);
  FileBatch results(folder, "calibrate.json");
  const std::string in = folder + "/";
  WritePng(RenderCalibration(c), in + "fit.png");
  WriteTextFile(in + "law.toml", FormatLawBlock(c));
  WriteTextFile(in + "report.md", FormatCalibrationReport(c));
  WriteTextFile(in + "calibrate.json", FormatCalibrationJson(c));
  results.Commit();
  return {std::begin(kFiles), std::end(kFiles)};
}

}  // namespace kerf
