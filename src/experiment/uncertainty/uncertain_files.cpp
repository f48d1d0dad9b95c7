#include "experiment/uncertainty/uncertain_files.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/core/append_format.h"
#include "base/core/number_text.h"
#include "base/files/files.h"
#include "base/files/markdown_text.h"
#include "base/table/table_json.h"
#include "kerf/version.h"
#include "session/run/run_scene.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr const char* kUncertainFiles[] = {"band.csv", "band.png", "report.md", "uncertain.json"};

/// What the percentiles rest on; printed in the JSON and the report.
constexpr const char* kAssumptions[] = {
    "Each quantity is uniform within its interval, and the quantities are independent of each other",
    "Estimated regions of one tissue share one fraction of their intervals, because they rest on the same few sources "
    "(the cortical ones on the four measured regions): their errors are taken to have the same sign",
    "The form of the law, the shape of the bone, Poisson's ratios and the effects are taken as exact: the band is not "
    "an interval for the force on a real bone"};

ordered_json SpreadJson(const Spread& s) {
  return {{"p5", RoundedJson(s.p5)},
          {"p50", RoundedJson(s.p50)},
          {"p95", RoundedJson(s.p95)},
          {"nominal", RoundedJson(s.nominal)}};
}

std::string TitleOf(const UncertainHead& head) {
  return head.title.empty() ? head.scene : head.title;
}

std::string ShowInterval(const DrawnQuantity& q) {
  return fmt::format("{:g} to {:g}", q.lower, q.upper);
}

std::string ShowCorrelation(const std::optional<double>& rank_correlation, std::size_t samples) {
  if (!rank_correlation) return "no effect";
  if (std::abs(*rank_correlation) < CalcChanceCorrelation(samples)) return "none discernible";
  return fmt::format("{:+.2f}", *rank_correlation);
}

TextTable MakeForceTable(const UncertainResult& r) {
  TextTable table({"", "5 %", "median", "95 %", "nominal"});
  const auto add = [&table](const char* name, const Spread& s) {
    table.Add({name, ShowThree(s.p5), ShowThree(s.p50), ShowThree(s.p95), ShowThree(s.nominal)});
  };
  add("peak force (N)", r.peak_N);
  add("mean force (N)", r.mean_N);
  add("work of the hand (mJ)", r.work_mJ);
  if (r.cutting_J) add("work of cutting (J)", *r.cutting_J);
  return table;
}

TextTable MakeQuantityTable(const UncertainRun& run, const UncertainResult& r) {
  TextTable table({"drawn", "interval", "nominal", "rank correlation", "basis of the interval"});
  const std::vector<DrawnQuantity>& drawn = run.head.drawing.drawn;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const DrawnQuantity& q = drawn[i];
    table.Add({q.name, ShowInterval(q), q.nominal ? fmt::format("{:g}", *q.nominal) : "differs by region",
               ShowCorrelation(r.rank_correlations[i], run.samples.size()), q.basis});
  }
  return table;
}

/// True if the figure shows the force against the travel of a single stroke.
bool IsSingleStroke(const UncertainResult& r) {
  return !r.rows.empty() && r.rows.front().segment == r.rows.back().segment && r.rows.back().travel_mm > 0;
}

/// The band between two curves, as a zigzag so dense that its line covers the area.
PlotSeries MakeArea(const std::vector<double>& x, const std::vector<double>& lower, const std::vector<double>& upper) {
  constexpr int kColumns = 1600;  // more than the figure has pixels
  PlotSeries area;
  area.label = "5 to 95 % of the runs";
  area.colour = Rgb8{190, 215, 235};
  std::size_t i = 0;
  for (int c = 0; c <= kColumns && x.size() > 1; ++c) {
    const double at = x.front() + (x.back() - x.front()) * c / kColumns;
    while (i + 2 < x.size() && x[i + 1] < at) ++i;
    const double t = x[i + 1] > x[i] ? std::min(1.0, (at - x[i]) / (x[i + 1] - x[i])) : 1;
    const double ends[] = {lower[i] + t * (lower[i + 1] - lower[i]), upper[i] + t * (upper[i + 1] - upper[i])};
    for (const int end : {c % 2, 1 - c % 2}) {
      area.x.push_back(at);
      area.y.push_back(ends[end]);
    }
  }
  return area;
}

}  // namespace

std::string FormatBandCsv(const UncertainResult& result) {
  return FormatCsv(BandColumns(), result.rows);
}

std::string FormatUncertainJson(const UncertainRun& run, const UncertainResult& result) {
  const UncertainHead& head = run.head;
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}};
  json["schema"] = 1;
  json["scene"] = head.scene;
  json["title"] = head.title;
  json["law"] = head.law;
  json["samples"] = run.samples.size();
  json["samples_requested"] = head.samples;
  json["seed"] = head.seed;
  json["row_ms"] = RoundedJson(1000 * head.row_ticks / head.rate_hz);
  json["parameters"] = ordered_json::array();
  for (std::size_t i = 0; i < head.drawing.drawn.size(); ++i) {
    const DrawnQuantity& q = head.drawing.drawn[i];
    const std::optional<double>& rho = result.rank_correlations[i];
    json["parameters"].push_back({{"name", q.name},
                                  {"lower", q.lower},
                                  {"upper", q.upper},
                                  {"nominal", OrNull(q.nominal)},
                                  {"basis", q.basis},
                                  {"regions", q.regions},
                                  {"rank_correlation", rho ? RoundedJson(*rho, 4) : ordered_json()}});
  }
  json["not_drawn"] = ordered_json::array();
  for (const FixedQuantity& q : head.drawing.fixed) json["not_drawn"].push_back({{"name", q.name}, {"why", q.why}});
  json["chance_correlation"] = RoundedJson(CalcChanceCorrelation(run.samples.size()), 4);
  json["peak_N"] = SpreadJson(result.peak_N);
  json["mean_N"] = SpreadJson(result.mean_N);
  json["work_mJ"] = SpreadJson(result.work_mJ);
  json["cutting_J"] = result.cutting_J ? SpreadJson(*result.cutting_J) : ordered_json();
  json["assumptions"] = kAssumptions;
  return DumpJson(json);
}

std::string FormatUncertainReport(const UncertainRun& run, const UncertainResult& result, bool has_figure) {
  const UncertainHead& head = run.head;
  std::string text;
  AppendFormat(text, "# {}: force with its uncertainty\n\n", EscapeMarkdown(TitleOf(head)));
  AppendFormat(text,
               "{} of {} runs of the scene {} with the law {}, seed {}. In each, the quantities below were drawn "
               "from their stated intervals.\n\n",
               run.samples.size(), head.samples, MarkdownCode(head.scene), MarkdownCode(head.law), head.seed);
  text += MakeForceTable(result).FormatMarkdown();
  if (has_figure) text += "\n![Force as a band](band.png)\n";
  AppendFormat(text, "\n## What was drawn\n\n{}\n", MakeQuantityTable(run, result).FormatMarkdown());
  AppendFormat(
      text,
      "Rank correlation: Spearman's, of the quantity with the mean force. With {} runs, 95 % of the correlations "
      "of quantities without any influence lie within +-{:.2f}; these are shown as \"none discernible\".\n",
      run.samples.size(), CalcChanceCorrelation(run.samples.size()));
  if (!head.drawing.fixed.empty()) {
    text += "\nNot drawn:\n\n";
    for (const FixedQuantity& q : head.drawing.fixed) AppendFormat(text, "- {}: {}.\n", MarkdownCode(q.name), q.why);
  }
  text += "\n## Assumptions\n\n";
  for (const char* assumption : kAssumptions) AppendFormat(text, "- {}.\n", assumption);
  AppendFormat(text, "\n`band.csv` contains the band, one row for at most {} ticks ({:g} ms). Made by kerf {} ({}).\n",
               head.row_ticks, 1000 * head.row_ticks / head.rate_hz, VersionString(), CommitString());
  return text;
}

PlotSpec MakeBandPlot(const UncertainRun& run, const UncertainResult& result) {
  const UncertainHead& head = run.head;
  const bool by_travel = IsSingleStroke(result);
  std::vector<double> x;
  std::vector<double> p5;
  std::vector<double> p50;
  std::vector<double> p95;
  std::vector<double> nominal;
  for (const BandRow& row : result.rows) {
    if (by_travel && row.travel_mm <= 0) continue;
    x.push_back(by_travel ? row.travel_mm : row.time_s);
    p5.push_back(row.force_N.p5);
    p50.push_back(row.force_N.p50);
    p95.push_back(row.force_N.p95);
    nominal.push_back(row.force_N.nominal);
  }
  PlotSpec plot;
  plot.title = fmt::format("{}: force on the tool with its uncertainty", TitleOf(head));
  plot.caption = fmt::format(
      "{} runs with {} drawn from stated intervals, law {}; each point is the mean over {:g} ms\n"
      "not an interval for the force on a real bone: the form of the law and the shape of the bone "
      "are taken as exact",
      run.samples.size(), FormatCount(head.drawing.drawn.size(), "quantity", "quantities"), head.law,
      1000 * head.row_ticks / head.rate_hz);
  plot.x.label = by_travel ? "travel of the tool since the first contact (mm)" : "time (s)";
  plot.y.label = "magnitude of the force on the tool (N)";
  plot.y.lower = 0;
  plot.series.push_back(MakeArea(x, p5, p95));
  plot.series.push_back({.label = "median of the runs", .x = x, .y = p50, .colour = Rgb8{0, 114, 178}, .width = 2.5});
  plot.series.push_back({.label = "nominal run, the scene's own values",
                         .x = x,
                         .y = nominal,
                         .colour = Rgb8{213, 94, 0},
                         .width = 2,
                         .dash = 6});
  return plot;
}

std::string DescribeUncertain(const UncertainRun& run, const UncertainResult& result) {
  const UncertainHead& head = run.head;
  std::string text = TitleOf(head) + "\n";
  AppendFormat(text, "  samples   {} of {}, seed {}; law {}\n", run.samples.size(), head.samples, head.seed, head.law);
  text += MakeForceTable(result).FormatTerminal("  ");
  TextTable drawn({"drawn", "interval", "rank correlation with the mean force"});
  for (std::size_t i = 0; i < head.drawing.drawn.size(); ++i) {
    const DrawnQuantity& q = head.drawing.drawn[i];
    drawn.Add({q.name, ShowInterval(q), ShowCorrelation(result.rank_correlations[i], run.samples.size())});
  }
  text += drawn.FormatTerminal("  ");
  text += "  The band is not an interval for the force on a real bone: the form of the law is taken as exact.\n";
  for (const FixedQuantity& q : head.drawing.fixed) AppendFormat(text, "  not drawn {}: {}\n", q.name, q.why);
  return text;
}

void CheckUncertainInputsNotOverwritten(const std::vector<std::string>& inputs, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kUncertainFiles) outputs.push_back(folder + "/" + name);
  CheckInputsNotOverwritten(inputs, outputs);
}

std::vector<std::string> WriteUncertain(const UncertainRun& run, const UncertainResult& result,
                                        const std::string& folder, bool pictures) {
  MakeFolder(folder);
  FileBatch results(folder, "uncertain.json");
  const std::string in = folder + "/";
  std::vector<std::string> files{"band.csv"};
  WriteTextFile(in + "band.csv", FormatBandCsv(result));
  if (pictures) {
    WritePlot(MakeBandPlot(run, result), in + "band.png");
    files.emplace_back("band.png");
  }
  WriteTextFile(in + "report.md", FormatUncertainReport(run, result, pictures));
  WriteTextFile(in + "uncertain.json", FormatUncertainJson(run, result));
  results.Commit();
  files.insert(files.end(), {"report.md", "uncertain.json"});
  return files;
}

}  // namespace kerf
