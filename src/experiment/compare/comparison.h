// The same cut in several ways: what `kerf compare` measures.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/compare/depth_curve.h"
#include "experiment/compare/difference.h"
#include "kerf/force.h"
#include "kerf/paper.h"
#include "kerf/slab.h"
#include "session/run/run.h"
#include "session/scene/scene.h"

namespace kerf {

/// One way to make the cut.
struct CompareCase {
  std::string id;     // "voxel_hertz_chip": in file columns and JSON
  std::string label;  // "voxel hertz_chip": for people
  bool slab = false;
  ForceLaw law;                                      // voxel only
  PaperReading reading = PaperReading::kAsComputed;  // slab only
};

/// What one case gave.
struct CaseResult {
  CompareCase what;
  DepthCurve curve;
  std::size_t ticks = 0;
  std::size_t ticks_on_curve = 0;  // in which the tool went deeper than before; the others are not compared
  double peak_N = 0;               // largest bin within the slice
  double peak_depth_mm = 0;
  double work_mJ = 0;                      // done by the hand over the whole path
  double removed_mm3 = 0;                  // voxel only
  std::uint64_t force_hash = 0;            // of each tick's force, bit for bit; equal in all repetitions
  std::optional<std::uint64_t> bone_hash;  // voxel only: of the bone after the cut
  std::uint64_t memory_bytes = 0;          // what the ticks work on: bone grids, or slab profile, law and state
  TickTimes times;                         // of the repetition with the lowest p99: a busy machine only adds
  std::vector<double> p50_us;              // of each repetition
  std::vector<double> p99_us;
  Difference slice;                 // from the reference, over the slice
  std::vector<Difference> regions;  // in the order of Comparison::regions
  Difference beyond;                // past the slice's end
};

/// Depths that belong together.
struct CompareRegion {
  int id = 0;
  std::string name;
  std::string tissue;
  double E_MPa = 0;
  double top_mm = 0;     // of the first bin
  double bottom_mm = 0;  // of the last; other regions may lie between
  std::vector<std::size_t> bins;
};

struct Comparison {
  std::string scene;  // name of the file, without folder and extension
  std::string title;
  std::string command;                 // that makes this again; the scene's file without its folder
  std::string material;                // what the bone's stiffness is from: a line for people
  std::string material_json = "null";  // the same as the object "material" of compare.json; files without folders
  std::string depth_by;                // "bone" or "paper_table_2"
  double voxel_mm = 0;
  double rate_hz = 0;
  double feed_mm_per_s = 0;  // top speed of the path
  double rpm = 0;
  DiscSaw saw;
  Vec3 direction_W{0};
  SlabProfile profile;
  SlabParams slab;  // of both readings
  DepthGrid grid;
  std::vector<int> region_of_bin;      // 0: no bone there, or past the slice
  std::vector<CompareRegion> regions;  // of the slice, by depth
  std::vector<std::size_t> slice_bins;
  std::vector<std::size_t> beyond_bins;
  int repetitions = 0;
  /// Rms difference over the slice of each case from each other, N: [i][j], symmetric.
  std::vector<std::vector<double>> rms_between_N;
  double peak_memory_MB = 0;      // of the whole program, all cases
  std::vector<CaseResult> cases;  // the first is the reference
  std::vector<std::string> warnings;

  const CaseResult& reference() const { return cases.front(); }
};

struct CompareParams {
  std::vector<std::string> laws;  // voxel mode with these too; "all": every law
  double depth_step_mm = 0.05;    // 0.005 to 5
  int repetitions = 3;            // 1 to 100
};

/// Throws Error for an unknown law or a number out of range.
void CheckCompareParams(const CompareParams& params);

/// What is being done (for a progress bar) and how much of it, 0..1.
using CompareProgress = std::function<void(const std::string& stage, double fraction)>;

/// The force on a tooth in slab mode, as a law for voxel mode.
ForceLaw MakeSlabLaw(const SlabParams& slab);
/// The voxel case with that law, with which slab cases are compared at equal law; null: there is none.
const CaseResult* FindEqualLaw(const Comparison& comparison);

/// The cases for a scene: voxel mode with its own law (the reference), with the laws asked for, with the slab's law,
/// slab mode in both readings. Throws Error for an unknown law.
std::vector<CompareCase> MakeCompareCases(const ForceLaw& own, const std::vector<std::string>& laws,
                                          const SlabParams& slab = {});

/// Runs every case `repetitions` times, in turn. Throws Error when the scene has no [slab], its path does not go into
/// the bone along the cut direction, CheckCompareParams() refuses, or a case gives other forces when repeated.
/// `scene_file` is named in the report's command, without its folder; "": the scene's name with .toml.
Comparison CompareScene(const Scene& scene, const CompareParams& params, const CompareProgress& progress,
                        const std::string& scene_file = "");

/// From cases with curves on the grid, and the profile: regions, bins, peaks and differences. What CompareScene() does
/// at the end; by itself for results made up in tests.
void FinishComparison(Comparison& comparison, const MaterialTable& materials);

}  // namespace kerf
