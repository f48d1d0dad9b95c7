#include "app/cli/paper_output.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace kerf::cli {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kSource =
    "M. Li et al., An Investigation of Haptic Modelling for Oral and Maxillofacial Surgical Training and Planning "
    "(HASP, University of Strathclyde)";

template <typename... T>
void Append(std::string& to, fmt::format_string<T...> format, T&&... values) {
  fmt::format_to(std::back_inserter(to), format, std::forward<T>(values)...);
}

// Breaks the text at spaces so that no line is longer than `width`, and indents each line by `indent` spaces.
std::string Wrap(std::string_view text, std::size_t indent, std::size_t width) {
  const std::string margin(indent, ' ');
  std::string lines;
  std::string line;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
      lines += margin + line + "\n";
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return lines + margin + line + "\n";
}

constexpr std::size_t kWidth = 110;

void AppendRegions(std::string& out, const PaperTables& tables) {
  Append(out, "Tables 1 and 2, and K of a = K F^(1/3)\n");
  Append(out, "  {:>6}  {:>7}  {:>5}  {:>10}  {:>11}   {:>21}  {:>9}   {:>9}\n", "", "", "", "depth (mm)", "band (mm)",
         "K (1e-5 m N^(-1/3))", "", "one tooth");
  Append(out, "  {:>6}  {:>7}  {:>5}  {:>10}  {:>11}   {:>10} {:>10}  {:>9}   {:>9}\n", "region", "E (GPa)", "nu",
         "printed", "(a reading)", "printed", "computed", "rel. diff", "(N)");
  for (const PaperRegionRow& row : tables.regions) {
    Append(out, "  {:>6}  {:>7.1f}  {:>5.2f}  {:>10.2f}  {:>11}   {:>10.2f} {:>10.4f}  {:>+9.1e}   {:>9.5f}\n",
           row.region, row.E_GPa, row.nu, row.depth_mm.printed,
           fmt::format("{} - {}", row.band_top_mm, row.band_bottom_mm), 1e5 * row.K_m_per_cbrt_N.printed,
           1e5 * row.K_m_per_cbrt_N.computed, row.K_m_per_cbrt_N.relative_difference(), row.tooth_force_N);
  }
  Append(out, "  The paper prints only the K of region 24; each force follows from the K of its own region.\n");
}

void AppendArcs(std::string& out, const PaperTables& tables) {
  Append(out, "\nTables 3 to 6: arcs and engaged teeth\n");
  Append(out, "  {:>10}   {:>22}  {:>9}   {:>16}   {:>19}\n", "", "arc (mm)", "", "teeth", "corrected");
  Append(out, "  {:>10}   {:>11}{:>11}  {:>9}   {:>7}{:>9}   {:>10}{:>9}\n", "depth (mm)", "printed", "computed",
         "rel. diff", "printed", "computed", "arc (mm)", "teeth");
  for (const PaperDepthRow& row : tables.depths) {
    Append(out, "  {:>10.1f}   {:>11}{:>11.4f}  {:>+9.1e}   {:>7}{:>9}   {:>10.4f}{:>9.3f}\n", row.depth_mm,
           row.arc_mm.printed, row.arc_mm.computed, row.arc_mm.relative_difference(), row.teeth.printed,
           row.teeth.computed, row.true_arc_mm, row.true_teeth);
  }
}

void AppendForces(std::string& out, const PaperTables& tables) {
  Append(out, "\nTables 3 to 6: forces (N), and corrected: true arc, forces summed over the teeth\n");
  Append(out, "  {:>6}  {:>10}   {:>9}{:>10}  {:>9}   {:>10}  {:>11}\n", "", "", "", "", "", "corrected", "corrected,");
  Append(out, "  {:>6}  {:>10}   {:>9}{:>10}  {:>9}   {:>10}  {:>11}\n", "region", "depth (mm)", "printed", "computed",
         "rel. diff", "", "whole teeth");
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) {
    for (const PaperDepthRow& row : tables.depths) {
      Append(out, "  {:>6}  {:>10.1f}   {:>9.5f}{:>10.5f}  {:>+9.1e}   {:>10.5f}  {:>7.5f} ({:.0f})\n",
             tables.regions[i].region, row.depth_mm, row.force_N[i].printed, row.force_N[i].computed,
             row.force_N[i].relative_difference(), row.corrected_N[i], row.corrected_whole_teeth_N[i],
             row.true_whole_teeth);
    }
  }
}

std::string DescribeDevice(const PaperTables& tables) {
  const PaperDeviceAdvice& device = tables.device;
  return fmt::format(
      "The paper requires a haptic device of at least {:.0f} N. With the disc in the bone to its full diameter, the "
      "paper's arc engages {:.0f} teeth; in region {} they exert {:.5f} x {:.0f}^3 = {:.1f} N from the printed force "
      "of one tooth, {:.1f} N computed. Corrected, {:.0f} teeth are engaged and exert {:.3f} N.",
      device.printed_at_least_N, device.teeth, device.region, tables.depths[0].force_N[0].printed, device.teeth,
      device.from_printed_force_N, device.computed_N, device.corrected_teeth, device.corrected_N);
}

ordered_json MakeCell(const PaperCell& cell, const char* unit) {
  return {{fmt::format("printed{}", unit), cell.printed},
          {fmt::format("computed{}", unit), cell.computed},
          {"relative_difference", cell.relative_difference()},
          {"within_rounding", cell.within_rounding()}};
}

}  // namespace

std::string FormatPaperText(const PaperTables& tables) {
  const DiscSaw& saw = tables.saw;
  std::string out = "The paper's Tables 1 to 6, printed against computed\n";
  out += Wrap(kSource, 2, kWidth);
  Append(
      out,
      "  disc {} mm, {} teeth, pitch {:.4f} mm; steel {} GPa, nu {}; contact radius {:.7f} mm, {} % of the pitch\n\n",
      saw.diameter_mm, saw.teeth, saw.pitch_mm(), saw.E_MPa / 1000, saw.nu, tables.contact_radius_mm,
      100 * kPaperShareOfPitch);
  AppendRegions(out, tables);
  AppendArcs(out, tables);
  AppendForces(out, tables);
  out += "\n";
  out += Wrap(DescribeRemainder(tables), 2, kWidth);
  Append(out, "\nAt least {:.0f} N\n", tables.device.printed_at_least_N);
  out += Wrap(DescribeDevice(tables), 2, kWidth);
  out += "\nWhere the paper's text and its tables disagree\n";
  int number = 1;
  for (const PaperDiscrepancy& one : MakePaperDiscrepancies(tables)) {
    Append(out, "  {}. {}\n", number++, one.title);
    out += Wrap("Text: " + one.text, 5, kWidth);
    out += Wrap("Tables: " + one.tables, 5, kWidth);
    out += Wrap("How we know: " + one.how, 5, kWidth);
  }
  return out;
}

std::string FormatPaperJson(const PaperTables& tables) {
  const DiscSaw& saw = tables.saw;
  ordered_json json;
  json["source"] = kSource;
  json["saw"] = {{"diameter_mm", saw.diameter_mm},
                 {"teeth", saw.teeth},
                 {"pitch_mm", saw.pitch_mm()},
                 {"E_GPa", saw.E_MPa / 1000},
                 {"nu", saw.nu},
                 {"contact_share_of_pitch", kPaperShareOfPitch},
                 {"contact_radius_mm", tables.contact_radius_mm}};
  json["regions"] = ordered_json::array();
  for (const PaperRegionRow& row : tables.regions) {
    json["regions"].push_back({{"region", row.region},
                               {"E_GPa", row.E_GPa},
                               {"nu", row.nu},
                               {"depth_mm", row.depth_mm.printed},
                               {"band_top_mm", row.band_top_mm},
                               {"band_bottom_mm", row.band_bottom_mm},
                               {"K", MakeCell(row.K_m_per_cbrt_N, "_m_per_cbrt_N")},
                               {"tooth_force_N", row.tooth_force_N}});
  }
  json["depths"] = ordered_json::array();
  for (const PaperDepthRow& row : tables.depths) {
    json["depths"].push_back({{"depth_mm", row.depth_mm},
                              {"arc", MakeCell(row.arc_mm, "_mm")},
                              {"teeth", MakeCell(row.teeth, "")},
                              {"corrected_arc_mm", row.true_arc_mm},
                              {"corrected_teeth", row.true_teeth},
                              {"corrected_whole_teeth", row.true_whole_teeth}});
  }
  json["forces"] = ordered_json::array();
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) {
    for (const PaperDepthRow& row : tables.depths) {
      ordered_json force = {{"region", tables.regions[i].region}, {"depth_mm", row.depth_mm}};
      force.update(MakeCell(row.force_N[i], "_N"));
      force["corrected_N"] = row.corrected_N[i];
      force["corrected_whole_teeth_N"] = row.corrected_whole_teeth_N[i];
      json["forces"].push_back(force);
    }
  }
  const PaperDifferences& largest = tables.largest;
  json["largest_relative_difference"] = {{"force", largest.force},
                                         {"force_by_rounding", largest.force_by_rounding},
                                         {"arc", largest.arc},
                                         {"K_region_24", largest.K_region_24},
                                         {"K_all_regions", largest.K}};
  json["teeth_counts_that_differ"] = largest.teeth_that_differ;
  json["forces_within_rounding"] = largest.forces_within_rounding;
  const PaperDeviceAdvice& device = tables.device;
  json["device_advice"] = {{"printed_at_least_N", device.printed_at_least_N},
                           {"region", device.region},
                           {"teeth", device.teeth},
                           {"from_printed_force_N", device.from_printed_force_N},
                           {"computed_N", device.computed_N},
                           {"corrected_teeth", device.corrected_teeth},
                           {"corrected_N", device.corrected_N}};
  json["discrepancies"] = ordered_json::array();
  for (const PaperDiscrepancy& one : MakePaperDiscrepancies(tables)) {
    json["discrepancies"].push_back(
        {{"id", one.id}, {"title", one.title}, {"text", one.text}, {"tables", one.tables}, {"how_we_know", one.how}});
  }
  return json.dump(2) + "\n";
}

std::string FormatPaperCsv(const PaperTables& tables) {
  std::string out =
      "region,E_GPa,nu,depth_mm,arc_printed_mm,arc_computed_mm,teeth_printed,teeth_computed,K_printed_m_per_cbrt_N,"
      "K_computed_m_per_cbrt_N,force_printed_N,force_computed_N,force_relative_difference,corrected_arc_mm,"
      "corrected_teeth,corrected_force_N,corrected_whole_teeth,corrected_whole_teeth_force_N\n";
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) {
    const PaperRegionRow& region = tables.regions[i];
    for (const PaperDepthRow& row : tables.depths) {
      Append(out, "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", region.region, region.E_GPa, region.nu,
             row.depth_mm, row.arc_mm.printed, row.arc_mm.computed, row.teeth.printed, row.teeth.computed,
             region.K_m_per_cbrt_N.printed, region.K_m_per_cbrt_N.computed, row.force_N[i].printed,
             row.force_N[i].computed, row.force_N[i].relative_difference(), row.true_arc_mm, row.true_teeth,
             row.corrected_N[i], row.true_whole_teeth, row.corrected_whole_teeth_N[i]);
    }
  }
  return out;
}

std::string FormatPaperMarkdown(const PaperTables& tables) {
  std::string out = "| depth (mm) | arc (mm) | teeth |";
  for (const PaperRegionRow& region : tables.regions) Append(out, " {} (N) |", region.region);
  Append(out, " corrected: arc, teeth, {} (N) |\n|---|---|---|", tables.regions[0].region);
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) out += "---|";
  out += "---|\n";
  for (const PaperDepthRow& row : tables.depths) {
    Append(out, "| {} | {} / {:.4f} | {} / {} |", row.depth_mm, row.arc_mm.printed, row.arc_mm.computed,
           row.teeth.printed, row.teeth.computed);
    for (const PaperCell& force : row.force_N) Append(out, " {:.5f} / {:.5f} |", force.printed, force.computed);
    Append(out, " {:.4f}, {:.2f}, {:.4f} |\n", row.true_arc_mm, row.true_teeth, row.corrected_N[0]);
  }
  out += "| K (1e-5 m N^(-1/3)) | | |";
  for (const PaperRegionRow& region : tables.regions) {
    Append(out, " {:.2f} / {:.4f} |", 1e5 * region.K_m_per_cbrt_N.printed, 1e5 * region.K_m_per_cbrt_N.computed);
  }
  out += " |\n";
  const PaperDifferences& largest = tables.largest;
  Append(out,
         "\nprinted / computed. Largest relative difference: force {:.1e} (up to {:.1e} due to the rounding of "
         "printed values), arc {:.1e}, K of region {} {:.1e}; teeth counts that differ: {}.\n",
         largest.force, largest.force_by_rounding, largest.arc, tables.regions[0].region, largest.K_region_24,
         largest.teeth_that_differ);
  return out;
}

}  // namespace kerf::cli
