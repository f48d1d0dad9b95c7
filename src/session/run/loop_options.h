// Options of a coupled session.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cut/undo/journal.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/haptics/loop_device.h"
#include "loop/haptics/step_body.h"
#include "loop/record/recording.h"
#include "session/run/loop_setup.h"
#include "session/run/loop_undo.h"
#include "session/run/make_bone.h"
#include "session/run/session_controller.h"
#include "session/run/stage_costs.h"

namespace kerf {

/// Destination of the rows of forces.csv and of the sound during the loop.
enum class LoopLog : std::uint8_t {
  kMemory,  // in the summary, for at most kMaxTicksInMemory ticks
  kFolder,  // in files in LoopOutput::folder, so that memory does not grow with the run
  kNone,
};

/// Maximum duration of a loop: ten hours. For longer work, save the bone and start a new loop.
inline constexpr double kMaxLoop_s = 36'000;
/// Maximum number of ticks with LoopLog::kMemory. Each takes 200 bytes, plus the effects' channels.
inline constexpr double kMaxTicksInMemory = 10'000'000;

/// A recorded session to replay, and whether a new session then continues it.
struct LoopReplayOptions {
  RecordingReader* recording = nullptr;  // null: none
  double until_s = std::numeric_limits<double>::infinity();
  bool continues = false;  // afterwards the scene's hand continues for LoopOptions::seconds
  bool verify = false;     // stop at the first divergence
  double speed = 0;        // multiple of real time; 0: as fast as possible
};

/// Makes the hand that replaces the scene's own hand, which follows the path. It moves the device with
/// SimulatedDevice::SetIntention before each tick, as a mouse or a synthetic surgeon does. `p_TC_mm`: the coupling's
/// point in the tool frame, where the device holds the tool. `felt_stiffness_N_per_mm`: stiffness of the coupling as
/// rendered on the device.
using MakeHand = std::function<std::unique_ptr<HandDriver>(SimulatedDevice& device, const LoopSetup& setup,
                                                           const Vec3& p_TC_mm, double felt_stiffness_N_per_mm)>;

/// Called in the thread that steps the session. `channels`: the effects' channels.
using TakeTick = std::function<void(const LoopTick& sample, std::span<const double> channels)>;

/// Called between two ticks, outside the heap guard. `wall_us`: duration of the tick, including the simulated hand and
/// device and the exchange with other threads.
using WatchTick = std::function<void(double wall_us, const LoopTick& tick, CoupledSimulation& simulation)>;

/// What is kept and written while the loop runs.
struct LoopOutput {
  LoopLog log = LoopLog::kMemory;
  std::string folder;            // with kFolder: must exist; pass it to WriteLoopReport too
  bool keep_bones = false;       // keep the bones in the summary, for WriteLoopReport
  bool keep_last = false;        // without keep_bones: keep only LoopSummary::after, and do not separate its pieces
  bool keep_on_failure = false;  // with keep_last: an exception inside the loop ends it with LoopSummary::failure
  std::string record;            // a new file; empty: none
  std::string scene_file;        // path of the scene, stored in a recording
};

/// Checkpoints, undo and redo at given times.
struct LoopUndoOptions {
  std::vector<LoopAction> actions;  // in order of time
  double max_MB = UndoParams{}.max_MB;
};
template <typename V>
void Describe(LoopUndoOptions& p, V&& visit) {
  DescribeUndoMemory(p, visit);
}

/// What moves the tool; with neither, the scene's hand along its path.
struct LoopDriver {
  MakeHand make_hand;  // replaces the scene's hand
  LoopDevice device;   // replaces the simulated device; not with make_hand
};

/// What observes the loop; each is optional.
struct LoopWatchers {
  TakeTick take_tick;                 // called with each logged tick, in order
  WatchTick watch_tick;               // in virtual time only
  SessionController* peer = nullptr;  // live only
};

struct LoopOptions {
  double seconds = 10;
  ReadSceneBone read_bone;                  // replaces the reading of the scene's bone file; optional
  bool virtual_time = false;                // without threads; each run gives bit-identical results
  double burn_us = 0;                       // fault injection
  int spare_leaves = 8192;                  // kept for cutting while the loop runs; see SupplyLeaves()
  const std::atomic<bool>* stop = nullptr;  // ends the run early; optional
  CostOptions costs;                        // not in virtual time
  LoopOutput output;
  LoopReplayOptions replay;
  LoopUndoOptions undo;
  LoopDriver driver;
  LoopWatchers watchers;
};

template <typename V>
void Describe(LoopOptions& p, V&& visit) {
  visit("seconds", p.seconds, Range{0.01, kMaxLoop_s}, "duration");
  visit("burn_us", p.burn_us, kBurnRange_us,
        "time to waste in each tick of the middle third (half of it in coarse ticks, a tenth in slab ticks), to test "
        "[loop] degrade");
}

}  // namespace kerf
