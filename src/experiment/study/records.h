// Results of a study: one setting on one path, its errors and its costs.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/core/log_histogram.h"
#include "base/core/percentiles.h"
#include "base/table/run_info.h"
#include "experiment/study/knobs.h"

namespace kerf {

/// How the tool is moved. kHand: coupled to a handle that follows the path (`kerf loop`); kPath: position-controlled
/// along the path (`kerf run`).
enum class Holding { kHand, kPath };
std::string_view ToString(Holding holding);  // "hand", "path"

/// Errors of the force on the hand (kHand) or on the tool (kPath), over all ticks of the path. F is the case's force, R
/// the reference's. A just-noticeable difference (JND) is 7 % of the force, where forces below 0.5 N count as 0.5 N;
/// that of the direction is 18.4 deg.
struct ErrorFigures {
  double force_l2 = 0;           // root mean square of |F - R| divided by that of |R|
  double force_worst_N = 0;      // largest |F - R|
  double force_p95 = 0;          // 95th percentile of |F - R| / max(|R|, 0.5 N)
  double force_worst = 0;        // maximum of the same ratio
  double direction_p95_deg = 0;  // between F and R where |R| > 0.5 N; 0 if there is no such tick
  double direction_worst_deg = 0;
  double impulse = 0;          // |integral of F - R| / integral of |R|
  double noise_N = 0;          // RMS of the part of F - R above 20 Hz
  double volume = 0;           // |removed volume - that of the reference| / that of the reference
  double surface_mean_mm = 0;  // symmetric distance between the cut surfaces
  double surface_p95_mm = 0;
  double surface_max_mm = 0;
  std::optional<double> breakthrough_ms;  // delay of the breakthrough (time after which the force stays below 10 % of
                                          // its peak) relative to the reference; none if there is no breakthrough
  // (integral of |F| - integral of |R|) / integral of |R|: positive if the force is too large overall, negative if too
  // small. Unset in records of versions that did not measure it.
  std::optional<double> impulse_signed;
  // Only with a heat grid: 95th percentile of the temperature error at the end of the path, 0.5 and 1 mm from the kerf,
  // where the bone is at least 1 K warmer than the body; and the part of this error that may be due to the reference
  // itself.
  std::optional<double> temperature_K;
  std::optional<double> temperature_bar_K;
};
inline constexpr double kForceJnd = 0.07;
inline constexpr double kDirectionJnd_deg = 18.4;
inline constexpr double kMinForce_N = 0.5;  // smaller forces count as this force

struct CostFigures {
  std::uint64_t ticks = 0;
  Percentiles tick;               // of all ticks; the percentiles may be too high by up to 3.2 %
  Percentiles undisturbed;        // of the ticks in which the system did not interrupt the thread
  double misses_per_million = 0;  // ticks longer than their period
  double memory_MB = 0;           // bone and simulation
  double setup_s = 0;             // time to create both
  double whole_s = 0;             // fastest pass along the path, without setup
  std::vector<std::pair<int, std::uint64_t>> histogram;  // non-empty buckets of LogHistogram and their counts
};

enum class CaseState { kDone, kFailed, kOmitted };

struct CaseRecord {
  std::string id;  // unique in the study; letters, digits, '-', '_' and '.'
  Holding holding = Holding::kHand;
  std::string path;   // name of the path
  std::string knob;   // name of the knob (knobs.h); "default" for the base settings
  std::string value;  // value of the knob as in the study file; empty for the base settings
  double number = 0;  // the value if it is a number; for the slopes
  CaseState state = CaseState::kDone;
  std::string why;  // reason for a failure or an omission
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;  // of the force of every tick
  std::uint64_t bone_hash = 0;   // 0: no bone
};

/// A reference; there is one for each path, holding, law and material of the study.
struct ReferenceRecord {
  Holding holding = Holding::kHand;
  std::string path;
  std::string variant;           // physics that differs from kerf's defaults: "law=edge_plus_chip"; empty if none
  std::uint64_t input_hash = 0;  // of the poses
  std::uint64_t force_hash = 0;
  int steps_per_tick = 0;  // of the final refinement
  double error_bar = 0;    // force_p95 between the last two refinements
  double error_bar_l2 = 0;
  double volume_bar = 0;
  double seconds = 0;  // time of the computation
  std::string note;    // e.g. that it did not converge, or how it compares with a closed form
};

struct StudyResults {
  std::string name;  // of the study file, without folder and extension
  std::string title;
  std::string command;  // command that reproduces it
  std::string commit;
  std::string build;  // compiler and flags
  RunInfo machine;
  StudySettings base;              // base settings, which the knobs vary; "default" in the records
  double seconds = 0;              // total time of the work, over all runs and shards
  std::vector<std::string> paths;  // names, in the study's order; titles below
  std::map<std::string, std::string> path_titles;
  std::vector<std::string> knobs;  // names, in the study's order
  std::vector<CaseRecord> cases;
  std::vector<ReferenceRecord> references;
};

}  // namespace kerf
