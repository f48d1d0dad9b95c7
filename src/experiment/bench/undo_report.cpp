#include <fmt/format.h>

#include "base/table/table_json.h"
#include "experiment/bench/undo_bench.h"

namespace kerf {
namespace {

nlohmann::ordered_json UndoTimesJson(const UndoTimes& t) {
  return {{"all_p50_ms", RoundedJson(t.all_p50_ms)},
          {"all_max_ms", RoundedJson(t.all_max_ms)},
          {"prepare_p50_ms", RoundedJson(t.prepare_p50_ms)},
          {"prepare_max_ms", RoundedJson(t.prepare_max_ms)},
          {"ticks", t.ticks},
          {"tick_p50_us", RoundedJson(t.tick_p50_us)},
          {"tick_max_us", RoundedJson(t.tick_max_us)}};
}

std::string FormatHistory(const UndoReport& r) {
  return fmt::format(
      "Tick with history p50 {:.1f}, p99 {:.1f} us; without {:.1f}, {:.1f} us; difference {:+.1f} and {:+.1f} us, "
      "over {} ticks each, measured alternately",
      r.with_history.p50_us, r.with_history.p99_us, r.without.p50_us, r.without.p99_us,
      r.with_history.p50_us - r.without.p50_us, r.with_history.p99_us - r.without.p99_us, r.with_history.count);
}

TextTable MakeUndoTable(const UndoReport& r) {
  TextTable table({"cuts", "leaves", "stored: MB (uncompressed)", "undo, p50 / max ms", "preparation, ms",
                   "ticks: number, p50 / max us", "redo, p50 / max ms", "bone: before, cut, undone"});
  for (const UndoResult& u : r.results) {
    table.Add({u.cuts, u.leaves, fmt::format("{:.1f} ({:.1f})", u.kept_MB, u.raw_MB),
               fmt::format("{:.1f} / {:.1f}", u.undo.all_p50_ms, u.undo.all_max_ms),
               fmt::format("{:.1f} / {:.1f}", u.undo.prepare_p50_ms, u.undo.prepare_max_ms),
               fmt::format("{}: {:.0f} / {:.0f}", u.undo.ticks, u.undo.tick_p50_us, u.undo.tick_max_us),
               fmt::format("{:.1f} / {:.1f}", u.redo.all_p50_ms, u.redo.all_max_ms),
               fmt::format("`{:016x}`, `{:016x}`, `{:016x}`", u.before, u.cut, u.undone)});
  }
  return table;
}

std::string DescribeUndo(const UndoReport& r) {
  return fmt::format(
      "\nDefault mandible at {:g} mm, a disc of 22 x 0.25 mm moving up through its left body; all cuts undone at once, "
      "{} times, {} leaves per tick. {}. The history takes {:.1f} MB. {}.\n",
      r.options.voxel_mm, r.options.rounds, r.options.leaves_per_tick, FormatHistory(r), r.history_MB,
      DescribeRun(r.run));
}

}  // namespace

std::string FormatUndoTable(const UndoReport& r) {
  return MakeUndoTable(r).FormatTerminal() + DescribeUndo(r);
}

std::string FormatUndoMarkdown(const UndoReport& r) {
  return MakeUndoTable(r).FormatMarkdown() + DescribeUndo(r);
}

std::string FormatUndoJson(const UndoReport& r) {
  nlohmann::ordered_json json = RunJson(r.run);
  json["voxel_mm"] = r.options.voxel_mm;
  json["leaves_per_tick"] = r.options.leaves_per_tick;
  json["rounds"] = r.options.rounds;
  json["cpu"] = r.run.cpu;
  json["load"] = RoundedJson(r.run.load);
  for (const UndoResult& u : r.results) {
    json["cuts"].push_back({{"cuts", u.cuts},
                            {"leaves", u.leaves},
                            {"kept_MB", RoundedJson(u.kept_MB)},
                            {"raw_MB", RoundedJson(u.raw_MB)},
                            {"undo", UndoTimesJson(u.undo)},
                            {"redo", UndoTimesJson(u.redo)},
                            {"hash_before", fmt::format("{:016x}", u.before)},
                            {"hash_cut", fmt::format("{:016x}", u.cut)},
                            {"hash_undone", fmt::format("{:016x}", u.undone)},
                            {"hash_redone", fmt::format("{:016x}", u.redone)}});
  }
  json["tick_with_history"] = TimesJson(r.with_history);
  json["tick_without"] = TimesJson(r.without);
  json["history_MB"] = RoundedJson(r.history_MB);
  return DumpJson(json);
}

}  // namespace kerf
