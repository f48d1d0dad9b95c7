#include "cut/proximity/clearance.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "cut/proximity/box_tree.h"
#include "cut/proximity/cover.h"
#include "cut/proximity/leaf_boxes.h"

namespace kerf {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// What is known is refreshed ahead of time when so many ticks like this one would use it up: by one query in a tick,
/// so that all plates don't fall due together.
constexpr double kTicksAhead = 40;
constexpr double kTicksApart = 8;
constexpr double kLongTravel_mm = 1e5;
constexpr double kFar_mm = 200;  // nobody needs to know more exactly

/// The most that a point within `reach` of the origin of T moves from X_a to X_b, mm.
double CalcMotion(const Pose& X_a, const Pose& X_b, double reach_mm) {
  const Quat turn = glm::conjugate(X_a.R_AB) * X_b.R_AB;
  const double half_sine = std::min(1.0, std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z));
  return glm::length(X_b.p_AB - X_a.p_AB) + 2 * half_sine * reach_mm;
}

/// What a query gave, and where on the tool's travel. How far it may have changed since is known from the travel.
struct Answer {
  double mm = kInfinity;  // infinity: not asked yet
  double travel_mm = 0;

  double CalcMost(double travel, double rate = 1) const { return mm + rate * (travel - travel_mm); }
};

}  // namespace

/// Three kinds of query tell how far the tool is clear, cheapest first:
/// - the tool as one ball;
/// - one large ball free of bone that reaches round a disc from behind, as seen from the nearest bone: enough where the
///   bone lies on one side, whatever the disc's tilt;
/// - the plates that cover the disc, one by one.
/// Clearances are kept for each plate as `until`: the travel of the tool at which it is used up.
struct Clearance::State {
  State(const BoneField& field, const Tool& tool)
      : tree(MakeLeafBoxes(field)), plates(MakeCover(tool)), reach_mm(CalcReach(tool)) {
    if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
      radius_mm = disc->radius_mm();
      half_thickness_mm = 0.5 * disc->thickness_mm;
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

  void AskBall() {
    const double most = std::min(ball.CalcMost(travel) + reach_mm, tree.CalcDistanceToAll(X_WT.p_AB) + kFar_mm);
    const BoxTree::Nearest nearest = tree.FindNearest(X_WT.p_AB, most);
    to_bone_W = nearest.p_W - X_WT.p_AB;
    ball = {nearest.distance_mm - reach_mm, travel};
    RaiseAll(ball.mm);
  }

  void AskBehind() {
    behind = {-kInfinity, travel};
    const double distance = glm::length(to_bone_W);
    if (!(distance > 0)) return;
    // Far behind, the ball is as good as a half space but slow to find.
    const double back_mm = 3 * radius_mm;
    const Vec3 away_W = -to_bone_W / distance;
    const double free_mm =
        tree.FindNearest(X_WT.p_AB + back_mm * away_W, ball.CalcMost(travel) + reach_mm + back_mm).distance_mm;
    const double axial = std::abs(glm::dot(away_W, X_WT.Vector({0, 0, 1})));
    const double radial = std::sqrt(std::max(0.0, 1 - axial * axial));
    behind.mm = free_mm - std::hypot(back_mm * radial + radius_mm, back_mm * axial + half_thickness_mm);
    RaiseAll(behind.mm);
  }

  /// Asks for the plate with the lowest bound. False when it may be within `margin_mm`.
  bool AskLowestPlate(double margin_mm) {
    const CoverPlate& plate = plates[lowest];
    const double plate_reach = std::hypot(plate.radius_mm, plate.half_thickness_mm);
    const Vec3 centre_W = X_WT.Point(plate.centre_T);
    const double most = std::min(plate_distance[lowest].CalcMost(travel), tree.CalcDistanceToAll(centre_W) + kFar_mm);
    plate_distance[lowest] = {tree.FindNearest(centre_W, most).distance_mm, travel};
    double clear_mm = plate_distance[lowest].mm - plate_reach;
    // As a ball the plate may seem near where it is only turned towards the bone.
    if (clear_mm < margin_mm + plate_reach) {
      const Plate plate_W{centre_W, X_WT.Vector({0, 0, 1}), plate.radius_mm, plate.half_thickness_mm};
      clear_mm = std::max(clear_mm, tree.CalcPlateBound(plate_W, plate_distance[lowest].mm, margin_mm));
    }
    if (clear_mm > margin_mm) until[lowest] = std::max(until[lowest], travel + clear_mm);
    if (bound() <= margin_mm) {
      until[lowest] = -kInfinity;  // asked first in the next tick
      return false;
    }
    FindLowest();
    return true;
  }

  /// One query of the kind that may tell of more than `wanted_mm` of clearance. False when the tool may be within
  /// `margin_mm`.
  bool Ask(double wanted_mm, double margin_mm) {
    if (ball.CalcMost(travel) > wanted_mm) {
      AskBall();
      return IsRaised(ball.mm, margin_mm);
    }
    if (plates.empty()) return bound() > margin_mm;
    if (behind.CalcMost(travel, 2) > wanted_mm) {  // its centre moves, and the disc against it
      AskBehind();
      return IsRaised(behind.mm, margin_mm);
    }
    return AskLowestPlate(margin_mm);
  }

  /// False when an answer of more than the margin has not lifted the bound above it: they differ by rounding then, and
  /// to ask again would give the same for ever.
  bool IsRaised(double clear_mm, double margin_mm) const { return !(clear_mm > margin_mm && bound() <= margin_mm); }

  /// At most one query, so that what is known lasts some ticks more.
  bool LookAhead(double margin_mm, double motion_mm) {
    const double ahead_mm = kTicksAhead * motion_mm;
    if (bound() - margin_mm >= ahead_mm) return true;
    // While the ball from behind tells enough, it is asked now and then, and the plates are not.
    if (!plates.empty() && std::isfinite(behind.mm) && behind.mm - margin_mm > kTicksApart * motion_mm) {
      if (travel - behind.travel_mm >= kTicksApart * motion_mm) AskBehind();
      return true;
    }
    return Ask(bound() + ahead_mm, margin_mm);
  }

  bool IsClear(double margin_mm, double motion_mm) {
    while (bound() <= margin_mm) {
      if (!Ask(margin_mm, margin_mm)) return false;
    }
    return LookAhead(margin_mm, motion_mm);
  }

  /// Nothing is known.
  void Forget() {
    std::fill(until.begin(), until.end(), -kInfinity);
    std::fill(plate_distance.begin(), plate_distance.end(), Answer{});
    travel = 0;
    ball = {};
    behind = {};
  }

  BoxTree tree;
  std::vector<CoverPlate> plates;  // of a disc; none: the ball is all
  double reach_mm;
  double radius_mm = 0;  // of a disc
  double half_thickness_mm = 0;
  std::vector<double> until;
  std::vector<Answer> plate_distance;  // from each plate's centre
  std::size_t lowest = 0;
  double travel = 0;  // the sum of the tool's motions
  Answer ball;
  Answer behind;
  Vec3 to_bone_W{0};  // from the tool's middle to the nearest box, when it was last asked for
  Pose X_WT;          // of the last call
  bool near = false;
};

Clearance::Clearance(const BoneField& field, const Tool& tool) : state_(std::make_unique<State>(field, tool)) {}
Clearance::~Clearance() = default;
Clearance::Clearance(Clearance&&) noexcept = default;
Clearance& Clearance::operator=(Clearance&&) noexcept = default;

bool Clearance::IsNear(const Pose& X_WT, double margin_mm) {
  State& s = *state_;
  if (!IsValid(X_WT)) return true;  // nothing is known of it
  const double motion = CalcMotion(std::exchange(s.X_WT, X_WT), X_WT, s.reach_mm);
  s.travel += motion;
  // A sum that has grown long has lost its last digits.
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
