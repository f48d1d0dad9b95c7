// Readable forms of the history: table, JSON, CSV, and the teacher's page.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "base/files/html_text.h"
#include "base/table/table_json.h"
#include "session/practise/exercises.h"
#include "session/practise/history.h"
#include "session/practise/history_check.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

/// Formats the total; "-" for an attempt without a valid one, such as a damaged row.
std::string Total(const Attempt& a) {
  return a.graded() ? fmt::format("{:.1f}", *a.total) : std::string("-");
}

std::string Marks(const Attempt& a) {
  return fmt::format("{}", fmt::join(FindMarks(a), "; "));
}

/// Colours of the curves, distinguishable with colour blindness (Okabe and Ito) and also by their dashes.
constexpr std::array<const char*, 6> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00"};
constexpr std::array<const char*, 6> kDashes{"", "6 3", "2 3", "8 3 2 3", "10 4", "4 2"};

/// Draws one student's totals against the number of the attempt, one curve per exercise.
std::string DrawCurves(const std::map<std::string, std::vector<const Attempt*>>& by_exercise) {
  constexpr double kWidth = 620, kLeft = 50, kTop = 14, kRight = 250, kBottom = 44, kLegend = 18;
  const double height = std::max(260.0, kTop + kLegend * static_cast<double>(by_exercise.size()) + 10);
  std::size_t max_attempts = 2;
  for (const auto& [exercise, attempts] : by_exercise) max_attempts = std::max(max_attempts, attempts.size());
  const double w = kWidth - kLeft - kRight;
  const double h = 260 - kTop - kBottom;
  const auto x = [&](std::size_t i) {
    return kLeft + w * static_cast<double>(i) / static_cast<double>(max_attempts - 1);
  };
  const auto y = [&](double total) { return kTop + h * (1 - total / 100); };
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" role=\"img\" aria-label=\"total by attempt\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n",
      kWidth, height, kWidth, height);
  for (int total = 0; total <= 100; total += 25) {
    svg += fmt::format("<line x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\" stroke=\"#ddd\"/>", kLeft, y(total),
                       kLeft + w, y(total));
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kLeft - 6, y(total) + 4, total);
  }
  const std::size_t every = std::max<std::size_t>(1, (max_attempts + 7) / 8);
  for (std::size_t i = 0; i < max_attempts; i += every) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", x(i), kTop + h + 16, i + 1);
  }
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">attempt (number)</text>\n", kLeft + w / 2,
                     kTop + h + 36);
  svg += fmt::format(
      "<text x=\"14\" y=\"{0}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {0})\">total (points out of 100)"
      "</text>\n",
      kTop + h / 2);
  std::size_t n = 0;
  for (const auto& [exercise, attempts] : by_exercise) {
    const char* colour = kColours[n % kColours.size()];
    std::string points;
    for (std::size_t i = 0; i < attempts.size(); ++i) {
      if (!attempts[i]->graded()) continue;
      const double total = *attempts[i]->total;
      points += fmt::format("{:.1f},{:.1f} ", x(i), y(total));
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x(i), y(total), colour);
    }
    svg += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"{}\"/>\n", points,
        colour, kDashes[n % kDashes.size()]);
    const double at = kTop + 10 + kLegend * static_cast<double>(n);
    svg += fmt::format(
        "<line x1=\"{0}\" y1=\"{1}\" x2=\"{2}\" y2=\"{1}\" stroke=\"{3}\" stroke-width=\"2\" stroke-dasharray=\"{4}\"/>"
        "<text x=\"{5}\" y=\"{6}\">{7}</text>\n",
        kLeft + w + 14, at, kLeft + w + 44, colour, kDashes[n % kDashes.size()], kLeft + w + 50, at + 4,
        EscapeHtml(exercise));
    ++n;
  }
  return svg + "</svg>\n";
}

/// Measures shown in a row of the page's table next to the total.
constexpr std::array kShown{"cut_share",    "too_deep_mm",       "plunge_max_mm", "plane_offset_mm", "plane_angle_deg",
                            "force_peak_N", "nerve_distance_mm", "breaches",      "time_total_s"};

std::string SealCell(const Attempt& a, const std::vector<KnownKey>& known) {
  if (a.signer.empty()) return a.seal == "whole" ? "not signed" : EscapeHtml(a.seal);
  const auto owner = std::find_if(known.begin(), known.end(), [&](const KnownKey& k) { return k.key == a.signer; });
  return EscapeHtml(fmt::format("signed by {} ({})", ShortKey(a.signer),
                                owner == known.end() ? std::string("an unknown key") : owner->owner));
}

std::string PageRow(const Attempt& a, const std::string& exercise, const std::vector<KnownKey>& known) {
  const std::string marks = Marks(a);
  std::string html = fmt::format(
      "<tr{}><td>{}</td><td class=\"t\">{}</td><td class=\"t\">{}</td><td><b>{}</b></td><td class=\"t m\">{}</td>"
      "<td class=\"t\">{}</td>",
      marks.empty() ? "" : " class=\"m\"", a.number, EscapeHtml(exercise), EscapeHtml(a.taken), Total(a),
      EscapeHtml(marks), SealCell(a, known));
  for (const char* key : kShown) {
    const std::optional<double> value = a.Get(key);
    html += fmt::format("<td>{}</td>", value ? fmt::format("{:.3g}", *value) : std::string("-"));
  }
  return html + "</tr>\n";
}

}  // namespace

std::string FormatHistory(const std::vector<Attempt>& attempts) {
  TextTable table({"number", "student", "exercise", "level", "taken", "total", "marks"});
  for (const Attempt& a : attempts) table.Add({a.number, a.student, a.exercise, a.level, a.taken, Total(a), Marks(a)});
  return table.FormatTerminal();
}

std::string FormatHistoryJson(const std::vector<Attempt>& attempts) {
  ordered_json json = ordered_json::array();
  for (const Attempt& a : attempts) {
    ordered_json row{{"number", a.number}, {"student", a.student},     {"exercise", a.exercise}, {"level", a.level},
                     {"taken", a.taken},   {"recording", a.recording}, {"hash", a.hash},         {"total", nullptr}};
    if (a.graded()) row["total"] = *a.total;
    row["marks"] = FindMarks(a);
    row["damaged"] = a.damaged;
    row["recording_state"] = a.recording_state;
    row["incomplete"] = a.incomplete;
    row["doubles"] = a.duplicates;
    row["more_doubles"] = a.more_duplicates;
    row["seal"] = a.seal;
    row["signer"] = a.signer;
    row["measures"] = ParseMeasures(a);
    json.push_back(row);
  }
  return DumpJson(json);
}

const Columns<AttemptRow>& HistoryColumns() {
  static const Columns<AttemptRow> kColumns = [] {
    const auto field = [](auto Attempt::*value) {
      return [value](const AttemptRow& r) -> TableCell { return r.attempt.*value; };
    };
    Columns<AttemptRow> columns{
        {"number", "{}", "number of the attempt", field(&Attempt::number)},
        {"student", "{}", "name of the student", field(&Attempt::student)},
        {"exercise", "{}", "id of the exercise, or name of the scene; its level", field(&Attempt::exercise)},
        {"level", "{}", "id of the exercise, or name of the scene; its level", field(&Attempt::level)},
        {"taken", "{}", "time of the recording, UTC", field(&Attempt::taken)},
        {"recording", "{}", "file of the recording when it was handed in; hash of its bytes",
         field(&Attempt::recording)},
        {"hash", "{}", "file of the recording when it was handed in; hash of its bytes", field(&Attempt::hash)},
        {"total", "{:.4f}", "points out of 100; empty if the attempt is not graded",
         [](const AttemptRow& r) { return r.attempt.graded() ? TableCell(r.attempt.total) : TableCell(); }}};
    for (std::size_t i = 0; i < Measures().size(); ++i) {
      columns.push_back({Measures()[i].key, "{:.6g}", "[measures](practise.md) of the attempt",
                         [i](const AttemptRow& r) { return r.measures[i]; }});
    }
    columns.push_back(
        {"marks", "{}", "reasons to doubt the total", [](const AttemptRow& r) { return Marks(r.attempt); }});
    columns.push_back({"seal", "{}", "state of the recording's seal; its signer", field(&Attempt::seal)});
    columns.push_back({"signer", "{}", "state of the recording's seal; its signer", field(&Attempt::signer)});
    return columns;
  }();
  return kColumns;
}

std::string FormatHistoryCsv(const std::vector<Attempt>& attempts) {
  std::vector<AttemptRow> rows;
  for (const Attempt& a : attempts) {
    const ordered_json measures = ParseMeasures(a);
    AttemptRow& row = rows.emplace_back(AttemptRow{a, {}});
    for (const MeasureInfo& info : Measures()) row.measures.push_back(FindValue(measures, info.key));
  }
  return FormatCsv(HistoryColumns(), rows);
}

std::string FormatTeacherPage(const std::vector<Attempt>& attempts, const std::vector<KnownKey>& known) {
  std::map<std::string, std::map<std::string, std::vector<const Attempt*>>> by_student;
  std::size_t marked = 0;
  for (const Attempt& a : attempts) {
    by_student[a.student][fmt::format("{} (level {})", a.exercise, a.level)].push_back(&a);
    if (!FindMarks(a).empty()) ++marked;
  }
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>kerf: practise</title>\n<style>"
      "body{font:16px/1.4 sans-serif;max-width:72em;margin:2em auto;padding:0 1em;color:#222}"
      "table{border-collapse:collapse;font-size:14px}td,th{padding:.2em .6em;text-align:right;border-bottom:1px solid "
      "#ccc}td.t,th.t{text-align:left}.i{color:#666}tr.m td{background:#fff3cd}td.m{color:#a00000;font-weight:bold}"
      "</style></head><body>\n<h1>Practise</h1>\n";
  html +=
      fmt::format("<p>{} attempts by {} students. Total: points out of 100, by the formula in docs/practise.md.</p>\n",
                  attempts.size(), by_student.size());
  if (marked > 0) {
    html += fmt::format("<p><b>{} of them {} marked: check them before you use a total.</b></p>\n", marked,
                        marked == 1 ? "is" : "are");
  }
  for (const auto& [student, by_exercise] : by_student) {
    html += fmt::format("<h2>{}</h2>\n{}", EscapeHtml(student), DrawCurves(by_exercise));
    html +=
        "<table><tr><th>number</th><th class=\"t\">exercise</th><th class=\"t\">taken (UTC)</th><th>total</th>"
        "<th class=\"t\">marks</th><th class=\"t\">seal</th>";
    for (const char* key : kShown) {
      const MeasureInfo& info = FindMeasure(key);
      html += fmt::format("<th>{}{}</th>", info.name, info.unit[0] == '\0' ? "" : fmt::format(", {}", info.unit));
    }
    html += "</tr>\n";
    std::string unfinished;
    for (const auto& [exercise, exercise_attempts] : by_exercise) {
      for (const Attempt* a : exercise_attempts) (a->graded() ? html : unfinished) += PageRow(*a, exercise, known);
    }
    if (!unfinished.empty()) {
      html += fmt::format("<tr><th class=\"t\" colspan=\"{}\">without a score</th></tr>\n{}", 6 + kShown.size(),
                          unfinished);
    }
    html += "</table>\n";
  }
  return html + "</body></html>\n";
}

}  // namespace kerf
