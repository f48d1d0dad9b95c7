#include "session/run/loop_mover.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace kerf {
namespace {

// Contact alone does not count as being in bone: a blade in its own kerf touches the walls.
constexpr double kContact_vox = -0.5;
// Air between the tool and the bone after it was moved out, below the width of the bone's band.
constexpr double kFree_vox = 1.5;
constexpr double kRetract_mm_per_s = 40;
constexpr double kMaxRetract_s = 2;   // a longer way out is moved along faster
constexpr double kTested_mm = 1;      // between the poses of a way at which the bone is looked for
constexpr double kGivesWay_mm = 0.3;  // further beside its tolerance than the guide gives way in a normal cut

/// Returns the largest distance of a disc's rim from a plane, mm.
double CalcDistance(const GuidedPlane& plane, double radius_mm, const Pose& X_WT) {
  const double along = glm::dot(X_WT.Vector({0, 0, 1}), plane.normal_W);
  return std::abs(glm::dot(X_WT.p_AB - plane.p_W, plane.normal_W)) +
         radius_mm * std::sqrt(std::max(0.0, 1 - along * along));
}

}  // namespace

LoopMover::LoopMover(const Tool& tool, const Pose& X_WT_start, double period_s, bool can_move)
    : tool_(tool), X_WT_(X_WT_start), period_s_(period_s), can_move_(can_move) {}

void LoopMover::Connect(HapticLoop& loop, BoneMirror& mirror) {
  loop_ = &loop;
  mirror_ = &mirror;
}

void LoopMover::Take(const LoopTick& tick) {
  X_WT_ = tick.coupled.X_WT;
  removed_mm3_ += tick.coupled.removed_mm3;
  if (!tick.stands && can_move_) trail_.Take(X_WT_);
}

std::vector<Pose> LoopMover::FindWayOut(const PhiSampler& phi, const Pose& X_WT) const {
  const double margin_mm = kFree_vox * phi.voxel_mm();
  if (IsClear(phi, tool_, X_WT, margin_mm)) return {};
  std::vector<Pose> corners = trail_.FindWayBack(phi, tool_, X_WT, margin_mm);
  if (corners.empty()) corners = {X_WT, FindNearestWayOut(phi, X_WT)};
  double travel_mm = 0;
  for (std::size_t i = 1; i < corners.size(); ++i)
    travel_mm += CalcTravel(corners[i - 1], corners[i], CalcReach(tool_));
  return DivideIntoTicks(corners, std::max(kRetract_mm_per_s, travel_mm / kMaxRetract_s), period_s_, CalcReach(tool_));
}

Pose LoopMover::FindNearestWayOut(const PhiSampler& phi, const Pose& X_WT) const {
  const Box3 bounds_W = mirror_->bone().CalcBounds();
  const double max_mm = glm::length(bounds_W.size()) + 2 * CalcReach(tool_);
  return FindNearestClearPose(phi, tool_, X_WT, bounds_W.centre(), kFree_vox * phi.voxel_mm(), max_mm);
}

/// Returns true if a blade is in the guide's plane now, but would not be at the wanted pose.
bool LoopMover::LeavesGuide(const Pose& X_wanted, const Pose& X_now) const {
  if (!guide_ || !IsBlade(tool_)) return false;
  const double limit_mm = guide_->tolerance_mm + kGivesWay_mm;
  return CalcDistance(*guide_, CalcReach(tool_), X_wanted) > limit_mm &&
         CalcDistance(*guide_, CalcReach(tool_), X_now) <= limit_mm;
}

bool LoopMover::UpdateBone() {
  // While the loop holds the tool, the bone does not change. The state is read before the leaves.
  loop_->state().Update();
  const LoopState& state = loop_->state().front();
  leaves_received_ += mirror_->Update();
  return state.sent_until_s >= state.last.time_s;
}

std::optional<std::vector<Pose>> LoopMover::FindReturn(const Pose& X_wanted) {
  if (!UpdateBone()) return std::nullopt;
  const PhiSampler phi(mirror_->bone());
  if (const Pose& X_now = loop_->state().front().last.coupled.X_WT; LeavesGuide(X_wanted, X_now)) {
    const bool clear = IsClear(phi, tool_, X_now, kContact_vox * phi.voxel_mm());
    return {{clear ? X_now : FindNearestWayOut(phi, X_now)}};
  }
  if (IsClear(phi, tool_, X_wanted, kContact_vox * phi.voxel_mm())) return {{X_wanted}};
  // The undone motion is not shown, so the tool is moved at once.
  const std::vector<Pose> way = FindWayOut(phi, X_wanted);
  return std::vector<Pose>{way.empty() ? X_wanted : way.back()};
}

/// Returns the straight way between two poses that are clear of the bone; only its end if bone is in the way.
std::vector<Pose> LoopMover::FindWayInAir(const PhiSampler& phi, const Pose& X_from, const Pose& X_to) const {
  const double reach_mm = CalcReach(tool_);
  const double travel_mm = CalcTravel(X_from, X_to, reach_mm);
  std::vector<Pose> way =
      DivideIntoTicks({X_from, X_to}, std::max(kRetract_mm_per_s, travel_mm / kMaxRetract_s), period_s_, reach_mm);
  const std::size_t step =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(static_cast<double>(way.size()) * kTested_mm /
                                                                   std::max(travel_mm, kTested_mm))));
  for (std::size_t i = 0; i < way.size(); i += step) {
    if (!IsClear(phi, tool_, way[i], kContact_vox * phi.voxel_mm())) return {X_to};
  }
  return way;
}

std::optional<std::vector<Pose>> LoopMover::FindRetraction(const std::optional<Pose>& X_to) {
  if (!UpdateBone()) return std::nullopt;
  const PhiSampler phi(mirror_->bone());
  const Pose X_now = loop_->state().front().last.coupled.X_WT;
  std::vector<Pose> way = FindWayOut(phi, X_now);
  if (!X_to) return way;
  const Pose X_out = way.empty() ? X_now : way.back();
  Pose X_end = *X_to;
  if (LeavesGuide(X_end, X_out)) {  // the guide would pull it back
    const Vec3 along = X_end.p_AB - X_out.p_AB;
    X_end = {X_out.R_AB, X_end.p_AB - glm::dot(along, guide_->normal_W) * guide_->normal_W};
  }
  if (!IsClear(phi, tool_, X_end, kFree_vox * phi.voxel_mm())) X_end = FindNearestWayOut(phi, X_end);
  const std::vector<Pose> rest = FindWayInAir(phi, X_out, X_end);
  way.insert(way.end(), rest.begin(), rest.end());
  return way;
}

}  // namespace kerf
