#include "experiment/bench/measure.h"

#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>

#include "kerf/error.h"

namespace kerf {

std::int64_t ReadClock_ns() {
  return MonotonicClock().Now();
}

Disturbances CountDisturbances() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_nivcsw, usage.ru_minflt + usage.ru_majflt};
}

std::vector<double> UndisturbedStages::CalcMeans_us() const {
  std::vector<double> means(kTickStages, 0);
  for (std::size_t i = 0; i < means.size() && ticks_ > 0; ++i) {
    const LogHistogram& times = timer_.times(static_cast<TickStage>(i));
    means[i] = times.CalcMean_us() * static_cast<double>(times.total()) / static_cast<double>(ticks_);
  }
  return means;
}

const char* NameOfStage(std::size_t stage) {
  return ToString(static_cast<TickStage>(stage));
}

PinnedToCore::PinnedToCore(int core, bool realtime) : before_(sizeof(cpu_set_t)) {
  cpu_set_t set;
  CPU_ZERO(&set);
  bool possible = sched_getaffinity(0, sizeof(set), &set) == 0;
  std::memcpy(before_.data(), &set, sizeof(set));
  possible = possible && core >= 0 && core < CPU_SETSIZE && CPU_ISSET(core, &set);
  CPU_ZERO(&set);
  if (possible) CPU_SET(core, &set);
  if (!possible || sched_setaffinity(0, sizeof(set), &set) != 0) {
    throw Error(fmt::format("can't pin this program to core {}; choose a core that it is allowed to use", core));
  }
  sched_param parameters{};
  policy_before_ = sched_getscheduler(0);
  sched_getparam(0, &parameters);
  priority_before_ = parameters.sched_priority;
  parameters.sched_priority = sched_get_priority_min(SCHED_FIFO);
  if (realtime && sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
    std::memcpy(&set, before_.data(), sizeof(set));
    sched_setaffinity(0, sizeof(set), &set);
    throw Error(
        "the system does not allow this program real-time scheduling; omit --realtime, or raise the limit (ulimit -r)");
  }
}
PinnedToCore::~PinnedToCore() {
  sched_param parameters{};
  parameters.sched_priority = priority_before_;
  sched_setscheduler(0, policy_before_, &parameters);
  cpu_set_t set;
  std::memcpy(&set, before_.data(), sizeof(set));
  sched_setaffinity(0, sizeof(set), &set);
}

}  // namespace kerf
