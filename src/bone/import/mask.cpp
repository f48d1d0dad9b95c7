#include "bone/import/mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace kerf {

namespace {

constexpr double kLeastReach_mm = 1.5;
constexpr double kReach_vox = 2;
constexpr std::size_t kTissues = 11;  // of MaskTissue

struct Fractions {
  std::array<double, kTissues> of{};  // by tissue
  int tooth = 0;                      // number of the tooth with the largest fraction; 0: none has a number

  double Sum(bool (*is)(MaskTissue)) const {
    double sum = 0;
    for (std::size_t t = 0; t < kTissues; ++t) sum += is(static_cast<MaskTissue>(t)) ? of[t] : 0;
    return sum;
  }
};

// Returns the fraction of each tissue at a point, in voxels of the mask.
Fractions CalcFractions(const BoneMask& mask, const Vec3& p_V) {
  Fractions fractions;
  const Vec3 first = glm::floor(p_V);
  const Vec3 f = p_V - first;
  std::map<int, double> teeth;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at{};
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const int upper = corner >> a & 1;
      at[static_cast<std::size_t>(a)] = static_cast<int>(first[a]) + upper;
      weight *= upper != 0 ? f[a] : 1 - f[a];
    }
    if (weight == 0 || !mask.tissue.Contains(at)) continue;
    const std::size_t v = mask.tissue.Index(at[0], at[1], at[2]);
    fractions.of[static_cast<std::size_t>(mask.At(v))] += weight;
    if (mask.ToothAt(v) != 0) teeth[mask.ToothAt(v)] += weight;
  }
  double largest = 0;
  for (const auto& [number, weight] : teeth) {
    if (weight <= largest) continue;
    largest = weight;
    fractions.tooth = number;
  }
  return fractions;
}

}  // namespace

std::size_t CountTissue(const BoneMask& mask, bool (*is)(MaskTissue)) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < mask.tissue.hu.size(); ++v) count += is(mask.At(v)) ? 1 : 0;
  return count;
}

std::vector<int> ListTeeth(const BoneMask& mask) {
  std::set<int> teeth;
  for (std::size_t v = 0; v < mask.tissue.hu.size(); ++v) {
    if (mask.ToothAt(v) != 0) teeth.insert(mask.ToothAt(v));
  }
  return {teeth.begin(), teeth.end()};
}

double CalcDefaultReach(const BoneMask& mask) {
  const Vec3& h = mask.tissue.spacing_mm;
  return std::max(kLeastReach_mm, kReach_vox * std::max({h.x, h.y, h.z}));
}

MaskSamples SampleMask(const BoneMask& mask, const Volume& lattice, double reach_mm) {
  MaskSamples samples;
  samples.reach_mm = reach_mm;
  samples.wanted.assign(lattice.count(), 0);
  samples.undecided = samples.wanted;
  samples.other = samples.wanted;
  const auto prepare = [&](std::vector<float>& values, bool (*is)(MaskTissue)) {
    if (CountTissue(mask, is) > 0) values.assign(lattice.count(), 0);
  };
  prepare(samples.tooth, IsTooth);
  prepare(samples.canal, IsCanal);
  prepare(samples.metal, IsMetal);
  prepare(samples.lesion, IsLesion);
  if (!ListTeeth(mask).empty()) samples.number.assign(lattice.count(), 0);
  const glm::dmat3 from_world = glm::inverse(mask.tissue.axes_W);
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(lattice.size[2]); ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i, ++v) {
        const Vec3 p_W = lattice.WorldFromVoxel({i, j, static_cast<double>(k)});
        const Vec3 p_V = from_world * (p_W - mask.tissue.origin_W) / mask.tissue.spacing_mm;
        bool beyond = false;
        for (int a = 0; a < 3; ++a) beyond |= !(p_V[a] > -1 && p_V[a] < mask.tissue.size[static_cast<std::size_t>(a)]);
        if (beyond) continue;
        const Fractions fractions = CalcFractions(mask, p_V);
        const double wanted = fractions.Sum(IsWanted), undecided = fractions.Sum(IsUndecided);
        samples.wanted[v] = wanted >= 0.5 ? 1 : 0;
        samples.undecided[v] = wanted < 0.5 && wanted + undecided >= 0.5 ? 1 : 0;
        samples.other[v] = fractions.of[static_cast<std::size_t>(MaskTissue::kOther)] >= 0.5 ? 1 : 0;
        if (!samples.number.empty()) samples.number[v] = static_cast<std::uint8_t>(fractions.tooth);
        const auto set = [&](std::vector<float>& values, bool (*is)(MaskTissue)) {
          if (!values.empty()) values[v] = static_cast<float>(fractions.Sum(is));
        };
        set(samples.tooth, IsTooth);
        set(samples.canal, IsCanal);
        set(samples.metal, IsMetal);
        set(samples.lesion, IsLesion);
      }
    }
  }
  return samples;
}

}  // namespace kerf
