// Wait-free transfer of the latest value from one thread to another.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace kerf {

/// One writer, one reader. The writer fills back() and publishes it. The reader gets the latest published value, may
/// miss earlier ones, and never reads a partly written one. Each side uses one atomic exchange. Tick-safe if T's
/// assignment is.
template <typename T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& initial) : slots_{Slot{initial}, Slot{initial}, Slot{initial}} {}

  // ---- writer
  /// Returns the value to fill. It contains what was published two or three times before, so fill it completely.
  T& back() { return slots_[back_].value; }
  void Publish() { back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh)) & kIndex; }
  void Publish(const T& value) {
    back() = value;
    Publish();
  }

  // ---- reader
  /// Takes the latest value. Returns false if none was published since the last call.
  bool Update() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_) & kIndex;
    return true;
  }
  const T& front() const { return slots_[front_].value; }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kFresh = 4;
  // On separate cache lines, so that the two threads do not slow each other down.
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_;
  alignas(64) std::uint8_t back_ = 0;                // owned by the writer
  alignas(64) std::uint8_t front_ = 1;               // owned by the reader
  alignas(64) std::atomic<std::uint8_t> middle_{2};  // in transit; kFresh is set until the reader takes it
};

}  // namespace kerf
