// A study's settings over all of its paths: the figures that diagrams, tables and words are made from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiment/study/records.h"
#include "experiment/study/slope.h"

namespace kerf {

inline constexpr double kTargetForce = 0.5 * kForceJnd;  // 3.5 %
inline constexpr double kTargetDirection_deg = 9;
inline constexpr double kTargetVolume = 0.01;
inline constexpr double kTargetP99_us = 300;

/// An error as it may be spoken of: no smaller than its reference's own.
struct SafeError {
  double value = 0;
  bool at_most = false;  // it is below the reference's error bar, and `value` is that bar
};

/// A setting's errors and times on several paths. Times are for a millisecond of simulated time: those of a tick times
/// ticks a second / 1000, so that settings of different rates compare and 1000 us is all the time that there is.
struct PooledSetting {
  std::string knob;
  std::string value;
  double number = 0;  // of the defaults: the defaults' number when they stand in a knob's curve, else 0
  bool is_default = false;
  std::size_t paths = 0;  // on which it was done
  bool complete = false;  // on all of those on which the defaults were
  bool timed = false;     // on all of `paths`
  SafeError worst;        // force_p95 of the path on which it is largest
  SafeError median;       // over the paths
  std::string worst_path;
  double p50_us = 0;   // median over the paths
  double p99_us = 0;   // of the slowest path
  double p999_us = 0;  // of the slowest path
  std::string slowest_path;
  std::vector<const CaseRecord*> cases;

  /// "voxel_mm = 0.05", "the defaults".
  std::string Name() const;
};

/// The knob decides what is simulated, not how exactly: its settings have references of their own or none that is fair.
bool ChoosesPhysics(const std::string& knob);
/// A knob's number in the settings, 0 where it is a word. Throws Error for a name that is no knob's.
double NumberOf(const StudySettings& settings, const std::string& knob);
/// What of the base settings differs from what kerf ships: "`voxel_mm = 0.2`, `law = ...`"; empty: nothing.
std::string DescribeBase(const StudySettings& base);
/// The base settings with the case's knob turned. Throws Error for a value that is none.
StudySettings SettingsOf(const StudyResults& study, const CaseRecord& record);

/// force_p95 of a case with errors.
SafeError CalcForceError(const StudyResults& study, const CaseRecord& record);
/// The reference that a case was held against; null when the study has none.
const ReferenceRecord* FindReference(const StudyResults& study, const CaseRecord& record);

/// All settings with errors on a path at least: first the defaults, then by knob in the study's order and number.
/// `paths` empty: all.
std::vector<PooledSetting> PoolSettings(const StudyResults& study, Holding holding,
                                        const std::vector<std::string>& paths = {});
/// The settings of a knob by rising number, the defaults, which are `base`, among them; empty when there is nothing but
/// the defaults.
std::vector<PooledSetting> CurveOf(const std::vector<PooledSetting>& settings, const StudySettings& base,
                                   const std::string& knob);
/// Of `settings`: complete, timed, and no physics of their own; by rising time. Indices.
std::vector<std::size_t> FindFront(const std::vector<PooledSetting>& settings);
/// Whether a setting may stand in the front and in the tables of the best.
bool IsRanked(const PooledSetting& setting);
std::vector<Holding> HoldingsOf(const StudyResults& study);

/// What falls with a knob's number: force_p95, or for heat the temperature.
struct KnobErrors {
  std::string knob;
  std::vector<std::string> paths;  // as `curves`
  std::vector<SlopePath> curves;   // all numbers, the defaults' too; errors no smaller than the bar
  std::vector<SlopePath> above;    // of these, errors above the bar only: for the slope
  std::optional<Slope> slope;      // over all numbers
  std::optional<Slope> coarse;     // over the coarser half of them
  double order = 0;                // theory's; 0: none
};
/// None for a knob of words, or with fewer than two numbers.
std::optional<KnobErrors> MakeKnobErrors(const StudyResults& study, Holding holding, const std::string& knob);

}  // namespace kerf
