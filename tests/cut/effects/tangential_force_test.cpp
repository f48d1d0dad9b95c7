// The force along the motion of the teeth, compared with closed forms; its stability; and the force that a hand feels.
#include "cut/effects/tangential_force.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/hands.h"
#include "cut/hand_sim/internals.h"
#include "experiment/stability/closed_loop.h"
#include "experiment/stability/held_block.h"
#include "experiment/stability/measures.h"
#include "support/message_of.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

EffectChoices With(double ratio) {
  EffectChoices effects;
  SetEffect(effects, "tangential_force", "ratio", ratio);
  return effects;
}

/// A stroke along +x through a block whose top is at z = 4, on a path; `out` is the last tick.
struct PathStroke {
  PathStroke(const Tool& tool, const char* law, double centre_z, double rpm, const EffectChoices& effects,
             double length_mm = 4)
      : simulation(test::MakeBox(Pose{}, {36, 3, 40}, 0.4), MakeParams(tool, law, effects),
                   DiscPose(Pose{}, {-18 - CalcReach(tool) - 0.5, 0, centre_z})) {
    const Vec3 from(-18 - CalcReach(tool) - 0.5, 0, centre_z);
    for (const TickOutput& tick :
         test::Stroke(simulation, Pose{}, from, from + Vec3(CalcReach(tool) + length_mm, 0, 0), 20, rpm)) {
      before = out;
      out = tick;
    }
  }
  static SimulationParams MakeParams(const Tool& tool, const char* law, const EffectChoices& effects) {
    SimulationParams params;
    params.tool = tool;
    params.law = ForceLaw(law);
    params.effects = effects;
    return params;
  }
  Simulation simulation;
  TickOutput out;
  TickOutput before;  // the tick before: on a path the force follows from the thrust of the previous step
};

// Each tooth's tangential force is its thrust rotated by a quarter turn and divided by the ratio. The same applies to
// the sums, for any arc and law: the resultant is at the angle arctan(1 / ratio) to the thrust.
TEST(TangentialForce, IsTheThrustRotatedByAQuarterTurnOverTheRatio) {
  for (const char* law : {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"}) {
    for (const double centre_z : {0.0, 20.0, 28.0}) {  // bone all around; half buried; 3 mm deep
      const PathStroke alone(kSaw, law, centre_z, 7500, {});
      const TickOutput& thrust = alone.before;
      ASSERT_GT(thrust.engaged_teeth, 1);
      for (const double ratio : {0.6, 1.6}) {
        const PathStroke forwards(kSaw, law, centre_z, 7500, With(ratio));
        const PathStroke backwards(kSaw, law, centre_z, -7500, With(ratio));
        // The force on the tool is opposite to the teeth's motion, which is along z x e for rpm > 0 (the spindle is +y
        // of the block): it is the thrust, along -e, rotated by +90 degrees.
        const Vec3 f = forwards.out.f_T_W_N - alone.out.f_T_W_N;
        const Vec3 turned = glm::cross(Vec3(0, 1, 0), thrust.f_T_W_N) / ratio;
        EXPECT_LT(glm::length(f - turned), 1e-9 * glm::length(turned)) << law << " " << ratio;
        EXPECT_NEAR(std::acos(glm::dot(glm::normalize(thrust.f_T_W_N + f), glm::normalize(thrust.f_T_W_N))),
                    std::atan(1 / ratio), 1e-7);
        // With the spindle reversed, the force is opposite.
        EXPECT_LT(glm::length(backwards.out.f_T_W_N - alone.out.f_T_W_N + turned), 1e-9 * glm::length(turned));
        // The torque about the spindle is the radius times the sum and acts against the rotation; the power is torque
        // times speed.
        const double torque = kR * thrust.thrust_sum_N / ratio;
        EXPECT_NEAR(glm::dot(forwards.out.tau_TG_W_Nmm, Vec3(0, 1, 0)), -torque, 1e-9 * torque);
        EXPECT_NEAR(glm::dot(backwards.out.tau_TG_W_Nmm, Vec3(0, 1, 0)), torque, 1e-9 * torque);
        for (const PathStroke* stroke : {&forwards, &backwards}) {
          const auto& figures = TangentialForceEffect::In(EffectsOf(stroke->simulation)).figures();
          EXPECT_NEAR(figures.sum_N, thrust.thrust_sum_N / ratio, 1e-9 * figures.sum_N);
          EXPECT_NEAR(figures.torque_Nmm, torque, 1e-9 * torque);
          EXPECT_NEAR(figures.power_W, 1e-3 * torque * 7500 * std::numbers::pi / 30, 1e-9 * figures.power_W);
        }
      }
    }
  }
}

TEST(TangentialForce, MatchesTheClosedFormForAConstantToothForce) {
  // The tooth force F does not depend on the bite, and half of the rim, n/2 teeth, is engaged. The resultant of the
  // thrusts is n F / pi against the feed, that of the tangential forces n F / (pi ratio) across it.
  const PathStroke stroke(kSaw, "hertz_constant_bite", 0, 7500, With(1.6), 13);
  const double tooth_N = stroke.out.thrust_sum_N / stroke.out.engaged_teeth;
  // 2 % allows for the onset error of the engagement at the ends of the arc (docs/physics.md), with voxels of 0.4 mm.
  EXPECT_NEAR(stroke.out.engaged_teeth, 12, 0.24);
  EXPECT_NEAR(stroke.out.f_T_W_N.x, -24 * tooth_N / std::numbers::pi, 0.02 * 24 * tooth_N / std::numbers::pi);
  const auto& figures = TangentialForceEffect::In(EffectsOf(stroke.simulation)).figures();
  EXPECT_NEAR(glm::length(figures.pull_T_N), 24 * tooth_N / std::numbers::pi / 1.6,
              0.02 * 24 * tooth_N / std::numbers::pi / 1.6);
  EXPECT_NEAR(figures.sum_N, 12 * tooth_N / 1.6, 0.02 * 12 * tooth_N / 1.6);
}

TEST(TangentialForce, AssistsAClimbCutAndResistsAConventionalCut) {
  // At the lowest point of the rim the teeth move along -x for rpm > 0: a feed along +x is a climb cut.
  const double thrust_x = PathStroke(kSaw, "hertz_chip", 28, 7500, {}).out.f_T_W_N.x;
  EXPECT_GT(PathStroke(kSaw, "hertz_chip", 28, 7500, With(1.6)).out.f_T_W_N.x - thrust_x, 0.1);
  EXPECT_LT(PathStroke(kSaw, "hertz_chip", 28, -7500, With(1.6)).out.f_T_W_N.x - thrust_x, -0.1);
}

TEST(TangentialForce, LeavesBoneAndMotionOnAPathUnchanged) {
  PathStroke without(kSaw, "hertz_chip", 20, 7500, {});
  PathStroke with(kSaw, "hertz_chip", 20, 7500, With(1.6));
  EXPECT_EQ(with.out.removed_mm3, without.out.removed_mm3);
  EXPECT_EQ(with.out.thrust_sum_N, without.out.thrust_sum_N);
  EXPECT_EQ(with.simulation.UpdateBone().CalcHash(), without.simulation.UpdateBone().CalcHash());
}

/// The objects that a step needs, so that it can be tested without a simulation.
struct Parts {
  explicit Parts(const Tool& the_tool, const Vec3& p_TC_mm, const ForceLaw& the_law = ForceLaw("hertz_chip"))
      : tool(the_tool),
        law(MakeToothForce(the_law, the_tool)),
        bone(test::MakeBox(Pose{}, {4, 4, 4}, 0.5)),
        field(bone, 8),
        shape(MakeToolShape(tool, {8, 1.4, 0.5, 0.1})),
        edge(field, bone, tool, shape, p_TC_mm),
        faces(field, shape, p_TC_mm),
        effect(1.6, {bone, field, tool, shape, edge, law, &faces, p_TC_mm, Vec3(0)}) {}
  Tool tool;
  ToothForce law;
  Bone bone;
  BoneField field;
  ToolShape shape;
  Edge edge;
  Faces faces;
  TangentialForceEffect effect;
};

TEST(TangentialForce, LawWithTooMuchCuttingForceIsRefusedInAHand) {
  ForceLaw law("two_component");
  EXPECT_NEAR(Parts(Tool(kSaw), Vec3(0), law).effect.ratio(), 9.66 / 6.83, 1e-12);
  law.Set("thrust_edge_N_per_mm", 4);  // 4 / 6.83 = 0.586
  EXPECT_EQ(test::MessageOf([&] { Parts(Tool(kSaw), Vec3(0), law); }),
            "tangential_force: the law's ratio of thrust to cutting force, or of their changes with the bite, is as "
            "small as 0.586; for a tool in a hand it must be at least 0.6");
}

TEST(TangentialForce, SumOverSectorsEqualsSumOverTeeth) {
  // Compared with brute force: at each tooth, a force perpendicular to its radius and against its motion. Also tested
  // for a ball, whose teeth are not in one plane.
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{})}) {
    for (const Vec3& p_TC : {Vec3(0), Vec3(3, -7, 80)}) {
      for (const double rpm : {-20000.0, -300.0, 7500.0}) {
        Parts parts(tool, p_TC);
        std::vector<ToothLoad> teeth;
        Twist expected{};
        double sum_N = 0, torque_Nmm = 0;
        for (const EdgePoint& place : parts.shape.edge) {
          if (uniform(random) < 0.4) continue;
          ToothLoad tooth;
          tooth.p_T = place.p_T;
          tooth.e_T = place.e_T;
          tooth.thrust_N = tooth.thrust_on_way_N = uniform(random);
          const Vec3 direction_T = glm::normalize(glm::cross(Vec3(0, 0, 1), place.p_T)) * (rpm > 0 ? 1.0 : -1.0);
          AddTo(expected, -tooth.thrust_N / 1.6, MakeRow(direction_T, place.p_T - p_TC));
          sum_N += tooth.thrust_N / 1.6;
          torque_Nmm += tooth.thrust_N / 1.6 * std::hypot(place.p_T.x, place.p_T.y);
          teeth.push_back(tooth);
        }
        StepProblem problem;
        problem.tau_s = 1;
        problem.creep_mm_per_s = 1e-7;  // otherwise a ball's slow teeth near its axis would stick slightly
        const Pose X;
        const Twist u{};
        // The force approaches its value with a lag: each step multiplies the difference by 1 / (1 + 1.6^2), which
        // depends on the ratio.
        for (int i = 0; i < 40; ++i) {
          parts.effect.Solved({X, X, parts.edge, &parts.faces, problem, u, 1, 1, rpm, teeth});
        }
        parts.effect.Engage({X, Probe(parts.field, X), parts.edge, &parts.faces, rpm, true}, problem);
        ASSERT_LE(problem.frictions.size(), parts.effect.capacity().frictions);
        StepProblem nothing;
        const Twist with = problem.CalcGradient(u);
        for (int k = 0; k < 6; ++k) {
          const double scale = k < 3 ? sum_N : sum_N * 90;
          EXPECT_NEAR(-with[k], expected[k], 1e-9 * scale) << k << " " << rpm;
        }
        for (const ToothLoad& tooth : teeth) EXPECT_EQ(tooth.tangential_N, tooth.thrust_N / 1.6);
        parts.effect.Solved({X, X, parts.edge, &parts.faces, problem, u, 1, 1, rpm, teeth});
        EffectEnd end{41, rpm, rpm, X, false, 0, 0, 0};
        parts.effect.End(end);
        EXPECT_GT(parts.effect.figures().power_W, 0);
        const auto& f = parts.effect.figures();
        EXPECT_NEAR(f.power_W, 1e-3 * f.torque_Nmm * std::abs(rpm) * std::numbers::pi / 30, 1e-9 * f.power_W);
        EXPECT_NEAR(f.torque_Nmm / f.sum_N, torque_Nmm / sum_N, 1e-9 * kR);
      }
    }
  }
}

// ---- in a hand

CoupledParams MakeTangentialParams(double ratio) {
  CoupledParams params = test::DiscParams();
  SetEffect(params.effects, "tangential_force", "ratio", ratio);
  return params;
}

TEST(TangentialForce, OfAPushedSawIsProportionalToItsThrust) {
  // A stiff coupling moves the tool down into the block. The tool cannot move sideways, so the hand feels the full
  // force.
  CoupledParams params = MakeTangentialParams(1.6);
  params.law = ForceLaw("hertz_chip");
  params.coupling.stiffness_N_per_mm = 50;
  params.coupling.torsion_Nmm_per_rad = 1e6;
  for (const double rpm : {7500.0, -7500.0}) {
    CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 3, 8}, 0.2), params, DiscPose(Pose{}, {0, 0, 4 + kR}));
    CoupledOutput out;
    for (int i = 1; i <= 2000; ++i) out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 4 + kR - 0.001 * i}), rpm));
    const auto& f = TangentialForceEffect::In(EffectsOf(simulation)).figures();
    // The force is steady except that the arc grows: during the lag of 4 ms the depth increases by 4 of 2000 um, and
    // the arc by 0.1 % of its length.
    EXPECT_NEAR(f.sum_N, out.thrust_sum_N / 1.6, 0.003 * f.sum_N);
    EXPECT_NEAR(f.torque_Nmm, kR * f.sum_N, 1e-9 * f.torque_Nmm);
    // The teeth at the bottom move along -x for rpm > 0, so the tool is pulled along +x.
    EXPECT_GT(f.sum_N, 1);
    EXPECT_NEAR(out.f_friction_W_N.x * (rpm > 0 ? 1 : -1), -out.f_cut_W_N.z * -1 / 1.6, 0.05 * f.sum_N);
  }
}

TEST(TangentialForce, ReturnsNoMoreEnergyThanTheSpindlePutIn) {
  // Hands that drift, jump and tilt, with random stiffnesses, ratios, laws, tick lengths and speeds.
  for (int seed = 0; seed < 16; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) * 977 + 5);
    const auto log_uniform = [&](double lower, double upper) {
      return std::exp(std::uniform_real_distribution<double>(std::log(lower), std::log(upper))(random));
    };
    CoupledParams params = MakeTangentialParams(std::max(0.6, log_uniform(0.2, 20)));
    if (seed % 3 == 0) RemoveEffect(params.effects, "kerf_friction");
    const char* laws[] = {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"};
    params.law = ForceLaw(laws[seed % 3]);
    params.coupling.stiffness_N_per_mm = log_uniform(0.2, 1e3);
    params.coupling.torsion_Nmm_per_rad = log_uniform(100, 1e6);
    if (seed % 2) params.coupling.p_TC_mm = {0, 0, 60};
    if (seed % 4 == 3) params.coupling.damping_Ns_per_mm = log_uniform(1e-4, 0.1);
    const double dts[] = {0.00025, 0.001, 0.004, 0.1};
    const double dt_s = dts[random() % 4];
    const double speeds[] = {-7500, 7500, 3, 60000};
    const double rpm = speeds[random() % 4];
    CoupledSimulation simulation(test::MakeBox(Pose{}, {12, 2, 4}, 0.2), params, DiscPose(Pose{}, {0, 0, 2 + kR}));
    std::normal_distribution<double> normal;
    Vec3 p(0, 0, 2 + kR - 0.5), v(0);
    double hand_mJ = 0, spindle_mJ = 0, work_mJ = 0, max_mJ = 0, lost_mJ = 0, max_N = 0;
    const HeapUseCounter heap;
    for (int i = 0; i < 1200; ++i) {
      v = 0.99 * v + Vec3(normal(random), normal(random), normal(random)) * 2.0;
      p += v * std::min(dt_s, 0.001);
      p -= 0.01 * (p - Vec3(0, 0, 2 + kR - 1));
      if (random() % 300 == 0) p += Vec3(normal(random), normal(random), normal(random)) * 5.0;
      Pose X = DiscPose(Pose{}, p);
      X.R_AB = X.R_AB * glm::angleAxis(0.1 * std::sin(0.01 * i), Vec3(1, 0, 0));
      const CoupledOutput out = [&] {
        const HeapGuard guard;
        return simulation.Tick(Handle(X, i % 400 < 350 ? rpm : -rpm, dt_s));
      }();
      ASSERT_TRUE(IsValid(out.X_WT));
      ASSERT_GE(out.spindle_mJ, 0);
      ASSERT_GE(out.friction_mJ, 0);
      hand_mJ += out.hand_mJ;
      spindle_mJ += out.spindle_mJ;
      lost_mJ += out.cut_mJ + out.friction_mJ + out.numerical_mJ;
      const auto& f = TangentialForceEffect::In(EffectsOf(simulation)).figures();
      ASSERT_TRUE(std::isfinite(f.power_W));
      work_mJ += std::max(1e3 * f.power_W * dt_s, 0.0);
      max_N = std::max(max_N, f.sum_N);
      max_mJ = std::max(max_mJ, std::abs(hand_mJ) + spindle_mJ);
      // 1e-7 allows for the work of the solver's residual force over the whole motion.
      ASSERT_GE(hand_mJ + spindle_mJ, -1e-7 * (1 + max_mJ)) << seed << " " << i;
      ASSERT_GE(lost_mJ, -1e-7 * (1 + max_mJ)) << seed << " " << i;
    }
    EXPECT_EQ(heap.count(), 0);
    EXPECT_GT(max_N, 0.01) << seed;
    // Without the flats' friction, all energy from the spindle to the motion passes through the teeth; it is at most
    // their work, without that of ticks in which the tool's own motion drives the teeth.
    if (seed % 3 == 0) {
      EXPECT_LE(spindle_mJ, work_mJ + 1e-9 * (1 + work_mJ)) << seed;
    }
  }
}

TEST(TangentialForce, DoesNotPushARestingHandWithoutBound) {
  // The handle jumps 3 mm down into the bone and 0.5 mm sideways, and then rests. The tool catches up with it and the
  // force vanishes.
  for (const double ratio : {0.6, 1.6}) {
    for (const double rpm : {7500.0, -7500.0}) {
      for (const double stiffness : {2.0, 20.0}) {
        CoupledParams params = MakeTangentialParams(ratio);
        params.coupling.stiffness_N_per_mm = stiffness;
        const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR});
        CoupledSimulation simulation(test::MakeBox(Pose{}, {40, 3, 8}, 0.2), params, start);
        const Pose X_WH = DiscPose(Pose{}, {0.5, 0, 4 + kR - 3});
        const double first_mm = glm::length(X_WH.p_AB - start.p_AB);
        double max_mm = 0, hand_mJ = 0, spindle_mJ = 0;
        CoupledOutput out;
        for (int i = 0; i < 12000; ++i) {
          out = simulation.Tick(Handle(X_WH, rpm));
          max_mm = std::max(max_mm, glm::length(out.X_WT.p_AB - X_WH.p_AB));
          hand_mJ += out.hand_mJ;
          spindle_mJ += out.spindle_mJ;
          ASSERT_GE(hand_mJ + spindle_mJ, -1e-7);
        }
        EXPECT_LT(glm::length(out.X_WT.p_AB - X_WH.p_AB), 0.1 * first_mm) << ratio << " " << stiffness;
        // If teeth engage only at the bottom, only the spring resists their sideways force: the tool yields sideways by
        // 1 / ratio times the deflection that presses it down.
        EXPECT_LT(max_mm, 1.02 * first_mm * std::sqrt(1 + 1 / (ratio * ratio))) << ratio << " " << stiffness;
        EXPECT_LT(TangentialForceEffect::In(EffectsOf(simulation)).figures().sum_N, 0.1 * stiffness * first_mm);
      }
    }
  }
}

// ---- on a device: stability of the closed loop

struct Listened {
  double noise_mN = 0;  // noise of the force on the device, above 20 Hz
  double mean_N = 0;
  double line_aside_N = 0;  // mean force across the push, in the disc's plane
  bool limit_cycle = false;
  PortEnergy energy;
};

/// A hand pushes the saw down into a block for 2.5 s; the last second is analysed.
Listened Listen(const ClosedLoopSetup& setup, double push_N, double rpm) {
  const Pose start = test::OverBlock(0.05);
  ClosedLoop loop(test::BlockOfBone(0.4, {80, 4, 26}), setup, start);  // long enough for the sideways pull
  IntentionStep push;
  push.seconds = 2.5;
  push.X_WH = start;
  push.push_W_N = Vec3(0, 0, -push_N);
  push.yield_s = 0.5;
  loop.device().SetScript(IntentionScript(start, {push}));
  std::vector<Vec3> f;
  std::vector<double> z;
  Listened l;
  for (int i = 0; i < 2500; ++i) {
    const ClosedLoopTick tick = loop.Step(rpm);
    l.energy = tick.energy;
    if (i < 1500) continue;
    f.push_back(tick.f_device_N);
    z.push_back(tick.f_device_N.x);
    l.mean_N += tick.f_device_N.z / 1000;
    l.line_aside_N += tick.f_device_N.x / 1000;
  }
  l.noise_mN = 1e3 * CalcNoise(f, setup.period_s);
  l.limit_cycle = FindOscillation(z, setup.period_s, 0.02).is_limit_cycle;
  return l;
}

TEST(TangentialForce, HeldCutDoesNotChatter) {
  std::string table = "device, hand, ratio, rpm, push: force above 20 Hz mN with / without it; mean force, aside N\n";
  for (const char* device : {"omega_6", "omni"}) {
    for (const char* hand : {"H1", "H2", "H3", "H4"}) {
      for (const double ratio : {0.6, 1.6}) {
        const double rpm = ratio < 1 ? -7500 : 7500;
        ClosedLoopSetup setup = test::HeldBlock(device, hand);
        // The push is limited so that the hand can resist the sideways pull, push / ratio, within 8 mm.
        const double push_N =
            std::min(0.5 * setup.profile.continuous_force_N, 8 * setup.hand.stiffness_N_per_mm * ratio);
        const Listened without = Listen(setup, push_N, rpm);
        SetEffect(setup.coupled.effects, "tangential_force", "ratio", ratio);
        const Listened with = Listen(setup, push_N, rpm);
        table += fmt::format("{} {} {} {} {:.2f}: {:.2f} / {:.2f}; {:.3f}, {:.3f}\n", device, hand, ratio, rpm, push_N,
                             with.noise_mN, without.noise_mN, with.mean_N, with.line_aside_N);
        EXPECT_LE(with.noise_mN, 20) << device << " " << hand << " " << ratio;
        EXPECT_FALSE(with.limit_cycle) << device << " " << hand << " " << ratio;
        EXPECT_GT(with.mean_N, 0.08 * push_N);  // as its intended position yields, the hand's spring bears the rest
        EXPECT_GT(with.line_aside_N * (rpm > 0 ? 1 : -1), 0);
        // Energy at the device: apart from the spindle's energy, no more is returned than what is due to holding the
        // force constant over a tick.
        EXPECT_GE(with.energy.lowest_mJ, -1e-3 - 1e-3 * with.energy.exchanged_mJ);
      }
    }
  }
  std::puts(table.c_str());
}

}  // namespace
}  // namespace kerf
