// Sweep of a tool of the form kRound over one step. Compiled once for each vector instruction set.
#if defined(KERF_CUT_TOOL_ROUND_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
#undef KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
#else
#define KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
#endif

#include <cmath>

#include "cut/tool/carve_step.h"
#include "cut/tool/vectors-inl.h"
#include "kerf/tool.h"

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

/// Sweep of a convex solid of revolution along a straight line. The solid is where the largest of its faces' distances
/// is at most 0. Each of these is a convex function of the way. The least value of the largest of them is that of one
/// face at an end of the way or at its own minimum, which has a closed form, or of two where they cross. Between the
/// ends, the crossing treats the distance from the axis as linear, an error of at most length^2 / (8 radius); the
/// cutter keeps that small.
class RoundSweep {
 public:
  explicit RoundSweep(const CarveStep& s)
      : back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        back_z_(Splat(s.back[2])),
        length_(Splat(s.length)),
        ceiling_(Splat(s.ceiling)),
        far_(Splat(-2 * s.band)),
        beyond_(Splat(s.band + s.length + s.rounding)),
        deep_(Splat(-s.band)),
        new_only_(s.new_only) {
    const float across = std::sqrt(s.back[0] * s.back[0] + s.back[1] * s.back[1]);
    const bool is_across = across > 1e-6f;
    per_across_ = Splat(is_across ? 1 / across : 0);
    way_across_ = Splat(is_across ? across * s.length : 0);
    const float row_xy = s.row_mm;
    const float row_z = std::abs(kHalfRow * s.grid[2][2]);
    row_z_ = Splat(row_z);
    for (int i = 0; i < kFaces; ++i) {
      r_[i] = Splat(s.faces[i].r);
      z_[i] = Splat(s.faces[i].z);
      offset_[i] = Splat(s.faces[i].offset);
      // Where a face's distance is least: w / c, with c the least distance from the axis on the line, at w beyond that.
      const float steep = is_across ? s.faces[i].z * s.back[2] / (across * std::max(s.faces[i].r, 1e-6f)) : 0;
      turn_[i] = Splat(is_across ? -s.faces[i].r * across : 0);
      rise_[i] = Splat(-s.faces[i].z * s.back[2]);
      at_least_[i] = Splat(std::abs(steep) < 1 ? steep / std::sqrt(1 - steep * steep) : std::copysign(1e6f, steep));
      extent_[i] = Splat(s.faces[i].r * row_xy + std::abs(s.faces[i].z) * row_z);
    }
    outer_ = Splat(s.band + s.rounding);
    inner_ = Splat(-(s.band + s.flank_slack + s.rounding));
    reach_ = Splat(s.length + 2 * s.rounding);
    row_xy_ = Splat(row_xy);
    still_ = Splat(s.flank_slack + s.rounding);
    bend_ = Splat((row_xy + s.length) * s.length);
  }

  HWY_INLINE M MayChange(V x, V y, V z) const {
    const Ends e = FindEnds(x, y, z);
    const V z_low = hn::Min(e.z0, e.z1);
    const V z_high = hn::Max(e.z0, e.z1);
    V least = Splat(-1e30f);
    V at_start = Splat(-1e30f);  // largest distance in the row where the step starts
    // The distance from the axis changes by at most the way. The radial parts of the motion differ between the voxels
    // of a row by at most bend_ / clear.
    const V r_least = hn::Max(hn::Mul(Splat(0.5f), hn::Sub(hn::Add(e.r0, e.r1), reach_)), hn::Zero(kFloats));
    const V clear = hn::Sub(r_least, row_xy_);
    M advances = hn::Le(clear, hn::Add(row_xy_, length_));
    for (int i = 0; i < kFaces; ++i) {
      const V z_least = hn::Min(hn::Mul(z_[i], z_low), hn::Mul(z_[i], z_high));
      least = hn::Max(least, hn::Sub(hn::Add(hn::Mul(r_[i], r_least), z_least), hn::Add(offset_[i], extent_[i])));
      const V d1 = Distance(i, e.r1, e.z1);
      at_start = hn::Max(at_start, hn::Add(d1, extent_[i]));
      const V forward = hn::Sub(Distance(i, e.r0, e.z0), d1);
      advances = hn::Or(advances, hn::Lt(hn::Mul(hn::Sub(forward, still_), clear), hn::Mul(r_[i], bend_)));
    }
    M may = hn::And(hn::Le(least, outer_), hn::Le(hn::Sub(z_low, row_z_), ceiling_));
    if (new_only_) {
      const M is_new = hn::Or(hn::And(advances, hn::Ge(at_start, inner_)), hn::Gt(hn::Add(z_high, row_z_), ceiling_));
      may = hn::And(may, is_new);
    }
    return may;
  }

  HWY_INLINE V Depth(V x, V y, V z) const {
    const Ends e = FindEnds(x, y, z);
    V a[kFaces];
    V d[kFaces];
    for (int i = 0; i < kFaces; ++i) {
      a[i] = Distance(i, e.r0, e.z0);
      d[i] = Distance(i, e.r1, e.z1);
    }
    const V at_end = hn::Max(hn::Max(a[0], a[1]), a[2]);
    const V at_start = hn::Max(hn::Max(d[0], d[1]), d[2]);
    V least = hn::Min(at_end, at_start);
    // The least value is that of an end if the same face is the largest at both ends and has no minimum in between.
    // Values that change nothing because they are outside the band may be too large by the length of the step.
    M is_at_an_end = hn::Or(hn::Ge(least, beyond_), hn::Le(least, deep_));
    const V along1 = hn::Sub(e.along, way_across_);
    for (int i = 0; i < kFaces; ++i) {
      M simple = hn::And(hn::Ge(a[i], at_end), hn::Ge(d[i], at_start));
      if (i < kFaces - 1) {  // the top is a plane
        const V slope0 = hn::Add(hn::Mul(turn_[i], e.along), hn::Mul(rise_[i], e.r0));
        const V slope1 = hn::Add(hn::Mul(turn_[i], along1), hn::Mul(rise_[i], e.r1));
        simple = hn::And(simple, hn::Or(hn::Ge(slope0, hn::Zero(kFloats)), hn::Le(slope1, hn::Zero(kFloats))));
      }
      is_at_an_end = hn::Or(is_at_an_end, simple);
    }
    if (!hn::AllTrue(kFloats, is_at_an_end)) least = FindLeast(x, y, z, e, a, d);
    return hn::IfThenElse(hn::Le(hn::Min(e.z0, e.z1), ceiling_), hn::Neg(least), far_);
  }

 private:
  static constexpr int kFaces = 3;

  /// Radius and height of a point relative to the tool at the end (0) and the start (1) of the step, and the point's
  /// coordinate along the part of the way that is across the axis.
  struct Ends {
    V r0, z0, r1, z1, along;
  };
  HWY_INLINE Ends FindEnds(V x, V y, V z) const {
    Ends e;
    e.r0 = Length(x, y);
    e.z0 = z;
    e.r1 = Length(hn::Sub(x, hn::Mul(length_, back_x_)), hn::Sub(y, hn::Mul(length_, back_y_)));
    e.z1 = hn::Sub(z, hn::Mul(length_, back_z_));
    e.along = hn::Mul(hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_)), per_across_);
    return e;
  }
  /// Returns the least value over the step of the largest of the faces' distances, which at its end are `a` and at its
  /// start `d`.
  HWY_INLINE V FindLeast(V x, V y, V z, const Ends& e, const V (&a)[kFaces], const V (&d)[kFaces]) const {
    V least = Splat(-1e30f);
    for (int i = 0; i < kFaces; ++i) least = hn::Max(least, hn::Min(a[i], d[i]));
    for (int i = 0; i < kFaces; ++i) {
      for (int j = i + 1; j < kFaces; ++j) {
        const V rise_i = hn::Sub(d[i], a[i]);
        const V rise_j = hn::Sub(d[j], a[j]);
        const V at = hn::Div(hn::Sub(a[j], a[i]), hn::Sub(rise_i, rise_j));
        const M cross = hn::And(hn::Lt(hn::Mul(rise_i, rise_j), hn::Zero(kFloats)),
                                hn::And(hn::Gt(at, hn::Zero(kFloats)), hn::Lt(at, Splat(1))));
        least = hn::IfThenElse(cross, hn::Max(least, hn::Add(a[i], hn::Mul(at, rise_i))), least);
      }
    }
    // The top is a plane: its distance is least at an end.
    const V clear = Length(hn::Sub(x, hn::Mul(e.along, hn::Mul(back_x_, per_across_))),
                           hn::Sub(y, hn::Mul(e.along, hn::Mul(back_y_, per_across_))));
    for (int i = 0; i < kFaces - 1; ++i) {
      const V t = Clamp(hn::Mul(hn::Add(e.along, hn::Mul(clear, at_least_[i])), per_across_));
      least = hn::Min(least, LargestAt(x, y, z, t));
    }
    return least;
  }
  HWY_INLINE V Clamp(V t) const { return hn::Min(hn::Max(t, hn::Zero(kFloats)), length_); }
  HWY_INLINE V LargestAt(V x, V y, V z, V t) const {
    const V radius = Length(hn::Sub(x, hn::Mul(t, back_x_)), hn::Sub(y, hn::Mul(t, back_y_)));
    const V height = hn::Sub(z, hn::Mul(t, back_z_));
    return hn::Max(hn::Max(Distance(0, radius, height), Distance(1, radius, height)), Distance(2, radius, height));
  }
  HWY_INLINE V Distance(int face, V radius, V z) const {
    return hn::Sub(hn::Add(hn::Mul(r_[face], radius), hn::Mul(z_[face], z)), offset_[face]);
  }

  V back_x_;
  V back_y_;
  V back_z_;
  V length_;
  V per_across_;
  V r_[kFaces];
  V z_[kFaces];
  V offset_[kFaces];
  V at_least_[kFaces];
  V turn_[kFaces];  // the slope of a face's distance along the step is (turn * along + rise * radius) / radius
  V rise_[kFaces];
  V way_across_;
  V extent_[kFaces];  // half of a row's extent across the face, at most
  V outer_;
  V inner_;
  V reach_;  // length of the step, with the error of rounding
  V row_xy_;
  V row_z_;
  V ceiling_;
  V far_;
  V beyond_;
  V deep_;
  V still_;
  V bend_;  // (row_xy + length) * length
  bool new_only_;
};

template <>
struct SweepOf<FissureBur> {
  using Type = RoundSweep;
};
template <>
struct SweepOf<TwistDrill> {
  using Type = RoundSweep;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#endif
