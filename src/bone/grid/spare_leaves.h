// Leaves that were allocated in advance, so that a tick that needs one allocates no memory.
#pragma once

#include "bone/grid/openvdb_templates.h"

#include <atomic>
#include <memory>
#include <vector>

#include "base/core/spsc_ring.h"

namespace kerf {

/// Leaves without active voxels, filled with one value. One thread takes leaves and returns them; meanwhile another one
/// may supply more.
class SpareLeaves {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  explicit SpareLeaves(float value) : value_(value), supplied_(kMaxSupplied) {}
  ~SpareLeaves();

  // ---- by the thread that takes leaves
  /// Number of leaves that are left. Tick-safe.
  int count() const { return count_.load(std::memory_order_acquire); }
  /// Returns a leaf at the given origin; count() must be above 0. Tick-safe.
  std::unique_ptr<Leaf> Take(const openvdb::Coord& origin);
  /// Takes back a leaf, with any values. May allocate.
  void Return(std::unique_ptr<Leaf> leaf);
  /// Allocates leaves until there are `count`.
  void Refill(int count);

  // ---- by one other thread, at any time
  /// Allocates leaves until there are `count`, but at most until kMaxSupplied of those that it supplied are left.
  void Supply(int count);

  std::size_t CalcMemoryBytes() const;

 private:
  static constexpr std::size_t kMaxSupplied = 65536;

  std::unique_ptr<Leaf> Make() const { return std::make_unique<Leaf>(openvdb::Coord(0, 0, 0), value_, false); }

  float value_;
  std::vector<std::unique_ptr<Leaf>> own_;
  SpscRing<Leaf*> supplied_;
  std::atomic<int> count_{0};  // in both; a supplied leaf is counted after it was added
};

}  // namespace kerf
