#include "bone/import/mask.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {

namespace {

constexpr double kLeastReach_mm = 1.5;
constexpr double kReach_vox = 2;
constexpr std::size_t kTissues = 7;  // of MaskTissue

// Returns the fraction of each tissue at a point, in voxels of the mask.
std::array<double, kTissues> CalcFractions(const BoneMask& mask, const Vec3& p_V) {
  std::array<double, kTissues> fractions{};
  const Vec3 first = glm::floor(p_V);
  const Vec3 f = p_V - first;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at{};
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const int upper = corner >> a & 1;
      at[static_cast<std::size_t>(a)] = static_cast<int>(first[a]) + upper;
      weight *= upper != 0 ? f[a] : 1 - f[a];
    }
    if (weight == 0 || !mask.tissue.Contains(at)) continue;
    fractions[static_cast<std::size_t>(mask.tissue.hu[mask.tissue.Index(at[0], at[1], at[2])])] += weight;
  }
  return fractions;
}

}  // namespace

bool ContainsTissue(const BoneMask& mask, MaskTissue tissue) {
  const auto value = static_cast<std::int16_t>(tissue);
  return std::find(mask.tissue.hu.begin(), mask.tissue.hu.end(), value) != mask.tissue.hu.end();
}

double CalcDefaultReach(const BoneMask& mask) {
  const Vec3& h = mask.tissue.spacing_mm;
  return std::max(kLeastReach_mm, kReach_vox * std::max({h.x, h.y, h.z}));
}

MaskSamples SampleMask(const BoneMask& mask, const Volume& lattice) {
  MaskSamples samples;
  samples.wanted.assign(lattice.count(), 0);
  samples.undecided = samples.wanted;
  samples.other = samples.wanted;
  if (ContainsTissue(mask, MaskTissue::kTooth) || ContainsTissue(mask, MaskTissue::kUndecidedTooth))
    samples.tooth.assign(lattice.count(), 0);
  if (ContainsTissue(mask, MaskTissue::kCanal)) samples.canal.assign(lattice.count(), 0);
  const glm::dmat3 from_world = glm::inverse(mask.tissue.axes_W);
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(lattice.size[2]); ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i, ++v) {
        const Vec3 p_W = lattice.WorldFromVoxel({i, j, static_cast<double>(k)});
        const Vec3 p_V = from_world * (p_W - mask.tissue.origin_W) / mask.tissue.spacing_mm;
        bool beyond = false;
        for (int a = 0; a < 3; ++a) beyond |= !(p_V[a] > -1 && p_V[a] < mask.tissue.size[static_cast<std::size_t>(a)]);
        if (beyond) continue;
        const std::array<double, kTissues> fractions = CalcFractions(mask, p_V);
        double wanted = 0, undecided = 0, tooth = 0;
        for (std::size_t t = 0; t < kTissues; ++t) {
          const auto tissue = static_cast<MaskTissue>(t);
          if (IsWanted(tissue)) wanted += fractions[t];
          if (IsUndecided(tissue)) undecided += fractions[t];
          if (IsTooth(tissue)) tooth += fractions[t];
        }
        samples.wanted[v] = wanted >= 0.5 ? 1 : 0;
        samples.undecided[v] = wanted < 0.5 && wanted + undecided >= 0.5 ? 1 : 0;
        samples.other[v] = fractions[static_cast<std::size_t>(MaskTissue::kOther)] >= 0.5 ? 1 : 0;
        if (!samples.tooth.empty()) samples.tooth[v] = static_cast<float>(tooth);
        if (!samples.canal.empty())
          samples.canal[v] = static_cast<float>(fractions[static_cast<std::size_t>(MaskTissue::kCanal)]);
      }
    }
  }
  return samples;
}

}  // namespace kerf
