// Hard case 15: the spindle is stopped. Nothing is cut, and a solid that has only compliance and friction returns no
// energy.
#include <random>

#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;
using test::Sawing;

TEST(HardCase15, StoppedSawRestsOnTheBoneWithTheCouplingsForceAlone) {
  test::Verdict verdict("holds");
  const Bone bone = test::MakeBox(Pose{}, {26, 6, 8}, 0.2);
  // The spindle counts as stopped below 1 rpm, in both directions.
  double max_in_mm = 0;
  for (const double rpm : {0.0, -0.0, 0.99, -0.99}) {
    Sawing saw(bone, DiscParams(), DiscPose(Pose{}, {0, 0, 4 + kR + 0.3}));
    saw.Move(DiscPose(Pose{}, {0, 0, 4 + kR - 5}), 500, rpm);
    EXPECT_TRUE(saw.out.status & kCoupledSpindleStopped);
    EXPECT_EQ(saw.out.f_cut_W_N, Vec3(0));
    EXPECT_EQ(saw.out.engaged_teeth, 0);
    // The spring is stretched by 5 mm at 1 N/mm, minus the deflection of the contact points of 2000 N/mm each.
    EXPECT_NEAR(saw.out.f_H_W_N.z, 5, 0.01);
    max_in_mm = std::max(max_in_mm, 4 + kR - saw.out.X_WT.p_AB.z);
    EXPECT_EQ(saw.simulation.UpdateBone().CalcHash(), bone.CalcHash());
  }
  verdict.AtMost("penetration of the bone under 5 N", 1000 * max_in_mm, 10, "um");
}

TEST(HardCase15, DraggedSawFeelsOnlyCoulombFriction) {
  test::Verdict verdict("holds");
  CoupledParams params = DiscParams();
  SetEffect(params.effects, "kerf_friction", "coefficient", 0.3);
  params.coupling.torsion_Nmm_per_rad = 1e6;  // prevents rolling
  params.coupling.max_torque_Nmm = 1e5;
  Sawing saw(test::MakeBox(Pose{}, {30, 6, 8}, 0.2), params, DiscPose(Pose{}, {-5, 0, 4 + kR + 0.3}));
  saw.Move(DiscPose(Pose{}, {-5, 0, 4 + kR - 5}), 500, 0);
  double smallest = 1e9;
  double largest = 0;
  const double x_from = saw.out.X_WT.p_AB.x;
  saw.Move(DiscPose(Pose{}, {5, 0, 4 + kR - 5}), 1000, 0, [&](const CoupledOutput& out) {
    const double ratio = -out.f_H_W_N.x / out.f_H_W_N.z;
    largest = std::max(largest, ratio);
    if (saw.X_WH.p_AB.x > -2) smallest = std::min(smallest, ratio);
    // The saw sticks, except for creep, until the hand pulls with mu N = 1.5 N, which is 1.5 mm of spring.
    if (saw.X_WH.p_AB.x < -3.6) {
      ASSERT_LT(out.X_WT.p_AB.x - x_from, 0.02 * 0.2 * 10);
    }
  });
  // On a plane of voxels the normal force is the sum over all points, except for the unevenness of distances that are
  // stored as floats.
  verdict.AtMost("maximum sliding friction / normal force", largest, 0.3 * 1.02);
  verdict.AtLeast("minimum sliding friction / normal force", smallest, 0.3 * 0.98);
  EXPECT_EQ(saw.invariants.removed_mm3(), 0);
}

/// The handle follows a closed path through random places near the bone's surface, with the tool slightly rotated.
TEST(HardCase15, ClosedPathsInAndOutOfTheBoneReturnNoEnergy) {
  test::Verdict verdict("holds");
  const Bone bone = test::MakeBox(Pose{}, {26, 6, 8}, 0.4);
  const std::uint64_t hash = bone.CalcHash();
  std::mt19937_64 random(15);
  const auto draw = [&random](double largest) {
    return largest * (static_cast<double>(random() >> 11) / 4503599627370496.0 - 1);
  };
  const int orbits = std::max(5, static_cast<int>(60 * test::Effort()));
  double lowest_mJ = 1e9;
  double exchanged_mJ = 0;
  double max_force_N = 0;
  for (int n = 0; n < orbits; ++n) {
    const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR + 2});
    Sawing saw(bone, DiscParams(), start);
    Pose X_before = start;
    const auto account = [&](const CoupledOutput& out) {
      const Vec3 motion = saw.X_WH.Point(saw.simulation.params().coupling.p_TC_mm) -
                          X_before.Point(saw.simulation.params().coupling.p_TC_mm);
      exchanged_mJ += std::abs(glm::dot(out.f_H_W_N, motion));
      X_before = saw.X_WH;
      max_force_N = std::max(max_force_N, glm::length(out.f_H_W_N));
      ASSERT_EQ(out.removed_mm3, 0);
    };
    for (int leg = 0; leg < 4; ++leg) {
      Pose X = start;
      if (leg < 3) {
        X.p_AB += Vec3(draw(10), draw(3), draw(4) - 4);
        X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(draw(0.3), glm::normalize(Vec3(1, draw(1), draw(1)))));
      }
      saw.Move(X, 100 + static_cast<int>(random() % 200), 0, account);
    }
    // Back in free air no energy is stored, so all of the hand's work is dissipated. Each tick's energy balance is
    // exact.
    EXPECT_EQ(saw.out.f_H_W_N, Vec3(0)) << n;
    EXPECT_NEAR(saw.invariants.stored_mJ(), 0, 1e-9) << n;
    EXPECT_EQ(saw.invariants.spindle_mJ(), 0) << n;
    lowest_mJ = std::min(lowest_mJ, saw.invariants.hand_mJ());
    EXPECT_EQ(saw.simulation.UpdateBone().CalcHash(), hash) << n;
  }
  EXPECT_GT(max_force_N, 3);  // there was contact
  verdict.AtLeast("minimum work of a hand on a closed path", lowest_mJ, -1e-7, "mJ");
  verdict.Note("energy exchanged along the paths", exchanged_mJ, "mJ");
}

TEST(HardCase15, StoppedSawOnAPathHasNoForceAndCutsNothing) {
  const Bone bone = test::MakeBox(Pose{}, {12, 4, 8}, 0.4);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 4 + kR + 0.3}));
  for (const TickOutput& out : test::Stroke(simulation, Pose{}, {0, 0, 4 + kR + 0.3}, {0, 0, 4 + kR - 3}, 20, 0)) {
    ASSERT_EQ(out.status, kTickSpindleStopped);
    ASSERT_EQ(out.f_T_W_N, Vec3(0));
    ASSERT_EQ(out.tau_TG_W_Nmm, Vec3(0));
    ASSERT_EQ(out.removed_mm3, 0);
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash());
}

}  // namespace
}  // namespace kerf
