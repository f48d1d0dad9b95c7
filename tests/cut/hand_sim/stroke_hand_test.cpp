// Blades with a stroke in a hand: energy, force in a kerf, stop, buried start, sides and walls.
#include <gtest/gtest.h>

#include <random>

#include "base/core/heap_guard.h"
#include "cut/hand_sim/hands.h"
#include "cut/tool/edge_down.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::Handle;

/// Pose of the blade: middle of the edge at p_W, edge along x, feed along -z, blade in the plane y = 0.
Pose SawPose(const Vec3& p_W) {
  return {CalcEdgeDown(), p_W};
}

Tool ShortReciprocating() {
  ReciprocatingBlade blade;
  blade.length_mm = 20;
  return blade;
}

/// One of each kind.
const Tool kStrokeTools[] = {ShortReciprocating(), OscillatingBlade{}, PiezoInsert{}};

CoupledParams SawParams(const char* law, const Tool& tool = kStrokeTools[0]) {
  CoupledParams params;
  params.tool = tool;
  params.law = ForceLaw(law);
  return params;
}

/// A hand that drifts smoothly about a pose slightly inside the bone, and sometimes jumps.
class SawingHand {
 public:
  explicit SawingHand(std::mt19937_64& random) : random_(random) {}
  Pose Next(double dt_s) {
    std::normal_distribution<double> normal;
    for (double* v : {&v_.x, &v_.y, &v_.z}) *v += -*v * 5 * dt_s + 60 * std::sqrt(dt_s) * normal(random_);
    for (double* w : {&w_.x, &w_.y, &w_.z}) *w += -*w * 5 * dt_s + 1.5 * std::sqrt(dt_s) * normal(random_);
    p_ += v_ * dt_s;
    p_ -= 8 * dt_s * (p_ - Vec3(0, 0, 1));
    theta_ += w_ * dt_s;
    theta_ *= 1 - 2 * dt_s;
    if (random_() % 400 == 0) p_ += Vec3(normal(random_), normal(random_), normal(random_)) * 10.0;
    Pose X = SawPose(p_);
    const double angle = glm::length(theta_);
    if (angle > 0) X.R_AB = X.R_AB * glm::angleAxis(angle, theta_ / angle);
    return X;
  }

 private:
  std::mt19937_64& random_;
  Vec3 p_{0, 0, 2.2}, v_{0}, w_{0}, theta_{0};
};

TEST(ReciprocatingHand, ForceInAKerfIsThatOfTheLawAtTheFeed) {
  // A handle at constant speed; after the approach the tool follows at the same speed. The force is that of the law at
  // the mean bite over the way of the teeth: feed x pitch / mean speed of the teeth.
  constexpr double kFeed_mm_per_s = 2, kStrokesAMinute = 12000;  // a period of five ticks
  CoupledParams params = SawParams("edge_plus_chip");
  params.law.Set("edge_N_per_mm", 0.5);
  params.law.Set("chip_N_per_mm2", 265);      // so soft that the coupling hardly yields to its changes
  params.coupling.stiffness_N_per_mm = 1000;  // so stiff that the feed is the same at all phases
  const auto& blade = std::get<ReciprocatingBlade>(params.tool);
  Bone bone = test::MakeBox({}, {6, 3, 5}, 0.1);
  bone.set_materials(test::OneRegionTable(24, 19300, 0.28));
  CoupledSimulation simulation(bone, params, SawPose({0, 0, 2.6}));
  double thrust_N = 0, removed_mm3 = 0, teeth = 0;
  Pose X_first, X_last;
  for (int i = 1; i <= 600; ++i) {
    const CoupledOutput out =
        simulation.Tick(Handle(SawPose({0, 0, 2.6 - kFeed_mm_per_s * 1e-3 * i}), kStrokesAMinute));
    if (i == 500) X_first = out.X_WT;
    if (i <= 500) continue;
    X_last = out.X_WT;
    thrust_N += out.thrust_sum_N / 100;
    teeth += out.engaged_teeth / 100;
    removed_mm3 += out.removed_mm3;
  }
  const double feed_mm = X_first.p_AB.z - X_last.p_AB.z;
  EXPECT_NEAR(feed_mm, 0.2, 0.005);
  EXPECT_NEAR(removed_mm3 / (blade.kerf_mm() * 6 * feed_mm), 1, 0.03);
  const double since_s = blade.pitch_mm / (2 * blade.stroke_mm * kStrokesAMinute / 60);
  const ToothForce law = MakeToothForce(params.law, params.tool);
  const ToothCut cut = Cortical(CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28));
  EXPECT_NEAR(teeth / (6 / blade.pitch_mm), 1, 0.03);
  EXPECT_NEAR(thrust_N / (teeth * law(kFeed_mm_per_s * since_s, cut)), 1, 0.03);
}

TEST(StrokeHand, WithoutAStrokeItRestsOnTheBone) {
  for (const Tool& tool : kStrokeTools) {
    Bone bone = test::MakeBox({}, {6, 3, 5}, 0.1);
    const std::uint64_t hash = bone.CalcHash();
    CoupledSimulation simulation(bone, SawParams("edge_plus_chip", tool), SawPose({0, 0, 2.6}));
    CoupledOutput out;
    for (int i = 0; i < 300; ++i) {
      out = simulation.Tick(Handle(SawPose({0, 0, std::max(1.5, 2.6 - 0.01 * i)}), 0));
    }
    EXPECT_NEAR(out.X_WT.p_AB.z, 2.5, 0.05);
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), hash);
  }
}

TEST(StrokeHand, AStartInsideBoneClearsAllOfTheStroke) {
  // The blade is set down inside bone; the first tick removes what it sweeps, and it then moves freely.
  for (const Tool& tool : kStrokeTools) {
    const auto blade = *FindPlanarBlade(tool);
    const Bone bone = test::MakeBox({}, {30, 3, 60}, 0.2);
    CoupledSimulation simulation(bone, SawParams("edge_plus_chip", tool), SawPose({0, 0, 0}));
    const CoupledOutput first = simulation.Tick(Handle(SawPose({0, 0, 0}), 9000));
    const ConvexOutline swept = blade.SweepOutline({-0.5 * blade.stroke_mm, 0.5 * blade.stroke_mm});
    double area_mm2 = 0;
    for (int i = 0; i < swept.size(); ++i) {
      const auto &a = swept.corner(i), &b = swept.corner((i + 1) % swept.size());
      area_mm2 += 0.5 * (a.x * b.y - b.x * a.y);
    }
    EXPECT_NEAR(first.removed_mm3 / (area_mm2 * blade.kerf_mm), 1, 0.03) << DescribeTool(tool);
    double later_mm3 = 0;
    for (int i = 0; i < 40; ++i) {
      const CoupledOutput out = simulation.Tick(Handle(SawPose({0, 0, 0}), 9000));
      later_mm3 += out.removed_mm3;
      EXPECT_LT(glm::length(out.f_H_W_N), 1e-9) << DescribeTool(tool) << i;
    }
    // What the chords of an arc leave.
    EXPECT_LE(later_mm3, blade.CalcSagitta() * blade.edge_mm * blade.kerf_mm + 1e-12);
  }
}

TEST(StrokeHand, TheSidesOfASwingingBladeDoNotCut) {
  // Beside a block, more than the zone of the teeth above the top; pushed against the block's end.
  for (const Tool& tool : {kStrokeTools[1], kStrokeTools[2]}) {
    const auto blade = *FindPlanarBlade(tool);
    const double beside_mm = 3 + 0.5 * blade.edge_mm + blade.stroke_mm + 0.5;
    Bone bone = test::MakeBox({}, {6, 3, 5}, 0.1);
    const std::uint64_t hash = bone.CalcHash();
    // The teeth are below the block, the side is beside it.
    CoupledSimulation simulation(bone, SawParams("edge_plus_chip", tool), SawPose({beside_mm, 0, -4.5}));
    CoupledOutput out;
    double force_N = 0, at_mm = 0;
    for (int i = 0; i < 400; ++i) {
      out = simulation.Tick(Handle(SawPose({beside_mm - std::min(3.0, 0.01 * i), 0, -4.5}), 14000));
      if (i >= 300) {
        force_N += out.f_H_W_N.x / 100;
        at_mm += out.X_WT.p_AB.x / 100;
      }
    }
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), hash);
    std::printf("%s: %.3f mm before the handle, %.3f N\n", DescribeToolBriefly(tool).c_str(), at_mm - beside_mm + 3,
                force_N);
    EXPECT_GT(at_mm, beside_mm - 2.9);
    EXPECT_GT(force_N, 0.1);  // the block pushes the hand back
  }
}

TEST(ReciprocatingHand, TheBackDoesNotCut) {
  // The blade is moved backwards into a block behind it while it saws.
  Bone bone = test::MakeBox({}, {6, 3, 5}, 0.1);
  const std::uint64_t hash = bone.CalcHash();
  // Feed is -z, so the back faces +z: start below the block, with the back under its lower face at -2.5.
  CoupledSimulation below(bone, SawParams("edge_plus_chip"), SawPose({0, 0, -2.6 - 6}));
  CoupledOutput out;
  for (int i = 0; i < 300; ++i) {
    out = below.Tick(Handle(SawPose({0, 0, std::min(-7.5, -8.6 + 0.01 * i)}), 15000));
  }
  EXPECT_NEAR(out.X_WT.p_AB.z, -8.5, 0.05);
  EXPECT_EQ(below.UpdateBone().CalcHash(), hash);
}

TEST(ReciprocatingHand, TheWallsOfItsKerfHoldIt) {
  CoupledParams params = SawParams("edge_plus_chip");
  params.law.Set("edge_N_per_mm", 0.5);
  params.coupling.stiffness_N_per_mm = 100;
  const Bone bone = test::MakeBox({}, {6, 3, 5}, 0.1);
  CoupledSimulation simulation(bone, params, SawPose({0, 0, 2.6}));
  for (int i = 1; i <= 1000; ++i) simulation.Tick(Handle(SawPose({0, 0, 2.6 - 0.002 * i}), 15000));
  CoupledOutput out;
  for (int i = 1; i <= 500; ++i) {
    out = simulation.Tick(Handle(SawPose({0, std::min(1.0, 0.01 * i), 0.8}), 15000));
  }
  // The set leaves 0.05 mm on each side, and the edge cuts its own width sideways only near the floor.
  EXPECT_LT(out.X_WT.p_AB.y, 0.15);
  EXPECT_GT(glm::length(out.f_face_W_N), 1);
}

TEST(ReciprocatingHand, ReportsTheDisplacementOfItsEdge) {
  CoupledParams params = SawParams("edge_plus_chip");
  CoupledSimulation simulation(test::MakeBox({}, {6, 3, 5}, 0.2), params, SawPose({0, 0, 2.6}));
  for (int i = 1; i <= 100; ++i) {  // 1.5 mm sin(2 pi 20 Hz t), in air and in bone
    const CoupledOutput out = simulation.Tick(Handle(SawPose({0, 0, 2.6 - 0.01 * i}), 1200));
    EXPECT_NEAR(out.displacement_mm, 1.5 * std::sin(2 * std::numbers::pi * 0.02 * i), 1e-9);
  }
  EXPECT_EQ(simulation.Tick(Handle(SawPose({0, 0, 1.6}), 0)).displacement_mm,
            simulation.Tick(Handle(SawPose({0, 0, 1.6}), 0)).displacement_mm);
}

TEST(StrokeHand, TheSameCallsGiveTheSameBits) {
  for (const Tool& tool : kStrokeTools) {
    std::uint64_t hash[2];
    for (std::uint64_t& one : hash) {
      std::mt19937_64 random(5);
      SawingHand hand(random);
      CoupledSimulation simulation(test::MakeBox({}, {12, 3, 4}, 0.2), SawParams("edge_plus_chip", tool),
                                   hand.Next(0.001));
      for (int i = 0; i < 800; ++i) simulation.Tick(Handle(hand.Next(0.001), 9000));
      one = simulation.UpdateBone().CalcHash();
    }
    EXPECT_EQ(hash[0], hash[1]);
  }
}

TEST(StrokeHand, OnlyAVibratingInsertAcceptsItsRate) {
  const Bone bone = test::MakeBox({}, {6, 3, 5}, 0.2);
  for (const Tool& tool : kStrokeTools) {
    CoupledSimulation simulation(bone, SawParams("edge_plus_chip", tool), SawPose({0, 0, 3}));
    const bool vibrates = std::holds_alternative<PiezoInsert>(tool);
    EXPECT_EQ((simulation.Tick(Handle(SawPose({0, 0, 3}), 2.16e6)).status & kCoupledBadPose) == 0, vibrates);
    EXPECT_NE(simulation.Tick(Handle(SawPose({0, 0, 3}), 1.01 * kMaxStrokesPerMin)).status & kCoupledBadPose, 0u);
  }
}

/// Pose of SawPose(0) in a block whose pose is X_WB.
Pose SawPoseIn(const Pose& X_WB) {
  const Pose X_BT = SawPose({0, 0, 0});
  return {X_WB.R_AB * X_BT.R_AB, X_WB.Point(X_BT.p_AB)};
}

/// A blade, stopped in the slot that it was set down in, and pushed by the hand's displacement from the pose.
class HeldBlade {
 public:
  HeldBlade(const Bone& bone, const CoupledParams& params, const Pose& X_WB)
      : start_(SawPoseIn(X_WB)), simulation_(bone, params, start_) {
    simulation_.Tick(Handle(start_, 9000));
  }
  /// Moves the handle from its place to this displacement, in the blade's frame. Returns the force on the hand in that
  /// frame, N, and adds the energy that the springs take up.
  Vec3 Push(const Vec3& to_T_mm, double& stored_mJ) {
    constexpr int kTicks = 25;
    CoupledOutput out;
    for (int i = 1; i <= 2 * kTicks; ++i) {
      const Vec3 at_T_mm = at_T_mm_ + std::min(1.0, 1.0 * i / kTicks) * (to_T_mm - at_T_mm_);
      out = simulation_.Tick(Handle({start_.R_AB, start_.Point(at_T_mm)}, 0));
      stored_mJ += out.stored_mJ;
    }
    at_T_mm_ = to_T_mm;
    return start_.InverseVector(out.f_H_W_N);
  }

 private:
  Pose start_;
  CoupledSimulation simulation_;
  Vec3 at_T_mm_{0};
};

TEST(BendingBlade, IsInSeriesWithTheCouplingAcrossTheBlade) {
  // The walls of the slot are stiff: each of more than a hundred points of a face has 3000 N/mm. The gap between blade
  // and slot does not change the slope of the force between two displacements, except that the blade tilts in the gap.
  constexpr double kCoupling_N_per_mm = 2, kTilt = 0.01;
  for (const Pose& X_WB : {Pose{}, Pose{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {3, -2, 40}}}) {
    const Bone bone = test::MakeBox(X_WB, {30, 5, 60}, 0.25);
    for (const Tool& tool : kStrokeTools) {
      for (const bool bends : {false, true}) {
        CoupledParams params = SawParams("edge_plus_chip", tool);
        params.coupling.blade_bends = bends;
        params.coupling.stiffness_N_per_mm = kCoupling_N_per_mm;
        params.coupling.torsion_Nmm_per_rad = 1e7;  // the blade does not tilt in its slot
        params.coupling.max_torque_Nmm = 1e6;
        HeldBlade blade(bone, params, X_WB);
        double first_mJ = 0, then_mJ = 0;
        const double first_N = blade.Push({0, 0, 1}, first_mJ).z;
        const double then_N = blade.Push({0, 0, 3}, then_mJ).z;
        const double compliance_mm_per_N = 1 / kCoupling_N_per_mm + (bends ? 1 / CalcSideStiffness(tool) : 0);
        if (bends) {
          EXPECT_GT(kCoupling_N_per_mm * compliance_mm_per_N, 1 + 5 * kTilt) << DescribeTool(tool);
        }
        EXPECT_NEAR((then_N - first_N) / 2 * compliance_mm_per_N, -1, kTilt) << DescribeTool(tool) << bends;
        EXPECT_NEAR(then_mJ / (0.5 * compliance_mm_per_N * (then_N * then_N - first_N * first_N)), 1, kTilt);
      }
    }
  }
}

TEST(BendingBlade, IsStiffInItsPlaneAndLeavesARigidToolAlone) {
  const Bone bone = test::MakeBox({}, {30, 5, 60}, 0.25);
  for (const Tool& tool : {kStrokeTools[0], Tool(TwistDrill{}), Tool(FissureBur{})}) {
    const bool is_blade = CalcSideStiffness(tool) > 0;
    Vec3 f_N[2];
    for (const bool bends : {false, true}) {
      CoupledParams params = SawParams("edge_plus_chip", tool);
      params.coupling.blade_bends = bends;
      double unused_mJ = 0;
      f_N[bends] = HeldBlade(bone, params, {}).Push(is_blade ? Vec3(1, 0, 0) : Vec3(0.2, 0.3, 0.5), unused_mJ);
    }
    EXPECT_GT(glm::length(f_N[0]), 0.3) << DescribeTool(tool);
    // Pushed in its plane, a blade may still shift across it by rounding.
    EXPECT_LE(glm::length(f_N[0] - f_N[1]), is_blade ? 1e-6 : 0) << DescribeTool(tool);
  }
}

}  // namespace
}  // namespace kerf
