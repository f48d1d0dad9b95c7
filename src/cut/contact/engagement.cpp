// This file is compiled once for each vector instruction set. It uses no fused multiply-add, so the results are
// bit-identical at every width.
#include "cut/contact/engagement.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/contact/engagement.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using D = hn::Vec<Doubles>;
constexpr Doubles kDoubles;

HWY_INLINE D Splat(double value) {
  return hn::Set(kDoubles, value);
}
HWY_INLINE D Clamp(D value, D low, D high) {
  return hn::Min(hn::Max(value, low), high);
}

/// A linear function of the place in the interval.
struct Line {
  D t_a, t_b, a, slope;

  Line(D start, D end, const double* at_start, const double* at_end)
      : t_a(start),
        t_b(end),
        a(hn::Load(kDoubles, at_start)),
        slope(hn::Div(hn::Sub(hn::Load(kDoubles, at_end), a), hn::Sub(end, start))) {}
  HWY_INLINE D At(D t) const { return hn::Add(a, hn::Mul(slope, hn::Sub(t, t_a))); }
  /// Returns the place with a value, between start and end; the start if the function is constant.
  HWY_INLINE D Where(D value) const {
    const D t = hn::Add(t_a, hn::Div(hn::Sub(value, a), slope));
    return hn::IfThenElse(hn::Eq(slope, hn::Zero(kDoubles)), t_a, Clamp(t, t_a, t_b));
  }
};

void Integrate(const EngagementDepths& depths, const IntervalParts& parts, double* of_start, double* of_end) {
  const D zero = hn::Zero(kDoubles);
  const D one = Splat(1);
  const D half = Splat(0.5);
  const D entry = Splat(depths.entry_mm);
  const D look_ahead = Splat(depths.look_ahead_mm);
  for (std::size_t i = 0; i < parts.size; i += hn::MaxLanes(kDoubles)) {
    const D t_a = hn::Load(kDoubles, parts.t_a + i);
    const D t_b = hn::Load(kDoubles, parts.t_b + i);
    const Line whole(t_a, t_b, parts.whole_a_mm + i, parts.whole_b_mm + i);
    const Line cut(t_a, t_b, parts.cut_a_mm + i, parts.cut_b_mm + i);
    const auto engagement = [&](D t) HWY_ATTR {
      const D entered = Clamp(hn::Sub(half, hn::Div(whole.At(t), entry)), zero, one);
      return hn::Mul(entered, Clamp(hn::Div(hn::Neg(cut.At(t)), look_ahead), zero, one));
    };
    // Between these places the engagement is a product of two linear functions.
    D ends[6] = {t_a,
                 whole.Where(hn::Mul(half, entry)),
                 whole.Where(hn::Mul(Splat(-0.5), entry)),
                 cut.Where(zero),
                 cut.Where(hn::Neg(look_ahead)),
                 t_b};
    constexpr int kSorted[5][2] = {{1, 2}, {3, 4}, {1, 3}, {2, 4}, {2, 3}};
    for (const auto& [low, high] : kSorted) {
      const D lower = hn::Min(ends[low], ends[high]);
      ends[high] = hn::Max(ends[low], ends[high]);
      ends[low] = lower;
    }
    D sum = zero;
    D sum_end = zero;
    D at_first = engagement(ends[0]);
    for (int k = 0; k < 5; ++k) {
      // Simpson's rule is exact for a product of three linear functions.
      const D middle = hn::Mul(half, hn::Add(ends[k], ends[k + 1]));
      const D at_middle = hn::Mul(Splat(4), engagement(middle));
      const D at_last = engagement(ends[k + 1]);
      const D sixth = hn::Div(hn::Sub(ends[k + 1], ends[k]), Splat(6));
      sum = hn::Add(sum, hn::Mul(sixth, hn::Add(hn::Add(at_first, at_middle), at_last)));
      const D moment =
          hn::Add(hn::Add(hn::Mul(at_first, ends[k]), hn::Mul(at_middle, middle)), hn::Mul(at_last, ends[k + 1]));
      sum_end = hn::Add(sum_end, hn::Mul(sixth, moment));
      at_first = at_last;
    }
    alignas(64) double start[hn::MaxLanes(kDoubles)];
    alignas(64) double end[hn::MaxLanes(kDoubles)];
    hn::Store(hn::Sub(sum, sum_end), kDoubles, start);
    hn::Store(sum_end, kDoubles, end);
    const std::size_t count = std::min(parts.size - i, hn::MaxLanes(kDoubles));
    std::copy_n(start, count, of_start + i);
    std::copy_n(end, count, of_end + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(Integrate);

}  // namespace

void IntegrateEngagement(const EngagementDepths& depths, const IntervalParts& parts, double* of_start, double* of_end) {
  HWY_DYNAMIC_DISPATCH(Integrate)(depths, parts, of_start, of_end);
}

}  // namespace kerf
#endif  // HWY_ONCE
