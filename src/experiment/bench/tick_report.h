// Output of `kerf bench tick`.
#pragma once

#include <string>
#include <vector>

#include "base/table/run_info.h"
#include "experiment/bench/cut_case.h"

namespace kerf {

/// The results, and the machine they were measured on.
struct TickReport {
  std::vector<BenchResult> results;
  RunInfo run;
  int ticks = 0;  // requested number
};

/// Describes conditions that make the figures doubtful, in one sentence each, e.g. a busy machine or a tool that did
/// not follow the handle. Empty if there are none.
std::vector<std::string> FindTickWarnings(const TickReport& report);

std::string FormatTickTable(const TickReport& report);     // for a terminal
std::string FormatTickMarkdown(const TickReport& report);  // for a README
std::string FormatTickJson(const TickReport& report);

}  // namespace kerf
