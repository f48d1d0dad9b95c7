#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/files/markdown_text.h"
#include "base/table/table.h"
#include "experiment/study/knobs.h"
#include "experiment/study/study_words.h"

namespace kerf {
namespace {

std::string ShowSlope(const std::optional<Slope>& slope) {
  if (!slope) return "";
  std::string text = fmt::format("{:.2f}", slope->slope);
  if (slope->interval) text += fmt::format(" ({:.2f} to {:.2f})", slope->interval->first, slope->interval->second);
  return text;
}

std::string OnPath(const SafeError& error, const std::string& path) {
  return fmt::format("{} on `{}`", ShowError(error), path);
}

/// Returns the table and an empty line; empty if the table has no rows.
std::string Finish(const TextTable& table) {
  return table.empty() ? "" : table.FormatMarkdown() + "\n";
}

}  // namespace

std::string ShowFraction(double fraction) {
  return ShowThree(100 * fraction) + " %";
}

std::string ShowSignedFraction(double fraction) {
  return (fraction > 0 ? "+" : "") + ShowFraction(fraction);
}

std::string ShowError(const SafeError& error) {
  return (error.at_most ? "at most " : "") + ShowFraction(error.value);
}

std::vector<std::string> PathsOfSlab(const StudyResults& study, Holding holding) {
  std::vector<std::string> paths;
  for (const PooledSetting& setting : PoolSettings(study, holding)) {
    if (setting.knob != "method" || setting.value != "slab") continue;
    for (const CaseRecord* record : setting.cases) paths.push_back(record->path);
  }
  return paths;
}

std::string DefaultsTable(const StudyResults& study, Holding holding) {
  TextTable table({"path", "force, p95", "impulse", "direction, p95 (deg)", "volume", "surface, mean / max (mm)",
                   "breakthrough delay (ms)", "tick, p50 / p99 / p99.9 / max (us)", "misses per million",
                   "memory (MB)"});
  for (const std::string& path : study.paths) {
    for (const CaseRecord& record : study.cases) {
      if (record.holding != holding || record.path != path || record.knob != "default" || !record.errors) continue;
      const ErrorFigures& e = *record.errors;
      std::vector<TableCell> row{EscapeMarkdown(path),
                                 ShowError(CalcForceError(study, record)),
                                 e.impulse_signed ? ShowSignedFraction(*e.impulse_signed) : "",
                                 ShowThree(e.direction_p95_deg),
                                 ShowFraction(e.volume),
                                 fmt::format("{} / {}", ShowThree(e.surface_mean_mm), ShowThree(e.surface_max_mm)),
                                 e.breakthrough_ms ? ShowThree(*e.breakthrough_ms) : ""};
      if (record.costs) {
        const CostFigures& c = *record.costs;
        row.insert(row.end(), {fmt::format("{} / {} / {} / {}", ShowThree(c.tick.p50_us), ShowThree(c.tick.p99_us),
                                           ShowThree(c.tick.p999_us), ShowThree(c.tick.max_us)),
                               ShowThree(c.misses_per_million), ShowThree(c.memory_MB)});
      }
      table.Add(row);
    }
  }
  return Finish(table);
}

std::string EqualTimeTable(const StudyResults& study, Holding holding) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding);
  if (FindFront(settings).empty()) return "";  // no setting is ranked
  TextTable table({"limit of p99.9 per simulated ms, on every path", "best setting", "force, p95, worst path",
                   "its p99.9 (us per ms)"});
  for (const double budget_us : {250.0, 500.0, 1000.0}) {
    const PooledSetting* best = nullptr;
    for (const PooledSetting& setting : settings) {
      if (!setting.ranked || setting.p999_us > budget_us) continue;
      if (best == nullptr || setting.worst.value < best->worst.value ||
          (setting.worst.value == best->worst.value && setting.p999_us < best->p999_us)) {
        best = &setting;
      }
    }
    const std::string limit = fmt::format("{:g} ms", budget_us / 1000);
    if (best == nullptr)
      table.Add({limit, "none"});
    else
      table.Add({limit, best->Name(), OnPath(best->worst, best->worst_path), ShowThree(best->p999_us)});
  }
  return Finish(table);
}

std::string EqualErrorTable(const StudyResults& study, Holding holding) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding);
  if (FindFront(settings).empty()) return "";  // no setting is ranked
  TextTable table({"limit of force, p95, on every path", "cheapest setting", "p99, slowest path (us per ms)",
                   "p99.9 (us per ms)", "its error"});
  for (const double limit : {kTargetForce, kForceJnd}) {
    const PooledSetting* best = nullptr;
    for (const PooledSetting& setting : settings) {
      if (!setting.ranked || setting.worst.value > limit) continue;
      if (best == nullptr || setting.p99_us < best->p99_us) best = &setting;
    }
    if (best == nullptr)
      table.Add({ShowFraction(limit), "none"});
    else
      table.Add({ShowFraction(limit), best->Name(),
                 fmt::format("{} on `{}`", ShowThree(best->p99_us), best->slowest_path), ShowThree(best->p999_us),
                 ShowError(best->worst)});
  }
  return Finish(table);
}

std::string SettingsTable(const StudyResults& study, Holding holding) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding);
  if (settings.empty()) return "";
  const std::vector<std::size_t> front = FindFront(settings);
  TextTable table({"setting", "paths", "force, p95, worst path", "median path", "p50 (us)", "p99 (us)", "p99.9 (us)",
                   "on the Pareto front"});
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const PooledSetting& s = settings[i];
    const auto time = [&s](double us) { return s.timed ? ShowThree(us) : ""; };
    table.Add({s.Name(), s.paths, OnPath(s.worst, s.worst_path), ShowError(s.median), time(s.p50_us), time(s.p99_us),
               time(s.p999_us), std::find(front.begin(), front.end(), i) != front.end() ? "yes" : ""});
  }
  return Finish(table);
}

std::string OrdersTable(const StudyResults& study, Holding holding) {
  TextTable table({"knob", "over all values", "over the coarser half", "theory", "paths"});
  for (const std::string& name : study.knobs) {
    const std::optional<KnobErrors> errors = MakeKnobErrors(study, holding, name);
    if (!errors || !errors->slope) continue;
    const Knob& knob = FindKnob(name);
    table.Add({fmt::format("`{}`", name), ShowSlope(errors->slope), ShowSlope(errors->coarse),
               knob.theory.empty() ? "none" : EscapeMarkdown(knob.theory), errors->slope->paths});
  }
  return Finish(table);
}

std::string SlabTable(const StudyResults& study, Holding holding) {
  const std::vector<std::string> paths = PathsOfSlab(study, holding);
  if (paths.empty()) return "";
  TextTable table(
      {"setting", "p50, median path (us)", "p99, slowest path (us)", "force, p95, median path", "worst path"});
  for (const PooledSetting& s : PoolSettings(study, holding, paths)) {
    if ((!s.is_default && s.knob != "method" && s.knob != "voxel_mm") || !s.complete || !s.timed) continue;
    table.Add({s.Name(), ShowThree(s.p50_us), ShowThree(s.p99_us), ShowError(s.median), OnPath(s.worst, s.worst_path)});
  }
  return fmt::format("Over {}.\n\n{}\n", fmt::join(paths, ", "), table.FormatMarkdown());
}

std::string LeftOutTable(const StudyResults& study) {
  struct Group {
    std::string what, state, why;
    std::vector<std::string> paths;
  };
  std::vector<Group> groups;
  for (const CaseRecord& record : study.cases) {
    if (record.state == CaseState::kDone) continue;
    const std::string what = fmt::format(
        "{}, {}",
        record.knob == "default" ? "the defaults" : MarkdownCode(fmt::format("{} = {}", record.knob, record.value)),
        ToString(record.holding));
    const std::string state = record.state == CaseState::kFailed ? "failed" : "left out";
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return g.what == what && g.state == state && g.why == record.why;
    });
    Group& group = same != groups.end() ? *same : groups.emplace_back(Group{what, state, record.why, {}});
    group.paths.push_back(record.path);
  }
  if (groups.empty()) return "Nothing was left out, and nothing failed.\n\n";
  TextTable table({"setting", "paths", "", "reason"});
  for (const Group& g : groups) {
    table.Add({g.what, EscapeMarkdown(fmt::format("{}", fmt::join(g.paths, ", "))), g.state, EscapeMarkdown(g.why)});
  }
  return Finish(table);
}

std::string ReferencesTable(const StudyResults& study) {
  TextTable table({"path", "holding", "physics", "steps per tick", "error bar, p95", "error bar, L2", "volume",
                   "computed in (s)", "force hash", "note"});
  for (const ReferenceRecord& r : study.references) {
    table.Add({EscapeMarkdown(r.path), ToString(r.holding), EscapeMarkdown(r.variant), r.steps_per_tick,
               ShowFraction(r.error_bar), ShowFraction(r.error_bar_l2), ShowFraction(r.volume_bar),
               ShowThree(r.seconds), fmt::format("`{:016x}`", r.force_hash), EscapeMarkdown(r.note)});
  }
  return Finish(table);
}

}  // namespace kerf
