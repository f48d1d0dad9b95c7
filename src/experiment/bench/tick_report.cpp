#include "experiment/bench/tick_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/core/number_text.h"
#include "base/table/table_json.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

std::string WithUnit(double value, const std::string& unit) {
  return ShowThree(value) + (unit.empty() ? "" : " " + unit);
}

/// Formats the errors for the column next to the times.
std::string ShowErrors(const BenchResult& r) {
  std::vector<std::string> errors;
  if (const BenchFigure* f = r.Find("removed minus swept")) {
    errors.push_back(fmt::format("volume {:+.3f} %, by occupancy {:+.3f} %", f->value,
                                 r.Find("removed by occupancy minus swept")->value));
  }
  if (const BenchFigure* f = r.Find("phi against dense at the surface, at most")) {
    errors.push_back(fmt::format("phi {} voxels from dense", ShowThree(f->value)));
  }
  return fmt::format("{}", fmt::join(errors, "; "));
}

/// Formats how many times faster the tick is than the baseline and the other ways, with the range of the blocks.
std::string ShowBaseline(const BenchResult& r) {
  if (!r.baseline) return "";
  std::string text = fmt::format("{} times faster than {} us ({})", ShowThree(r.TimesFaster()),
                                 ShowThree(r.baseline->times.p50_us), r.baseline->what);
  for (const BenchFigure& f : r.figures) {
    constexpr std::string_view kBegin = "speedup over ";
    const BenchFigure* const least = r.Find(f.what + ", least of the blocks");
    if (least == nullptr) continue;
    text += fmt::format("; {} ({} to {}) than {}", ShowThree(f.value), ShowThree(least->value),
                        ShowThree(r.Find(f.what + ", most of the blocks")->value), f.what.substr(kBegin.size()));
  }
  return text;
}

bool IsOfTime(const BenchTarget& target) {
  return target.unit == "us";
}

/// Formats the limits on the tick's time.
std::string ShowTimeLimits(const BenchResult& r) {
  std::vector<std::string> limits;
  for (const BenchTarget& t : r.targets) {
    if (IsOfTime(t)) limits.push_back(fmt::format("{} {}{}", t.what, ShowThree(t.limit), t.met() ? "" : " **missed**"));
  }
  return fmt::format("{}", fmt::join(limits, ", "));
}

std::string ShowOtherTargets(const BenchResult& r) {
  std::string text;
  for (const BenchTarget& t : r.targets) {
    if (IsOfTime(t)) continue;
    text += fmt::format("- {}: {} {}, {} {}{}\n", r.name, t.what, WithUnit(t.measured, t.unit),
                        t.at_least ? "at least" : "at most", WithUnit(t.limit, t.unit), t.met() ? "" : " **missed**");
  }
  return text;
}

ordered_json ResultJson(const BenchResult& r) {
  ordered_json json = {{"name", r.name}, {"title", r.title}};
  json["tick"] = r.times.count > 0 ? TimesJson(r.times) : ordered_json(nullptr);
  json["undisturbed"] = r.times.count > 0 ? TimesJson(r.undisturbed) : ordered_json(nullptr);
  json["baseline"] = nullptr;
  if (r.baseline) {
    json["baseline"] = {{"what", r.baseline->what}};
    json["baseline"].update(TimesJson(r.baseline->times));
    json["baseline"]["times_faster"] = RoundedJson(r.TimesFaster());
  }
  json["stages_mean_us"] = ordered_json::object();
  for (std::size_t i = 0; i < r.stages_us.size(); ++i)
    json["stages_mean_us"][NameOfStage(i)] = RoundedJson(r.stages_us[i]);
  json["figures"] = ordered_json::array();
  for (const BenchFigure& f : r.figures) {
    json["figures"].push_back({{"what", f.what}, {"value", RoundedJson(f.value)}, {"unit", f.unit}});
  }
  json["targets"] = ordered_json::array();
  for (const BenchTarget& t : r.targets) {
    json["targets"].push_back({{"what", t.what},
                               {t.at_least ? "at_least" : "at_most", RoundedJson(t.limit)},
                               {"measured", RoundedJson(t.measured)},
                               {"unit", t.unit},
                               {"met", t.met()}});
  }
  json["bone_hash"] = r.hash != 0 ? ordered_json(fmt::format("{:016x}", r.hash)) : ordered_json(nullptr);
  json["note"] = r.note;
  return json;
}

// These figures are quoted, not measured again. They come from a different machine, though also a shared AMD EPYC.
constexpr const char* kPeers =
    "Peers on the block of 256^3, ball r = 3 mm, 10 mm/s, p50/p99 (measured elsewhere, on 2 shared cores of an AMD "
    "EPYC): CHAI3D 136/279 us, removes 3 % of what it sweeps; AMBF 133/269 us, 32 %; iMSTK 364/591 us, 104 %. At "
    "r = 30 voxels: CHAI3D 944/2852 us, AMBF 938/2830 us. Disc r = 10 mm: iMSTK 4298/9783 us.";

}  // namespace

std::vector<std::string> FindTickWarnings(const TickReport& report) {
  std::vector<std::string> warnings;
  if (report.run.load > 0.5 && !report.run.realtime) {
    warnings.push_back(fmt::format(
        "the machine was busy before the run (load {:.1f} on {} cores); the slowest ticks are due to other programs",
        report.run.load, report.run.cores));
  }
  for (const BenchResult& r : report.results) {
    if (!r.note.empty()) warnings.push_back(fmt::format("{}: {}", r.name, r.note));
  }
  return warnings;
}

std::string FormatTickTable(const TickReport& report) {
  TextTable table(
      {"case", "ticks", "p50 (us)", "p99 (us)", "p99.9 (us)", "max (us)", "baseline (us)", "faster", "bone"});
  for (const BenchResult& r : report.results) {
    table.Add({r.name, r.times.count, ShowThree(r.times.p50_us), ShowThree(r.times.p99_us), ShowThree(r.times.p999_us),
               ShowThree(r.times.max_us), r.baseline ? ShowThree(r.baseline->times.p50_us) : "-",
               r.baseline ? ShowThree(r.TimesFaster()) : "-", r.hash ? fmt::format("{:016x}", r.hash) : "-"});
  }
  std::string text = DescribeRun(report.run) + "\n" + table.FormatTerminal();
  text += "\n";
  for (const BenchResult& r : report.results) {
    text += fmt::format("{}: {}\n", r.name, r.title);
    if (r.undisturbed.count < r.times.count) {
      text += fmt::format("  other programs took the core in {} ticks; without these p50 {} us, p99 {} us, max {} us\n",
                          r.times.count - r.undisturbed.count, ShowThree(r.undisturbed.p50_us),
                          ShowThree(r.undisturbed.p99_us), ShowThree(r.undisturbed.max_us));
    }
    if (r.baseline) text += fmt::format("  baseline: {}, {} ticks\n", r.baseline->what, r.baseline->times.count);
    for (const BenchTarget& t : r.targets) {
      text += fmt::format("  {:<7} {} {} {}: {}\n", t.met() ? "met" : "MISSED", t.what,
                          t.at_least ? "at least" : "at most", WithUnit(t.limit, t.unit), ShowThree(t.measured));
    }
    for (const BenchFigure& f : r.figures) text += fmt::format("  {}: {}\n", f.what, WithUnit(f.value, f.unit));
    if (!r.stages_us.empty()) {
      text += "  stages, mean us:";
      for (std::size_t i = 0; i < r.stages_us.size(); ++i) {
        text += fmt::format(" {} {}", NameOfStage(i), ShowThree(r.stages_us[i]));
      }
      text += "\n";
    }
  }
  return text;
}

/// Returns the table of the work of a tick, and how near it comes to the machine's limits.
std::string FormatWork(const TickReport& report) {
  constexpr std::pair<const char*, const char*> kColumns[] = {
      {"leaves visited", "leaves visited by removal"},
      {"voxels computed", "voxels computed by removal"},
      {"voxels changed", "voxels changed"},
      {"samples", "samples of the bone by contact"},
      {"kB", "bytes of these voxels and corners"},
      {"of the memory's rate (%)", "these bytes against this core's memory"},
      {"removal, of the vector rate (%)", "removal against this core's vector rate"},
      {"samples, of the vector rate (%)", "samples against this core's vector rate"},
  };
  std::vector<std::string> headings{"case"};
  for (const auto& [heading, figure] : kColumns) headings.emplace_back(heading);
  TextTable table(headings);
  const BenchResult* measured = nullptr;
  for (const BenchResult& r : report.results) {
    if (r.Find(kColumns[0].second) == nullptr) continue;
    measured = &r;
    std::vector<TableCell> row{r.name};
    for (const auto& [heading, figure] : kColumns) {
      const BenchFigure* const f = r.Find(figure);
      row.emplace_back(f != nullptr ? ShowThree(f->value) : "");
    }
    table.Add(row);
  }
  if (measured == nullptr) return "";
  const auto rate = [&](const char* figure) { return ShowThree(measured->Find(figure)->value); };
  std::string text =
      "\nThe work of a tick. kB: 8 bytes of each computed voxel, read and written, and the 32 bytes of each sample's "
      "corners, without the tables that lead to them. ";
  text += fmt::format("Of the memory's rate: what this is a second, over the whole tick, of {} GB/s. ",
                      rate("memory rate of this core"));
  text += fmt::format(
      "Of the vector rate: the operations counted in the source a second, over the stages remove ({:.0f} for a voxel "
      "of "
      "a disc, {:.0f} of a ball) and engage ({:.0f} for a sample), of {} Gop/s of floats and {} of doubles in "
      "registers. ",
      kDiscOperations, kBallOperations, kSampleOperations, rate("vector rate of this core, floats"),
      rate("vector rate of this core, doubles"));
  return text + "The rates are those of one core, measured in the same run, for the last case listed:\n\n" +
         table.FormatMarkdown();
}

std::string FormatTickMarkdown(const TickReport& report) {
  TextTable table(
      {"case", "what", "tick: p50 / p99 / p99.9 / max (us)", "upper limits (us)", "baseline", "error", "bone"});
  for (const BenchResult& r : report.results) {
    const std::string times = fmt::format("{} / {} / {} / {}", ShowThree(r.times.p50_us), ShowThree(r.times.p99_us),
                                          ShowThree(r.times.p999_us), ShowThree(r.times.max_us));
    table.Add({r.name, r.title, r.times.count > 0 ? times : "", ShowTimeLimits(r), ShowBaseline(r), ShowErrors(r),
               r.hash != 0 ? fmt::format("`{:016x}`", r.hash) : ""});
  }
  std::string text = table.FormatMarkdown() + "\n";
  for (const BenchResult& r : report.results) text += ShowOtherTargets(r);
  text += fmt::format(
      "\n{}. error: removed volume minus swept volume, from the exact volume of the level set and from the occupancy "
      "of voxels; "
      "largest difference of phi from brute force near the surface. bone: hash of the bone after the cut. {}\n\n",
      DescribeRun(report.run), kPeers);
  std::vector<std::string> headings{"case"};
  for (std::size_t i = 0; i < kTickStages; ++i) headings.emplace_back(NameOfStage(i));
  TextTable stages(headings);
  for (const BenchResult& r : report.results) {
    if (r.stages_us.empty()) continue;
    std::vector<TableCell> row{r.name};
    for (const double us : r.stages_us) row.emplace_back(ShowThree(us));
    stages.Add(row);
  }
  return text + "Where the time goes, mean us per tick (timing the stages adds a little):\n\n" +
         stages.FormatMarkdown() + FormatWork(report);
}

std::string FormatTickJson(const TickReport& report) {
  ordered_json json = RunJson(report.run);
  json["ticks_asked_for"] = report.ticks;
  json["cases"] = ordered_json::array();
  for (const BenchResult& r : report.results) json["cases"].push_back(ResultJson(r));
  json["peers"] = kPeers;
  json["warnings"] = FindTickWarnings(report);
  return DumpJson(json);
}

}  // namespace kerf
