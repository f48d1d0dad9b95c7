// `kerf run`: runs a scene and writes a folder of results.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bone/mesh/reduce.h"
#include "kerf/surface.h"
#include "session/run/cutting_energy.h"
#include "session/run/path_tape.h"
#include "session/run/run.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

/// A separate piece of the bone after the cut.
struct PieceSummary {
  double volume_mm3 = 0;
  Box3 bounds_W;                       // bounding box
  std::string file;                    // its STL in the output folder; empty if not requested
  std::size_t triangles = 0;           // in that file
  PieceFate place = PieceFate::kHeld;  // kHeld: in the bone
  Vec3 move_mm{0};                     // translation from where it was cut off
};

PieceSummary Summarize(const ResultPiece& piece);
/// Returns "; 5 crumbs of 0.404 mm3 in total, 2 of them (0.1 mm3) from before the cut", or "" if there are none.
std::string DescribeCrumbs(const PieceCounts& counts);

struct ForceSummary {
  double peak_N = 0;  // largest magnitude of the force on the tool
  double peak_time_s = 0;
  double mean_N = 0;      // over the ticks with a tooth engaged
  double impulse_Ns = 0;  // integral of the magnitude
  double work_Nmm = 0;    // done by the hand against the force along the path
  double engaged_teeth_peak = 0;
  double cutting_time_s = 0;  // with a tooth engaged
  double thrust_J = 0;        // integral of TeethOutput::thrust_W
  double cutting_J = 0;       // work of the cutting force that the law states; 0 if it states none
};

struct RunSummary {
  std::uint64_t hash_before = 0;
  std::uint64_t hash_after = 0;
  double volume_before_mm3 = 0;
  double volume_after_mm3 = 0;  // of the bone without the pieces taken out of it
  double removed_mm3 = 0;
  std::map<int, double> removed_mm3_by_region;
  MaterialTable materials;  // as used: uniform if the scene sets it so
  MaterialSummary material;
  ForceSummary force;
  CuttingEnergy cutting;
  EffectRecord effects;  // without its rows
  std::vector<PieceSummary> pieces;
  PieceCounts piece_counts;
  bool starts_in_bone = false;  // teeth were engaged in the first tick after the tool was placed
  bool touched = false;         // a tooth was engaged at least once
  std::size_t ticks = 0;
  std::size_t ticks_with_status = 0;  // ticks with any bit of TickOutput::status set
  std::size_t ticks_at_metal = 0;     // of these, ticks with kTickTouchesMetal
  double simulated_s = 0;
  double ticks_wall_s = 0;
  Percentiles times;
  std::optional<StageCosts> costs;
  double voxel_mm = 0;
  double bone_memory_MB = 0;
  std::optional<HeatReport> heat;
  std::optional<FragmentsReport> fragments;
  double peak_memory_MB = 0;          // of the whole program
  std::vector<std::string> files;     // written files, relative to the output folder
  double surface_error_mm = 0;        // maximum error of the pieces' files; 0: not reduced
  std::vector<std::string> warnings;  // one sentence each

  double CalcOut_mm3() const;  // taken out but not cut: set aside, hidden and deleted pieces, and dust
};

/// Called with the name of the current stage (for a progress bar) and its completed fraction, 0..1.
using RunProgress = std::function<void(const std::string& stage, double fraction)>;

/// Runs `scene` and writes into `folder`, which is created if missing: forces.csv, scene.toml (resolved) and, as the
/// scene requests, bone.vdb, piece_N.stl, before.png, after.png, cut.png, apart.png, force.png, heat.png,
/// fragments.png; the files of the effects (EffectFiles); summary.json last. The pieces' surfaces are reduced to
/// `surface_error_mm`; 0: not reduced. Results of an earlier run in the same folder, listed in its summary.json, are
/// replaced or removed. Throws kerf::Error.
RunSummary RunScene(const Scene& scene, const std::string& folder, const RunProgress& progress,
                    const CostOptions& costs = {}, const RunSession& session = {},
                    double surface_error_mm = kSurfaceErrorMm);
/// Replays a run, in either mode, without writing anything. Throws kerf::Error.
Replayed ReplayScene(const Scene& scene, RunReplay& replay, const RunProgress& progress);

/// Returns the files that a run of the scene reads; some may be "".
std::vector<std::string> ListInputs(const Scene& scene, const std::string& scene_file);

/// Throws kerf::Error if a result in `folder` would replace one of the run's inputs: `scene_file`, the bone, the path,
/// the table of regions or the table of laws.
void CheckInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder);

std::string FormatSummaryJson(const Scene& scene, const RunSummary& summary);
ForceSummary SummarizeForces(const std::vector<TickRecord>& ticks, double rate_hz);
/// Sets what the summary says about the ticks, such as `force`, `effects`, `cutting` and `touched`.
void SummarizeTicks(const Scene& scene, const Path& path, const RunResult& result, RunSummary& summary);
/// `force`: from SummarizeForces().
CuttingEnergy CalcRunEnergy(const Scene& scene, const Path& path, const RunResult& result, const ForceSummary& force);

}  // namespace kerf
