#include "experiment/study/errors.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/core/high_pass.h"
#include "base/core/percentiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kGivesWay = 0.1;  // fraction of the peak force, below which the bone has given way

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Returns the angle between a and b. Unlike an arc cosine, this is accurate for small angles too.
double CalcAngle(const Vec3& a, const Vec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

std::optional<double> FindBreakthrough(std::span<const Vec3> f_N, double dt_s) {
  double peak = 0;
  for (const Vec3& f : f_N) peak = std::max(peak, glm::length(f));
  const double limit = kGivesWay * peak;
  if (!(peak > 0) || glm::length(f_N.back()) >= limit) return std::nullopt;
  std::size_t last = f_N.size() - 1;  // will be the last sample that is not below the limit
  while (glm::length(f_N[last]) < limit) --last;
  const double above = glm::length(f_N[last]);
  const double below = glm::length(f_N[last + 1]);
  return dt_s * (static_cast<double>(last + 1) + (above - limit) / (above - below));
}

void CalcForceErrors(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, double dt_s, ErrorFigures& errors) {
  if (f_N.size() != reference_N.size()) throw Error("forces and reference do not cover the same ticks");
  const std::size_t n = f_N.size();
  if (n == 0) return;
  double sum_off2 = 0, sum_reference2 = 0, sum_reference = 0, sum_size_off = 0;
  Vec3 sum_off(0);
  std::vector<double> relative(n);
  std::vector<double> degrees;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 off = f_N[i] - reference_N[i];
    const double size = glm::length(reference_N[i]);
    const double far = glm::length(off);
    sum_off2 += far * far;
    sum_reference2 += size * size;
    sum_reference += size;
    sum_size_off += glm::length(f_N[i]) - size;
    sum_off += off;
    relative[i] = far / std::max(size, kMinForce_N);
    errors.force_worst_N = std::max(errors.force_worst_N, far);
    errors.force_worst = std::max(errors.force_worst, relative[i]);
    if (size > kMinForce_N) degrees.push_back(kDegreesPerRad * CalcAngle(f_N[i], reference_N[i]));
  }
  const auto count = static_cast<double>(n);
  errors.force_l2 = std::sqrt(sum_off2 / (sum_reference2 > 0 ? sum_reference2 : count * kMinForce_N * kMinForce_N));
  errors.force_p95 = CalcPercentile(std::move(relative), 0.95);
  if (!degrees.empty()) errors.direction_worst_deg = *std::max_element(degrees.begin(), degrees.end());
  errors.direction_p95_deg = CalcPercentile(std::move(degrees), 0.95);
  const double impulse = sum_reference > 0 ? sum_reference : count * kMinForce_N;
  errors.impulse = glm::length(sum_off) / impulse;
  errors.impulse_signed = sum_size_off / impulse;

  double noise2 = 0;
  if (kNoiseAbove_Hz * dt_s < 0.5) {
    std::vector<double> axis_N(n);
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < n; ++i) axis_N[i] = f_N[i][axis] - reference_N[i][axis];
      const double rms = CalcHighPassRms(axis_N, dt_s, kNoiseAbove_Hz);
      noise2 += rms * rms;
    }
  }
  errors.noise_N = std::sqrt(noise2);

  const std::optional<double> at_s = FindBreakthrough(f_N, dt_s);
  const std::optional<double> reference_at_s = FindBreakthrough(reference_N, dt_s);
  if (at_s && reference_at_s) errors.breakthrough_ms = 1000 * (*at_s - *reference_at_s);
}

double CalcVolumeError(double removed_mm3, double reference_mm3) {
  return reference_mm3 > 0 ? std::abs(removed_mm3 - reference_mm3) / reference_mm3 : std::abs(removed_mm3);
}

std::vector<Vec3> SampleReference(const StudyReference& reference, Holding holding, double rate_hz, std::size_t count) {
  const std::vector<ReferenceTick>& ticks = reference.ticks;
  if (ticks.empty()) throw Error("the reference has no ticks");
  std::vector<Vec3> forces(count);
  // On a path these are sums up to the end of each tick, so the mean over any interval follows from the difference of
  // two of them.
  std::vector<Vec3> values(ticks.size() + 1, Vec3(0));
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    values[i + 1] = holding == Holding::kPath ? values[i] + ticks[i].f_W_N : ticks[i].f_W_N;
  }
  const auto at = [&](double t_s) {
    const double place = std::clamp(t_s / reference.tick_s, 0.0, static_cast<double>(ticks.size()));
    // Rounding must not move the end of a tick into the next tick.
    const double nearest = std::round(place);
    const double where = std::abs(place - nearest) < 1e-6 ? nearest : place;
    const auto before = std::min(static_cast<std::size_t>(where), ticks.size() - 1);
    const double fraction = where - static_cast<double>(before);
    return values[before] + fraction * (values[before + 1] - values[before]);
  };
  for (std::size_t k = 0; k < count; ++k) {
    const double end_s = static_cast<double>(k + 1) / rate_hz;
    forces[k] = at(end_s);
    if (holding == Holding::kPath) {
      forces[k] = (forces[k] - at(static_cast<double>(k) / rate_hz)) * (rate_hz * reference.tick_s);
    }
  }
  return forces;
}

void CalcSurfaceErrors(std::vector<double> there_mm, std::vector<double> back_mm, ErrorFigures& errors) {
  if (there_mm.empty() || back_mm.empty()) return;
  errors.surface_mean_mm = 0.5 * (Mean(there_mm) + Mean(back_mm));
  errors.surface_max_mm =
      std::max(*std::max_element(there_mm.begin(), there_mm.end()), *std::max_element(back_mm.begin(), back_mm.end()));
  errors.surface_p95_mm = std::max(CalcPercentile(std::move(there_mm), 0.95), CalcPercentile(std::move(back_mm), 0.95));
}

}  // namespace kerf
