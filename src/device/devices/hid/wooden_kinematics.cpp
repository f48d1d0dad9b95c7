#include "device/devices/hid/wooden_kinematics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "base/core/vectors.h"

namespace kerf {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;

/// Converts from the makers' axes (towards the user, right, up) to frame D.
Vec3 ToFrameD(const Vec3& v) {
  return {v.y, v.z, v.x};
}
Vec3 FromFrameD(const Vec3& v_D) {
  return {v_D.z, v_D.x, v_D.y};
}

double CalcCountsPerRad(const WoodenParams& params, int joint) {
  return params.counts_per_turn[joint] * params.gear[joint] / (2 * std::numbers::pi);
}

}  // namespace

Vec3 CalcWoodenAngles(const WoodenParams& params, const WoodenCounts& counts) {
  Vec3 angles;
  for (int i = 0; i < 3; ++i) {
    angles[i] = counts[static_cast<std::size_t>(i)] / CalcCountsPerRad(params, i) + kRadPerDegree * params.zero_deg[i];
  }
  return angles;
}

WoodenCounts CalcWoodenCounts(const WoodenParams& params, const Vec3& angles) {
  constexpr double kMax = std::numeric_limits<std::int16_t>::max();
  WoodenCounts counts{};
  for (int i = 0; i < 3; ++i) {
    const double exact = (angles[i] - kRadPerDegree * params.zero_deg[i]) * CalcCountsPerRad(params, i);
    counts[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::lround(std::clamp(exact, -kMax, kMax)));
  }
  return counts;
}

Vec3 CalcWoodenPosition(const WoodenParams& params, const Vec3& angles) {
  const double out = params.upper_arm_mm * std::sin(angles.y) + params.forearm_mm * std::sin(angles.z);
  const double up = params.base_mm + params.upper_arm_mm * std::cos(angles.y) - params.forearm_mm * std::cos(angles.z);
  return ToFrameD(Vec3(out * std::cos(angles.x), out * std::sin(angles.x), up) - params.middle_mm);
}

std::array<Vec3, 3> CalcWoodenJacobian(const WoodenParams& params, const Vec3& angles) {
  const double sin_a = std::sin(angles.x);
  const double cos_a = std::cos(angles.x);
  const Vec3 upper = params.upper_arm_mm * Vec3(std::cos(angles.y), 0, -std::sin(angles.y));  // d(out, -, up)/db
  const Vec3 fore = params.forearm_mm * Vec3(std::cos(angles.z), 0, std::sin(angles.z));      // d(out, -, up)/dc
  const double out = params.upper_arm_mm * std::sin(angles.y) + params.forearm_mm * std::sin(angles.z);
  return {ToFrameD({-sin_a * out, cos_a * out, 0}), ToFrameD({cos_a * upper.x, sin_a * upper.x, upper.z}),
          ToFrameD({cos_a * fore.x, sin_a * fore.x, fore.z})};
}

std::optional<Vec3> FindWoodenAngles(const WoodenParams& params, const Vec3& p_D_mm) {
  const Vec3 p = FromFrameD(p_D_mm) + params.middle_mm;
  const double out = std::hypot(p.x, p.y);
  const double up = p.z - params.base_mm;
  const double reach = std::hypot(out, up);
  const double upper = params.upper_arm_mm;
  const double fore = params.forearm_mm;
  if (!(reach <= upper + fore && reach >= std::abs(upper - fore) && reach > 0)) return std::nullopt;
  const double at_joint = (reach * reach + upper * upper - fore * fore) / (2 * reach * upper);
  const double b = std::atan2(out, up) - std::acos(std::clamp(at_joint, -1.0, 1.0));
  const double c = std::atan2(out - upper * std::sin(b), upper * std::cos(b) - up);
  return Vec3(std::atan2(p.y, p.x), b, c);
}

Vec3 CalcWoodenCurrents(const WoodenParams& params, const Vec3& angles, const Vec3& f_D_N) {
  if (!IsFinite(f_D_N) || !IsFinite(angles)) return Vec3{0};
  const std::array<Vec3, 3> columns = CalcWoodenJacobian(params, angles);
  Vec3 currents_mA;
  double largest_mA = 0;
  for (int i = 0; i < 3; ++i) {
    const double joint_Nmm = glm::dot(columns[static_cast<std::size_t>(i)], f_D_N);
    currents_mA[i] = 1000 * joint_Nmm / (params.gear[i] * params.motor_Nmm_per_A[i]);
    largest_mA = std::max(largest_mA, std::abs(currents_mA[i]));
  }
  if (!IsFinite(currents_mA)) return Vec3{0};
  const double limit_mA = 1000 * params.max_current_A;
  return largest_mA > limit_mA ? currents_mA * (limit_mA / largest_mA) : currents_mA;
}

Vec3 CalcWoodenForce(const WoodenParams& params, const Vec3& angles, const Vec3& currents_mA) {
  const auto [a, b, c] = CalcWoodenJacobian(params, angles);
  // f solves J^T f = joint torques; the rows of the inverse of J^T follow from cross products.
  const double volume = glm::dot(a, glm::cross(b, c));
  if (!(std::abs(volume) > 1e-6 * glm::length(a) * glm::length(b) * glm::length(c))) return Vec3{0};
  Vec3 joint_Nmm;
  for (int i = 0; i < 3; ++i) joint_Nmm[i] = 1e-3 * currents_mA[i] * params.motor_Nmm_per_A[i] * params.gear[i];
  return (joint_Nmm.x * glm::cross(b, c) + joint_Nmm.y * glm::cross(c, a) + joint_Nmm.z * glm::cross(a, b)) / volume;
}

}  // namespace kerf
