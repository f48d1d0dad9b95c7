// `kerf loop`: a coupled simulation of a scene, live or as fast as possible.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "session/run/effect_files.h"
#include "session/run/effect_record.h"
#include "session/run/force_log.h"
#include "session/run/heat_report.h"
#include "session/run/loop_options.h"
#include "session/run/replay_body.h"
#include "session/run/run.h"
#include "session/run/run_scene.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

/// Results of the requested checkpoints, undo and redo.
struct UndoSummary {
  std::size_t restores = 0;
  std::size_t checkpoints = 0;  // available for undo
  double kept_MB = 0;
  double longest_ms = 0;  // live: longest restore, from request to completion
};

/// Result of recording a session.
struct LoopRecorded {
  std::string path;
  std::uint64_t bytes = 0;
  std::uint64_t steps = 0;
  std::string failure;  // one sentence; empty if the recording is whole
};

/// Bar of a histogram: `count` durations were between `lower_us` and `upper_us`.
struct LoopBar {
  double lower_us = 0;
  double upper_us = 0;
  std::uint64_t count = 0;
};

struct LoopForceSummary {
  double largest_N = 0;                    // on the device
  double largest_step_N = 0;               // from tick to tick, on the device
  double slew_bound_N = 0;                 // maximum step per tick that the force map permits
  double largest_simulated_N = 0;          // on the hand, before scaling for the device
  double noise_above_20_Hz_mN = 0;         // on the device, RMS over the whole run
  std::optional<double> cutting_noise_mN;  // largest value in any whole second of uninterrupted cutting
  double scale = 1;                        // device N per simulation N
};

struct LoopSummary {
  // settings
  double seconds = 0;
  double rate_hz = 0;
  bool virtual_time = false;
  std::string device;
  std::string hand;  // empty: no simulated hand
  LoopSetup setup;
  // results
  std::optional<Replayed> replayed;
  std::optional<LoopRecorded> recorded;
  std::optional<UndoSummary> undo;
  LoopEnd end = LoopEnd::kNotYet;
  std::string failure;
  RealtimeGrants grants;
  LoopCounts counts;
  ForceCounts device_counts;
  std::vector<std::pair<std::string, double>> device_figures;  // LoopDevice::figures
  long watchdog_trips = 0;
  double simulated_s = 0;
  double wall_s = 0;
  PartTimes tick;
  PartTimes lateness;
  std::vector<PartTimes> stages;
  std::optional<StageCosts> costs;
  std::vector<LoopBar> tick_bars;
  std::vector<LoopBar> lateness_bars;
  std::vector<FidelityStep> fidelity_steps;
  long fidelity_step_count = 0;
  LoopForceSummary force;
  // Of a hand that follows the scene's path, otherwise 0:
  long passes = 0;         // number of times that it has completed the path
  long strokes = 0;        // begun
  double removed_mm3 = 0;  // exact, from the level set
  double volume_before_mm3 = 0;
  double volume_after_mm3 = 0;          // of the bone without the pieces taken out of it
  double removed_by_occupancy_mm3 = 0;  // sum over the ticks
  // hand + spindle = stored + cut + friction + damping + numerical
  double hand_J = 0;
  double spindle_J = 0;
  double stored_J = 0;
  double cut_J = 0;
  double friction_J = 0;
  double damping_J = 0;
  double numerical_J = 0;
  CuttingSums cutting_sums;                // without removed_mm3
  std::optional<CuttingEnergy> cutting;    // none if ticks were undone or came from a recording
  bool touched = false;                    // the tool touched bone at least once
  std::optional<double> leaves_used_up_s;  // time at which the last spare leaf was used
  std::optional<double> metal_touched_s;   // time at which the turning edge first touched metal
  bool starts_in_bone = false;             // the tool was placed inside the bone
  std::vector<PieceSummary> pieces;
  PieceCounts piece_counts;
  std::vector<std::string> warnings;
  std::uint64_t bone_hash = 0;
  std::uint64_t force_hash = 0;   // of all ticks' forces and poses
  bool mirror_identical = false;  // the reader's bone, made from the published leaves, is identical
  std::size_t leaves_sent = 0;
  MaterialSummary material;
  std::optional<HeatReport> heat;
  std::optional<FragmentsReport> fragments;
  EffectFiles effect_files;
  EffectRecord effects;                 // with one row per entry of `rows`
  std::vector<LoopRow> rows;            // every `forces_every_ticks`th, with LoopLog::kMemory
  ForceCurve force_curve;               // of these rows, even if they are not kept
  std::unique_ptr<ForceLog> force_log;  // with LoopLog::kFolder: forces.csv, which WriteLoopReport completes
  // With `keep_bones`; with `keep_last` only `after`, and no volumes, pieces and `mirror_identical`:
  Bone before;
  Bone after;
  std::vector<Bone> piece_bones;
  std::vector<double> piece_volumes_mm3;  // of these
  Bone dust;
  std::vector<TickRecord> moments;  // first contact, largest force, last contact, each with the tick before it
  std::vector<std::string> files;   // written by WriteLoopReport
  double surface_error_mm = 0;      // maximum error of the surfaces in the pieces' files; 0: not reduced
};

/// Makes the scene's bone and runs its tool, coupled to its hand, for `options.seconds`. `progress` is called with the
/// name of a stage and its completed fraction, 0 to 1. Throws kerf::Error for slab mode, an unknown device or hand, or
/// parameters out of range.
LoopSummary RunLoop(const Scene& scene, const LoopOptions& options,
                    const std::function<void(const std::string&, double)>& progress);

/// Returns the fraction of the energy supplied by the hand and the spindle that was lost to the finite time step; 0 if
/// no energy was supplied. Negative if springs of the contact got back energy that the cut had lost (docs/tick.md).
double CalcNumericalFraction(const LoopSummary& s);
/// Adds warnings about the session as a whole: the tool touched no bone or started inside it, more than a tenth of the
/// energy was lost to the time step, or all `spare_leaves` spare leaves were used up.
void AddLoopWarnings(LoopSummary& s, int spare_leaves);

/// The following functions return readable phrases, such as
/// "omega_6 in the hand H3" or "falcon".
std::string DescribeDeviceAndHand(const LoopSummary& summary);
std::string DescribeDeviceFigures(const LoopSummary& summary);
std::string DescribeRemoved(const LoopSummary& summary);
std::string DescribeStrokes(const LoopSummary& summary);  // "" if the hand does not follow the path
std::string DescribePieces(const LoopSummary& summary);
std::string DescribeEnergy(const LoopSummary& summary);
std::string DescribeNoise(const LoopSummary& summary);

/// Returns JSON with stable keys that include the units.
std::string FormatLoopJson(const Scene& scene, const LoopSummary& summary);
/// Returns one row per logged tick, with the units in the header.
std::string FormatLoopCsv(const LoopSummary& summary);
/// Returns a readable report in Markdown. `pictures`: include the pictures that WriteLoopReport makes.
std::string FormatLoopReport(const Scene& scene, const LoopSummary& summary, bool pictures);
/// Writes report.md, loop.json, forces.csv, force.png, scene.toml (resolved) and, live, lateness.png into `folder`,
/// which is created if missing. After a run with `keep_bones` also writes, as the scene requests, bone.vdb,
/// piece_N.stl, before.png, after.png, cut.png, apart.png, heat.png and fragments.png, and the files of the effects
/// (EffectFiles). The pieces' surfaces are simplified with an error of at most `surface_error_mm`; 0: not simplified.
/// Results of an earlier loop in the same folder are replaced or removed. Sets `summary.files` and the data of the
/// pieces' files.
void WriteLoopReport(const Scene& scene, LoopSummary& summary, const std::string& folder,
                     const std::function<void(const std::string&, double)>& progress = {},
                     double surface_error_mm = kSurfaceErrorMm);
/// Throws kerf::Error if a result would replace one of the run's inputs.
void CheckLoopInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder);

}  // namespace kerf
