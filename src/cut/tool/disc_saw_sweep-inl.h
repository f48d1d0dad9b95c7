// Sweep of a disc saw over one step. Compiled once for each vector instruction set.
#if defined(KERF_CUT_TOOL_DISC_SAW_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_DISC_SAW_SWEEP_INL_H_
#undef KERF_CUT_TOOL_DISC_SAW_SWEEP_INL_H_
#else
#define KERF_CUT_TOOL_DISC_SAW_SWEEP_INL_H_
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "cut/tool/carve_step.h"
#include "cut/tool/vectors-inl.h"
#include "kerf/tool.h"

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

/// Sweep of a disc that moves in its own plane: a stadium with the disc's thickness.
class DiscSweep {
 public:
  DiscSweep(const CarveStep& s, const std::array<float, 3>& corner)
      : radius_(Splat(s.radius)),
        half_thickness_(Splat(s.half_thickness)),
        edge_depth_(Splat(-s.edge_depth)),
        edge_depth_in_(Splat(s.edge_depth)),
        back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        length_(Splat(s.length)),
        far_(Splat(-2 * s.band)),
        half_y_{Splat(s.half_y[0]), Splat(s.half_y[1])},
        half_z_{Splat(s.half_z[0]), Splat(s.half_z[1])},
        brick_z_(Splat(s.brick_z_mm)),
        brick_xy_(Splat(s.brick_mm)),
        new_only_(s.new_only) {
    half_radius_ = Splat(0.5f * s.radius);
    bend_ = Splat(s.bend_mm);
    const float reach = s.band + s.rounding;
    reach2_ = Splat(reach * reach);
    float furthest_back = s.back[0] * corner[0] + s.back[1] * corner[1] + s.rounding;
    for (const auto& step : s.grid) furthest_back += std::max(0.0f, 7 * (s.back[0] * step[0] + s.back[1] * step[1]));
    is_in_front_ = furthest_back <= 0;
    slack_ = Splat(s.length + s.flank_slack + s.rounding);
    behind_ = Splat(s.behind_mm);
  }

  /// Returns a mask of the bricks with a voxel that the step may change, computed from the middles of the bricks.
  HWY_INLINE M MayChange(V x, V y, V z) const {
    const V zero = hn::Zero(kFloats);
    const V along = hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_));
    const V t = hn::Min(hn::Max(along, zero), length_);
    const V qx = hn::Sub(x, hn::Mul(t, back_x_));
    const V qy = hn::Sub(y, hn::Mul(t, back_y_));
    const V axis_distance = Length(qx, qy);
    const V radial = hn::Sub(axis_distance, radius_);
    // Half of the brick's extent along the outward direction.
    const V reach = hn::Add(hn::Abs(Dot(qx, qy, half_y_[0], half_y_[1])), hn::Abs(Dot(qx, qy, half_z_[0], half_z_[1])));
    const V extent = hn::Div(reach, hn::Max(axis_distance, hn::Mul(half_radius_, Splat(1e-3f))));
    // Lower bound on the brick's distance: the distance is convex, so it lies above its tangent.
    const V axial = hn::Sub(hn::Max(hn::Sub(hn::Abs(z), brick_z_), zero), half_thickness_);
    const V out_r = hn::Max(hn::Sub(radial, extent), zero);
    const V out_a = hn::Max(axial, zero);
    M may = hn::Le(hn::Add(Square(out_r), Square(out_a)), reach2_);
    // Upper bound on the radial distance in the brick.
    const V bent = hn::Min(hn::Add(extent, bend_), brick_xy_);
    const V outermost = hn::Add(radial, hn::IfThenElse(hn::Ge(axis_distance, half_radius_), bent, brick_xy_));
    may = hn::And(may, hn::Ge(outermost, edge_depth_));
    if (new_only_) {
      // Where the flats are nearer than the rim, the distance to the flats applies, and it has not changed.
      const V inner = hn::Sub(hn::Min(axial, zero), slack_);
      may = hn::And(may, hn::And(hn::Ge(outermost, inner), hn::Le(along, behind_)));
    }
    return may;
  }

  /// Returns -distance; outside of the zone in which the disc cuts, a value beyond the band.
  HWY_INLINE V Depth(V x, V y, V z, V /*old*/) const {
    const V zero = hn::Zero(kFloats);
    V qx = x;
    V qy = y;
    if (!is_in_front_) {
      const V t = hn::Min(hn::Max(hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_)), zero), length_);
      qx = hn::Sub(x, hn::Mul(t, back_x_));
      qy = hn::Sub(y, hn::Mul(t, back_y_));
    }
    // Depths: the distances inside the rim and the flats.
    const V radial = hn::Sub(radius_, Length(qx, qy));
    const V axial = hn::Sub(half_thickness_, hn::Abs(z));
    const V inside = hn::Max(hn::Min(radial, axial), zero);
    const V outside = Length(hn::Min(radial, zero), hn::Min(axial, zero));
    // In a step that continues, the flats do not cut by what they have moved since they last did. If they did in some
    // bricks, the result would depend on which bricks are computed.
    V deepest = edge_depth_in_;
    if (new_only_) deepest = hn::Min(deepest, hn::Add(hn::Max(axial, zero), slack_));
    return hn::IfThenElse(hn::Le(radial, deepest), hn::Sub(inside, outside), far_);
  }

 private:
  V radius_;
  V half_thickness_;
  V edge_depth_;  // negative, as a radial distance
  V edge_depth_in_;
  V back_x_;
  V back_y_;
  V length_;
  V far_;
  V half_y_[2];
  V half_z_[2];
  bool is_in_front_;  // the end of the step is its nearest place to every voxel of the leaf
  V brick_z_;
  V brick_xy_;
  V half_radius_;
  V bend_;
  V reach2_;
  V slack_;
  V behind_;
  bool new_only_;
};

template <>
struct SweepOf<DiscSaw> {
  using Type = DiscSweep;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#endif
