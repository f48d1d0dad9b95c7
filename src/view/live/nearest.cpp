#include "view/live/nearest.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

namespace kerf {

std::optional<NearestPlace> FindNearest(const Tool& tool, const Pose& X_WT, const TriangleMesh& mesh_W) {
  if (mesh_W.points.empty()) return std::nullopt;
  const auto* disc = std::get_if<DiscSaw>(&tool);
  const double radius = disc != nullptr ? disc->radius_mm() : std::get<BallBurr>(tool).radius_mm();
  const double half = disc != nullptr ? 0.5 * disc->thickness_mm : 0;
  const glm::dmat3 R_TW = glm::mat3_cast(glm::conjugate(X_WT.R_AB));
  NearestPlace nearest{{}, std::numeric_limits<double>::infinity()};
  for (const Vec3& p_W : mesh_W.points) {
    const Vec3 p = R_TW * (p_W - X_WT.p_AB);
    double distance = glm::length(p) - radius;
    if (disc != nullptr) {
      const double out = std::hypot(p.x, p.y) - radius;
      const double above = std::abs(p.z) - half;
      distance = out > 0 && above > 0 ? std::hypot(out, above) : std::max(out, above);
    }
    if (distance < nearest.distance_mm) nearest = {p_W, distance};
  }
  return nearest;
}

AlarmLevel AlarmLevelFor(double distance_mm) {
  if (distance_mm < 1) return AlarmLevel::kDanger;
  if (distance_mm < 2) return AlarmLevel::kWarning;
  return distance_mm < 4 ? AlarmLevel::kNotice : AlarmLevel::kNone;
}

}  // namespace kerf
