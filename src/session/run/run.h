// Runs a scene without a window from start to end: the tool follows the path exactly, and the force is the result.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/table.h"
#include "kerf/simulation.h"
#include "session/run/effect_files.h"
#include "session/run/effect_record.h"
#include "session/run/fragments_report.h"
#include "session/run/heat_report.h"
#include "session/run/path_session.h"
#include "session/run/stage_costs.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

/// Maximum number of ticks per run: five and a half hours at 1 kHz. All ticks are kept in memory until the pictures are
/// drawn.
inline constexpr double kMaxRunTicks = 20'000'000;

struct RunResult {
  Bone bone;  // after the cut
  std::vector<TickRecord> ticks;
  EffectRecord effects;  // one row per tick
  std::array<double, 256> removed_mm3_by_region{};
  double removed_mm3 = 0;
  Percentiles times;
  std::optional<StageCosts> costs;
  double wall_s = 0;  // of the ticks alone
  std::optional<HeatReport> heat;
  std::optional<FragmentsReport> fragments;
  EffectFiles files;
};

/// Throws kerf::Error if a run has more ticks than kMaxRunTicks or than fit in memory; the message states their size in
/// bytes. Call it before long work; RunPath() also calls it.
void CheckRunTicks(const Path& path, double rate_hz);

/// Runs all ticks of `path`, or as many as the recording that `tape` replays. `progress` (optional) is
/// called with values from 0 to 1. Throws kerf::Error if a parameter is out of range.
RunResult RunPath(Bone bone, const SimulationParams& params, const Path& path, double rate_hz, double rpm,
                  const std::function<void(double)>& progress, const CostOptions& costs = {},
                  const PathTape& tape = {});

/// A row of forces.csv.
struct ForceRow {
  const TickRecord& tick;
  double removed_mm3 = 0;  // since the previous row
  double total_mm3 = 0;
};
const Columns<ForceRow>& ForceColumns();
/// Returns one row per tick (or per `every` ticks), with the units in the header. docs/formats.md describes the
/// columns. `effects` (optional) has one row per tick and adds its columns.
std::string FormatForceLog(const std::vector<TickRecord>& ticks, int every, const EffectRecord* effects = nullptr);
/// Writes the same text to a file, with only a few rows in memory at a time. Throws kerf::Error.
void WriteForceLog(const std::string& path, const std::vector<TickRecord>& ticks, int every,
                   const EffectRecord* effects = nullptr);

}  // namespace kerf
