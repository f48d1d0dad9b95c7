// Detects whether the machine stalled while a test ran. A shared machine stalls now and then for a second or two, which
// affects code that waits by the clock. The result depends only on the machine, not on the code under test.
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

/// The longest time between two calls of Look(), which is meant to be called every millisecond. One thread calls
/// Look(); any thread may query the result.
class LongestGap {
 public:
  using Clock = std::chrono::steady_clock;

  void Look() {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    if (last_ != 0) longest_ = std::max(longest_.load(), now - last_.load());
    last_ = now;
  }
  Clock::duration Longest() const { return Clock::duration(longest_.load()); }
  /// Duration of the present gap; 0 before the first look.
  Clock::duration SinceLast() const {
    const Clock::rep last = last_;  // read before the clock, so that the difference is not negative
    return Clock::duration(last == 0 ? 0 : Clock::now().time_since_epoch().count() - last);
  }

 private:
  std::atomic<Clock::rep> last_{0};
  std::atomic<Clock::rep> longest_{0};
};

/// A thread that only sleeps for a millisecond at a time. If it sleeps for long, so do other threads.
class StallDetector {
 public:
  StallDetector() {
    gap_.Look();
    thread_ = std::thread([this] { Watch(); });
  }
  ~StallDetector() {
    stop_ = true;
    thread_.join();
  }
  StallDetector(const StallDetector&) = delete;
  StallDetector& operator=(const StallDetector&) = delete;

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

/// Maximum number of runs of a test that may fail because the machine stalls.
constexpr int kMaxTries = 5;

/// Runs `check`, which contains EXPECTs and ASSERTs. If one of them fails in this thread and the machine stalled for
/// longer than `max_stall`, the run is inconclusive and is repeated, with at most kMaxTries runs in all. Failures of
/// the last run fail the test. `check` may also call own.Look() at a place that runs every millisecond.
inline void RetryIfStalled(std::chrono::milliseconds max_stall, const std::function<void(LongestGap& own)>& check) {
  for (int i = 1; i <= kMaxTries; ++i) {
    testing::TestPartResultArray results;
    LongestGap own;
    LongestGap::Clock::duration longest{0};
    {
      const testing::ScopedFakeTestPartResultReporter reporter(
          testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
      const StallDetector detector;
      check(own);
      longest = std::max(detector.Longest(), own.Longest());
    }
    int failures = 0;
    for (int k = 0; k < results.size(); ++k) failures += results.GetTestPartResult(k).failed() ? 1 : 0;
    if (failures == 0) return;
    const double longest_s = std::chrono::duration<double>(longest).count();
    if (longest > max_stall && i < kMaxTries) {
      std::cout << "the machine stalled for " << longest_s << " s; the test is repeated\n";
      continue;
    }
    for (int k = 0; k < results.size(); ++k) {
      const testing::TestPartResult& result = results.GetTestPartResult(k);
      if (!result.failed()) continue;
      ADD_FAILURE_AT(result.file_name() != nullptr ? result.file_name() : "", result.line_number())
          << result.message() << "\n(run " << i << "; the machine stalled for " << longest_s << " s at most)";
    }
    return;
  }
}

}  // namespace kerf::test
