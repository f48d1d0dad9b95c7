#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "experiment/reference/check.h"
#include "experiment/reference/least_motion.h"
#include "experiment/reference/reference.h"
#include "experiment/reference/rim.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using namespace reference;

// Stiffness of a kerf's walls per area of the flat, the same as in the simulation: 3000 N/mm for a point that
// represents 1.4 mm x 1.4 mm.
constexpr double kWall_N_per_mm3 = 3000 / (1.4 * 1.4);
constexpr double kDeep_mm = 0.1;        // depth in a wall that the deflection of a spring never reaches
constexpr double kFirstRing = 1.0 / 8;  // width of the outermost ring of points on a flat, as a fraction of the spacing
constexpr double kWiderRings = 1.5;     // ratio of successive ring widths, up to the spacing
constexpr double kCreep_mm_per_s = 0.02;  // speed up to which the force is ramped in if a law has a force at the
                                          // smallest bite
constexpr double kMaxMotion_mm = 0.025;   // maximum motion of any point of the disc before the bone and the walls are
                                          // evaluated again
constexpr double kMaxMotionPerTick_mm = 0.1;  // the same maximum, multiplied by the number of steps per tick; the
                                              // smaller of the two limits applies

/// A pair of opposite points on the two flats.
struct FlatPoint {
  double x = 0, y = 0;
  double area_mm2 = 0;
};

/// Returns points in rings. The outermost ring is narrow, because in a shallow kerf only that ring holds the tool.
std::vector<FlatPoint> MakeFlat(double radius_mm, double spacing_mm) {
  std::vector<FlatPoint> points;
  double outer = radius_mm;
  double width = kFirstRing * spacing_mm;
  for (int ring = 0; outer > 0; ++ring) {
    const double inner = outer > 1.5 * width ? outer - width : 0;
    const double r = 0.5 * (outer + inner);
    const int count = std::max(6, static_cast<int>(std::ceil(2 * std::numbers::pi * r / spacing_mm)));
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.5 * (ring % 2)) / count;
      points.push_back(
          {r * std::cos(angle), r * std::sin(angle), std::numbers::pi * (outer * outer - inner * inner) / count});
    }
    outer = inner;
    width = std::min(kWiderRings * width, spacing_mm);
  }
  return points;
}

/// Distance from the midpoint of a pair of points to the uncut bone, and the tool's travel when it was evaluated.
struct StoredDistance {
  double solid_mm = 0;
  double moved_mm = 0;
};

class HeldTool {
 public:
  HeldTool(ExactSolid solid, const ReferenceParams& params, const Pose& X_W)
      : params_(params),
        bone_(std::move(solid), params.saw),
        flat_(MakeFlat(params.saw.radius_mm() - params.fineness.edge_mm, params.fineness.flat_spacing_mm)),
        deflection_mm_(2 * flat_.size(), 0.0),
        stored_(flat_.size()),
        flux_(params.saw, std::max(16, params.fineness.rim_points / kFluxFraction), 1, false),
        reach_mm_(std::hypot(params.saw.radius_mm(), 0.5 * params.saw.thickness_mm)),
        max_motion_mm_(std::min(kMaxMotionPerTick_mm / params.fineness.steps_per_tick, kMaxMotion_mm)),
        X_T_(X_W),
        X_H_(X_W) {
    const CouplingParams& c = params.coupling;
    problem_.spring = {c.stiffness_N_per_mm, c.max_force_N};
    problem_.damper = {c.damping_Ns_per_mm, c.max_force_N};
    problem_.torsion = {c.torsion_Nmm_per_rad, c.max_torque_Nmm};
    problem_.torsion_damper = {c.torsion_damping_Nmms, c.max_torque_Nmm};
    problem_.law = MakeToothForce(params.law, params.saw);
    problem_.passes_per_s = params.saw.teeth * std::abs(params.rpm) / 60;
    problem_.ramp_mm_per_s = problem_.law.jumps ? kCreep_mm_per_s : 0;
    bone_.Sweep(X_W, X_W, 0);  // removes the space that the tool occupies where it is first set down
  }

  /// The thrust and the number of teeth, integrated over time.
  struct Sums {
    double thrust_Ns = 0;
    double teeth_s = 0;
  };

  /// Moves the handle to X_H in `step_s`, and lets the tool follow.
  void Follow(const Pose& X_H, double step_s, Sums& sums) {
    const Vec3& p_TC = params_.coupling.p_TC_mm;
    const Vec3 v_H_W = (X_H.Point(p_TC) - X_H_.Point(p_TC)) / step_s;
    const Vec3 w_H_W = X_H_.Vector(TurnBetween(X_H_.R_AB, X_H.R_AB)) / step_s;
    X_H_ = X_H;
    f_damper_W_ = Vec3(0);
    double left_s = step_s;
    for (int n = 0; n < kMaxParts; ++n) {
      // In air the tool moves with the handle.
      const double motion_mm = glm::length(X_H.p_AB - X_T_.p_AB);
      if (bone_.solid().distance_mm(X_T_.p_AB) > 2 * (2 * reach_mm_ + motion_mm)) {
        SetPose(X_H);
        u_ = {};
        f_damper_W_ = Vec3(0);
        return;
      }
      SetUp(v_H_W, w_H_W, left_s);
      const bool free = problem_.cuts.empty() && problem_.walls.empty();
      u_ = free ? Join(problem_.x_mm / left_s, problem_.theta_rad / left_s) : FindMinimum(problem_, u_, reach_mm_).u;
      const double fraction = CalcFraction(left_s);
      const double time_s = fraction * left_s;
      AddUp(time_s, free, sums);
      Move(fraction == 1 && free ? X_H : Advanced(time_s), time_s);
      if (fraction == 1) return;
      left_s -= time_s;
    }
  }

  /// Lifts the tool out of the bone and sets it down at X, at rest.
  void SetDown(const Pose& X) {
    SetPose(X);
    X_H_ = X;
    u_ = {};
    f_damper_W_ = Vec3(0);
    std::fill(deflection_mm_.begin(), deflection_mm_.end(), 0.0);
  }

  Vec3 CalcForceOnHand() const {
    const Vec3& p_TC = params_.coupling.p_TC_mm;
    return problem_.spring.Pull(X_T_.Point(p_TC) - X_H_.Point(p_TC)) - f_damper_W_;
  }
  const Pose& X_WT() const { return X_T_; }
  double removed_mm3() const { return removed_mm3_; }
  ExactBone TakeBone() && { return std::move(bone_); }

 private:
  static constexpr int kMaxParts = 100000;  // maximum number of parts of a step

  /// Sets up the problem from the coupling and the bone at the tool's current pose.
  void SetUp(const Vec3& v_H_W, const Vec3& w_H_W, double time_s) {
    const Vec3& p_TC = params_.coupling.p_TC_mm;
    problem_.tau_s = time_s;
    problem_.x_mm = X_T_.InverseVector(X_H_.Point(p_TC) - X_T_.Point(p_TC));
    problem_.theta_rad = TurnBetween(X_T_.R_AB, X_H_.R_AB);
    problem_.v_H = X_T_.InverseVector(v_H_W);
    problem_.w_H = X_T_.InverseVector(w_H_W);
    FindCuts();
    FindWalls();
  }

  void FindCuts() {
    problem_.cuts.clear();
    const DiscSaw& saw = params_.saw;
    const Circle ahead{saw.radius_mm() + params_.fineness.look_ahead_mm, 0, true};
    FindPieces(bone_, saw, X_T_, ahead, 0, 2 * std::numbers::pi, params_.fineness.rim_points, pieces_);
    for (const Piece& piece : pieces_) {
      const double angle = 0.5 * (piece.from_rad + piece.to_rad);
      const Vec3 e(std::cos(angle), std::sin(angle), 0);
      const Vec3 r = saw.radius_mm() * e - params_.coupling.p_TC_mm;
      problem_.cuts.push_back({Join(e, glm::cross(r, e)),
                               saw.teeth / (2 * std::numbers::pi) * (piece.to_rad - piece.from_rad), piece.Cut(angle)});
    }
  }

  enum class Place { kAir, kNear, kInside };

  /// Classifies a pair of points of the flats relative to the uncut bone: in air by more than a step, near its surface,
  /// or inside by more than any spring deflection. The stored distance of the pair is reused until the tool has moved
  /// far enough.
  Place FindPlace(std::size_t i) {
    // The distance function may grow up to twice as fast as the distance.
    const double half_mm = 0.5 * params_.saw.thickness_mm;
    const double air_mm = 2 * (half_mm + max_motion_mm_);
    const double inside_mm = -(2 * half_mm + kDeep_mm);
    StoredDistance& stored = stored_[i];
    const double off_mm = 2 * (moved_mm_ - stored.moved_mm);
    if (stored.solid_mm - off_mm > air_mm) return Place::kAir;
    if (stored.solid_mm + off_mm < inside_mm) return Place::kInside;
    stored = {bone_.solid().distance_mm(X_T_.Point({flat_[i].x, flat_[i].y, 0})), moved_mm_};
    if (stored.solid_mm > air_mm) return Place::kAir;
    return stored.solid_mm < inside_mm ? Place::kInside : Place::kNear;
  }

  void SetPose(const Pose& X) {
    moved_mm_ += glm::length(X.p_AB - X_T_.p_AB) + reach_mm_ * glm::length(TurnBetween(X_T_.R_AB, X.R_AB));
    X_T_ = X;
  }

  void FindWalls() {
    problem_.walls.clear();
    // Only the tool's own motion deflects a spring: if the tool was set down in bone, the walls hold it but do not push
    // it out.
    const double half_mm = 0.5 * params_.saw.thickness_mm;
    const ExactSolid& solid = bone_.solid();
    wall_of_.clear();
    for (std::size_t i = 0; i < flat_.size(); ++i) {
      const FlatPoint& point = flat_[i];
      const Place place = FindPlace(i);
      if (place == Place::kAir) {
        deflection_mm_[2 * i] = deflection_mm_[2 * i + 1] = 0;
        continue;
      }
      double depth_mm[2];
      for (const int side : {0, 1}) {
        const Vec3 p_W = X_T_.Point({point.x, point.y, side == 0 ? -half_mm : half_mm});
        const double max_mm = place == Place::kInside ? kDeep_mm : std::min(kDeep_mm, -solid.distance_mm(p_W));
        // A wall that is further than max_motion_mm_ away cannot be reached in this step.
        depth_mm[side] = max_mm <= -max_motion_mm_ ? max_mm : bone_.SweptDistance(p_W, max_mm, -max_motion_mm_);
      }
      // In a bent kerf both walls press on the disc; the common part of the two depths has no effect and is subtracted.
      // If there is no kerf nearby, each wall acts separately.
      const double common_mm = std::max(0.0, std::min(depth_mm[0], depth_mm[1]));
      const double squeeze = common_mm < kDeep_mm ? common_mm : 0;
      for (const int side : {0, 1}) {
        double& deflection_mm = deflection_mm_[2 * i + static_cast<std::size_t>(side)];
        const double depth = std::min(depth_mm[side] - squeeze, deflection_mm);
        deflection_mm = 0;
        if (depth <= -max_motion_mm_) continue;
        const Vec3 n(0, 0, side == 0 ? -1 : 1);
        const Vec3 r = Vec3(point.x, point.y, side == 0 ? -half_mm : half_mm) - params_.coupling.p_TC_mm;
        problem_.walls.push_back({Join(n, glm::cross(r, n)), depth, kWall_N_per_mm3 * point.area_mm2});
        wall_of_.push_back(2 * i + static_cast<std::size_t>(side));
      }
    }
  }

  Pose Advanced(double time_s) const {
    const Vec3& p_TC = params_.coupling.p_TC_mm;
    const Vec3 C_W = X_T_.Point(p_TC) + X_T_.Vector(time_s * Upper(u_));
    Pose X{Turn(X_T_.R_AB, time_s * Lower(u_)), Vec3(0)};
    X.p_AB = C_W - X.Vector(p_TC);
    return X;
  }

  /// Returns the fraction of the motion until the next evaluation, in which no point of the disc moves further than
  /// max_motion_mm_.
  double CalcFraction(double time_s) const {
    const Pose X = Advanced(time_s);
    const double motion_mm = glm::length(X.p_AB - X_T_.p_AB) + glm::length(Lower(u_)) * time_s * reach_mm_;
    return std::min(1.0, max_motion_mm_ / std::max(motion_mm, 1e-12));
  }

  void AddUp(double time_s, bool free, Sums& sums) {
    f_damper_W_ = free ? Vec3(0) : X_T_.Vector(problem_.damper.Pull(problem_.v_H - Upper(u_)));
    for (const Cut& cut : problem_.cuts) {
      double speed = 0;
      for (int i = 0; i < 6; ++i) speed += cut.along[i] * u_[i];
      sums.teeth_s += time_s * cut.teeth;
      sums.thrust_Ns += time_s * cut.teeth * problem_.CalcTooth(speed, cut.bone);
    }
    for (std::size_t n = 0; n < wall_of_.size(); ++n) {
      const Wall& wall = problem_.walls[n];
      double speed = 0;
      for (int i = 0; i < 6; ++i) speed += wall.along[i] * u_[i];
      deflection_mm_[wall_of_[n]] = std::max(0.0, wall.depth_mm + time_s * speed);
    }
  }

  void Move(const Pose& X_next, double time_s) {
    const Vec3 w = TurnBetween(X_T_.R_AB, X_next.R_AB) / time_s;
    const Pose X_middle = Between(X_T_, X_next, 0.5);
    const Vec3 v = X_middle.InverseVector(X_next.p_AB - X_T_.p_AB) / time_s;
    removed_mm3_ += time_s * flux_.Calc(bone_, X_middle, v, w);
    bone_.Sweep(X_T_, X_next, params_.fineness.edge_mm);
    SetPose(X_next);
  }

  ReferenceParams params_;
  ExactBone bone_;
  std::vector<FlatPoint> flat_;
  std::vector<double> deflection_mm_;   // deflection of each point's spring, lower and upper flat alternately
  std::vector<std::size_t> wall_of_;    // index in deflection_mm_ of each of the problem's walls
  std::vector<StoredDistance> stored_;  // of each pair
  double moved_mm_ = 0;  // upper bound of the distance that any point of the disc has moved since the start
  Flux flux_;
  double reach_mm_;
  double max_motion_mm_;
  Pose X_T_, X_H_;
  MotionProblem problem_;
  std::vector<Piece> pieces_;
  Six u_{};
  Vec3 f_damper_W_{0};  // on the tool
  double removed_mm3_ = 0;
};

}  // namespace

ReferenceRun RunReferenceInHand(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WH,
                                const std::atomic<bool>* stop) {
  reference::Check(params, X_WH);
  if (params.rpm == 0)
    throw Error("the reference does not support a tool coupled to a handle with its spindle stopped");
  HeldTool tool(std::move(solid), params, X_WH[0]);
  const int steps = params.fineness.steps_per_tick;
  std::vector<ReferenceTick> ticks;
  for (std::size_t k = 1; k < X_WH.size(); ++k) {
    reference::StopIf(stop);
    HeldTool::Sums sums;
    if (IsSetDown(params, k)) tool.SetDown(X_WH[k]);
    for (int i = 1; i <= steps && !IsSetDown(params, k); ++i) {
      tool.Follow(Between(X_WH[k - 1], X_WH[k], static_cast<double>(i) / steps), params.tick_s / steps, sums);
    }
    ReferenceTick tick;
    tick.X_WT = tool.X_WT();
    tick.f_W_N = tool.CalcForceOnHand();
    tick.thrust_sum_N = sums.thrust_Ns / params.tick_s;
    tick.engaged_teeth = sums.teeth_s / params.tick_s;
    tick.removed_mm3 = tool.removed_mm3();
    ticks.push_back(tick);
  }
  ReferenceRun run{std::move(ticks), std::move(tool).TakeBone()};
  reference::SettleRemoved(run);
  return run;
}

}  // namespace kerf
