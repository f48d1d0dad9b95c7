#include "experiment/stability_study/stability_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/core/csv.h"
#include "base/files/files.h"
#include "kerf/version.h"
#include "session/run/results_folder.h"
#include "session/run/run_scene.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

/// Number of scenarios with a diagram.
constexpr std::size_t kPictures = 3;
/// All files that may be written.
constexpr const char* kFiles[] = {"report.md",   "stability.json", "figures.csv", "margins.csv",
                                  "map.csv",     "map.png",        "margins.png", "delays.png",
                                  "worst_1.png", "worst_2.png",    "worst_3.png", "scene.toml"};

ordered_json Number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json CouplingJson(const LoopSetup& setup) {
  const FittedCoupling& fitted = setup.fitted;
  return {{"asked_stiffness_N_per_mm", setup.asked_stiffness_N_per_mm},
          {"stiffness_N_per_mm", fitted.coupling.stiffness_N_per_mm},
          {"damping_Ns_per_mm", fitted.coupling.damping_Ns_per_mm},
          {"lowered_for_device", fitted.lowered.by_device},
          {"lowered_for_loop", fitted.lowered.by_loop},
          {"device_bears_N_per_mm", Number(fitted.limits.stiffness_N_per_mm)},
          {"sampled_loop_holds_N_per_mm", Number(fitted.limits.sampled_stiffness_N_per_mm)},
          {"encoder_steps_allow_N_per_mm",
           setup.profile.friction_N > 0 ? Number(fitted.limits.quantum_stiffness_N_per_mm) : ordered_json()}};
}

ordered_json MarginsJson(const Margins& m) {
  if (!m.unjudged.empty()) {
    return {{"gain", nullptr},
            {"gain_beyond", nullptr},
            {"delay_ticks", nullptr},
            {"delay_beyond", nullptr},
            {"unjudged", m.unjudged}};
  }
  return {{"gain", Number(m.gain)},
          {"gain_beyond", m.gain_beyond},
          {"delay_ticks", m.delay_ticks},
          {"delay_beyond", m.delay_beyond}};
}

/// Returns true or false, or null if the figure was not required or could not be judged.
ordered_json HoldsJson(Judgement judgement) {
  if (judgement == Judgement::kHolds) return true;
  if (judgement == Judgement::kBroken) return false;
  return {};
}

/// Returns the value for a table: true, false, not_asked or not_judged.
const char* HoldsCsv(Judgement judgement) {
  switch (judgement) {
    case Judgement::kHolds:
      return "true";
    case Judgement::kBroken:
      return "false";
    case Judgement::kNotJudged:
      return "not_judged";
    case Judgement::kNotAsked:
      break;
  }
  return "not_asked";
}

ordered_json CountJson(const StabilityStudy::Count& count) {
  return {{"asked", count.asked}, {"judged", count.judged}, {"broken", count.broken}};
}

}  // namespace

std::string FormatStabilityJson(const StabilityStudy& s) {
  ordered_json scenarios = ordered_json::array();
  for (const ScenarioResult& scenario : s.scenarios) {
    ordered_json figures = ordered_json::array();
    for (const StabilityFigure& f : scenario.figures) {
      figures.push_back({{"name", f.name},
                         {"unit", f.unit},
                         {"value", Number(f.value)},
                         {"bound", Number(f.bound)},
                         {"kind", f.at_most ? "at_most" : "at_least"},
                         {"holds", f.holds()}});
    }
    scenarios.push_back({{"name", scenario.name},
                         {"what", scenario.what},
                         {"skipped", scenario.skipped},
                         {"holds", HoldsJson(scenario.judgement())},
                         {"judgement", ToString(scenario.judgement())},
                         {"unjudged", scenario.unjudged},
                         {"cut_through_s", scenario.cut_through_s ? ordered_json(*scenario.cut_through_s) : nullptr},
                         {"figures", figures}});
  }
  ordered_json margins = ordered_json::array();
  for (const HandMargins& m : s.margins) {
    if (!m.done) continue;
    ordered_json row = {{"hand", m.hand}, {"own", m.own}, {"state", ToString(m.state)}, {"linear", m.linear}};
    row.update(MarginsJson(m.margins));
    row["holds"] = HoldsJson(m.judgement());
    row["judgement"] = ToString(m.judgement());
    margins.push_back(row);
  }
  ordered_json map;
  if (!s.map.behaviour.empty()) {
    const auto rows = [&](const std::vector<Behaviour>& behaviour) {
      ordered_json all = ordered_json::array();
      for (std::size_t i = 0; i < behaviour.size(); ++i) {
        if (i % s.map.stiffness_N_per_mm.size() == 0) all.push_back(ordered_json::array());
        all.back().push_back(ToString(behaviour[i]));
      }
      return all;
    };
    map = {{"state", ToString(s.map_state)},
           {"stiffness_N_per_mm", s.map.stiffness_N_per_mm},
           {"damping_Ns_per_mm", s.map.damping_Ns_per_mm},
           {"behaviour_by_damping_then_stiffness", rows(s.map.behaviour)},
           {"linear_by_damping_then_stiffness", rows(s.map_linear)}};
  }
  ordered_json worst;
  if (const std::vector<WorstFigure> ranked = RankScenarios(s); !ranked.empty()) {
    worst = {{"scenario", ranked.front().scenario->name},
             {"figure", ranked.front().figure->name},
             {"share_of_bound", Number(CalcNearness(*ranked.front().figure))}};
  }
  const ordered_json json = {
      {"kerf", VersionString()},
      {"commit", CommitString()},
      {"schema", 1},
      {"scene", s.scene},
      {"title", s.title},
      {"command", s.command},
      {"stable", s.complete && s.CountScenarios().judged + s.CountMargins().judged > 0
                     ? ordered_json(s.findings.empty())
                     : ordered_json()},
      {"complete", s.complete},
      {"judged", {{"scenarios", CountJson(s.CountScenarios())}, {"margins", CountJson(s.CountMargins())}}},
      {"findings", s.findings},
      {"quick", s.quick},
      {"seed", s.seed},
      {"tool", s.tool},
      {"rpm", s.rpm},
      {"rate_hz", s.rate_hz},
      {"voxel_mm", s.voxel_mm},
      {"device", s.setup.profile.name},
      {"hand", s.setup.hand.name},
      {"force_scale", s.setup.force_scale},
      {"coupling", CouplingJson(s.setup)},
      {"first_touch",
       {{"time_s", s.touch.time_s},
        {"start_mm", {s.touch.X_WT.p_AB.x, s.touch.X_WT.p_AB.y, s.touch.X_WT.p_AB.z}},
        {"into", {s.touch.into_W.x, s.touch.into_W.y, s.touch.into_W.z}}}},
      {"worst", worst},
      {"scenarios", scenarios},
      {"asked_of_margins", {{"gain", kMinGainMargin}, {"delay_ticks", kMinDelayMargin_ticks}}},
      {"margins", margins},
      {"map", map},
      {"warnings", s.warnings},
      {"wall_s", s.wall_s},
      {"files", s.files}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string FormatFiguresCsv(const StabilityStudy& s) {
  std::string csv = "scenario,figure,unit,value,kind,bound,holds\n";
  for (const ScenarioResult& scenario : s.scenarios) {
    for (const StabilityFigure& f : scenario.figures) {
      fmt::format_to(std::back_inserter(csv), "{},{},{},{:.7g},{},{:.7g},{}\n", FormatCsvField(scenario.name),
                     FormatCsvField(f.name), FormatCsvField(f.unit), f.value, f.at_most ? "at_most" : "at_least",
                     f.bound, f.holds());
    }
    if (scenario.cut_through_s) {
      fmt::format_to(std::back_inserter(csv), "{},cut through,s,{:.7g},when,,not_asked\n", scenario.name,
                     *scenario.cut_through_s);
    }
  }
  return csv;
}

std::string FormatMarginsCsv(const StabilityStudy& s) {
  std::string csv = "hand,state,linear,gain,gain_beyond,delay_ticks,delay_beyond,holds\n";
  for (const HandMargins& m : s.margins) {
    if (!m.done) continue;
    fmt::format_to(std::back_inserter(csv), "{},{},{},", FormatCsvField(m.hand), FormatCsvField(ToString(m.state)),
                   m.linear);
    if (m.margins.unjudged.empty()) {
      fmt::format_to(std::back_inserter(csv), "{:.5g},{},{},{},", m.margins.gain, m.margins.gain_beyond,
                     m.margins.delay_ticks, m.margins.delay_beyond);
    } else {
      csv += ",,,,";
    }
    fmt::format_to(std::back_inserter(csv), "{}\n", HoldsCsv(m.judgement()));
  }
  return csv;
}

std::string FormatMapCsv(const StabilityStudy& s) {
  std::string csv =
      "damping_Ns_per_mm,stiffness_N_per_mm,device_damping_Ns_per_mm,device_stiffness_N_per_mm,rule_N_per_mm,"
      "behaviour,linear\n";
  const std::size_t width = s.map.stiffness_N_per_mm.size();
  for (std::size_t i = 0; i < s.map.behaviour.size(); ++i) {
    const double B = s.map.damping_Ns_per_mm[i / width];
    const double K = s.map.stiffness_N_per_mm[i % width];
    fmt::format_to(std::back_inserter(csv), "{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{}\n", B, K, B * s.setup.force_scale,
                   K * s.setup.force_scale, s.limits.CalcRule(B), ToString(s.map.behaviour[i]),
                   ToString(s.map_linear[i]));
  }
  return csv;
}

void WriteStabilityStudy(const Scene& scene, StabilityStudy& study, const std::string& folder) {
  MakeFolder(folder);
  const std::vector<std::string> earlier = ReadEarlierResults(folder, "stability.json");
  std::vector<std::string>& files = study.files;
  files = {"report.md", "stability.json"};
  const auto add = [&](const std::string& name) {
    files.push_back(name);
    return folder + "/" + name;
  };
  WriteTextFile(add("scene.toml"), ResolvedToml(scene));
  WriteTextFile(add("figures.csv"), FormatFiguresCsv(study));
  WriteTextFile(add("margins.csv"), FormatMarginsCsv(study));
  WriteTextFile(add("map.csv"), FormatMapCsv(study));
  if (!study.map.behaviour.empty()) WritePlot(MakeMapPlot(study), add("map.png"));
  const bool any_margin =
      std::any_of(study.margins.begin(), study.margins.end(), [](const HandMargins& m) { return m.done; });
  if (any_margin) {
    WritePlot(MakeMarginPlot(study, MarginKind::kGain), add("margins.png"));
    WritePlot(MakeMarginPlot(study, MarginKind::kDelay), add("delays.png"));
  }
  std::size_t pictures = 0;
  for (const WorstFigure& worst : RankScenarios(study)) {
    if (pictures == kPictures) break;
    if (worst.scenario->time_s.size() < 2 || worst.scenario->force_N.size() < 2) continue;
    WritePlot(MakeScenarioPlot(study, worst), add(fmt::format("worst_{}.png", ++pictures)));
  }
  WriteTextFile(folder + "/report.md", FormatStabilityReport(study));
  WriteTextFile(folder + "/stability.json", FormatStabilityJson(study));
  RemoveStaleResults(folder, earlier, files);
}

void CheckStabilityInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kFiles) outputs.push_back(fmt::format("{}/{}", folder, name));
  for (const std::string& name : ReadEarlierResults(folder, "stability.json")) {
    outputs.push_back(fmt::format("{}/{}", folder, name));
  }
  std::vector<std::string> inputs = ListInputs(scene, scene_file);
  inputs.push_back(scene.device.file);
  CheckInputsNotOverwritten(inputs, outputs);
}

std::string FormatProfilesTable(const std::vector<ProfileMargins>& rows) {
  std::string text = "| device |";
  std::string rule = "|---|";
  const auto column = [](const ProfileMargins& row) {
    return row.hand == row.fitted_to ? row.hand : fmt::format("{} released", row.fitted_to);
  };
  // The columns are those of the device with the most rows.
  const auto count = [&](const std::string& name) {
    return std::count_if(rows.begin(), rows.end(), [&](const ProfileMargins& row) { return row.profile == name; });
  };
  const auto fullest = std::max_element(
      rows.begin(), rows.end(),
      [&](const ProfileMargins& a, const ProfileMargins& b) { return count(a.profile) < count(b.profile); });
  for (const ProfileMargins& row : rows) {
    if (row.profile != fullest->profile) continue;
    text += fmt::format(" {} |", column(row));
    rule += "---|";
  }
  text += "\n" + rule;
  std::string profile;
  for (const ProfileMargins& row : rows) {
    if (row.profile != profile) text += fmt::format("\n| {} |", row.profile);
    profile = row.profile;
    Margins least;
    bool any = false;
    bool all = true;
    for (const Margins& m : row.margins) {
      if (!m.unjudged.empty()) {
        all = false;
        continue;
      }
      if (!any || m.gain < least.gain) {
        least.gain = m.gain;
        least.gain_beyond = m.gain_beyond;
      }
      if (!any || m.delay_ticks < least.delay_ticks) {
        least.delay_ticks = m.delay_ticks;
        least.delay_beyond = m.delay_beyond;
      }
      any = true;
    }
    if (!any) least.unjudged = row.margins.front().unjudged;
    const std::string cell = fmt::format("{:.3g} N/mm: {}{}", row.coupling.stiffness_N_per_mm, DescribeMargins(least),
                                         any && !all ? ", not all states judged" : "");
    text += Judge(row) == Judgement::kBroken ? fmt::format(" **{}** |", cell) : fmt::format(" {} |", cell);
  }
  return text + "\n";
}

std::string FormatProfilesJson(const Scene& scene, const std::vector<ProfileMargins>& rows, bool complete) {
  ordered_json all = ordered_json::array();
  for (const ProfileMargins& row : rows) {
    ordered_json states = ordered_json::array();
    for (std::size_t i = 0; i < kHeldStates.size(); ++i) {
      ordered_json of = {{"state", ToString(kHeldStates[i])}};
      of.update(MarginsJson(row.margins[i]));
      states.push_back(of);
    }
    all.push_back({{"device", row.profile},
                   {"hand", row.hand},
                   {"fitted_to", row.fitted_to},
                   {"stiffness_N_per_mm", row.coupling.stiffness_N_per_mm},
                   {"damping_Ns_per_mm", row.coupling.damping_Ns_per_mm},
                   {"force_scale", row.force_scale},
                   {"states", states},
                   {"holds", HoldsJson(Judge(row))},
                   {"judgement", ToString(Judge(row))}});
  }
  const ordered_json json = {{"kerf", VersionString()},
                             {"schema", 1},
                             {"scene", scene.name},
                             {"rate_hz", scene.loop.rate_hz},
                             {"complete", complete},
                             {"asked_of_margins", {{"gain", kMinGainMargin}, {"delay_ticks", kMinDelayMargin_ticks}}},
                             {"devices", all}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
