// Findings of a study in words. Every sentence follows from the figures and the limits below.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include "base/core/word_list.h"
#include "experiment/study/knobs.h"
#include "experiment/study/study_words.h"

namespace kerf {
namespace {

/// Errors and times within these fractions are treated as equal.
constexpr double kAlikeErrors = 0.03;
constexpr double kAlikeTimes = 0.05;
/// Maximum number of settings named in a sentence.
constexpr std::size_t kNamedChanges = 3;
constexpr double kTick_us = 1000;

template <typename... Args>
void Say(std::string& text, fmt::format_string<Args...> format, Args&&... args) {
  text += "- ";
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
  text += "\n";
}

/// States whether the defaults meet a requirement, path by path.
void SayCriterion(std::string& text, const PooledSetting& defaults, const std::string& demand, double limit, bool below,
                  const std::function<double(const CaseRecord&)>& read,
                  const std::function<std::string(double)>& show) {
  std::vector<std::pair<double, std::string>> values;
  std::size_t missing = 0;
  for (const CaseRecord* record : defaults.cases) {
    const double value = read(*record);
    if (std::isnan(value))
      ++missing;
    else
      values.emplace_back(value, record->path);
  }
  if (values.empty()) return Say(text, "**{}**: was not measured.", demand);
  std::sort(values.begin(), values.end(), std::greater<>());
  std::vector<std::string> above;
  for (const auto& [value, path] : values) {
    if (below ? value >= limit : value > limit) above.push_back(fmt::format("`{}` ({})", path, show(value)));
  }
  const std::string unknown =
      missing > 0 ? fmt::format(" {} path{} not measured.", missing, missing == 1 ? " was" : "s were") : "";
  if (above.empty()) {
    return Say(text, "**{}**: {}; the largest is {}, on `{}`.{}", demand,
               missing > 0 ? "holds where it was measured" : "holds", show(values[0].first), values[0].second, unknown);
  }
  Say(text, "**{}**: does not hold on {} of {} paths: {}.{}", demand, above.size(), values.size(), JoinWords(above),
      unknown);
}

void SayCriteria(std::string& text, const StudyResults& study, const PooledSetting& defaults) {
  const auto fraction = [](double value) { return ShowFraction(value); };
  SayCriterion(
      text, defaults, fmt::format("Force, p95, at most {}", ShowFraction(kTargetForce)), kTargetForce, false,
      [&](const CaseRecord& r) { return CalcForceError(study, r).value; }, fraction);
  SayCriterion(
      text, defaults, fmt::format("Direction, p95, at most {:g} deg", kTargetDirection_deg), kTargetDirection_deg,
      false, [](const CaseRecord& r) { return r.errors->direction_p95_deg; },
      [](double value) { return ShowThree(value) + " deg"; });
  SayCriterion(
      text, defaults, fmt::format("Removed volume within {}", ShowFraction(kTargetVolume)), kTargetVolume, false,
      [](const CaseRecord& r) { return r.errors->volume; }, fraction);
  SayCriterion(
      text, defaults, fmt::format("Tick, p99, under {:g} us", kTargetP99_us), kTargetP99_us, true,
      [](const CaseRecord& r) { return r.costs ? r.costs->tick.p99_us : std::nan(""); },
      [](double value) { return ShowThree(value) + " us"; });
}

/// States by how much the overall force is too large or too small: the minimum and the maximum over the paths.
void SayImpulse(std::string& text, const PooledSetting& defaults) {
  const CaseRecord* lowest = nullptr;
  const CaseRecord* highest = nullptr;
  for (const CaseRecord* record : defaults.cases) {
    if (!record->errors->impulse_signed) continue;
    if (lowest == nullptr || *record->errors->impulse_signed < *lowest->errors->impulse_signed) lowest = record;
    if (highest == nullptr || *record->errors->impulse_signed > *highest->errors->impulse_signed) highest = record;
  }
  if (lowest == nullptr) return;
  Say(text, "**Impulse**: from {} on `{}` to {} on `{}`.", ShowSignedFraction(*lowest->errors->impulse_signed),
      lowest->path, ShowSignedFraction(*highest->errors->impulse_signed), highest->path);
}

void SayFront(std::string& text, const std::vector<PooledSetting>& settings, const PooledSetting& defaults) {
  const PooledSetting* better = nullptr;
  for (const PooledSetting& s : settings) {
    if (!s.ranked || s.is_default || s.p99_us > defaults.p99_us || s.worst.value > defaults.worst.value) continue;
    if (s.p99_us == defaults.p99_us && s.worst.value == defaults.worst.value) continue;
    if (better == nullptr || s.worst.value < better->worst.value) better = &s;
  }
  if (better == nullptr) {
    return Say(text, "The defaults are on the Pareto front: no setting is as fast and more accurate ({}, {} us).",
               ShowError(defaults.worst), ShowThree(defaults.p99_us));
  }
  Say(text,
      "The defaults are not on the Pareto front: {} has {} in {} us, compared with {} in {} us for the defaults{}.",
      better->Name(), ShowError(better->worst), ShowThree(better->p99_us), ShowError(defaults.worst),
      ShowThree(defaults.p99_us),
      better->worst.value > (1 - kAlikeErrors) * defaults.worst.value &&
              better->p99_us > (1 - kAlikeTimes) * defaults.p99_us
          ? ", a negligible difference"
          : "");
}

struct Step {
  const PooledSetting* to;
  double rate;  // percentage points of error per 100 us
};

// Describes how settings trade error for time, relative to the defaults.
void SayPrices(std::string& text, const std::vector<PooledSetting>& settings, const PooledSetting& d) {
  std::vector<Step> gains;
  std::vector<Step> savings;
  std::vector<std::string> free;
  std::vector<std::string> wasted;
  std::vector<std::string> idle;
  for (const PooledSetting& s : settings) {
    if (!s.ranked || s.is_default) continue;
    const bool slower = s.p99_us > (1 + kAlikeTimes) * d.p99_us;
    const bool faster = s.p99_us < (1 - kAlikeTimes) * d.p99_us;
    const bool better = s.worst.value < (1 - kAlikeErrors) * d.worst.value;
    const bool worse = s.worst.value > (1 + kAlikeErrors) * d.worst.value;
    const double rate = 100 * 100 * std::abs((d.worst.value - s.worst.value) / (s.p99_us - d.p99_us));
    const bool counts = s.knob != "heat_grid_mm";  // this knob affects the heat, not the force
    if (better && slower) gains.push_back({&s, rate});
    if (better && !slower)
      free.push_back(fmt::format("{} ({} in {} us)", s.Name(), ShowError(s.worst), ShowThree(s.p99_us)));
    if (worse && faster) savings.push_back({&s, rate});
    if (!better && slower && counts) {
      wasted.push_back(
          fmt::format("{} ({} us more, {})", s.Name(), ShowThree(s.p99_us - d.p99_us), ShowError(s.worst)));
    }
    if (!worse && faster) {
      idle.push_back(fmt::format("{} ({} us less, {})", s.Name(), ShowThree(d.p99_us - s.p99_us), ShowError(s.worst)));
    }
  }
  std::stable_sort(gains.begin(), gains.end(), [](const Step& a, const Step& b) { return a.rate > b.rate; });
  std::stable_sort(savings.begin(), savings.end(), [](const Step& a, const Step& b) { return a.rate < b.rate; });
  const auto show = [&](const std::vector<Step>& steps, const char* sign) {
    std::vector<std::string> words;
    for (const Step& step : steps) {
      if (words.size() == kNamedChanges) break;
      words.push_back(fmt::format("{} ({} for {} us {}, {} points per 100 us)", step.to->Name(),
                                  ShowError(step.to->worst), ShowThree(std::abs(step.to->p99_us - d.p99_us)), sign,
                                  ShowThree(step.rate)));
    }
    return JoinWords(words);
  };
  if (!free.empty()) Say(text, "More accurate than the defaults in no more time: {}.", JoinWords(free));
  if (!gains.empty()) {
    Say(text, "Starting from the defaults ({}), {} gains the most accuracy per microsecond{}.", ShowError(d.worst),
        gains[0].to->Name(),
        gains.size() > 1 ? "; in order of gain: " + show(gains, "more") : ": " + show(gains, "more"));
  } else if (free.empty()) {
    Say(text, "No single knob makes the force more accurate than the defaults ({}).", ShowError(d.worst));
  }
  if (!savings.empty())
    Say(text, "Settings that save time with the smallest loss of accuracy: {}.", show(savings, "less"));
  if (!wasted.empty()) Say(text, "Wasteful, since they take time and gain nothing: {}.", JoinWords(wasted));
  if (!idle.empty()) Say(text, "Faster than the defaults without loss of accuracy: {}.", JoinWords(idle));
}

// Compares settings with the defaults, if there are times for them.
void SayComparison(std::string& text, const std::vector<PooledSetting>& settings, const PooledSetting& defaults) {
  std::size_t untimed = 0;
  bool any = false;
  for (const PooledSetting& s : settings) {
    if (s.is_default) continue;
    if (!s.timed) ++untimed;
    any = any || s.ranked;
  }
  if (untimed > 0) {
    Say(text, "{} setting{} not timed on every path and {} left out of all rankings and time diagrams.", untimed,
        untimed == 1 ? " was" : "s were", untimed == 1 ? "is" : "are");
  }
  if (!any) return;
  SayFront(text, settings, defaults);
  SayPrices(text, settings, defaults);
}

void SayThresholds(std::string& text, const std::vector<PooledSetting>& settings) {
  std::vector<std::string> above;
  std::vector<std::string> between;
  for (const PooledSetting& s : settings) {
    const std::string words = fmt::format("{} ({} on `{}`)", s.Name(), ShowFraction(s.worst.value), s.worst_path);
    if (s.worst.value > kForceJnd)
      above.push_back(words);
    else if (s.worst.value > kTargetForce)
      between.push_back(words);
  }
  if (above.empty() && between.empty()) {
    return Say(text, "No setting is above {} on any path.", ShowFraction(kTargetForce));
  }
  if (!above.empty())
    Say(text, "Above {}, one just-noticeable difference, on at least one path: {}.", ShowFraction(kForceJnd),
        JoinWords(above));
  if (!between.empty())
    Say(text, "Between {} and {}: {}.", ShowFraction(kTargetForce), ShowFraction(kForceJnd), JoinWords(between));
}

void SaySlab(std::string& text, const StudyResults& study, Holding holding) {
  const std::vector<std::string> paths = PathsOfSlab(study, holding);
  if (paths.empty()) return;
  const std::vector<PooledSetting> settings = PoolSettings(study, holding, paths);
  const PooledSetting* slab = nullptr;
  const PooledSetting* voxel = nullptr;
  for (const PooledSetting& s : settings) {
    if (s.is_default) voxel = &s;
    if (s.knob == "method" && s.value == "slab") slab = &s;
  }
  if (slab == nullptr || voxel == nullptr || !slab->timed || !voxel->timed || WasBusy(study.machine)) return;
  Say(text,
      "On the {} path{} that both can run, the slab takes {} us at p99 and the voxels take {} us, {} times as long; "
      "the force of the slab is off by {} (worst path; median {}), that of the voxels by {}.",
      paths.size(), paths.size() == 1 ? "" : "s", ShowThree(slab->p99_us), ShowThree(voxel->p99_us),
      ShowThree(voxel->p99_us / slab->p99_us), ShowError(slab->worst), ShowError(slab->median),
      ShowError(voxel->worst));
  if (voxel->p99_us < kTick_us) {
    Say(text,
        "The paper's reason for a slab, that voxels are too slow for a 1 ms tick, does not hold on this machine: at "
        "p99 "
        "they leave {} of the tick unused.",
        ShowFraction(1 - voxel->p99_us / kTick_us));
  } else {
    Say(text,
        "The paper's reason for a slab still holds on this machine: at p99 the voxels take longer than a tick of 1 "
        "ms.");
  }
}

void SayOrders(std::string& text, const StudyResults& study, Holding holding) {
  std::vector<std::string> as_theory;
  std::vector<std::string> flatter;
  std::vector<std::string> steeper;
  for (const std::string& name : study.knobs) {
    const std::optional<KnobErrors> errors = MakeKnobErrors(study, holding, name);
    if (!errors || errors->order == 0 || !errors->coarse) continue;
    const Slope& slope = *errors->coarse;
    const std::string words = fmt::format("`{}` ({:.2f}, theory {:g})", name, slope.slope, errors->order);
    // With only a few numbers, an order is accurate to only about a tenth.
    constexpr double kNear = 0.1;
    const double lower = slope.interval ? slope.interval->first - kNear : slope.slope - kNear;
    const double upper = slope.interval ? slope.interval->second + kNear : slope.slope + kNear;
    if (errors->order >= lower && errors->order <= upper)
      as_theory.push_back(words);
    else if (slope.slope / errors->order < 1)
      flatter.push_back(words);
    else
      steeper.push_back(words);
  }
  if (!as_theory.empty()) Say(text, "The order at the coarse end agrees with theory for {}.", JoinWords(as_theory));
  if (!flatter.empty()) {
    Say(text,
        "The order at the coarse end is lower than in theory for {}, probably because each of these knobs leaves the "
        "error contributions of the others unchanged.",
        JoinWords(flatter));
  }
  if (!steeper.empty()) {
    Say(text, "The order at the coarse end is higher than in theory for {}.", JoinWords(steeper));
  }
}

void SayReferences(std::string& text, const StudyResults& study, Holding holding) {
  double largest = 0;
  double smallest_ratio = std::numeric_limits<double>::infinity();
  std::string of;
  std::size_t cases = 0;
  std::size_t below = 0;
  std::size_t near = 0;
  constexpr double kNear = 10;  // the error of the reference should be smaller by this factor
  for (const CaseRecord& record : study.cases) {
    if (record.holding != holding || record.state != CaseState::kDone || !record.errors) continue;
    const ReferenceRecord* reference = FindReference(study, record);
    if (reference == nullptr) continue;
    ++cases;
    if (CalcForceError(study, record).at_most) {
      ++below;
    } else if (reference->error_bar > 0) {
      const double ratio = record.errors->force_p95 / reference->error_bar;
      smallest_ratio = std::min(smallest_ratio, ratio);
      near += ratio < kNear ? 1 : 0;
    }
    if (reference->error_bar > largest) largest = reference->error_bar, of = reference->path;
  }
  if (cases == 0 || largest <= 0) return;
  Say(text,
      "The error of the references is at most {} (on `{}`). {} of {} errors are below that of their reference, or "
      "below {}, and are "
      "given as \"at most\"{}.",
      ShowFraction(largest), of, below == 0 ? "None" : std::to_string(below), cases, ShowFraction(kFinestError),
      std::isfinite(smallest_ratio)
          ? fmt::format("; the smallest of the others is {} times the error of its reference, and {} less than ten "
                        "times as large",
                        ShowThree(smallest_ratio),
                        near == 0 ? "none is" : std::to_string(near) + (near == 1 ? " is" : " are"))
          : std::string());
}

}  // namespace

std::string DescribeFindings(const StudyResults& study, Holding holding) {
  const std::vector<PooledSetting> settings = PoolSettings(study, holding);
  std::string text;
  const auto found =
      std::find_if(settings.begin(), settings.end(), [](const PooledSetting& s) { return s.is_default; });
  if (found == settings.end()) {
    Say(text, "The defaults were not run on any path, so there are no findings about them.");
  } else {
    SayCriteria(text, study, *found);
    SayImpulse(text, *found);
    if (WasBusy(study.machine)) {
      Say(text,
          "Settings are not compared by their times, because the machine was busy: its load before the run was {:.1f}, "
          "with {} cores. Repeat the study on an idle machine.",
          study.machine.load, study.machine.cores);
    } else if (found->timed) {
      SayComparison(text, settings, *found);
    } else {
      Say(text, "Times were not measured on every path.");
    }
  }
  SayThresholds(text, settings);
  SaySlab(text, study, holding);
  SayOrders(text, study, holding);
  SayReferences(text, study, holding);
  return text + "\n";
}

}  // namespace kerf
