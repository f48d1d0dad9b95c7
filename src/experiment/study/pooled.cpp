#include "experiment/study/pooled.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/files/markdown_text.h"
#include "experiment/study/case.h"
#include "experiment/study/knobs.h"
#include "experiment/study/pareto.h"
#include "experiment/study/settings.h"

namespace kerf {
namespace {

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

bool Holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool IsMeasured(const CaseRecord& record) {
  return record.state == CaseState::kDone && record.errors && std::isfinite(record.errors->force_p95);
}

void Finish(const StudyResults& study, const PooledSetting& defaults, PooledSetting& setting) {
  setting.paths = setting.cases.size();
  setting.complete = std::all_of(defaults.cases.begin(), defaults.cases.end(), [&](const CaseRecord* other) {
    return std::any_of(setting.cases.begin(), setting.cases.end(),
                       [&](const CaseRecord* record) { return record->path == other->path; });
  });
  const double ticks_per_ms =
      (setting.knob == "rate_hz" && setting.number > 0 ? setting.number : study.base.rate_hz) / 1000;
  std::vector<SafeError> errors;
  std::vector<double> p50_us;
  setting.timed = true;
  for (const CaseRecord* record : setting.cases) {
    const SafeError error = CalcForceError(study, *record);
    errors.push_back(error);
    if (errors.size() == 1 || error.value > setting.worst.value)
      setting.worst = error, setting.worst_path = record->path;
    if (!record->costs) {
      setting.timed = false;
      continue;
    }
    const Percentiles& tick = record->costs->tick;
    p50_us.push_back(ticks_per_ms * tick.p50_us);
    setting.p999_us = std::max(setting.p999_us, ticks_per_ms * tick.p999_us);
    if (ticks_per_ms * tick.p99_us <= setting.p99_us) continue;
    setting.p99_us = ticks_per_ms * tick.p99_us;
    setting.slowest_path = record->path;
  }
  setting.ranked = setting.complete && setting.timed && !ChoosesPhysics(setting.knob) && !WasBusy(study.machine);
  std::sort(errors.begin(), errors.end(), [](const SafeError& a, const SafeError& b) { return a.value < b.value; });
  // For an even number of paths, this is the upper of the two middle values, so that it is the value of an actual path.
  setting.median = errors[errors.size() / 2];
  if (!p50_us.empty()) setting.p50_us = MedianOf(p50_us);
}

/// Returns the error bar of a case's force: that of its reference, and not below kFinestError unless both are exact.
double BarOf(const StudyResults& study, const CaseRecord& record) {
  const ReferenceRecord* reference = FindReference(study, record);
  const double bar = reference != nullptr ? reference->error_bar : 0;
  return record.errors->force_p95 > 0 ? std::max(bar, kFinestError) : bar;
}

// The error on the knob's curve, and the error of the reference.
struct KnobError {
  double value;
  double bar;
};
std::optional<KnobError> ReadKnobError(const StudyResults& study, const std::string& knob, const CaseRecord& record) {
  if (!IsMeasured(record)) return std::nullopt;
  if (knob == "heat_grid_mm") {
    if (!record.errors->temperature_K || !std::isfinite(*record.errors->temperature_K)) return std::nullopt;
    return KnobError{*record.errors->temperature_K, record.errors->temperature_bar_K.value_or(0)};
  }
  return KnobError{record.errors->force_p95, BarOf(study, record)};
}

}  // namespace

std::string PooledSetting::Name() const {
  return is_default ? "the defaults" : MarkdownCode(fmt::format("{} = {}", knob, value));
}

bool ChoosesPhysics(const std::string& knob) {
  return knob == "law" || knob == "material";
}

double NumberOf(const StudySettings& settings, const std::string& knob) {
  return FindKnob(knob).numeric ? std::stod(ValueOf(settings, knob)) : 0;
}

std::string DescribeBase(const StudySettings& base) {
  std::string text;
  for (const Knob& knob : StudyKnobs()) {
    const std::string value = ValueOf(base, knob.name);
    if (value != ValueOf(StudySettings{}, knob.name)) {
      text += fmt::format("{}`{} = {}`", text.empty() ? "" : ", ", knob.name, value);
    }
  }
  return text;
}

StudySettings SettingsOf(const StudyResults& study, const CaseRecord& record) {
  StudySettings settings = study.base;
  if (record.knob != "default") SetValue(settings, record.knob, record.value);
  return settings;
}

const ReferenceRecord* FindReference(const StudyResults& study, const CaseRecord& record) {
  const std::string variant = VariantOf(SettingsOf(study, record));
  for (const ReferenceRecord& reference : study.references) {
    const bool same = reference.holding == record.holding && reference.path == record.path;
    if (same && reference.variant == variant) return &reference;
  }
  return nullptr;
}

SafeError CalcForceError(const StudyResults& study, const CaseRecord& record) {
  const double error = record.errors->force_p95;
  const double bar = BarOf(study, record);
  return bar > 0 && error <= bar ? SafeError{bar, true} : SafeError{error, false};
}

std::vector<PooledSetting> PoolSettings(const StudyResults& study, Holding holding,
                                        const std::vector<std::string>& paths) {
  std::vector<PooledSetting> settings;
  PooledSetting& defaults = settings.emplace_back();
  defaults.knob = "default";
  defaults.is_default = true;
  std::vector<std::string> knobs = study.knobs;
  for (const CaseRecord& record : study.cases) {
    if (record.knob != "default" && !Holds(knobs, record.knob)) knobs.push_back(record.knob);
  }
  const auto fits = [&](const CaseRecord& record) {
    return record.holding == holding && IsMeasured(record) && (paths.empty() || Holds(paths, record.path));
  };
  for (const CaseRecord& record : study.cases) {
    if (fits(record) && record.knob == "default") settings[0].cases.push_back(&record);
  }
  for (const std::string& knob : knobs) {
    const auto first = static_cast<std::ptrdiff_t>(settings.size());
    for (const CaseRecord& record : study.cases) {
      if (!fits(record) || record.knob != knob) continue;
      const auto same = std::find_if(settings.begin() + first, settings.end(),
                                     [&](const PooledSetting& s) { return s.value == record.value; });
      PooledSetting& setting = same != settings.end() ? *same : settings.emplace_back();
      setting.knob = knob;
      setting.value = record.value;
      setting.number = record.number;
      setting.cases.push_back(&record);
    }
    std::stable_sort(settings.begin() + first, settings.end(),
                     [](const PooledSetting& a, const PooledSetting& b) { return a.number < b.number; });
  }
  const PooledSetting base = settings[0];
  if (base.cases.empty()) settings.erase(settings.begin());
  for (PooledSetting& setting : settings) Finish(study, base, setting);
  return settings;
}

std::vector<PooledSetting> CurveOf(const std::vector<PooledSetting>& settings, const StudySettings& base,
                                   const std::string& knob) {
  std::vector<PooledSetting> curve;
  const PooledSetting* defaults = nullptr;
  bool has_default_value = false;
  for (const PooledSetting& setting : settings) {
    if (setting.is_default) defaults = &setting;
    if (setting.knob != knob) continue;
    curve.push_back(setting);
    has_default_value = has_default_value || setting.value == ValueOf(base, knob);
  }
  if (curve.empty() || defaults == nullptr || has_default_value) return curve;
  PooledSetting point = *defaults;
  point.number = NumberOf(base, knob);
  point.value = ValueOf(base, knob);
  const auto after = std::find_if(curve.begin(), curve.end(),
                                  [&](const PooledSetting& setting) { return setting.number > point.number; });
  curve.insert(FindKnob(knob).numeric ? after : curve.begin(), point);
  return curve;
}

bool WasBusy(const RunInfo& machine) {
  return machine.load > 0.25 * std::max(1, machine.cores);
}

std::vector<std::size_t> FindFront(const std::vector<PooledSetting>& settings) {
  std::vector<std::size_t> ranked;
  std::vector<CostAndError> points;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (!settings[i].ranked) continue;
    ranked.push_back(i);
    points.push_back({settings[i].p99_us, settings[i].worst.value});
  }
  std::vector<std::size_t> front;
  for (const std::size_t k : FindParetoFront(points)) front.push_back(ranked[k]);
  return front;
}

std::vector<Holding> HoldingsOf(const StudyResults& study) {
  std::vector<Holding> holdings;
  for (const Holding holding : {Holding::kHand, Holding::kPath}) {
    const bool any = std::any_of(study.cases.begin(), study.cases.end(), [&](const CaseRecord& record) {
      return record.holding == holding && IsMeasured(record);
    });
    if (any) holdings.push_back(holding);
  }
  return holdings;
}

std::optional<KnobErrors> MakeKnobErrors(const StudyResults& study, Holding holding, const std::string& name) {
  const Knob& knob = FindKnob(name);
  if (!knob.numeric) return std::nullopt;
  KnobErrors errors;
  errors.knob = name;
  errors.order = knob.order;
  std::vector<double> numbers;
  for (const std::string& path : study.paths) {
    struct Point {
      double number;
      KnobError error;
    };
    std::vector<Point> points;
    std::optional<Point> base;
    for (const CaseRecord& record : study.cases) {
      if (record.holding != holding || record.path != path) continue;
      const bool is_default = record.knob == "default";
      const double number = is_default ? NumberOf(study.base, name) : record.number;
      if ((!is_default && record.knob != name) || !(number > 0)) continue;
      const std::optional<KnobError> error = ReadKnobError(study, name, record);
      if (!error) continue;
      if (is_default)
        base = {number, *error};
      else
        points.push_back({number, *error});
    }
    const auto has = [&](double number) {
      return std::any_of(points.begin(), points.end(), [&](const Point& p) { return p.number == number; });
    };
    if (points.empty()) continue;
    if (base && !has(base->number)) points.push_back(*base);
    std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.number < b.number; });
    SlopePath curve;
    SlopePath above;
    for (const Point& point : points) {
      const double drawn = std::max(point.error.value, point.error.bar);
      if (!(drawn > 0)) continue;
      curve.numbers.push_back(point.number), curve.errors.push_back(drawn);
      numbers.push_back(point.number);
      if (point.error.value <= point.error.bar) continue;
      above.numbers.push_back(point.number), above.errors.push_back(point.error.value);
    }
    if (above.numbers.empty()) continue;
    errors.paths.push_back(path);
    errors.curves.push_back(std::move(curve));
    errors.above.push_back(std::move(above));
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  if (numbers.size() < 2) return std::nullopt;
  errors.slope = FitSlope(errors.above);
  // The coarse end is the one at which the errors are larger according to theory or, if there is none, to the data.
  const double sense = errors.order != 0 ? errors.order : errors.slope ? errors.slope->slope : 1;
  const std::size_t half = (numbers.size() + 1) / 2;
  const double lower = sense > 0 ? numbers[numbers.size() - std::max<std::size_t>(half, 2)] : numbers.front();
  const double upper = sense > 0 ? numbers.back() : numbers[std::max<std::size_t>(half, 2) - 1];
  std::vector<SlopePath> coarse;
  for (const SlopePath& path : errors.above) {
    SlopePath& part = coarse.emplace_back();
    for (std::size_t i = 0; i < path.numbers.size(); ++i) {
      if (path.numbers[i] < lower || path.numbers[i] > upper) continue;
      part.numbers.push_back(path.numbers[i]), part.errors.push_back(path.errors[i]);
    }
  }
  errors.coarse = FitSlope(coarse);
  return errors;
}

}  // namespace kerf
