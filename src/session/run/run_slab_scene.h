// `kerf run` of a scene in slab mode: a folder of results.
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
  std::string file;           // its STL in the output folder; empty when none was asked for
  std::size_t triangles = 0;  // in that file
};

struct SlabSummary {
  ForceSummary force;
  SlabState end;  // at the end of the run
  SlabProfile profile;
  MaterialTable materials;
  MaterialSummary material;
  bool starts_in_bone = false;         // a stroke was set down with the blade in the bone
  std::optional<double> free_at_s;     // when the slice came free
  std::vector<SlabPartSummary> parts;  // empty when nothing that the scene asks for needs them
  std::size_t ticks = 0;
  std::size_t ticks_with_status = 0;
  double simulated_s = 0;
  double ticks_wall_s = 0;
  TickTimes times;
  std::uint64_t memory_bytes = 0;     // what the ticks need
  double voxel_mm = 0;                // of the bone that the profile was taken from
  std::vector<std::string> files;     // written, relative to the output folder
  double surface_error_mm = 0;        // of the parts' STL files, at most; 0: they have all triangles
  std::vector<std::string> warnings;  // a sentence each
};

/// Runs `scene`, whose mode is slab, and writes into `folder`: scene.toml (resolved), forces.csv, slab.csv and, as the
/// scene asks, force.png, slab.png, left.stl, slice.stl, right.stl and the same as .vdb; summary.json last. The STL
/// files are reduced to `surface_error_mm`; 0: not at all. Results of an earlier run there are replaced or removed.
/// Throws Error.
SlabSummary RunSlabScene(const Scene& scene, const std::string& folder, const RunProgress& progress,
                         const RunSession& session = {}, double surface_error_mm = kSurfaceErrorMm);

std::string FormatSlabSummaryJson(const Scene& scene, const SlabSummary& summary);
/// How near the force on one tooth, the paper's in both readings, is to what was measured.
std::string DescribeSlabLaw(const Scene& scene);

}  // namespace kerf
