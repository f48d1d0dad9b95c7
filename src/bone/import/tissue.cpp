#include "bone/import/tissue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "bone/import/components.h"
#include "bone/import/depth.h"
#include "bone/material/region_table.h"
#include "bone/material/segment_regions.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr double kSmallestEnamel_mm3 = 15;  // specks of metal or noise are smaller
constexpr std::size_t kAtlasPoints = 20000;
constexpr int kLastCortexRegion = 31;
constexpr int kToothRim = 2;  // voxels around a tooth: its own border, and beyond it

struct Stride {
  std::array<std::size_t, 3> of;
  explicit Stride(const Volume& v)
      : of{1, static_cast<std::size_t>(v.size[0]), static_cast<std::size_t>(v.size[0]) * v.size[1]} {}
  Vec3 Split(std::size_t v) const { return {v % of[1], v % of[2] / of[1], v / of[2]}; }
};

// Calls visit(neighbour, axis) for the up to six voxels that share a face with v.
template <typename Visit>
void ForFaceNeighbours(const Volume& lattice, const Stride& stride, std::size_t v, Visit&& visit) {
  const std::array<int, 3> at = {static_cast<int>(v % stride.of[1]),
                                 static_cast<int>(v / stride.of[1] % lattice.size[1]),
                                 static_cast<int>(v / stride.of[2])};
  for (int a = 0; a < 3; ++a) {
    if (at[a] > 0) visit(v - stride.of[a], a);
    if (at[a] + 1 < lattice.size[a]) visit(v + stride.of[a], a);
  }
}

// Continues teeth, metal and lesions into voxels of no segment, within reach: each gets those of the nearest voxel of a
// segment. The surface of a CT may lie outside the segments; otherwise it would have a skin of bone there.
MaskSamples SpreadOutward(const MaskSamples& mask, const Volume& lattice) {
  MaskSamples spread = mask;
  const auto count = mask.wanted.size();
  const Stride stride(lattice);
  constexpr auto kNoSegment = std::numeric_limits<std::uint32_t>::max();  // more than the voxels that kerf reads
  std::vector<std::uint32_t> nearest(count, kNoSegment);
  for (std::size_t v = 0; v < count; ++v) {
    const bool is_in_segment = mask.wanted[v] != 0 || mask.undecided[v] != 0 || mask.other[v] != 0;
    if (is_in_segment) nearest[v] = static_cast<std::uint32_t>(v);
  }
  std::vector<std::size_t> front;
  for (std::size_t v = 0; v < count; ++v) {
    bool at_border = false;
    if (nearest[v] == kNoSegment) continue;
    ForFaceNeighbours(lattice, stride, v, [&](std::size_t w, int) { at_border |= nearest[w] == kNoSegment; });
    if (at_border) front.push_back(v);
  }
  const auto distance_mm = [&](std::size_t a, std::size_t b) {
    return glm::length(lattice.spacing_mm * (stride.Split(a) - stride.Split(b)));
  };
  while (!front.empty()) {
    std::vector<std::size_t> next;
    for (const std::size_t v : front) {
      ForFaceNeighbours(lattice, stride, v, [&](std::size_t w, int) {
        const double new_mm = distance_mm(nearest[v], w);
        if (new_mm > mask.reach_mm || (nearest[w] != kNoSegment && distance_mm(nearest[w], w) <= new_mm)) return;
        nearest[w] = nearest[v];
        next.push_back(w);
      });
    }
    front = std::move(next);
  }
  for (std::size_t v = 0; v < count; ++v) {
    if (nearest[v] == kNoSegment || nearest[v] == v) continue;
    for (const auto fractions : {&MaskSamples::tooth, &MaskSamples::metal, &MaskSamples::lesion}) {
      if (!(mask.*fractions).empty()) (spread.*fractions)[v] = (mask.*fractions)[nearest[v]];
    }
    if (!mask.number.empty()) spread.number[v] = mask.number[nearest[v]];
  }
  return spread;
}

// Returns the bone that is not metal, which is as bright as enamel.
std::vector<std::uint8_t> WithoutMetal(std::vector<std::uint8_t> bone, const std::vector<float>& metal) {
  for (std::size_t v = 0; v < metal.size(); ++v) {
    if (metal[v] >= 0.5F) bone[v] = 0;
  }
  return bone;
}

// Returns 1 for the voxels of teeth and those nearest to them; empty if there is no enamel.
std::vector<std::uint8_t> FindToothVoxels(const Volume& lattice, const std::vector<std::uint8_t>& bone,
                                          const TissueOptions& options) {
  const std::vector<std::int16_t>& hu = lattice.hu;
  const Components lumps =
      FindComponents(lattice, [&](std::size_t v) { return bone[v] != 0 && hu[v] >= options.tooth_hu; });
  const Stride stride(lattice);
  // Dentin: voxels reachable from enamel through bright voxels; distances in mm.
  std::vector<float> distance_mm(bone.size(), -1);
  std::vector<std::size_t> front;
  for (std::size_t v = 0; v < bone.size(); ++v) {
    const std::int32_t label = lumps.labels[v];
    if (label == 0 || lumps.list[label - 1].volume_mm3 < kSmallestEnamel_mm3) continue;
    distance_mm[v] = 0;
    front.push_back(v);
  }
  if (front.empty()) return {};
  while (!front.empty()) {
    std::vector<std::size_t> next;
    for (const std::size_t v : front) {
      ForFaceNeighbours(lattice, stride, v, [&](std::size_t w, int axis) {
        const float new_mm = distance_mm[v] + static_cast<float>(lattice.spacing_mm[axis]);
        if (bone[w] == 0 || hu[w] < options.tooth_body_hu || static_cast<double>(new_mm) > options.tooth_reach_mm)
          return;
        if (distance_mm[w] >= 0 && distance_mm[w] <= new_mm) return;
        distance_mm[w] = new_mm;
        next.push_back(w);
      });
    }
    front = std::move(next);
  }
  // HU at the border of a tooth are lowered by its surroundings: voxels with low HU are assigned to the nearest bright
  // ones, tooth or bone.
  constexpr std::uint8_t kTooth = 1;
  constexpr std::uint8_t kOther = 2;
  std::vector<std::uint8_t> owner(bone.size(), 0);
  for (std::size_t v = 0; v < bone.size(); ++v) {
    if (distance_mm[v] >= 0)
      owner[v] = kTooth;
    else if (bone[v] != 0 && hu[v] >= options.tooth_body_hu)
      owner[v] = kOther;
    if (owner[v] != 0) front.push_back(v);
  }
  for (int ring = 0; ring < kToothRim; ++ring) {
    std::vector<std::size_t> next;
    for (const std::size_t v : front) {
      ForFaceNeighbours(lattice, stride, v, [&](std::size_t w, int) {
        if (owner[w] != 0) return;
        owner[w] = owner[v];
        next.push_back(w);
      });
    }
    front = std::move(next);
  }
  for (std::uint8_t& own : owner) own = own == kTooth ? 1 : 0;
  return owner;
}

// Clears the voxels that are no bone. Returns the volume of the others.
double KeepBone(const Volume& lattice, const std::vector<std::uint8_t>& bone, std::vector<std::uint8_t>& voxels) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < voxels.size(); ++v) count += voxels[v] &= bone[v];
  return static_cast<double>(count) * lattice.CalcVoxelVolume();
}

}  // namespace

double CalcToothVolume(const Volume& lattice, const std::vector<std::uint8_t>& bone, const TissueOptions& options) {
  std::vector<std::uint8_t> tooth = FindToothVoxels(lattice, bone, options);
  return KeepBone(lattice, bone, tooth);
}

ToothLevel FindToothLevel(const Volume& lattice, const std::vector<std::uint8_t>& bone, TissueOptions options,
                          double most_mm3) {
  constexpr double kStep_HU = 100, kSteady = 0.6;  // of the volume, from step to step
  const auto at = [&](double hu) {
    options.tooth_hu = hu;
    return ToothLevel{hu, CalcToothVolume(lattice, bone, options)};
  };
  ToothLevel level = at(options.tooth_hu);
  while (level.mm3 > 0) {
    const ToothLevel next = at(level.hu + kStep_HU);
    if (level.mm3 <= most_mm3 && next.mm3 >= kSteady * level.mm3) break;
    level = next;
  }
  return level;
}

TissueMap::TissueMap(const Volume& lattice, const std::vector<std::uint8_t>& solid,
                     const std::vector<std::uint8_t>& bone, const SplineField* hu, bool use_atlas,
                     const TissueOptions& options, const MaskSamples* mask, const LatticeMap* hu_map)
    : lattice_(lattice), map_(lattice), hu_map_(hu_map != nullptr ? *hu_map : map_), options_(options), hu_(hu) {
  MaskSamples named;
  if (mask != nullptr) {
    const bool spreads = !mask->tooth.empty() || !mask->metal.empty() || !mask->lesion.empty();
    named = spreads ? SpreadOutward(*mask, lattice) : *mask;
  }
  const auto take = [&](std::vector<float> MaskSamples::*fractions) {
    if ((named.*fractions).empty()) return std::unique_ptr<SplineField>();
    return std::make_unique<SplineField>(lattice.size, std::move(named.*fractions), true);
  };
  if (!named.tooth.empty()) {
    TakeTeeth(named.tooth, solid);
    number_ = std::move(named.number);
  } else if (!lattice_.hu.empty()) {
    FindTeeth(WithoutMetal(bone, named.metal));
  }
  canal_ = take(&MaskSamples::canal);
  metal_ = take(&MaskSamples::metal);
  lesion_ = take(&MaskSamples::lesion);
  MeasureDepth(solid);
  if (use_atlas) {
    std::vector<Vec3> points_W;
    std::size_t count = 0;
    for (const std::uint8_t s : solid) count += s;
    const std::size_t every = std::max<std::size_t>(1, count / kAtlasPoints);
    std::size_t n = 0;
    for (int k = 0; k < lattice.size[2]; ++k) {
      for (int j = 0; j < lattice.size[1]; ++j) {
        for (int i = 0; i < lattice.size[0]; ++i) {
          const std::size_t v = lattice.Index(i, j, k);
          if (solid[v] == 0 || (!tooth_voxels_.empty() && tooth_voxels_[v] != 0)) continue;
          if (n++ % every == 0) points_W.push_back(lattice.WorldFromVoxel({i, j, k}));
        }
      }
    }
    atlas_ = std::make_unique<MandibleAtlas>(points_W, options_.up_W);
  }
  lattice_.hu.clear();
  lattice_.hu.shrink_to_fit();
}

void TissueMap::MeasureDepth(const std::vector<std::uint8_t>& solid) {
  depth_mm_ = std::make_unique<SplineField>(lattice_.size, CalcDepth(lattice_, solid), false);
}

void TissueMap::TakeTeeth(const std::vector<float>& tooth, const std::vector<std::uint8_t>& bone) {
  tooth_voxels_.assign(bone.size(), 0);
  for (std::size_t v = 0; v < bone.size(); ++v) {
    if (bone[v] == 0 || tooth[v] < 0.5F) continue;
    tooth_voxels_[v] = 1;
    tooth_mm3_ += lattice_.CalcVoxelVolume();
  }
  tooth_ = std::make_unique<SplineField>(lattice_.size, tooth, false);
}

void TissueMap::FindTeeth(const std::vector<std::uint8_t>& bone) {
  std::vector<std::uint8_t> tooth = FindToothVoxels(lattice_, bone, options_);
  if (tooth.empty()) return;
  tooth_ = std::make_unique<SplineField>(lattice_.size, std::vector<float>(tooth.begin(), tooth.end()), false);
  tooth_mm3_ = KeepBone(lattice_, bone, tooth);
  tooth_voxels_ = std::move(tooth);
}

/// Returns the region of the numbered tooth that has the most of the voxels around a point, weighted by their nearness.
int TissueMap::FindToothRegion(const Vec3& p_V) const {
  if (number_.empty()) return kToothRegion;
  const Vec3 first = glm::floor(p_V);
  std::array<double, 256> weights{};
  int best = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at = first + Vec3(corner & 1, corner >> 1 & 1, corner >> 2);
    const std::array<int, 3> ijk{static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)};
    if (!lattice_.Contains(ijk)) continue;
    const std::uint8_t number = number_[lattice_.Index(ijk[0], ijk[1], ijk[2])];
    if (number == 0) continue;
    const Vec3 weight = Vec3(1) - glm::abs(at - p_V);
    weights[number] += weight.x * weight.y * weight.z;
    if (best == 0 || weights[number] > weights[static_cast<std::size_t>(best)]) best = number;
  }
  return best == 0 ? kToothRegion : ToothRegion(best);
}

template <typename ValueOf>
int TissueMap::ChooseRegion(const Vec3& p_W, ValueOf&& value_of) const {
  if (metal_ && value_of(*metal_) > 0.5) return kMetalRegion;
  if (tooth_ && value_of(*tooth_) > 0.5) return FindToothRegion(map_.VoxelFromWorld(p_W));
  if (canal_ && value_of(*canal_) > 0.5) return kCanalRegion;
  if (lesion_ && value_of(*lesion_) > 0.5) return kLesionRegion;
  const bool shell = value_of(*depth_mm_) < options_.shell_mm;
  if (!shell && (hu_ == nullptr || value_of(*hu_) < options_.cortical_hu)) return kCancellousRegion;
  return atlas_ ? atlas_->RegionAt(p_W) : kPlainCortexRegion;
}

int TissueMap::RegionAt(const Vec3& p_W) const {
  const Vec3 p_V = map_.VoxelFromWorld(p_W);
  return ChooseRegion(
      p_W, [&](const SplineField& field) { return field.At(&field == hu_ ? hu_map_.VoxelFromWorld(p_W) : p_V); });
}

void TissueMap::FindRegions(const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) const {
  if (!map_.HasPositions(leaf.voxel_mm) || !hu_map_.HasPositions(leaf.voxel_mm)) {
    for (int n = 0; n < kLeafVoxels; ++n) {
      if (wanted[n]) ids[n] = RegionAt(leaf.CalcPosition(n));
    }
    return;
  }
  // Each field is computed for the whole leaf when its value is first asked for.
  constexpr std::size_t kFields = 6;
  std::array<const SplineField*, kFields> fields{};
  std::array<std::array<double, kLeafVoxels>, kFields> values;
  std::size_t count = 0;
  const LatticePositions at_V = map_.CalcPositions(leaf), hu_at_V = hu_map_.CalcPositions(leaf);
  for (int n = 0; n < kLeafVoxels; ++n) {
    if (!wanted[n]) continue;
    ids[n] = ChooseRegion(leaf.CalcPosition(n), [&](const SplineField& field) {
      const auto place =
          static_cast<std::size_t>(std::find(fields.begin(), fields.begin() + count, &field) - fields.begin());
      if (place == count) {
        fields[count] = &field;
        field.AtLattice(&field == hu_ ? hu_at_V : at_V, values[count++]);
      }
      return values[place][n];
    });
  }
}

MaterialTable MakePlainTable() {
  MaterialTable table;
  Region cortex;
  cortex.id = TissueMap::kPlainCortexRegion;
  cortex.name = "cortical bone";
  cortex.tissue = Tissue::kCortical;
  cortex.E_MPa = 19100;
  cortex.nu = 0.30;
  cortex.source = "Estimate: mean E of the four measured regions of the mandible; no atlas was laid on this bone";
  table.Add(cortex);
  table.Add(DefaultMandibleTable().At(kCancellousRegion));
  table.Add(DefaultMandibleTable().At(kToothRegion));
  return table;
}

void CheckTable(const MaterialTable& table, bool use_atlas, const std::string& name) {
  std::string missing;
  for (int id = 1; id <= kToothRegion; ++id) {
    if (!use_atlas && id > TissueMap::kPlainCortexRegion && id <= kLastCortexRegion) continue;
    if (!table.Contains(id)) missing += (missing.empty() ? "" : ", ") + std::to_string(id);
  }
  if (!missing.empty()) {
    throw Error(fmt::format(
        "{}: the table lacks region {}, which the import uses ({}; {} is cancellous bone, {} tooth)", name, missing,
        use_atlas ? "1 to 31 are the cortex" : "1 is all cortex", kCancellousRegion, kToothRegion));
  }
}

}  // namespace kerf
