// What leaves were before they changed, handed from the tick to whoever keeps it.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/core/spsc_ring.h"
#include "bone/grid/field.h"

namespace kerf {

/// A leaf as it was when it was first changed after a checkpoint, or a checkpoint.
struct LeafBefore {
  enum class Kind : std::uint8_t {
    kValues,
    kInside,      // all of it pure bone: the values are not filled in
    kCheckpoint,  // a number and figures
  };
  Kind kind = Kind::kValues;
  std::uint32_t number = 0;       // of a checkpoint
  std::uint32_t epoch = 0;        // rises by one with each checkpoint and twice with each restore
  std::array<int, 3> index{};     // of the world, as ChangedLeaf
  std::array<float, 512> values;  // mm, z fastest, y next; of a checkpoint its figures() lie there

  /// Of a checkpoint: what whoever made it needs to come back to it.
  std::array<double, 256> figures() const { return std::bit_cast<std::array<double, 256>>(values); }
};

/// The writer is the thread that changes the field, the tick's; the reader any other, or the same between ticks. All
/// memory is taken when it is made: the ring, and four bytes for each leaf of the field's box.
///
/// When the ring is full a leaf's old values are lost. Then last_lost() tells the epoch: what is earlier than that
/// can't be come back to, and no wrong values ever come of it.
class LeafHistory {
 public:
  /// For BoneField::set_history(). Allocates.
  LeafHistory(const BoneField& field, std::size_t ring_leaves);
  /// phi in pure bone.
  float inside_mm() const { return inside_mm_; }

  // ---- the writer's: tick-safe
  /// Whether the leaf's old values are not there yet.
  bool Wants(std::size_t place) const { return epochs_[place] != epoch_; }
  /// `values`: null for pure bone. To be called before the leaf changes, when it is wanted.
  void Note(std::size_t place, const LeafIndex& leaf, const float* values);
  /// From here on each leaf is noted anew. False, and nothing done, when the ring is full.
  bool Checkpoint(std::uint32_t number, const std::array<double, 256>& figures);
  /// Begins an epoch of its own, in which Touch() tells what has been put back; ends it, and tells the next.
  void BeginRestore() { ++epoch_; }
  std::uint32_t EndRestore() { return ++epoch_; }
  /// True the first time for each leaf in this epoch; it is not noted in it any more.
  bool Touch(std::size_t place);
  /// So many were pushed since the start.
  std::size_t pushed() const { return pushed_; }
  /// The n-th that was pushed, whether it has been read or not; null when its slot is used again.
  const LeafBefore* At(std::size_t n) const { return ring_.At(n); }

  // ---- the reader's
  SpscRing<LeafBefore>& ring() { return ring_; }

  // ---- any thread
  /// The latest epoch in which a leaf's old values were lost; 0: never.
  std::uint32_t last_lost() const { return last_lost_.load(std::memory_order_acquire); }
  std::size_t CalcMemoryBytes() const;

 private:
  LeafIndex origin_;
  float inside_mm_;
  std::vector<std::uint32_t> epochs_;  // of each place: in which it was noted last
  std::uint32_t epoch_ = 1;
  std::size_t pushed_ = 0;
  SpscRing<LeafBefore> ring_;
  std::atomic<std::uint32_t> last_lost_{0};
};

}  // namespace kerf
