#include <fmt/format.h>

#include "experiment/bench/times_json.h"
#include "experiment/bench/undo_bench.h"

namespace kerf {
namespace {

std::string FormatUndoTimes(const UndoTimes& t, const char* format) {
  return fmt::format(fmt::runtime(format), t.all_p50_ms, t.all_max_ms, t.prepare_p50_ms, t.prepare_max_ms, t.ticks,
                     t.tick_p50_us, t.tick_max_us);
}

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

std::string FormatMachine(const UndoReport& r) {
  return fmt::format("{}, core {}{}; load {:.1f} before", r.machine.cpu, r.options.core,
                     r.options.realtime ? " with real-time priority" : "", r.machine.load);
}

}  // namespace

std::string FormatUndoTable(const UndoReport& r) {
  std::string text = fmt::format("Undo, default mandible at {:g} mm, {} leaves per tick\n", r.options.voxel_mm,
                                 r.options.leaves_per_tick);
  for (const UndoResult& u : r.results) {
    constexpr const char* kFormat =
        "{:.1f} ms, max {:.1f}: prepare {:.1f}, max {:.1f}; {} ticks of {:.0f} us, max {:.0f}";
    text +=
        fmt::format("  {} cut{}\n    stored  {} leaves, {:.1f} MB ({:.1f} MB uncompressed)\n    undo    {}\n", u.cuts,
                    u.cuts == 1 ? "" : "s", u.leaves, u.kept_MB, u.raw_MB, FormatUndoTimes(u.undo, kFormat));
    text += fmt::format("    redo    {}\n    bone    {:016x} before, {:016x} cut, {:016x} undone\n",
                        FormatUndoTimes(u.redo, kFormat), u.before, u.cut, u.undone);
  }
  text += fmt::format("  {}\n  {:.1f} MB of history\n  {}\n", FormatHistory(r), r.history_MB, FormatMachine(r));
  return text;
}

std::string FormatUndoMarkdown(const UndoReport& r) {
  std::string text =
      "| cuts | leaves | stored: MB (uncompressed) | undo, p50 / max ms | preparation, ms | ticks: number, p50 / max "
      "us | redo, "
      "p50 / max ms | bone: before, cut, undone |\n|---|---|---|---|---|---|---|---|\n";
  for (const UndoResult& u : r.results) {
    text += fmt::format(
        "| {} | {} | {:.1f} ({:.1f}) | {:.1f} / {:.1f} | {:.1f} / {:.1f} | {}: {:.0f} / {:.0f} | {:.1f} / {:.1f} | "
        "`{:016x}`, `{:016x}`, `{:016x}` |\n",
        u.cuts, u.leaves, u.kept_MB, u.raw_MB, u.undo.all_p50_ms, u.undo.all_max_ms, u.undo.prepare_p50_ms,
        u.undo.prepare_max_ms, u.undo.ticks, u.undo.tick_p50_us, u.undo.tick_max_us, u.redo.all_p50_ms,
        u.redo.all_max_ms, u.before, u.cut, u.undone);
  }
  text += fmt::format(
      "\nDefault mandible at {:g} mm, a disc of 22 x 0.25 mm moving up through its left body; all cuts undone at once, "
      "{} times. {}. "
      "The history takes {:.1f} MB. {}.\n",
      r.options.voxel_mm, r.options.rounds, FormatHistory(r), r.history_MB, FormatMachine(r));
  return text;
}

std::string FormatUndoJson(const UndoReport& r) {
  nlohmann::ordered_json json;
  json["voxel_mm"] = r.options.voxel_mm;
  json["leaves_per_tick"] = r.options.leaves_per_tick;
  json["rounds"] = r.options.rounds;
  json["cpu"] = r.machine.cpu;
  json["load"] = RoundedJson(r.machine.load);
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
  return json.dump(2) + "\n";
}

}  // namespace kerf
