// This file is compiled once for each vector instruction set. It uses no fused multiply-add, so the results are
// bit-identical at every width.
#include "bone/mesh/near_points.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bone/mesh/near_points.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using V = hn::Vec<Floats>;
constexpr Floats kFloats;

struct Vec3V {
  V x, y, z;
};

HWY_INLINE V Dot(const Vec3f& a, const Vec3V& b) {
  return hn::Add(hn::Add(hn::Mul(hn::Set(kFloats, a.x), b.x), hn::Mul(hn::Set(kFloats, a.y), b.y)),
                 hn::Mul(hn::Set(kFloats, a.z), b.z));
}

/// `values`: the rows of NearPoints.
void FindNearest(const PlaceTriangle* triangles, std::size_t triangle_count, float limit2, float min_cosine,
                 std::size_t stride, float* values) {
  const V far = hn::Set(kFloats, NearPoints::kFar);
  const V one = hn::Set(kFloats, 1.0F);
  const V zero = hn::Zero(kFloats);
  for (std::size_t i = 0; i < stride; i += hn::Lanes(kFloats)) {
    const auto row = [&](std::size_t n) { return values + n * stride + i; };
    const auto load = [&](std::size_t n) { return hn::LoadU(kFloats, row(n)); };
    const Vec3V p{load(0), load(1), load(2)};
    const Vec3V n{load(3), load(4), load(5)};
    V best2 = far;
    V best = hn::Set(kFloats, -1.0F);
    V least_cosine = one;
    for (std::size_t k = 0; k < triangle_count; ++k) {
      const PlaceTriangle& t = triangles[k];
      const V off = Dot(t.normal, p);
      const V cosine = Dot(t.normal, n);
      const V in_opposite = hn::Add(Dot(t.in_opposite, p), hn::Set(kFloats, t.to_opposite));
      const V in = hn::Min(hn::Min(Dot(t.in_from, p), Dot(t.in_to, p)),
                           hn::Min(in_opposite, hn::Sub(cosine, hn::Set(kFloats, min_cosine))));
      const V off2 = hn::IfThenElse(hn::Ge(in, zero), hn::Mul(off, off), far);
      least_cosine = hn::Min(least_cosine, hn::IfThenElse(hn::Lt(off2, hn::Set(kFloats, limit2)), cosine, one));
      best = hn::IfThenElse(hn::Lt(off2, best2), hn::Set(kFloats, static_cast<float>(k)), best);
      best2 = hn::Min(best2, off2);
    }
    hn::StoreU(best2, kFloats, row(6));
    hn::StoreU(best, kFloats, row(7));
    hn::StoreU(least_cosine, kFloats, row(8));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(FindNearest);

constexpr std::size_t kLanes = 16;  // at most, of a vector

float CalcDistance2ToSide(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  const Vec3f ab = b - a;
  const float along = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-30F), 0.0F, 1.0F);
  const Vec3f off = p - (a + along * ab);
  return glm::dot(off, off);
}

}  // namespace

PlaceTriangle::PlaceTriangle(const Vec3f& from_corner, const Vec3f& to_corner)
    : from(from_corner), to(to_corner), normal(glm::cross(from, to)) {
  to_opposite = glm::length(normal);
  if (to_opposite > 0) normal /= to_opposite;
  in_from = glm::cross(normal, from);
  in_to = glm::cross(to, normal);
  in_opposite = glm::cross(normal, to - from);
}

float PlaceTriangle::CalcDistance2BeyondSides(const Vec3f& p) const {
  float distance2 = NearPoints::kFar;
  if (glm::dot(p, in_from) < 0) distance2 = std::min(distance2, CalcDistance2ToSide(p, Vec3f(0), from));
  if (glm::dot(p, in_to) < 0) distance2 = std::min(distance2, CalcDistance2ToSide(p, to, Vec3f(0)));
  if (glm::dot(p, in_opposite) + to_opposite < 0) distance2 = std::min(distance2, CalcDistance2ToSide(p, from, to));
  return distance2;
}

void NearPoints::Resize(std::size_t size) {
  size_ = size;
  stride_ = (size + kLanes - 1) / kLanes * kLanes;
  if (values_.size() < kRows * stride_) values_.resize(2 * kRows * stride_);
}

void NearPoints::FindNearest(std::span<const PlaceTriangle> triangles, float limit2, float min_cosine) {
  HWY_DYNAMIC_DISPATCH(FindNearest)(triangles.data(), triangles.size(), limit2, min_cosine, stride_, values_.data());
}

std::span<const std::size_t> NearPoints::FindClosest(Vec3f p) {
  const float* const x = Row(0);
  const float* const y = Row(1);
  const float* const z = Row(2);
  float* const all2 = Row(9);
  for (std::size_t i = 0; i < stride_; ++i) {
    const Vec3f off = Vec3f(x[i], y[i], z[i]) - p;
    all2[i] = glm::dot(off, off);
  }
  std::array<float, 3> distance2;
  distance2.fill(kFar);
  for (std::size_t i = 0; i < size_; ++i) {
    const float d2 = all2[i];
    if (d2 >= distance2[2]) continue;
    std::size_t place = 2;
    for (; place > 0 && d2 < distance2[place - 1]; --place) {
      distance2[place] = distance2[place - 1];
      closest_[place] = closest_[place - 1];
    }
    distance2[place] = d2;
    closest_[place] = i;
  }
  return {closest_.data(), std::min<std::size_t>(size_, 3)};
}

}  // namespace kerf
#endif  // HWY_ONCE
