// What undo costs: `kerf bench undo`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "experiment/bench/measure.h"

namespace kerf {

struct UndoBenchOptions {
  int rounds = 10;  // of undo and redo after each number of cuts, 1 to 1000
  int core = 0;
  bool realtime = false;
  double voxel_mm = 0.1;               // of the mandible, 0.1 to 1
  std::size_t leaves_per_tick = 1500;  // put back, 1 or more
  std::function<void(const std::string& what, double fraction)> progress;
};

/// Times of going one way, ms: medians and the worst.
struct UndoTimes {
  double prepare_p50_ms = 0, prepare_max_ms = 0;  // by the reader: unpacking
  double tick_p50_us = 0, tick_max_us = 0;        // of putting back, by the loop
  int ticks = 0;
  double all_p50_ms = 0, all_max_ms = 0;  // prepare, and as many ticks of 1 ms, or longer where they take longer
};

struct UndoResult {
  int cuts = 0;
  std::size_t leaves = 0;
  double kept_MB = 0;  // compressed, by the journal
  double raw_MB = 0;   // what it keeps, 2 kB a leaf
  UndoTimes undo, redo;
  std::uint64_t before = 0, cut = 0, undone = 0, redone = 0;  // hashes of the bone
};

struct UndoReport {
  std::vector<UndoResult> results;
  Percentiles with_history, without;  // ticks of the same cut, in turn
  double history_MB = 0;              // its ring and table
  MachineState machine;
  UndoBenchOptions options;
};

/// A disc through the body of the default mandible, 1, 5 and 20 times. Throws Error for a value out of range, and when
/// the bone does not come back to the bit.
UndoReport RunUndoBench(const UndoBenchOptions& options);

std::string FormatUndoTable(const UndoReport& report);     // for a terminal
std::string FormatUndoMarkdown(const UndoReport& report);  // for docs/reliability.md
std::string FormatUndoJson(const UndoReport& report);

}  // namespace kerf
