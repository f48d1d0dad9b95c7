// A bounded queue from one thread to another, neither ever waiting.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

namespace kerf {

/// One writer, one reader. All memory is taken when it is made. Tick-safe when T's assignment is.
template <typename T>
class SpscRing {
 public:
  /// Holds at least `capacity` values, 1 or more.
  explicit SpscRing(std::size_t capacity) : slots_(std::bit_ceil(capacity > 0 ? capacity : 1)) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  std::size_t capacity() const { return slots_.size(); }

  // ---- the writer's
  /// The slot to fill next, null when the ring is full. Push() hands it over.
  T* Claim() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == slots_.size()) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == slots_.size()) return nullptr;
    }
    return &slots_[tail & (slots_.size() - 1)];
  }
  void Push() { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// The n-th value pushed since the start, whether it has been read or not: it stays until its slot is claimed again.
  /// Null when that has been, or when there are not so many.
  const T* At(std::size_t n) const {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    return n < tail && tail - n <= slots_.size() ? &slots_[n & (slots_.size() - 1)] : nullptr;
  }
  bool TryPush(const T& value) {
    T* slot = Claim();
    if (slot == nullptr) return false;
    *slot = value;
    Push();
    return true;
  }

  // ---- the reader's
  /// The oldest value, null when there is none. Valid until Pop().
  const T* Peek() {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return nullptr;
    }
    return &slots_[head & (slots_.size() - 1)];
  }
  /// Only after a Peek() that found one.
  void Pop() { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::vector<T> slots_;
  // Each side's counters on a cache line of their own. They only grow; their difference is what the ring holds.
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;
  alignas(64) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;
};

}  // namespace kerf
