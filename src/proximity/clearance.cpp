#include "proximity/clearance.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "proximity/box_tree.h"
#include "proximity/cover.h"
#include "proximity/leaf_boxes.h"

namespace kerf {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A plate is asked again ahead of time when so many ticks like this one would use its clearance up: one in a tick, so
/// that they don't all fall due together.
constexpr double kTicksAhead = 40;
constexpr double kLongTravel_mm = 1e5;

/// The most that a point within `reach` of the origin of T moves from X_a to X_b, mm.
double CalcMotion(const Pose& X_a, const Pose& X_b, double reach_mm) {
  const Quat turn = glm::conjugate(X_a.R_AB) * X_b.R_AB;
  const double half_sine = std::min(1.0, std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z));
  return glm::length(X_b.p_AB - X_a.p_AB) + 2 * half_sine * reach_mm;
}

}  // namespace

/// Clearances are kept as `until`: the travel of the tool at which they are used up.
struct Clearance::State {
  State(const BoneField& field, const Tool& tool)
      : tree(MakeLeafBoxes(field)), plates(MakeCover(tool)), reach_mm(CalcReach(tool)) {
    until.assign(std::max<std::size_t>(1, plates.size()), -kInfinity);
  }

  double bound() const { return until[lowest] - travel; }

  void FindLowest() { lowest = static_cast<std::size_t>(std::min_element(until.begin(), until.end()) - until.begin()); }

  /// Whether asking for the tool as one ball can tell of more than `bound_mm` of clearance.
  bool CanBallTell(double bound_mm) const { return ball_mm + (travel - ball_travel) > bound_mm; }

  /// One query for the whole tool as a ball.
  void AskBall() {
    const double to_all = tree.CalcDistanceToAll(X_WT.p_AB) - reach_mm;
    // Far away, the box around all is good enough.
    ball_mm = to_all > 2 * reach_mm + 20 ? to_all : tree.CalcDistance(X_WT.p_AB) - reach_mm;
    ball_travel = travel;
    for (double& u : until) u = std::max(u, travel + ball_mm);
    FindLowest();
  }

  /// Asks for the plate with the lowest bound. False when it may be within `margin_mm`.
  bool AskLowestPlate(double margin_mm) {
    const CoverPlate& plate = plates[lowest];
    const double plate_reach = std::hypot(plate.radius_mm, plate.half_thickness_mm);
    const Vec3 centre_W = X_WT.Point(plate.centre_T);
    double clear_mm = tree.CalcDistance(centre_W) - plate_reach;
    // As a ball the plate may seem near where it is only turned towards the bone.
    if (clear_mm < margin_mm + plate_reach) {
      const Plate plate_W{centre_W, X_WT.Vector({0, 0, 1}), plate.radius_mm, plate.half_thickness_mm};
      clear_mm = std::max(clear_mm, tree.CalcPlateBound(plate_W, margin_mm));
    }
    if (clear_mm > margin_mm) {
      until[lowest] = std::max(until[lowest], travel + clear_mm);
    } else if (bound() <= margin_mm) {
      until[lowest] = -kInfinity;  // asked first in the next tick
      return false;
    }
    FindLowest();
    return true;
  }

  bool IsClear(double margin_mm, double motion_mm) {
    while (bound() <= margin_mm) {
      if (CanBallTell(margin_mm)) {
        AskBall();
      } else if (plates.empty() || !AskLowestPlate(margin_mm)) {
        return false;
      }
    }
    // One ahead of time.
    const double ahead_mm = kTicksAhead * motion_mm;
    if (bound() - margin_mm < ahead_mm) {
      if (CanBallTell(bound() + ahead_mm)) {
        AskBall();
      } else if (!plates.empty()) {
        AskLowestPlate(margin_mm);
      }
    }
    return true;
  }

  /// Nothing is known.
  void Forget() {
    std::fill(until.begin(), until.end(), -kInfinity);
    travel = 0;
    ball_mm = kInfinity;
    ball_travel = 0;
  }

  BoxTree tree;
  std::vector<CoverPlate> plates;  // of a disc; none: the ball is all
  double reach_mm;
  std::vector<double> until;
  std::size_t lowest = 0;
  double travel = 0;           // the sum of the tool's motions
  double ball_mm = kInfinity;  // what the last query for the whole tool gave; infinity: not asked yet
  double ball_travel = 0;
  Pose X_WT;  // of the last call
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
