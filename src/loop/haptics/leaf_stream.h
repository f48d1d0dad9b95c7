// Stream of the bone's changed leaves, from the loop to a reader.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/core/spsc_ring.h"

namespace kerf {

/// A leaf as it was in some tick, with its values of the cut (see SetCut() in src/bone/grid/set_leaf.h).
struct LeafMessage {
  std::array<int, 3> index{};
  std::array<float, 512> values{};
};

/// The loop's end of the stream. Changed leaves wait in a queue, each at most once. A few are sent in each tick, oldest
/// first, with the values that they have then. Every leaf is sent eventually, so that after the bone has stopped
/// changing, the reader receives its final state.
class LeafPublisher {
 public:
  /// The queue holds at most `max_waiting` leaves (1 or more). Allocates.
  LeafPublisher(SpscRing<LeafMessage>& ring, std::size_t max_waiting);

  /// Queues a changed leaf; if it is queued already, only updates `values`. `values` (512) are read when the leaf is
  /// sent and must stay valid until then. `time_s`: time of the tick. Returns false if the queue is full. Tick-safe.
  bool Mark(const std::array<int, 3>& index, const float* values, double time_s = 0);
  /// Sends up to `at_most` leaves, as far as the ring has room, and returns their number. Tick-safe.
  int Send(int at_most);
  std::size_t waiting() const { return count_; }
  /// Time at which the leaf at the head of the queue was first marked. Undefined if the queue is empty.
  double oldest_s() const { return line_[first_].marked_s; }

 private:
  struct Waiting {
    std::array<int, 3> index{};
    const float* values = nullptr;
    double marked_s = 0;
  };
  std::size_t HomeOf(const std::array<int, 3>& index) const;
  std::size_t FindSlot(const std::array<int, 3>& index) const;
  void Forget(const std::array<int, 3>& index);

  SpscRing<LeafMessage>& ring_;
  std::vector<Waiting> line_;  // circular buffer
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  // Hash table (open addressing, linear probing) from a leaf's index to its position in line_. kFree: no entry.
  static constexpr std::uint32_t kFree = 0xffffffff;
  std::vector<std::uint32_t> table_;
};

}  // namespace kerf
