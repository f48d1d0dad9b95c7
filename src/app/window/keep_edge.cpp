#include "app/window/keep_edge.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "bone/grid/removed.h"
#include "cut/tool/shape.h"
#include "session/run/clear_pose.h"

namespace kerf {
namespace {

/// Air that is left between the tool and the bone, in voxels.
constexpr double kClear_vox = 1;

enum class Form { kDisc, kStroke, kAxis };

Form FormOf(const Tool& tool) {
  if (CalcStroke(tool) > 0) return Form::kStroke;
  return IsBlade(tool) ? Form::kDisc : Form::kAxis;
}

/// Returns the direction in which a tool goes into the bone, tool frame, unit length: of a disc, that of the point of
/// its rim that is nearest to the bone.
Vec3 FindInto(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const Form form = FormOf(tool);
  if (form != Form::kDisc) return form == Form::kStroke ? Vec3(1, 0, 0) : Vec3(0, 0, -1);
  const PhiSampler phi(bone);
  const Vec3 middle_W = bone.CalcBounds().centre();
  constexpr double kSlightly = 1e-6;  // phi is the same at all points that are far from the bone
  Vec3 into_T{1, 0, 0};
  double least = 1e300;
  for (const EdgePoint& point : MakeToolShape(tool, {}).edge) {
    const Vec3 p_W = X_WT.Point(point.p_T);
    const double value = phi.Calc(p_W) + kSlightly * glm::distance(p_W, middle_W);
    if (value >= least) continue;
    least = value;
    into_T = point.e_T;
  }
  return into_T;
}

/// Returns the point of the edge that lies furthest in the direction into the bone, tool frame.
Vec3 FindEdge(const Tool& tool, const Vec3& into_T) {
  return FormOf(tool) == Form::kDisc ? CalcRadius(tool) * into_T : FindDeepest(tool, into_T);
}

}  // namespace

Pose KeepEdge(const Bone& bone, const Tool& from, const Pose& X_WF, const Tool& to) {
  const Vec3 into_F = FindInto(bone, from, X_WF);
  const Vec3 into_W = X_WF.Vector(into_F);
  Pose X_WT = X_WF;
  const Form form = FormOf(to);
  if (form != FormOf(from)) {
    const Vec3 across_W = X_WF.Vector(FormOf(from) == Form::kAxis ? Vec3(1, 0, 0) : Vec3(0, 0, 1));
    const Vec3 x_W = form == Form::kAxis ? across_W : into_W;
    const Vec3 z_W = form == Form::kAxis ? -into_W : across_W;
    X_WT.R_AB = glm::normalize(glm::quat_cast(glm::dmat3(x_W, glm::cross(z_W, x_W), z_W)));
  }
  X_WT.p_AB = X_WF.Point(FindEdge(from, into_F)) - X_WT.Vector(FindEdge(to, X_WT.InverseVector(into_W)));
  const PhiSampler phi(bone);
  const double margin_mm = kClear_vox * bone.voxel_mm();
  if (IsClear(phi, to, X_WT, margin_mm)) return X_WT;
  const Box3 bounds_W = bone.CalcBounds();
  return FindNearestClearPose(phi, to, X_WT, bounds_W.centre(), margin_mm,
                              glm::length(bounds_W.size()) + 2 * CalcReach(to));
}

}  // namespace kerf
