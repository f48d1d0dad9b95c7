// The report of `kerf stability`, in words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/core/append_format.h"
#include "base/files/markdown_text.h"
#include "base/table/table.h"
#include "experiment/stability_study/stability_files.h"
#include "kerf/version.h"

namespace kerf {
namespace {

std::string Unit(const std::string& unit) {
  return unit.empty() ? "" : " " + unit;
}

bool Wrote(const StabilityStudy& s, const std::string& file) {
  return std::find(s.files.begin(), s.files.end(), file) != s.files.end();
}

void AddVerdict(std::string& text, const StabilityStudy& s) {
  AppendFormat(text, "**{}**\n\n", DescribeVerdict(s));
  for (const std::string& finding : s.findings) AppendFormat(text, "- {}\n", EscapeMarkdown(finding));
  if (!s.findings.empty()) text += "\n";
  if (const std::string worst = DescribeWorst(s); !worst.empty())
    AppendFormat(text, "Closest to its bound: {}.\n\n", worst);
  for (const std::string& warning : s.warnings) AppendFormat(text, "Warning: {}.\n\n", EscapeMarkdown(warning));
}

void AddSetting(std::string& text, const StabilityStudy& s) {
  AppendFormat(text, "## What was examined\n\n");
  AppendFormat(text, "- {}, {}, in bone of {:g} mm voxels, where the path first touches it ({:.3f} s).\n",
               EscapeMarkdown(s.tool), s.rate, s.voxel_mm, s.touch.time_s);
  AppendFormat(text,
               "- Device {} in the hand {}, {:g} ticks per second; {:.3g} N on the device for 1 N in the simulation.\n",
               EscapeMarkdown(s.setup.profile.name), EscapeMarkdown(s.setup.hand.name), s.rate_hz, s.setup.force_scale);
  AppendFormat(text, "- Coupling: {}; damping {:.4g} N s/mm.\n", EscapeMarkdown(DescribeCoupling(s.setup)),
               s.setup.fitted.coupling.damping_Ns_per_mm);
  AppendFormat(text, "- Limits: {}.\n\n", EscapeMarkdown(DescribeLimits(s.setup)));
}

void AddScenarios(std::string& text, const StabilityStudy& s) {
  AppendFormat(
      text,
      "## Scenarios\n\nEach scenario runs on the simulated device, with its friction and encoder, in virtual time; "
      "seed {}.\n\n",
      s.seed);
  TextTable table({"scenario", "figure", "measured", "bound", "holds"});
  for (const ScenarioResult& scenario : s.scenarios) {
    const auto note = [&](const std::string& what, Judgement judgement) {
      table.Add({scenario.name, what, "", "", ToString(judgement)});
    };
    if (scenario.skipped) note(scenario.what, Judgement::kNotAsked);
    if (!scenario.unjudged.empty()) note(scenario.unjudged, Judgement::kNotJudged);
    if (scenario.cut_through_s) note(DescribeCutThrough(scenario), Judgement::kNotAsked);
    for (const StabilityFigure& f : scenario.figures) {
      table.Add({scenario.name, f.name, fmt::format("{:.3g}{}", f.value, Unit(f.unit)),
                 fmt::format("{} {:.3g}", f.at_most ? "at most" : "at least", f.bound), f.holds() ? "yes" : "**no**"});
    }
  }
  text += table.FormatMarkdown() + "\n";
  for (const ScenarioResult& scenario : s.scenarios) {
    if (!scenario.skipped) AppendFormat(text, "- **{}**: {}\n", scenario.name, scenario.what);
  }
  text += "\n";
  for (const char* file : {"worst_1.png", "worst_2.png", "worst_3.png"}) {
    if (Wrote(s, file)) AppendFormat(text, "![Force over time]({})\n\n", file);
  }
}

void AddMargins(std::string& text, const StabilityStudy& s) {
  AppendFormat(
      text,
      "## Margins\n\nGain / ticks: the factor by which the device force can be multiplied, and the number of ticks by "
      "which it can be delayed, before the motion after a kick no longer decays. Required: {:g} / {} with the scene's "
      "hand; a stable loop with any other hand and the same coupling; nothing with H0, a released handle, because no "
      "hand pushes it (the scenario let_go shows its behaviour). *Linear*: without the device's friction and the "
      "encoder's steps.\n\n",
      kMinGainMargin, kMinDelayMargin_ticks);
  TextTable table({"hand", "state", "with the real device", "linear", "holds"});
  for (const HandMargins& m : s.margins) {
    if (!m.done || m.linear) continue;
    const auto linear = std::find_if(s.margins.begin(), s.margins.end(), [&](const HandMargins& other) {
      return other.linear && other.done && other.hand == m.hand && other.state == m.state;
    });
    const bool has_linear = linear != s.margins.end();
    const Judgement both = has_linear ? Both(m.judgement(), linear->judgement()) : m.judgement();
    table.Add({EscapeMarkdown(m.hand) + (m.own ? " (the scene's)" : ""), ToString(m.state), DescribeMargins(m.margins),
               has_linear ? DescribeMargins(linear->margins) : "",
               both == Judgement::kBroken ? "**no**" : ToString(both)});
  }
  text += table.FormatMarkdown();
  text += "\n";
  if (Wrote(s, "margins.png")) AppendFormat(text, "![Gain margin by hand](margins.png)\n\n");
  if (Wrote(s, "delays.png")) AppendFormat(text, "![Delay margin by hand](delays.png)\n\n");
}

void AddMap(std::string& text, const StabilityStudy& s) {
  if (s.map.behaviour.empty()) return;
  AppendFormat(
      text,
      "## Map\n\nStiffness and damping of the coupling, {}. The line is the rule for a sampled spring, K = 2 (b + B) / "
      "(T + 2 t_d), with b = {:.4g} N s/mm of device and hand; it applies to a linear device and small B.\n\n",
      ToString(s.map_state), s.limits.own_damping_Ns_per_mm);
  if (Wrote(s, "map.png")) AppendFormat(text, "![Stability map](map.png)\n\n");
}

}  // namespace

std::string DescribeVerdict(const StabilityStudy& s) {
  const StabilityStudy::Count scenarios = s.CountScenarios();
  const StabilityStudy::Count margins = s.CountMargins();
  const int judged = scenarios.judged + margins.judged;
  const std::string of = fmt::format("{} of {} scenarios, {} of {} margins", scenarios.judged, scenarios.asked,
                                     margins.judged, margins.asked);
  if (!s.complete) {
    if (judged == 0) return "Stopped before anything was examined.";
    return fmt::format("Stopped before all cases were examined; {}",
                       s.findings.empty() ? fmt::format("stable so far ({}).", of) : "not stable so far:");
  }
  if (judged == 0) return "Nothing could be judged here.";
  const double K = s.setup.fitted.coupling.stiffness_N_per_mm;
  const bool lowered = K < s.setup.asked_stiffness_N_per_mm;
  const std::string at =
      lowered ? fmt::format(" at {:.3g} N/mm ({:.4g} requested)", K, s.setup.asked_stiffness_N_per_mm) : std::string();
  if (!s.findings.empty()) return fmt::format("Not stable{}:", at);
  if (judged == scenarios.asked + margins.asked) return fmt::format("Stable{}.", at);
  return fmt::format("Stable{} as far as could be judged: {}.", at, of);
}

std::string DescribeCutThrough(const ScenarioResult& scenario) {
  return scenario.cut_through_s ? fmt::format("cut through at t = {:.2f} s", *scenario.cut_through_s) : std::string();
}

Judgement Both(Judgement a, Judgement b) {
  for (const Judgement worst : {Judgement::kBroken, Judgement::kNotJudged, Judgement::kHolds}) {
    if (a == worst || b == worst) return worst;
  }
  return Judgement::kNotAsked;
}

std::string DescribeFigure(const StabilityFigure& f) {
  return fmt::format("{:.3g}{}, {} {:.3g}", f.value, Unit(f.unit), f.at_most ? "at most" : "at least", f.bound);
}

std::string DescribeWorst(const StabilityStudy& s) {
  const std::vector<WorstFigure> ranked = RankScenarios(s);
  if (ranked.empty()) return "";
  const WorstFigure& worst = ranked.front();
  return fmt::format("{}, {} {}", worst.scenario->name, worst.figure->name, DescribeFigure(*worst.figure));
}

std::string DescribeMargins(const Margins& m) {
  if (!m.unjudged.empty()) return "not judged: " + m.unjudged;
  return fmt::format("{}{:.3g} / {}{}", m.gain_beyond ? "> " : "", m.gain, m.delay_beyond ? ">= " : "", m.delay_ticks);
}

std::string FormatStabilityReport(const StabilityStudy& s) {
  std::string text = fmt::format("# {}: stability in a hand\n\n", EscapeMarkdown(s.title.empty() ? s.scene : s.title));
  AddVerdict(text, s);
  AddSetting(text, s);
  AddScenarios(text, s);
  AddMargins(text, s);
  AddMap(text, s);
  AppendFormat(text,
               "## To reproduce\n\nIn this folder, whose scene.toml specifies the chosen hand and "
               "device:\n\n```\n{}\n```\n\nMade by kerf {} (commit {}).\n",
               MarkdownCodeLine(s.command), VersionString(), CommitString());
  return text;
}

}  // namespace kerf
