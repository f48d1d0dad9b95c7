// Histogram of times with logarithmic buckets, from 1 ns to 37 minutes in 9.5 kB. Counts every time.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace kerf {

/// One thread adds times. Other threads may read at the same time and see recent counts. Tick-safe.
///
/// With 32 buckets per octave, a percentile is at most 3.2 % above the true one and never below it. Times are whole
/// nanoseconds, clamped to 0 and 2^41 ns (37 minutes).
class LogHistogram {
 public:
  void Add(std::int64_t ns) {
    const std::uint64_t value = static_cast<std::uint64_t>(std::clamp<std::int64_t>(ns, 0, kTop_ns));
    Bump(counts_[IndexOf(value)], 1);
    Bump(sum_ns_, value);
    if (value > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(value, std::memory_order_relaxed);
    Bump(total_, 1);
  }

  std::uint64_t total() const { return total_.load(std::memory_order_relaxed); }
  double max_us() const { return 1e-3 * static_cast<double>(max_ns_.load(std::memory_order_relaxed)); }
  double CalcMean_us() const {
    const std::uint64_t n = total();
    return n > 0 ? 1e-3 * static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) / static_cast<double>(n) : 0;
  }
  /// Returns the nearest-rank percentile; 0 if the histogram is empty. `fraction`: 0 to 1.
  double CalcPercentile_us(double fraction) const {
    std::uint64_t n = 0;
    for (const auto& count : counts_) n += count.load(std::memory_order_relaxed);
    if (n == 0) return 0;
    const double wanted = std::max(1.0, fraction * static_cast<double>(n));
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      below += counts_[i].load(std::memory_order_relaxed);
      if (static_cast<double>(below) >= wanted - 1e-6) return std::min(UpperEdge_us(i), max_us());
    }
    return max_us();
  }
  /// Returns how many of the times are longer than `us`, accurate to the width of a bucket.
  std::uint64_t CountAbove_us(double us) const {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      if (LowerEdge_us(i) >= us) n += counts_[i].load(std::memory_order_relaxed);
    }
    return n;
  }

  static constexpr std::size_t kBuckets = 37 * 32;
  std::uint64_t count(std::size_t bucket) const { return counts_[bucket].load(std::memory_order_relaxed); }
  /// A bucket counts the times t with LowerEdge_us() <= t <= UpperEdge_us().
  static double LowerEdge_us(std::size_t bucket) { return 1e-3 * static_cast<double>(FirstOf(bucket)); }
  static double UpperEdge_us(std::size_t bucket) { return 1e-3 * static_cast<double>(FirstOf(bucket + 1) - 1); }

 private:
  static constexpr std::int64_t kTop_ns = (std::int64_t{1} << 41) - 1;

  // Below 32 ns there is one bucket per nanosecond; above, the five bits after the leading bit select the bucket.
  static std::size_t IndexOf(std::uint64_t ns) {
    if (ns < 32) return static_cast<std::size_t>(ns);
    const int octave = static_cast<int>(std::bit_width(ns)) - 6;  // 0: 32 to 63
    return static_cast<std::size_t>(32 * (octave + 1)) + static_cast<std::size_t>((ns >> octave) - 32);
  }
  static std::uint64_t FirstOf(std::size_t bucket) {
    if (bucket < 32) return bucket;
    const std::size_t octave = bucket / 32 - 1;
    return (32 + bucket % 32) << octave;
  }
  // With one writer, no atomic read-modify-write is needed.
  template <typename Count>
  static void Bump(Count& count, std::uint64_t by) {
    count.store(count.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> total_{0};
  std::atomic<std::uint64_t> sum_ns_{0};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace kerf
