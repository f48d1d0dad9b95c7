// Measured costs of effects as text, JSON and Markdown.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/core/csv.h"
#include "base/files/markdown_text.h"
#include "base/table/table_json.h"
#include "effect_costs_csv.h"
#include "experiment/effect_costs/effect_costs.h"
#include "kerf/describe.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr double kMaxAsleep_us = 5;

double AddedP50(const EffectCost& c) {
  return c.with_it.cutting.p50_us - c.without_it.cutting.p50_us;
}
double AddedP99(const EffectCost& c) {
  return c.with_it.cutting.p99_us - c.without_it.cutting.p99_us;
}

/// Formats the time that an effect adds. A difference that is negative or below `kNoise_us` is noise.
constexpr double kNoise_us = 0.05;
std::string ShowAdded(double us) {
  return us < kNoise_us ? "0" : fmt::format("+{:.1f}", us);
}
std::string ShowAddedTimes(const EffectCost& c) {
  return fmt::format("{} / {}", ShowAdded(AddedP50(c)), ShowAdded(AddedP99(c)));
}
std::string ShowTimes(const TickCosts& t) {
  return fmt::format("{:.1f} / {:.1f}", t.cutting.p50_us, t.cutting.p99_us);
}
std::string SayAdded(double us) {
  return us < kNoise_us ? "below the noise" : fmt::format("+{:.1f} us", us);
}

std::string Memory(double MB) {
  return MB < 0.1 ? fmt::format("{:.1f} kB", 1000 * MB) : fmt::format("{:.2f} MB", MB);
}

std::string FormatValue(const EffectValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:g}", *number);
  if (const auto* on = std::get_if<bool>(&value)) return *on ? "true" : "false";
  if (const auto* v = std::get_if<Vec3>(&value)) return fmt::format("[{:g}, {:g}, {:g}]", v->x, v->y, v->z);
  return fmt::format("\"{}\"", std::get<std::string>(value));
}
ordered_json ValueJson(const EffectValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* on = std::get_if<bool>(&value)) return *on;
  if (const auto* v = std::get_if<Vec3>(&value)) return {v->x, v->y, v->z};
  return std::get<std::string>(value);
}

std::string FormatRange(const EffectParameter& p) {
  if (!p.words.empty()) return fmt::format("one of {}", fmt::join(p.words, ", "));
  if (p.file == EffectFileKind::kSurface) return "a closed surface (.stl, .ply, .obj), relative to the scene";
  if (p.file == EffectFileKind::kMarkups) return "a .mrk.json file of 3D Slicer, relative to the scene";
  std::string range = ShowRange({p.lower, p.upper}, UnitOfKey(p.key));
  if (p.default_value.index() == EffectValue(0.0).index()) return range;
  if (std::holds_alternative<Vec3>(p.default_value)) return "each " + range;
  return std::holds_alternative<bool>(p.default_value) ? "true or false" : "text";
}

std::string FormatNeeds(const EffectInfo& info) {
  std::string text = info.tool == EffectTool::kInHand ? "a tool coupled to a handle ('kerf loop')" : "";
  for (const char* needed : info.needs) text += fmt::format("{}the effect {}", text.empty() ? "" : ", ", needed);
  return text.empty() ? "nothing else" : text;
}

std::string DescribeMeasuredPart(const EffectCosts& c) {
  return fmt::format(
      "{:g} s of the cut starting at {:.2f} s, {:.1f} teeth engaged, the saw {}; {:g} mm voxels, "
      "{} pass{}",
      c.seconds, c.begin_s, c.mean_teeth,
      c.by_hand ? "coupled to a handle as in 'kerf loop'" : "following the path as in 'kerf run'", c.voxel_mm, c.passes,
      c.passes == 1 ? "" : "es");
}

/// Returns the rows of the table; the last one is "all".
std::vector<EffectCost> Rows(const EffectCosts& c) {
  std::vector<EffectCost> rows = c.effects;
  rows.push_back(c.together);
  return rows;
}

std::string DescribeFit(const EffectCosts& c) {
  const double p99_us = c.together.with_it.cutting.p99_us;
  return fmt::format(
      "{:.1f} kHz (1 / p99 of {:.1f} us; with the slower passes {:.1f} us); at {:g} Hz they take {:.1f} % of the time",
      c.fits_kHz(), p99_us, c.together.with_it.all.p99_us, c.rate_hz, 1e-4 * p99_us * c.rate_hz);
}

ordered_json SideJson(const TickCosts& t) {
  return {{"cutting", TimesJson(t.cutting)},
          {"cutting_all_passes", TimesJson(t.all)},
          {"ticks_left_out", t.disturbed},
          {"in_the_air", TimesJson(t.air)},
          {"in_the_air_after_the_cut", TimesJson(t.air_after)},
          {"bone_hash", fmt::format("{:016x}", t.bone_hash)},
          {"force_hash", fmt::format("{:016x}", t.force_hash)}};
}
ordered_json CostJson(const EffectCost& c) {
  ordered_json json = {{"name", c.name},
                       {"why", c.why},
                       {"with", c.with},
                       {"adds_p50_us", RoundedJson(AddedP50(c))},
                       {"adds_p99_us", RoundedJson(AddedP99(c))},
                       {"memory_MB", RoundedJson(c.memory_MB)},
                       {"only_observes", c.only_observes()}};
  json["with_it"] = SideJson(c.with_it);
  json["without_it"] = SideJson(c.without_it);
  return json;
}

}  // namespace

const Columns<EffectCost>& EffectCostColumns() {
  static const Columns<EffectCost> kColumns{
      {"effect", "{}", "name of the effect; `all`: all effects together", &EffectCost::name},
      {"p50_us", "{:.2f}", "time added to a tick in the cut: median, 99th percentile", AddedP50},
      {"p99_us", "{:.2f}", "time added to a tick in the cut: median, 99th percentile", AddedP99},
      {"air_us", "{:.2f}", "median of the whole tick in the air, the larger of before and after the cut",
       [](const EffectCost& c) { return std::max(c.with_it.air.p50_us, c.with_it.air_after.p50_us); }},
      {"memory_MB", "{:.4f}", "memory of the effect", &EffectCost::memory_MB}};
  return kColumns;
}

std::vector<StoredCost> StoredEffectCosts() {
  std::vector<StoredCost> stored;
  const std::vector<std::string> names = NamesOf(EffectCostColumns());
  ReadCsv(kEffectCostsCsv, "volumes/effect_costs.csv", names,
          [&](const std::vector<std::string>& fields, const CsvPlace& place) {
            const auto number = [&](std::size_t i) { return ParseCsvNumber(fields[i], 0, names[i].c_str(), place); };
            stored.push_back({fields[0], number(1), number(2), number(3), number(4)});
          });
  return stored;
}

std::string FormatStoredCosts(const EffectCosts& costs) {
  std::string csv =
      "# Cost of each effect, written by 'kerf effects'.\n"
      "# p50_us, p99_us: added to a tick in the cut; air_us: whole tick in the air, p50, the larger of before and "
      "after "
      "the cut.\n";
  std::string scene = costs.scene;
  // These characters would break the file's columns.
  std::replace_if(
      scene.begin(), scene.end(), [](char c) { return c < ' ' || c == ',' || c == '"'; }, ' ');
  csv += fmt::format("# {}: {}.\n# {}.\n", scene, DescribeMeasuredPart(costs), DescribeRun(costs.run));
  return csv + FormatCsv(EffectCostColumns(), Rows(costs));
}

namespace {

TextTable MakeCostTable(const EffectCosts& c) {
  TextTable table({"effect", "tick without, p50 / p99 us", "with", "adds", "in the air, p50 us: before, after the cut",
                   "memory", "bone, forces"});
  for (const EffectCost& cost : Rows(c)) {
    const TickCosts& with = cost.with_it;
    table.Add({cost.name + (cost.with.empty() ? "" : fmt::format(" (with {})", fmt::join(cost.with, ", "))),
               ShowTimes(cost.without_it), ShowTimes(with), ShowAddedTimes(cost),
               fmt::format("{:.2f}, {:.2f}{}", with.air.p50_us, with.air_after.p50_us,
                           std::max(with.air.p50_us, with.air_after.p50_us) > kMaxAsleep_us ? " **above 5**" : ""),
               Memory(cost.memory_MB),
               cost.only_observes() ? "as without, bit for bit"
                                    : fmt::format("`{:016x}`, `{:016x}`", with.bone_hash, with.force_hash)});
  }
  return table;
}

}  // namespace

std::string FormatEffectCosts(const EffectCosts& c) {
  std::string text = fmt::format("{}\n  measured  {}\n            {}\n", c.title.empty() ? c.scene : c.title,
                                 DescribeMeasuredPart(c), DescribeRun(c.run));
  const TickCosts& with = c.together.with_it;
  if (with.disturbed > 0) {
    text += fmt::format("            other programs took the core in {} of {} ticks\n", with.disturbed,
                        with.disturbed + with.all.count);
  }
  text += fmt::format("\n{}  (adds 0: below the noise of the measurement)\n\n  rate      up to {}\n",
                      MakeCostTable(c).FormatTerminal("  "), DescribeFit(c));
  text += fmt::format("  memory    effects {}, {} {}, bone {:.0f} MB\n", Memory(c.together.memory_MB),
                      c.by_hand ? "whole simulation" : "all effects", Memory(c.simulation_MB), c.bone_MB);
  for (const EffectCost& cost : c.effects) text += fmt::format("  enabled   {}: {}\n", cost.name, cost.why);
  for (const EffectLeftOut& left_out : c.left_out)
    text += fmt::format("  left out  {}: {}\n", left_out.name, left_out.why);
  return text;
}

std::string FormatEffectCostsMarkdown(const EffectCosts& c) {
  std::string text = MakeCostTable(c).FormatMarkdown();
  text +=
      fmt::format("\n{}: {}. {}. All effects together allow up to {}. Adds 0: below the noise of the measurement.\n",
                  MarkdownCode(c.scene), DescribeMeasuredPart(c), DescribeRun(c.run), DescribeFit(c));
  for (const EffectLeftOut& left_out : c.left_out)
    text += fmt::format("\nLeft out: {}: {}.\n", left_out.name, EscapeMarkdown(left_out.why));
  return text;
}

std::string FormatEffectCostsJson(const EffectCosts& c) {
  ordered_json json = RunJson(c.run);
  json["scene"] = c.scene;
  json["as"] = c.by_hand ? "kerf loop" : "kerf run";
  json["voxel_mm"] = c.voxel_mm;
  json["rate_hz"] = RoundedJson(c.rate_hz);
  json["begin_s"] = RoundedJson(c.begin_s);
  json["seconds"] = RoundedJson(c.seconds);
  json["passes"] = c.passes;
  json["mean_engaged_teeth"] = RoundedJson(c.mean_teeth);
  json["on"] = ordered_json::array();
  for (const EffectCost& cost : c.effects) json["on"].push_back(CostJson(cost));
  json["together"] = CostJson(c.together);
  json["together"].erase("why");
  json["together"].erase("with");
  json["fits_kHz"] = RoundedJson(c.fits_kHz());
  json["simulation_MB"] = RoundedJson(c.simulation_MB);
  json["bone_MB"] = RoundedJson(c.bone_MB);
  json["left_out"] = ordered_json::array();
  for (const EffectLeftOut& left_out : c.left_out) {
    json["left_out"].push_back({{"name", left_out.name}, {"why", left_out.why}});
  }
  return DumpJson(json);
}

std::string FormatEffectList(const EffectInfo* only) {
  const std::vector<StoredCost> stored = StoredEffectCosts();
  std::string text;
  if (only == nullptr) {
    text =
        "Effects: only those that a scene names as [effects.NAME] are simulated. In the order in which a tick calls "
        "them:\n";
  }
  for (const EffectInfo* info : Effects()) {
    if (only != nullptr && info != only) continue;
    text += fmt::format("\n{}\n  {}\n", info->name, info->summary);
    text += fmt::format("  source    {}\n", info->source);
    text += fmt::format("  needs     {}\n", FormatNeeds(*info));
    text += fmt::format("  sleeps    {}\n", info->sleeps);
    std::string cost = "not measured yet";
    for (const StoredCost& k : stored) {
      if (k.name != info->name) continue;
      cost = fmt::format("a tick in the cut: {}, p99 {}; in the air: {:.2f} us for the whole tick; {}",
                         SayAdded(k.p50_us), SayAdded(k.p99_us), k.air_us, Memory(k.memory_MB));
    }
    text += fmt::format("  cost      {}\n", cost);
    for (const EffectParameter& p : info->parameters) {
      text += fmt::format("  {:<28} {:<12} {}; {}\n", p.key, FormatValue(p.default_value), FormatRange(p), p.meaning);
    }
    for (const EffectChannel& channel : info->channels) {
      text += fmt::format("  gives {:<22} {}\n", channel.name, channel.meaning);
    }
  }
  text +=
      "\nThe costs were measured on the generic mandible's osteotomy by tools/effects_table; 'kerf effects SCENE' "
      "measures your own scene on this machine.\n";
  return text;
}

std::string FormatEffectListJson(const EffectInfo* only) {
  const std::vector<StoredCost> stored = StoredEffectCosts();
  ordered_json json = ordered_json::array();
  for (const EffectInfo* info : Effects()) {
    if (only != nullptr && info != only) continue;
    ordered_json row = {{"name", info->name},     {"summary", info->summary}, {"source", info->source},
                        {"reads", info->reads},   {"writes", info->writes},   {"state", info->state},
                        {"sleeps", info->sleeps}, {"needs", info->needs}};
    row["needs_hand"] = info->tool == EffectTool::kInHand;
    row["parameters"] = ordered_json::array();
    for (const EffectParameter& p : info->parameters) {
      ordered_json parameter = {{"key", p.key}, {"default", ValueJson(p.default_value)}, {"meaning", p.meaning}};
      if (std::holds_alternative<double>(p.default_value) || std::holds_alternative<Vec3>(p.default_value)) {
        parameter["range"] = {p.lower, p.upper};
      }
      if (const std::string_view unit = UnitOfKey(p.key); !unit.empty()) parameter["unit"] = unit;
      if (!p.words.empty()) parameter["words"] = p.words;
      row["parameters"].push_back(parameter);
    }
    row["channels"] = ordered_json::array();
    for (const EffectChannel& channel : info->channels) {
      row["channels"].push_back({{"name", channel.name}, {"meaning", channel.meaning}});
    }
    row["cost"] = nullptr;
    for (const StoredCost& k : stored) {
      if (k.name != info->name) continue;
      row["cost"] = {{"adds_p50_us", k.p50_us},
                     {"adds_p99_us", k.p99_us},
                     {"in_the_air_p50_us", k.air_us},
                     {"memory_MB", k.memory_MB}};
    }
    json.push_back(row);
  }
  return DumpJson({{"effects", json}});
}

}  // namespace kerf
