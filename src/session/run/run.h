// A scene run from beginning to end without a window: the path is followed exactly and the force is what it costs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kerf/simulation.h"
#include "session/run/effect_files.h"
#include "session/run/effect_record.h"
#include "session/run/fragments_report.h"
#include "session/run/heat_report.h"
#include "session/run/stage_costs.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

class RunTap;

/// Of one run: five hours and a half at 1 kHz. All its ticks are kept until its pictures are drawn.
inline constexpr double kMostRunTicks = 20'000'000;

/// One tick, as logged.
struct TickRecord {
  double time_s = 0;  // path time at the end of the tick
  std::size_t segment = 0;
  Pose X_WT;             // at the end of the tick
  double travel_mm = 0;  // of the disc's centre since this segment's first contact; 0 before
  bool touched = false;  // this segment has met bone
  TickOutput out;
};

/// How long ticks took, microseconds.
struct TickTimes {
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

struct RunResult {
  Bone bone;  // after the cut
  std::vector<TickRecord> ticks;
  EffectRecord effects;  // a row of it for each tick
  std::array<double, 256> removed_mm3_by_region{};
  double removed_mm3 = 0;
  TickTimes times;
  std::optional<StageCosts> costs;
  double wall_s = 0;  // of the ticks alone
  std::optional<HeatReport> heat;
  std::optional<FragmentsReport> fragments;
  EffectFiles files;
};

/// Throws Error, with the bytes that they would take, when a run has more ticks than kMostRunTicks or than there is
/// memory for. For asking before long work; RunPath asks too.
void CheckRunTicks(const Path& path, double rate_hz);

/// Runs all ticks of `path`, or as many as `tap` (session/run_tap.h; may be null) lets it. `progress` gets 0..1; may be
/// empty. Throws Error for parameters out of range.
RunResult RunPath(Bone bone, const SimulationParams& params, const Path& path, double rate_hz, double rpm,
                  const std::function<void(double)>& progress, const CostOptions& costs = {}, RunTap* tap = nullptr);

/// Nearest-rank percentiles; all 0 for none.
TickTimes CalcTickTimes(std::vector<double> microseconds);

/// One row a tick (or every `every`th); units in the header. docs/formats.md says what each column is.
/// `effects`, with a row for each tick, adds its columns; null: none.
std::string FormatForceLog(const std::vector<TickRecord>& ticks, int every, const EffectRecord* effects = nullptr);
/// The same straight into a file, in memory for some rows only. Throws Error.
void WriteForceLog(const std::string& path, const std::vector<TickRecord>& ticks, int every,
                   const EffectRecord* effects = nullptr);

}  // namespace kerf
