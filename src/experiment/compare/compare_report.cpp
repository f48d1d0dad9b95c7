// The report of a comparison, in Markdown.
#include <fmt/format.h>

#include "base/core/append_format.h"
#include "base/files/markdown_text.h"
#include "base/table/table.h"
#include "experiment/compare/compare_files.h"
#include "experiment/compare/conclusion.h"
#include "kerf/version.h"

namespace kerf {
namespace {

/// Returns the headings, and then the labels of the cases.
std::vector<std::string> WithLabels(std::vector<std::string> headings, const Comparison& c) {
  for (const CaseResult& r : c.cases) headings.push_back(r.what.label);
  return headings;
}

std::string Signed(double value) {
  return (value > 0 ? "+" : "") + ShowFigure(value);
}

/// Describes the forces on the hand in slab mode other than cutting.
std::string DescribeSlab(const SlabParams& p) {
  std::string text = fmt::format("held by a spring of {:g} N/mm", p.coupling_N_per_mm);
  const double friction_N = 2 * p.friction_coefficient * p.normal_force_N;
  if (friction_N > 0) text += fmt::format(", friction of up to {} N on its two faces", ShowFigure(friction_N));
  if (p.stiffness_N_per_mm > 0)
    text += fmt::format(", a spring of {:g} N/mm to its initial position", p.stiffness_N_per_mm);
  if (p.damping_Ns_per_mm > 0) text += fmt::format(", a damper of {:g} N s/mm", p.damping_Ns_per_mm);
  if (friction_N > 0 || p.stiffness_N_per_mm > 0 || p.damping_Ns_per_mm > 0) {
    text += "; these are part of its force";
  }
  return text;
}

void AddSetting(std::string& text, const Comparison& c) {
  AppendFormat(text, "## What was compared\n\n");
  AppendFormat(
      text,
      "- Scene {}{}{}: disc {:g} x {:g} mm with {} teeth at {:g} rpm, moved at up to {:g} mm/s, {:g} ticks per "
      "second.\n",
      MarkdownCode(c.scene), c.title.empty() ? "" : ": ", c.title, c.saw.diameter_mm, c.saw.thickness_mm, c.saw.teeth,
      c.rpm, c.feed_mm_per_s, c.rate_hz);
  AppendFormat(text, "- Material: {}.\n", c.material);
  AppendFormat(text, "- Voxel mode: voxels of {:g} mm; the force on each tooth comes from the bone that it touches.\n",
               c.voxel_mm);
  AppendFormat(text,
               "- Slab mode: a slice {:.2f} mm long along [{:.4g}, {:.4g}, {:.4g}], with its layers from {}; {}.\n",
               c.profile.end_mm, c.direction_W.x, c.direction_W.y, c.direction_W.z,
               c.depth_by == "bone" ? "the bone itself" : "the paper's Table 2", DescribeSlab(c.slab));
  AppendFormat(
      text,
      "- Depth is the distance of the disc's leading rim (in slab mode of the blade's edge) below the first bone, "
      "along the cut. Force is the component of the force on the tool against the cut. Each point of the common depth "
      "axis is the mean over the ticks within {:g} mm in which the tool went deeper than before.\n",
      c.grid.step_mm);
  AppendFormat(
      text, "- Differences are relative to **{}**, over the slice's {} depths; % is of the reference's peak, {} N.\n\n",
      c.reference().what.label, c.slice_bins.size(), ShowFigure(c.reference().peak_N));
}

void AddForces(std::string& text, const Comparison& c) {
  AppendFormat(text, "## Force and work\n\n![Force against depth](force_depth.png)\n\n");
  TextTable table({"case", "mean (N)", "ratio", "ratio with the same law", "peak (N)", "at (mm)", "rms difference (N)",
                   "(%)", "peak difference (N)", "(%)", "at (mm)", "work (mJ)"});
  const double peak_N = c.reference().peak_N;
  const CaseResult* equal = FindEqualLaw(c);
  const auto ratio = [](double mean_N, double other_N) {
    return other_N > 0 ? ShowFigure(mean_N / other_N) : std::string();
  };
  for (const CaseResult& r : c.cases) {
    table.Add({r.what.label, ShowFigure(r.slice.mean_N), ratio(r.slice.mean_N, r.slice.reference_mean_N),
               r.what.slab && equal ? ratio(r.slice.mean_N, equal->slice.mean_N) : "", ShowFigure(r.peak_N),
               ShowFigure(r.peak_depth_mm), ShowFigure(r.slice.rms_N), ShowFigure(Percent(r.slice.rms_N, peak_N)),
               Signed(r.slice.peak_N), Signed(100 * r.slice.peak_N / (peak_N > 0 ? peak_N : 1)),
               ShowFigure(r.slice.peak_depth_mm), ShowFigure(r.work_mJ)});
  }
  TextTable between(WithLabels({""}, c));
  for (std::size_t a = 0; a < c.cases.size(); ++a) {
    std::vector<TableCell> row{c.cases[a].what.label};
    for (const double rms_N : c.rms_between_N[a]) row.emplace_back(ShowFigure(rms_N));
    between.Add(row);
  }
  AppendFormat(text,
               "{}\n![Force difference](difference.png)\n\n"
               "Rms difference between all pairs of cases, over the slice (N):\n\n{}\n",
               table.FormatMarkdown(), between.FormatMarkdown());
}

void AddStatements(std::string& text, const std::vector<std::string>& statements) {
  for (const std::string& statement : statements) AppendFormat(text, "- {}\n", statement);
  if (!statements.empty()) AppendFormat(text, "\n");
}

void AddRegions(std::string& text, const Comparison& c, const Conclusion& words) {
  AppendFormat(text, "## By region\n\n");
  AddStatements(text, words.regions);
  AppendFormat(text, "Mean force (N) / rms difference from the reference (N) over the depths of each region.\n\n");
  TextTable table(WithLabels({"region", "E (GPa)", "depths (mm)"}, c));
  const auto forces = [](const Difference& d) {
    return fmt::format("{} / {}", ShowFigure(d.mean_N), ShowFigure(d.rms_N));
  };
  for (std::size_t i = 0; i < c.regions.size(); ++i) {
    const CompareRegion& region = c.regions[i];
    const double length_mm = c.grid.step_mm * static_cast<double>(region.bins.size());
    const bool parted = length_mm < 0.98 * (region.bottom_mm - region.top_mm);
    std::vector<TableCell> row{fmt::format("{} {} ({})", region.id, region.name, region.tissue),
                               fmt::format("{:.4g}", region.E_MPa / 1000),
                               fmt::format("{:.2f} to {:.2f}{}", region.top_mm, region.bottom_mm,
                                           parted ? fmt::format(", {} in total", ShowFigure(length_mm)) : "")};
    for (const CaseResult& r : c.cases) row.emplace_back(forces(r.regions[i]));
    table.Add(row);
  }
  if (!c.beyond_bins.empty()) {
    std::vector<TableCell> row{"beyond the end of the slice", "",
                               fmt::format("{} to {}", ShowFigure(c.profile.end_mm),
                                           ShowFigure(c.grid.step_mm * static_cast<double>(c.grid.count)))};
    for (const CaseResult& r : c.cases) row.emplace_back(forces(r.beyond));
    table.Add(row);
  }
  text += table.FormatMarkdown();
  if (!c.beyond_bins.empty()) {
    AppendFormat(text, "\nDepths beyond the end of the slice are not included in any figure above.");
    for (const std::string& statement : words.beyond) AppendFormat(text, " {}", statement);
    AppendFormat(text, "\n");
  }
  AppendFormat(text, "\n");
}

std::string ShowAll(const std::vector<double>& values) {
  std::string all;
  for (const double value : values) all += (all.empty() ? "" : ", ") + ShowFigure(value);
  return all;
}

void AddCost(std::string& text, const Comparison& c, const std::vector<std::string>& words) {
  AppendFormat(text, "## Cost\n\n");
  AddStatements(text, words);
  AppendFormat(text, "![Time per tick against force difference](cost.png)\n\n");
  TextTable table({"case", "p50 (us)", "p99 (us)", "max (us)", "times faster than the reference",
                   "memory that a tick works on", "p50 of each repetition (us)", "p99 of each (us)"});
  for (const CaseResult& r : c.cases) {
    const double faster = r.times.p50_us > 0 ? c.reference().times.p50_us / r.times.p50_us : 0;
    table.Add({r.what.label, ShowFigure(r.times.p50_us), ShowFigure(r.times.p99_us), ShowFigure(r.times.max_us),
               ShowFigure(faster), ShowMemory(static_cast<double>(r.memory_bytes)), ShowAll(r.p50_us),
               ShowAll(r.p99_us)});
  }
  text += table.FormatMarkdown();
  AppendFormat(
      text,
      "\nEach case ran {} time{}, all cases in turn. The first three columns are from the repetition with the lowest "
      "p99, "
      "since other work on the machine can only increase it. They apply to this machine; ratios are more portable. The "
      "whole comparison used up to {:.0f} MB, including the generation of the bone and a copy of it for each run.\n\n",
      c.repetitions, c.repetitions == 1 ? "" : "s", c.peak_memory_MB);
}

void AddAgain(std::string& text, const Comparison& c) {
  AppendFormat(text, "## To reproduce\n\nIn the scene's folder:\n\n```\n{}\n```\n\n", MarkdownCodeLine(c.command));
  AppendFormat(text, "Generated by kerf {} (commit {}). Equal hashes mean bit-identical results{}.\n\n",
               VersionString(), CommitString(),
               c.repetitions > 1 ? "; each case gave the same hashes in all its repetitions" : "");
  TextTable table({"case", "force of every tick", "bone after the cut"});
  for (const CaseResult& r : c.cases) {
    table.Add({r.what.label, fmt::format("`{:016x}`", r.force_hash),
               r.bone_hash ? fmt::format("`{:016x}`", *r.bone_hash) : "not cut"});
  }
  text += table.FormatMarkdown();
}

}  // namespace

std::string FormatCompareReport(const Comparison& comparison) {
  Comparison c = comparison;
  c.title = EscapeMarkdown(c.title);
  c.material = EscapeMarkdown(c.material);
  for (CompareRegion& region : c.regions) region.name = EscapeMarkdown(region.name);
  for (std::string& warning : c.warnings) warning = EscapeMarkdown(warning);
  std::string text =
      fmt::format("# {}: the same cut in several ways\n\n", c.title.empty() ? EscapeMarkdown(c.scene) : c.title);
  AppendFormat(text, "Written by `kerf compare`. docs/compare.md of kerf explains each figure.\n\n");
  const Conclusion words = WriteConclusion(c);
  AppendFormat(text, "## Summary\n\n");
  AddStatements(text, words.force);
  if (!c.warnings.empty()) {
    AppendFormat(text, "Caveats:\n\n");
    for (const std::string& warning : c.warnings) AppendFormat(text, "- {}\n", warning);
    AppendFormat(text, "\n");
  }
  AddForces(text, c);
  AddRegions(text, c, words);
  AddCost(text, c, words.cost);
  AddSetting(text, c);
  AddAgain(text, c);
  return text;
}

}  // namespace kerf
