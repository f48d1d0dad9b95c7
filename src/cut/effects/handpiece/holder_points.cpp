#include "cut/effects/handpiece/holder_points.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "cut/proximity/leaf_boxes.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr int kRingPoints = 16;        // points of a ring
constexpr int kHubPoints = 32;         // of the hub, which ends the depth of a cut
constexpr int kHubRings = 2;           // of each flange, besides that at the disc, which is in the kerf
constexpr double kPart_mm = 6;         // length of a part
constexpr double kPartFar_mm = 30;     // limit of a query; larger distances are not needed exactly
constexpr double kPartNearVoxels = 2;  // a part closer than this may have points within a voxel of bone
constexpr double kPartSeekVoxels = 3;  // travel after which a part near bone is sought again

}  // namespace

HolderPoints::HolderPoints(const BoneField& field, const Tool& tool, double spacing_mm)
    : tree_(MakeLeafBoxes(field)),
      margin_mm_(kPartNearVoxels * field.voxel_mm()),
      step_mm_(kPartSeekVoxels * field.voxel_mm()) {
  const std::vector<HolderBody> bodies = MakeHolder(tool);
  for (double spacing = spacing_mm; points_.empty() || points_.size() > kMaxPoints; spacing *= 1.25) {
    points_.clear();
    rings_.clear();
    for (const HolderBody& body : bodies) AddBody(body, spacing, spacing / spacing_mm);
  }
  rings_.push_back(points_.size());
  for (const Point& point : points_) reach_mm_ = std::max(reach_mm_, glm::length(point.p_T));
  MakeParts();
  clear_until_mm_.resize(points_.size());
  list_.Reserve(points_.size());
  seen_.reserve(points_.size());
  found_.reserve(points_.size());
  sampled_mm_.resize(points_.size() + PointList::kPadding);
  Forget();
}

/// Adds the rings of a body. Its first and last ring face along the axis as much as outwards. Rings are no further
/// apart than `radii` times the radius.
void HolderPoints::AddBody(const HolderBody& body, double spacing_mm, double radii) {
  const bool hub = body.part == HolderBody::Part::kHub;
  const int around = hub ? kHubPoints : kRingPoints;
  const auto add_ring = [&](const Vec3& middle_T, const Quat& R_TS, double radius_mm, double r, double z) {
    rings_.push_back(points_.size());
    for (int k = 0; k < around; ++k) {
      const double turn = 2 * std::numbers::pi * k / around;
      const Vec3 e(std::cos(turn), std::sin(turn), 0);
      points_.push_back({middle_T + R_TS * (radius_mm * e), glm::normalize(R_TS * (r * e + Vec3(0, 0, z))), hub});
    }
  };
  const std::size_t last = body.sections.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    const HolderSection& a = body.sections[i];
    const HolderSection& b = body.sections[i + 1];
    const double length_mm = glm::length(b.middle_T - a.middle_T);
    const double spacing = std::min(spacing_mm, radii * std::max(a.radius_mm, b.radius_mm));
    const int rings = hub ? kHubRings : std::max(1, static_cast<int>(std::ceil(length_mm / spacing)));
    for (int n = 0; n <= rings; ++n) {
      if (n == rings && i + 1 < last) continue;  // the first of the next pair
      const double t = static_cast<double>(n) / rings;
      const double z_mm = glm::mix(a.middle_T.z, b.middle_T.z, t);
      if (hub && std::abs(z_mm) < 0.5 * (std::abs(a.middle_T.z) + std::abs(b.middle_T.z)) - 1e-9) continue;
      const bool first_ring = i == 0 && n == 0;
      const bool last_ring = i + 1 == last && n == rings;
      const double along = hub && !first_ring && !last_ring ? 0 : first_ring ? -1 : last_ring ? 1 : 0;
      const double slope = std::hypot(length_mm, b.radius_mm - a.radius_mm);
      add_ring(glm::mix(a.middle_T, b.middle_T, t), glm::slerp(a.R_TS, b.R_TS, t),
               glm::mix(a.radius_mm, b.radius_mm, t), along != 0 ? 1 : length_mm / slope,
               along != 0 ? along : (a.radius_mm - b.radius_mm) / slope);
    }
  }
}

void HolderPoints::MakeParts() {
  for (std::size_t ring = 0; ring + 1 < rings_.size(); ++ring) {
    const std::size_t begin = rings_[ring], end = rings_[ring + 1];
    const bool joins = !parts_.empty() && points_[parts_.back().begin].hub == points_[begin].hub &&
                       glm::length(points_[begin].p_T - points_[parts_.back().begin].p_T) < kPart_mm;
    if (joins) {
      parts_.back().end = end;
    } else {
      parts_.push_back({.begin = begin, .end = end});
    }
  }
  for (Part& part : parts_) {
    for (std::size_t i = part.begin; i < part.end; ++i) part.centre_T += points_[i].p_T;
    part.centre_T /= static_cast<double>(part.end - part.begin);
    for (std::size_t i = part.begin; i < part.end; ++i) {
      part.radius_mm = std::max(part.radius_mm, glm::length(points_[i].p_T - part.centre_T));
    }
  }
}

void HolderPoints::MoveTo(const Pose& X_FT) {
  travelled_mm_ += CalcTravel(X_FT_, X_FT, reach_mm_);
  X_FT_ = X_FT;
}

/// Finds the part's distance from the boxes.
void HolderPoints::Seek(Part& part) {
  const double near_mm = part.radius_mm + margin_mm_;
  const double clear_mm = tree_.FindNearest(X_FT_.Point(part.centre_T), near_mm + kPartFar_mm).distance_mm - near_mm;
  part.near = !(clear_mm > 0);
  part.clear_mm = clear_mm;
  part.until_mm = travelled_mm_ + (part.near ? step_mm_ : clear_mm);
}

bool HolderPoints::IsNear(Part& part) {
  if (travelled_mm_ >= part.until_mm) Seek(part);
  return part.near;
}

bool HolderPoints::IsClear(const Pose& X_FT_from, const Pose& X_FT_to) {
  MoveTo(X_FT_from);
  const double travel_mm = CalcTravel(X_FT_from, X_FT_to, reach_mm_);
  for (Part& part : parts_) {
    if (IsNear(part)) return false;
    if (part.until_mm - travelled_mm_ > travel_mm) continue;
    Seek(part);
    if (part.near || part.until_mm - travelled_mm_ <= travel_mm) return false;
  }
  return true;
}

std::span<const HolderPoints::Found> HolderPoints::Find(const Probe& probe, double reach_mm) {
  MoveTo(probe.X_WT());
  list_.Clear();
  seen_.clear();
  found_.clear();
  for (Part& part : parts_) {
    if (!IsNear(part)) continue;
    for (std::size_t i = part.begin; i < part.end; ++i) {
      if (travelled_mm_ < clear_until_mm_[i]) continue;
      list_.Add(points_[i].p_T);
      seen_.push_back(static_cast<int>(i));
    }
  }
  probe.Distances(list_, sampled_mm_.data());
  for (std::size_t n = 0; n < seen_.size(); ++n) {
    const double over_mm = sampled_mm_[n] - reach_mm;
    if (over_mm > 0) {
      clear_until_mm_[static_cast<std::size_t>(seen_[n])] = travelled_mm_ + over_mm / kMaxGradient;
    } else {
      found_.push_back({seen_[n], sampled_mm_[n]});
    }
  }
  return found_;
}

std::array<StepProblem::MotionLimit, 2> HolderPoints::CalcLimits(const Vec3& p_TC_mm, double step_mm) {
  StepProblem::MotionLimit near{0, step_mm}, far{0, kPartFar_mm};
  for (Part& part : parts_) {
    // The bound is renewed so often that it is at least half of the distance.
    if (!part.near && part.until_mm - travelled_mm_ < 0.5 * part.clear_mm) Seek(part);
    StepProblem::MotionLimit& limit = part.near ? near : far;
    limit.reach_mm = std::max(limit.reach_mm, glm::length(part.centre_T - p_TC_mm) + part.radius_mm);
    if (!part.near) far.largest_mm = std::min(far.largest_mm, std::max(part.until_mm - travelled_mm_, step_mm));
  }
  return {near, far};
}

void HolderPoints::Forget() {
  travelled_mm_ = 0;
  for (Part& part : parts_) part.until_mm = 0;
  std::fill(clear_until_mm_.begin(), clear_until_mm_.end(), -1.0);
}

std::size_t HolderPoints::CalcMemoryBytes() const {
  return tree_.CalcMemoryBytes() + points_.capacity() * (sizeof(Point) + sizeof(Found) + 5 * sizeof(double)) +
         parts_.capacity() * sizeof(Part);
}

}  // namespace kerf
