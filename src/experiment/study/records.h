// What a study measures: one setting on one path, its errors and its costs.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/core/log_histogram.h"
#include "experiment/bench/measure.h"
#include "experiment/study/knobs.h"

namespace kerf {

/// How the tool is moved. kHand: tied to a handle that follows the path (`kerf loop`); kPath: on the path itself
/// (`kerf run`).
enum class Holding { kHand, kPath };
std::string_view ToString(Holding holding);  // "hand", "path"

/// Of the force on the hand (kHand) or on the tool (kPath), over all ticks of the path; F is the case's, R the
/// reference's. A just-noticeable difference (JND) is 7 % of the force, of at least 0.5 N; of the direction 18.4 deg.
struct ErrorFigures {
  double force_l2 = 0;           // |F - R| / |R|, root mean squares
  double force_worst_N = 0;      // largest |F - R|
  double force_p95 = 0;          // 95th percentile of |F - R| / max(|R|, 0.5 N)
  double force_worst = 0;        // largest of that
  double direction_p95_deg = 0;  // between F and R where |R| > 0.5 N; 0 when nowhere
  double direction_worst_deg = 0;
  double impulse = 0;          // |integral of F - R| / integral of |R|
  double noise_N = 0;          // RMS of what F - R has above 20 Hz
  double volume = 0;           // |removed volume - reference's| / reference's
  double surface_mean_mm = 0;  // symmetric distance between the cut surfaces
  double surface_p95_mm = 0;
  double surface_max_mm = 0;
  std::optional<double> breakthrough_ms;  // how much too late the bone gives way (the force falls below 10 % of its
                                          // peak for good); none where it does not
  // (integral of |F| - integral of |R|) / integral of |R|: above 0 the force is too large in all, below too small. None
  // in records of versions before it was measured.
  std::optional<double> impulse_signed;
  // With a heat grid only: 95th percentile of the error of the temperature at the end of the path, 0.5 and 1 mm beside
  // the kerf where that is a kelvin warmer than the body, and what of it may be the reference's own.
  std::optional<double> temperature_K;
  std::optional<double> temperature_bar_K;
};
inline constexpr double kForceJnd = 0.07;
inline constexpr double kDirectionJnd_deg = 18.4;
inline constexpr double kLeastForce_N = 0.5;  // forces below are judged as this

struct CostFigures {
  std::uint64_t ticks = 0;
  Percentiles tick;                                      // of all ticks; percentiles up to 3.2 % too high
  Percentiles undisturbed;                               // of those in which the system did not take the core away
  double misses_per_million = 0;                         // ticks longer than the time from tick to tick
  double memory_MB = 0;                                  // bone and simulation
  double setup_s = 0;                                    // making both
  double whole_s = 0;                                    // one pass of the path, setup left out
  std::vector<std::pair<int, std::uint64_t>> histogram;  // bucket of LogHistogram and its count, those not empty
};

enum class CaseState { kDone, kFailed, kOmitted };

struct CaseRecord {
  std::string id;  // unique in the study; letters, digits, '-', '_' and '.'
  Holding holding = Holding::kHand;
  std::string path;   // its name
  std::string knob;   // its name (accuracy/knobs.h); "default" for the base settings
  std::string value;  // of the knob as the study file has it; empty for the base settings
  double number = 0;  // the value as a number where it is one; for the slopes
  CaseState state = CaseState::kDone;
  std::string why;  // failed or left out
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;  // of every tick's force
  std::uint64_t bone_hash = 0;   // 0: no bone
};

/// A reference, one for each path, holding, law and material that the study asks for.
struct ReferenceRecord {
  Holding holding = Holding::kHand;
  std::string path;
  std::string variant;  // what of the physics differs from what kerf ships: "law=edge_plus_chip"; empty: nothing
  std::uint64_t input_hash = 0;  // of the poses
  std::uint64_t force_hash = 0;
  int steps_per_tick = 0;  // at which it was taken
  double error_bar = 0;    // force_p95 between the last two refinements
  double error_bar_l2 = 0;
  double volume_bar = 0;
  double seconds = 0;  // what it took to work out
  std::string note;    // not converged, closed form compared with, ...
};

struct StudyResults {
  std::string name;  // of the study file, without folder and extension
  std::string title;
  std::string command;  // that makes it again
  std::string commit;
  std::string build;  // compiler and flags
  MachineState machine;
  StudySettings base;              // that the knobs are turned from: the records' "default"
  double seconds = 0;              // of work, over all sessions and shards
  std::vector<std::string> paths;  // names, in the study's order; titles below
  std::map<std::string, std::string> path_titles;
  std::vector<std::string> knobs;  // names, in the study's order
  std::vector<CaseRecord> cases;
  std::vector<ReferenceRecord> references;
};

}  // namespace kerf
