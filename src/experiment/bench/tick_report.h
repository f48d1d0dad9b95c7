// Output of `kerf bench tick`.
#pragma once

#include <string>
#include <vector>

#include "experiment/bench/cut_case.h"

namespace kerf {

/// The results, and the machine they were measured on.
struct TickReport {
  std::vector<BenchResult> results;
  MachineState machine;  // before the run
  int core = 0;
  bool realtime = false;
  int ticks = 0;             // requested number
  std::string vector_width;  // instruction set that the removal uses
};

/// Describes conditions that make the figures doubtful, in one sentence each, e.g. a busy machine or a tool that did
/// not follow the handle. Empty if there are none.
std::vector<std::string> FindTickWarnings(const TickReport& report);

std::string FormatTickTable(const TickReport& report);     // for a terminal
std::string FormatTickMarkdown(const TickReport& report);  // for a README
std::string FormatTickJson(const TickReport& report);

}  // namespace kerf
