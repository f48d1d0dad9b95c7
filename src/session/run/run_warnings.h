// Warnings after a run along a path, for the terminal and for its summary.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "session/run/run_scene.h"
#include "session/run/run_slab_scene.h"

namespace kerf {

/// Volume removed in the first tick from which the tool counts as placed inside the bone. A disc that is placed clear
/// of the bone removes at most a thin shaving.
inline constexpr double kInBone_mm3 = 0.1;
/// Depth from which the blade of slab mode counts as placed inside the bone. The entry is known to a quarter of a
/// voxel, and a path may begin at the surface.
inline constexpr double kInBone_mm = 0.1;

/// What the ticks of a path have done.
struct TickFindings {
  bool touched = false;         // a tooth touched bone
  bool starts_in_bone = false;  // it was set down inside the bone
  std::size_t ticks_with_status = 0;
  std::size_t ticks_at_metal = 0;
  double removed_mm3 = 0;
  std::string_view tool = "saw";  // NameTool()
};

/// Returns the word for a tool in sentences: "saw" or its shape, such as "drill".
std::string_view NameTool(const Tool& tool);

/// These return the warnings, one sentence each.
std::vector<std::string> FindTickWarnings(const TickFindings& ticks);
/// About effects that cannot hold or stop a tool on a path.
std::vector<std::string> FindEffectWarnings(const EffectChoices& effects, const EffectRecord& record);
/// About walls thinner than a voxel.
std::vector<std::string> FindPieceWarnings(const Scene& scene, const PieceCounts& counts, double voxel_mm);
std::vector<std::string> FindRunWarnings(const Scene& scene, const RunSummary& summary);
std::vector<std::string> FindSlabRunWarnings(const Scene& scene, const SlabSummary& summary);

}  // namespace kerf
