#include "session/scene/exercise.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "kerf/error.h"

namespace kerf {

WantedCut MakeWantedCut(const SceneExercise& exercise, const Tool& tool) {
  WantedCut cut;
  cut.start_W = exercise.start_mm;
  const std::optional<Vec3> along = CalcDirection(exercise.end_mm - exercise.start_mm);
  if (!along) throw Error("[exercise] the line has no length: end_mm equals start_mm");
  cut.along_W = *along;
  const std::optional<Vec3> into = CalcDirection(exercise.into);
  const Vec3 aside = into ? *into - glm::dot(*into, cut.along_W) * cut.along_W : Vec3(0);
  if (!(glm::length(aside) > 1e-6)) {
    throw Error("[exercise] into has no component across the line from start_mm to end_mm");
  }
  cut.into_W = glm::normalize(aside);
  cut.across_W = glm::cross(cut.along_W, cut.into_W);
  cut.length_mm = glm::distance(exercise.start_mm, exercise.end_mm);
  cut.depth_mm = exercise.depth_mm;
  cut.margin_mm = exercise.margin_mm;
  cut.radius_mm = CalcRadius(tool);
  cut.is_blade = IsBlade(tool);
  cut.thickness_mm = CalcCutWidth(tool);
  return cut;
}

Pose WantedCut::CalcToolPose(double s_mm, double t_mm) const {
  const glm::dmat3 axes(along_W, glm::cross(across_W, along_W), across_W);
  return {glm::normalize(glm::quat_cast(axes)), ToWorld({s_mm, t_mm - radius_mm, 0})};
}

double WantedCut::CalcDistance(const Vec3& p_W) const {
  const Vec3 p = ToCut(p_W);
  const double s = p.x - std::clamp(p.x, 0.0, length_mm);
  // The tool has also passed through everything above the path of its centre.
  const double t = std::max(p.y - (depth_mm - radius_mm), 0.0);
  if (!is_blade) return std::sqrt(s * s + t * t + p.z * p.z) - radius_mm;
  const double in_plane = std::hypot(s, t) - radius_mm;
  const double across = std::abs(p.z) - 0.5 * thickness_mm;
  if (in_plane <= 0 || across <= 0) return std::max(in_plane, across);
  return std::hypot(in_plane, across);
}

}  // namespace kerf
