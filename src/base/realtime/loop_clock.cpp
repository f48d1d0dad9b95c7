#include "base/realtime/loop_clock.h"

#include <cerrno>
#include <ctime>

namespace kerf {

namespace {
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
}  // namespace

std::int64_t MonotonicClock::Now() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return kNsPerSecond * now.tv_sec + now.tv_nsec;
}

void MonotonicClock::SleepUntil(std::int64_t time_ns) noexcept {
  timespec until{};
  until.tv_sec = time_ns / kNsPerSecond;
  until.tv_nsec = time_ns % kNsPerSecond;
  // A signal handler may interrupt the sleep.
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

void MonotonicClock::Burn(std::int64_t ns) noexcept {
  const std::int64_t until = Now() + ns;
  while (Now() < until) {
  }
}

}  // namespace kerf
