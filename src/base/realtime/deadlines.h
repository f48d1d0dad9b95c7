// Deadlines of ticks: whole multiples of the period after the start, regardless of whether earlier ticks were late.
#pragma once

#include <algorithm>
#include <cstdint>

namespace kerf {

/// Times are nanoseconds of any one clock. Tick-safe; uses no clock.
///
/// A tick that has not begun when the next one is due is missed: it is skipped and counted, and not made up for later.
/// Two ticks begin at least a quarter of a period apart: if less time is left after a late tick, the next deadline is
/// skipped.
class Deadlines {
 public:
  /// `period_ns` > 0.
  explicit Deadlines(std::int64_t period_ns) : period_ns_(period_ns) {}

  /// The first tick is due one period after `now_ns`.
  void Start(std::int64_t now_ns) {
    due_ns_ = now_ns + period_ns_;
    last_ns_ = now_ns;
  }
  std::int64_t due_ns() const { return due_ns_; }

  struct Tick {
    std::int64_t due_ns = 0;
    std::int64_t late_ns = 0;  // since the deadline that was awaited, which may be a skipped one; >= 0
    std::int64_t skipped = 0;  // number of deadlines without a tick between the last tick and this one
  };
  /// Begins the tick that is due at `now_ns` >= due_ns(). Its deadline is the last one that has passed.
  Tick Begin(std::int64_t now_ns) {
    Tick tick;
    tick.late_ns = std::max<std::int64_t>(now_ns - due_ns_, 0);
    due_ns_ += tick.late_ns / period_ns_ * period_ns_;
    tick.due_ns = due_ns_;
    tick.skipped = (due_ns_ - last_ns_) / period_ns_ - 1;
    last_ns_ = due_ns_;
    began_ns_ = now_ns;
    return tick;
  }
  /// Ends the tick: finds the next deadline after `now_ns`.
  void End(std::int64_t now_ns) {
    const std::int64_t earliest_ns = std::max(now_ns + 1, began_ns_ + period_ns_ / 4);
    const std::int64_t ahead_ns = std::max(earliest_ns - due_ns_, period_ns_);
    due_ns_ += (ahead_ns + period_ns_ - 1) / period_ns_ * period_ns_;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;
  std::int64_t last_ns_ = 0;   // deadline of the last tick
  std::int64_t began_ns_ = 0;  // time at which the last tick actually began
};

}  // namespace kerf
