// Sweep of a tool of the form kRound over one step. Compiled once for each vector instruction set.
#if defined(KERF_CUT_TOOL_ROUND_SWEEP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
#undef KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
#else
#define KERF_CUT_TOOL_ROUND_SWEEP_INL_H_
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

/// Sweep of a convex solid of revolution along a straight line. The solid is where the largest of its faces' distances
/// is at most 0. Each of these is a convex function of the way. The least value of the largest of them is that of one
/// face at an end of the way or at its own minimum, which has a closed form, or of two where they cross. Between the
/// ends, the crossing treats the distance from the axis as linear, an error of at most length^2 / (8 radius); the
/// cutter keeps that small.
class RoundSweep {
 public:
  RoundSweep(const CarveStep& s, const std::array<float, 3>& corner)
      : back_x_(Splat(s.back[0])),
        back_y_(Splat(s.back[1])),
        back_z_(Splat(s.back[2])),
        length_(Splat(s.length)),
        ceiling_(Splat(s.ceiling)),
        far_(Splat(-2 * s.band)),
        beyond_(Splat(s.band + s.length + s.rounding)),
        deep_(Splat(-s.band)),
        way_(Splat(s.length + s.rounding)),
        apart_(Splat(2 * (s.length + s.rounding))),
        half_y_{Splat(s.half_y[0]), Splat(s.half_y[1])},
        half_z_{Splat(s.half_z[0]), Splat(s.half_z[1])},
        brick_xy_(Splat(s.brick_mm)),
        brick_z_(Splat(s.brick_z_mm)),
        least_radius_(Splat(1e-6f * s.voxel)),
        new_only_(s.new_only),
        exact_(!s.whole_voxels && s.precision_bits == 24) {
    per_across_ = Splat(s.per_across);
    way_across_ = Splat(s.way_across);
    int selected[kFaces];
    SelectFaces(s, corner, selected);
    for (int i = 0; i < count_; ++i) {
      const CarveStep::Face& face = s.faces[selected[i]];
      r_[i] = Splat(face.r);
      z_[i] = Splat(face.z);
      offset_[i] = Splat(face.offset);
      turn_[i] = Splat(face.turn);
      rise_[i] = Splat(face.rise);
      at_least_[i] = Splat(face.at_least);
      extent_[i] = Splat(face.extent);
      along_y_[i] = Splat(face.z * s.half_y[2]);
      along_z_[i] = Splat(face.z * s.half_z[2]);
    }
    outer_ = Splat(s.band + s.rounding);
    inner_ = Splat(-(s.band + s.flank_slack + s.rounding));
    reach_ = Splat(s.length + 2 * s.rounding);
    still_ = Splat(s.flank_slack + s.rounding);
    bend_ = Splat((s.brick_mm + s.length) * s.length);
    climb_ = Splat(s.rounding / std::max(s.length, 1e-30f));
  }

  HWY_INLINE M MayChange(V x, V y, V z) const {
    return count_ == 1 ? MayChangeBy<1>(x, y, z) : count_ == 2 ? MayChangeBy<2>(x, y, z) : MayChangeBy<3>(x, y, z);
  }
  HWY_INLINE V Depth(V x, V y, V z, V old) const {
    return count_ == 1 ? DepthBy<1>(x, y, z, old) : count_ == 2 ? DepthBy<2>(x, y, z, old) : DepthBy<3>(x, y, z, old);
  }

 private:
  static constexpr int kFaces = 3;

  /// Selects the faces that may be less than a band deep somewhere in the leaf during the step, or were it where the
  /// previous step ended (flank_slack). The others have no effect, because nothing is cut deeper than that.
  void SelectFaces(const CarveStep& s, const std::array<float, 3>& corner, int (&selected)[kFaces]) {
    const std::array<float, 3> middle = s.Middle(corner);
    const float radius = std::sqrt(middle[0] * middle[0] + middle[1] * middle[1]);
    const float reach = 1.7321f * kHalfLeaf * s.voxel + s.band + s.length + s.flank_slack + 4 * s.rounding;
    for (int i = 0; i < kFaces; ++i) {
      const CarveStep::Face& face = s.faces[i];
      if (face.r * radius + face.z * middle[2] - face.offset + reach > 0) selected[count_++] = i;
    }
    if (count_ == 0) selected[count_++] = 0;  // all of the leaf is deep inside
  }

  template <int kCount>
  HWY_INLINE M MayChangeBy(V x, V y, V z) const {
    const Ends e = FindEnds(x, y, z);
    const V z_low = hn::Min(e.z0, e.z1);
    const V z_high = hn::Max(e.z0, e.z1);
    V least = Splat(-1e30f);
    V at_start = Splat(-1e30f);  // largest distance in the brick where the step starts
    // Radius per half brick along y and z, at the middle of the brick.
    const V radius = hn::Max(e.r0, least_radius_);
    const V slant_y = hn::Div(Dot(x, y, half_y_[0], half_y_[1]), radius);
    const V slant_z = hn::Div(Dot(x, y, half_z_[0], half_z_[1]), radius);
    // The distance from the axis changes by at most the way. The radial parts of the motion differ between the voxels
    // of a brick by at most bend_ / clear.
    const V r_least = hn::Max(hn::Mul(Splat(0.5f), hn::Sub(hn::Add(e.r0, e.r1), reach_)), hn::Zero(kFloats));
    const V clear = hn::Sub(r_least, brick_xy_);
    V a[kCount];
    V d[kCount];
    for (int i = 0; i < kCount; ++i) {
      // A face's distance is convex, so in the brick it lies above its tangent at the middle.
      a[i] = Distance(i, e.r0, e.z0);
      const V extent = hn::Add(hn::Abs(hn::Add(hn::Mul(r_[i], slant_y), along_y_[i])),
                               hn::Abs(hn::Add(hn::Mul(r_[i], slant_z), along_z_[i])));
      least = hn::Max(least, hn::Sub(a[i], extent));
      d[i] = Distance(i, e.r1, e.z1);
      at_start = hn::Max(at_start, hn::Add(d[i], extent_[i]));
    }
    least = hn::Sub(least, way_);
    // A face that is nowhere in the brick the largest has no effect. `least` is lower than needed by the rounding.
    M advances = hn::Le(clear, hn::Add(brick_xy_, length_));
    for (int i = 0; i < kCount; ++i) {
      const M forward = hn::Lt(hn::Mul(hn::Sub(hn::Sub(a[i], d[i]), still_), clear), hn::Mul(r_[i], bend_));
      const M counts = hn::Ge(hn::Add(hn::Max(a[i], d[i]), extent_[i]), least);
      advances = hn::Or(advances, hn::And(forward, counts));
    }
    M may = hn::And(hn::Le(least, outer_), hn::Le(hn::Sub(z_low, brick_z_), ceiling_));
    if (new_only_) {
      const M is_new = hn::Or(hn::And(advances, hn::Ge(at_start, inner_)), hn::Gt(hn::Add(z_high, brick_z_), ceiling_));
      may = hn::And(may, is_new);
    }
    return may;
  }

  template <int kCount>
  HWY_INLINE V DepthBy(V x, V y, V z, V old) const {
    Ends e;
    FindEnd(x, y, z, e);
    V a[kCount];
    for (int i = 0; i < kCount; ++i) a[i] = Distance(i, e.r0, e.z0);
    const V at_end = Largest(a);
    if (exact_) {
      // Nothing grows where it is further than the way from growing, and nothing exceeds the band.
      M is_end = hn::Or(hn::Ge(hn::Add(at_end, old), way_), hn::Or(hn::Le(at_end, deep_), hn::Ge(old, hn::Neg(deep_))));
      is_end = hn::Or(is_end, IsLeastAtEnd(e, a));
      if (hn::AllTrue(kFloats, is_end)) return BelowCeiling(e, hn::Neg(at_end));
    }
    FindStart(x, y, e);
    V d[kCount];
    for (int i = 0; i < kCount; ++i) d[i] = Distance(i, e.r1, e.z1);
    const V at_start = Largest(d);
    V least = hn::Min(at_end, at_start);
    // The least value is that of an end if the same face is the largest at both ends and has no minimum in between.
    // Values that change nothing because they are outside the band may be too large by the length of the step.
    M is_at_an_end = hn::Or(hn::Ge(least, beyond_), hn::Le(least, deep_));
    const V along1 = hn::Sub(e.along, way_across_);
    for (int i = 0; i < kCount; ++i) {
      M simple = hn::And(hn::Ge(a[i], at_end), hn::Ge(d[i], at_start));
      const V slope0 = hn::Add(hn::Mul(turn_[i], e.along), hn::Mul(rise_[i], e.r0));
      const V slope1 = hn::Add(hn::Mul(turn_[i], along1), hn::Mul(rise_[i], e.r1));
      simple = hn::And(simple, hn::Or(hn::Ge(slope0, hn::Zero(kFloats)), hn::Le(slope1, hn::Zero(kFloats))));
      is_at_an_end = hn::Or(is_at_an_end, simple);
    }
    // A voxel's result must not depend on which others are in its vector.
    if (!hn::AllTrue(kFloats, is_at_an_end)) {
      least = hn::IfThenElse(is_at_an_end, least, FindLeast(x, y, z, e, a, d));
    }
    return BelowCeiling(e, hn::Neg(least));
  }

  /// Radius and height of a point relative to the tool at the end (0) and the start (1) of the step, and the point's
  /// coordinate along the part of the way that is across the axis.
  struct Ends {
    V r0, z0, r1, z1, along;
  };
  HWY_INLINE void FindEnd(V x, V y, V z, Ends& e) const {
    e.r0 = Length(x, y);
    e.z0 = z;
    e.z1 = hn::Sub(z, hn::Mul(length_, back_z_));
    e.along = hn::Mul(hn::Add(hn::Mul(x, back_x_), hn::Mul(y, back_y_)), per_across_);
  }
  HWY_INLINE void FindStart(V x, V y, Ends& e) const {
    e.r1 = Length(hn::Sub(x, hn::Mul(length_, back_x_)), hn::Sub(y, hn::Mul(length_, back_y_)));
  }
  HWY_INLINE Ends FindEnds(V x, V y, V z) const {
    Ends e;
    FindEnd(x, y, z, e);
    FindStart(x, y, e);
    return e;
  }
  /// Returns where the tool certainly comes nearer until the end of the step: where one face is the largest by more
  /// than the way can change, and its distance falls by more than the rounding. On the axis, where both are 0, it does
  /// not tell.
  template <int kCount>
  HWY_INLINE M IsLeastAtEnd(const Ends& e, const V (&a)[kCount]) const {
    const V climb = hn::Mul(climb_, e.r0);
    M is_least = hn::Lt(climb, climb);
    for (int i = 0; i < kCount; ++i) {
      M nearer = hn::Gt(hn::Add(hn::Mul(turn_[i], e.along), hn::Mul(rise_[i], e.r0)), climb);
      for (int j = 0; j < kCount; ++j) {
        if (j != i) nearer = hn::And(nearer, hn::Ge(a[i], hn::Add(a[j], apart_)));
      }
      is_least = hn::Or(is_least, nearer);
    }
    return is_least;
  }
  HWY_INLINE V BelowCeiling(const Ends& e, V depth) const {
    return hn::IfThenElse(hn::Le(hn::Min(e.z0, e.z1), ceiling_), depth, far_);
  }
  /// Returns the least value over the step of the largest of the faces' distances, which at its end are `a` and at its
  /// start `d`.
  template <int kCount>
  HWY_INLINE V FindLeast(V x, V y, V z, const Ends& e, const V (&a)[kCount], const V (&d)[kCount]) const {
    V least = Splat(-1e30f);
    for (int i = 0; i < kCount; ++i) least = hn::Max(least, hn::Min(a[i], d[i]));
    for (int i = 0; i < kCount; ++i) {
      for (int j = i + 1; j < kCount; ++j) {
        const V rise_i = hn::Sub(d[i], a[i]);
        const V rise_j = hn::Sub(d[j], a[j]);
        const V at = hn::Div(hn::Sub(a[j], a[i]), hn::Sub(rise_i, rise_j));
        const M cross = hn::And(hn::Lt(hn::Mul(rise_i, rise_j), hn::Zero(kFloats)),
                                hn::And(hn::Gt(at, hn::Zero(kFloats)), hn::Lt(at, Splat(1))));
        least = hn::IfThenElse(cross, hn::Max(least, hn::Add(a[i], hn::Mul(at, rise_i))), least);
      }
    }
    const V clear = Length(hn::Sub(x, hn::Mul(e.along, hn::Mul(back_x_, per_across_))),
                           hn::Sub(y, hn::Mul(e.along, hn::Mul(back_y_, per_across_))));
    for (int i = 0; i < kCount; ++i) {
      const V t = Clamp(hn::Mul(hn::Add(e.along, hn::Mul(clear, at_least_[i])), per_across_));
      least = hn::Min(least, LargestAt<kCount>(x, y, z, t));
    }
    return least;
  }
  HWY_INLINE V Clamp(V t) const { return hn::Min(hn::Max(t, hn::Zero(kFloats)), length_); }
  template <int kCount>
  HWY_INLINE V LargestAt(V x, V y, V z, V t) const {
    const V radius = Length(hn::Sub(x, hn::Mul(t, back_x_)), hn::Sub(y, hn::Mul(t, back_y_)));
    const V height = hn::Sub(z, hn::Mul(t, back_z_));
    V a[kCount];
    for (int i = 0; i < kCount; ++i) a[i] = Distance(i, radius, height);
    return Largest(a);
  }
  template <int kCount>
  HWY_INLINE static V Largest(const V (&distances)[kCount]) {
    V largest = distances[0];
    for (int i = 1; i < kCount; ++i) largest = hn::Max(largest, distances[i]);
    return largest;
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
  V extent_[kFaces];   // half of a brick's extent across the face, at most
  V along_y_[kFaces];  // change of a face's distance by the height, per half brick along y
  V along_z_[kFaces];  // and along z
  V outer_;
  V inner_;
  V reach_;  // length of the step, with twice the error of rounding
  V ceiling_;
  V far_;
  V beyond_;
  V deep_;
  V way_;    // length of the step, with the error of rounding
  V apart_;  // twice the same
  V climb_;  // slope over the step that exceeds the rounding
  V half_y_[2];
  V half_z_[2];
  V brick_xy_;
  V brick_z_;
  V least_radius_;
  V still_;
  V bend_;  // (brick_xy + length) * length
  bool new_only_;
  bool exact_;     // phi keeps all bits of the distance
  int count_ = 0;  // faces that matter in the leaf
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
