#include "experiment/stability_study/stability_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/table/table_json.h"
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

ordered_json CouplingJson(const LoopSetup& setup) {
  const FittedCoupling& fitted = setup.fitted;
  return {{"asked_stiffness_N_per_mm", setup.asked_stiffness_N_per_mm},
          {"stiffness_N_per_mm", fitted.coupling.stiffness_N_per_mm},
          {"damping_Ns_per_mm", fitted.coupling.damping_Ns_per_mm},
          {"lowered_for_device", fitted.lowered.by_device},
          {"lowered_for_loop", fitted.lowered.by_loop},
          {"device_bears_N_per_mm", NumberJson(fitted.limits.stiffness_N_per_mm)},
          {"sampled_loop_holds_N_per_mm", NumberJson(fitted.limits.sampled_stiffness_N_per_mm)},
          {"encoder_steps_allow_N_per_mm",
           setup.profile.friction_N > 0 ? NumberJson(fitted.limits.quantum_stiffness_N_per_mm) : ordered_json()}};
}

ordered_json MarginsJson(const Margins& m) {
  if (!m.unjudged.empty()) {
    return {{"gain", nullptr},
            {"gain_beyond", nullptr},
            {"delay_ticks", nullptr},
            {"delay_beyond", nullptr},
            {"unjudged", m.unjudged}};
  }
  return {{"gain", NumberJson(m.gain)},
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
std::string HoldsCsv(Judgement judgement) {
  if (const ordered_json holds = HoldsJson(judgement); !holds.is_null()) return holds.dump();
  return judgement == Judgement::kNotJudged ? "not_judged" : "not_asked";
}

ordered_json CountJson(const StabilityStudy::Count& count) {
  return {{"asked", count.asked}, {"judged", count.judged}, {"broken", count.broken}};
}

/// Formats the minimum over the states, for a cell of the table of devices.
std::string ShowLeastMargins(const ProfileMargins& row) {
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
  return Judge(row) == Judgement::kBroken ? fmt::format("**{}**", cell) : cell;
}

}  // namespace

std::string FormatStabilityJson(const StabilityStudy& s) {
  ordered_json scenarios = ordered_json::array();
  for (const ScenarioResult& scenario : s.scenarios) {
    ordered_json figures = ordered_json::array();
    for (const StabilityFigure& f : scenario.figures) {
      figures.push_back({{"name", f.name},
                         {"unit", f.unit},
                         {"value", NumberJson(f.value)},
                         {"bound", NumberJson(f.bound)},
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
             {"share_of_bound", NumberJson(CalcNearness(*ranked.front().figure))}};
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
  return DumpJson(json);
}

const Columns<FigureRow>& FigureColumns() {
  static const Columns<FigureRow> kColumns{
      {"scenario", "{}", "name of the scenario", &FigureRow::scenario},
      {"figure", "{}", "what was measured", &FigureRow::figure},
      {"unit", "{}", "unit of value and bound", &FigureRow::unit},
      {"value", "{:.7g}", "the measured value", &FigureRow::value},
      {"kind", "{}", "`at_most` or `at_least` the bound; `when`: the time at which the tool cut through",
       &FigureRow::kind},
      {"bound", "{:.7g}", "the bound; empty for `when`", &FigureRow::bound},
      {"holds", "{}", "true or false; `not_asked` for `when`", &FigureRow::holds}};
  return kColumns;
}

std::vector<FigureRow> ListFigures(const StabilityStudy& s) {
  std::vector<FigureRow> rows;
  for (const ScenarioResult& scenario : s.scenarios) {
    for (const StabilityFigure& f : scenario.figures) {
      rows.push_back({scenario.name, f.name, f.unit, f.value, f.at_most ? "at_most" : "at_least", f.bound,
                      f.holds() ? "true" : "false"});
    }
    if (scenario.cut_through_s)
      rows.push_back({scenario.name, "cut through", "s", *scenario.cut_through_s, "when", {}, "not_asked"});
  }
  return rows;
}

const Columns<HandMargins>& MarginColumns() {
  // The value of a figure, or empty if the margins could not be judged.
  const auto judged = [](auto figure) {
    return [figure](const HandMargins& m) {
      return m.margins.unjudged.empty() ? TableCell(m.margins.*figure) : TableCell();
    };
  };
  const char* const kGain = "factor of the device force up to which the motion decays; true: it is at least that";
  const char* const kDelay = "ticks of delay up to which the motion decays; true: it is at least that";
  static const Columns<HandMargins> kColumns{
      {"hand", "{}", "name of the hand", &HandMargins::hand},
      {"state", "{}", "state of tool and bone", [](const HandMargins& m) { return ToString(m.state); }},
      {"linear", "{}", "true: without the device's friction and encoder steps", &HandMargins::linear},
      {"gain", "{:.5g}", kGain, judged(&Margins::gain)},
      {"gain_beyond", "{}", kGain, judged(&Margins::gain_beyond)},
      {"delay_ticks", "{}", kDelay, judged(&Margins::delay_ticks)},
      {"delay_beyond", "{}", kDelay, judged(&Margins::delay_beyond)},
      {"holds", "{}", "true, false, `not_asked` or `not_judged`",
       [](const HandMargins& m) { return HoldsCsv(m.judgement()); }}};
  return kColumns;
}

std::vector<HandMargins> ListMargins(const StabilityStudy& s) {
  std::vector<HandMargins> rows;
  std::copy_if(s.margins.begin(), s.margins.end(), std::back_inserter(rows),
               [](const HandMargins& m) { return m.done; });
  return rows;
}

Columns<std::size_t> MapColumns(const StabilityStudy& s) {
  const auto damping = [&s](std::size_t i) { return s.map.damping_Ns_per_mm[i / s.map.stiffness_N_per_mm.size()]; };
  const auto stiffness = [&s](std::size_t i) { return s.map.stiffness_N_per_mm[i % s.map.stiffness_N_per_mm.size()]; };
  const char* const kCoupling = "of the coupling in the simulation";
  const char* const kDevice = "the same on the device";
  return {
      {"damping_Ns_per_mm", "{:.6g}", kCoupling, damping},
      {"stiffness_N_per_mm", "{:.6g}", kCoupling, stiffness},
      {"device_damping_Ns_per_mm", "{:.6g}", kDevice, [=, &s](auto i) { return damping(i) * s.setup.force_scale; }},
      {"device_stiffness_N_per_mm", "{:.6g}", kDevice, [=, &s](auto i) { return stiffness(i) * s.setup.force_scale; }},
      {"rule_N_per_mm", "{:.6g}", "largest stiffness by the rule for a sampled spring",
       [=, &s](auto i) { return s.limits.CalcRule(damping(i)); }},
      {"behaviour", "{}", "behaviour with the device as it is", [&s](auto i) { return ToString(s.map.behaviour[i]); }},
      {"linear", "{}", "behaviour without the device's friction and encoder steps",
       [&s](auto i) { return ToString(s.map_linear[i]); }}};
}

std::string FormatMapCsv(const StabilityStudy& s) {
  return FormatCsv(MapColumns(s), s.map.behaviour.size());
}

void WriteStabilityStudy(const Scene& scene, StabilityStudy& study, const std::string& folder) {
  MakeFolder(folder);
  const std::vector<std::string> earlier = ReadEarlierResults(folder, "stability.json");
  FileBatch results(folder, "stability.json");
  std::vector<std::string>& files = study.files;
  files = {"report.md", "stability.json"};
  const auto add = [&](const std::string& name) {
    files.push_back(name);
    return folder + "/" + name;
  };
  WriteTextFile(add("scene.toml"), ResolvedToml(scene));
  WriteTextFile(add("figures.csv"), FormatCsv(FigureColumns(), ListFigures(study)));
  WriteTextFile(add("margins.csv"), FormatCsv(MarginColumns(), ListMargins(study)));
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
  results.Commit(earlier);
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
  std::vector<std::string> headings{"device"};
  for (const ProfileMargins& row : rows) {
    if (row.profile == fullest->profile) headings.push_back(column(row));
  }
  TextTable table(headings);
  for (std::size_t i = 0; i < rows.size();) {
    const std::string& profile = rows[i].profile;
    std::vector<TableCell> cells{profile};
    for (; i < rows.size() && rows[i].profile == profile; ++i) cells.emplace_back(ShowLeastMargins(rows[i]));
    table.Add(cells);
  }
  return table.FormatMarkdown();
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
  return DumpJson(json);
}

}  // namespace kerf
