#include "view/live/dust.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {
namespace {

constexpr double kMaxSpeed_mm_per_s = 150;
constexpr double kSlowing_s = 0.16;       // after this time, the speed through the air is reduced to 1/e
constexpr double kSinking_mm_per_s = 14;  // towards -z, the patient's feet
constexpr double kSpread = 0.45;          // of the direction, as a fraction of the speed
constexpr double kStart_mm = 0.6;         // grains start within this distance of the cut

}  // namespace

void DustCloud::set_max_grains(std::size_t max_grains) {
  max_grains_ = max_grains;
  if (grains_.size() > max_grains_) {
    grains_.erase(grains_.begin(), grains_.end() - static_cast<std::ptrdiff_t>(max_grains_));
  }
}

void DustCloud::Add(const Vec3& p_W, const Vec3& v_W, double volume_mm3) {
  if (!(volume_mm3 > 0) || !std::isfinite(volume_mm3) || !IsInWorld(p_W) || !IsInWorld(v_W) || max_grains_ == 0) return;
  rest_mm3_ = std::min(rest_mm3_ + volume_mm3, static_cast<double>(max_grains_) / kGrainsPerMm3);
  const auto count = static_cast<std::size_t>(rest_mm3_ * kGrainsPerMm3);
  rest_mm3_ -= static_cast<double>(count) / kGrainsPerMm3;
  // Not std::uniform_real_distribution, whose values depend on the library.
  const auto draw = [&] { return (static_cast<double>(random_()) + 0.5) / 4294967296.0; };
  const auto around = [&] { return Vec3{2 * draw() - 1, 2 * draw() - 1, 2 * draw() - 1}; };
  const double speed = std::min(glm::length(v_W), kMaxSpeed_mm_per_s);
  const Vec3 direction = CalcDirection(v_W).value_or(Vec3{0, 0, 1});
  for (std::size_t i = 0; i < count; ++i) {
    Flying grain;
    grain.p_W = p_W + kStart_mm * around();
    grain.v_W = speed * (0.4 + 0.6 * draw()) * (direction + kSpread * around());
    grain.diameter_mm = 0.18 + 0.3 * draw();
    grain.life_s = kLife_s * (0.45 + 0.55 * draw());
    grains_.push_back(grain);
  }
  set_max_grains(max_grains_);
}

void DustCloud::Advance(double dt_s) {
  if (!(dt_s > 0)) return;
  const double kept = std::exp(-dt_s / kSlowing_s);
  for (Flying& grain : grains_) {
    // Exact for any step: the distance flown is the integral of the decaying speed.
    grain.p_W += kSlowing_s * (1 - kept) * grain.v_W - Vec3{0, 0, kSinking_mm_per_s * dt_s};
    grain.v_W *= kept;
    grain.age_s += dt_s;
  }
  grains_.erase(std::remove_if(grains_.begin(), grains_.end(), [](const Flying& g) { return g.age_s >= g.life_s; }),
                grains_.end());
}

void DustCloud::Clear() {
  grains_.clear();
  rest_mm3_ = 0;
}

std::vector<DustGrain> DustCloud::MakeGrains() const {
  std::vector<DustGrain> grains;
  grains.reserve(grains_.size());
  for (const Flying& grain : grains_) {
    const double left = 1 - grain.age_s / grain.life_s;
    grains.push_back({grain.p_W, grain.diameter_mm, std::min(1.0, 2 * left)});
  }
  return grains;
}

}  // namespace kerf
