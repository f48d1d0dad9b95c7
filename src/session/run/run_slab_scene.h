// `kerf run` of a scene in slab mode: writes a folder of results.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/run/run_scene.h"
#include "session/run/run_slab.h"
#include "session/run/scene_material.h"

namespace kerf {

/// One of the three parts, before the run.
struct SlabPartSummary {
  std::string name;  // "left", "slice" or "right"
  double volume_mm3 = 0;
  Box3 bounds_W;
  std::string file;           // its STL in the output folder; empty if not requested
  std::size_t triangles = 0;  // in that file
};

struct SlabSummary {
  ForceSummary force;
  SlabState end;  // at the end of the run
  SlabProfile profile;
  MaterialTable materials;
  MaterialSummary material;
  bool starts_in_bone = false;         // the tool was placed with the blade inside the bone
  std::optional<double> free_at_s;     // time at which the slice came free
  std::vector<SlabPartSummary> parts;  // empty if no requested result needs them
  std::size_t ticks = 0;
  std::size_t ticks_with_status = 0;
  double simulated_s = 0;
  double ticks_wall_s = 0;
  Percentiles times;
  std::uint64_t memory_bytes = 0;     // memory for the ticks
  double voxel_mm = 0;                // of the bone from which the profile was taken
  std::vector<std::string> files;     // written files, relative to the output folder
  double surface_error_mm = 0;        // maximum error of the parts' STL files; 0: not reduced
  std::vector<std::string> warnings;  // one sentence each
};

/// Runs `scene`, whose mode is slab, and writes into `folder`: scene.toml (resolved), forces.csv, slab.csv and, as the
/// scene requests, force.png, slab.png, left.stl, slice.stl, right.stl and the same parts as .vdb; summary.json last.
/// The STL files are reduced to `surface_error_mm`; 0: not reduced. Results of an earlier run in the folder are
/// replaced or removed. Throws kerf::Error.
SlabSummary RunSlabScene(const Scene& scene, const std::string& folder, const RunProgress& progress,
                         const RunSession& session = {}, double surface_error_mm = kSurfaceErrorMm);

/// Sets what the summary says about the ticks, of which there is at least one.
void SummarizeSlabRun(const Scene& scene, const SlabParams& params, const SlabRun& run, SlabSummary& summary);
std::string FormatSlabSummaryJson(const Scene& scene, const SlabSummary& summary);
/// Describes how the force on one tooth, in both readings of the paper, compares with measured values.
std::string DescribeSlabLaw(const Scene& scene);

}  // namespace kerf
