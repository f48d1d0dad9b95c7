// This file is compiled once for each vector instruction set. It uses no fused multiply-add, and sums lane by lane in a
// fixed order, so the results are bit-identical at every width.
#include "cut/effects/heat/kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/effects/heat/kernels.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::heat {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kSide>;  // a row of nodes, or a part of one
using Ints = hn::RebindToSigned<Floats>;
using V = hn::Vec<Floats>;
constexpr Floats kFloats;
constexpr Ints kInts;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));

HWY_INLINE V Splat(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE V Square(V a) {
  return hn::Mul(a, a);
}

/// Sums values over a block: in float along the rows of a layer, and in double from layer to layer.
class Sum {
 public:
  HWY_INLINE void Add(V values, int part) {
    hn::Store(hn::Add(hn::Load(kFloats, layer_ + part), values), kFloats, layer_ + part);
  }
  HWY_INLINE void EndLayer() {
    for (int z = 0; z < kSide; ++z) {
      sums_[z] += static_cast<double>(layer_[z]);
      layer_[z] = 0;
    }
  }
  double Total() const {
    double total = 0;
    for (const double sum : sums_) total += sum;
    return total;
  }

 private:
  alignas(64) float layer_[kSide] = {};
  double sums_[kSide] = {};
};

/// Maximum of each lane.
class LaneMax {
 public:
  explicit LaneMax(float first) { std::fill(lanes_, lanes_ + kSide, first); }
  HWY_INLINE void Add(V values, int part) {
    hn::Store(hn::Max(hn::Load(kFloats, lanes_ + part), values), kFloats, lanes_ + part);
  }
  float Total() const { return *std::max_element(lanes_, lanes_ + kSide); }

 private:
  alignas(64) float lanes_[kSide];
};

/// Returns the heat gained from a neighbour. Both cells compute the same product with opposite signs, so the exchange
/// is exact, bit for bit.
template <bool kAllBone>
HWY_INLINE V Gain(const float* theta, const float* fraction, V t, V f, int step) {
  const V difference = hn::Sub(hn::LoadU(kFloats, theta + step), t);
  if constexpr (kAllBone) return difference;
  return hn::Mul(hn::Min(f, hn::LoadU(kFloats, fraction + step)), difference);
}

template <bool kAllBone>
void ConductAll(const float* HWY_RESTRICT theta, const float* HWY_RESTRICT fraction, float conduction,
                float* HWY_RESTRICT after) {
  const V r = Splat(conduction);
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      for (int z = 0; z < kSide; z += kLanes) {
        const float* at = theta + PaddedAt(x, y, z);
        const float* f_at = fraction + PaddedAt(x, y, z);
        const V t = hn::LoadU(kFloats, at);
        const V f = hn::LoadU(kFloats, f_at);
        V gain = hn::Add(Gain<kAllBone>(at, f_at, t, f, -kLayer), Gain<kAllBone>(at, f_at, t, f, kLayer));
        gain = hn::Add(gain, Gain<kAllBone>(at, f_at, t, f, -kRow));
        gain = hn::Add(gain, Gain<kAllBone>(at, f_at, t, f, kRow));
        gain = hn::Add(gain, Gain<kAllBone>(at, f_at, t, f, -1));
        gain = hn::Add(gain, Gain<kAllBone>(at, f_at, t, f, 1));
        gain = hn::Mul(r, gain);
        if constexpr (!kAllBone) gain = hn::Div(gain, hn::Max(f, Splat(kMinFraction)));
        hn::StoreU(hn::Add(t, gain), kFloats, after + (x * kSide + y) * kSide + z);
      }
    }
  }
}

void ConductBlock(const PaddedNodes& theta, const PaddedNodes& fraction, bool all_bone, float conduction,
                  Nodes& after) {
  (all_bone ? ConductAll<true> : ConductAll<false>)(theta.data(), fraction.data(), conduction, after.data());
}

SurfaceLoss CoolBlock(const PaddedNodes& fraction, const Surface& s, Nodes& theta) {
  Sum to_air, to_coolant;
  const V one = Splat(1);
  alignas(64) float along_z[kSide], across_z[kSide];
  for (int z = 0; z < kSide; ++z) {
    along_z[z] = s.axis[2] * s.spacing_mm * static_cast<float>(z);
    across_z[z] = s.first_mm[2] + s.spacing_mm * static_cast<float>(z);
  }
  const V radius2 = Splat(s.radius_mm * s.radius_mm);
  const V half = Splat(s.half_mm);
  for (int x = 0; x < kSide; ++x) {
    const float rx = s.first_mm[0] + s.spacing_mm * static_cast<float>(x);
    for (int y = 0; y < kSide; ++y) {
      const float ry = s.first_mm[1] + s.spacing_mm * static_cast<float>(y);
      const V along_xy = Splat(s.axis[0] * rx + s.axis[1] * ry + s.axis[2] * s.first_mm[2]);
      const V across_xy = Splat(rx * rx + ry * ry);
      for (int z = 0; z < kSide; z += kLanes) {
        const float* at = fraction.data() + PaddedAt(x, y, z);
        const V f = hn::LoadU(kFloats, at);
        const auto slope = [&](int step) {
          const V smaller = hn::Min(hn::LoadU(kFloats, at - step), hn::LoadU(kFloats, at + step));
          return Square(hn::Sub(f, hn::Min(smaller, f)));
        };
        const V slope2 = hn::Add(hn::Add(slope(kLayer), slope(kRow)), slope(1));
        const V area = hn::Div(hn::Sqrt(slope2), hn::Max(f, Splat(kMinFraction)));
        float* row = theta.data() + (x * kSide + y) * kSide + z;
        const V before = hn::LoadU(kFloats, row);
        V after = hn::Div(before, hn::Add(one, hn::Mul(Splat(s.air), area)));
        V air = hn::Mul(f, hn::Sub(before, after));
        if (s.wet) {
          const V along = hn::Add(along_xy, hn::Load(kFloats, along_z + z));
          const V across2 = hn::Sub(hn::Add(across_xy, Square(hn::Load(kFloats, across_z + z))), Square(along));
          const auto is_wet = hn::And(hn::Le(hn::Abs(along), half), hn::Le(across2, radius2));
          const V rate = hn::Mul(Splat(s.coolant), area);
          const V cooled = hn::Div(hn::Add(before, hn::Mul(rate, Splat(s.coolant_K))), hn::Add(one, rate));
          to_coolant.Add(hn::IfThenElseZero(is_wet, hn::Mul(f, hn::Sub(before, cooled))), z);
          air = hn::IfThenZeroElse(is_wet, air);
          after = hn::IfThenElse(is_wet, cooled, after);
        }
        to_air.Add(air, z);
        hn::StoreU(after, kFloats, row);
      }
    }
    to_air.EndLayer();
    to_coolant.EndLayer();
  }
  return {to_air.Total(), to_coolant.Total()};
}

Perfused PerfuseBlock(const Nodes& fraction, float kept_fraction, const Nodes& before, Nodes& after) {
  Sum lost;
  constexpr float kFar = 1e30F;
  LaneMax hottest(-kFar), coldest(-kFar), was_hottest(-kFar);
  for (int row = 0; row < kNodes; row += kSide) {
    for (int z = 0; z < kSide; z += kLanes) {
      const V now = hn::LoadU(kFloats, after.data() + row + z);
      const V kept = hn::Mul(Splat(kept_fraction), now);
      lost.Add(hn::Mul(hn::LoadU(kFloats, fraction.data() + row + z), hn::Sub(now, kept)), z);
      hottest.Add(kept, z);
      coldest.Add(hn::Neg(kept), z);
      was_hottest.Add(hn::LoadU(kFloats, before.data() + row + z), z);
      hn::StoreU(kept, kFloats, after.data() + row + z);
    }
    if (row % (kSide * kSide) == kSide * kSide - kSide) lost.EndLayer();
  }
  return {lost.Total(), hottest.Total(), -coldest.Total(), was_hottest.Total()};
}

/// Returns 2^x with a relative error of 3e-7, for x from -126 to 126.
HWY_INLINE V CalcPowerOf2(V x) {
  const V to_whole = Splat(12582912.0F);  // 1.5 * 2^23: adding it rounds to whole numbers
  const V whole = hn::Sub(hn::Add(x, to_whole), to_whole);
  const V t = hn::Sub(x, whole);
  V fine = Splat(0.00015404F);
  for (const float factor : {0.00133336F, 0.00961813F, 0.05550411F, 0.24022651F, 0.69314718F, 1.0F}) {
    fine = hn::Add(Splat(factor), hn::Mul(t, fine));
  }
  const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(kInts, whole), hn::Set(kInts, 127)));
  return hn::Mul(fine, hn::BitCast(kFloats, exponent));
}

DoseFigures AddDoseToBlock(const DoseRule& rule, const Nodes& fraction, const Nodes& before, const Nodes& after,
                           Nodes& above_s, Nodes& dose_min) {
  LaneMax longest(0), max_dose(0);
  Sum past_time, past_dose;
  const V zero = hn::Zero(kFloats);
  const V frame_s = Splat(rule.frame_s);
  const V frame_min = Splat(rule.frame_s / 60);
  for (int row = 0; row < kNodes; row += kSide) {
    for (int z = 0; z < kSide; z += kLanes) {
      const int n = row + z;
      const V f = hn::LoadU(kFloats, fraction.data() + n);
      const V middle =
          hn::Mul(Splat(0.5F), hn::Add(hn::LoadU(kFloats, before.data() + n), hn::LoadU(kFloats, after.data() + n)));
      const V mean_K = hn::IfThenElse(hn::Gt(f, zero), middle, Splat(-1000));
      const V above = hn::Add(hn::LoadU(kFloats, above_s.data() + n),
                              hn::IfThenElseZero(hn::Ge(mean_K, Splat(rule.limit_K)), frame_s));
      const V over_K = hn::Min(hn::Max(hn::Sub(mean_K, Splat(rule.base_K)), Splat(-60)), Splat(rule.max_K));
      const V rate = CalcPowerOf2(hn::Min(over_K, hn::Add(over_K, over_K)));  // R = 1/2 above 43 C and 1/4 below
      const V dose = hn::Add(hn::LoadU(kFloats, dose_min.data() + n),
                             hn::IfThenElseZero(hn::Ge(mean_K, Splat(rule.from_K)), hn::Mul(frame_min, rate)));
      hn::StoreU(above, kFloats, above_s.data() + n);
      hn::StoreU(dose, kFloats, dose_min.data() + n);
      past_time.Add(hn::IfThenElseZero(hn::Ge(above, Splat(rule.limit_s)), f), z);
      past_dose.Add(hn::IfThenElseZero(hn::Gt(dose, Splat(rule.limit_dose_min)), f), z);
      longest.Add(above, z);
      max_dose.Add(dose, z);
    }
  }
  past_time.EndLayer();
  past_dose.EndLayer();
  return {longest.Total(), max_dose.Total(), past_time.Total(), past_dose.Total()};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::heat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::heat {
namespace {

HWY_EXPORT(ConductBlock);
HWY_EXPORT(CoolBlock);
HWY_EXPORT(PerfuseBlock);
HWY_EXPORT(AddDoseToBlock);

}  // namespace

void Conduct(const PaddedNodes& theta, const PaddedNodes& fraction, bool all_bone, float conduction, Nodes& after) {
  HWY_DYNAMIC_DISPATCH(ConductBlock)(theta, fraction, all_bone, conduction, after);
}
SurfaceLoss CoolSurface(const PaddedNodes& fraction, const Surface& surface, Nodes& theta) {
  return HWY_DYNAMIC_DISPATCH(CoolBlock)(fraction, surface, theta);
}
Perfused Perfuse(const Nodes& fraction, float kept_fraction, const Nodes& before, Nodes& after) {
  return HWY_DYNAMIC_DISPATCH(PerfuseBlock)(fraction, kept_fraction, before, after);
}
DoseFigures AddDose(const DoseRule& rule, const Nodes& fraction, const Nodes& before, const Nodes& after,
                    Nodes& above_s, Nodes& dose_min) {
  return HWY_DYNAMIC_DISPATCH(AddDoseToBlock)(rule, fraction, before, after, above_s, dose_min);
}

}  // namespace kerf::heat
#endif  // HWY_ONCE
