// How time and memory grow with the size of a task: `kerf bench growth`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/table/run_info.h"
#include "base/table/table.h"
#include "experiment/bench/cut_case.h"

namespace kerf {

struct GrowthOptions {
  int ticks = 1000;  // of each cut; at most 5 mm of it
  int core = 0;
  bool realtime = false;
  std::function<void(const std::string& what, double fraction)> progress;
};
template <typename V>
void Describe(GrowthOptions& p, V&& visit) {
  visit("ticks", p.ticks, Range{100, 100'000}, "ticks measured of each cut; a cut that is too short is repeated");
  DescribeCore(p.core, visit);
}

/// One cut, with one value of the quantity that grows.
struct GrowthPoint {
  double value = 0;
  double tick_p50_us = 0;
  double tick_p99_us = 0;
  double bone_MB = 0;          // memory of the bone before the cut
  double simulation_MB = 0;    // memory of the simulation, of which most is leaves in reserve
  double computed_voxels = 0;  // by removal, per tick
  double samples = 0;          // of the bone by contact, per tick
  std::uint64_t hash = 0;      // of the bone after the cut
};

/// The exponent of a figure as a power of the quantity: the slope of the logarithms by least squares. `limit` is what
/// the surface or the edge that is worked on would give.
struct GrowthExponent {
  double limit = 0;
  double measured = 0;
  /// Returns whether the figure grows no more than by the limit, and 0.1 for the noise of times.
  bool within() const { return limit < 0 ? measured >= limit - 0.1 : measured <= limit + 0.1; }
};

/// Cuts that differ in one quantity.
struct GrowthSeries {
  std::string quantity;  // with its unit
  std::string why;       // the reason for the limits
  bool is_power = true;  // false: the quantity starts at 0, so that there are no exponents
  std::vector<GrowthPoint> points;
  GrowthExponent tick;  // of tick_p50_us
  GrowthExponent bone;  // of bone_MB
  GrowthExponent simulation;
};

struct GrowthReport {
  std::vector<GrowthSeries> series;
  GrowthOptions options;
  RunInfo run;
};

/// Cuts of a series without results. Each is a change of the cut "disc-0.1".
struct GrowthPlan {
  GrowthSeries series;
  std::vector<std::pair<double, CutCase>> cuts;  // value of the quantity, and the cut
};
std::vector<GrowthPlan> PlanGrowth();

/// Runs all cuts of the plan. Throws Error if a value is out of range or the core does not exist.
GrowthReport MeasureGrowth(const std::vector<GrowthPlan>& plan, const GrowthOptions& options);

/// A point with the quantity that it belongs to: a row of growth.csv.
struct GrowthRow {
  std::string quantity;
  GrowthPoint point;
};
/// Describes the columns of growth.csv.
const Columns<GrowthRow>& GrowthColumns();
std::string FormatGrowthTable(const GrowthReport& report);     // for a terminal
std::string FormatGrowthMarkdown(const GrowthReport& report);  // for docs/benchmarks.md
/// Writes growth.csv and growth.png. Throws Error if a file cannot be written.
void WriteGrowth(const GrowthReport& report, const std::string& folder);

}  // namespace kerf
