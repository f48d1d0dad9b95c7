#include "bone/grid/leaf_history.h"

#include <algorithm>

namespace kerf {

LeafHistory::LeafHistory(const BoneField& field, std::size_t ring_leaves)
    : origin_(field.origin_leaf()),
      inside_mm_(static_cast<float>(-field.band_mm())),
      epochs_(field.place_count(), 0),
      ring_(ring_leaves) {}

void LeafHistory::Note(std::size_t place, const LeafIndex& leaf, const float* values) {
  epochs_[place] = epoch_;
  if (last_lost_.load(std::memory_order_relaxed) == epoch_) return;  // this epoch is lost anyway
  LeafBefore* before = ring_.Claim();
  if (before == nullptr) {
    last_lost_.store(epoch_, std::memory_order_release);
    return;
  }
  before->kind = values == nullptr ? LeafBefore::Kind::kInside : LeafBefore::Kind::kValues;
  before->epoch = epoch_;
  before->index = {origin_.x + leaf.x, origin_.y + leaf.y, origin_.z + leaf.z};
  if (values != nullptr) std::copy_n(values, before->values.size(), before->values.begin());
  ring_.Push();
  ++pushed_;
}

bool LeafHistory::Checkpoint(std::uint32_t number, const std::array<double, 256>& figures) {
  LeafBefore* before = ring_.Claim();
  if (before == nullptr) return false;
  ++epoch_;
  before->kind = LeafBefore::Kind::kCheckpoint;
  before->number = number;
  before->epoch = epoch_;
  before->values = std::bit_cast<std::array<float, 512>>(figures);
  ring_.Push();
  ++pushed_;
  return true;
}

bool LeafHistory::Touch(std::size_t place) {
  if (epochs_[place] == epoch_) return false;
  epochs_[place] = epoch_;
  return true;
}

std::size_t LeafHistory::CalcMemoryBytes() const {
  return sizeof(*this) + epochs_.capacity() * sizeof(std::uint32_t) + ring_.capacity() * sizeof(LeafBefore);
}

}  // namespace kerf
