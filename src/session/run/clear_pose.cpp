#include "session/run/clear_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kLiftStep_mm = 0.5;
constexpr int kDirections = 24;

/// Distance of two poses as seen at the steps of a trail.
bool IsNear(const Pose& a, const Pose& b, double mm, double rad) {
  return glm::distance(a.p_AB, b.p_AB) < mm && CalcTravel({a.R_AB, Vec3{0}}, {b.R_AB, Vec3{0}}, 1) < rad;
}

/// Points of a tool's surface that are looked up in the bone.
class ClearTest {
 public:
  ClearTest(const PhiSampler& phi, const Tool& tool, double margin_mm)
      : phi_(phi),
        points_T_(SampleToolSurface(tool, std::max(phi.voxel_mm(), CalcReach(tool) / 60))),
        margin_mm_(margin_mm) {}
  bool IsClear(const Pose& X_WT) const {
    // The middle of a ball too: the bone may be smaller than the distance between the points.
    if (phi_.Calc(X_WT.p_AB) < margin_mm_) return false;
    return std::all_of(points_T_.begin(), points_T_.end(),
                       [&](const Vec3& p_T) { return phi_.Calc(X_WT.Point(p_T)) >= margin_mm_; });
  }

 private:
  const PhiSampler& phi_;
  std::vector<Vec3> points_T_;
  double margin_mm_;
};

}  // namespace

bool IsClear(const PhiSampler& phi, const Tool& tool, const Pose& X_WT, double margin_mm) {
  return ClearTest(phi, tool, margin_mm).IsClear(X_WT);
}

Pose FindNearestClearPose(const PhiSampler& phi, const Tool& tool, const Pose& X_WT, const Vec3& p_inside_W,
                          double margin_mm, double max_mm) {
  std::vector<Vec3> directions;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    directions.push_back(X_WT.Vector({std::cos(angle), std::sin(angle), 0}));
  }
  const ClearTest test(phi, tool, margin_mm);
  const auto find = [&]() -> std::optional<Pose> {
    for (double distance_mm = 0; distance_mm <= max_mm; distance_mm += kLiftStep_mm) {
      for (const Vec3& direction : directions) {
        const Pose X{X_WT.R_AB, X_WT.p_AB + distance_mm * direction};
        if (test.IsClear(X)) return X;
      }
    }
    return std::nullopt;
  };
  if (IsBlade(tool)) {
    if (const std::optional<Pose> X = find()) return *X;
  }
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x != 0 || y != 0 || z != 0) directions.push_back(glm::normalize(Vec3(x, y, z)));
      }
    }
  }
  if (const std::optional<Pose> X = find()) return *X;
  const Vec3 away = X_WT.p_AB - p_inside_W;
  const double length = glm::length(away);
  return {X_WT.R_AB, X_WT.p_AB + max_mm * (length > 1e-6 ? away / length : Vec3{0, 0, 1})};
}

std::vector<Pose> FindClearWay(const PhiSampler& phi, const Tool& tool, const Pose& X_from, const Pose& X_to,
                               const Vec3& p_inside_W, double margin_mm, double max_mm) {
  constexpr double kLook_mm = 3;
  constexpr double kLift_mm = 10;
  const ClearTest test(phi, tool, margin_mm);
  const auto is_clear = [&](const std::vector<Pose>& corners) {
    const std::vector<Pose> way = DivideIntoTicks(corners, kLook_mm, 1, CalcReach(tool));
    return std::all_of(way.begin(), way.end(), [&](const Pose& X) { return test.IsClear(X); });
  };
  if (!test.IsClear(X_from)) return {};
  if (is_clear({X_from, X_to})) return {X_to};
  std::vector<Vec3> directions{{0, 0, 1}, {0, -1, 0}};
  for (const Pose& X : {X_from, X_to}) {
    const Vec3 out = X.p_AB - p_inside_W;
    if (glm::length(out) > 1e-6) directions.push_back(glm::normalize(out));
  }
  for (double lift_mm = kLift_mm; lift_mm <= max_mm; lift_mm += kLift_mm) {
    for (const Vec3& direction : directions) {
      const Pose X_up{X_from.R_AB, X_from.p_AB + lift_mm * direction};
      const Pose X_over{X_to.R_AB, X_to.p_AB + lift_mm * direction};
      if (is_clear({X_from, X_up, X_over, X_to})) return {X_up, X_over, X_to};
    }
  }
  return {};
}

void ToolTrail::Take(const Pose& X_WT) {
  if (!poses_.empty()) {
    if (IsNear(poses_.back(), X_WT, kStep_mm, kStep_rad)) return;
    if (glm::distance(poses_.back().p_AB, X_WT.p_AB) > kJump_mm) poses_.clear();
  }
  if (poses_.size() == kMaxPoses) poses_.erase(poses_.begin(), poses_.begin() + kMaxPoses / 4);
  poses_.push_back(X_WT);
}

std::vector<Pose> ToolTrail::FindWayBack(const PhiSampler& phi, const Tool& tool, const Pose& X_WT,
                                         double margin_mm) const {
  const ClearTest test(phi, tool, margin_mm);
  const auto clear = std::find_if(poses_.rbegin(), poses_.rend(), [&](const Pose& X) { return test.IsClear(X); });
  if (clear == poses_.rend()) return {};
  const std::size_t end = poses_.size() - 1 - static_cast<std::size_t>(clear - poses_.rbegin());
  std::vector<Pose> way{X_WT};
  for (std::size_t at = poses_.size(); at-- > end;) {
    // Continue from the earliest time at which the tool was here.
    for (std::size_t i = end; i < at; ++i) {
      if (IsNear(poses_[i], poses_[at], 2 * kStep_mm, 2 * kStep_rad)) {
        at = i;
        break;
      }
    }
    way.push_back(poses_[at]);
  }
  return way;
}

std::vector<Pose> DivideIntoTicks(const std::vector<Pose>& corners, double speed_mm_per_s, double period_s,
                                  double reach_mm) {
  std::vector<Pose> poses;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Pose& from = corners[i - 1];
    const Pose& to = corners[i];
    const double travel_mm = CalcTravel(from, to, reach_mm);
    const int ticks = std::max(1, static_cast<int>(std::ceil(travel_mm / (speed_mm_per_s * period_s))));
    const Quat R_to = glm::dot(from.R_AB, to.R_AB) < 0 ? -to.R_AB : to.R_AB;
    for (int k = 1; k <= ticks; ++k) {
      const double fraction = static_cast<double>(k) / ticks;
      poses.push_back({glm::normalize(glm::slerp(from.R_AB, R_to, fraction)), glm::mix(from.p_AB, to.p_AB, fraction)});
    }
  }
  return poses;
}

}  // namespace kerf
