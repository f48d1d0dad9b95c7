#include "loop/haptics/leaf_stream.h"

#include <algorithm>
#include <bit>

namespace kerf {

LeafPublisher::LeafPublisher(SpscRing<LeafMessage>& ring, std::size_t max_waiting)
    : ring_(ring), line_(std::max<std::size_t>(max_waiting, 1)), table_(std::bit_ceil(2 * line_.size()), kFree) {}

std::size_t LeafPublisher::HomeOf(const std::array<int, 3>& index) const {
  std::uint64_t h = 0;
  for (const int i : index) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9e3779b97f4a7c15U;
  return static_cast<std::size_t>(h >> 20) & (table_.size() - 1);
}

/// Returns the leaf's slot in the table, or the free slot where it would be inserted.
std::size_t LeafPublisher::FindSlot(const std::array<int, 3>& index) const {
  std::size_t slot = HomeOf(index);
  while (table_[slot] != kFree && line_[table_[slot]].index != index) slot = (slot + 1) & (table_.size() - 1);
  return slot;
}

bool LeafPublisher::Mark(const std::array<int, 3>& index, const float* values, double time_s) {
  const std::size_t slot = FindSlot(index);
  if (table_[slot] != kFree) {
    line_[table_[slot]].values = values;
    return true;
  }
  if (count_ == line_.size()) return false;
  const std::size_t at = (first_ + count_) % line_.size();
  line_[at] = {index, values, time_s};
  table_[slot] = static_cast<std::uint32_t>(at);
  ++count_;
  return true;
}

void LeafPublisher::Forget(const std::array<int, 3>& index) {
  const std::size_t mask = table_.size() - 1;
  std::size_t hole = FindSlot(index);
  table_[hole] = kFree;
  // Move later entries up that the hole would make unreachable (Knuth, algorithm 6.4 R).
  for (std::size_t slot = (hole + 1) & mask; table_[slot] != kFree; slot = (slot + 1) & mask) {
    const std::size_t home = HomeOf(line_[table_[slot]].index);
    if (((slot - home) & mask) >= ((slot - hole) & mask)) {
      table_[hole] = table_[slot];
      table_[slot] = kFree;
      hole = slot;
    }
  }
}

int LeafPublisher::Send(int at_most) {
  int sent = 0;
  for (; sent < at_most && count_ > 0; ++sent) {
    LeafMessage* message = ring_.Claim();
    if (message == nullptr) break;
    const Waiting& leaf = line_[first_];
    message->index = leaf.index;
    std::copy_n(leaf.values, message->values.size(), message->values.begin());
    ring_.Push();
    Forget(leaf.index);
    first_ = (first_ + 1) % line_.size();
    --count_;
  }
  return sent;
}

}  // namespace kerf
