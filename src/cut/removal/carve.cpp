// This file is compiled once for each vector instruction set. It uses no fused multiply-add, which rounds once where
// two operations round twice and which not every set has. Additions, multiplications, divisions and square roots round
// the same everywhere.
#include "cut/removal/carve.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "kerf/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/removal/carve.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;  // two neighbouring rows of a leaf, or a part of them
using V = hn::Vec<Floats>;
using M = hn::Mask<Floats>;
constexpr Floats kFloats;
constexpr int kRow = 8;
constexpr float kHalfRow = 3.5f;  // distance from the middle of a row to its ends, in voxels

HWY_INLINE V Splat(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE V Square(V a) {
  return hn::Mul(a, a);
}
HWY_INLINE V Length(V x, V y) {
  return hn::Sqrt(hn::Add(Square(x), Square(y)));
}

/// Sweep of a disc that moves in its own plane: a stadium with the disc's thickness.
class Disc {
 public:
  explicit Disc(const CarveStep& s)
      : radius_(Splat(s.radius)),
        half_thickness_(Splat(s.half_thickness)),
        edge_depth_(Splat(-s.edge_depth)),
        back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        length_(Splat(s.length)),
        far_(Splat(-2 * s.band)),
        row_x_(Splat(kHalfRow * s.grid[2][0])),
        row_y_(Splat(kHalfRow * s.grid[2][1])),
        new_only_(s.new_only) {
    row_z_ = Splat(std::abs(kHalfRow * s.grid[2][2]));
    row_xy_ = Splat(s.row_mm);
    half_radius_ = Splat(0.5f * s.radius);
    bend_ = Splat(s.bend_mm);
    const float reach = s.band + s.rounding;
    reach2_ = Splat(reach * reach);
    slack_ = Splat(s.length + s.flank_slack + s.rounding);
    behind_ = Splat(s.behind_mm);
  }

  /// Returns a mask of the rows with a voxel that the step may change, computed from the middles of the rows.
  HWY_INLINE M MayChange(V x, V y, V z) const {
    const V zero = hn::Zero(kFloats);
    const V along = hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_));
    const V t = hn::Min(hn::Max(along, zero), length_);
    const V qx = hn::Sub(x, hn::Mul(t, back_x_));
    const V qy = hn::Sub(y, hn::Mul(t, back_y_));
    const V axis_distance = Length(qx, qy);
    const V radial = hn::Sub(axis_distance, radius_);
    // Half of the row's extent along the outward direction.
    const V extent = hn::Div(hn::Abs(hn::Add(hn::Mul(qx, row_x_), hn::Mul(qy, row_y_))),
                             hn::Max(axis_distance, hn::Mul(half_radius_, Splat(1e-3f))));
    // Lower bound on the row's distance: the distance is convex, so it lies above its tangent.
    const V axial = hn::Sub(hn::Max(hn::Sub(hn::Abs(z), row_z_), zero), half_thickness_);
    const V out_r = hn::Max(hn::Sub(radial, extent), zero);
    const V out_a = hn::Max(axial, zero);
    M may = hn::Le(hn::Add(Square(out_r), Square(out_a)), reach2_);
    // Upper bound on the radial distance in the row.
    const V bent = hn::Min(hn::Add(extent, bend_), row_xy_);
    const V outermost = hn::Add(radial, hn::IfThenElse(hn::Ge(axis_distance, half_radius_), bent, row_xy_));
    may = hn::And(may, hn::Ge(outermost, edge_depth_));
    if (new_only_) {
      // Where the flats are nearer than the rim, the distance to the flats applies, and it has not changed.
      const V inner = hn::Sub(hn::Min(axial, zero), slack_);
      may = hn::And(may, hn::And(hn::Ge(outermost, inner), hn::Le(along, behind_)));
    }
    return may;
  }

  /// Returns -distance; outside of the zone in which the disc cuts, a value beyond the band.
  HWY_INLINE V Depth(V x, V y, V z) const {
    const V zero = hn::Zero(kFloats);
    const V t = hn::Min(hn::Max(hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_)), zero), length_);
    const V radial = hn::Sub(Length(hn::Sub(x, hn::Mul(t, back_x_)), hn::Sub(y, hn::Mul(t, back_y_))), radius_);
    const V axial = hn::Sub(hn::Abs(z), half_thickness_);
    const V inside = hn::Min(hn::Max(radial, axial), zero);
    const V outside = Length(hn::Max(radial, zero), hn::Max(axial, zero));
    return hn::IfThenElse(hn::Ge(radial, edge_depth_), hn::Neg(hn::Add(inside, outside)), far_);
  }

 private:
  V radius_;
  V half_thickness_;
  V edge_depth_;  // negative, as a radial distance
  V back_x_;
  V back_y_;
  V length_;
  V far_;
  V row_x_;
  V row_y_;
  V row_z_;
  V row_xy_;
  V half_radius_;
  V bend_;
  V reach2_;
  V slack_;
  V behind_;
  bool new_only_;
};

/// Sweep of a ball: a capsule.
class Ball {
 public:
  explicit Ball(const CarveStep& s)
      : radius_(Splat(s.radius)),
        back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        back_z_(Splat(s.back[2])),
        length_(Splat(s.length)),
        row_x_(Splat(kHalfRow * s.grid[2][0])),
        row_y_(Splat(kHalfRow * s.grid[2][1])),
        row_z_(Splat(kHalfRow * s.grid[2][2])),
        row_(Splat(kHalfRow * s.voxel)),
        outer_(Splat(s.band + s.rounding)),
        // Deeper than the band there is only air, as there was after the previous step.
        inner_(Splat(-(s.band + s.length + s.rounding))),
        least_(Splat(1e-3f * s.radius)),
        new_only_(s.new_only) {
    behind_ = Splat(s.behind_mm);
  }

  HWY_INLINE M MayChange(V x, V y, V z) const {
    const V along = Along(x, y, z);
    const V t = hn::Min(hn::Max(along, hn::Zero(kFloats)), length_);
    const V qx = hn::Sub(x, hn::Mul(t, back_x_));
    const V qy = hn::Sub(y, hn::Mul(t, back_y_));
    const V qz = hn::Sub(z, hn::Mul(t, back_z_));
    const V axis_distance = hn::Sqrt(hn::Add(hn::Add(Square(qx), Square(qy)), Square(qz)));
    const V distance = hn::Sub(axis_distance, radius_);
    const V extent = hn::Div(hn::Abs(hn::Add(hn::Add(hn::Mul(qx, row_x_), hn::Mul(qy, row_y_)), hn::Mul(qz, row_z_))),
                             hn::Max(axis_distance, least_));
    M may = hn::Le(hn::Sub(distance, extent), outer_);
    if (new_only_) {
      may = hn::And(may, hn::And(hn::Ge(hn::Add(distance, row_), inner_), hn::Le(along, behind_)));
    }
    return may;
  }

  HWY_INLINE V Depth(V x, V y, V z) const {
    const V t = hn::Min(hn::Max(Along(x, y, z), hn::Zero(kFloats)), length_);
    const V qx = hn::Sub(x, hn::Mul(t, back_x_));
    const V qy = hn::Sub(y, hn::Mul(t, back_y_));
    const V qz = hn::Sub(z, hn::Mul(t, back_z_));
    return hn::Sub(radius_, hn::Sqrt(hn::Add(hn::Add(Square(qx), Square(qy)), Square(qz))));
  }

 private:
  HWY_INLINE V Along(V x, V y, V z) const {
    return hn::Add(hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_)), hn::Mul(z, back_z_));
  }

  V radius_;
  V back_x_;
  V back_y_;
  V back_z_;
  V length_;
  V row_x_;
  V row_y_;
  V row_z_;
  V row_;
  V outer_;
  V inner_;
  V least_;
  V behind_;
  bool new_only_;
};

/// Returns the occupancy, clamp(1/2 - phi/h, 0, 1).
HWY_INLINE V Fraction(V phi, V per_voxel) {
  const V fraction = hn::Sub(Splat(0.5f), hn::Mul(phi, per_voxel));
  return hn::Min(hn::Max(fraction, hn::Zero(kFloats)), Splat(1));
}

/// Returns the value of each lane's row: `rows[row]` for the lower eight voxels, `rows[row + 1]` for the upper.
HWY_INLINE V OfRows(const float* rows, int row, int part) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  if constexpr (kLanes == 2 * kRow) {
    return hn::IfThenElse(hn::FirstN(kFloats, kRow), Splat(rows[row]), Splat(rows[row + 1]));
  } else {
    return Splat(rows[row + part / kRow]);
  }
}

template <typename Swept>
CarveLoss Carve(const CarveStep& s, const std::array<float, 3>& corner, float* HWY_RESTRICT values) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
  constexpr int kPair = 2 * kRow;
  const Swept swept(s);
  // Positions of the first voxels of the rows.
  using Row = hn::CappedTag<float, kRow>;
  constexpr Row kRowTag;
  alignas(64) float rows[3][kRow * kRow];
  for (int axis = 0; axis < 3; ++axis) {
    for (int x = 0; x < kRow; ++x) {
      const float base = corner[static_cast<std::size_t>(axis)] + static_cast<float>(x) * s.grid[0][axis];
      for (int y = 0; y < kRow; y += static_cast<int>(hn::MaxLanes(kRowTag))) {
        hn::Store(hn::Add(hn::Set(kRowTag, base), hn::Load(kRowTag, s.across[axis] + y)), kRowTag,
                  rows[axis] + kRow * x + y);
      }
    }
  }
  // First, select the rows by their middles.
  std::uint64_t active = 0;
  const V middle_x = Splat(kHalfRow * s.grid[2][0]);
  const V middle_y = Splat(kHalfRow * s.grid[2][1]);
  const V middle_z = Splat(kHalfRow * s.grid[2][2]);
  for (int row = 0; row < kRow * kRow; row += kLanes) {
    const M may = swept.MayChange(hn::Add(hn::Load(kFloats, rows[0] + row), middle_x),
                                  hn::Add(hn::Load(kFloats, rows[1] + row), middle_y),
                                  hn::Add(hn::Load(kFloats, rows[2] + row), middle_z));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kFloats, may, bits);
    active |= static_cast<std::uint64_t>(bits[0] | bits[1] << 8) << row;
  }
  // Then compute their voxels.
  CarveLoss loss;
  loss.rows = std::popcount(active);
  alignas(64) float lost[kPair] = {};
  const V band = Splat(s.band);
  const V per_voxel = Splat(1 / s.voxel);
  // Veltkamp's splitting keeps the upper bits of a significand, rounded to nearest.
  const bool rounds = s.precision_bits < 24;
  const V splitter = Splat(static_cast<float>(1 << (24 - s.precision_bits)) + 1);
  std::uint64_t pairs = (active | active >> 1) & 0x5555555555555555u;
  for (; pairs != 0; pairs &= pairs - 1) {
    const int row = std::countr_zero(pairs);
    const auto of_pair = static_cast<unsigned>(active >> row) & 3u;
    for (int part = 0; part < kPair; part += kLanes) {
      if (kLanes <= kRow && !(of_pair >> (part / kRow) & 1u)) continue;
      V depth = swept.Depth(hn::Add(OfRows(rows[0], row, part), hn::Load(kFloats, s.along[0] + part)),
                            hn::Add(OfRows(rows[1], row, part), hn::Load(kFloats, s.along[1] + part)),
                            hn::Add(OfRows(rows[2], row, part), hn::Load(kFloats, s.along[2] + part)));
      if (s.whole_voxels) {
        depth = hn::Mul(hn::Add(hn::Floor(hn::Mul(depth, per_voxel)), Splat(0.5f)), Splat(s.voxel));
      }
      if (rounds) {
        const V split = hn::Mul(depth, splitter);
        depth = hn::Sub(split, hn::Sub(split, depth));
      }
      float* HWY_RESTRICT voxels = values + kRow * row + part;
      const V old = hn::LoadU(kFloats, voxels);
      const V now = hn::Min(depth, band);
      M grown = hn::Gt(now, old);
      if constexpr (kLanes == kPair) {
        // A row that is not selected stays unchanged, as it does where rows are computed one by one.
        static constexpr std::uint8_t kLanesOf[4][8] = {{0, 0}, {0xff, 0}, {0, 0xff}, {0xff, 0xff}};
        grown = hn::And(grown, hn::LoadMaskBits(kFloats, kLanesOf[of_pair]));
      }
      if (hn::AllFalse(kFloats, grown)) continue;
      const V phi = hn::IfThenElse(grown, now, old);
      hn::StoreU(phi, kFloats, voxels);
      loss.changed += static_cast<int>(hn::CountTrue(kFloats, grown));
      const V less = hn::Sub(Fraction(old, per_voxel), Fraction(phi, per_voxel));
      hn::Store(hn::Add(hn::Load(kFloats, lost + part), less), kFloats, lost + part);
    }
  }
  for (const float part : lost) loss.voxels += static_cast<double>(part);
  return loss;
}

/// Sets a bit in `near` for each leaf that may have a voxel in the zone.
void Cull(const LeafCull& c, const float* x, const float* y, const float* z, int count, std::uint64_t* near) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
  const V outer = Splat(c.outer);
  const V inner = Splat(c.inner);
  const V half_leaf2 = Splat(c.half_leaf2);
  const auto project = [](const float(&e)[3], V px, V py, V pz) {
    return hn::Add(hn::Add(hn::Mul(Splat(e[0]), px), hn::Mul(Splat(e[1]), py)), hn::Mul(Splat(e[2]), pz));
  };
  for (int first = 0; first < count; first += 64) {
    std::uint64_t found = 0;
    for (int i = first; i < first + 64 && i < count; i += kLanes) {
      const V px = hn::Load(kFloats, x + i);
      const V py = hn::Load(kFloats, y + i);
      const V pz = hn::Load(kFloats, z + i);
      V qx = hn::Add(project(c.axes[0], px, py, pz), Splat(c.origin[0]));
      V qy = hn::Add(project(c.axes[1], px, py, pz), Splat(c.origin[1]));
      V qz = hn::Add(project(c.axes[2], px, py, pz), Splat(c.origin[2]));
      M may = hn::Le(project(c.back, qx, qy, qz), Splat(c.behind));
      may = hn::And(may, hn::Le(hn::Abs(qz), Splat(c.axial)));
      qz = hn::Mul(qz, Splat(c.axial_counts));
      const V distance = hn::Max(hn::Sqrt(hn::Add(hn::Add(Square(qx), Square(qy)), Square(qz))), Splat(c.min_distance));
      V extent = hn::Zero(kFloats);
      for (const auto& half_edge : c.half_edges) extent = hn::Add(extent, hn::Abs(project(half_edge, qx, qy, qz)));
      extent = hn::Div(extent, distance);
      may = hn::And(may, hn::Le(hn::Sub(distance, extent), outer));
      // A voxel at offset s from the middle has a distance of at most distance + s.e + |s|^2 / (2 distance).
      const V furthest = hn::Add(hn::Add(distance, extent), hn::Div(half_leaf2, hn::Add(distance, distance)));
      may = hn::And(may, hn::Ge(furthest, inner));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kFloats, may, bits);
      found |= static_cast<std::uint64_t>(bits[0] | bits[1] << 8) << (i - first);
    }
    if (count - first < 64) found &= (std::uint64_t{1} << (count - first)) - 1;
    near[first / 64] = found;
  }
}

CarveLoss CarveDisc(const CarveStep& step, const std::array<float, 3>& corner, float* values) {
  return Carve<Disc>(step, corner, values);
}
CarveLoss CarveBall(const CarveStep& step, const std::array<float, 3>& corner, float* values) {
  return Carve<Ball>(step, corner, values);
}
void CullLeaves(const LeafCull& cull, const float* x, const float* y, const float* z, int count, std::uint64_t* near) {
  Cull(cull, x, y, z, count, near);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(CarveDisc);
HWY_EXPORT(CarveBall);
HWY_EXPORT(CullLeaves);

std::string NameOf(std::int64_t target) {
  std::string name = hwy::TargetName(target);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

/// Returns a bit for each instruction set; the lowest bit is the widest set.
std::int64_t AllTargets() {
  hwy::SetSupportedTargetsForTest(0);
  return hwy::SupportedTargets() & HWY_TARGETS;
}

/// Set by SetVectorTarget(); 0: the best.
std::int64_t chosen_target = 0;

}  // namespace

void CarveStep::Prepare() {
  constexpr float kHalfRow = 3.5f;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 8; ++i) across[axis][i] = static_cast<float>(i) * grid[1][axis];
    for (int i = 0; i < 16; ++i) along[axis][i] = static_cast<float>(i % 8) * grid[2][axis];
  }
  row_mm = kHalfRow * std::sqrt(grid[2][0] * grid[2][0] + grid[2][1] * grid[2][1]);
  // The curvature of a distance is at most 1 / distance. This is used only where the distance is at least half a
  // radius.
  bend_mm = 0.5f * radius > 2 * row_mm ? 0.5f * row_mm * row_mm / (0.5f * radius - row_mm) : row_mm;
  const float along_row = back[0] * grid[2][0] + back[1] * grid[2][1] + back[2] * grid[2][2];
  behind_mm = length + rounding + kHalfRow * std::abs(along_row);
}

CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, float* values) {
  if (step.ball) return HWY_DYNAMIC_DISPATCH(CarveBall)(step, corner_T, values);
  return HWY_DYNAMIC_DISPATCH(CarveDisc)(step, corner_T, values);
}

void FindLeaves(const LeafCull& cull, const LeafMiddles& middles, int count, std::uint64_t* near) {
  HWY_DYNAMIC_DISPATCH(CullLeaves)(cull, middles.x, middles.y, middles.z, count, near);
}

std::vector<std::string> VectorTargets() {
  std::vector<std::string> names;
  for (std::int64_t left = AllTargets(); left != 0; left &= left - 1) names.push_back(NameOf(left & -left));
  hwy::SetSupportedTargetsForTest(chosen_target);
  return names;
}

std::string VectorTarget() {
  const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  return NameOf(targets & -targets);
}

void SetVectorTarget(std::string_view name) {
  chosen_target = 0;
  std::string known;
  for (std::int64_t left = AllTargets(); left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    if (name == NameOf(target)) chosen_target = target;
    known += (known.empty() ? "" : ", ") + NameOf(target);
  }
  hwy::SetSupportedTargetsForTest(chosen_target);
  if (chosen_target == 0 && !name.empty()) {
    throw Error(fmt::format("this machine has no vector instructions \"{}\"; it has {}", name, known));
  }
}

}  // namespace kerf
#endif  // HWY_ONCE
