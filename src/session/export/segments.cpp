#include "session/export/segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <tuple>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "session/marks/region_parts.h"

namespace kerf {
namespace {

using Colour = std::array<std::uint8_t, 3>;

constexpr Colour kBone{241, 214, 145};
constexpr Colour kRemoved{213, 62, 40};
constexpr Colour kCanal{0, 114, 178};
constexpr Colour kTooth{250, 250, 240};
constexpr Colour kLesion{170, 60, 110};
constexpr Colour kMetal{126, 140, 158};
constexpr std::array<Colour, 6> kPieces{Colour{230, 159, 0}, {86, 180, 233},  {0, 158, 115},
                                        {240, 228, 66},      {204, 121, 167}, {153, 153, 153}};
constexpr std::size_t kMaxLabels = 250;  // of a layer
constexpr double kMaxOutside = 1e-3;     // of the bone's volume, outside the bone before the cut

/// Structures of a bone's regions, and their labels.
class Structures {
 public:
  Structures(const Bone& bone, int layer, std::vector<WrittenSegment>& segments) : bone_(bone) {
    const double mid_x_mm = bone.CalcBounds().centre().x;
    std::size_t label = 0;
    const auto add = [&](const std::string& name, const Colour& colour, const SegmentMeaning& meaning) {
      if (++label > kMaxLabels) throw Error(fmt::format("the bone has more than {} structures", kMaxLabels));
      segments.push_back(
          {.name = name, .colour = colour, .layer = layer, .label = static_cast<int>(label), .meaning = meaning});
    };
    for (const auto& [tissue, colour, role] : {std::tuple{Tissue::kCanal, kCanal, SegmentRole::kCanal},
                                               {Tissue::kTooth, kTooth, SegmentRole::kTooth},
                                               {Tissue::kLesion, kLesion, SegmentRole::kLesion}}) {
      tissues_.push_back(
          {FindRegionsOf(bone, tissue), RegionParts(bone, tissue, mid_x_mm), static_cast<int>(label) + 1});
      for (const StructureResult& part : tissues_.back().parts.structures()) {
        add(FormatMessage(NameStructure(part)), colour, {.role = role, .fdi = part.fdi});
      }
    }
    // A table of materials has regions of metal also if the bone has none.
    metal_ = FindRegionsOf(bone, Tissue::kMetal);
    const std::map<int, double> region_mm3 = bone.CalcRegionVolumes();
    if (std::ranges::none_of(region_mm3, [this](const auto& r) { return r.second > 0 && IsMetal(r.first); })) return;
    add("metal", kMetal, {.role = SegmentRole::kMetal});
    metal_label_ = static_cast<int>(label);
  }

  /// Returns the label at a point in the bone; 0: none.
  int LabelAt(const Vec3& p_W) const {
    const int region = bone_.RegionAt(p_W);
    if (region <= 0 || region > 255) return 0;
    const auto id = static_cast<std::size_t>(region);
    if (metal_[id]) return metal_label_;
    for (const OfTissue& tissue : tissues_) {
      if (!tissue.regions[id]) continue;
      const int part = tissue.parts.FindPart(p_W);
      return part < 0 ? 0 : tissue.first_label + part;
    }
    return 0;
  }

 private:
  struct OfTissue {
    std::array<bool, 256> regions;
    RegionParts parts;
    int first_label;
  };
  bool IsMetal(int region) const { return region > 0 && region < 256 && metal_[static_cast<std::size_t>(region)]; }

  const Bone& bone_;
  std::vector<OfTissue> tissues_;
  std::array<bool, 256> metal_{};
  int metal_label_ = 0;
};

/// Sets the lattice for a bone with this box. The faces of its voxels, not their centres, are at multiples of their
/// size, where the faces of models and of labels lie: volumes then have no bias.
void PlaceLattice(const Box3& box_W, double voxel_mm, SegmentationWriting& writing) {
  writing.voxel_mm = voxel_mm;
  const Vec3 lower = glm::floor(box_W.lower / voxel_mm) - 0.5;
  const Vec3 upper = glm::ceil(box_W.upper / voxel_mm) + 0.5;
  writing.origin_W = voxel_mm * lower;
  for (int a = 0; a < 3; ++a) {
    writing.size[static_cast<std::size_t>(a)] = static_cast<int>(std::lround(upper[a] - lower[a])) + 1;
  }
}

/// Returns the fraction of the bone's volume that is outside another bone, at a million points of its box.
double CalcFractionOutside(const Bone& bone, const Bone& other) {
  constexpr int kPoints = 1'000'000;
  // Multiples of this vector, without whole parts, fill a cube evenly along every plane (R sequence of Roberts, 2018).
  constexpr Vec3 kEven{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const Box3 box_W = bone.CalcBounds();
  // Surfaces of one bone at different voxel sizes differ a little.
  const double slack_mm = bone.voxel_mm() == other.voxel_mm() ? 0 : 0.5 * std::max(bone.voxel_mm(), other.voxel_mm());
  const PhiSampler bone_phi(bone), other_phi(other);
  std::size_t inside = 0, outside = 0;
  for (int i = 1; i <= kPoints; ++i) {
    const Vec3 p_W = box_W.lower + box_W.size() * glm::fract(static_cast<double>(i) * kEven);
    if (bone_phi.Calc(p_W) >= 0) continue;
    ++inside;
    outside += other_phi.Calc(p_W) > slack_mm ? 1 : 0;
  }
  return inside == 0 ? 0 : static_cast<double>(outside) / static_cast<double>(inside);
}

}  // namespace

SegmentationWriting WriteSegments(const Bone& bone, const Bone* before, double voxel_mm, const std::string& path,
                                  const DicomStudy* study, const std::function<void(double)>& progress) {
  CheckRange("voxel_mm", voxel_mm, kSegmentVoxelRange_mm);
  const Bone& whole = before != nullptr ? *before : bone;
  if (whole.empty()) throw Error("there is no bone to write as a segmentation");
  if (before != nullptr && !bone.empty()) {
    if (const double outside = CalcFractionOutside(bone, *before); outside > kMaxOutside) {
      throw Error(fmt::format(
          "{:.1f} % of the bone is outside the bone before the cut; they are swapped, or of different bones",
          100 * outside));
    }
  }
  Pieces split = SplitPieces(bone, kMinSegment_mm3);
  if (before == nullptr && split.pieces.size() == 1) split.pieces.clear();
  if (split.pieces.size() >= kMaxLabels) {
    throw Error(fmt::format("the bone has {} pieces; a segmentation holds up to {}", split.pieces.size(), kMaxLabels));
  }

  enum Layer { kWhole, kParts, kStructures, kLayers };
  SegmentationWriting writing;
  writing.layers = kLayers;
  PlaceLattice(whole.CalcBounds(), voxel_mm, writing);
  writing.segments.push_back({.name = before != nullptr ? "bone before the cut" : "bone",
                              .colour = kBone,
                              .layer = kWhole,
                              .meaning = SegmentMeaning{.role = SegmentRole::kMandible}});
  for (std::size_t i = 0; i < split.pieces.size(); ++i) {
    writing.segments.push_back({.name = fmt::format("piece {}", i + 1),
                                .colour = kPieces[i % kPieces.size()],
                                .layer = kParts,
                                .label = static_cast<int>(i) + 1});
  }
  const auto removed_label = static_cast<std::uint8_t>(split.pieces.size() + 1);
  if (before != nullptr) {
    writing.segments.push_back({.name = "removed", .colour = kRemoved, .layer = kParts, .label = removed_label});
  }
  const Structures structures(whole, kStructures, writing.segments);

  const PhiSampler whole_phi(whole);
  const PhiSampler bone_phi(bone);
  std::vector<PhiSampler> pieces;
  pieces.reserve(split.pieces.size());
  for (const Bone& piece : split.pieces) pieces.emplace_back(piece);
  writing.fill = [&](int k, std::span<std::uint8_t> labels) {
    if (progress) progress(static_cast<double>(k) / writing.size[2]);
    for (std::size_t i = 0; i < labels.size() / kLayers; ++i) {
      const auto width = static_cast<std::size_t>(writing.size[0]);
      const Vec3 p_W = writing.origin_W + voxel_mm * Vec3(i % width, i / width, k);
      if (whole_phi.Calc(p_W) >= 0) continue;
      std::uint8_t* const at = &labels[i * kLayers];
      at[kWhole] = 1;
      at[kStructures] = static_cast<std::uint8_t>(structures.LabelAt(p_W));
      if (before != nullptr && bone_phi.Calc(p_W) >= 0) {
        at[kParts] = removed_label;
        continue;
      }
      for (std::size_t n = 0; n < pieces.size() && at[kParts] == 0; ++n) {
        if (pieces[n].Calc(p_W) < 0) at[kParts] = static_cast<std::uint8_t>(n + 1);
      }
    }
  };
  if (study == nullptr) {
    WriteSegmentation(writing, path);
  } else {
    WriteDicomSegmentation(writing, *study, path);
  }
  writing.fill = nullptr;
  return writing;
}

}  // namespace kerf
