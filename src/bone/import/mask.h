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
  kBoneMetal,       // implants and plates in a segment of the wanted bone
  kBoneLesion,      // a lesion in a segment of the wanted bone
  kOther,           // other bone, and teeth in it
  kUndecided,       // the CT decides whether it belongs to the wanted bone
  kUndecidedTooth,  // the same, for a tooth
  kMetal,           // the same, for implants and plates
  kLesion,          // the same, for a lesion
};

constexpr bool IsWanted(MaskTissue tissue) {
  return tissue >= MaskTissue::kBone && tissue < MaskTissue::kOther;
}
constexpr bool IsUndecided(MaskTissue tissue) {
  return tissue >= MaskTissue::kUndecided;
}
constexpr bool IsTooth(MaskTissue tissue) {
  return tissue == MaskTissue::kTooth || tissue == MaskTissue::kUndecidedTooth;
}

constexpr bool IsCanal(MaskTissue tissue) {
  return tissue == MaskTissue::kCanal;
}
constexpr bool IsMetal(MaskTissue tissue) {
  return tissue == MaskTissue::kMetal || tissue == MaskTissue::kBoneMetal;
}
constexpr bool IsLesion(MaskTissue tissue) {
  return tissue == MaskTissue::kLesion || tissue == MaskTissue::kBoneLesion;
}

struct BoneMask {
  Volume tissue;             // its values are those of Pack()
  std::string how;           // what it was made from, in words
  std::string series_uid{};  // of the CT that was segmented; empty: unknown
  std::string frame_uid{};   // of its DICOM frame of reference; empty: unknown
  bool cropped = false;      // its lattice ends where the segments end, not where the scan does

  /// `fdi`: number of a tooth after ISO 3950; 0: unknown, or no tooth.
  static std::int16_t Pack(MaskTissue tissue, int fdi) {
    return static_cast<std::int16_t>(static_cast<int>(tissue) + 16 * fdi);
  }
  MaskTissue At(std::size_t v) const { return static_cast<MaskTissue>(tissue.hu[v] % 16); }
  int ToothAt(std::size_t v) const { return tissue.hu[v] / 16; }
};

/// Returns the number of voxels whose tissue is one of those for which `is` returns true, such as IsMetal().
std::size_t CountTissue(const BoneMask& mask, bool (*is)(MaskTissue));

/// Returns the numbers of the teeth in the mask, each once, in increasing order.
std::vector<int> ListTeeth(const BoneMask& mask);

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
  std::vector<float> metal;             // fraction of metal; empty if the mask has none
  std::vector<float> lesion;            // fraction of a lesion; empty if the mask has none
  std::vector<std::uint8_t> number;     // number of the tooth with the largest fraction; empty if none has a number
  double reach_mm = 0;                  // from the border of the mask; beyond it the mask overrides the CT
};

MaskSamples SampleMask(const BoneMask& mask, const Volume& lattice, double reach_mm);

}  // namespace kerf
