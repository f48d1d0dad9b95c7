#include "session/scene/path.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <utility>

namespace kerf {
namespace {

/// If the sine of the angle between feed and normal is below this, the feed has no direction in the disc's plane.
constexpr double kAlongNormal = 1e-6;

Vec3 ProjectOntoPlane(const Vec3& v, const Vec3& nhat) {
  return v - glm::dot(v, nhat) * nhat;
}

/// Returns the world axis furthest from nhat, projected into the plane with this normal.
Vec3 AnyDirectionInPlane(const Vec3& nhat) {
  const Vec3 size = glm::abs(nhat);
  const Vec3 axis = size.x <= size.y && size.x <= size.z ? Vec3{1, 0, 0}
                    : size.y <= size.z                   ? Vec3{0, 1, 0}
                                                         : Vec3{0, 0, 1};
  return glm::normalize(ProjectOntoPlane(axis, nhat));
}

Quat CalcStrokeRotation(const SceneStroke& stroke) {
  const Vec3 zhat = glm::normalize(stroke.disc_normal);
  const Vec3 travel = stroke.end_mm - stroke.start_mm;
  const Vec3 in_plane = ProjectOntoPlane(travel, zhat);
  const bool has_direction = glm::length(in_plane) > kAlongNormal * glm::length(travel);
  const Vec3 xhat = has_direction ? glm::normalize(in_plane) : AnyDirectionInPlane(zhat);
  return glm::normalize(glm::quat_cast(glm::dmat3(xhat, glm::cross(zhat, xhat), zhat)));
}

}  // namespace

void Path::AddSegment(const std::vector<TimedPose>& knots, bool retract_before) {
  segments_.push_back({knots.front().time_s, knots.back().time_s, retract_before});
  for (std::size_t i = 1; i < knots.size(); ++i)
    length_mm_ += glm::distance(knots[i - 1].X_WT.p_AB, knots[i].X_WT.p_AB);
  knots_.push_back(knots);
}

Pose Path::CalcPose(std::size_t segment, double t_s) const {
  const std::vector<TimedPose>& knots = knots_.at(segment);
  if (!(t_s > knots.front().time_s)) return knots.front().X_WT;
  if (t_s >= knots.back().time_s) return knots.back().X_WT;
  const auto after = std::upper_bound(knots.begin(), knots.end(), t_s,
                                      [](double t, const TimedPose& knot) { return t < knot.time_s; });
  const TimedPose& a = *(after - 1);
  const TimedPose& b = *after;
  const double fraction = (t_s - a.time_s) / (b.time_s - a.time_s);
  return {glm::normalize(glm::slerp(a.X_WT.R_AB, b.X_WT.R_AB, fraction)),
          a.X_WT.p_AB + fraction * (b.X_WT.p_AB - a.X_WT.p_AB)};
}

std::size_t Path::CountTicks(std::size_t segment, double rate_hz) const {
  const double ticks = (segments_.at(segment).end_s - segments_.at(segment).start_s) * rate_hz;
  // Rounding must not add a tick to a segment that is a whole number of ticks long.
  return static_cast<std::size_t>(std::max(1.0, std::ceil(ticks - 1e-6)));
}

std::size_t Path::CountTicks(double rate_hz) const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < segments_.size(); ++i) sum += CountTicks(i, rate_hz);
  return sum;
}

double Path::CalcMaxSpeed() const {
  double top = 0;
  for (const std::vector<TimedPose>& knots : knots_) {
    for (std::size_t i = 1; i < knots.size(); ++i) {
      const double dt_s = knots[i].time_s - knots[i - 1].time_s;
      top = std::max(top, glm::distance(knots[i - 1].X_WT.p_AB, knots[i].X_WT.p_AB) / dt_s);
    }
  }
  return top;
}

std::optional<PathStep> PathDriver::Next() {
  if (ticks_ > 0 && tick_ == ticks_) {
    ++segment_;
    ticks_ = 0;
  }
  if (segment_ == path_.segments().size()) return {};
  const PathSegment& segment = path_.segments()[segment_];
  if (ticks_ == 0) {
    tick_ = 0;
    ticks_ = path_.CountTicks(segment_, rate_hz_);
    time_s_ = segment.start_s;
    if (segment.retract_before) return PathStep{segment_, true, path_.CalcPose(segment_, time_s_), time_s_, 0};
  }
  ++tick_;
  const double end_s = std::min(segment.start_s + static_cast<double>(tick_) / rate_hz_, segment.end_s);
  const double dt_s = end_s - std::exchange(time_s_, end_s);
  return PathStep{segment_, false, path_.CalcPose(segment_, end_s), end_s, dt_s};
}

Path MakePath(const Scene& scene) {
  Path path;
  if (!scene.path.poses.empty()) {
    std::vector<TimedPose> knots = scene.path.poses;
    const double start_s = knots.front().time_s;
    for (TimedPose& knot : knots) knot.time_s -= start_s;
    path.AddSegment(knots, true);
    return path;
  }
  double t_s = 0;
  Quat R_WT;
  for (const SceneStroke& stroke : scene.path.strokes) {
    if (stroke.retract) R_WT = CalcStrokeRotation(stroke);
    std::vector<TimedPose> knots{{t_s, {R_WT, stroke.start_mm}}};
    const double travel_mm = glm::distance(stroke.start_mm, stroke.end_mm);
    if (travel_mm > 0) {
      t_s += travel_mm / stroke.feed_mm_per_s;
      knots.push_back({t_s, {R_WT, stroke.end_mm}});
    }
    if (stroke.dwell_s > 0) {
      t_s += stroke.dwell_s;
      knots.push_back({t_s, {R_WT, stroke.end_mm}});
    }
    path.AddSegment(knots, stroke.retract);
  }
  return path;
}

}  // namespace kerf
