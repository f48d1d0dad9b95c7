// Formats the results of `kerf tune` for the user and for programs.
#include <fmt/format.h>

#include "base/table/table_json.h"
#include "experiment/study/record_json.h"
#include "experiment/study/tune.h"
#include "kerf/version.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

std::string DescribeAsked(const TuneOptions& options) {
  std::string text;
  if (options.budget_us) text += fmt::format("p99 at most {:g} us", *options.budget_us);
  if (options.error) text += fmt::format("{}error at most {:g} %", text.empty() ? "" : ", ", 100 * *options.error);
  return text;
}

std::string DescribeError(double force_p95, double bar) {
  return force_p95 < bar ? fmt::format("at most {:.2f} %", 100 * bar) : fmt::format("{:.2f} %", 100 * force_p95);
}

ordered_json CandidateJson(const TuneCandidate& c) {
  ordered_json json = {{"voxel_mm", c.settings.voxel_mm},
                       {"rim_samples_per_pitch", c.settings.rim_samples_per_pitch},
                       {"substeps", c.settings.substeps},
                       {"carve_interval_ticks", c.settings.carve_interval_ticks}};
  if (!c.done()) {
    json["why_not"] = c.outcome.why;
    return json;
  }
  const ErrorFigures& e = *c.outcome.errors;
  const Percentiles& t = c.outcome.costs->tick;
  json["force_p95"] = c.force_p95;
  json["impulse_signed"] = e.impulse_signed.value_or(0);
  json["force_worst"] = e.force_worst;
  json["force_l2"] = e.force_l2;
  json["direction_p95_deg"] = e.direction_p95_deg;
  json["volume"] = e.volume;
  json["ticks"] = t.count;
  json["p50_us"] = t.p50_us;
  json["p99_us"] = t.p99_us;
  json["p999_us"] = t.p999_us;
  json["max_us"] = t.max_us;
  json["memory_MB"] = c.outcome.costs->memory_MB;
  json["force_hash"] = fmt::format("{:016x}", c.outcome.force_hash);
  json["bone_hash"] = fmt::format("{:016x}", c.outcome.bone_hash);
  return json;
}

}  // namespace

std::string DescribeExtent(const TuneResult& r) {
  const std::string strokes = r.strokes == 1            ? std::string()
                              : r.measured == r.strokes ? fmt::format(", all {} strokes", r.strokes)
                                                        : fmt::format(", {} of its {} strokes", r.measured, r.strokes);
  if (r.extent == TuneExtent::kWhole) {
    return fmt::format("the whole path from the first contact {} ({:.2f} to {:.2f} s{})",
                       r.to_s < r.path_s ? "to the last" : "onward", r.from_s, r.to_s, strokes);
  }
  return fmt::format("{:.2f} to {:.2f} s of the path's {:.2f} s ({}{})", r.from_s, r.to_s, r.path_s,
                     r.extent == TuneExtent::kSeconds ? "as requested" : "the first passage through the bone", strokes);
}

std::string DescribeEvidence(const TuneResult& r, const TuneOptions& options) {
  if (!r.again || !r.again->done()) return {};
  const Percentiles& t = r.again->outcome.costs->tick;
  const ErrorFigures& e = *r.again->outcome.errors;
  std::string phases;
  for (const TunePhase& p : r.phases) {
    phases += fmt::format("{} {} {}", phases.empty() ? "; by phase" : ",", p.phase.name,
                          DescribeError(p.force_p95, r.reference.error_bar));
  }
  return fmt::format(
      "requested {}; measured p50 {:.0f}, p99 {:.0f}, p99.9 {:.0f}, max {:.0f} us over {} ticks; force within {} (p95 "
      "over the ticks with tooth contact in the run or the reference, relative to the reference force or {:g} N, "
      "whichever is larger) and impulse {:+.2f} % over {}{}; {} on {} ({} cores, load {:.1f}), "
      "commit {}",
      DescribeAsked(options), t.p50_us, t.p99_us, t.p999_us, t.max_us, t.count,
      DescribeError(r.again->force_p95, r.reference.error_bar), kMinForce_N, 100 * e.impulse_signed.value_or(0),
      DescribeExtent(r), phases, r.holding == Holding::kHand ? "coupled to a handle" : "on a prescribed path",
      r.machine.cpu, r.machine.cores, r.machine.load, CommitString());
}

std::string FormatTuneTable(const TuneResult& r) {
  TextTable table({"", "voxel (mm)", "samples/pitch", "steps/tick", "carve (ticks)", "force p95 (%)", "impulse (%)",
                   "direction p95 (deg)", "p50 (us)", "p99 (us)", "p99.9 (us)", "max (us)", "memory (MB)"});
  const auto add = [&](const TuneCandidate& c, const char* mark) {
    std::vector<TableCell> row{mark, fmt::format("{:g}", c.settings.voxel_mm), c.settings.rim_samples_per_pitch,
                               c.settings.substeps, c.settings.carve_interval_ticks};
    if (c.done()) {
      const ErrorFigures& e = *c.outcome.errors;
      const Percentiles& t = c.outcome.costs->tick;
      const bool below = c.force_p95 < r.reference.error_bar;
      const auto us = [](double time_us) { return fmt::format("{:.1f}", time_us); };
      row.insert(
          row.end(),
          {fmt::format("{}{:.2f}", below ? "< " : "", 100 * (below ? r.reference.error_bar : c.force_p95)),
           fmt::format("{:+.2f}", 100 * e.impulse_signed.value_or(0)), fmt::format("{:.2f}", e.direction_p95_deg),
           us(t.p50_us), us(t.p99_us), us(t.p999_us), us(t.max_us), us(c.outcome.costs->memory_MB)});
    }
    table.Add(row);
  };
  std::string failures;
  for (std::size_t i = 0; i < r.candidates.size(); ++i) {
    const TuneCandidate& c = r.candidates[i];
    add(c, r.chosen && *r.chosen == i ? "chosen" : "");
    if (!c.done()) failures += fmt::format("  voxel {:g} mm: {}\n", c.settings.voxel_mm, c.outcome.why);
  }
  if (r.again) add(*r.again, "again");
  std::string text = table.FormatTerminal("  ") + failures;
  for (const TunePhase& p : r.phases) {
    text += fmt::format("    {:<12} {:>6.2f} to {:>6.2f} s  force p95 {:>6.2f} %  impulse {:>+6.2f} %\n", p.phase.name,
                        p.phase.from_s, p.phase.to_s, 100 * p.force_p95, 100 * p.impulse_signed);
  }
  text += fmt::format(
      "  errors are over {};\n"
      "  force p95: of |F - R| / max(|R|, {:g} N), R being the reference, over the ticks with tooth contact in\n"
      "  either; impulse: positive if the force is too large overall, negative if too small\n",
      DescribeExtent(r), kMinForce_N);
  return text;
}

std::string FormatTuneJson(const TuneResult& r, const TuneOptions& options, const std::vector<SceneEdit>& edits) {
  ordered_json candidates = ordered_json::array();
  for (const TuneCandidate& c : r.candidates) candidates.push_back(CandidateJson(c));
  ordered_json phases = ordered_json::array();
  for (const TunePhase& p : r.phases) {
    phases.push_back({{"phase", p.phase.name},
                      {"from_s", p.phase.from_s},
                      {"to_s", p.phase.to_s},
                      {"force_p95", p.force_p95},
                      {"impulse_signed", p.impulse_signed}});
  }
  ordered_json changes = ordered_json::array();
  for (const SceneEdit& edit : edits) {
    changes.push_back({{"table", edit.table}, {"key", edit.key}, {"value", edit.value}});
  }
  const ordered_json json = {{"kerf", VersionString()},
                             {"commit", CommitString()},
                             {"scene", r.scene},
                             {"holding", ToString(r.holding)},
                             {"rate_hz", r.rate_hz},
                             {"budget_us", OrNull(options.budget_us)},
                             {"error", OrNull(options.error)},
                             {"machine", ToJson(r.machine)},
                             {"errors_over", DescribeExtent(r)},
                             {"errors_from_s", r.from_s},
                             {"errors_to_s", r.to_s},
                             {"path_s", r.path_s},
                             {"strokes", r.strokes},
                             {"strokes_measured", r.measured},
                             {"reference_error_bar", r.reference.error_bar},
                             {"candidates", candidates},
                             {"chosen", OrNull(r.chosen)},
                             {"again", r.again ? CandidateJson(*r.again) : ordered_json()},
                             {"keeps", r.keeps},
                             {"phases", phases},
                             {"edits", changes},
                             {"notes", r.notes}};
  return DumpJson(json);
}

}  // namespace kerf
