// Table of the leaves of a bone's level set, in which an edge between the surface and a cut stays sharp: phi is the
// larger of two smooth fields.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bone/grid/leaf_table.h"

namespace kerf {

/// Values of a leaf, 512 each: of phi before any cut, and of minus the distance to the space that was cut.
struct PhiParts {
  const float* whole = nullptr;
  const float* cut = nullptr;

  /// Returns the value of `cut` at a voxel. Air beyond the band counts as cut, because nothing is stored there:
  /// otherwise bone would appear between it and a leaf of bone that was cut away entirely.
  float CutAt(int voxel, float band) const { return whole[voxel] >= band ? band : cut[voxel]; }
};

/// The same at a point, mm.
struct PhiPair {
  double whole_mm = 0;
  double cut_mm = 0;
  double phi() const { return std::max(whole_mm, cut_mm); }
};

/// The same at the corners of a cell.
struct PhiCorners {
  CellValues<float> whole, cut;

  void Set(std::size_t corner, const PhiParts& parts, int voxel, float band) {
    whole[corner] = parts.whole[voxel];
    cut[corner] = parts.CutAt(voxel, band);
  }
};

/// Returns the values at the corners of a cell. find_parts: gives the values of the leaf that contains voxel x, y, z.
template <typename FindParts>
PhiCorners FindPhiCorners(const CellPoint& cell, float band, FindParts&& find_parts) {
  PhiCorners corners;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = cell.x + (corner >> 2), y = cell.y + (corner >> 1 & 1), z = cell.z + (corner & 1);
    const int voxel = 64 * (x & 7) + 8 * (y & 7) + (z & 7);
    corners.Set(static_cast<std::size_t>(corner), find_parts(x, y, z), voxel, band);
  }
  return corners;
}

/// phi of each leaf, and both fields of each leaf that is split. The fields of any other leaf follow from what its phi
/// is: that of the whole bone, of the cut, or a constant.
class PhiTable {
 public:
  // Flags of a leaf. A leaf without one of the last three holds a constant.
  static constexpr std::uint8_t kChanged = 1;    // changed since ClearChanged()
  static constexpr std::uint8_t kUnsettled = 2;  // changed since Settle()
  static constexpr std::uint8_t kWhole = 4;      // phi is that of the whole bone: nothing was cut near the leaf
  static constexpr std::uint8_t kCut = 8;        // phi is that of the cut: the whole bone fills the leaf, or filled it
  static constexpr std::uint8_t kSplit = 16;     // phi is the larger of both

  /// Returns whether the leaves of a cell, with these flags between them, are split or hold different fields.
  static bool NeedsBoth(unsigned flags) {
    constexpr unsigned kDifferent = kWhole | kCut;
    return (flags & kSplit) != 0 || (flags & kDifferent) == kDifferent;
  }

  PhiTable() = default;
  /// `outside`, `inside`: the shared leaves of air and of bone.
  PhiTable(LeafTable<float> leaves, const float* outside, const float* inside)
      : leaves_(std::move(leaves)), outside_(outside), inside_(inside), flags_(leaves_.size()), split_(leaves_.size()) {
    for (std::size_t place = 0; place < leaves_.size(); ++place) {
      if (leaves_.at(place) != outside && leaves_.at(place) != inside) flags_[place] = kWhole;
    }
  }

  const LeafTable<float>& leaves() const { return leaves_; }
  const float* outside() const { return outside_; }
  const float* inside() const { return inside_; }
  void Set(std::size_t place, const float* phi) { leaves_.Set(place, phi); }
  std::uint8_t& flags(std::size_t place) { return flags_[place]; }
  std::uint8_t flags(std::size_t place) const { return flags_[place]; }
  const std::uint8_t* all_flags() const { return flags_.data(); }

  /// Tick-safe if there is room.
  void Split(std::size_t place, const PhiParts& parts) {
    splits_.push_back(parts);
    split_[place] = static_cast<std::uint32_t>(splits_.size());
    flags_[place] = static_cast<std::uint8_t>((flags_[place] & (kChanged | kUnsettled)) | kSplit);
  }
  void ReserveSplits(std::size_t more) { splits_.reserve(splits_.size() + more); }

  PhiParts Parts(std::size_t place) const {
    const float* const phi = leaves_.at(place);
    if ((flags_[place] & kSplit) != 0) return splits_[split_[place] - 1];
    if (phi == outside_) return {(flags_[place] & kCut) != 0 ? inside_ : outside_, outside_};
    return (flags_[place] & kWhole) != 0 ? PhiParts{phi, inside_} : PhiParts{inside_, phi};
  }

  /// Tick-safe.
  PhiCorners FindCorners(const CellPoint& cell) const {
    return FindPhiCorners(cell, outside_[0], [&](int x, int y, int z) {
      return Parts(leaves_.Find({x >> 3, y >> 3, z >> 3}));
    });
  }

  std::size_t CalcMemoryBytes() const {
    return leaves_.CalcMemoryBytes() + flags_.capacity() + split_.capacity() * sizeof(split_[0]) +
           splits_.capacity() * sizeof(PhiParts);
  }

 private:
  LeafTable<float> leaves_;
  const float* outside_ = nullptr;
  const float* inside_ = nullptr;
  std::vector<std::uint8_t> flags_;
  std::vector<std::uint32_t> split_;  // of a split leaf: its number, from 1
  std::vector<PhiParts> splits_;
};

}  // namespace kerf
