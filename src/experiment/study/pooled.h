// The settings of a study, with their results pooled over all its paths: the data for diagrams, tables and sentences.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiment/bench/slope.h"
#include "experiment/study/records.h"

namespace kerf {

inline constexpr double kTargetForce = 0.5 * kForceJnd;  // 3.5 %
inline constexpr double kTargetDirection_deg = 9;
inline constexpr double kTargetVolume = 0.01;
inline constexpr double kTargetP99_us = 300;

/// Smaller errors of the force, as a fraction, are given as at most this: far below what is felt or measured, and above
/// rounding.
inline constexpr double kFinestError = 1e-5;

/// An error that may be quoted because it is never smaller than the error of its reference.
struct SafeError {
  double value = 0;
  bool at_most = false;  // true if the error is not above its error bar; `value` is then that bar
};

/// A setting's errors and times on several paths. Times are per millisecond of simulated time, i.e. the time of a tick
/// times ticks per second / 1000. Settings with different rates can thus be compared, and 1000 us is the total time
/// available.
struct PooledSetting {
  std::string knob;
  std::string value;
  double number = 0;  // of the knob; the defaults have one only on a knob's curve, otherwise 0
  bool is_default = false;
  std::size_t paths = 0;  // number of paths with results
  bool complete = false;  // true if it has results on all paths on which the defaults have
  bool timed = false;     // true if it has times on all of `paths`
  // True if it is complete and timed, does not change the physics, and the machine was idle. Only such settings are on
  // the Pareto front and compared by their times.
  bool ranked = false;
  SafeError worst;   // force_p95 on the path on which it is largest
  SafeError median;  // over the paths
  std::string worst_path;
  double p50_us = 0;   // median over the paths
  double p99_us = 0;   // of the slowest path
  double p999_us = 0;  // of the slowest path
  std::string slowest_path;
  std::vector<const CaseRecord*> cases;

  /// Returns a name such as "voxel_mm = 0.05" or "the defaults".
  std::string Name() const;
};

/// Returns true if other programs may have slowed some settings more than others: the load before the run was more than
/// a quarter of the cores. No setting is ranked then.
bool WasBusy(const RunInfo& machine);
/// Returns true if the knob determines what is simulated rather than how accurately: its settings have their own
/// references, or no fair one.
bool ChoosesPhysics(const std::string& knob);
/// Returns a knob's number in the settings, or 0 if its value is a word. Throws Error for an unknown knob.
double NumberOf(const StudySettings& settings, const std::string& knob);
/// Lists the base settings that differ from kerf's defaults: "`voxel_mm = 0.2`, `law = ...`"; empty if there are none.
std::string DescribeBase(const StudySettings& base);
/// Returns the base settings with the case's value for its knob. Throws Error for an invalid value.
StudySettings SettingsOf(const StudyResults& study, const CaseRecord& record);

/// Returns force_p95 of a case that has errors.
SafeError CalcForceError(const StudyResults& study, const CaseRecord& record);
/// Returns the reference that a case was compared with; null if the study has none.
const ReferenceRecord* FindReference(const StudyResults& study, const CaseRecord& record);

/// Returns all settings that have errors on at least one path: first the defaults, then the others in the study's order
/// of knobs, sorted by number. If `paths` is empty, all paths are used.
std::vector<PooledSetting> PoolSettings(const StudyResults& study, Holding holding,
                                        const std::vector<std::string>& paths = {});
/// Returns the settings of a knob in ascending order of its number, including the defaults, which are `base`. Empty if
/// there are only the defaults.
std::vector<PooledSetting> CurveOf(const std::vector<PooledSetting>& settings, const StudySettings& base,
                                   const std::string& knob);
/// Returns the indices of the Pareto-optimal settings among those that are ranked, in ascending order of time.
std::vector<std::size_t> FindFront(const std::vector<PooledSetting>& settings);
std::vector<Holding> HoldingsOf(const StudyResults& study);

/// Errors as a function of a knob's number: force_p95, or for heat the temperature. A path without an
/// error above its error bar has no curve.
struct KnobErrors {
  std::string knob;
  std::vector<std::string> paths;  // in the order of `curves`
  std::vector<SlopePath> curves;   // all numbers, including that of the defaults; no error is below its error bar
  std::vector<SlopePath> above;    // only the errors above the bar; for the slope
  std::optional<Slope> slope;      // over all numbers
  std::optional<Slope> coarse;     // over the coarser half of the numbers
  double order = 0;                // theoretical order; 0: none
};
/// Returns nullopt if the knob's values are words, or if there are fewer than two numbers.
std::optional<KnobErrors> MakeKnobErrors(const StudyResults& study, Holding holding, const std::string& knob);

}  // namespace kerf
