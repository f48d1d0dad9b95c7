// A scene in slab mode, tick by tick: the hand follows the path exactly and the slice follows the hand.
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
  std::vector<TickRecord> ticks;  // X_WT is the hand's; touched: the blade has met the slice; travel_mm its depth
  std::vector<SlabState> states;  // at the end of each tick
  TickTimes times;
  double wall_s = 0;               // of the ticks alone
  std::uint64_t memory_bytes = 0;  // what the ticks need: profile, law and state
};

/// The slice's profile by `scene.slab.depth_by`. The bone is not needed afterwards. Throws Error when the disc's plane
/// and the cut direction don't fit together, or no bone is there.
SlabProfile MakeSlabProfile(const Scene& scene, const Bone& bone);

/// Depth of the blade's edge below the first bone when the disc's centre is at `p_W`, mm.
double CalcBladeDepth(const SlabProfile& profile, const SlabParams& params, const Vec3& p_W);

/// Runs all ticks of the scene's path. `progress` gets 0..1; may be empty. Throws Error for parameters out of range.
/// `tap` may be null.
SlabRun RunSlab(const Scene& scene, SlabProfile profile, const std::function<void(double)>& progress,
                RunTap* tap = nullptr);

/// One row a tick (or every `every`th): displacements, depth and energies. docs/formats.md says what each column is.
std::string FormatSlabLog(const SlabRun& run, int every);

}  // namespace kerf
