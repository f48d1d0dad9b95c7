// Volume of bone in the cells of a leaf, from the two fields of a bone (see BoneField).
#pragma once

#include <algorithm>
#include <array>

#include "bone/grid/cell_block.h"
#include "bone/grid/phi_table.h"

namespace kerf {

/// The two fields at the corners of all cells whose lowest corner lies in one leaf.
///
/// A cut has edges of its own, such as those of the floor of a kerf, and a kerf may be hardly wider than a voxel.
/// Within a cell in which the cut has such a kink it is therefore not interpolated linearly but continued from both
/// sides: along each axis its value is the smaller of the two straight lines through the two voxels on either side (or
/// the larger, for an inward kink), as in Harten's subcell resolution. That is exact for a wall that is thin or an edge
/// that is sharp. It takes one more layer of voxels around the cells.
class CellFields {
 public:
  static constexpr int kEdge = 11;  // of the voxels of `cut`: from one before the leaf to two behind it
  static constexpr int kCount = kEdge * kEdge * kEdge;

  CellFields(double voxel_mm, double band_mm)
      : voxel_mm_(static_cast<float>(voxel_mm)), band_mm_(static_cast<float>(band_mm)) {}

  /// parts_of(x, y, z), each -1 to 1, returns the values of the leaf or of a neighbour.
  template <typename PartsOf>
  void Load(PartsOf&& parts_of) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) LoadPart(parts_of(x, y, z), x, y, z);
      }
    }
    FindWhetherCut();
  }
  /// Replaces the values of the cut with those that cut_of(x, y, z) returns; null: they remain.
  template <typename CutOf>
  void LoadCut(CutOf&& cut_of) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (const float* const values = cut_of(x, y, z)) LoadCutPart(values, x, y, z);
        }
      }
    }
    FindWhetherCut();
  }

  /// The values of cell (x, y, z), each 0 to 7, at its corners, in the order of CalcCellFraction().
  std::array<float, 8> WholeCorners(int x, int y, int z) const { return whole_.Corners(x, y, z); }
  std::array<float, 8> CutCorners(int x, int y, int z) const;
  PhiCorners Corners(int x, int y, int z) const { return {WholeCorners(x, y, z), CutCorners(x, y, z)}; }
  /// phi at a voxel, each index 0 to 8.
  float PhiAt(int x, int y, int z) const { return std::max(whole_.at(x, y, z), CutAt(x, y, z)); }
  bool operator==(const CellFields& other) const = default;
  /// The value of the cut at a voxel, each index -1 to 9.
  float CutAt(int x, int y, int z) const { return cut_[static_cast<std::size_t>(At(x, y, z))]; }

  /// Returns whether values of the cut on which the cell's volume depends differ from those of another leaf.
  bool DiffersAround(const CellFields& other, int x, int y, int z) const;
  /// Returns the fraction of the cell that is bone, 0 to 1. It depends only on the values of `whole` at the corners and
  /// of `cut` at the 4 x 4 x 4 voxels around them.
  double CalcFraction(int x, int y, int z) const;

 private:
  static constexpr int At(int x, int y, int z) { return ((x + 1) * kEdge + y + 1) * kEdge + z + 1; }
  void LoadPart(const PhiParts& parts, int bx, int by, int bz);
  void LoadCutPart(const float* values, int bx, int by, int bz);
  void FindWhetherCut();
  bool HasKink(int x, int y, int z) const;
  double CalcFineFraction(int x, int y, int z) const;

  float voxel_mm_;
  float band_mm_;
  CellBlock whole_;
  std::array<float, kCount> cut_{};
  bool is_cut_ = true;  // some value of the cut is not that of uncut bone
};

}  // namespace kerf
