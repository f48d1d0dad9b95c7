// Table of the 8 x 8 x 8 leaves in a box of space, with O(1) access.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bone/grid/interpolate.h"
#include "kerf/error.h"

namespace kerf {

/// Index of a leaf of 8 x 8 x 8 voxels: along each axis the voxel's index divided by 8, rounded down.
struct LeafIndex {
  int x = 0;
  int y = 0;
  int z = 0;
  bool operator==(const LeafIndex&) const = default;
};

/// Largest number of leaves in a table: those of the largest bone, which has 2^36 voxels, and of the layer around it. A
/// table stores one pointer per leaf.
inline constexpr double kMaxTableLeaves = 1.05 * (1 << 27);

/// The box of a table: its lowest leaf, and the number of leaves along each axis.
struct TableBox {
  std::array<int, 3> first;
  std::array<int, 3> count;
};

/// Pointers to the values of leaves (512 each, z fastest, y next), which are owned elsewhere. Every leaf outside the
/// box, and every leaf in it that was not set, reads as the values passed to the constructor.
template <typename T>
class LeafTable {
 public:
  static constexpr int kLeafVoxels = 512;

  LeafTable() = default;
  /// `first` and `last`: the lowest and the highest leaf; for an empty table `last` is one less than `first` along each
  /// axis. A layer of leaves is added around them. Throws kerf::Error if the box holds more than kMaxTableLeaves.
  LeafTable(const LeafIndex& first, const LeafIndex& last, const T* beyond)
      : first_{first.x - 1, first.y - 1, first.z - 1},
        count_{last.x - first.x + 3, last.y - first.y + 3, last.z - first.z + 3},
        leaves_(CheckedSize(count_), beyond) {}

  /// Returns the number of leaves in a box with `count` leaves along each axis. Throws kerf::Error if it exceeds
  /// kMaxTableLeaves.
  static std::size_t CheckedSize(const LeafIndex& count) {
    const double leaves = double{1} * count.x * count.y * count.z;
    if (!(leaves <= kMaxTableLeaves)) {
      throw Error(
          fmt::format("a bone whose parts lie in a box of {} x {} x {} voxels can't be cut: the limit is 2^36 voxels; "
                      "use larger voxels, or remove distant parts",
                      8 * static_cast<std::int64_t>(count.x), 8 * static_cast<std::int64_t>(count.y),
                      8 * static_cast<std::int64_t>(count.z)));
    }
    return static_cast<std::size_t>(leaves);
  }
  std::size_t size() const { return leaves_.size(); }

  /// Returns the place of a leaf in the table; a leaf beyond the box has the place of the nearest leaf of the layer
  /// around it. Tick-safe.
  std::size_t Find(const LeafIndex& leaf) const { return PlaceX(leaf.x) + PlaceY(leaf.y) + PlaceZ(leaf.z); }
  const T* at(std::size_t place) const { return leaves_[place]; }
  void Set(std::size_t place, const T* values) { leaves_[place] = values; }

  T Get(int x, int y, int z) const {
    return leaves_[Find({x >> 3, y >> 3, z >> 3})][64 * (x & 7) + 8 * (y & 7) + (z & 7)];
  }

  /// Returns the eight values of a cell. Tick-safe.
  CellValues<T> Corners(const CellPoint& cell) const {
    const int x = cell.x & 7;
    const int y = cell.y & 7;
    const int z = cell.z & 7;
    if (x < 7 && y < 7 && z < 7) {
      const T* p = leaves_[Find({cell.x >> 3, cell.y >> 3, cell.z >> 3})] + 64 * x + 8 * y + z;
      return {p[0], p[1], p[8], p[9], p[64], p[65], p[72], p[73]};
    }
    const std::size_t place_x[2] = {PlaceX(cell.x >> 3), PlaceX((cell.x + 1) >> 3)};
    const std::size_t place_y[2] = {PlaceY(cell.y >> 3), PlaceY((cell.y + 1) >> 3)};
    const std::size_t place_z[2] = {PlaceZ(cell.z >> 3), PlaceZ((cell.z + 1) >> 3)};
    const int in_x[2] = {64 * x, 64 * ((x + 1) & 7)};
    const int in_y[2] = {8 * y, 8 * ((y + 1) & 7)};
    const int in_z[2] = {z, (z + 1) & 7};
    const auto at = [&](int i, int j, int k) {
      return leaves_[place_x[i] + place_y[j] + place_z[k]][in_x[i] + in_y[j] + in_z[k]];
    };
    return {at(0, 0, 0), at(0, 0, 1), at(0, 1, 0), at(0, 1, 1), at(1, 0, 0), at(1, 0, 1), at(1, 1, 0), at(1, 1, 1)};
  }

  /// The box with the layer around it. The place of the leaf at (x, y, z) from its first one is (x count_y + y) count_z
  /// + z.
  TableBox box() const { return {{first_.x, first_.y, first_.z}, {count_.x, count_.y, count_.z}}; }
  /// The box itself, without the layer around it.
  LeafIndex lowest() const { return {first_.x + 1, first_.y + 1, first_.z + 1}; }
  LeafIndex highest() const { return {first_.x + count_.x - 2, first_.y + count_.y - 2, first_.z + count_.z - 2}; }
  std::size_t CalcMemoryBytes() const { return leaves_.size() * sizeof(const T*); }

 private:
  // The place of a leaf is the sum of these.
  std::size_t PlaceX(int x) const {
    return Clamp(x - first_.x, count_.x) * static_cast<std::size_t>(count_.y) * static_cast<std::size_t>(count_.z);
  }
  std::size_t PlaceY(int y) const { return Clamp(y - first_.y, count_.y) * static_cast<std::size_t>(count_.z); }
  std::size_t PlaceZ(int z) const { return Clamp(z - first_.z, count_.z); }
  static std::size_t Clamp(int i, int count) { return static_cast<std::size_t>(std::clamp(i, 0, count - 1)); }

  LeafIndex first_;
  LeafIndex count_;
  std::vector<const T*> leaves_;
};

}  // namespace kerf
