// Vectors of voxels, for the sweeps of the tools. Compiled once for each vector instruction set
// (cut/removal/carve.cpp).
#if defined(KERF_CUT_TOOL_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CUT_TOOL_VECTORS_INL_H_
#undef KERF_CUT_TOOL_VECTORS_INL_H_
#else
#define KERF_CUT_TOOL_VECTORS_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 8>;  // the voxels of a brick of a leaf, or a part of them
using V = hn::Vec<Floats>;
using M = hn::Mask<Floats>;
constexpr Floats kFloats;
constexpr float kHalfLeaf =
    3.5f;  // distance from the middle of a leaf to its outermost voxels along an axis, in voxels

HWY_INLINE V Splat(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE V Square(V a) {
  return hn::Mul(a, a);
}
HWY_INLINE V Dot(V ax, V ay, V bx, V by) {
  return hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by));
}
HWY_INLINE V Length(V x, V y) {
  return hn::Sqrt(hn::Add(Square(x), Square(y)));
}

/// The sweep of a kind of tool: SweepOf<T>::Type is made from a CarveStep and the position of a leaf's lowest voxel,
/// and has, for the positions of as many voxels of the leaf as a vector has lanes,
///   M MayChange(V x, V y, V z): the bricks with a voxel that the step may change, by the middles of the bricks;
///   V Depth(V x, V y, V z, V old): -distance to the swept space; where the tool does not cut, a value beyond the band.
///     `old`: their phi. Where it certainly is at least the result, the result may be less than -distance, and beyond
///     the band it may be too.
template <typename T>
struct SweepOf;

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#endif
