#include "cut/proximity/clearance.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "cut/proximity/box_tree.h"
#include "cut/proximity/leaf_boxes.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

/// A bound is refreshed early if this many ticks with the current motion would use it up. This costs one query per tick
/// and prevents the queries of all plates from becoming due in the same tick.
constexpr double kTicksAhead = 40;
constexpr double kTicksApart = 8;  // interval of the queries of the ball from behind, in ticks with the current motion
constexpr double kLongTravel_mm = 1e5;
constexpr double kFar_mm = 200;  // limit of a query; larger distances are not needed exactly

/// Returns a bound on the motion of a point within `reach_mm` of the origin of T from X_a to X_b, mm.
double CalcMotion(const Pose& X_a, const Pose& X_b, double reach_mm) {
  const Quat turn = glm::conjugate(X_a.R_AB) * X_b.R_AB;
  const double half_sine = std::min(1.0, std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z));
  return glm::length(X_b.p_AB - X_a.p_AB) + 2 * half_sine * reach_mm;
}

/// Result of a query, and the tool's travel at that time. The travel since then bounds the change of the result.
struct Answer {
  double mm = kInfinity;  // infinity: no query yet
  double travel_mm = 0;

  double CalcMax(double travel, double rate = 1) const { return mm + rate * (travel - travel_mm); }
};

}  // namespace

/// Three kinds of query find the clearance of the tool, in the order of their cost:
/// - the tool as one ball;
/// - for a tool with a cover, one large ball without bone that encloses the tool and whose centre lies on the side away
/// from the
///   nearest bone: this is sufficient where all bone lies on one side, for any tilt of a blade;
/// - the plates that cover the tool, one by one.
/// The clearance of each plate is stored as `until`: the tool's travel at which it is used up.
struct Clearance::State {
  State(const BoneField& field, const Tool& tool)
      : tree(MakeLeafBoxes(field)), plates(MakeToolCover(tool)), reach_mm(CalcReach(tool)) {
    radius_mm = CalcRadius(tool);
    if (CalcStroke(tool) > 0) radius_mm = reach_mm;  // the blade is not round
    for (const CoverPlate& plate : plates) {
      half_thickness_mm = std::max(half_thickness_mm, std::abs(plate.centre_T.z) + plate.half_thickness_mm);
    }
    until.resize(std::max<std::size_t>(1, plates.size()));
    plate_distance.resize(plates.size());
    Forget();
  }

  double bound() const { return until[lowest] - travel; }

  void FindLowest() { lowest = static_cast<std::size_t>(std::min_element(until.begin(), until.end()) - until.begin()); }
  void RaiseAll(double clear_mm) {
    for (double& u : until) u = std::max(u, travel + clear_mm);
    FindLowest();
  }

  void QueryBall() {
    const double limit_mm = std::min(ball.CalcMax(travel) + reach_mm, tree.CalcDistanceToAll(X_WT.p_AB) + kFar_mm);
    const BoxTree::Nearest nearest = tree.FindNearest(X_WT.p_AB, limit_mm);
    to_bone_W = nearest.p_W - X_WT.p_AB;
    ball = {nearest.distance_mm - reach_mm, travel};
    RaiseAll(ball.mm);
  }

  void QueryBehind() {
    behind = {-kInfinity, travel};
    const double distance = glm::length(to_bone_W);
    if (!(distance > 0)) return;
    // A ball whose centre is further behind is closer to a half space, but it takes longer to find.
    const double back_mm = 3 * radius_mm;
    const Vec3 away_W = -to_bone_W / distance;
    const double free_mm =
        tree.FindNearest(X_WT.p_AB + back_mm * away_W, ball.CalcMax(travel) + reach_mm + back_mm).distance_mm;
    const double axial = std::abs(glm::dot(away_W, X_WT.Vector({0, 0, 1})));
    const double radial = std::sqrt(std::max(0.0, 1 - axial * axial));
    behind.mm = free_mm - std::hypot(back_mm * radial + radius_mm, back_mm * axial + half_thickness_mm);
    RaiseAll(behind.mm);
  }

  /// Queries the plate with the lowest bound. Returns false if it may be within `margin_mm`.
  bool QueryLowestPlate(double margin_mm) {
    const CoverPlate& plate = plates[lowest];
    const double plate_reach = std::hypot(plate.radius_mm, plate.half_thickness_mm);
    const Vec3 centre_W = X_WT.Point(plate.centre_T);
    const double limit_mm =
        std::min(plate_distance[lowest].CalcMax(travel), tree.CalcDistanceToAll(centre_W) + kFar_mm);
    plate_distance[lowest] = {tree.FindNearest(centre_W, limit_mm).distance_mm, travel};
    double clear_mm = plate_distance[lowest].mm - plate_reach;
    // Treated as a ball, the plate may seem near although only its flat faces the bone.
    if (clear_mm < margin_mm + plate_reach) {
      const Plate plate_W{centre_W, X_WT.Vector({0, 0, 1}), plate.radius_mm, plate.half_thickness_mm};
      clear_mm = std::max(clear_mm, tree.CalcPlateBound(plate_W, plate_distance[lowest].mm, margin_mm));
    }
    if (clear_mm > margin_mm) until[lowest] = std::max(until[lowest], travel + clear_mm);
    if (bound() <= margin_mm) {
      until[lowest] = -kInfinity;  // queried first in the next tick
      return false;
    }
    FindLowest();
    return true;
  }

  /// Makes one query, of the kind that may give more than `wanted_mm` of clearance. Returns false if the tool may be
  /// within `margin_mm`.
  bool Query(double wanted_mm, double margin_mm) {
    if (ball.CalcMax(travel) > wanted_mm) {
      QueryBall();
      return IsRaised(ball.mm, margin_mm);
    }
    if (plates.empty()) return bound() > margin_mm;
    if (behind.CalcMax(travel, 2) > wanted_mm) {  // the centre of this ball moves, and the blade moves relative to it
      QueryBehind();
      return IsRaised(behind.mm, margin_mm);
    }
    return QueryLowestPlate(margin_mm);
  }

  /// Returns false if a result above the margin has not raised the bound above the margin. They then differ by
  /// rounding, and repeated queries would never end.
  bool IsRaised(double clear_mm, double margin_mm) const { return !(clear_mm > margin_mm && bound() <= margin_mm); }

  /// Makes at most one query, so that the bounds last for some more ticks.
  bool LookAhead(double margin_mm, double motion_mm) {
    const double ahead_mm = kTicksAhead * motion_mm;
    if (bound() - margin_mm >= ahead_mm) return true;
    // While the ball from behind gives enough clearance, it is queried at intervals and the plates are not.
    if (!plates.empty() && std::isfinite(behind.mm) && behind.mm - margin_mm > kTicksApart * motion_mm) {
      if (travel - behind.travel_mm >= kTicksApart * motion_mm) QueryBehind();
      return true;
    }
    return Query(bound() + ahead_mm, margin_mm);
  }

  bool IsClear(double margin_mm, double motion_mm) {
    while (bound() <= margin_mm) {
      if (!Query(margin_mm, margin_mm)) return false;
    }
    return LookAhead(margin_mm, motion_mm);
  }

  /// Discards all results.
  void Forget() {
    std::fill(until.begin(), until.end(), -kInfinity);
    std::fill(plate_distance.begin(), plate_distance.end(), Answer{});
    travel = 0;
    ball = {};
    behind = {};
  }

  BoxTree tree;
  std::vector<CoverPlate> plates;  // empty for a ball
  double reach_mm;
  double radius_mm = 0;
  double half_thickness_mm = 0;  // largest distance of the tool from the plane z = 0
  std::vector<double> until;
  std::vector<Answer> plate_distance;  // distance of each plate's centre from bone
  std::size_t lowest = 0;
  double travel = 0;  // sum of the tool's motions
  Answer ball;
  Answer behind;
  Vec3 to_bone_W{0};  // from the tool's centre to the nearest box, at the last query
  Pose X_WT;          // pose of the last call
  bool near = false;
};

Clearance::Clearance(const BoneField& field, const Tool& tool) : state_(std::make_unique<State>(field, tool)) {}
Clearance::~Clearance() = default;
Clearance::Clearance(Clearance&&) noexcept = default;
Clearance& Clearance::operator=(Clearance&&) noexcept = default;

bool Clearance::IsNear(const Pose& X_WT, double margin_mm) {
  State& s = *state_;
  if (!IsValid(X_WT)) return true;  // the position is unknown
  const double motion = CalcMotion(std::exchange(s.X_WT, X_WT), X_WT, s.reach_mm);
  s.travel += motion;
  // A sum that has become this large has lost its last digits.
  if (!(s.travel < kLongTravel_mm)) s.Forget();
  s.near = !s.IsClear(margin_mm, motion);
  return s.near;
}

double Clearance::bound_mm() const {
  return state_->near ? 0 : std::max(0.0, state_->bound());
}

std::size_t Clearance::CalcMemoryBytes() const {
  const State& s = *state_;
  return sizeof(State) + s.tree.CalcMemoryBytes() + s.plates.capacity() * sizeof(CoverPlate) +
         s.until.capacity() * sizeof(double);
}

}  // namespace kerf
