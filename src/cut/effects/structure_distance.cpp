#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "cut/contact/probe.h"
#include "cut/effects/structures.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr int kBladeRings = 7;                     // rings of patches on a blade
constexpr int kTurns = 12;                         // alternations between tool and boxes
constexpr double kSettled = 1e-4;                  // minimum relative decrease of the distance per alternation
constexpr double kDiagonal = std::numbers::sqrt3;  // half the diagonal of a cube, in half edges

/// Returns corner `i` of a cube about the origin; the first four are the lower ones.
Vec3 CalcCorner(double half_mm, int i) {
  return {i % 2 == 0 ? -half_mm : half_mm, i / 2 % 2 == 0 ? -half_mm : half_mm, i < 4 ? -half_mm : half_mm};
}

}  // namespace

StructureDistance::StructureDistance(const std::vector<Box3>& boxes_F, const Tool& tool)
    : tree_(boxes_F),
      tool_(tool),
      form_(GetForm(tool)),
      outline_(MakeStrokeOutline(tool)),
      radius_mm_(outline_.empty() ? CalcRadius(tool) : CalcReach(tool)),
      half_mm_(form_ == ToolForm::kBlade ? 0.5 * CalcCutWidth(tool) : 0),
      reach_mm_(CalcReach(tool)) {
  MakePatches();
  bound_mm_.resize(patches_.size(), 0);
  looked_at_mm_.resize(patches_.size(), -1e9);
}

/// Makes the patches. A blade has one in the middle and rings around it, without those that it never reaches; a ball is
/// a single patch; a solid of revolution has layers of four cubes along its axis.
void StructureDistance::MakePatches() {
  if (form_ == ToolForm::kBall) {
    patches_.push_back({Vec3(0), radius_mm_});
    return;
  }
  if (form_ == ToolForm::kRound) {
    const double half_mm = 0.5 * radius_mm_;
    const int layers = static_cast<int>(std::ceil(CalcRoundSolid(tool_)->top_z_mm / radius_mm_));
    for (int i = 0; i < 4 * layers; ++i) {
      patches_.push_back({CalcCorner(half_mm, i % 4) + Vec3(0, 0, (i / 4 + 1) * radius_mm_), kDiagonal * half_mm});
    }
    return;
  }
  const double width = radius_mm_ / (kBladeRings + 0.5);
  patches_.push_back({Vec3(0), 0.5 * width});
  for (int ring = 1; ring <= kBladeRings; ++ring) {
    const double at = ring * width;
    const int count = 6 * ring;
    // Distance of the furthest corner of a piece of the ring from its middle.
    double radius = 0.5 * width;
    for (const double edge : {at - 0.5 * width, at + 0.5 * width}) {
      radius = std::max(radius, std::hypot(edge * std::cos(std::numbers::pi / count) - at,
                                           edge * std::sin(std::numbers::pi / count)));
    }
    for (int i = 0; i < count; ++i) {
      const double turn = 2 * std::numbers::pi * i / count;
      patches_.push_back({{at * std::cos(turn), at * std::sin(turn), 0}, radius});
    }
  }
  if (outline_.empty()) return;
  std::erase_if(patches_, [&](const Patch& patch) {
    return outline_.CalcSignedDistance({patch.p_T.x, patch.p_T.y}) > patch.radius_mm;
  });
}

/// Returns the point nearest to a point; the point itself inside.
Vec3 StructureDistance::FindNearestOfBody(const Vec3& p_T) const {
  if (outline_.empty()) return FindNearestOfTool(tool_, p_T);
  const ConvexOutline::Point nearest = outline_.FindNearest({p_T.x, p_T.y});
  return {nearest.x, nearest.y, std::clamp(p_T.z, -half_mm_, half_mm_)};
}

/// Returns the distance of the patch's centre from the boxes, or the limit of the search if that is less. Lowers `best`
/// if it finds a smaller distance.
double StructureDistance::QueryPatch(const Pose& X_FT, const Patch& patch, Nearest& best) {
  const double limit_mm = best.distance_mm + Reach(patch);
  ++queries_;
  const BoxTree::Nearest found = tree_.FindNearest(X_FT.Point(patch.p_T), limit_mm);
  if (found.distance_mm >= limit_mm) return limit_mm;
  Vec3 q_F = found.p_W;
  double last_mm = 1e300;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Vec3 p_F = X_FT.Point(FindNearestOfBody(X_FT.InversePoint(q_F)));
    const double distance_mm = glm::length(p_F - q_F);
    if (distance_mm < best.distance_mm) best = {distance_mm, q_F};
    // No point of this patch can lead to a smaller distance than the known one.
    if (distance_mm >= last_mm * (1 - kSettled) || distance_mm > best.distance_mm + Reach(patch)) break;
    if (distance_mm == 0) break;
    last_mm = distance_mm;
    ++queries_;
    const BoxTree::Nearest next = tree_.FindNearest(p_F, distance_mm);
    if (next.distance_mm >= distance_mm) break;  // next.p_W is then not a point of a box
    q_F = next.p_W;
  }
  return found.distance_mm;
}

/// Searches a patch that its bound does not exclude for a distance below `best`.
void StructureDistance::SearchPatch(const Pose& X_FT, const Patch& patch, Nearest& best) {
  const double enough_mm = std::max(kMin_mm, kTolerance * best.distance_mm);
  const bool is_flat = form_ == ToolForm::kBlade;
  for (int i = 0; i < (is_flat ? 4 : 8) && queries_ < max_queries_ && best.distance_mm > 0; ++i) {
    Patch part;
    if (is_flat) {
      Vec3 corner = CalcCorner(0.5 * patch.radius_mm, i);
      corner.z = 0;
      part = {patch.p_T + corner, std::sqrt(0.5) * patch.radius_mm};
      if (std::hypot(part.p_T.x, part.p_T.y) > radius_mm_ + part.radius_mm) continue;
      if (!outline_.empty() && outline_.CalcSignedDistance({part.p_T.x, part.p_T.y}) > part.radius_mm) continue;
    } else {
      part = {patch.p_T + CalcCorner(0.5 * patch.radius_mm / kDiagonal, i), 0.5 * patch.radius_mm};
      if (CalcToolDistance(tool_, part.p_T) > part.radius_mm) continue;
    }
    const double distance_mm = QueryPatch(X_FT, part, best);
    if (distance_mm - Reach(part) < best.distance_mm - enough_mm && part.radius_mm > enough_mm) {
      SearchPatch(X_FT, part, best);
    }
  }
}

StructureDistance::Nearest StructureDistance::Find(const Pose& X_FT, double limit_mm, std::size_t max_queries) {
  queries_ = 0;
  max_queries_ = max_queries;
  Nearest best{limit_mm, X_FT.p_AB};
  travelled_mm_ += CalcTravel(X_looked_, X_FT, reach_mm_);
  X_looked_ = X_FT;
  if (tree_.CalcDistanceToAll(X_FT.p_AB) - reach_mm_ >= limit_mm) return best;
  const auto ask = [&](std::size_t i) {
    bound_mm_[i] = QueryPatch(X_FT, patches_[i], best);
    looked_at_mm_[i] = travelled_mm_;
  };
  if (form_ == ToolForm::kBall) {
    // The distance of a ball is the distance of its centre minus its radius.
    ++queries_;
    const BoxTree::Nearest found = tree_.FindNearest(X_FT.p_AB, limit_mm + radius_mm_);
    if (found.distance_mm >= limit_mm + radius_mm_) return best;
    return {std::max(0.0, found.distance_mm - radius_mm_), found.p_W};
  }
  ask(best_patch_);
  std::size_t nearest = best_patch_;
  double min_mm = bound_mm_[nearest];
  const std::size_t begin = first_patch_;
  first_patch_ = 0;
  for (std::size_t n = 0; n < patches_.size(); ++n) {
    const std::size_t i = (begin + n) % patches_.size();
    if (queries_ >= max_queries_) {
      first_patch_ = i;
      break;
    }
    const double enough_mm = std::max(kMin_mm, kTolerance * best.distance_mm);
    const double bound_mm = bound_mm_[i] - (travelled_mm_ - looked_at_mm_[i]) - Reach(patches_[i]);
    if (bound_mm >= best.distance_mm - enough_mm) continue;
    if (i != best_patch_) ask(i);
    if (bound_mm_[i] < min_mm) {
      min_mm = bound_mm_[i];
      nearest = i;
    }
    if (best.distance_mm == 0) break;
    if (bound_mm_[i] - Reach(patches_[i]) < best.distance_mm - enough_mm) SearchPatch(X_FT, patches_[i], best);
  }
  best_patch_ = nearest;
  return best;
}

std::size_t StructureDistance::CalcMemoryBytes() const {
  return tree_.CalcMemoryBytes() + patches_.capacity() * sizeof(Patch) +
         (bound_mm_.capacity() + looked_at_mm_.capacity()) * sizeof(double);
}

}  // namespace kerf
