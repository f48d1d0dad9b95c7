// The newest value from one thread to another, neither ever waiting.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace kerf {

/// One writer, one reader. The writer fills back() and publishes; the reader sees the newest published value, may skip
/// some, and never sees one half written. Both sides wait-free: one atomic exchange. Tick-safe when T's assignment is.
template <typename T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& initial) : slots_{Slot{initial}, Slot{initial}, Slot{initial}} {}

  // ---- the writer's
  /// Holds what was published two or three times before: fill all of it.
  T& back() { return slots_[back_].value; }
  void Publish() { back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh)) & kIndex; }
  void Publish(const T& value) {
    back() = value;
    Publish();
  }

  // ---- the reader's
  /// Takes the newest value; false when there is none since the last call.
  bool Update() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_) & kIndex;
    return true;
  }
  const T& front() const { return slots_[front_].value; }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kFresh = 4;
  // On cache lines of their own, so that the two threads don't slow each other.
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_;
  alignas(64) std::uint8_t back_ = 0;                // the writer's
  alignas(64) std::uint8_t front_ = 1;               // the reader's
  alignas(64) std::atomic<std::uint8_t> middle_{2};  // nobody's, with kFresh when the reader has not seen it
};

}  // namespace kerf
