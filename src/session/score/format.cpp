#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "base/files/html_text.h"
#include "base/table/table_json.h"
#include "session/score/measures.h"
#include "session/score/review.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

/// A smaller value is a residue of rounding: no measure is as accurate.
constexpr double kResidue = 1e-4;

std::string Number(double x) {
  return std::abs(x) < kResidue ? "0" : fmt::format("{:.4g}", x);
}

std::string Value(const MeasureRow& row) {
  return row.value ? Number(*row.value) : std::string("-");
}

std::string Points(const MeasureRow& row) {
  return row.points ? fmt::format("{:.2f} x {:g}", *row.points, row.weight) : std::string();
}

constexpr int kPageView_px = 900;

/// Returns a mark that shows the level without colour.
const char* MarkOf(ReviewLevel level) {
  switch (level) {
    case ReviewLevel::kGood:
      return "✓";
    case ReviewLevel::kWarn:
      return "!";
    case ReviewLevel::kBad:
      return "✗";
    case ReviewLevel::kPlain:
      break;
  }
  return "";
}

std::string FormatFigures(const std::vector<ReviewFigure>& figures) {
  std::string html = "<table>\n";
  for (const ReviewFigure& figure : figures) {
    const std::string goal = FormatGoal(figure);
    html +=
        fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"i\">{}</td></tr>\n",
                    figure.label, figure.value ? FormatQuantity(*figure.value) : std::string("-"), MarkOf(figure.level),
                    goal.empty() ? goal : "goal: " + goal, EscapeHtml(MeaningOf(*figure.info)));
  }
  return html + "</table>\n";
}

/// Returns the part of the page for the student: advice, figures and pictures.
std::string FormatReviewHtml(const ScoreSheet& sheet) {
  const ExerciseReview review = MakeReview(sheet);
  std::string html =
      fmt::format("<p><b>{}{}</b></p>\n", review.passed ? EscapeHtml(FormatMessage(*review.passed)) + " " : "",
                  EscapeHtml(FormatMessage(review.headline)));
  if (review.praise) html += fmt::format("<p>{}</p>\n", EscapeHtml(FormatMessage(*review.praise)));
  for (const Message& note : review.notes) html += fmt::format("<p>{}</p>\n", EscapeHtml(FormatMessage(note)));
  for (const Message& line : review.crossed) html += fmt::format("<p>{}</p>\n", EscapeHtml(FormatMessage(line)));
  if (review.nerve) html += fmt::format("<p>{}</p>\n", EscapeHtml(FormatMessage(*review.nerve)));
  html += FormatFigures(review.figures);
  if (!sheet.picture) return html;
  html += FormatCutViewSvg(sheet.picture->above, AboveTexts(), kPageView_px);
  return html + FormatCutViewSvg(sheet.picture->side, SideTexts(), kPageView_px);
}

/// Returns a table of the holes, with a line for each.
TextTable MakeHoleTable(const ScoreSheet& sheet) {
  TextTable table({"hole", "depth, mm", "beyond, mm", "offset, mm", "angle, degrees", "through"});
  for (std::size_t i = 0; i < sheet.holes.size(); ++i) {
    const std::optional<HoleResult>& hole = sheet.holes[i];
    const auto show = [&](double HoleResult::*value) { return hole ? Number((*hole).*value) : std::string("-"); };
    table.Add({fmt::format("{}", i + 1), show(&HoleResult::depth_mm), show(&HoleResult::beyond_mm),
               show(&HoleResult::offset_mm), show(&HoleResult::angle_deg), hole && hole->through ? "yes" : "no"});
  }
  return table;
}

ordered_json HoleJson(const std::optional<HoleResult>& hole) {
  if (!hole) return nullptr;
  return {{"depth_mm", hole->depth_mm},
          {"beyond_mm", hole->beyond_mm},
          {"offset_mm", hole->offset_mm},
          {"angle_deg", hole->angle_deg},
          {"through", hole->through}};
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
  TextTable table({"measure", "value", "unit", sheet.total ? "points" : ""});
  for (const MeasureRow& row : sheet.rows) {
    if (!row.value && row.weight == 0) continue;
    table.Add({row.info->name, Value(row), row.info->unit, Points(row)});
  }
  text += "\n" + table.FormatTerminal("  ");
  if (!sheet.holes.empty()) text += "\n" + MakeHoleTable(sheet).FormatTerminal("  ");
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
  json["total"] = OrNull(sheet.total);
  json["complete"] = sheet.incomplete.empty();
  json["incomplete"] = sheet.incomplete;
  json["recording_state"] = ToString(sheet.state);
  json["seal"] = {{"chain", DescribeChain(sheet.seal)}, {"signer", sheet.seal.signer}};
  json["measures"] = ordered_json::object();
  for (const MeasureRow& row : sheet.rows) {
    ordered_json measure{{"name", row.info->name},
                         {"unit", row.info->unit},
                         {"value", OrNull(row.value)},
                         {"scored", row.info->scored()},
                         {"weight", row.weight}};
    if (row.points) measure["points"] = *row.points;
    if (row.points) measure["half"] = row.half;
    if (row.points) measure["goal"] = row.goal;
    json["measures"][row.info->key] = measure;
  }
  if (!sheet.holes.empty()) json["holes"] = ordered_json::array();
  for (const std::optional<HoleResult>& hole : sheet.holes) json["holes"].push_back(HoleJson(hole));
  json["warnings"] = sheet.warnings;
  return json;
}

std::string FormatSheetJson(const ScoreSheet& sheet) {
  return DumpJson(SheetJson(sheet));
}

const Columns<SheetLine>& SheetColumns() {
  static const Columns<SheetLine> kColumns{
      {"key", "{}", "key of the measure; `total`; `complete`: whether the attempt is graded", &SheetLine::key},
      {"name", "\"{}\"", "name of the measure", &SheetLine::name},
      {"unit", "{}", "unit of its value", &SheetLine::unit},
      {"value", "{}", "value; empty if it could not be measured", &SheetLine::value},
      {"scored", "{}", "1 if the measure can have points, otherwise 0", &SheetLine::scored},
      {"weight", "{:g}", "weight in this exercise; 0: not scored", &SheetLine::weight},
      {"points", "{:.4f}", "0 to 1; empty if there are none", &SheetLine::points}};
  return kColumns;
}

std::string FormatSheetCsv(const ScoreSheet& sheet) {
  std::vector<SheetLine> lines;
  for (const MeasureRow& row : sheet.rows) {
    lines.push_back({row.info->key, row.info->name, row.info->unit, row.value ? fmt::format("{:.6g}", *row.value) : "",
                     row.info->scored() ? 1 : 0, row.weight, row.points});
  }
  if (sheet.total) lines.push_back({"total", "total", "", fmt::format("{:.4f}", *sheet.total), 1, {}, {}});
  lines.push_back({"complete", "complete, so that it is graded", "", sheet.incomplete.empty() ? "1" : "0", 0, {}, {}});
  return FormatCsv(SheetColumns(), lines);
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
  if (sheet.kind) html += FormatReviewHtml(sheet) + "<h2>All measures</h2>\n";
  html +=
      "<table><tr><th>measure</th><th>value</th><th>unit</th><th>points</th><th>meaning</th><th>formula</th></tr>\n";
  for (const MeasureRow& row : sheet.rows) {
    if (!row.value && row.weight == 0) continue;
    if (sheet.kind && !IsMeaningful(*row.info, *sheet.kind)) continue;
    html += fmt::format(
        "<tr{}><td>{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"i\">{}</td>"
        "<td class=\"i\">{}</td></tr>\n",
        row.points ? "" : " class=\"i\"", row.info->name, Value(row), row.info->unit, Points(row),
        EscapeHtml(MeaningOf(*row.info)), EscapeHtml(row.info->formula));
  }
  html +=
      "</table>\n<p class=\"i\">Only measures that publications show to distinguish novices from experts have points; "
      "the rest is for information.</p>\n</body></html>\n";
  return html;
}

std::string FormatMeasuresMarkdown() {
  TextTable table({"key", "measure", "unit", "meaning", "formula", "evidence"});
  for (const MeasureInfo& info : Measures()) {
    table.Add({fmt::format("`{}`", info.key), info.name, info.unit, EscapeBars(MeaningOf(info)),
               EscapeBars(info.formula), info.scored() ? info.evidence : "information only"});
  }
  return table.FormatMarkdown();
}

}  // namespace kerf
