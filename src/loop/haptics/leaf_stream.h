// The bone's changed leaves, from the loop to whoever looks at the bone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/core/spsc_ring.h"

namespace kerf {

/// A leaf as it was at some tick: the values of src/bone/grid/set_leaf.h.
struct LeafMessage {
  std::array<int, 3> index{};
  std::array<float, 512> values{};
};

/// The loop's side. What has changed waits in line, each leaf once; a few are sent each tick, oldest first, with the
/// values that they have then. So no leaf starves, and once nothing changes any more everything has been sent as it is.
class LeafPublisher {
 public:
  /// At most `max_waiting` >= 1 leaves wait. Allocates.
  LeafPublisher(SpscRing<LeafMessage>& ring, std::size_t max_waiting);

  /// The leaf has changed; does nothing when it waits already. `values` (512) are read when it is sent: they must stay
  /// where they are. `time_s`: of the tick. False when the line is full. Tick-safe.
  bool Mark(const std::array<int, 3>& index, const float* values, double time_s = 0);
  /// Sends up to `at_most`, as far as the ring has room; returns how many. Tick-safe.
  int Send(int at_most);
  std::size_t waiting() const { return count_; }
  /// When the leaf that has waited longest was marked; of none waiting nothing is known.
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
  std::vector<Waiting> line_;  // a circle
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  // Where in the line a leaf waits, by its index: open addressing, linear probing. kFree: nothing there.
  static constexpr std::uint32_t kFree = 0xffffffff;
  std::vector<std::uint32_t> table_;
};

}  // namespace kerf
