#include "cut/contact/faces.h"
#include "cut/tool/shape.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kSlackVoxels = 0.002;  // clearance added on each side

}  // namespace

Faces::Faces(const BoneField& field, const ToolShape& shape, const Tool& tool, const Vec3& p_TC_mm)
    : half_mm_(0.5 * CalcThickness(tool)),
      slack_mm_(kSlackVoxels * field.voxel_mm()),
      voxel_mm_(field.voxel_mm()),
      tool_reach_mm_(shape.reach_mm),
      p_TC_(p_TC_mm),
      penetration_(shape.faces.size()) {
  for (std::size_t i = 0; i + 1 < shape.faces.size(); i += 2) {
    const Vec3& p = shape.faces[i].p_T;
    pairs_.push_back({p.x, p.y, shape.faces[i].while_stopped});
  }
  clear_until_mm_.resize(pairs_.size(), -1);
  found_.reserve(2 * pairs_.size());
}

void Faces::Find(const Probe& probe, double reach_mm, bool turning, StepProblem& problem) {
  problem.flats.clear();
  found_.clear();
  travelled_mm_ += CalcTravel(X_looked_, probe.X_WT(), tool_reach_mm_);
  X_looked_ = probe.X_WT();
  // Reach of a grid cell along the normal, less the distance from the kerf's middle to its wall.
  const Vec3 normal_W = probe.X_WT().Vector({0, 0, 1});
  const double cell_mm = voxel_mm_ * (std::abs(normal_W.x) + std::abs(normal_W.y) + std::abs(normal_W.z));
  const double in_mm = std::max(0.0, cell_mm - half_mm_);
  // The ridge of the distances is interpolated between corners at most one cell apart along the normal. A flat
  // therefore appears nearer to the bone than it is, by at most this amount.
  const double max_blur_mm = in_mm * in_mm / (2 * cell_mm);
  for (std::size_t j = 0; j < pairs_.size(); j += static_cast<std::size_t>(stride_)) {
    const int low = static_cast<int>(2 * j);
    const Pair& pair = pairs_[j];
    if (travelled_mm_ < clear_until_mm_[j] || (pair.while_stopped && turning)) {
      penetration_.set_known_mm(low, 0);
      penetration_.set_known_mm(low + 1, 0);
      continue;
    }
    const double z = half_mm_ + in_mm;
    double depth[2] = {-slack_mm_ - in_mm - probe.Distance({pair.x, pair.y, -z}),
                       -slack_mm_ - in_mm - probe.Distance({pair.x, pair.y, z})};
    // A wall may be so thin that the sample inside it lies behind it. The depth is therefore the larger of two values:
    // the depth from the sample inside the wall, and the depth from the sample at the flat, less the blur due to the
    // kerf's middle. Without a wall on the other side there is no kerf and therefore no blur.
    const double open_mm = -2 * in_mm;
    const double in_kerf[2] = {depth[1], depth[0]};  // depths of the opposite wall
    for (int side = 0; in_mm > 0 && side < 2; ++side) {
      if (depth[side] < open_mm - reach_mm) continue;
      const double blur_mm = max_blur_mm * std::clamp((in_kerf[side] - open_mm) / in_mm, 0.0, 1.0);
      depth[side] = std::max(depth[side],
                             -slack_mm_ - blur_mm - probe.Distance({pair.x, pair.y, side == 0 ? -half_mm_ : half_mm_}));
    }
    const double clear_mm = -std::max(depth[0], depth[1]) - reach_mm + open_mm;
    if (clear_mm > 0) clear_until_mm_[j] = travelled_mm_ + clear_mm / kMaxGradient;
    const double squeeze = std::min(depth[0], depth[1]);
    for (int side = 0; side < 2; ++side) {
      if (squeeze > 0) depth[side] -= squeeze;
      if (depth[side] <= -reach_mm) {
        penetration_.set_known_mm(low + side, 0);
        continue;
      }
      problem.flats.push_back({side == 0 ? -1.0 : 1.0, pair.x - p_TC_.x, pair.y - p_TC_.y, depth[side]});
      found_.push_back({low + side, depth[side]});
    }
  }
}

double Faces::SetDepths(StepProblem& problem, bool may_rise) {
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    FlatPoint& flat = problem.flats[n];
    flat.depth_mm = penetration_.Limit(found_[n].point, found_[n].depth_mm, problem.tau_s, may_rise);
    const double depth = std::max(flat.depth_mm, 0.0);
    sum += depth * depth;
  }
  return 0.5 * problem.flat_stiffness_N_per_mm * sum;
}

double Faces::Remember(const StepProblem& problem, const Twist& u, double fraction) {
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    const FlatPoint& flat = problem.flats[n];
    const double motion_mm = problem.tau_s * flat.side * (u[2] + u[3] * flat.y - u[4] * flat.x);
    const double depth = std::max(flat.depth_mm + fraction * motion_mm, 0.0);
    penetration_.set_known_mm(found_[n].point, depth);
    sum += depth * depth;
  }
  return 0.5 * problem.flat_stiffness_N_per_mm * sum;
}

void Faces::Release() {
  penetration_.Forget();
}

void Faces::Forget() {
  Release();
  std::fill(clear_until_mm_.begin(), clear_until_mm_.end(), -1.0);
  travelled_mm_ = 0;
}

}  // namespace kerf
