#include "cut/contact/faces.h"
#include "cut/tool/shape.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kSlackVoxels = 0.002;  // clearance added on each side

}  // namespace

Faces::Faces(const BoneField& field, const ToolShape& shape, const Vec3& p_TC_mm)
    : slack_mm_(kSlackVoxels * field.voxel_mm()),
      voxel_mm_(field.voxel_mm()),
      tool_reach_mm_(shape.reach_mm),
      p_EC_(p_TC_mm),
      motion_(shape.motion),
      penetration_(shape.faces.size()) {
  for (std::size_t i = 0; i + 1 < shape.faces.size(); i += 2) {
    const Vec3& low_T = shape.faces[i].p_T;
    const Vec3& high_T = shape.faces[i + 1].p_T;
    const Vec3& n_T = shape.faces[i + 1].n_T;
    pairs_.push_back({0.5 * (low_T + high_T), n_T, 0.5 * glm::length(high_T - low_T),
                      shape.faces[i].touching == Touching::kStopped});
    are_flats_ = are_flats_ && n_T == Vec3(0, 0, 1);
  }
  clear_until_mm_.resize(pairs_.size(), -1);
  found_.reserve(2 * pairs_.size());
  seen_.reserve(pairs_.size());
  list_.Reserve(4 * pairs_.size());
  sampled_.resize(4 * pairs_.size());
}

void Faces::Find(const Probe& probe, double reach_mm, bool turning, StepProblem& problem) {
  problem.flats.clear();
  found_.clear();
  first_solid_ = problem.solids.size();
  travelled_mm_ += CalcTravel(X_looked_, probe.X_WT(), tool_reach_mm_);
  X_looked_ = probe.X_WT();
  seen_.clear();
  list_.Clear();
  const auto calc_cell_mm = [&](const Vec3& n_T) {
    const Vec3 n_W = probe.X_WT().Vector(n_T);
    return voxel_mm_ * (std::abs(n_W.x) + std::abs(n_W.y) + std::abs(n_W.z));
  };
  const double cell_of_flats_mm = calc_cell_mm({0, 0, 1});
  for (std::size_t j = 0; j < pairs_.size(); j += static_cast<std::size_t>(stride_)) {
    const Pair& pair = pairs_[j];
    if (travelled_mm_ < clear_until_mm_[j] || (pair.while_stopped && turning)) {
      penetration_.set_known_mm(static_cast<int>(2 * j), 0);
      penetration_.set_known_mm(static_cast<int>(2 * j + 1), 0);
      continue;
    }
    Seen seen{j};
    seen.cell_mm = are_flats_ ? cell_of_flats_mm : calc_cell_mm(pair.n_T);
    // Reach of a grid cell along the normal, less the distance from the kerf's middle to its wall.
    seen.in_mm = std::max(0.0, seen.cell_mm - pair.half_mm);
    const double z = pair.half_mm + seen.in_mm;
    list_.Add(pair.middle_T - z * pair.n_T);
    list_.Add(pair.middle_T + z * pair.n_T);
    if (seen.in_mm > 0) {
      list_.Add(pair.middle_T - pair.half_mm * pair.n_T);
      list_.Add(pair.middle_T + pair.half_mm * pair.n_T);
    }
    seen_.push_back(seen);
  }
  samples_ += list_.size();
  probe.Distances(list_, sampled_.data());
  SetDepthsOfSeen(reach_mm);
  const Quat R_TE = motion_.CalcTurn(slide_mm_);
  for (Seen& seen : seen_) {
    const Pair& pair = pairs_[seen.pair];
    const int low = static_cast<int>(2 * seen.pair);
    double* const depth = seen.depth_mm;
    const double clear_mm = -std::max(depth[0], depth[1]) - reach_mm - 2 * seen.in_mm;
    if (clear_mm > 0) clear_until_mm_[seen.pair] = travelled_mm_ + clear_mm / kMaxGradient;
    const double squeeze = std::min(depth[0], depth[1]);
    for (int side = 0; side < 2; ++side) {
      if (squeeze > 0) depth[side] -= squeeze;
      if (depth[side] <= -reach_mm) {
        penetration_.set_known_mm(low + side, 0);
        continue;
      }
      const double sign = side == 0 ? -1.0 : 1.0;
      const Vec3 from_C = pair.middle_T - p_EC_;
      const Vec3 middle = motion_.is_straight() ? from_C : R_TE * from_C;
      if (are_flats_) {
        problem.flats.push_back({sign, middle.x, middle.y, depth[side]});
      } else {
        problem.solids.push_back({MakeRow(sign * pair.n_T, middle + sign * pair.half_mm * pair.n_T), depth[side],
                                  problem.flat_stiffness_N_per_mm});
      }
      found_.push_back({low + side, depth[side]});
    }
  }
}

/// Sets the depths of the pairs seen from the samples inside the walls, and from those at the faces, if any.
///
/// A wall may be so thin that the sample inside it lies behind it. The depth is therefore the larger of two values: the
/// depth from the sample inside the wall, and the depth from the sample at the face, less the blur due to the kerf's
/// middle. Without a wall on the other side there is no kerf and therefore no blur.
void Faces::SetDepthsOfSeen(double reach_mm) {
  const double* sampled = sampled_.data();
  for (Seen& seen : seen_) {
    for (double& depth_mm : seen.depth_mm) depth_mm = -slack_mm_ - seen.in_mm - *sampled++;
    if (!(seen.in_mm > 0)) continue;
    // The ridge of the distances is interpolated between corners at most one cell apart along the normal. A face
    // therefore appears nearer to the bone than it is, by at most this amount.
    const double max_blur_mm = seen.in_mm * seen.in_mm / (2 * seen.cell_mm);
    const double open_mm = -2 * seen.in_mm;
    const double in_kerf[2] = {seen.depth_mm[1], seen.depth_mm[0]};  // depths of the opposite wall
    for (int side = 0; side < 2; ++side) {
      const double at_face_mm = *sampled++;
      if (seen.depth_mm[side] < open_mm - reach_mm) continue;  // no wall in reach
      const double blur_mm = max_blur_mm * std::clamp((in_kerf[side] - open_mm) / seen.in_mm, 0.0, 1.0);
      seen.depth_mm[side] = std::max(seen.depth_mm[side], -slack_mm_ - blur_mm - at_face_mm);
    }
  }
}

double Faces::SetDepths(StepProblem& problem, bool may_rise) {
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    double& depth_mm = are_flats_ ? problem.flats[n].depth_mm : problem.solids[first_solid_ + n].depth_mm;
    depth_mm = penetration_.Limit(found_[n].point, found_[n].depth_mm, problem.tau_s, may_rise);
    const double depth = std::max(depth_mm, 0.0);
    sum += depth * depth;
  }
  return 0.5 * problem.flat_stiffness_N_per_mm * sum;
}

double Faces::Remember(const StepProblem& problem, const Twist& u, double fraction) {
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    double depth_mm, speed_mm_per_s;
    if (are_flats_) {
      const FlatPoint& flat = problem.flats[n];
      depth_mm = flat.depth_mm;
      speed_mm_per_s = flat.side * (u[2] + u[3] * flat.y - u[4] * flat.x);
    } else {
      const SolidPoint& solid = problem.solids[first_solid_ + n];
      depth_mm = solid.depth_mm;
      speed_mm_per_s = Dot(solid.row, u);
    }
    const double depth = std::max(depth_mm + fraction * (problem.tau_s * speed_mm_per_s), 0.0);
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
