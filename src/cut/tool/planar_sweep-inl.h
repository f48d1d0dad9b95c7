// Sweep of a blade with a convex outline over one step. Compiled once for each vector instruction set.
#if defined(KERF_CUT_TOOL_PLANAR_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_PLANAR_SWEEP_INL_H_
#undef KERF_CUT_TOOL_PLANAR_SWEEP_INL_H_
#else
#define KERF_CUT_TOOL_PLANAR_SWEEP_INL_H_
#endif

#include <array>
#include <cmath>
#include <cstdint>

#include "cut/tool/carve_step.h"
#include "cut/tool/vectors-inl.h"
#include "kerf/tool.h"

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

/// Sweep of a flat blade that moves in its own plane: a prism over the hull of its outlines (CarveStep::sides).
class PlanarSweep {
 public:
  PlanarSweep(const CarveStep& s, const std::array<float, 3>& corner)
      : s_(s),
        half_thickness_(Splat(s.half_thickness)),
        edge_depth_(Splat(-s.edge_depth)),
        far_(Splat(-2 * s.band)),
        band_(Splat(s.band)),
        brick_z_(Splat(s.brick_z_mm)),
        brick_xy_(Splat(s.brick_mm)),
        reach2_(Splat((s.band + s.rounding) * (s.band + s.rounding))),
        slack_(Splat(s.flank_slack + s.length + s.rounding)) {
    SelectSides(corner);
  }

  /// Returns a mask of the bricks with a voxel that the step may change, computed from the middles of the bricks.
  HWY_INLINE M MayChange(V x, V y, V z) const {
    const V zero = hn::Zero(kFloats);
    V edge;
    V foot_off;
    const V outward = Outward(x, y, edge, foot_off);
    const V axial = hn::Sub(hn::Max(hn::Sub(hn::Abs(z), brick_z_), zero), half_thickness_);
    // The distance to the furthest side is a lower bound on the distance outside.
    const V out_r = hn::Max(hn::Sub(outward, brick_xy_), zero);
    const V out_a = hn::Max(axial, zero);
    M may = hn::Le(hn::Add(Square(out_r), Square(out_a)), reach2_);
    may = hn::And(may, hn::Ge(hn::Add(edge, brick_xy_), edge_depth_));
    // Where the flats are nearer than the outline, the distance to the flats applies, and it has not changed.
    if (s_.new_only) may = hn::And(may, hn::Ge(hn::Add(outward, brick_xy_), hn::Sub(hn::Min(axial, zero), slack_)));
    return may;
  }

  /// Returns -distance; outside of the zone in which the blade cuts, a value beyond the band.
  HWY_INLINE V Depth(V x, V y, V z, V /*old*/) const {
    const V zero = hn::Zero(kFloats);
    V edge;
    V foot_off;
    V radial = Outward(x, y, edge, foot_off);
    // The furthest line is also the nearest side, unless the foot on it lies beyond a corner.
    const M by_line = hn::Or(hn::Le(foot_off, zero), hn::Or(hn::Le(radial, zero), hn::Gt(radial, band_)));
    if (!hn::AllTrue(kFloats, by_line)) radial = hn::IfThenElse(by_line, radial, ToSides(x, y));
    const V axial = hn::Sub(hn::Abs(z), half_thickness_);
    const V inside = hn::Min(hn::Max(radial, axial), zero);
    const V outside = Length(hn::Max(radial, zero), hn::Max(axial, zero));
    return hn::IfThenElse(hn::Ge(edge, edge_depth_), hn::Neg(hn::Add(inside, outside)), far_);
  }

 private:
  /// Selects the sides that may be the furthest at a voxel of the leaf, or the furthest of those that cut, and their
  /// neighbours: the corners are then those of all sides. Two distances change by at most the difference of the normals
  /// times the way from the middle of the leaf.
  void SelectSides(const std::array<float, 3>& corner) {
    const float reach = 1.7321f * kHalfLeaf * s_.voxel;
    const std::array<float, 3> middle = s_.Middle(corner);
    float out[CarveStep::kMaxSides];
    int furthest = 0;
    int furthest_edge = -1;
    for (int i = 0; i < s_.sides; ++i) {
      const CarveStep::Side& side = s_.side[i];
      out[i] = (middle[0] - side.x) * side.nx + (middle[1] - side.y) * side.ny;
      if (out[i] > out[furthest]) furthest = i;
      if (side.cuts && (furthest_edge < 0 || out[i] > out[furthest_edge])) furthest_edge = i;
    }
    const auto may_exceed = [&](int i, int other) {
      const float nx = s_.side[i].nx - s_.side[other].nx;
      const float ny = s_.side[i].ny - s_.side[other].ny;
      const float behind = out[other] - out[i] - s_.rounding;
      return behind <= 0 || behind * behind <= (nx * nx + ny * ny) * reach * reach;
    };
    std::uint64_t kept = 0;
    for (int i = 0; i < s_.sides; ++i) {
      if (!may_exceed(i, furthest) && !(s_.side[i].cuts && may_exceed(i, furthest_edge))) continue;
      for (const int n : {i > 0 ? i - 1 : s_.sides - 1, i, i + 1 < s_.sides ? i + 1 : 0}) kept |= std::uint64_t{1} << n;
    }
    for (int i = 0; i < s_.sides; ++i) {
      if ((kept >> i & 1) != 0) side_[sides_++] = s_.side[i];
    }
  }
  /// Returns the distance outwards from the furthest of the sides' lines, and sets `edge` to that of the sides that
  /// cut, and `foot_off` to the distance of the foot on that line from its side, negative within.
  HWY_INLINE V Outward(V x, V y, V& edge, V& foot_off) const {
    V outward = Splat(-1e30f);
    edge = outward;
    foot_off = outward;
    for (int i = 0; i < sides_; ++i) {
      const CarveStep::Side& side = side_[i];
      const V px = hn::Sub(x, Splat(side.x));
      const V py = hn::Sub(y, Splat(side.y));
      const V out = hn::Add(hn::Mul(px, Splat(side.nx)), hn::Mul(py, Splat(side.ny)));
      const V ahead = Ahead(side, px, py);
      const M further = hn::Gt(out, outward);
      foot_off = hn::IfThenElse(further, hn::Max(hn::Neg(ahead), hn::Sub(ahead, Splat(side.length))), foot_off);
      outward = hn::Max(outward, out);
      if (side.cuts) edge = hn::Max(edge, out);
    }
    return outward;
  }
  /// Returns the coordinate along a side of a point relative to the side's start.
  static HWY_INLINE V Ahead(const CarveStep::Side& side, V px, V py) {
    return hn::Sub(hn::Mul(py, Splat(side.nx)), hn::Mul(px, Splat(side.ny)));
  }
  /// Returns the distance from the nearest of the sides, as segments.
  HWY_INLINE V ToSides(V x, V y) const {
    V least2 = Splat(1e30f);
    for (int i = 0; i < sides_; ++i) {
      const CarveStep::Side& side = side_[i];
      const V px = hn::Sub(x, Splat(side.x));
      const V py = hn::Sub(y, Splat(side.y));
      const V t = hn::Min(hn::Max(Ahead(side, px, py), hn::Zero(kFloats)), Splat(side.length));
      const V qx = hn::Add(px, hn::Mul(t, Splat(side.ny)));
      const V qy = hn::Sub(py, hn::Mul(t, Splat(side.nx)));
      least2 = hn::Min(least2, hn::Add(Square(qx), Square(qy)));
    }
    return hn::Sqrt(least2);
  }

  const CarveStep& s_;
  int sides_ = 0;  // the selected ones, in their order
  CarveStep::Side side_[CarveStep::kMaxSides];
  V half_thickness_;
  V edge_depth_;  // negative
  V far_;
  V band_;
  V brick_z_;
  V brick_xy_;
  V reach2_;
  V slack_;
};

template <>
struct SweepOf<ReciprocatingBlade> {
  using Type = PlanarSweep;
};
template <>
struct SweepOf<OscillatingBlade> {
  using Type = PlanarSweep;
};
template <>
struct SweepOf<PiezoInsert> {
  using Type = PlanarSweep;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#endif
