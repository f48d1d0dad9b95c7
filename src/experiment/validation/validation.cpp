#include "experiment/validation/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kDefaultSpeed_mm_per_s = 4400;  // of a tooth whose speed is not known

std::string ShowFactor(double factor) {
  return factor >= 1 ? fmt::format("{:.3g} times", factor) : fmt::format("{:.2g} times", factor);
}

/// Compares with a mean and its standard deviation, with a mean alone, or with a range.
void Judge(const MeasuredValue& measured, ValueComparison& c) {
  const double value = c.simulated.value;
  if (!c.simulated.why.empty()) {
    c.verdict = "not compared: " + c.simulated.why;
  } else if (IsGiven(measured.sd)) {
    c.difference_sd = (value - measured.value) / measured.sd;
    c.factor = value / measured.value;
    c.agrees = std::abs(c.difference_sd) <= kAgreeWithin_sd;
    c.verdict = fmt::format("{:+.1f} SD", c.difference_sd);
  } else if (IsGiven(measured.value)) {
    c.factor = value / measured.value;
    c.verdict = fmt::format("{}; no scatter is known", ShowFactor(c.factor));
  } else {
    c.agrees = value >= measured.low - kRangeRounding * std::abs(measured.low) &&
               value <= measured.high + kRangeRounding * std::abs(measured.high);
    c.factor = *c.agrees ? 1 : value / (value < measured.low ? measured.low : measured.high);
    c.verdict =
        *c.agrees ? "inside" : fmt::format("{}, {}", value < measured.low ? "below" : "above", ShowFactor(c.factor));
  }
}

/// The cuts of a set's teeth, each made once for each law, width and bite.
class ToothRuns {
 public:
  explicit ToothRuns(Validation& validation) : validation_(validation) {}

  const ToothRun& Run(std::size_t law, double width_mm, double bite_um, double speed_mm_per_s) {
    for (const ToothCheck& check : validation_.teeth) {
      const ToothRun& run = check.run;
      if (check.law == law && run.width_mm == width_mm && run.bite_um == bite_um &&
          run.speed_mm_per_s == speed_mm_per_s) {
        return run;
      }
    }
    validation_.teeth.push_back({law, RunTooth(validation_.laws[law], width_mm, bite_um, speed_mm_per_s)});
    return validation_.teeth.back().run;
  }

 private:
  Validation& validation_;
};

/// Replaces the law's forces by those of a cut.
void UseCut(const MeasuredSet& set, const MeasuredValue& measured, ToothRuns& runs, ValueComparison& c) {
  const MeasuredConditions at = JoinConditions(measured.at, set.conditions);
  if (IsGiven(at.density) && at.density != 1) return;  // the cut is in the bone of the measurements
  const double speed = IsGiven(at.speed_mm_per_s) ? at.speed_mm_per_s : kDefaultSpeed_mm_per_s;
  const ToothRun& run = runs.Run(c.law, set.tool.width_mm, at.bite_um, speed);
  c.simulated.value = CalcToothQuantity(measured.quantity, {run.thrust_N, run.cutting_N}, set.tool.width_mm,
                                        run.removed_bite_um / 1000);
}

ValueComparison CompareValue(const Validation& v, std::size_t set_index, std::size_t row, std::size_t law_index,
                             ToothRuns& runs) {
  const MeasuredSet& set = v.sets[set_index];
  const MeasuredValue& measured = set.values[row];
  const ForceLaw& law = v.laws[law_index];
  ValueComparison c;
  c.set = set_index;
  c.row = row;
  c.law = law_index;
  c.calibration = IsCalibrated(set, law);
  if (measured.material != "cortical") {
    c.simulated.why = fmt::format("kerf has no constants of {} bone", measured.material);
  } else {
    c.simulated = SimulateQuantity(law, set, measured.quantity, measured.at);
    c.law_value = c.simulated.value;
    if (c.simulated.why.empty() && set.tool.kind == kToolTooth) UseCut(set, measured, runs, c);
  }
  Judge(measured, c);
  return c;
}

std::string SignOf(double ratio, const std::string& measured) {
  const double tolerance = measured == "constant" ? kConstantWithin : kChangeFrom;
  if (std::abs(ratio - 1) <= tolerance) return "constant";
  return ratio > 1 ? "rises" : "falls";
}

void JudgeTrend(const MeasuredTrend& measured, TrendComparison& c) {
  const std::string& why = c.at_from.why.empty() ? c.at_to.why : c.at_from.why;
  if (!why.empty()) {
    c.verdict = "not compared: " + why;
  } else if (c.at_from.value == 0 && c.at_to.value == 0) {
    c.sign = "constant";
    c.right = measured.sign == c.sign;
    c.verdict = "wrong: cuts nothing";
  } else {
    c.ratio = c.at_from.value > 0 ? c.at_to.value / c.at_from.value : std::numeric_limits<double>::infinity();
    c.sign = SignOf(c.ratio, measured.sign);
    c.right = measured.sign == c.sign;
    c.verdict = fmt::format("{}: {}, x {:.3g}", *c.right ? "right" : "wrong", c.sign, c.ratio);
  }
}

TrendComparison CompareTrend(const Validation& v, std::size_t set_index, std::size_t row, std::size_t law_index) {
  const MeasuredSet& set = v.sets[set_index];
  const MeasuredTrend& measured = set.trends[row];
  const ForceLaw& law = v.laws[law_index];
  TrendComparison c;
  c.set = set_index;
  c.row = row;
  c.law = law_index;
  c.calibration = IsCalibrated(set, law);
  MeasuredConditions from = JoinConditions(measured.at, set.conditions);
  if (!IsGiven(from.density)) from.density = 1;
  MeasuredConditions to = from;
  double& x_from = ConditionOf(from, measured.against);
  double& x_to = ConditionOf(to, measured.against);
  c.from = IsGiven(measured.from) ? measured.from : x_from;
  c.to = IsGiven(measured.to) ? measured.to : 2 * x_from;
  x_from = c.from;
  x_to = c.to;
  c.at_from = SimulateQuantity(law, set, measured.quantity, from);
  c.at_to = SimulateQuantity(law, set, measured.quantity, to);
  JudgeTrend(measured, c);
  return c;
}

/// Returns the quantity of a trend in a cut with a blade.
double QuantityOf(const BladeRun& run, const BladeCut& cut, std::string_view quantity) {
  if (quantity == "removal_mm3_per_s") return run.removal_mm3_per_s;
  if (quantity == "temperature_rise") return run.rise_K;
  return CalcToothQuantity(quantity, {run.thrust_N, run.cutting_N}, cut.width_mm, run.bite_um / 1000);
}

BladeRun Saw(const ForceLaw& law, const BladeCut& cut, const MeasuredConditions& at) {
  if (cut.swing_radius_mm > 0) return RunBladeHeat(law, cut, at.feed_mm_per_min / 60);
  return IsGiven(at.force_N) ? RunBladeUnderForce(law, cut, at.force_N) : RunBladeAtBite(law, cut, at.bite_um);
}

/// Returns the cut of a set's blade under some conditions.
BladeCut MakeCut(const MeasuredTool& tool, const MeasuredConditions& at) {
  constexpr double kEngagedTeeth = 5;  // of an oscillating blade, in a wall of bone
  if (tool.is_oscillating()) {
    const double stroke_mm = tool.swing_deg * std::numbers::pi / 180 * tool.radius_mm;
    return {tool.width_mm, tool.pitch_mm, stroke_mm, kEngagedTeeth, 2 * stroke_mm * at.cycles_per_min / 60,
            tool.radius_mm};
  }
  return {tool.width_mm, tool.pitch_mm, tool.stroke_mm, IsGiven(tool.teeth) ? tool.teeth : 1,
          IsGiven(at.speed_mm_per_s) ? at.speed_mm_per_s : kDefaultSpeed_mm_per_s};
}

/// Saws a trend that could be simulated with a blade, if its set gives one. The bone is that of the
/// measurements: its density is 1.
void SawTrend(Validation& v, std::size_t index) {
  const TrendComparison& c = v.trends[index];
  const MeasuredSet& set = v.sets[c.set];
  const MeasuredTrend& measured = set.trends[c.row];
  const bool swings = set.tool.is_oscillating();
  if (!(swings ? measured.quantity == "temperature_rise" : set.tool.is_reciprocating())) return;
  if (!c.right || measured.against == "density") return;
  const ForceLaw& law = v.laws[c.law];
  MeasuredConditions at = JoinConditions(measured.at, set.conditions);
  const auto saw = [&](double value) {
    ConditionOf(at, measured.against) = value;
    return MakeCut(set.tool, at);
  };
  BladeCheck check;
  check.trend = index;
  check.cut = saw(c.from);
  check.from = Saw(law, check.cut, at);
  const double from = QuantityOf(check.from, check.cut, measured.quantity);
  check.cut = saw(c.to);
  check.to = Saw(law, check.cut, at);
  const double to = QuantityOf(check.to, check.cut, measured.quantity);
  if (check.from.removal_mm3_per_s > 0) {
    check.ratio = to / from;
    check.sign = SignOf(check.ratio, measured.sign);
  } else {
    check.sign = "cuts nothing";
  }
  check.right = check.sign == measured.sign;
  v.blades.push_back(check);
}

LawCounts CountLaw(const Validation& v, std::size_t law) {
  LawCounts counts;
  counts.law = law;
  for (const ValueComparison& c : v.values) {
    // Derived values repeat what other rows state.
    if (c.law != law || !c.agrees || v.value_of(c).obtained == "derived") continue;
    ++(c.calibration ? counts.calibration_values : counts.values);
    if (*c.agrees) ++(c.calibration ? counts.calibration_values_agree : counts.values_agree);
  }
  for (const TrendComparison& c : v.trends) {
    if (c.law != law || !c.right) continue;
    ++(c.calibration ? counts.calibration_trends : counts.trends);
    if (*c.right) ++(c.calibration ? counts.calibration_trends_right : counts.trends_right);
  }
  return counts;
}

/// Compares all laws with one set.
void CompareSet(Validation& v, std::size_t set, ToothRuns& runs, const std::function<void()>& done_one) {
  for (std::size_t law = 0; law < v.laws.size(); ++law) {
    for (std::size_t row = 0; row < v.sets[set].values.size(); ++row) {
      v.values.push_back(CompareValue(v, set, row, law, runs));
      done_one();
    }
    for (std::size_t row = 0; row < v.sets[set].trends.size(); ++row) {
      v.trends.push_back(CompareTrend(v, set, row, law));
      SawTrend(v, v.trends.size() - 1);
    }
    const MeasuredSet& s = v.sets[set];
    const bool force_varies = std::any_of(s.trends.begin(), s.trends.end(),
                                          [](const MeasuredTrend& trend) { return trend.against == "force_N"; });
    if (s.tool.kind == kToolBladeForce && IsGiven(s.conditions.force_N) && !force_varies) {
      v.carried.push_back(
          {set, law, s.conditions.force_N, CountCarriedTeeth(v.laws[law], s.tool.width_mm, s.conditions.force_N)});
    }
  }
}

}  // namespace

bool IsCalibrated(const MeasuredSet& set, const ForceLaw& law) {
  const bool is_default = law.values() == ForceLaw(law.name()).values() && !law.has_own_table();
  return is_default && std::find(set.calibrated.begin(), set.calibrated.end(), law.name()) != set.calibrated.end();
}

std::size_t Validation::CountComparedSets() const {
  return static_cast<std::size_t>(std::count_if(
      sets.begin(), sets.end(), [](const MeasuredSet& set) { return !set.values.empty() || !set.trends.empty(); }));
}

std::vector<ForceLaw> ChooseLaws(const std::vector<std::string>& names) {
  std::vector<ForceLaw> laws;
  const auto add = [&](const ForceLaw& law) {
    const auto same = [&](const ForceLaw& other) { return std::string_view(other.name()) == law.name(); };
    if (std::none_of(laws.begin(), laws.end(), same)) laws.push_back(law);
  };
  const bool all = names.empty() || std::find(names.begin(), names.end(), "all") != names.end();
  for (const std::string& name : names) {
    if (name != "all") add(ForceLaw(name));
  }
  if (!all) return laws;
  laws.clear();
  for (const ForceLawInfo* law : ForceLaws()) add(ForceLaw(law->name));
  return laws;
}

Validation CompareWithMeasurements(const std::vector<ForceLaw>& laws, const std::vector<MeasuredSet>& sets,
                                   const std::function<void(double)>& progress,
                                   const std::optional<SceneLaw>& scene_law) {
  Validation v;
  v.laws = laws;
  for (const ForceLaw& law : laws) v.names.emplace_back(law.name());
  if (scene_law) {
    MaterialTable bone;
    bone.Add(DefaultMandibleTable().At(24));  // that of the measurements
    CheckTissues(scene_law->law, bone);
    v.laws.push_back(scene_law->law);
    v.names.push_back(fmt::format("{}: {}", scene_law->scene, scene_law->law.name()));
  }
  v.sets = sets;
  std::size_t all = 0;
  for (const MeasuredSet& set : sets) all += set.values.size() * v.laws.size();
  std::size_t done = 0;
  ToothRuns runs(v);
  for (std::size_t set = 0; set < sets.size(); ++set) {
    CompareSet(v, set, runs, [&] {
      ++done;
      if (progress) progress(static_cast<double>(done) / static_cast<double>(all));
    });
  }
  for (std::size_t law = 0; law < v.laws.size(); ++law) v.counts.push_back(CountLaw(v, law));
  return v;
}

}  // namespace kerf
