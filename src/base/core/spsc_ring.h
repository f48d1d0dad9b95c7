// Bounded wait-free queue from one thread to another.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

namespace kerf {

/// One writer, one reader. Allocates only in the constructor. Tick-safe if T's assignment is.
template <typename T>
class SpscRing {
 public:
  /// Holds at least `capacity` values, 1 or more.
  explicit SpscRing(std::size_t capacity) : slots_(std::bit_ceil(capacity > 0 ? capacity : 1)) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  std::size_t capacity() const { return slots_.size(); }

  // ---- writer
  /// Returns the next slot to fill, or nullptr if the ring is full. Push() passes it to the reader.
  T* Claim() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == slots_.size()) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == slots_.size()) return nullptr;
    }
    return &slots_[tail & (slots_.size() - 1)];
  }
  void Push() { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Returns the n-th value pushed since the start, even if it has already been read. Returns nullptr if fewer values
  /// were pushed or the slot has been claimed again.
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

  // ---- reader
  /// Returns the oldest value, or nullptr if the ring is empty. Valid until Pop().
  const T* Peek() {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return nullptr;
    }
    return &slots_[head & (slots_.size() - 1)];
  }
  /// Call only after a Peek() that returned a value.
  void Pop() { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::vector<T> slots_;
  // The counters of each side are on a separate cache line. They only grow; their difference is the number of values.
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;
  alignas(64) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;
};

}  // namespace kerf
