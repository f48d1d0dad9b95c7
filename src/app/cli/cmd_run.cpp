#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/progress.h"
#include "app/cli/run_uncertain.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "bone/material/segment_regions.h"
#include "cut/force/measured.h"
#include "cut/tool/words.h"
#include "session/run/run_scene.h"
#include "session/run/run_slab_scene.h"
#include "session/scene/saws.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct RunArguments {
  std::string scene;
  std::string folder = "out";
  bool json = false;
  bool costs = false;
  std::string record;
  bool records = false;
  bool no_pictures = false;
  bool full = false;
};

/// Prints what the files of the pieces or parts contain.
template <typename Pieces>
void PrintSurfaces(const Pieces& pieces, double error_mm) {
  std::size_t triangles = 0;
  for (const auto& piece : pieces) triangles += piece.triangles;
  if (triangles == 0) return;
  fmt::print("  surfaces  {} triangles, {}\n", triangles,
             error_mm > 0 ? fmt::format("within {:g} mm of the full ones ('--full' writes those)", error_mm)
                          : "at full resolution");
}

/// Returns the name of a tooth with a number, otherwise the tissue.
std::string NameTissue(const Region& region) {
  return FindToothNumber(region) != 0 ? region.name : ToString(region.tissue);
}

void PrintSummary(const Scene& scene, const RunSummary& s, const std::string& folder) {
  fmt::print("{}\n", scene.TitleOrName());
  fmt::print("  bone      {:.2f} cm3 at {:g} mm voxels, {:.0f} MB\n", s.volume_before_mm3 / 1000, s.voxel_mm,
             s.bone_memory_MB);
  fmt::print("  material  {}\n", DescribeMaterial(scene, s.material));
  fmt::print("  tool      {}\n", DescribeDrivenTool(scene.tool));
  fmt::print("  removed   {:.2f} mm3", s.removed_mm3);
  std::map<std::string, double> by_tissue;
  for (const auto& [id, mm3] : s.removed_mm3_by_region) {
    by_tissue[s.materials.Contains(id) ? NameTissue(s.materials.At(id)) : "no material"] += mm3;
  }
  for (auto it = by_tissue.begin(); it != by_tissue.end(); ++it) {
    fmt::print("{}{:.2f} {}", it == by_tissue.begin() ? " (" : ", ", it->second, it->first);
  }
  fmt::print("{}\n", by_tissue.empty() ? "" : ")");
  fmt::print("  force     peak {:.2f} N at {:.2f} s, mean {:.2f} N over {:.2f} s of cutting; up to {} engaged\n",
             s.force.peak_N, s.force.peak_time_s, s.force.mean_N, s.force.cutting_time_s,
             DescribeTeeth(scene.tool.shape, s.force.engaged_teeth_peak));
  fmt::print("            {}, {}\n            {}\n            {}\n", scene.force.name(), DescribeBites(scene),
             DescribeAccuracy(scene.force, MakeTool(scene)), DescribeBlades(scene.force, MakeTool(scene)));
  fmt::print("  cutting   {}\n", DescribeCuttingEnergy(s.cutting));
  for (const std::string& effect : DescribeEffects(s.effects)) fmt::print("  effect    {}\n", effect);
  fmt::print("  pieces    {}", s.pieces.size());
  for (std::size_t i = 0; i < s.pieces.size(); ++i) {
    fmt::print("{}{:.2f} cm3", i == 0 ? ": " : ", ", s.pieces[i].volume_mm3 / 1000);
    if (s.pieces[i].place != PieceFate::kHeld) fmt::print(" ({})", ToString(s.pieces[i].place));
  }
  fmt::print("{}\n", DescribeCrumbs(s.piece_counts));
  PrintSurfaces(s.pieces, s.surface_error_mm);
  if (s.heat) fmt::print("  heat      {}\n", DescribeHeat(*s.heat));
  if (s.fragments) fmt::print("  fragments {}\n", DescribeFragments(*s.fragments));
  fmt::print("  ticks     {} in {:.1f} s, {:.0f} a second; each p50 {:.0f}, p99 {:.0f}, p99.9 {:.0f}, max {:.0f} us\n",
             s.ticks, s.ticks_wall_s, s.ticks_wall_s > 0 ? static_cast<double>(s.ticks) / s.ticks_wall_s : 0,
             s.times.p50_us, s.times.p99_us, s.times.p999_us, s.times.max_us);
  if (s.costs) fmt::print("{}", FormatCostTable(*s.costs));
  fmt::print("  state     {:016x} before, {:016x} after\n", s.hash_before, s.hash_after);
  fmt::print("  results   {}/:", folder);
  for (const std::string& file : s.files) fmt::print(" {}", file);
  fmt::print("\n");
}

void PrintSlabSummary(const Scene& scene, const SlabSummary& s, const std::string& folder) {
  fmt::print("{}\n", scene.TitleOrName());
  const Vec3& d = scene.slab.direction;
  fmt::print("  slice     {:g} mm thick, {:.2f} mm long along [{:g}, {:g}, {:g}]; law {}\n",
             CalcThickness(scene.tool.shape), s.profile.end_mm, d.x, d.y, d.z, ToString(scene.slab.params.reading));
  fmt::print("  material  {}\n", DescribeMaterial(scene, s.material));
  fmt::print("  cut       {:.2f} mm deep{}\n", std::min(s.end.deepest_mm, s.profile.end_mm),
             s.free_at_s ? fmt::format("; the slice came free at {:.2f} s", *s.free_at_s) : std::string());
  fmt::print("  force     peak {:.2f} N at {:.2f} s, mean {:.2f} N over {:.2f} s of cutting; up to {:.1f} teeth\n",
             s.force.peak_N, s.force.peak_time_s, s.force.mean_N, s.force.cutting_time_s, s.force.engaged_teeth_peak);
  fmt::print("            {}\n", DescribeSlabLaw(scene));
  fmt::print(
      "  energy    hand {:.3g} mJ: cutting {:.3g}, friction {:.3g}, damping {:.3g}, in springs and motion {:.3g}, "
      "released {:.3g}, time step {:.2g}\n",
      s.end.hand_work_mJ, s.end.cutting_mJ, s.end.friction_mJ, s.end.damping_mJ, s.end.kinetic_mJ + s.end.elastic_mJ,
      s.end.released_mJ, s.end.numerical_mJ);
  if (!s.parts.empty()) {
    fmt::print("  parts    ");
    for (const SlabPartSummary& part : s.parts) fmt::print(" {} {:.2f} mm3;", part.name, part.volume_mm3);
    fmt::print(" before the run\n");
  }
  PrintSurfaces(s.parts, s.surface_error_mm);
  fmt::print("  ticks     {} in {:.2g} s; each p50 {:.2f}, p99 {:.2f}, p99.9 {:.2f}, max {:.0f} us; {:.1f} kB\n",
             s.ticks, s.ticks_wall_s, s.times.p50_us, s.times.p99_us, s.times.p999_us, s.times.max_us,
             static_cast<double>(s.memory_bytes) / 1000);
  fmt::print("  results   {}/:", folder);
  for (const std::string& file : s.files) fmt::print(" {}", file);
  fmt::print("\n");
}

/// Runs a scene in slab mode. `lost`: set to a message if the recording could not be written completely.
void RunSlabMode(const Scene& scene, const RunArguments& options, std::string& lost) {
  SlabSummary summary;
  {
    RunBar bar(ListRunStages(scene, true));
    summary = RunSlabScene(
        scene, options.folder, [&](const std::string& now, double fraction) { bar.Show(now, fraction); },
        {options.record, options.scene, nullptr, &lost}, options.full ? 0 : kSurfaceErrorMm);
  }
  for (const std::string& warning : summary.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatSlabSummaryJson(scene, summary));
  } else {
    PrintSlabSummary(scene, summary, options.folder);
    if (options.records && lost.empty()) fmt::print("  recorded  {}\n", options.record);
  }
}

void RunVoxelMode(const Scene& scene, const RunArguments& options, std::string& lost) {
  RunSummary summary;
  {
    RunBar bar(ListRunStages(scene, true));
    summary = RunScene(
        scene, options.folder, [&](const std::string& now, double fraction) { bar.Show(now, fraction); },
        {options.costs, [&](const std::string& line) { bar.SetNote(line); }},
        {options.record, options.scene, nullptr, &lost}, options.full ? 0 : kSurfaceErrorMm);
  }
  for (const std::string& warning : summary.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatSummaryJson(scene, summary));
  } else {
    PrintSummary(scene, summary, options.folder);
    if (options.records && lost.empty()) fmt::print("  recorded  {}\n", options.record);
  }
}

void Run(const RunArguments& options) {
  Scene scene = ReadScene(options.scene);
  if (options.no_pictures) scene.output.pictures = false;
  CheckInputsNotOverwritten(scene, options.scene, options.folder);
  if (options.records) {
    CheckInputsNotOverwritten(ListInputs(scene, options.scene), {options.record});
    CheckNewRecording(options.record);
    CheckInputsNotOverwritten(scene, options.record, options.folder);  // results must not overwrite the recording
  }
  if (scene.simulation.mode == SceneMode::kSlab && options.costs) {
    throw Error(fmt::format("{}: slab mode has no stages for --costs to show", options.scene));
  }
  const FolderLock lock(options.folder);
  std::string lost;
  try {
    if (scene.simulation.mode == SceneMode::kSlab) {
      RunSlabMode(scene, options, lost);
    } else {
      RunVoxelMode(scene, options, lost);
    }
  } catch (const Error&) {
    // Report a lost recording first.
    if (!lost.empty()) Say("{}", lost);
    throw;
  }
  if (!lost.empty()) throw Error(lost);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  const auto options = std::make_shared<RunArguments>();
  CLI::App* command =
      app.add_subcommand("run", "Run a scene: cut the bone along the path, write forces, bone, pieces and pictures");
  command->add_option("SCENE", options->scene, "Scene file (TOML; see 'kerf scene --defaults')")->required();
  command
      ->add_option("-o,--output", options->folder,
                   "Folder for the results; created if missing; files of the same names in it are replaced")
      ->capture_default_str();
  CLI::Option* costs =
      command->add_flag("--costs", options->costs,
                        "Time each stage of the ticks and each effect, and show the cost of a tick: live after the "
                        "progress bar, and as a table");
  CLI::Option* record = command->add_option(
      "--record", options->record, "Record the run into this file, which must not exist yet (see 'kerf replay')");
  command->add_flag("--no-pictures", options->no_pictures, "Draw no pictures, even if the scene requests them");
  CLI::Option* full = command->add_flag(
      "--full", options->full,
      fmt::format("Write the pieces at full resolution; otherwise within {:g} mm of it, with fewer triangles",
                  kSurfaceErrorMm));
  command->add_flag("--json", options->json, "Print as JSON");
  const auto run_uncertain = AddUncertainOptions(*command, {costs, record, full});
  command->callback([options, record, run_uncertain] {
    if (run_uncertain({options->scene, options->folder, options->json, options->no_pictures})) return;
    options->records = record->count() > 0;
    Run(*options);
  });
}

}  // namespace kerf::cli
