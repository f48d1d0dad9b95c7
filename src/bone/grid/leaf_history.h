// Values of leaves before they changed, passed from the tick to the undo history.
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

/// A leaf as it was before its first change after a checkpoint; or a checkpoint.
struct LeafBefore {
  enum class Kind : std::uint8_t {
    kValues,
    kInside,      // entirely pure bone: the values are not set
    kCheckpoint,  // a checkpoint: its number and figures
  };
  Kind kind = Kind::kValues;
  std::uint32_t number = 0;       // of a checkpoint
  std::uint32_t epoch = 0;        // rises by one with each checkpoint and by two with each restore
  std::array<int, 3> index{};     // in the world, as in ChangedLeaf
  std::array<float, 512> values;  // mm, z fastest, y next; for a checkpoint: storage of its figures()

  /// For a checkpoint: the data needed to return to it.
  std::array<double, 256> figures() const { return std::bit_cast<std::array<double, 256>>(values); }
};

/// Queue of old leaf values. The writer is the tick's thread, which changes the field; the reader is any other thread,
/// or the same one between ticks. All memory is allocated in the constructor: the ring, and four bytes for each leaf of
/// the field's box.
///
/// If the ring is full, a leaf's old values are lost. last_lost() then returns the epoch in which this happened: the
/// checkpoint that started this epoch and all earlier checkpoints can no longer be restored. Wrong values are never
/// restored.
class LeafHistory {
 public:
  /// To be passed to BoneField::set_history(). Allocates.
  LeafHistory(const BoneField& field, std::size_t ring_leaves);
  /// phi in pure bone, mm.
  float inside_mm() const { return inside_mm_; }

  // ---- writer: tick-safe
  /// Returns whether the leaf's old values have not been stored yet in this epoch.
  bool NeedsOldValues(std::size_t place) const { return epochs_[place] != epoch_; }
  /// Stores the old values of a leaf; `values`: null for pure bone. If NeedsOldValues() returns true, must be called
  /// before the leaf changes.
  void Note(std::size_t place, const LeafIndex& leaf, const float* values);
  /// Starts a new epoch, in which each leaf is stored again. Returns false and does nothing if the ring is full.
  bool Checkpoint(std::uint32_t number, const std::array<double, 256>& figures);
  /// Starts a separate epoch, in which Touch() marks the restored leaves. EndRestore() ends it and returns the next
  /// epoch.
  void BeginRestore() { ++epoch_; }
  std::uint32_t EndRestore() { return ++epoch_; }
  /// Returns true the first time that it is called for a leaf in this epoch; the leaf is then not stored in this epoch.
  bool Touch(std::size_t place);
  /// Number of entries pushed since the start.
  std::size_t pushed() const { return pushed_; }
  /// Returns the n-th pushed entry, read or not; null if its slot has been reused.
  const LeafBefore* At(std::size_t n) const { return ring_.At(n); }

  // ---- reader
  SpscRing<LeafBefore>& ring() { return ring_; }

  // ---- any thread
  /// Latest epoch in which a leaf's old values were lost; 0: none.
  std::uint32_t last_lost() const { return last_lost_.load(std::memory_order_acquire); }
  std::size_t CalcMemoryBytes() const;

 private:
  LeafIndex origin_;
  float inside_mm_;
  std::vector<std::uint32_t> epochs_;  // for each place: the epoch in which it was last stored
  std::uint32_t epoch_ = 1;
  std::size_t pushed_ = 0;
  SpscRing<LeafBefore> ring_;
  std::atomic<std::uint32_t> last_lost_{0};
};

}  // namespace kerf
