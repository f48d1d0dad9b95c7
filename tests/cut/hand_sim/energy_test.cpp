// For any motion of the hand: no energy is created, no force exceeds the coupling's, and runs are bit-identical.
#include <gtest/gtest.h>

#include <random>

#include "base/core/heap_guard.h"
#include "cut/hand_sim/hands.h"
#include "cut/tool/edge_down.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

constexpr double kVibration_N = 2;  // largest push of tooth_vibration

struct Case {
  CoupledParams params;
  double dt_s = 0.001;
  double rpm = 7500;
  double E_MPa = 19300;
};

Case MakeCase(std::mt19937_64& random, bool turning) {
  const auto log_uniform = [&](double lower, double upper) {
    return std::exp(std::uniform_real_distribution<double>(std::log(lower), std::log(upper))(random));
  };
  const auto one_of = [&](auto... values) {
    const double list[] = {static_cast<double>(values)...};
    return list[random() % (sizeof(list) / sizeof(list[0]))];
  };
  Case c;
  const char* laws[] = {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"};
  c.params.law = ForceLaw(laws[random() % 3]);
  c.params.coupling.stiffness_N_per_mm = log_uniform(0.1, 1e3);
  c.params.coupling.torsion_Nmm_per_rad = log_uniform(100, 1e6);
  c.params.coupling.max_force_N = log_uniform(2, 60);
  c.params.coupling.max_torque_Nmm = log_uniform(100, 5000);
  if (random() % 2) c.params.coupling.p_TC_mm = {0, 0, 40};
  if (random() % 2) c.params.coupling.damping_Ns_per_mm = log_uniform(1e-4, 0.1);
  SetEffect(c.params.effects, "kerf_friction", "coefficient", one_of(0, 0.2, 0.5, 2));
  c.params.max_iterations = static_cast<int>(one_of(2, 5, 40));
  c.dt_s = one_of(0.00025, 0.001, 0.004);
  c.rpm = turning ? one_of(-7500, 100, 7500, 60000) : 0;
  c.E_MPa = log_uniform(1e2, 1e7);
  return c;
}

/// Tool of a case: hands 0 to 59 have a disc, then burs and drills take turns up to 119, then blades with a stroke.
Tool PickTool(int hand) {
  if (hand < 60) return test::DiscParams().tool;
  if (hand >= 180) return hand % 2 == 0 ? Tool(OscillatingBlade{}) : Tool(PiezoInsert{});
  if (hand >= 120) return ReciprocatingBlade{.length_mm = 20, .p_TG_mm = {0, -100, 0}};
  if (hand % 2 == 0) return FissureBur{.diameter_mm = 1.2, .length_mm = 5, .taper = 0.7, .point_angle_deg = 100};
  return TwistDrill{.diameter_mm = 1.1, .length_mm = 8};
}

/// Adds all effects that a block without structures can have.
void AddEffects(std::mt19937_64& random, EffectChoices& effects) {
  for (const char* name : {"tangential_force", "spindle", "heat", "sound", "chips"}) effects.emplace_back(name);
  SetEffect(effects, "tooth_vibration", "max_N", kVibration_N);
  SetEffect(effects, "spindle", "stall_torque_Nmm", random() % 2 == 0 ? 10.0 : 300.0);
  SetEffect(effects, "guide", "depth_direction", Vec3(0, 0, -1));
  SetEffect(effects, "guide", "normal", Vec3(0, 1, 0));
  SetEffect(effects, "guide", "depth_mm", random() % 2 == 0 ? 1.0 : 4.0);
}

/// A hand that drifts smoothly and sometimes jumps. A disc's spindle is horizontal, that of a solid of revolution
/// vertical, and the edge of a blade with a stroke lies along the block.
class WanderingHand {
 public:
  explicit WanderingHand(std::mt19937_64& random, const Tool& tool = DiscSaw{})
      : random_(random),
        lift_mm_(std::holds_alternative<DiscSaw>(tool) ? kR : 0),
        R_(IsBlade(tool) ? DiscPose(Pose{}, {}).R_AB : Quat(1, 0, 0, 0)),
        p_(0, 0, 2 + lift_mm_ + 0.1) {
    // x of T, the direction of the feed, is -z, and y of T is x.
    if (CalcStroke(tool) > 0) R_ = CalcEdgeDown();
  }
  Pose Next(double dt_s) {
    std::normal_distribution<double> normal;
    for (double* v : {&v_.x, &v_.y, &v_.z}) *v += -*v * 5 * dt_s + 60 * std::sqrt(dt_s) * normal(random_);
    for (double* w : {&w_.x, &w_.y, &w_.z}) *w += -*w * 5 * dt_s + 1.5 * std::sqrt(dt_s) * normal(random_);
    p_ += v_ * dt_s;
    p_ -= 8 * dt_s * (p_ - Vec3(0, 0, 2 + lift_mm_ - 1));  // the hand is attracted to a pose slightly inside the bone
    theta_ += w_ * dt_s;
    theta_ *= 1 - 2 * dt_s;
    if (random_() % 400 == 0) p_ += Vec3(normal(random_), normal(random_), normal(random_)) * 10.0;
    Pose X{R_, p_};
    const double angle = glm::length(theta_);
    if (angle > 0) X.R_AB = X.R_AB * glm::angleAxis(angle, theta_ / angle);
    return X;
  }

 private:
  std::mt19937_64& random_;
  double lift_mm_;  // of the tool's origin above its lowest point
  Quat R_;
  Vec3 p_;
  Vec3 v_{0}, w_{0}, theta_{0};
};

class EnergyOverHands : public testing::TestWithParam<int> {};

TEST_P(EnergyOverHands, IsNeverCreated) {
  std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()) * 7919 + 1);
  const bool turning = GetParam() / (GetParam() < 60 ? 1 : 2) % 2 == 1;
  Case c = MakeCase(random, turning);
  c.params.tool = PickTool(GetParam());
  if (std::holds_alternative<PiezoInsert>(c.params.tool)) c.rpm = std::abs(28 * c.rpm);  // up to 28 kHz
  const bool all_effects = GetParam() >= 140;
  if (all_effects) AddEffects(random, c.params.effects);
  Bone bone = test::MakeBox(Pose{}, {12, IsBlade(c.params.tool) ? 2.0 : 8.0, 4}, 0.2);
  bone.set_materials(test::OneRegionTable(24, c.E_MPa, 0.28));
  const std::uint64_t hash = bone.CalcHash();
  WanderingHand hand(random, c.params.tool);
  CoupledSimulation simulation(bone, c.params, hand.Next(c.dt_s));
  double hand_mJ = 0, spindle_mJ = 0, stored_mJ = 0, lost_mJ = 0, max_mJ = 0;
  int touched = 0;
  const HeapUseCounter heap;
  for (int i = 0; i < 1500; ++i) {
    // For every third hand the spindle is also switched, and for half of them the fidelity changes.
    const double rpm = GetParam() % 3 == 0 && i / 200 % 2 == 1 ? 0 : c.rpm;
    if (GetParam() % 4 >= 2) simulation.SetFidelity(static_cast<Fidelity>(i / 150 % 3));
    const CoupledInput in = Handle(hand.Next(c.dt_s), rpm, c.dt_s);
    const CoupledOutput out = [&] {
      const HeapGuard guard;
      return simulation.Tick(in);
    }();
    ASSERT_TRUE(IsValid(out.X_WT));
    ASSERT_LE(glm::length(out.f_H_W_N),
              (c.params.coupling.damping_Ns_per_mm > 0 ? 2 : 1) * c.params.coupling.max_force_N * (1 + 1e-12) +
                  (all_effects ? kVibration_N : 0));
    ASSERT_LE(glm::length(out.tau_H_W_Nmm), c.params.coupling.max_torque_Nmm * (1 + 1e-12));
    ASSERT_GE(out.cut_mJ, 0);
    ASSERT_GE(out.friction_mJ, 0);
    ASSERT_GE(out.damping_mJ, 0);
    ASSERT_LE(out.substeps, c.params.max_substeps);
    ASSERT_LE(out.iterations, c.params.max_iterations);
    hand_mJ += out.hand_mJ;
    spindle_mJ += out.spindle_mJ;
    stored_mJ += out.stored_mJ;
    lost_mJ += out.cut_mJ + out.friction_mJ + out.numerical_mJ;
    max_mJ = std::max(max_mJ, std::abs(hand_mJ) + std::abs(spindle_mJ));
    touched += glm::length(out.f_H_W_N) > 0;
    // 1e-7 allows for the work of the solver's residual force over the whole motion.
    ASSERT_GE(stored_mJ, -1e-9);
    ASSERT_GE(lost_mJ, -1e-7 * (1 + max_mJ)) << i;
    ASSERT_GE(hand_mJ + spindle_mJ, -1e-7 * (1 + max_mJ)) << i;
    if (!turning) {
      ASSERT_EQ(out.spindle_mJ, 0);
      ASSERT_EQ(out.removed_mm3, 0);
    }
  }
  EXPECT_EQ(heap.count(), 0);                           // always 0 if HeapGuardIsInstalled() returns false
  EXPECT_GT(touched, IsBlade(c.params.tool) ? 10 : 0);  // a jump takes a thin tool away from the bone
  if (!turning) {
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), hash);
  }
}
INSTANTIATE_TEST_SUITE_P(Random, EnergyOverHands, testing::Range(0, 240));

TEST(CoupledSimulation, SameCallsGiveTheSameBits) {
  CoupledOutput last[2];
  std::uint64_t hash[2];
  for (int run = 0; run < 2; ++run) {
    std::mt19937_64 random(5);
    const Bone bone = test::MakeBox(Pose{}, {12, 2, 4}, 0.2);
    WanderingHand hand(random);
    CoupledSimulation simulation(bone, test::DiscParams(), hand.Next(0.001));
    for (int i = 0; i < 1500; ++i) last[run] = simulation.Tick(Handle(hand.Next(0.001)));
    hash[run] = simulation.UpdateBone().CalcHash();
  }
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_EQ(last[0].f_H_W_N, last[1].f_H_W_N);
  EXPECT_EQ(last[0].tau_H_W_Nmm, last[1].tau_H_W_Nmm);
  EXPECT_EQ(last[0].X_WT.p_AB, last[1].X_WT.p_AB);
  EXPECT_EQ(last[0].numerical_mJ, last[1].numerical_mJ);
}

}  // namespace
}  // namespace kerf
