// A small hash map from leaf origins to indices that is emptied in no time and allocates only while it grows.
#pragma once

#include <openvdb/math/Coord.h>

#include <cstdint>
#include <vector>

#include "core/hash.h"

namespace kerf {

class LeafMap {
 public:
  LeafMap() : slots_(1024) {}

  void Clear() {
    ++generation_;
    count_ = 0;
  }

  /// The index of `origin`, or -1. Tick-safe.
  int Find(const openvdb::Coord& origin) const {
    for (std::size_t i = Home(origin);; i = (i + 1) & (slots_.size() - 1)) {
      const Slot& slot = slots_[i];
      if (slot.generation != generation_) return -1;
      if (slot.origin == origin) return slot.index;
    }
  }

  /// Gives `origin` an index; false when it has one already (which then stays).
  bool Insert(const openvdb::Coord& origin, int index) {
    if (2 * (count_ + 1) > slots_.size()) Grow();
    for (std::size_t i = Home(origin);; i = (i + 1) & (slots_.size() - 1)) {
      Slot& slot = slots_[i];
      if (slot.generation != generation_) {
        slot = {generation_, origin, index};
        ++count_;
        return true;
      }
      if (slot.origin == origin) return false;
    }
  }

 private:
  struct Slot {
    std::uint64_t generation = 0;
    openvdb::Coord origin;
    int index = -1;
  };

  std::size_t Home(const openvdb::Coord& c) const {
    const auto bits = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v >> 3) & 0x1fffffu); };
    return MixHash(bits(c.x()) << 42 | bits(c.y()) << 21 | bits(c.z())) & (slots_.size() - 1);
  }

  void Grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    count_ = 0;
    for (const Slot& slot : old) {
      if (slot.generation == generation_) Insert(slot.origin, slot.index);
    }
  }

  std::vector<Slot> slots_;
  std::uint64_t generation_ = 1;
  std::size_t count_ = 0;
};

}  // namespace kerf
