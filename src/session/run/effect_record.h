// Channels of a run's effects: columns of its log and values of its summary.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kerf {

class EffectPlan;

/// Statistics of one channel of an effect over a run.
struct EffectFigure {
  std::string effect;
  std::string name;  // including its unit
  double last = 0;
  double smallest = 0;
  double largest = 0;
  double sum = 0;  // over all ticks
  std::string column() const { return effect + "_" + name; }
};

/// Record of all effects' channels. If the scene has no effects, it and the texts made from it are empty.
struct EffectRecord {
  EffectRecord() = default;
  explicit EffectRecord(const EffectPlan& plan);

  /// Adds a tick's channels, in the order of `figures`.
  void Take(std::span<const double> channels);
  /// Does the same, and also adds a row to the log.
  void TakeRow(std::span<const double> channels);

  EffectRecord WithoutRows() const;

  bool empty() const { return on.empty() && left_out.empty(); }
  /// Returns the columns, such as ",spindle_rpm,heat_peak_C".
  std::string Header() const;
  /// Returns the row's values, each preceded by a comma.
  std::string Row(std::size_t row) const;

  std::vector<std::string> on;        // enabled effects
  std::vector<std::string> left_out;  // effects that were left out because they need a hand
  std::vector<EffectFigure> figures;
  std::vector<double> rows;  // figures.size() values per row
  std::size_t ticks = 0;
};

/// Returns a row of the log: values, each preceded by a comma.
std::string FormatEffectRow(std::span<const double> channels);

/// Returns a readable phrase per effect, such as "spindle: rpm 7312 (6840 to 7500)": with the last value and the range.
std::vector<std::string> DescribeEffects(const EffectRecord& record);

}  // namespace kerf
