// `kerf tune`: the settings for a scene on this machine, the most accurate within a time or the cheapest within an
// error.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiment/study/case.h"
#include "experiment/study/phases.h"
#include "session/scene/edit_scene.h"
#include "session/scene/scene.h"

namespace kerf {

struct TuneOptions {
  Holding holding = Holding::kHand;
  std::optional<double> budget_us;  // of a tick's p99
  std::optional<double> error;      // of TuneCandidate::force_p95: 0.035
  std::optional<double> seconds;    // of the path from the first contact on, in which errors are measured, 0.2 to 3600;
                                    // none: see TuneExtent
  std::uint64_t ticks = 20000;      // that a candidate's times are measured over, at least
  std::optional<int> core;          // that they are held to
  std::vector<double> voxels_mm;    // to try; empty: those that suit the tool
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage, double fraction)> progress;
};

struct TuneCandidate {
  StudySettings settings;
  CaseOutcome outcome;   // errors and costs
  double force_p95 = 0;  // as ErrorFigures::force_p95, over the ticks with contact (CalcContactError)
  /// Errors below what the reference itself may be off by are all the same.
  double CalcError(double reference_bar) const;
  double p99_us() const { return outcome.costs ? outcome.costs->tick.p99_us : 0; }
  bool done() const { return outcome.errors && outcome.costs; }
};

/// The part of the path in which errors are measured.
enum class TuneExtent {
  kWhole,         // from the first contact to the path's end
  kFirstPassage,  // of a path too long for that: until the tool is first out of the bone again
  kSeconds,       // the seconds that were asked for
};

/// A phase of the cut, and how exact the chosen settings are in it.
struct TunePhase {
  CutPhase phase;  // path time
  double force_p95 = 0;
  double impulse_signed = 0;
};

struct TuneResult {
  std::string scene;
  Holding holding = Holding::kHand;
  double rate_hz = 0;
  MachineState machine;
  ReferenceRecord reference;
  TuneExtent extent = TuneExtent::kWhole;
  double from_s = 0;  // the stretch of the path in which errors were measured
  double to_s = 0;
  double path_s = 0;         // the path's duration; of several strokes that of those up to the first that is retracted
  std::size_t strokes = 1;   // of the scene's path
  std::size_t measured = 1;  // of these, from the first on
  std::vector<TuneCandidate> candidates;  // in the order in which they were measured; the scene's own is the first
  std::optional<std::size_t> chosen;      // none: nothing fulfils what was asked
  std::optional<TuneCandidate> again;     // the chosen one, measured anew
  bool keeps = false;                     // what was asked, measured anew
  std::vector<TunePhase> phases;          // of `again`
  std::vector<std::string> notes;
};

/// 95th percentile of |F - R| / max(|R|, kLeastForce_N) over the ticks in which a tooth meets bone in either run. Air
/// between strokes, where both are without force, does not make it smaller. 0 where there is no such tick.
double CalcContactError(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, const std::vector<bool>& contact,
                        const std::vector<bool>& reference_contact);

/// The settings that the scene has now.
StudySettings SettingsOf(const Scene& scene, Holding holding);
/// Which of the candidates fulfils what is asked: within the budget the least error (of equals the cheapest), or within
/// the error the cheapest. None: nothing does.
std::optional<std::size_t> ChooseCandidate(const std::vector<TuneCandidate>& candidates, const TuneOptions& options,
                                           double reference_bar);
/// Throws Error: for a scene that this is not for (slab mode, a ball), for options out of range.
TuneResult Tune(const std::string& scene_file, const TuneOptions& options);

/// What the chosen settings change in the scene's file; empty when it has them already.
std::vector<SceneEdit> EditsFor(const Scene& scene, Holding holding, const StudySettings& settings);
/// Which part of the path the errors are of: "the whole path (0.95 to 16.20 s)".
std::string DescribeExtent(const TuneResult& result);
/// For the note above the edit, one line: what was asked, what was measured, and over which part of the path.
std::string DescribeEvidence(const TuneResult& result, const TuneOptions& options);
/// All candidates with their figures.
std::string FormatTuneTable(const TuneResult& result);
/// `edits`: what the chosen settings change in the scene.
std::string FormatTuneJson(const TuneResult& result, const TuneOptions& options, const std::vector<SceneEdit>& edits);

}  // namespace kerf
