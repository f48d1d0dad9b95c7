#include "bone/grid/spare_leaves.h"

#include <utility>

namespace kerf {

SpareLeaves::~SpareLeaves() {
  while (Leaf* const* leaf = supplied_.Peek()) {
    delete *leaf;
    supplied_.Pop();
  }
}

std::unique_ptr<SpareLeaves::Leaf> SpareLeaves::Take(const openvdb::Coord& origin) {
  std::unique_ptr<Leaf> leaf;
  if (Leaf* const* const supplied = supplied_.Peek()) {
    leaf.reset(*supplied);
    supplied_.Pop();
  } else {
    leaf = std::move(own_.back());
    own_.pop_back();
  }
  count_.fetch_sub(1, std::memory_order_relaxed);
  leaf->setOrigin(origin);
  return leaf;
}

void SpareLeaves::Return(std::unique_ptr<Leaf> leaf) {
  leaf->buffer().fill(value_);
  own_.push_back(std::move(leaf));
  count_.fetch_add(1, std::memory_order_relaxed);
}

void SpareLeaves::Refill(int count) {
  for (; this->count() < count; count_.fetch_add(1, std::memory_order_relaxed)) own_.push_back(Make());
}

void SpareLeaves::Supply(int count) {
  while (this->count() < count) {
    Leaf** const slot = supplied_.Claim();
    if (slot == nullptr) return;
    *slot = Make().release();
    supplied_.Push();
    count_.fetch_add(1, std::memory_order_release);
  }
}

std::size_t SpareLeaves::CalcMemoryBytes() const {
  return own_.capacity() * sizeof(own_[0]) + supplied_.capacity() * sizeof(Leaf*) +
         static_cast<std::size_t>(count()) * (sizeof(Leaf) + Leaf::SIZE * sizeof(float));
}

}  // namespace kerf
