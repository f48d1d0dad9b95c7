// The same cut made in several ways: the measurement of `kerf compare`.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
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
  std::string id;     // in CSV columns and JSON: "voxel_hertz_chip"
  std::string label;  // for the user: "voxel hertz_chip"
  bool slab = false;
  ForceLaw law;                                      // voxel only
  PaperReading reading = PaperReading::kAsComputed;  // slab only
};

/// The result of one case.
struct CaseResult {
  CompareCase what;
  DepthCurve curve;
  std::size_t ticks = 0;
  std::size_t ticks_on_curve = 0;  // ticks in which the tool went deeper than before; the others are not compared
  double peak_N = 0;               // maximum over the bins of the slice
  double peak_depth_mm = 0;
  double work_mJ = 0;                      // done by the hand over the whole path
  double removed_mm3 = 0;                  // voxel only
  std::uint64_t force_hash = 0;            // of the exact forces of all ticks; equal in all repetitions
  std::optional<std::uint64_t> bone_hash;  // voxel only: of the bone after the cut
  std::uint64_t memory_bytes = 0;          // data that the ticks work on: bone grids, or slab profile, law and state
  Percentiles times;                       // of the repetition with the lowest p99; other load can only add time
  std::vector<double> p50_us;              // of each repetition
  std::vector<double> p99_us;
  Difference slice;                 // from the reference, over the slice
  std::vector<Difference> regions;  // in the order of Comparison::regions
  Difference beyond;                // beyond the end of the slice
};

/// The depths that have the same material.
struct CompareRegion {
  int id = 0;
  std::string name;
  std::string tissue;
  double E_MPa = 0;
  double top_mm = 0;     // of the first bin
  double bottom_mm = 0;  // of the last bin; other regions may lie between
  std::vector<std::size_t> bins;
};

struct Comparison {
  std::string scene;  // name of the file, without folder and extension
  std::string title;
  std::string command;                   // command that reproduces this; the scene file without its folder
  std::string material;                  // source of the bone's stiffness, one line for the user
  nlohmann::ordered_json material_json;  // the same as the object "material" of compare.json; files without folders
  std::string depth_by;                  // "bone" or "paper_table_2"
  double voxel_mm = 0;
  double rate_hz = 0;
  double feed_mm_per_s = 0;  // top speed of the path
  double rpm = 0;
  DiscSaw saw;
  Vec3 direction_W{0};
  SlabProfile profile;
  SlabParams slab;  // used by both readings
  DepthGrid grid;
  std::vector<int> region_of_bin;      // 0: no bone there, or beyond the slice
  std::vector<CompareRegion> regions;  // of the slice, by depth
  std::vector<std::size_t> slice_bins;
  std::vector<std::size_t> beyond_bins;
  int repetitions = 0;
  /// RMS difference over the slice between each pair of cases, N: [i][j], symmetric.
  std::vector<std::vector<double>> rms_between_N;
  double peak_memory_MB = 0;      // of the whole program, all cases
  std::vector<CaseResult> cases;  // the first is the reference
  std::vector<std::string> warnings;

  const CaseResult& reference() const { return cases.front(); }
};

struct CompareParams {
  std::vector<std::string> laws;  // additional laws for voxel mode; "all": every law
  double depth_step_mm = 0.05;
  int repetitions = 3;
};
template <typename V>
void Describe(CompareParams& p, V&& visit) {
  visit("depth_step_mm", p.depth_step_mm, Range{0.005, 5}, "step of the common depth axis");
  visit("repetitions", p.repetitions, Range{1, 100},
        "runs of each case; they alternate between cases, and the times are those of the fastest run");
}

/// Throws Error for an unknown law or a number out of range.
void CheckCompareParams(const CompareParams& params);

/// Receives the current stage (for a progress bar) and the fraction that is done, 0..1.
using CompareProgress = std::function<void(const std::string& stage, double fraction)>;

/// Returns the force on a tooth in slab mode as a law for voxel mode.
ForceLaw MakeSlabLaw(const SlabParams& slab);
/// Returns the voxel case that uses MakeSlabLaw(), with which slab cases are compared so that only the mode differs;
/// null if there is none.
const CaseResult* FindEqualLaw(const Comparison& comparison);

/// Returns the cases for a scene: voxel mode with its own law (the reference), with the requested laws and with the
/// slab's law, and slab mode in both readings. Throws Error for an unknown law.
std::vector<CompareCase> MakeCompareCases(const ForceLaw& own, const std::vector<std::string>& laws,
                                          const SlabParams& slab = {});

/// Runs every case `repetitions` times; the repetitions of the cases alternate. Throws Error if the scene has no
/// [slab], its path does not enter the bone along the cut direction, CheckCompareParams() fails, or the forces of a
/// case differ between repetitions. The command in the report contains `scene_file` without its folder or, if it is
/// empty, the scene's name with .toml.
Comparison CompareScene(const Scene& scene, const CompareParams& params, const CompareProgress& progress,
                        const std::string& scene_file = "");

/// Computes regions, bins, peaks and differences from the profile and from the cases and their curves on the grid. This
/// is the last step of CompareScene(); tests call it with artificial results.
void FinishComparison(Comparison& comparison, const MaterialTable& materials);

}  // namespace kerf
