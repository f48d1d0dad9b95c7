#include "session/run/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>

#include "base/core/number_text.h"
#include "base/files/files.h"
#include "base/files/peak_memory.h"
#include "bone/vdb/bonefile.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/bone_cache.h"
#include "session/run/expected_files.h"
#include "session/run/make_bone.h"
#include "session/run/results_folder.h"
#include "session/run/run_pictures.h"
#include "session/run/run_slab.h"
#include "session/run/run_warnings.h"
#include "session/run/summary_json.h"
#include "session/run/write_pieces.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

/// Throws kerf::Error if the results will not fit on the disk.
void CheckSpace(const Scene& scene, const Path& path, const std::string& folder, const RunSession& session) {
  const auto ticks = static_cast<double>(path.CountTicks(scene.simulation.rate_hz));
  const std::string lack =
      DescribeLackOfSpace(ListExpectedFiles(scene, session.replay != nullptr ? 0 : ticks, folder, session.record));
  if (!lack.empty()) throw Error(lack);
}

void SummarizeBone(const Bone& before, const RunResult& result, RunSummary& summary) {
  summary.hash_before = before.CalcHash();
  summary.volume_after_mm3 = result.bone.CalcVolume();
  summary.removed_mm3 = result.removed_mm3;
  for (std::size_t id = 0; id < result.removed_mm3_by_region.size(); ++id) {
    const double mm3 = result.removed_mm3_by_region[id];
    if (mm3 > 0) summary.removed_mm3_by_region[static_cast<int>(id)] = mm3;
  }
  summary.materials = before.materials();
  summary.voxel_mm = before.voxel_mm();
  summary.bone_memory_MB = static_cast<double>(result.bone.CalcMemoryBytes()) / 1e6;
}

/// Writes scene.toml, forces.csv, the sounds and bone.vdb. Returns their names.
std::vector<std::string> WriteData(const Scene& scene, const std::string& folder, RunResult& result) {
  WriteTextFile(folder + "/scene.toml", ResolvedToml(scene));
  WriteForceLog(folder + "/forces.csv", result.ticks, scene.output.forces_every_ticks, &result.effects);
  std::vector<std::string> names = {"scene.toml", "forces.csv"};
  for (const std::string& name : result.files.WriteSounds(folder)) names.push_back(name);
  if (scene.output.bone) {
    WriteBone(result.bone, folder + "/bone.vdb");
    names.emplace_back("bone.vdb");
  }
  return names;
}

void WriteEffectPictures(const RunPictures& run, const std::vector<Bone>& pieces, const EffectFiles& files,
                         const Tool& tool, RunSummary& summary) {
  const std::string& title = run.scene.TitleOrName();
  if (summary.heat && summary.heat->section.columns > 0) {
    WriteHeatPicture(*summary.heat, title, run.folder + "/heat.png");
    summary.files.emplace_back("heat.png");
  }
  for (const std::string& name : files.WritePictures(run.folder, title, run.after, tool, IsOfPatient(run.scene))) {
    summary.files.push_back(name);
  }
  if (summary.fragments &&
      WriteFragmentsPicture(*summary.fragments, pieces, IsOfPatient(run.scene), title, run.folder + "/fragments.png")) {
    summary.files.emplace_back("fragments.png");
  }
}

}  // namespace

PieceSummary Summarize(const ResultPiece& piece) {
  PieceSummary summary{piece.volume_mm3, piece.bone->CalcBounds(), "", 0, PieceFate::kHeld, Vec3(0)};
  if (piece.out == nullptr) return summary;
  summary.place = piece.out->fate;
  summary.move_mm = piece.out->move_mm;
  summary.bounds_W.lower += summary.move_mm;
  summary.bounds_W.upper += summary.move_mm;
  return summary;
}

std::string DescribeCrumbs(const PieceCounts& counts) {
  if (counts.dust_count == 0) return "";
  std::string text =
      fmt::format("; {} of {:.3g} mm3 in total", FormatCount(counts.dust_count, "crumb", "crumbs"), counts.dust_mm3);
  if (counts.old_dust_count.value_or(0) == 0) return text;
  return text +
         fmt::format(", {} of them ({:.3g} mm3) from before the cut", *counts.old_dust_count, counts.old_dust_mm3);
}

ForceSummary SummarizeForces(const std::vector<TickRecord>& ticks, double rate_hz) {
  ForceSummary summary;
  double time_before_s = 0;
  double sum_N_s = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const TickRecord& t = ticks[i];
    // The last tick of a segment may be shorter.
    const double dt_s = std::min(t.time_s - time_before_s, 1 / rate_hz);
    time_before_s = t.time_s;
    const double force_N = glm::length(t.out.f_T_W_N);
    summary.impulse_Ns += force_N * dt_s;
    summary.thrust_J += t.out.thrust_W * dt_s;
    summary.cutting_J += t.out.cutting_W * dt_s;
    if (i > 0 && ticks[i - 1].segment == t.segment) {
      summary.work_Nmm -= glm::dot(t.out.f_T_W_N, t.X_WT.p_AB - ticks[i - 1].X_WT.p_AB);
    }
    if (t.out.engaged_teeth > 0) {
      summary.cutting_time_s += dt_s;
      sum_N_s += force_N * dt_s;
    }
    summary.engaged_teeth_peak = std::max(summary.engaged_teeth_peak, t.out.engaged_teeth);
    if (force_N > summary.peak_N) {
      summary.peak_N = force_N;
      summary.peak_time_s = t.time_s;
    }
  }
  if (summary.cutting_time_s > 0) summary.mean_N = sum_N_s / summary.cutting_time_s;
  return summary;
}

void SummarizeTicks(const Scene& scene, const Path& path, const RunResult& result, RunSummary& summary) {
  summary.force = SummarizeForces(result.ticks, scene.simulation.rate_hz);
  summary.effects = result.effects.WithoutRows();
  summary.cutting = CalcRunEnergy(scene, path, result, summary.force);
  summary.ticks = result.ticks.size();
  for (std::size_t i = 0; i < result.ticks.size(); ++i) {
    const TickRecord& t = result.ticks[i];
    summary.ticks_with_status += t.out.status != kTickOk ? 1 : 0;
    summary.ticks_at_metal += (t.out.status & kTickTouchesMetal) != 0 ? 1 : 0;
    summary.touched = summary.touched || t.touched;
    const bool set_down =
        i == 0 || (t.segment != result.ticks[i - 1].segment && path.segments()[t.segment].retract_before);
    summary.starts_in_bone = summary.starts_in_bone || (set_down && t.out.removed_mm3 > kInBone_mm3);
  }
  summary.simulated_s = path.duration_s();
  summary.ticks_wall_s = result.wall_s;
  summary.times = result.times;
  summary.costs = result.costs;
}

CuttingEnergy CalcRunEnergy(const Scene& scene, const Path& path, const RunResult& result, const ForceSummary& force) {
  const double turns_per_s = std::abs(scene.tool.rpm) / 60;
  return CalcCuttingEnergy(
      scene, result.effects,
      {force.thrust_J, path.duration_s(), force.cutting_time_s * turns_per_s, result.removed_mm3, force.cutting_J});
}

double RunSummary::CalcOut_mm3() const {
  if (!fragments) return 0;
  return fragments->CalcSetAside_mm3() + fragments->CalcDeleted_mm3() + fragments->CalcDustOut_mm3();
}

std::vector<std::string> ListInputs(const Scene& scene, const std::string& scene_file) {
  std::vector<std::string> inputs{scene_file,      scene.bone.file,   scene.bone.materials, scene.material.ct_law_file,
                                  scene.path.file, scene.device.file, scene.force_file};
  inputs.insert(inputs.end(), scene.plan_files.begin(), scene.plan_files.end());
  for (const EffectChoice& effect : scene.effects) {
    for (const auto& file : effect.files()) {
      if (file != nullptr) inputs.push_back(file->name);
    }
  }
  return inputs;
}

void CheckInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder) {
  std::vector<std::string> outputs;
  // List all results, whatever the scene requests: an earlier run may have left others, which are removed.
  for (const char* name : {"scene.toml", "forces.csv", "bone.vdb", "summary.json", "before.png", "after.png", "cut.png",
                           "apart.png", "force.png", "heat.png", "fragments.png", "slab.csv", "slab.png", "left.vdb",
                           "slice.vdb", "right.vdb", "left.stl", "slice.stl", "right.stl"}) {
    outputs.push_back(fmt::format("{}/{}", folder, name));
  }
  for (const std::string& name : EffectFiles::Names()) outputs.push_back(fmt::format("{}/{}", folder, name));
  for (const std::string& name : ReadEarlierResults(folder)) outputs.push_back(fmt::format("{}/{}", folder, name));
  const std::vector<std::string> inputs = ListInputs(scene, scene_file);
  for (const std::string& name : ListPieceFiles(folder, inputs)) outputs.push_back(name);
  CheckInputsNotOverwritten(inputs, outputs);
}

RunSummary RunScene(const Scene& scene, const std::string& folder, const RunProgress& progress,
                    const CostOptions& costs, const RunSession& session, double surface_error_mm) {
  const auto stage = [&](const char* name) {
    return [&progress, name](double fraction) {
      if (progress) progress(name, fraction);
    };
  };
  MakeFolder(folder);
  const std::vector<std::string> earlier = ReadEarlierResults(folder);
  const Path path = MakePath(scene);
  CheckRunTicks(path, scene.simulation.rate_hz);
  CheckSpace(scene, path, folder, session);
  const SimulationParams params = MakeSimulationParams(scene);
  RunSummary summary;
  const Bone before = MakeSceneBone(scene, stage("making the bone"), &summary.material);
  if (costs.costs) FinishKeepingBones();
  RunTape tape(session, scene, RecordedKind::kRun, before);
  RunResult result = RunPath(before, params, path, scene.simulation.rate_hz, scene.tool.CalcTickRpm(), stage("cutting"),
                             costs, tape.tape());
  summary.hash_after = result.bone.CalcHash();
  tape.Finish(summary.hash_after);
  summary.heat = std::move(result.heat);
  summary.fragments = std::move(result.fragments);
  const std::span<const PieceOut> out = summary.fragments ? summary.fragments->out : std::span<const PieceOut>{};
  if (scene.output.bone) result.bone.set_note("cut_by_scene", scene.name);

  FileBatch results(folder, "summary.json");
  // The data, the pieces and the first picture do not depend on each other. Pictures are drawn by this thread.
  std::future<std::vector<std::string>> data =
      std::async(std::launch::async, [&] { return WriteData(scene, folder, result); });
  Pieces split;
  std::vector<PieceSurface> surfaces;
  std::atomic<bool> is_separated = false;
  std::atomic<double> written = 0;
  std::future<void> pieces = std::async(std::launch::async, [&] {
    split = SplitPieces(result.bone, scene.output.smallest_piece_mm3, &before);
    const std::vector<ResultPiece> listed = ListPieces(split.pieces, CalcVolumes(split.pieces), out);
    for (const ResultPiece& piece : listed) summary.pieces.push_back(Summarize(piece));
    is_separated = true;
    surfaces = WritePieces(
        scene, split.pieces, listed, surface_error_mm, folder, [&](double fraction) { written = fraction; },
        summary.pieces);
  });
  const auto report_pieces = [&](double first_drawn) {
    if (is_separated) {
      stage("writing the pieces")(written);
    } else {
      stage("separating the pieces")(first_drawn);
    }
  };
  stage("separating the pieces")(0);
  summary.volume_before_mm3 = before.CalcVolume();
  SummarizeTicks(scene, path, result, summary);
  std::vector<std::string> picture_warnings;
  std::vector<std::string> picture_names;
  const bool drawn = AreDrawn(scene, picture_warnings);
  RunPictures pictures{scene, result.ticks, before, summary.volume_before_mm3, result.bone, {}, folder};
  pictures.apart = !summary.fragments;  // fragments.png shows them
  pictures.out = out;
  std::future<void> summarized;
  const auto finish_pieces = [&] {
    while (pieces.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) report_pieces(drawn ? 1 : 0);
    pieces.get();
    stage("writing the pieces")(1);
    if (drawn) stage("drawing the pictures")(0);
    // Only now: the pieces use all cores, and drawing the pictures does not.
    if (drawn) summarized = std::async(std::launch::async, [&] { SummarizeBone(before, result, summary); });
    return DrawnPieces{surfaces, &split.dust};
  };
  pictures.make_pieces = finish_pieces;
  const auto report_drawn = [&](double fraction) {
    if (fraction > kBeforeDrawn) {
      stage("drawing the pictures")((fraction - kBeforeDrawn) / (1 - kBeforeDrawn));
    } else {
      report_pieces(fraction / kBeforeDrawn);
    }
  };
  if (drawn) {
    picture_names = WriteRunPictures(pictures, report_drawn, picture_warnings);
    summarized.get();
  } else {
    SummarizeBone(before, result, summary);
    finish_pieces();
  }
  summary.piece_counts = split;
  summary.surface_error_mm = surface_error_mm;
  summary.files = data.get();
  for (const PieceSummary& piece : summary.pieces) {
    if (!piece.file.empty()) summary.files.push_back(piece.file);
  }
  if (session.replay != nullptr) summary.warnings = session.replay->FindWarnings();
  for (const std::string& warning : FindRunWarnings(scene, summary)) summary.warnings.push_back(warning);
  summary.warnings.insert(summary.warnings.end(), picture_warnings.begin(), picture_warnings.end());
  summary.files.insert(summary.files.end(), picture_names.begin(), picture_names.end());
  if (drawn) WriteEffectPictures(pictures, split.pieces, result.files, params.tool, summary);
  summary.peak_memory_MB = ReadPeakMemory_MB();
  summary.files.emplace_back("summary.json");
  WriteTextFile(folder + "/summary.json", FormatSummaryJson(scene, summary));
  results.Commit(earlier);
  return summary;
}

Replayed ReplayScene(const Scene& scene, RunReplay& replay, const RunProgress& progress) {
  const Bone bone = MakeSceneBone(scene, [&](double f) { progress("making the bone", f); });
  CheckReplays(replay.recording(), bone);
  const auto cutting = [&](double f) { progress("cutting", f); };
  if (scene.simulation.mode == SceneMode::kSlab) {
    RunSlab(scene, MakeSlabProfile(scene, bone), cutting, {.replay = &replay});
    return replay.MakeReport(bone.CalcHash());
  }
  const RunResult result = RunPath(bone, MakeSimulationParams(scene), MakePath(scene), scene.simulation.rate_hz,
                                   scene.tool.CalcTickRpm(), cutting, {}, {.replay = &replay});
  return replay.MakeReport(result.bone.CalcHash());
}

std::string FormatSummaryJson(const Scene& scene, const RunSummary& s) {
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}};
  json["scene"] = scene.name;
  json["bone"] = {{"voxel_mm", s.voxel_mm},
                  {"hash_before", fmt::format("{:016x}", s.hash_before)},
                  {"hash_after", fmt::format("{:016x}", s.hash_after)},
                  {"volume_before_mm3", s.volume_before_mm3},
                  {"volume_after_mm3", s.volume_after_mm3},
                  {"memory_MB", s.bone_memory_MB}};
  json["material"] = MaterialJson(scene, s.material);
  ordered_json regions = ordered_json::array();
  for (const auto& [id, mm3] : s.removed_mm3_by_region) {
    ordered_json row = {{"region", id}, {"removed_mm3", mm3}};
    if (s.materials.Contains(id)) {
      const Region& region = s.materials.At(id);
      row["name"] = region.name;
      row["tissue"] = ToString(region.tissue);
      row["E_GPa"] = region.E_MPa / 1000;
      row["nu"] = region.nu;
      row["estimate"] = region.estimate;
    }
    regions.push_back(row);
  }
  json["removed"] = {{"total_mm3", s.removed_mm3},
                     {"removed_plus_remaining_minus_initial_mm3",
                      s.removed_mm3 + s.volume_after_mm3 + s.CalcOut_mm3() - s.volume_before_mm3},
                     {"by_region", regions}};
  json["force"] = ForceJson(scene.force.name(), s.force);
  json["force"]["accuracy"] = DescribeAccuracy(scene.force, MakeTool(scene));
  json["force"]["blades"] = DescribeBlades(scene.force, MakeTool(scene));
  json["cutting"] = CuttingJson(s.cutting);
  if (!s.effects.on.empty()) json["effects"] = EffectsJson(s.effects);
  if (s.heat) json["heat"] = HeatJson(*s.heat);
  if (s.fragments) json["fragments"] = FragmentsJson(*s.fragments, true);
  json["pieces"] = ordered_json::array();
  for (const PieceSummary& piece : s.pieces) json["pieces"].push_back(PieceJson(piece));
  if (HaveFiles(s.pieces)) json["surface_error_mm"] = s.surface_error_mm;
  json["dust"] = DustJson(s.piece_counts);
  json["ticks"] = TicksJson(s);
  if (s.costs) json["costs"] = CostsJson(*s.costs);
  json["peak_memory_MB"] = s.peak_memory_MB;
  json["warnings"] = s.warnings;
  json["files"] = s.files;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
