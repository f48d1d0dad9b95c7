// Runs a scene in slab mode, tick by tick: the hand follows the path exactly and the slice follows the hand.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kerf/slab.h"
#include "session/run/run.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

struct SlabRun {
  SlabProfile profile;
  std::vector<TickRecord> ticks;  // X_WT: of the hand; touched: the blade has touched the slice; travel_mm: its depth
  std::vector<SlabState> states;  // at the end of each tick
  Percentiles times;
  double wall_s = 0;               // of the ticks alone
  std::uint64_t memory_bytes = 0;  // memory for the ticks: profile, law and state
};

/// Computes the slice's profile with `scene.slab.depth_by`. The bone is not needed afterwards. Throws kerf::Error if
/// the disc's plane and the cut direction do not match, or if there is no bone in the cut.
SlabProfile MakeSlabProfile(const Scene& scene, const Bone& bone);

/// Returns the depth of the blade's edge below the first bone, mm, when the disc's centre is at `p_W`.
double CalcBladeDepth(const SlabProfile& profile, const SlabParams& params, const Vec3& p_W);

/// Runs all ticks of the scene's path. `progress` (optional) is called with values from 0 to 1. Throws kerf::Error if a
/// parameter is out of range.
SlabRun RunSlab(const Scene& scene, SlabProfile profile, const std::function<void(double)>& progress,
                const PathTape& tape = {});

/// A row of slab.csv.
struct SlabRow {
  double time_s = 0;
  SlabState state;
};
const Columns<SlabRow>& SlabColumns();
/// Returns one row per tick (or per `every` ticks): displacements, depth and energies. docs/formats.md describes the
/// columns.
std::string FormatSlabLog(const SlabRun& run, int every);

}  // namespace kerf
