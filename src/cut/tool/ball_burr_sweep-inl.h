// Sweep of a ball burr over one step. Compiled once for each vector instruction set.
#if defined(KERF_CUT_TOOL_BALL_BURR_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_BALL_BURR_SWEEP_INL_H_
#undef KERF_CUT_TOOL_BALL_BURR_SWEEP_INL_H_
#else
#define KERF_CUT_TOOL_BALL_BURR_SWEEP_INL_H_
#endif

#include <array>

#include "cut/tool/carve_step.h"
#include "cut/tool/vectors-inl.h"
#include "kerf/tool.h"

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

/// Sweep of a ball: a capsule.
class BallSweep {
 public:
  BallSweep(const CarveStep& s, const std::array<float, 3>& /*corner*/)
      : radius_(Splat(s.radius)),
        back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        back_z_(Splat(s.back[2])),
        length_(Splat(s.length)),
        half_y_{Splat(s.half_y[0]), Splat(s.half_y[1]), Splat(s.half_y[2])},
        half_z_{Splat(s.half_z[0]), Splat(s.half_z[1]), Splat(s.half_z[2])},
        brick_(Splat(1.5812f * s.voxel)),  // sqrt(0.5^2 + 1.5^2)
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
    const auto across = [&](const V(&half)[3]) {
      return hn::Abs(hn::Add(Dot(qx, qy, half[0], half[1]), hn::Mul(qz, half[2])));
    };
    const V extent = hn::Div(hn::Add(across(half_y_), across(half_z_)), hn::Max(axis_distance, least_));
    M may = hn::Le(hn::Sub(distance, extent), outer_);
    if (new_only_) {
      may = hn::And(may, hn::And(hn::Ge(hn::Add(distance, brick_), inner_), hn::Le(along, behind_)));
    }
    return may;
  }

  HWY_INLINE V Depth(V x, V y, V z, V /*old*/) const {
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
  V half_y_[3];
  V half_z_[3];
  V brick_;
  V outer_;
  V inner_;
  V least_;
  V behind_;
  bool new_only_;
};

template <>
struct SweepOf<BallBurr> {
  using Type = BallSweep;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#endif
