// Compiled once for each vector instruction set. No multiply-add: a fused one rounds once where two operations round
// twice, and not every set has it. Additions, multiplications, divisions and square roots round the same everywhere.
#include "removal/carve.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "kerf/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "removal/carve.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 8>;  // a row of a leaf, or a part of one
using V = hn::Vec<Floats>;
using M = hn::Mask<Floats>;
constexpr Floats kFloats;
constexpr int kRow = 8;
constexpr float kHalfRow = 3.5f;  // from the middle of a row to its ends, in voxels

HWY_INLINE V Splat(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE V Square(V a) {
  return hn::Mul(a, a);
}
HWY_INLINE V Length(V x, V y) {
  return hn::Sqrt(hn::Add(Square(x), Square(y)));
}

/// A disc that has moved in its own plane: a stadium of its thickness.
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
    const float along = std::abs(kHalfRow * s.grid[2][2]);
    const float across = kHalfRow * std::sqrt(s.grid[2][0] * s.grid[2][0] + s.grid[2][1] * s.grid[2][1]);
    row_z_ = Splat(along);
    row_xy_ = Splat(across);
    const float half_radius = 0.5f * s.radius;
    half_radius_ = Splat(half_radius);
    // A distance to a point or segment bends by at most 1 / distance.
    bend_ = Splat(half_radius > 2 * across ? 0.5f * across * across / (half_radius - across) : across);
    const float reach = s.band + s.rounding;
    reach2_ = Splat(reach * reach);
    slack_ = Splat(s.length + s.flank_slack + s.rounding);
    behind_ = Splat(s.length + s.rounding +
                    std::abs(s.back[0] * kHalfRow * s.grid[2][0] + s.back[1] * kHalfRow * s.grid[2][1]));
  }

  /// Which of the rows with their middles at these points hold a voxel that the step may change.
  HWY_INLINE M MayChange(V x, V y, V z) const {
    const V zero = hn::Zero(kFloats);
    const V along = hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_));
    const V t = hn::Min(hn::Max(along, zero), length_);
    const V qx = hn::Sub(x, hn::Mul(t, back_x_));
    const V qy = hn::Sub(y, hn::Mul(t, back_y_));
    const V axis_distance = Length(qx, qy);
    const V radial = hn::Sub(axis_distance, radius_);
    // Half the row's extent along the outward direction.
    const V extent = hn::Div(hn::Abs(hn::Add(hn::Mul(qx, row_x_), hn::Mul(qy, row_y_))),
                             hn::Max(axis_distance, hn::Mul(half_radius_, Splat(1e-3f))));
    // The nearest that any of the row comes: the distance is convex, so it lies above its tangent.
    const V axial = hn::Sub(hn::Max(hn::Sub(hn::Abs(z), row_z_), zero), half_thickness_);
    const V out_r = hn::Max(hn::Sub(radial, extent), zero);
    const V out_a = hn::Max(axial, zero);
    M may = hn::Le(hn::Add(Square(out_r), Square(out_a)), reach2_);
    // The outermost of the row.
    const V bent = hn::Min(hn::Add(extent, bend_), row_xy_);
    const V outermost = hn::Add(radial, hn::IfThenElse(hn::Ge(axis_distance, half_radius_), bent, row_xy_));
    may = hn::And(may, hn::Ge(outermost, edge_depth_));
    if (new_only_) {
      // Further in than the flats are near, the flats' distance counts, which is as it was.
      const V inner = hn::Sub(hn::Min(axial, zero), slack_);
      may = hn::And(may, hn::And(hn::Ge(outermost, inner), hn::Le(along, behind_)));
    }
    return may;
  }

  /// -distance; beyond the band where the disc does not cut.
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
  V edge_depth_;  // negative: as a radial distance
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

/// A ball that has moved: a capsule.
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
        // Deeper than the band all is air, and was so after the step before.
        inner_(Splat(-(s.band + s.length + s.rounding))),
        least_(Splat(1e-3f * s.radius)),
        new_only_(s.new_only) {
    behind_ =
        Splat(s.length + s.rounding +
              std::abs(kHalfRow * (s.back[0] * s.grid[2][0] + s.back[1] * s.grid[2][1] + s.back[2] * s.grid[2][2])));
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

/// Occupancy: clamp(1/2 - phi/h, 0, 1).
HWY_INLINE V Share(V phi, V per_voxel) {
  const V share = hn::Sub(Splat(0.5f), hn::Mul(phi, per_voxel));
  return hn::Min(hn::Max(share, hn::Zero(kFloats)), Splat(1));
}

template <typename Swept>
CarveLoss Carve(const CarveStep& s, const std::array<float, 3>& corner, float* HWY_RESTRICT values) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
  const Swept swept(s);
  // Offsets of the voxels along a row, and of the rows along y, as products: the same for whatever part of a row.
  alignas(64) float along_row[3][kRow];
  alignas(64) float across[3][kRow];
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kRow; ++i) {
      along_row[axis][i] = static_cast<float>(i) * s.grid[2][axis];
      across[axis][i] = static_cast<float>(i) * s.grid[1][axis];
    }
  }
  // First which rows: eight at a time by their middles.
  alignas(64) float rows[3][kRow * kRow];
  std::uint64_t active = 0;
  const V middle_x = Splat(kHalfRow * s.grid[2][0]);
  const V middle_y = Splat(kHalfRow * s.grid[2][1]);
  const V middle_z = Splat(kHalfRow * s.grid[2][2]);
  for (int x = 0; x < kRow; ++x) {
    const V base_x = Splat(corner[0] + static_cast<float>(x) * s.grid[0][0]);
    const V base_y = Splat(corner[1] + static_cast<float>(x) * s.grid[0][1]);
    const V base_z = Splat(corner[2] + static_cast<float>(x) * s.grid[0][2]);
    for (int y = 0; y < kRow; y += kLanes) {
      const V row_x = hn::Add(base_x, hn::Load(kFloats, across[0] + y));
      const V row_y = hn::Add(base_y, hn::Load(kFloats, across[1] + y));
      const V row_z = hn::Add(base_z, hn::Load(kFloats, across[2] + y));
      const int row = kRow * x + y;
      hn::Store(row_x, kFloats, rows[0] + row);
      hn::Store(row_y, kFloats, rows[1] + row);
      hn::Store(row_z, kFloats, rows[2] + row);
      const M may = swept.MayChange(hn::Add(row_x, middle_x), hn::Add(row_y, middle_y), hn::Add(row_z, middle_z));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kFloats, may, bits);
      active |= static_cast<std::uint64_t>(bits[0]) << row;
    }
  }
  // Then their voxels.
  CarveLoss loss;
  loss.rows = std::popcount(active);
  alignas(64) float lost[kRow] = {};
  const V band = Splat(s.band);
  const V per_voxel = Splat(1 / s.voxel);
  for (; active != 0; active &= active - 1) {
    const int row = std::countr_zero(active);
    const V row_x = Splat(rows[0][row]);
    const V row_y = Splat(rows[1][row]);
    const V row_z = Splat(rows[2][row]);
    for (int z = 0; z < kRow; z += kLanes) {
      V depth = swept.Depth(hn::Add(row_x, hn::Load(kFloats, along_row[0] + z)),
                            hn::Add(row_y, hn::Load(kFloats, along_row[1] + z)),
                            hn::Add(row_z, hn::Load(kFloats, along_row[2] + z)));
      if (s.whole_voxels) {
        depth = hn::Mul(hn::Add(hn::Floor(hn::Mul(depth, per_voxel)), Splat(0.5f)), Splat(s.voxel));
      }
      float* HWY_RESTRICT part = values + kRow * row + z;
      const V old = hn::LoadU(kFloats, part);
      const V now = hn::Min(depth, band);
      const M grown = hn::Gt(now, old);
      if (hn::AllFalse(kFloats, grown)) continue;
      const V phi = hn::Max(old, now);
      hn::StoreU(phi, kFloats, part);
      loss.changed += static_cast<int>(hn::CountTrue(kFloats, grown));
      const V less = hn::Sub(Share(old, per_voxel), Share(phi, per_voxel));
      hn::Store(hn::Add(hn::Load(kFloats, lost + z), less), kFloats, lost + z);
    }
  }
  for (const float part : lost) loss.voxels += static_cast<double>(part);
  return loss;
}

CarveLoss CarveDisc(const CarveStep& step, const std::array<float, 3>& corner, float* values) {
  return Carve<Disc>(step, corner, values);
}
CarveLoss CarveBall(const CarveStep& step, const std::array<float, 3>& corner, float* values) {
  return Carve<Ball>(step, corner, values);
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

std::string NameOf(std::int64_t target) {
  std::string name = hwy::TargetName(target);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

/// A bit for each instruction set; the lowest is the widest.
std::int64_t AllTargets() {
  hwy::SetSupportedTargetsForTest(0);
  return hwy::SupportedTargets() & HWY_TARGETS;
}

/// What SetVectorTarget() asked for; 0: the best.
std::int64_t chosen_target = 0;

}  // namespace

CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, float* values) {
  if (step.ball) return HWY_DYNAMIC_DISPATCH(CarveBall)(step, corner_T, values);
  return HWY_DYNAMIC_DISPATCH(CarveDisc)(step, corner_T, values);
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
