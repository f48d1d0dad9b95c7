#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "base/files/html_text.h"
#include "session/score/measures.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

std::string Number(double x) {
  return fmt::format("{:.4g}", x);
}

std::string Value(const MeasureRow& row) {
  return row.value ? Number(*row.value) : std::string("-");
}

/// Escapes bars, which would otherwise end a cell of a table.
std::string ForTable(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string DescribeExercise(const ScoreSheet& sheet) {
  if (!sheet.kind) return "no exercise: only measures that need no plan";
  return fmt::format("{}, level {}", kExerciseKindWords[static_cast<std::size_t>(*sheet.kind)], sheet.level);
}

}  // namespace

const char* DescribeChain(const RecordingSeal& seal) {
  if (!seal.is_chained) return "none";
  if (seal.is_whole) return "whole";
  return seal.is_broken ? "broken" : "not closed";
}

std::string FormatSheet(const ScoreSheet& sheet) {
  std::string text = fmt::format("{}\n", sheet.title.empty() ? sheet.scene : sheet.title);
  text += fmt::format("  exercise  {}\n", DescribeExercise(sheet));
  if (sheet.total) text += fmt::format("  total     {:.1f} out of 100\n", *sheet.total);
  for (const std::string& why : sheet.incomplete) text += fmt::format("  not graded: {}\n", why);
  text += fmt::format("\n  {:<50} {:>10} {:<8} {}\n", "measure", "value", "unit", sheet.total ? "points" : "");
  for (const MeasureRow& row : sheet.rows) {
    if (!row.value && row.weight == 0) continue;
    std::string points;
    if (row.points) points = fmt::format("{:.2f} x {:g}", *row.points, row.weight);
    text += fmt::format("  {:<50} {:>10} {:<8} {}\n", row.info->name, Value(row), row.info->unit, points);
  }
  if (sheet.total) {
    text += "\n  total = 100 x fraction of the wanted cut x weighted mean of the points; the rest is for information\n";
  }
  return text;
}

ordered_json SheetJson(const ScoreSheet& sheet) {
  ordered_json json{
      {"recording", sheet.recording}, {"scene", sheet.scene}, {"title", sheet.title}, {"created", sheet.created}};
  json["exercise"] = nullptr;
  if (sheet.kind) json["exercise"] = kExerciseKindWords[static_cast<std::size_t>(*sheet.kind)];
  json["level"] = sheet.level;
  json["total"] = nullptr;
  if (sheet.total) json["total"] = *sheet.total;
  json["complete"] = sheet.incomplete.empty();
  json["incomplete"] = sheet.incomplete;
  json["recording_state"] = ToString(sheet.state);
  json["seal"] = {{"chain", DescribeChain(sheet.seal)}, {"signer", sheet.seal.signer}};
  json["measures"] = ordered_json::object();
  for (const MeasureRow& row : sheet.rows) {
    ordered_json measure{{"name", row.info->name},
                         {"unit", row.info->unit},
                         {"value", nullptr},
                         {"scored", row.info->scored()},
                         {"weight", row.weight}};
    if (row.value) measure["value"] = *row.value;
    if (row.points) measure["points"] = *row.points;
    if (row.points) measure["half"] = row.half;
    json["measures"][row.info->key] = measure;
  }
  json["warnings"] = sheet.warnings;
  return json;
}

std::string FormatSheetJson(const ScoreSheet& sheet) {
  return SheetJson(sheet).dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string FormatSheetCsv(const ScoreSheet& sheet) {
  std::string csv = "key,name,unit,value,scored,weight,points\n";
  for (const MeasureRow& row : sheet.rows) {
    csv += fmt::format("{},\"{}\",{},{},{},{:g},{}\n", row.info->key, row.info->name, row.info->unit,
                       row.value ? fmt::format("{:.6g}", *row.value) : "", row.info->scored() ? 1 : 0, row.weight,
                       row.points ? fmt::format("{:.4f}", *row.points) : "");
  }
  if (sheet.total) csv += fmt::format("total,\"total\",,{:.4f},1,,\n", *sheet.total);
  csv += fmt::format("complete,\"complete, so that it is graded\",,{},0,,\n", sheet.incomplete.empty() ? 1 : 0);
  return csv;
}

std::string FormatSheetHtml(const ScoreSheet& sheet) {
  const std::string title = EscapeHtml(sheet.title.empty() ? sheet.scene : sheet.title);
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title>\n<style>body{{font:16px/1.4 "
      "sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}}table{{border-collapse:collapse}}"
      "td,th{{padding:.2em .8em;text-align:left;border-bottom:1px solid #ccc}}td.n{{text-align:right}}"
      ".total{{font-size:2em}}.i{{color:#666}}</style></head><body>\n<h1>{}</h1>\n",
      title, title);
  html += fmt::format("<p>{}; recorded {}; {}</p>\n", EscapeHtml(DescribeExercise(sheet)), EscapeHtml(sheet.created),
                      EscapeHtml(sheet.recording));
  if (sheet.total) html += fmt::format("<p class=\"total\">{:.1f} out of 100</p>\n", *sheet.total);
  for (const std::string& why : sheet.incomplete)
    html += fmt::format("<p><b>Not graded: {}</b></p>\n", EscapeHtml(why));
  for (const std::string& warning : sheet.warnings)
    html += fmt::format("<p><b>Note: {}</b></p>\n", EscapeHtml(warning));
  html += "<table><tr><th>measure</th><th>value</th><th>unit</th><th>points</th><th>formula</th></tr>\n";
  for (const MeasureRow& row : sheet.rows) {
    if (!row.value && row.weight == 0) continue;
    const std::string points = row.points ? fmt::format("{:.2f} x {:g}", *row.points, row.weight) : std::string();
    html += fmt::format("<tr{}><td>{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"i\">{}</td></tr>\n",
                        row.points ? "" : " class=\"i\"", row.info->name, Value(row), row.info->unit, points,
                        EscapeHtml(row.info->formula));
  }
  html +=
      "</table>\n<p class=\"i\">Only measures that publications show to distinguish novices from experts have points; "
      "the rest is for information.</p>\n</body></html>\n";
  return html;
}

std::string FormatMeasuresMarkdown() {
  std::string text = "| key | measure | unit | formula | evidence |\n|---|---|---|---|---|\n";
  for (const MeasureInfo& info : Measures()) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", info.key, info.name, info.unit, ForTable(info.formula),
                        info.scored() ? info.evidence : "information only");
  }
  return text;
}

}  // namespace kerf
