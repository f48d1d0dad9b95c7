// Comparison of force laws with published measurements: the work of `kerf validate`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/validation/blade_run.h"
#include "experiment/validation/measured_set.h"
#include "experiment/validation/rigs.h"
#include "experiment/validation/tooth_run.h"
#include "kerf/force.h"

namespace kerf {

/// Number of standard deviations within which a simulated value agrees with a mean.
inline constexpr double kAgreeWithin_sd = 2;
/// Ends of ranges are published with two digits; a value beyond an end by less than this fraction of it is inside.
inline constexpr double kRangeRounding = 0.005;
/// Relative change below which a simulated quantity counts as constant, if it was measured as constant. The standard
/// deviations of the sets are 5 to 22 % of the values, so a smaller change could not have been noticed.
inline constexpr double kConstantWithin = 0.1;
/// The same, if it was measured as rising or falling: above rounding.
inline constexpr double kChangeFrom = 0.001;

/// A measured value and that of one law.
struct ValueComparison {
  std::size_t set = 0;  // index in Validation::sets
  std::size_t row = 0;  // index in its values
  std::size_t law = 0;  // index in Validation::laws
  bool calibration = false;
  Simulated simulated;           // of a tooth: from a cut in the contact and removal code
  double law_value = kNotGiven;  // of a tooth: from the law alone; else equal to `simulated`
  double difference_sd = kNotGiven;
  double factor = kNotGiven;   // simulated / mean, or / nearest end of the range; 1 within the range
  std::optional<bool> agrees;  // within kAgreeWithin_sd, or in the range; none: no scatter is known, or not simulated
  std::string verdict;         // in words
};

/// A measured trend and that of one law.
struct TrendComparison {
  std::size_t set = 0;
  std::size_t row = 0;
  std::size_t law = 0;
  bool calibration = false;
  double from = kNotGiven;  // of the condition
  double to = kNotGiven;
  Simulated at_from;
  Simulated at_to;
  double ratio = kNotGiven;
  std::string sign;           // simulated; empty: not simulated
  std::optional<bool> right;  // none: not simulated
  std::string verdict;
};

/// A cut with a single tooth, with one law.
struct ToothCheck {
  std::size_t law = 0;
  ToothRun run;
};

/// A trend that was sawn with a reciprocating or oscillating blade.
struct BladeCheck {
  std::size_t trend = 0;  // index in Validation::trends
  BladeCut cut;           // at the end of the trend
  BladeRun from;
  BladeRun to;
  double ratio = kNotGiven;
  std::string sign;
  bool right = false;
};

/// Teeth that the force of a set carries without cutting.
struct CarriedTeeth {
  std::size_t set = 0;
  std::size_t law = 0;
  double force_N = 0;
  double teeth = 0;  // infinite: any number
};

/// Numbers of comparisons of one law.
struct LawCounts {
  std::size_t law = 0;
  int values = 0;  // read or recalled, with a known scatter, and not used for calibration
  int values_agree = 0;
  int trends = 0;
  int trends_right = 0;
  int calibration_values = 0;
  int calibration_values_agree = 0;
  int calibration_trends = 0;
  int calibration_trends_right = 0;
};

struct Validation {
  std::vector<ForceLaw> laws;
  std::vector<std::string> names;  // of the laws in the results: "LAW", and "SCENE: LAW" for a SceneLaw
  std::vector<MeasuredSet> sets;
  std::vector<ValueComparison> values;
  std::vector<TrendComparison> trends;
  std::vector<ToothCheck> teeth;
  std::vector<BladeCheck> blades;
  std::vector<CarriedTeeth> carried;
  std::vector<LawCounts> counts;

  /// Returns the number of sets with a value or a trend.
  std::size_t CountComparedSets() const;
  const MeasuredValue& value_of(const ValueComparison& c) const { return sets[c.set].values[c.row]; }
  const MeasuredTrend& trend_of(const TrendComparison& c) const { return sets[c.set].trends[c.row]; }
};

/// Force law with the values and the table of a scene.
struct SceneLaw {
  std::string scene;  // its name
  ForceLaw law;
};

/// Returns true if the law has its default values and these were derived from the set.
bool IsCalibrated(const MeasuredSet& set, const ForceLaw& law);

/// Returns the laws of these names with their default parameters, or all for an empty list and for "all". Throws Error
/// for an unknown law.
std::vector<ForceLaw> ChooseLaws(const std::vector<std::string>& names);

/// Compares each law with each set; the law of a scene comes last. `progress` receives the fraction that is done, 0 to
/// 1, and may be empty. Throws Error if the scene's law has no forces for cortical bone.
Validation CompareWithMeasurements(const std::vector<ForceLaw>& laws, const std::vector<MeasuredSet>& sets,
                                   const std::function<void(double)>& progress,
                                   const std::optional<SceneLaw>& scene_law = std::nullopt);

}  // namespace kerf
