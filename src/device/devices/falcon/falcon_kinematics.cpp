#include "device/devices/falcon/falcon_kinematics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/core/vectors.h"

namespace kerf {
namespace {

// Dimensions in Stamper's notation, mm.
constexpr double kThigh = 60;        // a: motor arm
constexpr double kShin = 102.5;      // b: side of the parallelogram
constexpr double kEnds = 2 * 11.25;  // d + e: parts of the shin beyond the parallelogram
constexpr double kU = 14.43 - 40;    // c - r: from the base of a leg to the grip, outwards
constexpr double kV = 23.09 - 25;    // f - s: the same, across
constexpr double kDegree = 6.283185307179586 / 360;
constexpr std::array<double, 3> kAzimuth = {105 * kDegree, -15 * kDegree, -135 * kDegree};

struct LegFrame {
  double cos_phi = 0;
  double sin_phi = 0;
};

const std::array<LegFrame, 3> kLegs = {LegFrame{std::cos(kAzimuth[0]), std::sin(kAzimuth[0])},
                                       LegFrame{std::cos(kAzimuth[1]), std::sin(kAzimuth[1])},
                                       LegFrame{std::cos(kAzimuth[2]), std::sin(kAzimuth[2])}};

/// End of the shin in the frame of a leg's arm: u outwards, v across, w towards the user.
struct LegPoint {
  double u = 0;
  double v = 0;
  double w = 0;
};

LegPoint CalcLegPoint(const LegFrame& leg, const Vec3& p_D_mm) {
  return {leg.cos_phi * p_D_mm.x + leg.sin_phi * p_D_mm.y + kU, -leg.sin_phi * p_D_mm.x + leg.cos_phi * p_D_mm.y + kV,
          p_D_mm.z + kFalconMiddle_mm};
}

Vec3 CalcInD(const LegFrame& leg, double u, double v, double w) {
  return {leg.cos_phi * u - leg.sin_phi * v, leg.sin_phi * u + leg.cos_phi * v, w};
}

/// Returns the squared length of the parallelogram's projection onto the plane of the arm. Negative if the leg cannot
/// reach the position.
double CalcSquareInPlane(double v) {
  return kShin * kShin - v * v;
}

struct KneeGap {
  double gap_mm = 0;  // distance from the knee to the end of the shin, minus the shin's length
  Vec3 gradient_D;
};

std::optional<KneeGap> CalcKneeGap(const LegFrame& leg, const Vec3& p_D_mm, double angle) {
  const LegPoint at = CalcLegPoint(leg, p_D_mm);
  const double square = CalcSquareInPlane(at.v);
  if (!(square > 1)) return std::nullopt;
  const double in_plane = std::sqrt(square);
  const double du = at.u - kThigh * std::cos(angle);
  const double dw = at.w - kThigh * std::sin(angle);
  const double distance = std::hypot(du, dw);
  if (!(distance > 1)) return std::nullopt;
  return KneeGap{distance - kEnds - in_plane, CalcInD(leg, du / distance, at.v / in_plane, dw / distance)};
}

/// Returns the approximate grip position when all legs have this angle; it lies on the axis.
Vec3 CalcOnAxis(double angle) {
  const double length = kEnds + std::sqrt(CalcSquareInPlane(kV));
  const double du = kU - kThigh * std::cos(angle);
  return {0, 0, kThigh * std::sin(angle) + std::sqrt(std::max(length * length - du * du, 0.0)) - kFalconMiddle_mm};
}

}  // namespace

FalconAngles CalcFalconAngles(const FalconCounts& counts) noexcept {
  FalconAngles angles{};
  for (std::size_t i = 0; i < 3; ++i) angles[i] = kFalconAngleOfZero_rad + kFalconRadPerCount * counts[i];
  return angles;
}

FalconCounts CalcFalconCounts(const FalconAngles& angles) noexcept {
  FalconCounts counts{};
  for (std::size_t i = 0; i < 3; ++i) {
    counts[i] = static_cast<int>(std::lround((angles[i] - kFalconAngleOfZero_rad) / kFalconRadPerCount));
  }
  return counts;
}

std::optional<FalconAngles> CalcFalconAnglesAt(const Vec3& p_D_mm) noexcept {
  FalconAngles angles{};
  for (std::size_t i = 0; i < 3; ++i) {
    const LegPoint at = CalcLegPoint(kLegs[i], p_D_mm);
    const double square = CalcSquareInPlane(at.v);
    if (!(square >= 0)) return std::nullopt;
    const double length = kEnds + std::sqrt(square);
    const double distance = std::hypot(at.u, at.w);
    // Law of cosines in the triangle of shoulder, knee and end of the shin. There are two solutions; the one with the
    // knee further out is used.
    const double cosine = (distance * distance + kThigh * kThigh - length * length) / (2 * kThigh * distance);
    if (!(std::abs(cosine) <= 1)) return std::nullopt;
    angles[i] = std::atan2(at.w, at.u) - std::acos(cosine);
  }
  return angles;
}

std::optional<glm::dmat3> CalcFalconJacobian(const Vec3& p_D_mm) noexcept {
  const std::optional<FalconAngles> angles = CalcFalconAnglesAt(p_D_mm);
  if (!angles) return std::nullopt;
  glm::dmat3 J(0);
  for (std::size_t i = 0; i < 3; ++i) {
    // The gap remains zero, so its changes due to the angle and due to the position cancel.
    const double angle = (*angles)[i];
    const std::optional<KneeGap> knee = CalcKneeGap(kLegs[i], p_D_mm, angle);
    if (!knee) return std::nullopt;
    const LegPoint at = CalcLegPoint(kLegs[i], p_D_mm);
    const double du = at.u - kThigh * std::cos(angle);
    const double dw = at.w - kThigh * std::sin(angle);
    const double with_angle = kThigh * (du * std::sin(angle) - dw * std::cos(angle)) / std::hypot(du, dw);
    if (!(std::abs(with_angle) > 1e-3 * kThigh)) return std::nullopt;
    for (int k = 0; k < 3; ++k) J[k][static_cast<int>(i)] = -knee->gradient_D[k] / with_angle;
  }
  return J;
}

std::optional<Vec3> CalcFalconTorques(const Vec3& p_D_mm, const Vec3& f_D_N) noexcept {
  const std::optional<glm::dmat3> J = CalcFalconJacobian(p_D_mm);
  if (!J) return std::nullopt;
  const double size = std::max({glm::length((*J)[0]), glm::length((*J)[1]), glm::length((*J)[2])});
  if (!(std::abs(glm::determinant(*J)) > 1e-6 * size * size * size)) return std::nullopt;
  const Vec3 tau_Nmm = glm::inverse(glm::transpose(*J)) * f_D_N;
  if (!IsFinite(tau_Nmm)) return std::nullopt;
  return tau_Nmm;
}

std::optional<Vec3> CalcFalconForce(const Vec3& p_D_mm, const Vec3& tau_Nmm) noexcept {
  const std::optional<glm::dmat3> J = CalcFalconJacobian(p_D_mm);
  if (!J) return std::nullopt;
  return glm::transpose(*J) * tau_Nmm;
}

bool FalconForward::Solve(const FalconAngles& angles) noexcept {
  constexpr int kMaxSteps = 30;
  constexpr double kLongestStep_mm = 20;
  constexpr double kSmallStep_mm = 1e-10;
  // This box is far larger than the workspace; only mirrored solutions lie beyond it.
  constexpr double kFarthest_mm = 110;
  constexpr double kSame_rad = 1e-9;
  const double average = (angles[0] + angles[1] + angles[2]) / 3;
  if (!std::isfinite(average)) return false;
  steps_ = 0;
  for (const bool from_last : {true, false}) {
    Vec3 p = from_last ? p_D_mm_ : CalcOnAxis(average);
    for (int step = 0; step < kMaxSteps; ++step) {
      ++steps_;
      glm::dmat3 gradient(0);
      Vec3 gap{0};
      bool reaches = true;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::optional<KneeGap> knee = CalcKneeGap(kLegs[i], p, angles[i]);
        if (!knee) {
          reaches = false;
          break;
        }
        gap[static_cast<int>(i)] = knee->gap_mm;
        for (int k = 0; k < 3; ++k) gradient[k][static_cast<int>(i)] = knee->gradient_D[k];
      }
      if (!reaches || !(std::abs(glm::determinant(gradient)) > 1e-6)) break;
      Vec3 correction = -(glm::inverse(gradient) * gap);
      const double length = glm::length(correction);
      if (!std::isfinite(length)) break;
      if (length > kLongestStep_mm) correction *= kLongestStep_mm / length;
      p += correction;
      if (length > kSmallStep_mm) continue;
      if (!(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < kFarthest_mm)) break;
      // Reject solutions with a knee on the wrong side.
      const std::optional<FalconAngles> back = CalcFalconAnglesAt(p);
      if (!back) break;
      double worst = 0;
      for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, std::abs((*back)[i] - angles[i]));
      if (!(worst < kSame_rad)) break;
      p_D_mm_ = p;
      return true;
    }
  }
  return false;
}

}  // namespace kerf
