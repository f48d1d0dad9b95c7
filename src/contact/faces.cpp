#include "contact/faces.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFrictionLag_s = 0.004;
constexpr double kSlackVoxels = 0.002;  // of play on each side

/// What presses a disc's rim aside by half its thickness, N. Plate bending about a flange: about 0.45 E t^3 / R^2 of
/// stiffness, an estimate good to some tens of percent.
double CalcBendingForce(const Tool& tool) {
  const auto* disc = std::get_if<DiscSaw>(&tool);
  if (!disc) return 0;
  const double t = disc->thickness_mm;
  return 0.45 * disc->E_MPa * t * t * t / (disc->radius_mm() * disc->radius_mm()) * 0.5 * t;
}

double CalcThickness(const Tool& tool) {
  const auto* disc = std::get_if<DiscSaw>(&tool);
  return disc ? disc->thickness_mm : 0;
}

}  // namespace

Faces::Faces(const BoneField& field, const ToolShape& shape, const Tool& tool, const Vec3& p_TC_mm)
    : half_mm_(0.5 * CalcThickness(tool)),
      most_couple_N_(2 * CalcBendingForce(tool)),
      slack_mm_(kSlackVoxels * field.voxel_mm()),
      voxel_mm_(field.voxel_mm()),
      tool_reach_mm_(shape.reach_mm),
      p_TC_(p_TC_mm),
      push_out_(shape.faces.size()),
      patches_(kPatches) {
  for (std::size_t i = 0; i + 1 < shape.faces.size(); i += 2) {
    const Vec3& p = shape.faces[i].p_T;
    const double turn = std::atan2(p.y, p.x) / (2 * kPi) + 0.5;
    const int sector = std::min(static_cast<int>(turn * kSectors), kSectors - 1);
    const int ring = std::min(static_cast<int>(std::hypot(p.x, p.y) / shape.reach_mm * kRings), kRings - 1);
    pairs_.push_back({p.x, p.y, ring * kSectors + sector, shape.faces[i].while_stopped});
  }
  clear_until_mm_.resize(pairs_.size(), -1);
  found_.reserve(2 * pairs_.size());
}

void Faces::Find(const Probe& probe, double reach_mm, double friction_coefficient, double spindle_rad_per_s,
                 StepProblem& problem) {
  problem.flats.clear();
  found_.clear();
  travelled_mm_ += CalcTravel(X_looked_, probe.X_WT(), tool_reach_mm_);
  X_looked_ = probe.X_WT();
  // How far a cell of the grid can reach along the normal, less how far the wall is from the kerf's middle.
  const Vec3 normal_W = probe.X_WT().Vector({0, 0, 1});
  const double cell_mm = voxel_mm_ * (std::abs(normal_W.x) + std::abs(normal_W.y) + std::abs(normal_W.z));
  const double in_mm = std::max(0.0, cell_mm - half_mm_);
  // Interpolated between corners at most a cell apart along the normal, the ridge of distances in the middle comes out
  // nearer to the bone at a flat by at most this.
  const double most_blur_mm = in_mm * in_mm / (2 * cell_mm);
  for (std::size_t j = 0; j < pairs_.size(); j += static_cast<std::size_t>(stride_)) {
    const int low = static_cast<int>(2 * j);
    const Pair& pair = pairs_[j];
    if (travelled_mm_ < clear_until_mm_[j] || (pair.while_stopped && spindle_rad_per_s != 0)) {
      push_out_.set_known_mm(low, 0);
      push_out_.set_known_mm(low + 1, 0);
      continue;
    }
    const double z = half_mm_ + in_mm;
    double depth[2] = {-slack_mm_ - in_mm - probe.Distance({pair.x, pair.y, -z}),
                       -slack_mm_ - in_mm - probe.Distance({pair.x, pair.y, z})};
    // A wall may be so thin that a look into it comes out behind: the nearer of that and what lies at the flat itself
    // is the wall, the latter less what the kerf's middle may blur it by. Where there is no wall on the other side
    // there is no kerf whose middle could.
    const double open_mm = -2 * in_mm;
    const double in_kerf[2] = {depth[1], depth[0]};  // how near the other wall is
    for (int side = 0; in_mm > 0 && side < 2; ++side) {
      if (depth[side] < open_mm - reach_mm) continue;
      const double blur_mm = most_blur_mm * std::clamp((in_kerf[side] - open_mm) / in_mm, 0.0, 1.0);
      depth[side] = std::max(depth[side],
                             -slack_mm_ - blur_mm - probe.Distance({pair.x, pair.y, side == 0 ? -half_mm_ : half_mm_}));
    }
    const double clear_mm = -std::max(depth[0], depth[1]) - reach_mm + open_mm;
    if (clear_mm > 0) clear_until_mm_[j] = travelled_mm_ + clear_mm / kSteepest;
    const double squeeze = std::min(depth[0], depth[1]);
    for (int side = 0; side < 2; ++side) {
      if (squeeze > 0) depth[side] -= squeeze;
      if (depth[side] <= -reach_mm) {
        push_out_.set_known_mm(low + side, 0);
        continue;
      }
      problem.flats.push_back({side == 0 ? -1.0 : 1.0, pair.x - p_TC_.x, pair.y - p_TC_.y, depth[side]});
      found_.push_back({low + side, depth[side]});
    }
  }
  for (std::size_t n = 0; n < patches_.size(); ++n) {
    const Patch& patch = patches_[n];
    const double limit_N = friction_coefficient * patch.force_N;
    if (!(limit_N > 0)) continue;
    const Vec3 p_T(patch.x_N / patch.force_N, patch.y_N / patch.force_N,
                   n < patches_.size() / 2 ? -half_mm_ : half_mm_);
    problem.frictions.push_back({MakeRow({1, 0, 0}, p_T - p_TC_), MakeRow({0, 1, 0}, p_T - p_TC_),
                                 -spindle_rad_per_s * p_T.y, spindle_rad_per_s * p_T.x, limit_N});
  }
}

double Faces::SetDepths(StepProblem& problem, bool may_rise) {
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    FlatPoint& flat = problem.flats[n];
    flat.depth_mm = push_out_.Limit(found_[n].point, found_[n].depth_mm, problem.tau_s, may_rise);
    const double depth = std::max(flat.depth_mm, 0.0);
    sum += depth * depth;
  }
  return 0.5 * problem.flat_stiffness_N_per_mm * sum;
}

double Faces::Remember(const StepProblem& problem, const Twist& u, double share) {
  // The friction of the next step goes by forces that follow these with a lag: a tool that friction throws off the wall
  // and that falls back without it would else do so in every tick.
  const double fresh = 1 - std::exp(-share * problem.tau_s / kFrictionLag_s);
  for (Patch& patch : patches_) {
    patch.force_N *= 1 - fresh;
    patch.x_N *= 1 - fresh;
    patch.y_N *= 1 - fresh;
  }
  const double share_borne = CalcShareBorne(problem, u);
  double sum = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    const FlatPoint& flat = problem.flats[n];
    const double way = problem.tau_s * flat.side * (u[2] + u[3] * flat.y - u[4] * flat.x);
    const double depth = std::max(flat.depth_mm + share * way, 0.0);
    push_out_.set_known_mm(found_[n].point, depth);
    sum += depth * depth;
    const double at_end = flat.depth_mm + way;
    if (!(at_end > 0)) continue;
    const Pair& pair = pairs_[static_cast<std::size_t>(found_[n].point / 2)];
    const int index = pair.patch + (flat.side > 0 ? kSectors * kRings : 0);
    Patch& patch = patches_[static_cast<std::size_t>(index)];
    const double force = fresh * share_borne * problem.flat_stiffness_N_per_mm * at_end;
    patch.force_N += force;
    patch.x_N += force * pair.x;
    patch.y_N += force * pair.y;
  }
  return 0.5 * problem.flat_stiffness_N_per_mm * sum;
}

double Faces::CalcShareBorne(const StepProblem& problem, const Twist& u) const {
  const auto depth = [&](const FlatPoint& p) {
    return std::max(0.0, p.depth_mm + problem.tau_s * p.side * (u[2] + u[3] * p.y - u[4] * p.x));
  };
  double gross = 0, x = 0, y = 0;
  for (const FlatPoint& p : problem.flats) {
    const double d = depth(p);
    gross += d;
    x += d * p.x;
    y += d * p.y;
  }
  if (!(gross > 0)) return 0;
  x /= gross;
  y /= gross;
  double net = 0, moment_x = 0, moment_y = 0, spread = 0;
  for (const FlatPoint& p : problem.flats) {
    const double d = depth(p);
    net += p.side * d;
    moment_x += p.side * d * (p.y - y);
    moment_y += p.side * d * (p.x - x);
    spread += d * std::hypot(p.x - x, p.y - y);
  }
  const double turning = spread > 0 ? gross * std::hypot(moment_x, moment_y) / spread : 0;
  const double passed_on = std::min(turning, most_couple_N_ / problem.flat_stiffness_N_per_mm);
  return std::min(1.0, (std::abs(net) + passed_on) / gross);
}

void Faces::Release() {
  push_out_.Forget();
  for (Patch& patch : patches_) patch = {};
}

void Faces::Forget() {
  Release();
  std::fill(clear_until_mm_.begin(), clear_until_mm_.end(), -1.0);
  travelled_mm_ = 0;
}

}  // namespace kerf
