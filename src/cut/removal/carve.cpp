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

/// Returns the occupancy, clamp(1/2 - phi/h, 0, 1).
HWY_INLINE V Fraction(V phi, V per_voxel) {
  const V fraction = hn::Sub(Splat(0.5f), hn::Mul(phi, per_voxel));
  return hn::Min(hn::Max(fraction, hn::Zero(kFloats)), Splat(1));
}

/// Returns the value of each lane's row: `rows[row]` for the lower eight voxels, `rows[row + 1]` for the upper.
HWY_INLINE V OfRows(const float* rows, int row, int part) {
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  if constexpr (kLanes == 2 * kRow) {
    return hn::IfThenElse(hn::FirstN(kFloats, kRow), Splat(rows[row]), Splat(rows[row + 1]));
  } else {
    return Splat(rows[row + part / kRow]);
  }
}

template <typename Swept, bool kHasWhole>
CarveLoss Carve(const CarveStep& s, const std::array<float, 3>& corner, const CarvedLeaf& leaf) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
  constexpr int kPair = 2 * kRow;
  const Swept swept(s, corner);
  // Positions of the first voxels of the rows.
  using Row = hn::CappedTag<float, kRow>;
  constexpr Row kRowTag;
  alignas(64) float rows[3][kRow * kRow];
  for (int axis = 0; axis < 3; ++axis) {
    for (int x = 0; x < kRow; ++x) {
      const float base = corner[static_cast<std::size_t>(axis)] + static_cast<float>(x) * s.grid[0][axis];
      for (int y = 0; y < kRow; y += static_cast<int>(hn::MaxLanes(kRowTag))) {
        hn::Store(hn::Add(hn::Set(kRowTag, base), hn::Load(kRowTag, s.across[axis] + y)), kRowTag,
                  rows[axis] + kRow * x + y);
      }
    }
  }
  // First, select the rows by their middles.
  std::uint64_t active = 0;
  const V middle_x = Splat(kHalfRow * s.grid[2][0]);
  const V middle_y = Splat(kHalfRow * s.grid[2][1]);
  const V middle_z = Splat(kHalfRow * s.grid[2][2]);
  for (int row = 0; row < kRow * kRow; row += kLanes) {
    const M may = swept.MayChange(hn::Add(hn::Load(kFloats, rows[0] + row), middle_x),
                                  hn::Add(hn::Load(kFloats, rows[1] + row), middle_y),
                                  hn::Add(hn::Load(kFloats, rows[2] + row), middle_z));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(kFloats, may, bits);
    active |= static_cast<std::uint64_t>(bits[0] | bits[1] << 8) << row;
  }
  // Then compute their voxels.
  CarveLoss loss;
  loss.rows = std::popcount(active);
  alignas(64) float lost[kPair] = {};
  const V band = Splat(s.band);
  const V per_voxel = Splat(1 / s.voxel);
  // Veltkamp's splitting keeps the upper bits of a significand, rounded to nearest.
  const bool rounds = s.precision_bits < 24;
  const V splitter = Splat(static_cast<float>(1 << (24 - s.precision_bits)) + 1);
  std::uint64_t pairs = (active | active >> 1) & 0x5555555555555555u;
  for (; pairs != 0; pairs &= pairs - 1) {
    const int row = std::countr_zero(pairs);
    const auto of_pair = static_cast<unsigned>(active >> row) & 3u;
    for (int part = 0; part < kPair; part += kLanes) {
      if (kLanes <= kRow && !(of_pair >> (part / kRow) & 1u)) continue;
      float* HWY_RESTRICT voxels = leaf.cut + kRow * row + part;
      const V old = hn::LoadU(kFloats, voxels);
      M is_final = hn::Ge(old, band);
      V whole = old;
      if constexpr (kHasWhole) {
        whole = hn::LoadU(kFloats, leaf.whole + kRow * row + part);
        is_final = hn::Or(is_final, hn::Ge(whole, band));
      }
      if (hn::AllTrue(kFloats, is_final)) continue;
      V depth = swept.Depth(hn::Add(OfRows(rows[0], row, part), hn::Load(kFloats, s.along[0] + part)),
                            hn::Add(OfRows(rows[1], row, part), hn::Load(kFloats, s.along[1] + part)),
                            hn::Add(OfRows(rows[2], row, part), hn::Load(kFloats, s.along[2] + part)), old);
      if (s.whole_voxels) {
        depth = hn::Mul(hn::Add(hn::Floor(hn::Mul(depth, per_voxel)), Splat(0.5f)), Splat(s.voxel));
      }
      if (rounds) {
        const V split = hn::Mul(depth, splitter);
        depth = hn::Sub(split, hn::Sub(split, depth));
      }
      const V now = hn::Min(depth, band);
      M grown = hn::Gt(now, old);
      if constexpr (kLanes == kPair) {
        // A row that is not selected stays unchanged, as it does where rows are computed one by one.
        static constexpr std::uint8_t kLanesOf[4][8] = {{0, 0}, {0xff, 0}, {0, 0xff}, {0xff, 0xff}};
        grown = hn::And(grown, hn::LoadMaskBits(kFloats, kLanesOf[of_pair]));
      }
      if constexpr (kHasWhole) grown = hn::AndNot(is_final, grown);
      const V cut = hn::IfThenElse(grown, now, old);
      hn::StoreU(cut, kFloats, voxels);
      loss.changed += static_cast<int>(hn::CountTrue(kFloats, grown));
      V less;
      if constexpr (kHasWhole) {
        const V phi = hn::Max(whole, cut);
        if (leaf.phi != nullptr) hn::StoreU(phi, kFloats, leaf.phi + kRow * row + part);
        less = hn::Sub(Fraction(hn::Max(whole, old), per_voxel), Fraction(phi, per_voxel));
      } else {
        less = hn::Sub(Fraction(old, per_voxel), Fraction(cut, per_voxel));
      }
      hn::Store(hn::Add(hn::Load(kFloats, lost + part), less), kFloats, lost + part);
    }
  }
  for (const float part : lost) loss.voxels += static_cast<double>(part);
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
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kFloats));
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
      found |= static_cast<std::uint64_t>(bits[0] | bits[1] << 8) << (i - first);
    }
    if (count - first < 64) found &= (std::uint64_t{1} << (count - first)) - 1;
    near[first / 64] = found;
  }
}

template <std::size_t... kKinds>
CarveLoss CarveAny(const CarveStep& step, const std::array<float, 3>& corner, const CarvedLeaf& leaf,
                   std::index_sequence<kKinds...>) {
  CarveLoss loss;
  const auto carve = [&]<typename Swept>() {
    loss = leaf.whole == nullptr ? Carve<Swept, false>(step, corner, leaf) : Carve<Swept, true>(step, corner, leaf);
    return true;
  };
  (void)((step.kind == kKinds &&
          carve.template operator()<typename SweepOf<std::variant_alternative_t<kKinds, Tool>>::Type>()) ||
         ...);
  return loss;
}
CarveLoss CarveAll(const CarveStep& step, const std::array<float, 3>& corner, const CarvedLeaf& leaf) {
  return CarveAny(step, corner, leaf, std::make_index_sequence<std::variant_size_v<Tool>>());
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
  constexpr float kHalfRow = 3.5f;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 8; ++i) across[axis][i] = static_cast<float>(i) * grid[1][axis];
    for (int i = 0; i < 16; ++i) along[axis][i] = static_cast<float>(i % 8) * grid[2][axis];
  }
  row_mm = kHalfRow * std::sqrt(grid[2][0] * grid[2][0] + grid[2][1] * grid[2][1]);
  // The curvature of a distance is at most 1 / distance. This is used only where the distance is at least half a
  // radius.
  bend_mm = 0.5f * radius > 2 * row_mm ? 0.5f * row_mm * row_mm / (0.5f * radius - row_mm) : row_mm;
  const float along_row = back[0] * grid[2][0] + back[1] * grid[2][1] + back[2] * grid[2][2];
  behind_mm = length + rounding + kHalfRow * std::abs(along_row);
  const float across_axis = std::sqrt(back[0] * back[0] + back[1] * back[1]);
  const bool is_across = across_axis > 1e-6f;
  per_across = is_across ? 1 / across_axis : 0;
  way_across = is_across ? across_axis * length : 0;
  for (Face& face : faces) {
    const float steep = is_across ? face.z * back[2] / (across_axis * std::max(face.r, 1e-6f)) : 0;
    face.turn = is_across ? -face.r * across_axis : 0;
    face.rise = -face.z * back[2];
    face.at_least = std::abs(steep) < 1 ? steep / std::sqrt(1 - steep * steep) : std::copysign(1e6f, steep);
    face.extent = face.r * row_mm + std::abs(face.z) * std::abs(kHalfRow * grid[2][2]);
  }
}

CarveLoss CarveLeaf(const CarveStep& step, const std::array<float, 3>& corner_T, const CarvedLeaf& leaf) {
  return HWY_DYNAMIC_DISPATCH(CarveAll)(step, corner_T, leaf);
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
