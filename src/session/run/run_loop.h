// `kerf loop`: a scene in a hand, live or as fast as it goes.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/devices/simulated_device.h"
#include "kerf/bone.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/haptics/loop_device.h"
#include "loop/haptics/step_body.h"
#include "session/run/effect_files.h"
#include "session/run/effect_record.h"
#include "session/run/force_log.h"
#include "session/run/heat_report.h"
#include "session/run/loop_peer.h"
#include "session/run/loop_setup.h"
#include "session/run/loop_undo.h"
#include "session/run/loop_watch.h"
#include "session/run/replay_body.h"
#include "session/run/run.h"
#include "session/run/run_scene.h"
#include "session/run/scene_material.h"
#include "session/run/stage_costs.h"
#include "session/scene/scene.h"

namespace kerf {

/// Where the rows of forces.csv and the sound go while the loop runs.
enum class LoopLog : std::uint8_t {
  kMemory,  // into the summary, for at most kMostTicksInMemory ticks
  kFolder,  // into files of LoopOptions::folder: memory does not grow with the run
  kNowhere,
};

/// Of one loop: ten hours. Whoever works longer saves and begins again.
inline constexpr double kMostLoop_s = 36'000;
/// 200 bytes each, and the effects' figures.
inline constexpr double kMostTicksInMemory = 10'000'000;

/// A recorded session to go through, alone or before a new one goes on from there.
struct LoopReplayOptions {
  RecordingReader* recording = nullptr;  // null: none
  double until_s = std::numeric_limits<double>::infinity();
  bool goes_on = false;  // afterwards the scene's hand has it for LoopOptions::seconds
  bool verify = false;   // stop where something else comes out
  double speed = 0;      // of real time; 0: as fast as it goes
};

/// Checkpoints, undo and redo that were asked for.
struct LoopUndone {
  std::size_t restores = 0;
  std::size_t checkpoints = 0;  // that can be gone back to
  double kept_MB = 0;
  double longest_ms = 0;  // live: from asking to the bone being there
};

/// Of a recording that was made.
struct LoopRecorded {
  std::string path;
  std::uint64_t bytes = 0;
  std::uint64_t steps = 0;
  std::string failure;  // a sentence; empty when it is whole
};

/// In place of the simulated hand that goes along the scene's path: whoever moves the device by
/// SimulatedDevice::SetIntention before each tick, as a mouse or a synthetic surgeon does. `p_TC_mm`: the coupling's
/// point in the tool frame, where the device holds the tool. `felt_stiffness_N_per_mm`: the coupling's, as the device
/// feels it.
using MakeHand = std::function<std::unique_ptr<BeforeTick>(SimulatedDevice& device, const LoopSetup& setup,
                                                           const Vec3& p_TC_mm, double felt_stiffness_N_per_mm)>;

/// Called in the thread that RunLoop runs in. `channels`: the effects' figures.
using TakeTick = std::function<void(const LoopSample& sample, std::span<const double> channels)>;

struct LoopOptions {
  double seconds = 10;  // 0.01 to kMostLoop_s
  LoopLog log = LoopLog::kMemory;
  std::string folder;                       // with kFolder: is there, and WriteLoopReport gets the same
  bool virtual_time = false;                // without the clock and without threads: the same bits each time
  double burn_us = 0;                       // fault injection: burnt in each tick of the middle third, 0 to 1e5
  bool keep_bones = false;                  // in the summary, for WriteLoopReport
  const std::atomic<bool>* stop = nullptr;  // ends the run early; may be null
  CostOptions costs;                        // not without the clock
  std::string record;                       // a file that is not there yet; empty: none
  std::string scene_file;                   // of the scene, for a recording to name
  LoopReplayOptions replay;
  std::vector<LoopAction> actions;  // checkpoints, undo and redo, in the order of their moments
  double undo_MB = 256;             // kept for them at most: 0.2 to 1e6
  TakeTick take_tick;               // told each tick that is logged, in order; may be empty
  LoopWatch* watch = nullptr;       // without the clock only; may be null
  MakeHand make_hand;               // empty: the scene's hand along its path
  LoopDevice device;                // in place of the simulated one; without make_hand
  LoopPeer* peer = nullptr;         // live only; may be null
};

struct LoopTimeSummary {
  std::string name;
  std::uint64_t count = 0;
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
  double mean_us = 0;
};

/// Bars of a histogram: times from `lower_us` to the next one's, and how many.
struct LoopBar {
  double lower_us = 0;
  double upper_us = 0;
  std::uint64_t count = 0;
};

struct LoopForceSummary {
  double largest_N = 0;                    // on the device
  double largest_step_N = 0;               // from tick to tick, on the device
  double slew_bound_N = 0;                 // that the profile of forces allows in a tick
  double largest_simulated_N = 0;          // on the hand, before it is scaled to the device
  double noise_above_20_Hz_mN = 0;         // on the device, RMS over the whole run
  std::optional<double> cutting_noise_mN;  // the largest of the whole seconds in which the tool cut throughout
  double scale = 1;                        // device N per simulation N
};

struct LoopSummary {
  // asked for
  double seconds = 0;
  double rate_hz = 0;
  bool virtual_time = false;
  std::string device;
  std::string hand;  // empty: it was no simulated one
  LoopSetup setup;
  // what happened
  std::optional<Replayed> replayed;
  std::optional<LoopRecorded> recorded;
  std::optional<LoopUndone> undone;
  LoopEnd end = LoopEnd::kNotYet;
  std::string failure;
  RealtimeGrants grants;
  LoopCounts counts;
  ForceCounts device_counts;
  std::vector<std::pair<std::string, double>> served;  // LoopDevice::figures
  long watchdog_trips = 0;
  double simulated_s = 0;
  double wall_s = 0;
  LoopTimeSummary tick;
  LoopTimeSummary lateness;
  std::vector<LoopTimeSummary> stages;
  std::optional<StageCosts> costs;
  std::vector<LoopBar> tick_bars;
  std::vector<LoopBar> lateness_bars;
  std::vector<FidelityStep> fidelity_steps;
  long fidelity_step_count = 0;
  LoopForceSummary force;
  long rounds = 0;  // of the hand through the path
  long strokes = 0;
  double removed_mm3 = 0;  // exact, of the level set
  double volume_before_mm3 = 0;
  double volume_after_mm3 = 0;          // in the bone: without what was taken out
  double removed_by_occupancy_mm3 = 0;  // what the ticks add up to
  // hand + spindle = stored + cut + friction + damping + numerical
  double hand_J = 0;
  double spindle_J = 0;
  double stored_J = 0;
  double cut_J = 0;
  double friction_J = 0;
  double damping_J = 0;
  double numerical_J = 0;
  CuttingSums cutting_sums;                // without removed_mm3
  std::optional<CuttingEnergy> cutting;    // none where ticks were taken back, or came from a recording
  bool touched = false;                    // the tool ever met bone
  std::optional<double> leaves_used_up_s;  // when no block of voxels was left to cut into
  bool starts_in_bone = false;             // it was set down there
  std::vector<PieceSummary> pieces;
  std::size_t dust_count = 0;
  double dust_mm3 = 0;
  std::vector<std::string> warnings;
  std::uint64_t bone_hash = 0;
  std::uint64_t force_hash = 0;   // of every tick's forces and poses
  bool mirror_identical = false;  // a reader's copy of the bone, made from the published leaves, is the bone
  std::size_t leaves_sent = 0;
  MaterialSummary material;
  std::optional<HeatReport> heat;
  std::optional<FragmentsReport> fragments;
  EffectFiles effect_files;
  EffectRecord effects;                 // a row of it for each of the next
  std::vector<LoopRow> rows;            // every `forces_every_ticks`th, with LoopLog::kMemory
  ForceCurve force_curve;               // of these rows, kept or not
  std::unique_ptr<ForceLog> force_log;  // with LoopLog::kFolder: forces.csv, which WriteLoopReport gives its name
  // With `keep_bones`:
  Bone before;
  Bone after;
  std::vector<Bone> piece_bones;
  std::vector<TickRecord> moments;  // first contact, largest force, last contact, each with the tick before it
  std::vector<std::string> files;   // that WriteLoopReport wrote
  double surface_error_mm = 0;      // of the pieces' files, at most; 0: they have all triangles
};

/// Builds the scene's bone and runs its tool in its hand for so long. `progress` gets a stage's name and 0..1. Throws
/// Error: for slab mode, a device or hand that there is none of, parameters out of range.
LoopSummary RunLoop(const Scene& scene, const LoopOptions& options,
                    const std::function<void(const std::string&, double)>& progress);

/// Of the energy that hand and spindle put in, what the finite steps lost; 0 when nothing was put in.
double CalcNumericalShare(const LoopSummary& s);
/// What a user should know of the session as a whole: no bone met, more than a tenth of the energy lost to the time
/// step, `spare_leaves` blocks for cutting used up, begun inside the bone.
void AddLoopWarnings(LoopSummary& s, int spare_leaves);

/// For people, a phrase each.
/// "omega_6 in the hand H3", "falcon".
std::string DescribeHeld(const LoopSummary& summary);
std::string DescribeServed(const LoopSummary& summary);
std::string DescribeRemoved(const LoopSummary& summary);
std::string DescribeStrokes(const LoopSummary& summary);
std::string DescribePieces(const LoopSummary& summary);
std::string DescribeEnergy(const LoopSummary& summary);
std::string DescribeNoise(const LoopSummary& summary);

/// Stable keys with units.
std::string FormatLoopJson(const Scene& scene, const LoopSummary& summary);
/// A row for each tick, or for every n-th; units in the header.
std::string FormatLoopCsv(const LoopSummary& summary);
/// For people, Markdown. `pictures`: with the pictures that WriteLoopReport makes.
std::string FormatLoopReport(const Scene& scene, const LoopSummary& summary, bool pictures);
/// report.md, loop.json, forces.csv, force.png, scene.toml (resolved) and, live, lateness.png in `folder`, made when
/// missing; from a run with `keep_bones`, as the scene asks, also bone.vdb, piece_N.stl, before.png, after.png,
/// cut.png, apart.png, heat.png and fragments.png; what its effects leave (EffectFiles). The pieces' surfaces are
/// reduced to `surface_error_mm`; 0: not at all. Results of an earlier loop in the same folder are replaced or removed.
/// Fills `summary.files` and what there is of the pieces' files.
void WriteLoopReport(const Scene& scene, LoopSummary& summary, const std::string& folder,
                     const std::function<void(const std::string&, double)>& progress = {},
                     double surface_error_mm = kSurfaceErrorMm);
/// Throws Error when one of them would replace one of the run's own inputs.
void CheckLoopInputsStay(const Scene& scene, const std::string& scene_file, const std::string& folder);

}  // namespace kerf
