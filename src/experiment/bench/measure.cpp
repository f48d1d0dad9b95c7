#include "experiment/bench/measure.h"

#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>

#include "kerf/error.h"
#include "loop/haptics/stage_timer.h"

namespace kerf {

std::int64_t ReadClock_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000000000} * now.tv_sec + now.tv_nsec;
}

long CountInterruptions() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

void StageClock::Enter(TickStage stage) noexcept {
  const std::int64_t now = ReadClock_ns();
  if (now_ < kStages) in_tick_ns_[now_] += now - since_ns_;
  now_ = static_cast<std::size_t>(stage);
  since_ns_ = now;
}
void StageClock::FinishTick() noexcept {
  Enter(TickStage::kEnd);
  const long interruptions = CountInterruptions();
  const bool undisturbed = interruptions == interruptions_;
  interruptions_ = interruptions;
  for (std::size_t i = 0; i < kStages; ++i) {
    if (undisturbed) sum_ns_[i] += in_tick_ns_[i];
    in_tick_ns_[i] = 0;
  }
  if (undisturbed) ++ticks_;
}
std::array<double, StageClock::kStages> StageClock::CalcMeans_us() const {
  std::array<double, kStages> means{};
  for (std::size_t i = 0; i < kStages; ++i) {
    if (ticks_ > 0) means[i] = 1e-3 * static_cast<double>(sum_ns_[i]) / static_cast<double>(ticks_);
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

MachineState LookAtMachine() {
  MachineState machine;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line) && machine.cpu.empty();) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) machine.cpu = line.substr(colon + 2);
  }
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) machine.cores = CPU_COUNT(&set);
  double load = 0;
  if (getloadavg(&load, 1) == 1) machine.load = load;
  return machine;
}

}  // namespace kerf
