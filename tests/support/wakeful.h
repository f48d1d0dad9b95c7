// Whether the machine stood still while a test ran: a shared one does now and then, for a second or two, and what waits
// by the clock sees that. It judges the machine, never the code under test.
#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iostream>
#include <thread>

namespace kerf::test {

/// The longest time between two looks at the clock, by somebody who means to look each millisecond. One thread looks,
/// any may ask.
class LongestGap {
 public:
  using Clock = std::chrono::steady_clock;

  void Look() {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    if (last_ != 0) longest_ = std::max(longest_.load(), now - last_.load());
    last_ = now;
  }
  Clock::duration Longest() const { return Clock::duration(longest_.load()); }
  /// That which has not ended yet; 0 before the first look.
  Clock::duration SinceLast() const {
    const Clock::rep last = last_;  // before the clock, which must not be behind it
    return Clock::duration(last == 0 ? 0 : Clock::now().time_since_epoch().count() - last);
  }

 private:
  std::atomic<Clock::rep> last_{0};
  std::atomic<Clock::rep> longest_{0};
};

/// A thread that does nothing but sleep, a millisecond at a time: when it slept for long, so did others.
class Wakeful {
 public:
  Wakeful() {
    gap_.Look();
    thread_ = std::thread([this] { Watch(); });
  }
  ~Wakeful() {
    stop_ = true;
    thread_.join();
  }
  Wakeful(const Wakeful&) = delete;
  Wakeful& operator=(const Wakeful&) = delete;

  LongestGap::Clock::duration Longest() const { return std::max(gap_.SinceLast(), gap_.Longest()); }

 private:
  void Watch() {
    while (!stop_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      gap_.Look();
    }
  }

  LongestGap gap_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// So often is a test begun that a machine which stands still can spoil.
constexpr int kMostTries = 5;

/// Runs `judge` with its EXPECTs and ASSERTs. Where one of this thread failed, and the machine stood still for longer
/// than `most` meanwhile, nothing is known: once more from the beginning, kMostTries times in all. What failed in the
/// last run fails the test. `judge` may look at its own gap too, from where it comes by each millisecond.
inline void JudgeAwake(std::chrono::milliseconds most, const std::function<void(LongestGap& own)>& judge) {
  for (int i = 1; i <= kMostTries; ++i) {
    testing::TestPartResultArray results;
    LongestGap own;
    LongestGap::Clock::duration longest{0};
    {
      const testing::ScopedFakeTestPartResultReporter reporter(
          testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
      const Wakeful awake;
      judge(own);
      longest = std::max(awake.Longest(), own.Longest());
    }
    int failures = 0;
    for (int k = 0; k < results.size(); ++k) failures += results.GetTestPartResult(k).failed() ? 1 : 0;
    if (failures == 0) return;
    const double longest_s = std::chrono::duration<double>(longest).count();
    if (longest > most && i < kMostTries) {
      std::cout << "the machine stood still for " << longest_s << " s: once more\n";
      continue;
    }
    for (int k = 0; k < results.size(); ++k) {
      const testing::TestPartResult& result = results.GetTestPartResult(k);
      if (!result.failed()) continue;
      ADD_FAILURE_AT(result.file_name() != nullptr ? result.file_name() : "", result.line_number())
          << result.message() << "\n(run " << i << "; the machine stood still for " << longest_s << " s at most)";
    }
    return;
  }
}

}  // namespace kerf::test
