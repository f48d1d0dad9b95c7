// `kerf tune`: finds the settings for a scene on this machine, either the most accurate ones within a time budget or
// the cheapest ones within an error limit.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiment/bench/measure.h"
#include "experiment/study/case.h"
#include "experiment/study/phases.h"
#include "session/scene/edit_scene.h"
#include "session/scene/scene.h"

namespace kerf {

struct TuneOptions {
  Holding holding = Holding::kHand;
  std::optional<double> budget_us;
  std::optional<double> error;    // limit for TuneCandidate::force_p95, e.g. 0.035
  std::optional<double> seconds;  // if unset, see TuneExtent
  std::uint64_t ticks = 20000;
  std::optional<int> core;
  std::vector<double> voxels_mm;  // if empty, 0.4 to 0.05 mm
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage, double fraction)> progress;
};

template <typename V>
void Describe(TuneOptions& p, V&& visit) {
  visit("budget_us", p.budget_us, Range{1, 1e6}, "time limit for 99 % of the ticks");
  visit("error", p.error, Range{1e-4, 1}, "force error limit for 95 % of the ticks");
  visit("seconds", p.seconds, Range{0.2, 3600},
        "time after the first contact over which errors are measured; default: the whole path, or the first passage "
        "through the bone if the path takes more than 120 s");
  visit("ticks", p.ticks, Range{1000, 1e7}, "minimum number of ticks timed with each setting");
  visit("voxels_mm", p.voxels_mm, kVoxelRange_mm, "voxel sizes to try, separated by commas; default: 0.4 to 0.05");
  DescribeCore(p.core, visit);
}

struct TuneCandidate {
  StudySettings settings;
  CaseOutcome outcome;   // errors and costs
  double force_p95 = 0;  // as ErrorFigures::force_p95, over the ticks with contact (CalcContactError)
  /// Returns the error, but at least that of the reference: smaller errors are treated as equal.
  double CalcError(double reference_bar) const;
  double p99_us() const { return outcome.costs ? outcome.costs->tick.p99_us : 0; }
  bool done() const { return outcome.errors && outcome.costs; }
};

/// The part of the path in which errors are measured.
enum class TuneExtent {
  kWhole,         // from the first contact to the end of the path
  kFirstPassage,  // if the path is too long for that: until the tool has left the bone for the first time
  kSeconds,       // the requested number of seconds
};

/// A phase of the cut, and the accuracy of the chosen settings in it.
struct TunePhase {
  CutPhase phase;  // path time
  double force_p95 = 0;
  double impulse_signed = 0;
};

struct TuneResult {
  std::string scene;
  Holding holding = Holding::kHand;
  double rate_hz = 0;
  RunInfo machine;
  ReferenceRecord reference;
  TuneExtent extent = TuneExtent::kWhole;
  double from_s = 0;  // the part of the path in which errors were measured
  double to_s = 0;
  double path_s = 0;                      // duration of the scene's path, all strokes
  std::size_t strokes = 1;                // of the scene's path
  std::size_t measured = 1;               // number of strokes, from the first, that were measured
  std::vector<TuneCandidate> candidates;  // in the order of measurement; the scene's own settings are the first
  std::optional<std::size_t> chosen;      // unset if no candidate meets the request
  std::optional<TuneCandidate> again;     // second measurement of the chosen candidate
  bool keeps = false;                     // true if the second measurement meets the request
  std::vector<TunePhase> phases;          // of `again`
  std::vector<std::string> notes;
};

/// Returns the 95th percentile of |F - R| / max(|R|, kMinForce_N) over the ticks in which a tooth touches bone in
/// either run, or 0 if there is no such tick. Ticks in air between strokes, where both forces are 0, therefore do not
/// lower it.
double CalcContactError(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, const std::vector<bool>& contact,
                        const std::vector<bool>& reference_contact);

/// Returns the scene's present settings.
StudySettings SettingsOf(const Scene& scene, Holding holding);
/// Returns the candidate that best meets the request. With an error limit, this is the cheapest one. Otherwise, among
/// the candidates with at most 1.05 times the smallest error, it is the one with the finest rim, then the shortest
/// interval between removals, then the lowest time. Returns nullopt if there is none.
std::optional<std::size_t> ChooseCandidate(const std::vector<TuneCandidate>& candidates, const TuneOptions& options,
                                           double reference_bar);
/// Throws Error for a scene that is not supported (slab mode, a ball) and for options out of range.
TuneResult Tune(const std::string& scene_file, const TuneOptions& options);

/// Returns the edits of the scene file that apply the chosen settings; empty if it has them already.
std::vector<SceneEdit> EditsFor(const Scene& scene, Holding holding, const StudySettings& settings);
/// Describes the part of the path in which errors were measured: "the whole path (0.95 to 16.20 s)".
std::string DescribeExtent(const TuneResult& result);
/// Returns one line for the note above the edit: the request, the measurement, and the part of the path.
std::string DescribeEvidence(const TuneResult& result, const TuneOptions& options);
/// Formats all candidates and their figures as a table.
std::string FormatTuneTable(const TuneResult& result);
/// `edits`: the changes to the scene that apply the chosen settings.
std::string FormatTuneJson(const TuneResult& result, const TuneOptions& options, const std::vector<SceneEdit>& edits);

}  // namespace kerf
