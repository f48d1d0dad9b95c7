// This file is compiled once for each vector instruction set. It uses no fused multiply-add, so the results are
// bit-identical at every width.
#include "bone/grid/sample_points.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bone/grid/sample_points.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPart = 64;  // points that are computed together

using Doubles = hn::CappedTag<double, 8>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using Singles = hn::Rebind<float, Doubles>;
using D = hn::Vec<Doubles>;
using I = hn::Vec<Ints>;
constexpr Doubles kDoubles;
constexpr Ints kInts;
constexpr std::size_t kLanes = hn::MaxLanes(kDoubles);

/// Cells of a part of the points, by axis.
struct Cells {
  alignas(64) double f[3][kPart];             // position in the cell
  alignas(64) std::int32_t place[kPart];      // of the leaf with the lowest corner
  alignas(64) std::int32_t in_leaf[kPart];    // place of the lowest corner in that leaf
  alignas(64) std::int32_t is_across[kPart];  // -1: other corners are in other leaves; otherwise 0
  // To the next corner along each axis: change of the leaf's place, and of the place in the leaf.
  alignas(64) std::int32_t to_leaf[3][kPart];
  alignas(64) std::int32_t to_voxel[3][kPart];
};

/// Finds the cells of `count` points from `first` on, and of a few more that are no points. `to_index`: null if the map
/// leads to the grid's index space. kCorners: false if the corners are not to be read.
template <bool kCorners>
void FindCells(const TableBox& box, const PointMap& map, const GridMap* to_index, const PointList& points,
               std::size_t first, std::size_t count, Cells& cells) {
  static_assert(kLanes <= PointList::kPadding && kPart % PointList::kPadding == 0);
  constexpr int kVoxelStep[3] = {64, 8, 1};
  const int leaf_step[3] = {box.count[1] * box.count[2], box.count[2], 1};
  const I seven = hn::Set(kInts, 7);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const D x = hn::LoadU(kDoubles, points.x() + first + i);
    const D y = hn::LoadU(kDoubles, points.y() + first + i);
    const D z = hn::LoadU(kDoubles, points.z() + first + i);
    I place = hn::Zero(kInts);
    I in_leaf = hn::Zero(kInts);
    I is_across = hn::Zero(kInts);
    for (int axis = 0; axis < 3; ++axis) {
      const auto entry = [&](int column) { return hn::Set(kDoubles, map.R[column][axis]); };
      const D turned = hn::Add(hn::Add(hn::Mul(entry(0), x), hn::Mul(entry(1), y)), hn::Mul(entry(2), z));
      D mapped = hn::Add(turned, hn::Set(kDoubles, map.t[axis]));
      if (to_index != nullptr) {
        mapped = hn::Div(hn::Mul(hn::Set(kDoubles, to_index->scale), mapped), hn::Set(kDoubles, to_index->voxel_mm));
        mapped = hn::Add(mapped, hn::Set(kDoubles, to_index->offset[axis]));
      }
      const D far = hn::Set(kDoubles, kFarCell);
      const D p = hn::Min(hn::Max(mapped, hn::Neg(far)), far);
      const I lowest = hn::DemoteTo(kInts, hn::Floor(p));
      hn::Store(hn::Sub(p, hn::PromoteTo(kDoubles, lowest)), kDoubles, cells.f[axis] + i);
      const auto clamp = [&](I leaf) {
        return hn::Min(hn::Max(leaf, hn::Zero(kInts)), hn::Set(kInts, box.count[axis] - 1));
      };
      const I leaf = hn::Sub(hn::ShiftRight<3>(lowest), hn::Set(kInts, box.first[axis]));
      const I own = clamp(leaf);
      place = hn::Add(hn::Mul(place, hn::Set(kInts, box.count[axis])), own);
      if constexpr (!kCorners) continue;
      const I in_axis = hn::And(lowest, seven);
      in_leaf = hn::Add(hn::ShiftLeft<3>(in_leaf), in_axis);
      const auto at_end = hn::Eq(in_axis, seven);
      is_across = hn::Or(is_across, hn::VecFromMask(kInts, at_end));
      const auto has_next = hn::Ne(clamp(hn::Add(leaf, hn::Set(kInts, 1))), own);
      hn::Store(hn::IfThenElseZero(hn::And(at_end, has_next), hn::Set(kInts, leaf_step[axis])), kInts,
                cells.to_leaf[axis] + i);
      hn::Store(hn::IfThenElse(at_end, hn::Set(kInts, -7 * kVoxelStep[axis]), hn::Set(kInts, kVoxelStep[axis])), kInts,
                cells.to_voxel[axis] + i);
    }
    hn::Store(place, kInts, cells.place + i);
    if constexpr (!kCorners) continue;
    hn::Store(in_leaf, kInts, cells.in_leaf + i);
    hn::Store(is_across, kInts, cells.is_across + i);
  }
}

/// Calls visit(edge, place of the leaf of its lower corner, place of that corner in it, and the same of the upper one)
/// for each of the four edges of cell i along z, in the order of the corners.
template <typename Visit>
HWY_INLINE void VisitEdges(const Cells& cells, std::size_t i, Visit&& visit) {
  const std::ptrdiff_t up_leaf = cells.to_leaf[2][i];
  const std::ptrdiff_t up_voxel = cells.to_voxel[2][i];
  for (std::size_t edge = 0; edge < 4; ++edge) {
    std::ptrdiff_t place = cells.place[i];
    std::ptrdiff_t voxel = cells.in_leaf[i];
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if ((edge >> (1 - axis) & 1) == 0) continue;
      place += cells.to_leaf[axis][i];
      voxel += cells.to_voxel[axis][i];
    }
    visit(edge, static_cast<std::size_t>(place), voxel, static_cast<std::size_t>(place + up_leaf), voxel + up_voxel);
  }
}

/// Values at the corners of cells, in pairs along z, in the order of the corners.
struct Corners {
  struct Edge {
    float lower, upper;
  };
  alignas(64) Edge edges[4][kPart];

  /// Reads both ends of an edge that lies in one leaf.
  HWY_INLINE void Read(std::size_t edge, std::size_t i, const float* lower) {
    std::memcpy(&edges[edge][i], lower, sizeof(Edge));
  }
  /// Reads all edges of a cell that lies in one leaf.
  HWY_INLINE void ReadCell(std::size_t i, const float* lowest) {
    constexpr int kFromLowest[4] = {0, 8, 64, 72};
    for (std::size_t edge = 0; edge < 4; ++edge) Read(edge, i, lowest + kFromLowest[edge]);
  }
  /// Sets the values of further cells to zero, until their number is that of whole vectors.
  void Pad(std::size_t count) {
    for (std::size_t i = count; i % kLanes != 0; ++i) edges[0][i] = edges[1][i] = edges[2][i] = edges[3][i] = {};
  }
  /// Returns the values at the lower and at the upper ends of the edges of some cells, from cell i on.
  HWY_INLINE void Load(std::size_t edge, std::size_t i, hn::Vec<Singles>& lower, hn::Vec<Singles>& upper) const {
    hn::LoadInterleaved2(Singles(), &edges[edge][i].lower, lower, upper);
  }
};

/// Interpolates trilinearly between values that load(edge, lower, upper) gives, at the position f in the cell.
template <typename Load>
HWY_INLINE D Mix(D fx, D fy, D fz, Load&& load) {
  const auto mix = [](D a, D b, D t) HWY_ATTR { return hn::Add(a, hn::Mul(t, hn::Sub(b, a))); };
  const auto along_edge = [&](std::size_t edge) HWY_ATTR {
    hn::Vec<Singles> lower, upper;
    load(edge, lower, upper);
    return mix(hn::PromoteTo(kDoubles, lower), hn::PromoteTo(kDoubles, upper), fz);
  };
  const D lower = mix(along_edge(0), along_edge(1), fy);
  const D upper = mix(along_edge(2), along_edge(3), fy);
  return mix(lower, upper, fx);
}

/// Stores the first values of a vector, `count` at most.
HWY_INLINE void StoreFirst(D values, std::size_t count, double* to) {
  if (count >= kLanes) {
    hn::StoreU(values, kDoubles, to);
    return;
  }
  alignas(64) double all[kLanes];
  hn::Store(values, kDoubles, all);
  for (std::size_t i = 0; i < count; ++i) to[i] = all[i];
}

/// Interpolates both fields in the cells `list` of a part of the points. cut: null if `whole` is to get phi.
void SampleBoth(const PhiTable& table, const Cells& cells, const std::uint8_t* list, std::size_t count, double* whole,
                double* cut) {
  Corners of_whole, of_cut;
  alignas(64) double f[3][kPart];
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t i = list[n];
    for (int axis = 0; axis < 3; ++axis) f[axis][n] = cells.f[axis][i];
    if (cells.is_across[i] == 0) {
      const PhiParts parts = table.Parts(static_cast<std::size_t>(cells.place[i]));
      of_whole.ReadCell(n, parts.whole + cells.in_leaf[i]);
      of_cut.ReadCell(n, parts.cut + cells.in_leaf[i]);
      continue;
    }
    VisitEdges(cells, i,
               [&](std::size_t edge, std::size_t low, std::ptrdiff_t low_voxel, std::size_t high,
                   std::ptrdiff_t high_voxel) HWY_ATTR {
                 const PhiParts lower = table.Parts(low);
                 const PhiParts upper = low == high ? lower : table.Parts(high);
                 of_whole.edges[edge][n] = {lower.whole[low_voxel], upper.whole[high_voxel]};
                 of_cut.edges[edge][n] = {lower.cut[low_voxel], upper.cut[high_voxel]};
               });
  }
  for (std::size_t n = count; n % kLanes != 0; ++n) f[0][n] = f[1][n] = f[2][n] = 0;
  of_whole.Pad(count);
  of_cut.Pad(count);
  const auto band = hn::Set(Singles(), table.outside()[0]);
  for (std::size_t n = 0; n < count; n += kLanes) {
    const D fx = hn::Load(kDoubles, f[0] + n);
    const D fy = hn::Load(kDoubles, f[1] + n);
    const D fz = hn::Load(kDoubles, f[2] + n);
    const D w = Mix(fx, fy, fz,
                    [&](std::size_t edge, auto& lower, auto& upper) HWY_ATTR { of_whole.Load(edge, n, lower, upper); });
    const D c = Mix(fx, fy, fz, [&](std::size_t edge, auto& lower, auto& upper) HWY_ATTR {
      // As PhiParts::CutAt().
      hn::Vec<Singles> whole_lower, whole_upper;
      of_whole.Load(edge, n, whole_lower, whole_upper);
      of_cut.Load(edge, n, lower, upper);
      lower = hn::IfThenElse(hn::Ge(whole_lower, band), band, lower);
      upper = hn::IfThenElse(hn::Ge(whole_upper, band), band, upper);
    });
    alignas(64) double values[2][kLanes];
    hn::Store(cut == nullptr ? hn::Max(w, c) : w, kDoubles, values[0]);
    hn::Store(c, kDoubles, values[1]);
    for (std::size_t lane = 0; lane < kLanes && n + lane < count; ++lane) {
      whole[list[n + lane]] = values[0][lane];
      if (cut != nullptr) cut[list[n + lane]] = values[1][lane];
    }
  }
}

/// cut: null if `whole` is to get phi.
void Sample(const PhiTable& table, const PointMap& map, const PointList& points, double* whole, double* cut) {
  using Longs = hn::Rebind<std::int64_t, Doubles>;
  const LeafTable<float>& leaves = table.leaves();
  const std::uint8_t* const flags = table.all_flags();
  const TableBox box = leaves.box();
  const D inside = hn::Set(kDoubles, static_cast<double>(table.inside()[0]));
  Cells cells;
  Corners corners;
  alignas(64) std::int32_t flags_of[kPart];  // of all leaves of a cell
  // Cells in one leaf; cells whose edges along z are in one leaf each; other cells; cells with both fields. They are
  // read separately, because a branch for each would be predicted badly.
  std::uint8_t in_one[kPart], in_columns[kPart], in_more[kPart], with_both[kPart];
  for (std::size_t first = 0; first < points.size(); first += kPart) {
    const std::size_t count = std::min(kPart, points.size() - first);
    FindCells<true>(box, map, nullptr, points, first, count, cells);
    std::size_t one = 0, columns = 0, more = 0;
    for (std::size_t i = 0; i < count; ++i) {
      in_one[one] = in_columns[columns] = in_more[more] = static_cast<std::uint8_t>(i);
      const std::size_t is_across = static_cast<std::uint32_t>(cells.is_across[i]) >> 31;  // 0 or -1
      const std::size_t is_more = cells.to_voxel[2][i] == 1 ? 0 : 1;
      one += 1 - is_across;
      columns += is_across & ~is_more;
      more += is_more;
    }
    for (std::size_t n = 0; n < one; ++n) {
      const std::size_t i = in_one[n];
      const auto place = static_cast<std::size_t>(cells.place[i]);
      flags_of[i] = flags[place];
      corners.ReadCell(i, leaves.at(place) + cells.in_leaf[i]);
    }
    for (std::size_t n = 0; n < columns; ++n) {
      const std::size_t i = in_columns[n];
      int all_flags = 0;
      VisitEdges(cells, i,
                 [&](std::size_t edge, std::size_t low, std::ptrdiff_t low_voxel, std::size_t /*high*/,
                     std::ptrdiff_t /*high_voxel*/) HWY_ATTR {
                   all_flags |= flags[low];
                   corners.Read(edge, i, leaves.at(low) + low_voxel);
                 });
      flags_of[i] = all_flags;
    }
    for (std::size_t n = 0; n < more; ++n) {
      const std::size_t i = in_more[n];
      int all_flags = 0;
      VisitEdges(cells, i,
                 [&](std::size_t edge, std::size_t low, std::ptrdiff_t low_voxel, std::size_t high,
                     std::ptrdiff_t high_voxel) HWY_ATTR {
                   all_flags |= flags[low] | flags[high];
                   corners.edges[edge][i] = {leaves.at(low)[low_voxel], leaves.at(high)[high_voxel]};
                 });
      flags_of[i] = all_flags;
    }
    std::size_t both = 0;
    for (std::size_t i = 0; i < count; ++i) {
      with_both[both] = static_cast<std::uint8_t>(i);
      both += PhiTable::NeedsBoth(static_cast<unsigned>(flags_of[i])) ? 1 : 0;
    }
    corners.Pad(count);
    for (std::size_t i = count; i % kLanes != 0; ++i) flags_of[i] = 0;
    for (std::size_t i = 0; i < count; i += kLanes) {
      const D mixed = Mix(
          hn::Load(kDoubles, cells.f[0] + i), hn::Load(kDoubles, cells.f[1] + i), hn::Load(kDoubles, cells.f[2] + i),
          [&](std::size_t edge, auto& lower, auto& upper) HWY_ATTR { corners.Load(edge, i, lower, upper); });
      if (cut == nullptr) {
        StoreFirst(mixed, count - i, whole + first + i);
        continue;
      }
      const auto cut_flag =
          hn::And(hn::PromoteTo(Longs(), hn::Load(kInts, flags_of + i)), hn::Set(Longs(), PhiTable::kCut));
      const auto is_cut = hn::RebindMask(kDoubles, hn::Ne(cut_flag, hn::Zero(Longs())));
      StoreFirst(hn::IfThenElse(is_cut, inside, mixed), count - i, whole + first + i);
      StoreFirst(hn::IfThenElse(is_cut, mixed, inside), count - i, cut + first + i);
    }
    if (both > 0) {
      SampleBoth(table, cells, with_both, both, whole + first, cut == nullptr ? nullptr : cut + first);
    }
  }
}

void Uniform(const TableBox& box, const std::uint8_t* of_leaf, const PointMap& map, const GridMap& to_index,
             const PointList& points, const RegionConstants& constants, std::uint8_t* regions, double* a, double* b) {
  Cells cells;
  alignas(64) double values[2][kPart] = {};
  for (std::size_t first = 0; first < points.size(); first += kPart) {
    const std::size_t count = std::min(kPart, points.size() - first);
    FindCells<false>(box, map, &to_index, points, first, count, cells);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t region = of_leaf[cells.place[i]];
      regions[first + i] = static_cast<std::uint8_t>(region);
      values[0][i] = constants.a[region];
      values[1][i] = constants.b[region];
    }
    for (std::size_t i = 0; i < count; i += kLanes) {
      const D one = hn::Set(kDoubles, 1);
      D f[3][2];  // [axis]: weights of the lower and the upper corner
      for (int axis = 0; axis < 3; ++axis) {
        f[axis][1] = hn::Load(kDoubles, cells.f[axis] + i);
        f[axis][0] = hn::Sub(one, f[axis][1]);
      }
      const D value_a = hn::Load(kDoubles, values[0] + i);
      const D value_b = hn::Load(kDoubles, values[1] + i);
      D sum = hn::Zero(kDoubles);
      D sum_a = sum;
      D sum_b = sum;
      for (int corner = 0; corner < 8; ++corner) {
        const D weight = hn::Mul(hn::Mul(f[0][corner >> 2], f[1][corner >> 1 & 1]), f[2][corner & 1]);
        sum = hn::Add(sum, weight);
        sum_a = hn::Add(sum_a, hn::Mul(weight, value_a));
        sum_b = hn::Add(sum_b, hn::Mul(weight, value_b));
      }
      hn::Store(hn::Div(sum_a, sum), kDoubles, values[0] + i);
      hn::Store(hn::Div(sum_b, sum), kDoubles, values[1] + i);
    }
    std::copy_n(values[0], count, a + first);
    std::copy_n(values[1], count, b + first);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(Sample);
HWY_EXPORT(Uniform);

}  // namespace

void SamplePoints(const PhiTable& table, const PointMap& map, const PointList& points, double* whole, double* cut) {
  HWY_DYNAMIC_DISPATCH(Sample)(table, map, points, whole, cut);
}

void SamplePhi(const PhiTable& table, const PointMap& map, const PointList& points, double* phi) {
  HWY_DYNAMIC_DISPATCH(Sample)(table, map, points, phi, nullptr);
}

[[gnu::flatten]] PhiPair SamplePoint(const PhiTable& table, const Vec3& p_vox) {
  const CellPoint cell = FindCell(p_vox);
  const LeafTable<float>& leaves = table.leaves();
  unsigned flags = 0;
  if ((cell.x & 7) < 7 && (cell.y & 7) < 7 && (cell.z & 7) < 7) {
    flags = table.flags(leaves.Find({cell.x >> 3, cell.y >> 3, cell.z >> 3}));
  } else {
    for (int corner = 0; corner < 8; ++corner) {
      const int x = cell.x + (corner >> 2), y = cell.y + (corner >> 1 & 1), z = cell.z + (corner & 1);
      flags |= table.flags(leaves.Find({x >> 3, y >> 3, z >> 3}));
    }
  }
  if (PhiTable::NeedsBoth(flags)) {
    const PhiCorners both = table.FindCorners(cell);
    return {Interpolate(both.whole, cell.f), Interpolate(both.cut, cell.f)};
  }
  const double phi = Interpolate(leaves.Corners(cell), cell.f);
  const auto inside = static_cast<double>(table.inside()[0]);
  return (flags & PhiTable::kCut) != 0 ? PhiPair{inside, phi} : PhiPair{phi, inside};
}

void InterpolateUniform(const TableBox& box, const std::uint8_t* of_leaf, const PointMap& map, const GridMap& to_index,
                        const PointList& points, const RegionConstants& constants, std::uint8_t* regions, double* a,
                        double* b) {
  HWY_DYNAMIC_DISPATCH(Uniform)(box, of_leaf, map, to_index, points, constants, regions, a, b);
}

}  // namespace kerf
#endif  // HWY_ONCE
