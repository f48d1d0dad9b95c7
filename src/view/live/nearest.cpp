#include "view/live/nearest.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "cut/tool/shape.h"

namespace kerf {

std::optional<NearestPlace> FindNearest(const Tool& tool, const Pose& X_WT, const TriangleMesh& mesh_W) {
  if (mesh_W.points.empty()) return std::nullopt;
  const glm::dmat3 R_TW = glm::mat3_cast(glm::conjugate(X_WT.R_AB));
  NearestPlace nearest{{}, std::numeric_limits<double>::infinity()};
  for (const Vec3& p_W : mesh_W.points) {
    const Vec3 p = R_TW * (p_W - X_WT.p_AB);
    const double distance = CalcSignedToolDistance(tool, p);
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
