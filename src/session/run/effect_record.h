// What the effects of a run told, tick by tick: columns of its log, and figures of its summary.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kerf {

class EffectPlan;

/// A channel of an effect over a run.
struct EffectFigure {
  std::string effect;
  std::string name;  // with its unit
  double last = 0;
  double smallest = 0;
  double largest = 0;
  double sum = 0;  // over all ticks
  std::string column() const { return effect + "_" + name; }
};

/// Of a scene without effects it is empty, and so is all that is made of it.
struct EffectRecord {
  EffectRecord() = default;
  explicit EffectRecord(const EffectPlan& plan);

  /// A tick's channels, in the order of `figures`.
  void Take(std::span<const double> channels);
  /// The same, and a row of the log.
  void TakeRow(std::span<const double> channels);

  bool empty() const { return on.empty() && left_out.empty(); }
  /// ",spindle_rpm,heat_peak_C".
  std::string Header() const;
  /// Of the row, behind a comma each.
  std::string Row(std::size_t row) const;

  std::vector<std::string> on;        // effects
  std::vector<std::string> left_out;  // that need a hand where there is none
  std::vector<EffectFigure> figures;
  std::vector<double> rows;  // as many as figures for each
  std::size_t ticks = 0;
};

/// Figures of a row of the log, behind a comma each.
std::string FormatEffectRow(std::span<const double> channels);

/// For people, a phrase for each effect: "spindle: rpm 7312 (6840 to 7500)"; the last value, and all between.
std::vector<std::string> DescribeEffects(const EffectRecord& record);

}  // namespace kerf
