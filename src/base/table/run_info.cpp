#include "base/table/run_info.h"

#include <fmt/format.h>
#include <sched.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/table/table_json.h"
#include "kerf/version.h"

namespace kerf {

RunInfo ReadRunInfo(std::optional<int> core, bool realtime) {
  RunInfo run;
  run.core = core;
  run.realtime = realtime;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line) && run.cpu.empty();) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) run.cpu = line.substr(colon + 2);
  }
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) run.cores = CPU_COUNT(&set);
  double load = 0;
  if (getloadavg(&load, 1) == 1) run.load = load;
  return run;
}

std::string DescribeRun(const RunInfo& run) {
  return fmt::format("{}, {} core{}{}{}{}; load {:.1f} before the run; commit {}", run.cpu, run.cores,
                     run.cores == 1 ? "" : "s", run.core ? fmt::format(", core {}", *run.core) : "",
                     run.realtime ? " with real-time priority" : "",
                     run.vector_width.empty() ? "" : ", " + run.vector_width, run.load, CommitString());
}

nlohmann::ordered_json RunJson(const RunInfo& run) {
  const std::optional<std::string> width = run.vector_width.empty() ? std::nullopt : std::optional(run.vector_width);
  return {{"kerf", VersionString()},
          {"commit", CommitString()},
          {"compiler", CompilerString()},
          {"machine",
           {{"cpu", run.cpu},
            {"cores", run.cores},
            {"load_before", RoundedJson(run.load)},
            {"core", OrNull(run.core)},
            {"realtime", run.realtime},
            {"vector_width", OrNull(width)}}}};
}

}  // namespace kerf
