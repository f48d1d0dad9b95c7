// The circumstances of a measurement: machine, load and program.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace kerf {

struct RunInfo {
  std::string cpu;           // model name as reported by the system; empty if unknown
  int cores = 0;             // number of cores that this program may use
  double load = 0;           // load average before the run: mean number of programs ready to run in the last minute
  std::optional<int> core;   // core that ran the measured work; none: the system chose
  bool realtime = false;     // the measured work had real-time priority
  std::string vector_width;  // instruction set of the removal; empty if it was not chosen
};

/// Reads cpu, cores and load. `core`, `realtime`: how the work to be measured will run.
RunInfo ReadRunInfo(std::optional<int> core = std::nullopt, bool realtime = false);

/// Describes the run in a sentence without its full stop: "AMD EPYC, 2 cores, core 0 with real-time priority, AVX2;
/// load 0.1 before the run; commit 0123abc".
std::string DescribeRun(const RunInfo& run);
/// Returns an object with the keys kerf, commit, compiler and machine.
nlohmann::ordered_json RunJson(const RunInfo& run);

}  // namespace kerf
