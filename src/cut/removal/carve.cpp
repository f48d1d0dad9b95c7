// This file is compiled once for each vector instruction set. It uses no fused multiply-add, which rounds once where
// two operations round twice and which not every set has. Additions, multiplications, divisions and square roots round
// the same everywhere.
#include "cut/removal/carve.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "kerf/error.h"
#include "kerf/tool.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/removal/carve.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come first.
#include <hwy/highway.h>

#include "cut/tool/sweeps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf {
namespace HWY_NAMESPACE {
namespace {

constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
constexpr int kHalf = 4;  // voxels of a row of a brick
constexpr int kParts = 2 * kHalf / kLanes;
using Half = hn::CappedTag<float, kHalf>;
constexpr Half kHalfTag;

/// Coordinates of the first voxel of a leaf at each x, tool frame.
struct Starts {
  Starts(const CarveStep& s, const std::array<float, 3>& corner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int x = 0; x < 8; x += kLanes) {
        hn::Store(hn::Add(Splat(corner[axis]), hn::Load(kFloats, s.steps_x[axis] + x)), kFloats, of[axis] + x);
      }
    }
  }
  alignas(64) float of[3][8];
};

/// A brick of a leaf; its voxels are computed in kParts parts.
struct Brick {
  explicit Brick(std::uint64_t bricks) : number(static_cast<std::size_t>(std::countr_zero(bricks))) {}

  /// Returns a coordinate of the voxels.
  HWY_INLINE V Locate(const CarveStep& s, const Starts& starts, int axis, int part) const {
    return hn::Add(Splat(starts.of[axis][number >> 3]), hn::Load(kFloats, s.voxels[number & 7][axis] + kLanes * part));
  }
  /// Read and write the values of a leaf.
  template <typename Tag>
  HWY_INLINE hn::Vec<Tag> Load(Tag tag, const float* leaf, int part) const {
#if HWY_TARGET != HWY_SCALAR
    if constexpr (hn::MaxLanes(tag) == 2 * kHalf) {
      return hn::Combine(tag, hn::LoadU(kHalfTag, leaf + Voxel(1)), hn::LoadU(kHalfTag, leaf + Voxel(0)));
    }
#endif
    return hn::LoadU(tag, leaf + VoxelOf(part));
  }
  template <typename Vec>
  HWY_INLINE void Store(Vec values, float* leaf, int part) const {
#if HWY_TARGET != HWY_SCALAR
    if constexpr (hn::MaxLanes(hn::DFromV<Vec>()) == 2 * kHalf) {
      hn::StoreU(hn::LowerHalf(kHalfTag, values), kHalfTag, leaf + Voxel(0));
      hn::StoreU(hn::UpperHalf(kHalfTag, values), kHalfTag, leaf + Voxel(1));
      return;
    }
#endif
    hn::StoreU(values, kFloats, leaf + VoxelOf(part));
  }

  std::size_t number;  // 8 x + 2 (y / 2) + z / 4

 private:
  /// Returns the first voxel of a row of the brick, and that of a part.
  std::size_t Voxel(std::size_t row) const {
    return 16 * (number >> 1) + 4 * (number & 1) + 8 * row;
  }
  std::size_t VoxelOf(int part) const {
    const int voxel = kLanes * part;
    return Voxel(static_cast<std::size_t>(voxel / kHalf)) + static_cast<std::size_t>(voxel % kHalf);
  }
};

/// Returns the bricks that the step may change, a bit each.
template <typename Swept>
std::uint64_t Find(const CarveStep& s, const std::array<float, 3>& corner) {
  const Swept swept(s, corner);
  const Starts starts(s, corner);
  std::uint64_t found = 0;
  for (int brick = 0; brick < 64; brick += kLanes) {
    const auto middle = [&](int axis) {
      return hn::Add(Splat(starts.of[axis][brick >> 3]), hn::Load(kFloats, s.middles[axis] + (brick & 7)));
    };
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kFloats, swept.MayChange(middle(0), middle(1), middle(2)), bits);
    found |= std::uint64_t{bits[0]} << brick;
  }
  return found;
}

/// kAllBits: phi is written as it is computed.
template <typename Swept, bool kHasWhole, bool kAllBits>
CarveLoss Carve(const CarveStep& s, const std::array<float, 3>& corner, std::uint64_t bricks, const CarvedLeaf& leaf) {
  const Swept swept(s, corner);
  const Starts starts(s, corner);
  constexpr hn::RebindToSigned<Floats> kCounts;
  auto changed = hn::Zero(kCounts);
  V lost[kParts];
  for (V& sum : lost) sum = hn::Zero(kFloats);
  const V band = Splat(s.band);
  const V voxel = Splat(s.voxel);
  const V per_voxel = Splat(1 / s.voxel);
  const V half_voxel = Splat(0.5f * s.voxel);
  // Veltkamp's splitting keeps the upper bits of a significand, rounded to nearest.
  const bool rounds = s.precision_bits < 24;
  const V splitter = Splat(static_cast<float>(1 << (24 - s.precision_bits)) + 1);
  for (; bricks != 0; bricks &= bricks - 1) {
    const Brick brick(bricks);
    for (int part = 0; part < kParts; ++part) {
      const V old = brick.Load(kFloats, leaf.cut, part);
      V depth = swept.Depth(brick.Locate(s, starts, 0, part), brick.Locate(s, starts, 1, part),
                            brick.Locate(s, starts, 2, part), old);
      if (!kAllBits && s.whole_voxels) {
        depth = hn::Mul(hn::Add(hn::Floor(hn::Mul(depth, per_voxel)), Splat(0.5f)), voxel);
      }
      if (!kAllBits && rounds) {
        const V split = hn::Mul(depth, splitter);
        depth = hn::Sub(split, hn::Sub(split, depth));
      }
      const V now = hn::Min(depth, band);
      M grown = hn::Gt(now, old);
      V phi_before = old;
      if constexpr (kHasWhole) {
        const V whole = brick.Load(kFloats, leaf.whole, part);
        grown = hn::And(grown, hn::Lt(whole, band));
        phi_before = hn::Max(whole, old);
      }
      const V cut = hn::IfThenElse(grown, now, old);
      brick.Store(cut, leaf.cut, part);
      changed = hn::Sub(changed, hn::VecFromMask(kCounts, hn::RebindMask(kCounts, grown)));
      V phi = cut;
      if constexpr (kHasWhole) {
        phi = hn::Max(phi_before, cut);
        if (leaf.phi != nullptr) brick.Store(phi, leaf.phi, part);
      }
      // The occupancy is 1/2 less phi, in voxels, but at least 0 and at most 1.
      const auto clamp = [&](V value) HWY_ATTR { return hn::Min(hn::Max(value, hn::Neg(half_voxel)), half_voxel); };
      const V rise = hn::Sub(clamp(phi), clamp(phi_before));
      lost[part] = hn::Add(lost[part], hn::Mul(rise, per_voxel));
    }
  }
  CarveLoss loss;
  for (const V& sum : lost) {
    alignas(64) float lanes[kLanes];
    hn::Store(sum, kFloats, lanes);
    for (const float lane : lanes) loss.voxels += static_cast<double>(lane);
  }
  alignas(64) std::int32_t counts[kLanes];
  hn::Store(changed, kCounts, counts);
  for (const std::int32_t count : counts) loss.changed += count;
  return loss;
}

/// Returns the leaves that may have a voxel near the sides of a blade's outline.
HWY_INLINE M NearSides(const LeafCull& c, V x, V y) {
  V outward = Splat(-1e30f);
  V edge = outward;
  for (int i = 0; i < c.sides; ++i) {
    const CarveStep::Side& side = c.side[i];
    const V out =
        hn::Add(hn::Mul(hn::Sub(x, Splat(side.x)), Splat(side.nx)), hn::Mul(hn::Sub(y, Splat(side.y)), Splat(side.ny)));
    outward = hn::Max(outward, out);
    if (side.cuts) edge = hn::Max(edge, out);
  }
  const V reach = Splat(c.half_diagonal);
  M may = hn::Le(hn::Sub(outward, reach), Splat(c.side_out));
  may = hn::And(may, hn::Ge(hn::Add(outward, reach), Splat(-c.side_in)));
  return hn::And(may, hn::Ge(hn::Add(edge, reach), Splat(-c.side_depth)));
}

/// Sets a bit in `near` for each leaf that may have a voxel in the zone.
void Cull(const LeafCull& c, const float* x, const float* y, const float* z, int count, std::uint64_t* near) {
  const V outer = Splat(c.outer);
  const V inner = Splat(c.inner);
  const V half_leaf2 = Splat(c.half_leaf2);
  const auto project = [](const float(&e)[3], V px, V py, V pz) {
    return hn::Add(hn::Add(hn::Mul(Splat(e[0]), px), hn::Mul(Splat(e[1]), py)), hn::Mul(Splat(e[2]), pz));
  };
  for (int first = 0; first < count; first += 64) {
    std::uint64_t found = 0;
    for (int i = first; i < first + 64 && i < count; i += kLanes) {
      const V px = hn::Load(kFloats, x + i);
      const V py = hn::Load(kFloats, y + i);
      const V pz = hn::Load(kFloats, z + i);
      V qx = hn::Add(project(c.axes[0], px, py, pz), Splat(c.origin[0]));
      V qy = hn::Add(project(c.axes[1], px, py, pz), Splat(c.origin[1]));
      V qz = hn::Add(project(c.axes[2], px, py, pz), Splat(c.origin[2]));
      M may = hn::Le(project(c.back, qx, qy, qz), Splat(c.behind));
      may = hn::And(may, hn::Le(hn::Abs(qz), Splat(c.axial)));
      if (c.receded < LeafCull::kNone) {
        const V across = hn::Add(hn::Mul(Splat(c.across[0]), qx), hn::Mul(Splat(c.across[1]), qy));
        const M between = hn::And(hn::Ge(qz, Splat(c.receded_low)), hn::Le(qz, Splat(c.receded_high)));
        may = hn::AndNot(hn::And(hn::Gt(across, Splat(c.receded)), between), may);
      }
      if (c.sides > 0) may = hn::And(may, NearSides(c, qx, qy));
      qz = hn::Mul(qz, Splat(c.axial_counts));
      const V distance = hn::Max(hn::Sqrt(hn::Add(hn::Add(Square(qx), Square(qy)), Square(qz))), Splat(c.min_distance));
      V extent = hn::Zero(kFloats);
      for (const auto& half_edge : c.half_edges) extent = hn::Add(extent, hn::Abs(project(half_edge, qx, qy, qz)));
      extent = hn::Div(extent, distance);
      may = hn::And(may, hn::Le(hn::Sub(distance, extent), outer));
      // A voxel at offset s from the middle has a distance of at most distance + s.e + |s|^2 / (2 distance).
      const V furthest = hn::Add(hn::Add(distance, extent), hn::Div(half_leaf2, hn::Add(distance, distance)));
      may = hn::And(may, hn::Ge(furthest, inner));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kFloats, may, bits);
      found |= std::uint64_t{bits[0]} << (i - first);
    }
    if (count - first < 64) found &= (std::uint64_t{1} << (count - first)) - 1;
    near[first / 64] = found;
  }
}

/// Returns visit.operator()<S>(), where S is the sweep of the step's kind of tool.
template <typename Visit, std::size_t... kKinds>
auto VisitSweep(std::size_t kind, Visit&& visit, std::index_sequence<kKinds...>) {
  decltype(visit.template operator()<DiscSweep>()) result{};
  const auto set = [&]<typename Swept>() {
    result = visit.template operator()<Swept>();
    return true;
  };
  (void)((kind == kKinds &&
          set.template operator()<typename SweepOf<std::variant_alternative_t<kKinds, Tool>>::Type>()) ||
         ...);
  return result;
}
constexpr std::make_index_sequence<std::variant_size_v<Tool>> kAllKinds;

template <bool kHasWhole, bool kAllBits>
CarveLoss CarveKind(const CarveStep& step, const std::array<float, 3>& corner, std::uint64_t bricks,
                    const CarvedLeaf& leaf) {
  const auto carve = [&]<typename Swept>() { return Carve<Swept, kHasWhole, kAllBits>(step, corner, bricks, leaf); };
  return VisitSweep(step.kind, carve, kAllKinds);
}
CarveLoss CarveAll(const CarveStep& step, const std::array<float, 3>& corner, std::uint64_t bricks,
                   const CarvedLeaf& leaf) {
  const bool all_bits = !step.whole_voxels && step.precision_bits == 24;
  if (leaf.whole == nullptr) {
    return all_bits ? CarveKind<false, true>(step, corner, bricks, leaf)
                    : CarveKind<false, false>(step, corner, bricks, leaf);
  }
  return all_bits ? CarveKind<true, true>(step, corner, bricks, leaf)
                  : CarveKind<true, false>(step, corner, bricks, leaf);
}
std::uint64_t FindAll(const CarveStep& step, const std::array<float, 3>& corner) {
  const auto find = [&]<typename Swept>() { return Find<Swept>(step, corner); };
  return VisitSweep(step.kind, find, kAllKinds);
}
void CullLeaves(const LeafCull& cull, const float* x, const float* y, const float* z, int count, std::uint64_t* near) {
  Cull(cull, x, y, z, count, near);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf {
namespace {

HWY_EXPORT(CarveAll);
HWY_EXPORT(FindAll);
HWY_EXPORT(CullLeaves);

std::string NameOf(std::int64_t target) {
  std::string name = hwy::TargetName(target);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

/// Returns a bit for each instruction set; the lowest bit is the widest set.
std::int64_t AllTargets() {
  hwy::SetSupportedTargetsForTest(0);
  return hwy::SupportedTargets() & HWY_TARGETS;
}

/// Set by SetVectorTarget(); 0: the best.
std::int64_t chosen_target = 0;

}  // namespace

void CarveStep::Prepare() {
  for (int axis = 0; axis < 3; ++axis) {
    const float along_y = grid[1][axis];
    const float along_z = grid[2][axis];
    half_y[axis] = 0.5f * along_y;
    half_z[axis] = 1.5f * along_z;
    for (int i = 0; i < 8; ++i) {
      steps_x[axis][i] = static_cast<float>(i) * grid[0][axis];
      const int first_y = i / 2 * 2;
      const int first_z = i % 2 * 4;
      for (int v = 0; v < 8; ++v) {
        voxels[i][axis][v] =
            static_cast<float>(first_y + v / 4) * along_y + static_cast<float>(first_z + v % 4) * along_z;
      }
      middles[axis][i] = voxels[i][axis][0] + half_y[axis] + half_z[axis];
    }
  }
  brick_mm = std::max(std::hypot(half_z[0] + half_y[0], half_z[1] + half_y[1]),
                      std::hypot(half_z[0] - half_y[0], half_z[1] - half_y[1]));
  brick_z_mm = std::abs(half_y[2]) + std::abs(half_z[2]);
  // The curvature of a distance is at most 1 / distance. This is used only where the distance is at least half a
  // radius.
  bend_mm = 0.5f * radius > 2 * brick_mm ? 0.5f * brick_mm * brick_mm / (0.5f * radius - brick_mm) : brick_mm;
  const auto along = [this](const float(&e)[3]) { return back[0] * e[0] + back[1] * e[1] + back[2] * e[2]; };
  behind_mm = length + rounding + std::abs(along(half_y)) + std::abs(along(half_z));
  const float across_axis = std::sqrt(back[0] * back[0] + back[1] * back[1]);
  const bool is_across = across_axis > 1e-6f;
  per_across = is_across ? 1 / across_axis : 0;
  way_across = is_across ? across_axis * length : 0;
  for (Face& face : faces) {
    const float steep = is_across ? face.z * back[2] / (across_axis * std::max(face.r, 1e-6f)) : 0;
    face.turn = is_across ? -face.r * across_axis : 0;
    face.rise = -face.z * back[2];
    face.at_least = std::abs(steep) < 1 ? steep / std::sqrt(1 - steep * steep) : std::copysign(1e6f, steep);
    face.extent = face.r * brick_mm + std::abs(face.z) * brick_z_mm;
  }
}

CarveStep CarveStep::Widened(float slack) const {
  CarveStep wide = *this;
  // No direction; the way still bounds those of other steps.
  for (float& component : wide.back) component = 0;
  wide.length = slack;
  for (float* bound : {&wide.rounding, &wide.edge_depth, &wide.flank_slack}) *bound += slack;
  wide.Prepare();
  return wide;
}

CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, std::uint64_t bricks,
                    const CarvedLeaf& leaf) {
  return HWY_DYNAMIC_DISPATCH(CarveAll)(step, corner_T, bricks, leaf);
}

std::uint64_t FindBricks(const CarveStep& step, const std::array<float, 3>& corner_T) {
  return HWY_DYNAMIC_DISPATCH(FindAll)(step, corner_T);
}

void FindLeaves(const LeafCull& cull, const LeafMiddles& middles, int count, std::uint64_t* near) {
  HWY_DYNAMIC_DISPATCH(CullLeaves)(cull, middles.x, middles.y, middles.z, count, near);
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
