// A segmentation as the import uses it: which voxels are the wanted bone, and what they are made of.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

enum class MaskTissue : std::int16_t {
  kBackground,      // nothing, or soft tissue
  kBone,            // of the wanted bone
  kTooth,           // in the wanted bone
  kCanal,           // of the nerve, in the wanted bone
  kOther,           // other bone, and teeth in it
  kUndecided,       // the CT decides whether it belongs to the wanted bone
  kUndecidedTooth,  // the same, for a tooth
};

constexpr bool IsWanted(MaskTissue tissue) {
  return tissue == MaskTissue::kBone || tissue == MaskTissue::kTooth || tissue == MaskTissue::kCanal;
}
constexpr bool IsUndecided(MaskTissue tissue) {
  return tissue == MaskTissue::kUndecided || tissue == MaskTissue::kUndecidedTooth;
}
constexpr bool IsTooth(MaskTissue tissue) {
  return tissue == MaskTissue::kTooth || tissue == MaskTissue::kUndecidedTooth;
}

struct BoneMask {
  Volume tissue;    // its values are those of MaskTissue
  std::string how;  // what it was made from, in words

  MaskTissue At(std::size_t v) const { return static_cast<MaskTissue>(tissue.hu[v]); }
};

/// Returns whether a voxel of the mask has this tissue.
bool ContainsTissue(const BoneMask& mask, MaskTissue tissue);

/// Returns the distance from the border of the mask beyond which the mask overrides the CT, mm: two of its voxels,
/// along the axis with the largest spacing, but at least 1.5 mm. A mask that leaks by a voxel lies wrong by one voxel
/// and by half the diagonal of another, 1.87 voxels in all.
double CalcDefaultReach(const BoneMask& mask);

/// A mask on the lattice of a CT, interpolated between its voxels.
struct MaskSamples {
  std::vector<std::uint8_t> wanted;     // 1 for the wanted bone
  std::vector<std::uint8_t> undecided;  // 1 where the CT decides
  std::vector<std::uint8_t> other;      // 1 for other bone
  std::vector<float> tooth;             // fraction of tooth, whether wanted or undecided; empty if the mask has none
  std::vector<float> canal;             // fraction of the canal; empty if the mask has none
};

MaskSamples SampleMask(const BoneMask& mask, const Volume& lattice);

}  // namespace kerf
