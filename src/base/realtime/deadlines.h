// When ticks are due: at whole multiples of the period after the start, whatever happened to the ones before.
#pragma once

#include <algorithm>
#include <cstdint>

namespace kerf {

/// Times are nanoseconds of one clock. Tick-safe; has no clock of its own.
///
/// A tick that is not begun before the next one is due is missed: it is skipped and counted, never run late and in a
/// row with others. Nor do two ticks begin less than a quarter of a period apart: after one that began later than that,
/// the next waits for the next but one deadline.
class Deadlines {
 public:
  /// `period_ns` > 0.
  explicit Deadlines(std::int64_t period_ns) : period_ns_(period_ns) {}

  /// The first tick is due a period after `now_ns`.
  void Start(std::int64_t now_ns) {
    due_ns_ = now_ns + period_ns_;
    last_ns_ = now_ns;
  }
  std::int64_t due_ns() const { return due_ns_; }

  struct Tick {
    std::int64_t due_ns = 0;
    std::int64_t late_ns = 0;  // since the deadline that was waited for, which may be one of the skipped; >= 0
    std::int64_t skipped = 0;  // deadlines between the last tick's and this one's that had no tick
  };
  /// Begins the tick that is due at `now_ns` >= due_ns(): of all deadlines that have passed, the last.
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
  /// The tick is over: finds the next deadline, after `now_ns`.
  void End(std::int64_t now_ns) {
    const std::int64_t earliest_ns = std::max(now_ns + 1, began_ns_ + period_ns_ / 4);
    const std::int64_t ahead_ns = std::max(earliest_ns - due_ns_, period_ns_);
    due_ns_ += (ahead_ns + period_ns_ - 1) / period_ns_ * period_ns_;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;
  std::int64_t last_ns_ = 0;   // deadline of the last tick
  std::int64_t began_ns_ = 0;  // when it truly began
};

}  // namespace kerf
