// The time and memory that undo takes: `kerf bench undo`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/run_info.h"
#include "experiment/bench/measure.h"

namespace kerf {

struct UndoBenchOptions {
  int rounds = 10;  // after each number of cuts
  int core = 0;
  bool realtime = false;
  double voxel_mm = 0.1;
  std::size_t leaves_per_tick = 1500;
  std::function<void(const std::string& what, double fraction)> progress;
};
template <typename V>
void Describe(UndoBenchOptions& p, V&& visit) {
  visit("rounds", p.rounds, Range{1, 1000}, "repetitions of undo and redo");
  visit("voxel_mm", p.voxel_mm, kBenchVoxelRange_mm, "voxel size of the mandible");
  visit("leaves_per_tick", p.leaves_per_tick, Range{1, 100'000}, "leaves restored in a tick");
  DescribeCore(p.core, visit);
}

/// Times of one direction (undo or redo), ms: medians and maxima.
struct UndoTimes {
  double prepare_p50_ms = 0, prepare_max_ms = 0;  // unpacking, in the thread that keeps the history
  double tick_p50_us = 0, tick_max_us = 0;        // restoring leaves, in the loop
  int ticks = 0;
  double all_p50_ms = 0, all_max_ms = 0;  // preparation plus the ticks, each counted as 1 ms or its actual time if that
                                          // is longer
};

struct UndoResult {
  int cuts = 0;
  std::size_t leaves = 0;
  double kept_MB = 0;  // kept by the journal, compressed
  double raw_MB = 0;   // uncompressed size, 2 kB per leaf
  UndoTimes undo, redo;
  std::uint64_t before = 0, cut = 0, undone = 0, redone = 0;  // hashes of the bone in these states
};

struct UndoReport {
  std::vector<UndoResult> results;
  Percentiles with_history, without;  // ticks of the same cut, measured alternately
  double history_MB = 0;              // size of the history's ring and table
  RunInfo run;
  UndoBenchOptions options;
};

/// Measures undo and redo after 1, 5 and 20 cuts with a disc through the body of the default mandible. Throws Error if
/// a value is out of range, or if the bone is not restored bit for bit.
UndoReport RunUndoBench(const UndoBenchOptions& options);

std::string FormatUndoTable(const UndoReport& report);     // for a terminal
std::string FormatUndoMarkdown(const UndoReport& report);  // for docs/reliability.md
std::string FormatUndoJson(const UndoReport& report);

}  // namespace kerf
