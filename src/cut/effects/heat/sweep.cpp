// Computation of a block of the heat grid from the beginning to the end of a frame.
#include <algorithm>
#include <cmath>

#include "cut/effects/heat/heat_grid.h"
#include "cut/effects/heat/kernels.h"

namespace kerf {
namespace {

using namespace heat;

constexpr double kDoseFrom_C = 39;  // CEM43 counts no dose below this
constexpr double kDoseTo_C = 100;   // higher temperatures count as this
constexpr double kLimit_C = 47, kLimit_s = 60, kLimitDose_min = 16;

void CopyRow(const float* from, float* to) {
  std::copy_n(from, kSide, to);
}

/// Copies a layer of a block, z fastest, into a layer of a padded block. `face`: the face of the padded block at which
/// the copy lies.
void CopyLayer(const float* from, int layer, int face, float* to) {
  const int place = face % 2 == 1 ? kSide : -1;
  for (int i = 0; i < kSide; ++i) {
    switch (face / 2) {
      case 0:
        CopyRow(from + (layer * kSide + i) * kSide, to + PaddedAt(place, i, 0));
        break;
      case 1:
        CopyRow(from + (i * kSide + layer) * kSide, to + PaddedAt(i, place, 0));
        break;
      default:
        for (int k = 0; k < kSide; ++k) to[PaddedAt(i, k, place)] = from[(i * kSide + k) * kSide + layer];
    }
  }
}

void ClearLayer(int face, float* to) {
  static constexpr Nodes kZeros{};
  CopyLayer(kZeros.data(), 0, face, to);
}

}  // namespace

/// Block with a layer of its neighbours on each side.
struct HeatGrid::Padded {
  PaddedNodes theta{};
  PaddedNodes fraction{};
  bool surface = false;  // some of the cells may have a bare surface
};

void HeatGrid::Pad(const Block& block, Padded& padded) const {
  const Nodes& theta = block.theta[static_cast<std::size_t>(now_)];
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const int row = (x * kSide + y) * kSide;
      CopyRow(theta.data() + row, padded.theta.data() + PaddedAt(x, y, 0));
      CopyRow(block.fraction.data() + row, padded.fraction.data() + PaddedAt(x, y, 0));
    }
  }
  padded.surface = !block.whole;
  for (int face = 0; face < 6; ++face) {
    const bool upper = face % 2 == 1;
    const int number = block.neighbours[static_cast<std::size_t>(face)];
    const Block* other = number >= 0 ? &blocks_[static_cast<std::size_t>(number)] : nullptr;
    // No heat is exchanged with a neighbour that is not active.
    const bool worked_on = other != nullptr && other->active;
    CopyLayer((worked_on ? other->theta[static_cast<std::size_t>(now_)] : theta).data(),
              worked_on != upper ? kSide - 1 : 0, face, padded.theta.data());
    if (number == kAir) {
      ClearLayer(face, padded.fraction.data());
    } else {
      CopyLayer((other != nullptr ? other->fraction : block.fraction).data(),
                (other != nullptr) != upper ? kSide - 1 : 0, face, padded.fraction.data());
    }
    padded.surface = padded.surface || number == kAir || (other != nullptr && !other->whole);
  }
}

void HeatGrid::Cool(const Block& block, const Padded& padded, const HeatWet& wet, Nodes& theta) {
  const double H = params_.spacing_mm;
  Surface surface;
  surface.air = air_rate_;
  const Vec3 first = H * Vec3(kSide * block.index.x, kSide * block.index.y, kSide * block.index.z) - wet.p_F;
  surface.wet = coolant_rate_ > 0 && wet.radius_mm > 0 &&
                glm::length(first + Vec3(3.5 * H)) < std::hypot(wet.radius_mm, wet.half_mm) + 6.1 * H;
  if (surface.air == 0 && !surface.wet) return;
  surface.coolant = coolant_rate_;
  surface.coolant_K = static_cast<float>(params_.coolant_C - params_.body_C);
  for (int axis = 0; axis < 3; ++axis) {
    surface.first_mm[static_cast<std::size_t>(axis)] = static_cast<float>(first[axis]);
    surface.axis[static_cast<std::size_t>(axis)] = static_cast<float>(wet.axis_F[axis]);
  }
  surface.spacing_mm = static_cast<float>(H);
  surface.radius_mm = static_cast<float>(wet.radius_mm);
  surface.half_mm = static_cast<float>(wet.half_mm);
  const SurfaceLoss loss = CoolSurface(padded.fraction, surface, theta);
  frame_spent_.air += cell_mJ_per_K_ * loss.air;
  frame_spent_.irrigation += cell_mJ_per_K_ * loss.coolant;
}

void HeatGrid::Count(Block& block, const Nodes& before, const Nodes& after) {
  DoseRule rule;
  rule.frame_s = static_cast<float>(frame_s_);
  rule.from_K = static_cast<float>(kDoseFrom_C - params_.body_C);
  rule.base_K = static_cast<float>(43 - params_.body_C);
  rule.max_K = static_cast<float>(kDoseTo_C - 43);
  rule.limit_K = static_cast<float>(kLimit_C - params_.body_C);
  // The times are sums of frame lengths, so they have an error of half a frame.
  rule.limit_s = static_cast<float>(kLimit_s) - 0.5F * rule.frame_s;
  rule.limit_dose_min = static_cast<float>(kLimitDose_min);
  const DoseFigures found = AddDose(rule, block.fraction, before, after, block.above_47_s, block.cem43_min);
  const double cell_mm3 = params_.spacing_mm * params_.spacing_mm * params_.spacing_mm;
  figures_.above_47_s = std::max(figures_.above_47_s, static_cast<double>(found.longest_s));
  figures_.cem43_min = std::max(figures_.cem43_min, static_cast<double>(found.max_dose_min));
  figures_.past_47_mm3 += cell_mm3 * found.past_time - block.past_47_mm3;
  figures_.past_dose_mm3 += cell_mm3 * found.past_dose - block.past_dose_mm3;
  block.past_47_mm3 = cell_mm3 * found.past_time;
  block.past_dose_mm3 = cell_mm3 * found.past_dose;
}

/// Boils off water with the heat of a node above 100 C, until no water is left. Returns the heat of the steam, mJ.
double HeatGrid::Boil(Block& block, std::size_t node, float& theta) const {
  const float boils = std::min(theta - boiling_K_, water_K_ - block.boiled_K[node]);
  if (!(boils > 0)) return 0;
  const float before = theta;
  theta -= boils;
  block.boiled_K[node] += boils;
  return cell_mJ_per_K_ * static_cast<double>(block.fraction[node]) *
         (static_cast<double>(before) - static_cast<double>(theta));
}

void HeatGrid::Sweep(int number, const HeatWet& wet) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  Padded padded;
  Pad(block, padded);
  const Nodes& before = block.theta[static_cast<std::size_t>(now_)];
  Nodes& after = block.theta[static_cast<std::size_t>(now_ ^ 1)];
  Conduct(padded.theta, padded.fraction, !padded.surface, conduction_, after);
  if (padded.surface) Cool(block, padded, wet, after);
  const Perfused perfused = Perfuse(block.fraction, perfusion_factor_, before, after);
  frame_spent_.perfusion += cell_mJ_per_K_ * perfused.lost;
  block.hottest_K = perfused.hottest_K;
  if (perfused.hottest_K > boiling_K_ && water_K_ > 0) {
    block.hottest_K = -1e30F;
    for (std::size_t n = 0; n < kNodes; ++n) {
      if (after[n] > boiling_K_) frame_spent_.steam += Boil(block, n, after[n]);
      block.hottest_K = std::max(block.hottest_K, after[n]);
    }
  }
  const auto dose_K = static_cast<float>(kDoseFrom_C - params_.body_C);
  if (std::max(perfused.hottest_K, perfused.was_hottest_K) >= dose_K || block.past_47_mm3 > 0 ||
      block.past_dose_mm3 > 0) {
    Count(block, before, after);
  }
  if (block.hottest_K < kOpenAbove_K) return;
  for (int face = 0; face < 6; ++face) {
    const int neighbour = block.neighbours[static_cast<std::size_t>(face)];
    if (neighbour == kAir || (neighbour >= 0 && blocks_[static_cast<std::size_t>(neighbour)].active)) continue;
    const int layer = face % 2 == 1 ? kSide - 1 : 0;
    float hottest = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int u = i / kSide, v = i % kSide;
      const int n = face < 2 ? layer * 64 + i : face < 4 ? u * 64 + layer * 8 + v : i * 8 + layer;
      hottest = std::max(hottest, after[static_cast<std::size_t>(n)]);
    }
    if (hottest >= kOpenAbove_K) block.wanted |= 1U << face;
  }
}

}  // namespace kerf
