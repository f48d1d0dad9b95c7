// Clock of the loop: the machine's clock, or a virtual clock for runs that must not depend on the machine.
#pragma once

#include <cstdint>

namespace kerf {

/// Clock that counts nanoseconds from an arbitrary origin and never goes back. Tick-safe.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  virtual std::int64_t Now() noexcept = 0;
  /// Returns at `time_ns` or later.
  virtual void SleepUntil(std::int64_t time_ns) noexcept = 0;
  /// Lets time pass without sleeping.
  virtual void Burn(std::int64_t ns) noexcept = 0;
};

/// The machine's clock, CLOCK_MONOTONIC.
class MonotonicClock final : public LoopClock {
 public:
  std::int64_t Now() noexcept override;
  void SleepUntil(std::int64_t time_ns) noexcept override;
  void Burn(std::int64_t ns) noexcept override;
};

/// Virtual time that advances only in SleepUntil() and Burn(). For one thread.
class VirtualClock final : public LoopClock {
 public:
  std::int64_t Now() noexcept override { return now_ns_; }
  void SleepUntil(std::int64_t time_ns) noexcept override { now_ns_ = time_ns > now_ns_ ? time_ns : now_ns_; }
  void Burn(std::int64_t ns) noexcept override { now_ns_ += ns; }

 private:
  std::int64_t now_ns_ = 0;
};

}  // namespace kerf
