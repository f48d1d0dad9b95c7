// A block of the heat grid from a frame's beginning to its end.
#include <algorithm>
#include <bit>
#include <cmath>

#include "effects/heat/heat_grid.h"

namespace kerf {
namespace {

constexpr int kSide = 8;
constexpr int kRow = 10;  // of the padded block
constexpr int kLayer = kRow * kRow;
constexpr float kLeastShare = 0.5F;
constexpr float kOpens_K = 0.2F;
constexpr double kDoseFrom_C = 39;  // below, the rule of CEM43 counts nothing
constexpr double kDoseTo_C = 100;   // above, it counts as that
constexpr double kLimit_C = 47, kLimit_s = 60, kLimitDose_min = 16;

constexpr int PaddedAt(int x, int y, int z) {
  return (x + 1) * kLayer + (y + 1) * kRow + z + 1;
}

}  // namespace

/// A block with a layer of its neighbours about it.
struct HeatGrid::Padded {
  std::array<float, kRow * kRow * kRow> theta;
  std::array<float, kRow * kRow * kRow> share;
  bool surface = false;  // some of the cells may have a bare surface
};

void HeatGrid::Pad(const Block& block, Padded& padded) const {
  const std::array<float, kNodes>& theta = block.theta[static_cast<std::size_t>(now_)];
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const int first = (x * kSide + y) * kSide;
      const auto from = static_cast<std::size_t>(first);
      const auto to = static_cast<std::size_t>(PaddedAt(x, y, 0));
      std::copy_n(&theta[from], kSide, &padded.theta[to]);
      std::copy_n(&block.share[from], kSide, &padded.share[to]);
    }
  }
  padded.surface = !block.whole;
  constexpr std::array<int, 3> kStride{kSide * kSide, kSide, 1};
  constexpr std::array<int, 3> kPaddedStride{kLayer, kRow, 1};
  for (int face = 0; face < 6; ++face) {
    const std::size_t axis = static_cast<std::size_t>(face / 2);
    const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    const bool upper = face % 2 == 1;
    const int number = block.neighbours[static_cast<std::size_t>(face)];
    const Block* other = number >= 0 ? &blocks_[static_cast<std::size_t>(number)] : nullptr;
    // Of a neighbour that is not worked on, heat neither comes nor goes.
    const std::array<float, kNodes>& beside_theta =
        other != nullptr && other->active ? other->theta[static_cast<std::size_t>(now_)] : theta;
    const std::array<float, kNodes>& beside_share = other != nullptr ? other->share : block.share;
    const int theta_layer = (other != nullptr && other->active) != upper ? kSide - 1 : 0;
    const int share_layer = (other != nullptr) != upper ? kSide - 1 : 0;
    padded.surface = padded.surface || number == kAir || (other != nullptr && !other->whole);
    const int base = PaddedAt(0, 0, 0) + (upper ? kSide : -1) * kPaddedStride[axis];
    for (int i = 0; i < kSide; ++i) {
      for (int k = 0; k < kSide; ++k) {
        const int place = base + i * kPaddedStride[a] + k * kPaddedStride[b];
        const auto to = static_cast<std::size_t>(place);
        const int in_layer = i * kStride[a] + k * kStride[b];
        const int theta_at = theta_layer * kStride[axis] + in_layer;
        const int share_at = share_layer * kStride[axis] + in_layer;
        padded.theta[to] = beside_theta[static_cast<std::size_t>(theta_at)];
        padded.share[to] = number == kAir ? 0 : beside_share[static_cast<std::size_t>(share_at)];
      }
    }
  }
}

/// Newton's law at bare surfaces, implicitly. The area of a surface within a cell is the gradient of the share.
void HeatGrid::CoolSurface(const Block& block, const Padded& padded, const HeatWet& wet, float* theta, double& air,
                           double& irrigation) const {
  const double H = params_.spacing_mm;
  const auto rate = [&](double h_W_per_m2K) {  // of a cell of bone with a whole face bare, in a frame
    if (!(h_W_per_m2K > 0)) return 0.0;
    const double U = 1e-3 / (1 / h_W_per_m2K + 0.5e-3 * H / params_.conductivity_W_per_mK);  // mW / (mm2 K)
    return U * H * H * frame_s_ / cell_mJ_per_K_;
  };
  const auto dry = static_cast<float>(rate(params_.air_W_per_m2K));
  const auto wetted = static_cast<float>(rate(params_.irrigation_W_per_m2K));
  const auto coolant_K = static_cast<float>(params_.coolant_C - params_.body_C);
  const Vec3 first(H * Vec3(kSide * block.index.x, kSide * block.index.y, kSide * block.index.z));
  const bool near = params_.irrigation_W_per_m2K > 0 && wet.radius_mm > 0 &&
                    glm::length(first + Vec3(3.5 * H) - wet.p_F) < std::hypot(wet.radius_mm, wet.half_mm) + 6.1 * H;
  if (dry == 0 && !near) return;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const float* f = &padded.share[static_cast<std::size_t>(PaddedAt(x, y, 0))];
      float* row = theta + (x * kSide + y) * kSide;
      std::array<float, kSide> area, before;
      for (int z = 0; z < kSide; ++z) {
        const float gx = f[z] - std::min(std::min(f[z - kLayer], f[z + kLayer]), f[z]);
        const float gy = f[z] - std::min(std::min(f[z - kRow], f[z + kRow]), f[z]);
        const float gz = f[z] - std::min(std::min(f[z - 1], f[z + 1]), f[z]);
        area[z] = std::sqrt(gx * gx + gy * gy + gz * gz) / std::max(f[z], kLeastShare);
        before[z] = row[z];
        row[z] = before[z] / (1 + dry * area[z]);
      }
      float air_row = 0;
      for (int z = 0; z < kSide; ++z) {
        if (near && area[z] > 0) {
          const Vec3 r = first + H * Vec3(x, y, z) - wet.p_F;
          const double along = glm::dot(r, wet.axis_F);
          if (std::abs(along) <= wet.half_mm && glm::dot(r, r) - along * along <= wet.radius_mm * wet.radius_mm) {
            const float lambda = wetted * area[z];
            row[z] = (before[z] + lambda * coolant_K) / (1 + lambda);
            irrigation += static_cast<double>(f[z]) * (static_cast<double>(before[z]) - static_cast<double>(row[z]));
            continue;
          }
        }
        air_row += f[z] * (before[z] - row[z]);
      }
      air += static_cast<double>(air_row);
    }
  }
}

/// 2^x to 3e-7 of it; x from -126 to 126.
inline float CalcPowerOf2(float x) {
  constexpr float kToWhole = 12582912.0F;  // 1.5 * 2^23: what is added to it is rounded to whole numbers
  const float whole = (x + kToWhole) - kToWhole;
  const float t = x - whole;
  const float fine =
      1 + t * (0.69314718F +
               t * (0.24022651F + t * (0.05550411F + t * (0.00961813F + t * (0.00133336F + t * 0.00015404F)))));
  return fine * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

/// Time above 47 C and CEM43 (Sapareto and Dewey 1984), both by the mean of the temperatures before and after.
void HeatGrid::AddDose(Block& block, const float* before, const float* after) {
  const auto from_K = static_cast<float>(kDoseFrom_C - params_.body_C);
  const auto limit_K = static_cast<float>(kLimit_C - params_.body_C);
  const auto base_K = static_cast<float>(43 - params_.body_C);
  const auto most_K = static_cast<float>(kDoseTo_C - 43);
  const auto frame_s = static_cast<float>(frame_s_);
  const float frame_min = frame_s / 60;
  // Sums of frames' lengths: within half a frame.
  const float least_s = static_cast<float>(kLimit_s) - 0.5F * frame_s;
  std::array<float, kSide> past_47_row{}, past_dose_row{}, longest_row{}, dose_row{};
  for (std::size_t row = 0; row < kNodes; row += kSide) {
    for (std::size_t z = 0; z < kSide; ++z) {
      const std::size_t n = row + z;
      const float share = block.share[n];
      const float mean_K = share > 0 ? 0.5F * (before[n] + after[n]) : -1000.0F;
      const float above_s = block.above_47_s[n] + (mean_K >= limit_K ? frame_s : 0.0F);
      const float over_K = std::clamp(mean_K - base_K, -60.0F, most_K);
      const float rate = CalcPowerOf2(over_K >= 0 ? over_K : 2 * over_K);
      const float dose = block.cem43_min[n] + (mean_K >= from_K ? frame_min * rate : 0.0F);
      block.above_47_s[n] = above_s;
      block.cem43_min[n] = dose;
      past_47_row[z] += above_s >= least_s ? share : 0.0F;
      past_dose_row[z] += dose > static_cast<float>(kLimitDose_min) ? share : 0.0F;
      longest_row[z] = std::max(longest_row[z], above_s);
      dose_row[z] = std::max(dose_row[z], dose);
    }
  }
  double past_47 = 0, past_dose = 0;
  for (std::size_t z = 0; z < kSide; ++z) {
    past_47 += static_cast<double>(past_47_row[z]);
    past_dose += static_cast<double>(past_dose_row[z]);
  }
  const float longest_s = *std::max_element(longest_row.begin(), longest_row.end());
  const float dose_min = *std::max_element(dose_row.begin(), dose_row.end());
  const double cell_mm3 = params_.spacing_mm * params_.spacing_mm * params_.spacing_mm;
  figures_.above_47_s = std::max(figures_.above_47_s, static_cast<double>(longest_s));
  figures_.cem43_min = std::max(figures_.cem43_min, static_cast<double>(dose_min));
  figures_.past_47_mm3 += cell_mm3 * past_47 - block.past_47_mm3;
  figures_.past_dose_mm3 += cell_mm3 * past_dose - block.past_dose_mm3;
  block.past_47_mm3 = cell_mm3 * past_47;
  block.past_dose_mm3 = cell_mm3 * past_dose;
}

void HeatGrid::Sweep(int number, const HeatWet& wet) {
  Block& block = blocks_[static_cast<std::size_t>(number)];
  Padded padded;
  Pad(block, padded);
  const float* before = block.theta[static_cast<std::size_t>(now_)].data();
  float* after = block.theta[static_cast<std::size_t>(now_ ^ 1)].data();
  const float r = conduction_;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const float* t = &padded.theta[static_cast<std::size_t>(PaddedAt(x, y, 0))];
      const float* f = &padded.share[static_cast<std::size_t>(PaddedAt(x, y, 0))];
      float* out = after + (x * kSide + y) * kSide;
      // What goes from one cell to the next is to the bit what comes there: the same product with the other sign.
      const auto from = [&](int z, int step) { return std::min(f[z], f[z + step]) * (t[z + step] - t[z]); };
      for (int z = 0; z < kSide; ++z) {
        const float gain =
            from(z, -kLayer) + from(z, kLayer) + from(z, -kRow) + from(z, kRow) + from(z, -1) + from(z, 1);
        out[z] = t[z] + r * gain / std::max(f[z], kLeastShare);
      }
    }
  }
  if (padded.surface) {
    double air = 0, irrigation = 0;
    CoolSurface(block, padded, wet, after, air, irrigation);
    frame_spent_.air += cell_mJ_per_K_ * air;
    frame_spent_.irrigation += cell_mJ_per_K_ * irrigation;
  }
  double carried = 0;
  float hottest = after[0], coldest = after[0], was_hottest = before[0];
  const float keeps = perfusion_keeps_;
  for (int row = 0; row < kSide * kSide; ++row) {
    float sum = 0;
    for (int z = 0; z < kSide; ++z) {
      const int n = row * kSide + z;
      const float kept = keeps * after[n];
      sum += block.share[static_cast<std::size_t>(n)] * (after[n] - kept);
      after[n] = kept;
      hottest = std::max(hottest, kept);
      coldest = std::min(coldest, kept);
      was_hottest = std::max(was_hottest, before[n]);
    }
    carried += static_cast<double>(sum);
  }
  frame_spent_.perfusion += cell_mJ_per_K_ * carried;
  block.hottest_K = hottest;
  block.farthest_K = std::max(hottest, -coldest);
  const auto dose_K = static_cast<float>(kDoseFrom_C - params_.body_C);
  if (std::max(hottest, was_hottest) >= dose_K || block.past_47_mm3 > 0 || block.past_dose_mm3 > 0)
    AddDose(block, before, after);
  for (int face = 0; face < 6; ++face) {
    const int neighbour = block.neighbours[static_cast<std::size_t>(face)];
    if (neighbour == kAir || block.farthest_K < kOpens_K) continue;
    if (neighbour >= 0 && blocks_[static_cast<std::size_t>(neighbour)].active) continue;
    float farthest = 0;
    const int layer = face % 2 == 1 ? kSide - 1 : 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int u = i / kSide, v = i % kSide;
      const int n = face < 2 ? layer * 64 + i : face < 4 ? u * 64 + layer * 8 + v : i * 8 + layer;
      farthest = std::max(farthest, std::abs(after[n]));
    }
    if (farthest >= kOpens_K) block.wanted |= 1U << face;
  }
}

}  // namespace kerf
