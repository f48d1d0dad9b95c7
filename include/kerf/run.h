// Runs of a whole scene: along its path, in slab mode, or with the tool in a hand.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "kerf/device.h"
#include "kerf/geometry.h"
#include "kerf/path.h"
#include "kerf/scene.h"
#include "kerf/slab.h"

namespace kerf {

/// A tick of a tool in a hand.
struct HandTick {
  double time_s = 0;  // at the end of the tick
  Pose X_WH;          // the last valid pose of the handle
  double rpm = 0;
  CoupledOutput out;
  Vec3 f_device_N{0};  // force and torque that the device received
  Vec3 tau_device_Nmm{0};
  std::uint32_t faults = 0;  // 0: none; otherwise the device received no force
};

/// What the effects of a run have reported: one row per tick.
struct ChannelRows {
  std::vector<std::string> names;  // "heat.peak_C", ...
  std::vector<double> values;      // row by row
  std::size_t rows() const { return names.empty() ? 0 : values.size() / names.size(); }
};

/// Where a replay first differed from its recording.
struct ReplayDifference {
  double time_s = 0;
  std::string what;
};

/// Results that every run has.
struct RunResults {
  Bone bone;               // after the cut; in slab mode empty
  double removed_mm3 = 0;  // exact, from the level set; 0 in slab mode
  ChannelRows channels;
  double wall_s = 0;  // of the ticks, without making the bone
  std::vector<std::string> warnings;
  std::optional<ReplayDifference> difference;  // of a replay
};

struct PathRun : RunResults {
  std::vector<TickRecord> ticks;
  std::array<double, 256> removed_mm3_by_region{};  // exact; index 0 is bone without a region
  std::vector<SlabState> slab_states;               // of each tick; only in slab mode
};

struct HandRun : RunResults {
  std::vector<HandTick> ticks;
};

struct PathRunOptions {
  std::string record;  // recording to be written; it must not exist; empty: none
  ShowProgress progress;
};

/// Runs a scene along its path, as `kerf run` does, with the same bits; in slab mode if the scene says so. Throws
/// kerf::Error.
PathRun RunAlongPath(const SceneFile& scene, const PathRunOptions& options = {});
/// Uses `bone`, with its own materials, instead of the scene's; it cannot be recorded.
PathRun RunAlongPath(const SceneFile& scene, Bone bone, const ShowProgress& progress = {});

struct HandRunOptions {
  double seconds = 10;  // 0.01 to 36000
  /// Device that moves the tool instead of the scene's simulated hand; it must outlive the run. Its capabilities are
  /// those of the scene's [device] section.
  Device* device = nullptr;
  /// True: the ticks run at the scene's rate in a thread of their own, with real-time priority where that is permitted.
  /// False: as fast as possible; each run then gives the same bits.
  bool real_time = false;
  std::string record;                       // as in PathRunOptions
  const std::atomic<bool>* stop = nullptr;  // set to true, also by the device or a signal handler, to end the run early
  ShowProgress progress;
};

/// Runs a scene with the tool in a hand, as `kerf loop` does. Throws kerf::Error.
HandRun RunInHand(const SceneFile& scene, const HandRunOptions& options = {});

}  // namespace kerf
