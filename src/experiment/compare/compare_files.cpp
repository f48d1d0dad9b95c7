#include "experiment/compare/compare_files.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/table/table_json.h"
#include "experiment/compare/conclusion.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/run_scene.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFiles[] = {"report.md", "force_depth.png", "difference.png",
                                  "cost.png",  "compare.csv",     "compare.json"};

/// Rounds to seven significant digits, which is enough for the accuracy of the numbers and hides rounding noise.
ordered_json Number(double value) {
  return RoundedJson(value, 7);
}

ordered_json Numbers(const std::vector<double>& values) {
  ordered_json list = ordered_json::array();
  for (const double value : values) list.push_back(RoundedJson(value, 5));
  return list;
}

ordered_json DifferenceJson(const Difference& d, double peak_N) {
  const double per_cent = peak_N > 0 ? 100 / peak_N : 0;
  return {{"depths", d.bins},
          {"mean_N", Number(d.mean_N)},
          {"reference_mean_N", Number(d.reference_mean_N)},
          {"rms_difference_N", Number(d.rms_N)},
          {"rms_difference_percent", Number(per_cent * d.rms_N)},
          {"peak_difference_N", Number(d.peak_N)},
          {"peak_difference_percent", Number(per_cent * d.peak_N)},
          {"peak_difference_depth_mm", Number(d.peak_depth_mm)}};
}

ordered_json CaseJson(const CaseResult& r, const Comparison& c) {
  const double peak_N = c.reference().peak_N;
  ordered_json json = {{"id", r.what.id}, {"label", r.what.label}, {"mode", r.what.slab ? "slab" : "voxel"}};
  json["law"] = r.what.slab ? std::string(ToString(r.what.reading)) : std::string(r.what.law.name());
  if (!r.what.slab) {
    json["law_parameters"] = ordered_json::object();
    const auto& parameters = r.what.law.info().parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      json["law_parameters"][parameters[i].key] = r.what.law.values()[i];
    }
  }
  json["peak_N"] = Number(r.peak_N);
  json["peak_depth_mm"] = Number(r.peak_depth_mm);
  const auto ratio = [](double mean_N, double other_N) {
    return other_N > 0 ? Number(mean_N / other_N) : ordered_json(nullptr);
  };
  const CaseResult* equal = r.what.slab ? FindEqualLaw(c) : nullptr;
  json["mean_ratio"] = ratio(r.slice.mean_N, r.slice.reference_mean_N);
  json["mean_ratio_at_equal_law"] = equal ? ratio(r.slice.mean_N, equal->slice.mean_N) : ordered_json(nullptr);
  json["slice"] = DifferenceJson(r.slice, peak_N);
  json["regions"] = ordered_json::array();
  for (std::size_t k = 0; k < c.regions.size(); ++k) {
    ordered_json row = {{"region", c.regions[k].id}};
    row.update(DifferenceJson(r.regions[k], peak_N));
    json["regions"].push_back(row);
  }
  json["beyond"] = DifferenceJson(r.beyond, peak_N);
  json["work_mJ"] = Number(r.work_mJ);
  json["removed_mm3"] = r.what.slab ? ordered_json(nullptr) : Number(r.removed_mm3);
  json["ticks"] = {
      {"count", r.ticks},
      {"deeper_than_before", r.ticks_on_curve},
      {"interpolated_depths", r.curve.interpolated},
      {"p50_us", Number(r.times.p50_us)},
      {"p99_us", Number(r.times.p99_us)},
      {"max_us", Number(r.times.max_us)},
      {"p50_of_repetitions_us", Numbers(r.p50_us)},
      {"p99_of_repetitions_us", Numbers(r.p99_us)},
      {"times_faster_than_reference", Number(r.times.p50_us > 0 ? c.reference().times.p50_us / r.times.p50_us : 0)}};
  json["memory_bytes"] = r.memory_bytes;
  json["force_hash"] = fmt::format("{:016x}", r.force_hash);
  json["bone_hash"] = r.bone_hash ? ordered_json(fmt::format("{:016x}", *r.bone_hash)) : ordered_json(nullptr);
  json["force_N"] = Numbers(r.curve.force_N);
  json["magnitude_N"] = Numbers(r.curve.magnitude_N);
  json["thrust_sum_N"] = Numbers(r.curve.thrust_N);
  json["engaged_teeth"] = Numbers(r.curve.teeth);
  return json;
}

}  // namespace

Columns<std::size_t> CompareColumns(const Comparison& c) {
  Columns<std::size_t> columns{
      {"depth_mm", "{:.6g}", "middle of the step", [&c](std::size_t i) { return c.grid.Centre(i); }},
      {"region", "{}", "0: past the slice, the step in which it ends, or a gap",
       [&c](std::size_t i) { return c.region_of_bin[i]; }}};
  for (const CaseResult& r : c.cases) {
    columns.push_back(
        {r.what.id + "_N", "{:.6g}", "force of the case; empty where it did not reach that depth", [&r](std::size_t i) {
           const double force_N = r.curve.force_N[i];
           return std::isfinite(force_N) ? TableCell(force_N) : TableCell();
         }});
  }
  return columns;
}

std::string FormatCompareCsv(const Comparison& c) {
  return FormatCsv(CompareColumns(c), c.grid.count);
}

std::string FormatCompareJson(const Comparison& c) {
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}};
  json["schema"] = 1;
  json["scene"] = c.scene;
  json["title"] = c.title;
  json["command"] = c.command;
  json["rate_hz"] = c.rate_hz;
  json["rpm"] = c.rpm;
  json["top_speed_mm_per_s"] = Number(c.feed_mm_per_s);
  json["disc"] = {{"diameter_mm", c.saw.diameter_mm}, {"thickness_mm", c.saw.thickness_mm}, {"teeth", c.saw.teeth}};
  json["voxel_mm"] = c.voxel_mm;
  json["material"] = c.material_json;
  json["direction"] = {Number(c.direction_W.x), Number(c.direction_W.y), Number(c.direction_W.z)};
  json["slice"] = {{"depth_by", c.depth_by},
                   {"length_mm", Number(c.profile.end_mm)},
                   {"entry_mm", Number(c.profile.entry_mm)},
                   {"layers", c.profile.layers.size()}};
  json["slab"] = {{"contact_share_of_pitch", c.slab.contact_share_of_pitch},
                  {"mass_g", c.slab.mass_g},
                  {"stiffness_N_per_mm", c.slab.stiffness_N_per_mm},
                  {"damping_Ns_per_mm", c.slab.damping_Ns_per_mm},
                  {"friction_coefficient", c.slab.friction_coefficient},
                  {"normal_force_N", c.slab.normal_force_N},
                  {"coupling_N_per_mm", c.slab.coupling_N_per_mm},
                  {"coupling_damping_Ns_per_mm", c.slab.coupling_damping_Ns_per_mm},
                  {"segments_move", c.slab.segments_move}};
  json["regions"] = ordered_json::array();
  for (const CompareRegion& region : c.regions) {
    json["regions"].push_back({{"region", region.id},
                               {"name", region.name},
                               {"tissue", region.tissue},
                               {"E_GPa", Number(region.E_MPa / 1000)},
                               {"top_mm", Number(region.top_mm)},
                               {"bottom_mm", Number(region.bottom_mm)},
                               {"depths", region.bins.size()}});
  }
  json["repetitions"] = c.repetitions;
  json["peak_memory_MB"] = Number(c.peak_memory_MB);
  json["reference"] = c.reference().what.id;
  const CaseResult* equal = FindEqualLaw(c);
  json["equal_law"] = equal ? ordered_json(equal->what.id) : ordered_json(nullptr);
  json["rms_between_cases_N"] = ordered_json::array();
  for (const auto& row : c.rms_between_N) json["rms_between_cases_N"].push_back(Numbers(row));
  const Conclusion words = WriteConclusion(c);
  json["conclusion"] = {
      {"force", words.force}, {"regions", words.regions}, {"beyond", words.beyond}, {"cost", words.cost}};
  json["warnings"] = c.warnings;
  json["depth_step_mm"] = c.grid.step_mm;
  std::vector<double> depths;
  for (std::size_t i = 0; i < c.grid.count; ++i) depths.push_back(c.grid.Centre(i));
  json["depth_mm"] = Numbers(depths);
  json["region_of_depth"] = c.region_of_bin;
  json["cases"] = ordered_json::array();
  for (const CaseResult& r : c.cases) json["cases"].push_back(CaseJson(r, c));
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

void CheckCompareInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kFiles) outputs.push_back(folder + "/" + name);
  CheckInputsNotOverwritten(ListInputs(scene, scene_file), outputs);
}

std::vector<std::string> WriteComparison(const Comparison& c, const std::string& folder) {
  MakeFolder(folder);
  FileBatch results(folder, "compare.json");
  const std::string in = folder + "/";
  WritePlot(MakeForceDepthPlot(c), in + "force_depth.png");
  WritePlot(MakeDifferencePlot(c), in + "difference.png");
  WritePlot(MakeCostPlot(c), in + "cost.png");
  WriteTextFile(in + "compare.csv", FormatCompareCsv(c));
  WriteTextFile(in + "report.md", FormatCompareReport(c));
  WriteTextFile(in + "compare.json", FormatCompareJson(c));
  results.Commit();
  return {std::begin(kFiles), std::end(kFiles)};
}

}  // namespace kerf
