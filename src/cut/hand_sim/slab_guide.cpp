#include "cut/hand_sim/slab_guide.h"

#include <algorithm>
#include <cmath>

#include "cut/contact/probe.h"
#include "cut/removal/cutter.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kGuideStiffness_N_per_mm = 3000;  // at each of three points of the disc

double CalcLaw(const DiscSaw& saw, double depth_mm, PaperReading reading) {
  const double teeth = CalcPaperTeeth(saw, depth_mm, reading);
  return reading == PaperReading::kCorrected ? teeth : teeth * teeth * teeth;
}

}  // namespace

SlabGuide::SlabGuide(const Tool& tool, const Vec3& p_TC_mm, PaperReading reading) : p_TC_(p_TC_mm), reading_(reading) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) saw_ = *disc;
}

void SlabGuide::Begin(const Pose& X_WT, const Vec3& f_cut_T_N, double teeth, const Twist& u) {
  active_ = true;
  stopped_ = false;
  X_plane_ = X_WT;
  p_start_W_ = X_WT.p_AB;
  const Vec3 in_plane(f_cut_T_N.x, f_cut_T_N.y, 0);
  start_force_N_ = glm::length(in_plane);
  direction_W_ = X_WT.Vector(-in_plane / start_force_N_);
  rated_mm_per_s_ = std::max(kMinRated_mm_per_s, kMaxFeed * Dot(MakeRow(-in_plane / start_force_N_, -p_TC_), u));
  // Depth of an arc that has this number of teeth and is symmetric about the direction.
  const double half_angle = std::min(0.5 * teeth * saw_->pitch_mm() / saw_->radius_mm(), 3.14);
  start_depth_mm_ = saw_->radius_mm() * (1 - std::cos(half_angle));
  start_law_ = CalcLaw(*saw_, start_depth_mm_, reading_);
}

double SlabGuide::CalcDepth(const Pose& X_WT) const {
  return start_depth_mm_ + glm::dot(X_WT.p_AB - p_start_W_, direction_W_);
}

double SlabGuide::CalcResistance(double depth_mm) const {
  if (!(depth_mm > 0)) return 0;
  return start_law_ > 0 ? start_force_N_ * CalcLaw(*saw_, depth_mm, reading_) / start_law_ : start_force_N_;
}

Vec3 SlabGuide::Point(int i) const {
  constexpr double kHalf = 0.5, kRoot = 0.8660254037844386;
  const Vec3 directions[kPoints] = {{1, 0, 0}, {-kHalf, kRoot, 0}, {-kHalf, -kRoot, 0}};
  return 0.5 * saw_->radius_mm() * directions[i];
}

/// Returns the offset of point i of the tool from the guide's plane, along the plane's normal, mm.
double SlabGuide::CalcOffset(const Pose& X_WT, int i) const {
  return glm::dot(X_plane_.Vector({0, 0, 1}), X_WT.Point(Point(i)) - X_plane_.p_AB);
}

void SlabGuide::AddTo(const Pose& X_WT, double fraction, StepProblem& problem) const {
  if (!(fraction > 0)) return;
  for (int i = 0; i < kPoints; ++i) {
    const Twist row = MakeRow({0, 0, 1}, Point(i) - p_TC_);
    const double offset = CalcOffset(X_WT, i);
    for (const double sign : {1.0, -1.0}) {
      Twist towards{};
      kerf::AddTo(towards, sign, row);
      problem.solids.push_back({towards, sign * offset, fraction * kGuideStiffness_N_per_mm});
    }
  }
  const Vec3 d_T = X_WT.InverseVector(direction_W_);
  if (stopped_) {
    problem.solids.push_back(
        {MakeRow(d_T, -p_TC_), CalcDepth(X_WT) - stopped_depth_mm_, fraction * kGuideStiffness_N_per_mm});
    return;
  }
  const double force_N = fraction * CalcResistance(CalcDepth(X_WT));
  if (!(force_N > 0)) return;
  problem.yields.push_back({MakeRow(d_T, -p_TC_), force_N, rated_mm_per_s_});
  problem.frictions.push_back({MakeRow(glm::cross(Vec3(0, 0, 1), d_T), -p_TC_), Twist{}, 0, 0, force_N});
}

double SlabGuide::CalcEnergy(const Pose& X_WT, double fraction) const {
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double offset = CalcOffset(X_WT, i);
    sum += offset * offset;
  }
  if (stopped_) {
    const double deeper = std::max(0.0, CalcDepth(X_WT) - stopped_depth_mm_);
    sum += deeper * deeper;
  }
  return 0.5 * fraction * kGuideStiffness_N_per_mm * sum;
}

PassedPath::PassedPath() {
  poses_.reserve(kMaxPoses);
}

void PassedPath::Forget() {
  poses_.clear();
  next_ = 0;
  done_ = 0;
  thinning_ = 1;
}

void PassedPath::PutBack() {
  next_ = last_next_;
  done_ = last_done_;
}

void PassedPath::Record(const Pose& X_WT, double spacing_mm) {
  constexpr double kReach_mm = 10;  // radius at which rotation is converted to distance
  if (!poses_.empty() && CalcTravel(poses_.back(), X_WT, kReach_mm) < thinning_ * spacing_mm) return;
  if (poses_.size() == kMaxPoses) {
    std::size_t kept = 0;
    for (std::size_t i = next_; i < poses_.size(); i += i == next_ ? 1 : 2) poses_[kept++] = poses_[i];
    poses_.resize(kept);
    next_ = 0;
    thinning_ *= 2;
  }
  poses_.push_back(X_WT);
}

bool PassedPath::Next(const Tool& tool, double voxel_mm, Pose& from, Pose& to) {
  if (empty()) {
    Forget();
    return false;
  }
  last_next_ = next_;
  last_done_ = done_;
  const Pose& a = poses_[next_];
  const Pose& b = poses_[next_ + 1];
  from = Interpolate(a, b, done_);
  const double fraction = done_ + 1 / CountSubsteps(a, b, tool, voxel_mm);
  done_ = fraction < 1 ? fraction : 0;
  to = fraction < 1 ? Interpolate(a, b, fraction) : b;
  if (fraction >= 1) ++next_;
  return true;
}

}  // namespace kerf
