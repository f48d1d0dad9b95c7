// What `kerf bench tick` prints.
#pragma once

#include <string>
#include <vector>

#include "experiment/bench/cut_case.h"

namespace kerf {

/// What was measured, and where.
struct TickReport {
  std::vector<BenchResult> results;
  MachineState machine;  // before the run
  int core = 0;
  bool realtime = false;
  int ticks = 0;             // asked for
  std::string vector_width;  // of the removal, as its instruction set is called
};

/// Sentences about what makes the figures doubtful: a busy machine, a tool that did not follow. Empty: nothing.
std::vector<std::string> FindTickDoubts(const TickReport& report);

std::string FormatTickTable(const TickReport& report);     // for a terminal
std::string FormatTickMarkdown(const TickReport& report);  // for a README
std::string FormatTickJson(const TickReport& report);

}  // namespace kerf
