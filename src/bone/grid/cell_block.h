// Corner values of all cells whose lowest corner lies in one 8 x 8 x 8 leaf: the values of the leaf and of the
// adjoining layer of its upper neighbours.
#pragma once

#include <array>

namespace kerf {

/// 9 x 9 x 9 values, z fastest.
class CellBlock {
 public:
  static constexpr int kEdge = 9;
  static constexpr int kCount = kEdge * kEdge * kEdge;

  float& at(int x, int y, int z) { return values_[(x * kEdge + y) * kEdge + z]; }
  float at(int x, int y, int z) const { return values_[(x * kEdge + y) * kEdge + z]; }

  const float* data() const { return values_.data(); }
  bool operator==(const CellBlock& other) const = default;

  /// Returns the eight corner values of cell (x, y, z), each 0 to 7, in the order that CalcCellFraction() expects.
  /// Tick-safe.
  std::array<float, 8> Corners(int x, int y, int z) const {
    const float* p = &values_[(x * kEdge + y) * kEdge + z];
    return {p[0],
            p[1],
            p[kEdge],
            p[kEdge + 1],
            p[kEdge * kEdge],
            p[kEdge * kEdge + 1],
            p[kEdge * kEdge + kEdge],
            p[kEdge * kEdge + kEdge + 1]};
  }

  /// Loads the values around the leaf whose lowest voxel is `origin` (a multiple of 8) from a tree. Tick-safe.
  template <typename Accessor, typename Coord>
  void Load(const Accessor& accessor, const Coord& origin) {
    ForEachPart([&](int bx, int by, int bz) {
      const Coord part = origin.offsetBy(8 * bx, 8 * by, 8 * bz);
      const auto* leaf = accessor.probeConstLeaf(part);
      LoadPart(leaf ? leaf->buffer().data() : nullptr, leaf ? 0.0f : accessor.getValue(part), bx, by, bz);
    });
  }

  /// Loads the values from leaves: values_of(x, y, z), each 0 or 1, returns the 512 values of the leaf or of an upper
  /// neighbour.
  template <typename ValuesOf>
  void LoadLeaves(ValuesOf&& values_of) {
    ForEachPart([&](int bx, int by, int bz) { LoadPart(values_of(bx, by, bz), 0, bx, by, bz); });
  }

 private:
  template <typename Visit>
  static void ForEachPart(Visit&& visit) {
    for (int bx = 0; bx < 2; ++bx) {
      for (int by = 0; by < 2; ++by) {
        for (int bz = 0; bz < 2; ++bz) visit(bx, by, bz);
      }
    }
  }

  /// Loads the part that comes from one leaf: the leaf itself, or the upper neighbour at (bx, by, bz). `data`: its 512
  /// values; null if all are `uniform`.
  void LoadPart(const float* data, float uniform, int bx, int by, int bz) {
    for (int x = 0; x < (bx ? 1 : 8); ++x) {
      for (int y = 0; y < (by ? 1 : 8); ++y) {
        float* row = &at(8 * bx + x, 8 * by + y, 8 * bz);
        for (int z = 0; z < (bz ? 1 : 8); ++z) row[z] = data ? data[64 * x + 8 * y + z] : uniform;
      }
    }
  }

  std::array<float, kCount> values_{};
};

}  // namespace kerf
