// handpiece: what holds the tool and does not cut meets bone: the hub of a disc, the shank of a bur, neck and handle.
//
//   Points on these solids (cut/tool/handpiece.h) have one-sided springs towards the bone that is left. The springs are
//   part of the step's convex problem: their stiffness is positive, and their direction, the gradient of the distance
//   field, is fixed in a step. Like other contacts, a spring is deflected at the start of a step at most as far as at
//   the end of the last one, unless earlier losses cover the energy (PenetrationLimiter): they hold, but never throw.
//   Friction uses the force of each point in the last step.
//
// On a path the tool does not yield, so that the force of a rigid solid in bone is undefined: only the depth is
// measured.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "cut/contact/penetration_limiter.h"
#include "cut/effects/effect.h"
#include "cut/effects/effects.h"
#include "cut/effects/handpiece/holder_points.h"
#include "cut/effects/parameters.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxContacts = 64;
constexpr double kHolderStepVoxels = 0.5;    // largest motion of a point in a substep
constexpr double kHolderReachVoxels = 0.75;  // points within this distance of bone are in the step's problem
constexpr double kNormalVoxels = 0.5;        // from the point to the samples that give the direction of the bone
constexpr double kLeastGradient = 0.1;       // deep in the bone the gradient vanishes
constexpr double kLeastAlignment = -0.2;     // cosine between the outward normal and the bone's direction

struct HandpieceParams {
  double stiffness_N_per_mm = 1000;
  double friction = 0.2;
  double spacing_mm = 3;
};

template <typename V>
void Describe(HandpieceParams& p, V&& visit) {
  visit("stiffness_N_per_mm", p.stiffness_N_per_mm, Range{1, 100'000},
        "stiffness of each of its points that touch bone");
  visit("friction", p.friction, Range{0, 2}, "coefficient of friction on bone");
  visit("spacing_mm", p.spacing_mm, Range{0.5, 20},
        "largest distance between two rings of points; at most the radius there, and larger if there were more than "
        "1024 points");
}

class HandpieceEffect final : public Effect {
 public:
  HandpieceEffect(const HandpieceParams& params, const EffectSetup& setup)
      : stiffness_N_per_mm_(params.stiffness_N_per_mm),
        friction_(params.friction),
        field_(setup.field),
        in_hand_(setup.faces != nullptr),
        p_TC_(setup.p_TC_mm),
        points_(setup.field, setup.tool, params.spacing_mm),
        penetration_(points_.points().size()),
        pressing_N_(points_.points().size(), 0.0) {
    found_.reserve(points_.points().size());
  }

  bool Holds(const EffectFlight& flight) override { return !points_.IsClear(flight.X_FT_from, flight.X_FT_to); }

  void Engage(const EffectStep& step, StepProblem& problem) override {
    if (!step.reads_bone) return;
    const Probe probe(field_, step.X_FT);
    const std::span<const HolderPoints::Found> found = points_.Find(probe, kHolderReachVoxels * field_.voxel_mm());
    for (const HolderPoints::Found& f : found) deepest_mm_ = std::max(deepest_mm_, -f.distance_mm);
    if (!in_hand_) return;
    problem.limits = points_.CalcLimits(p_TC_, kHolderStepVoxels * field_.voxel_mm());
    if (found.empty() && count_ == 0) return;
    Choose(found);
    AddSprings(step, probe, problem);
  }

  void Solved(const EffectSolved& solved) override {
    Vec3 f_T(0), f_hub_T(0);
    energy_mJ_ = 0;
    for (std::size_t n = 0; n < count_; ++n) {
      const SolidPoint& p = solved.problem.solids[first_ + n];
      const double motion_mm = solved.problem.tau_s * Dot(p.row, solved.u);
      const double depth_mm = std::max(0.0, p.depth_mm + solved.fraction * motion_mm);
      penetration_.set_known_mm(held_[n], depth_mm);
      energy_mJ_ += 0.5 * stiffness_N_per_mm_ * depth_mm * depth_mm;
      const double pressing_N = stiffness_N_per_mm_ * std::max(0.0, p.depth_mm + motion_mm);
      pressing_N_[static_cast<std::size_t>(held_[n])] = pressing_N;
      const Vec3 f = -pressing_N * Vec3(p.row[0], p.row[1], p.row[2]);
      f_T += f;
      if (points_.points()[static_cast<std::size_t>(held_[n])].hub) f_hub_T += f;
    }
    force_N_ = glm::length(f_T);
    hub_N_ = glm::length(f_hub_T);
  }

  void End(EffectEnd&) override {
    channels_ = {force_N_, hub_N_, deepest_mm_};
    force_N_ = hub_N_ = deepest_mm_ = 0;
  }
  void Release() override {
    for (std::size_t n = 0; n < count_; ++n) Forget(held_[n]);
    count_ = 0;
    energy_mJ_ = 0;
  }
  void Reset() override {
    Release();
    points_.Forget();
    force_N_ = hub_N_ = deepest_mm_ = 0;
    channels_ = {};
  }
  void Report(std::span<double> channels) const override {
    std::copy(channels_.begin(), channels_.end(), channels.begin());
  }

  bool reads_teeth() const override { return false; }
  EffectCapacity capacity() const override {
    const std::size_t contacts = in_hand_ ? kMaxContacts : 0;
    return {contacts, contacts};
  }
  std::size_t CalcMemoryBytes() const override {
    return sizeof(*this) + points_.CalcMemoryBytes() + found_.capacity() * sizeof(HolderPoints::Found) +
           2 * penetration_.size() * sizeof(double);
  }

 private:
  /// Chooses the deepest points, in their order, and sets the deflections of those before to 0.
  void Choose(std::span<const HolderPoints::Found> found) {
    found_.assign(found.begin(), found.end());
    if (found_.size() > kMaxContacts) {
      const auto end = found_.begin() + kMaxContacts;
      std::nth_element(found_.begin(), end, found_.end(), [](const auto& a, const auto& b) {
        return a.distance_mm != b.distance_mm ? a.distance_mm < b.distance_mm : a.point < b.point;
      });
      found_.erase(end, found_.end());
      std::sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.point < b.point; });
    }
    std::size_t next = 0;
    for (std::size_t n = 0; n < count_; ++n) {
      while (next < found_.size() && found_[next].point < held_[n]) ++next;
      if (next == found_.size() || found_[next].point != held_[n]) Forget(held_[n]);
    }
  }

  void Forget(int point) {
    penetration_.set_known_mm(point, 0);
    pressing_N_[static_cast<std::size_t>(point)] = 0;
  }

  void AddSprings(const EffectStep& step, const Probe& probe, StepProblem& problem) {
    // A point far deeper than its spring was set down in bone. It stays there, so that the bone does not clamp the
    // tool.
    const auto limit = [&](const HolderPoints::Found& f, bool may_rise) {
      const double held_mm = penetration_.Limit(f.point, -f.distance_mm, problem.tau_s, false);
      const bool slid = -f.distance_mm - held_mm < field_.voxel_mm();
      return may_rise && slid ? penetration_.Limit(f.point, -f.distance_mm, problem.tau_s, true) : held_mm;
    };
    double risen_mJ = 0;
    for (const HolderPoints::Found& f : found_) {
      const double depth_mm = std::max(0.0, limit(f, true));
      risen_mJ += 0.5 * stiffness_N_per_mm_ * depth_mm * depth_mm;
    }
    const bool may_rise = risen_mJ - energy_mJ_ <= step.reserve_mJ;
    first_ = problem.solids.size();
    count_ = found_.size();
    energy_mJ_ = 0;
    for (std::size_t n = 0; n < count_; ++n) {
      const HolderPoints::Found& f = found_[n];
      const HolderPoints::Point& point = points_.points()[static_cast<std::size_t>(f.point)];
      const double depth_mm = limit(f, may_rise);
      held_[n] = f.point;
      const double known_mm = std::max(0.0, depth_mm);
      penetration_.set_known_mm(f.point, known_mm);
      energy_mJ_ += 0.5 * stiffness_N_per_mm_ * known_mm * known_mm;
      const Vec3 into = FindBone(probe, point);
      const Vec3 r = point.p_T - p_TC_;
      problem.solids.push_back({MakeRow(into, r), depth_mm, stiffness_N_per_mm_});
      const double limit_N = friction_ * pressing_N_[static_cast<std::size_t>(f.point)];
      if (!(limit_N > 0)) continue;
      const Vec3 a = glm::normalize(glm::cross(into, std::abs(into.z) < 0.7 ? Vec3(0, 0, 1) : Vec3(1, 0, 0)));
      problem.frictions.push_back({MakeRow(a, r), MakeRow(glm::cross(into, a), r), 0, 0, limit_N});
    }
  }

  /// Returns the direction from a point towards the bone. Where the bone's middle lies behind the point, as in a thin
  /// wall that it has half passed, it is the outward normal, so that the wall does not push the point through.
  Vec3 FindBone(const Probe& probe, const HolderPoints::Point& point) const {
    const double aside_mm = kNormalVoxels * field_.voxel_mm();
    Vec3 away(0);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 aside(0);
      aside[axis] = aside_mm;
      away[axis] = (probe.Distance(point.p_T + aside) - probe.Distance(point.p_T - aside)) / (2 * aside_mm);
    }
    const double length = glm::length(away);
    if (!(length > kLeastGradient) || glm::dot(away, point.n_T) > -kLeastAlignment * length) return point.n_T;
    return -away / length;
  }

  double stiffness_N_per_mm_;
  double friction_;
  const BoneField& field_;
  bool in_hand_;
  Vec3 p_TC_;
  HolderPoints points_;
  PenetrationLimiter penetration_;
  std::vector<double> pressing_N_;  // of each point in the last step
  std::vector<HolderPoints::Found> found_;
  std::array<int, kMaxContacts> held_{};  // points in the problem of the step
  std::size_t count_ = 0;
  std::size_t first_ = 0;  // index of the first in the problem's solids
  double energy_mJ_ = 0;   // of the springs at the end of the last step
  double force_N_ = 0, hub_N_ = 0, deepest_mm_ = 0;
  std::array<double, 3> channels_{};
};

}  // namespace

const EffectInfo& Handpiece() {
  static const EffectInfo kEffect{
      .name = "handpiece",
      .summary = "resistance of bone to what holds the tool: hub, shank, neck and handle; on a path only its depth",
      .source = "one-sided springs, Coulomb's law; shapes, stiffness and coefficient are assumptions",
      .reads = "the tool's pose, the distance from the bone that is left",
      .writes = "force and torque on the tool",
      .state = "deflection and force of up to 1024 points, bounds on their distances from the bone",
      .sleeps = "while all of it is further away from bone than it moves",
      .hooks = kEffectHolds | kEffectEngage | kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<HandpieceParams>(),
      .channels = {{"force_N", "force of the bone on hub, shank, neck and handle together"},
                   {"hub_N", "part of it on the hub of a disc"},
                   {"depth_mm", "largest depth of one of its points in bone, up to three voxels"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<HandpieceEffect>(ReadEffectParameters<HandpieceParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
