#include "bone/pieces/measure.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {
double CalcDistance(const Vec3& a_W, const Vec3& b_W) {
  return glm::length(b_W - a_W);
}

std::optional<double> CalcAngle(const Vec3& a_W, const Vec3& corner_W, const Vec3& b_W) {
  const std::optional<Vec3> u = CalcDirection(a_W - corner_W);
  const std::optional<Vec3> v = CalcDirection(b_W - corner_W);
  if (!u || !v) return {};
  return kDegreesPerRad * std::atan2(glm::length(glm::cross(*u, *v)), glm::dot(*u, *v));
}

double CalcAngle(const CutPlane& a, const CutPlane& b) {
  return kDegreesPerRad *
         std::atan2(glm::length(glm::cross(a.normal_W, b.normal_W)), std::abs(glm::dot(a.normal_W, b.normal_W)));
}

double CalcDistance(const Vec3& p_W, const CutPlane& plane) {
  return glm::dot(plane.normal_W, p_W - plane.p_W);
}

double CalcRotationAngle(const Pose& X) {
  const Quat& q = X.R_AB;
  return 2 * kDegreesPerRad * std::atan2(glm::length(Vec3(q.x, q.y, q.z)), std::abs(q.w));
}

}  // namespace kerf
