// The volume that a ball burr on a path removes, and its force, compared with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kerf/simulation.h"
#include "support/solids.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

constexpr double kFeed = 10;  // mm/s

SimulationParams BallParams() {
  SimulationParams params;
  BallBurr ball;
  ball.diameter_mm = 4;
  params.tool = ball;
  params.law = ForceLaw("hertz_chip");
  return params;
}

/// Makes a block of 12 x 7 x 4 mm of uniform bone whose top face is z = 0.
Bone Block(double voxel_mm, const Quat& R_WB) {
  return test::MakeBox({R_WB, R_WB * Vec3(0, 0, -2)}, {12, 7, 4}, voxel_mm);
}

struct BallSlot {
  double removed_mm3 = 0;
  Vec3 force_B_N{0};   // mean over the middle of the kerf
  double end_mm3 = 0;  // volume that the bone has lost at the end
};

/// Cuts along x through the entire block, with the lower half of the ball in it; the spindle is along the block's z.
BallSlot CutSlot(double voxel_mm, const Quat& R_WB) {
  Bone bone = Block(voxel_mm, R_WB);
  const double before = bone.CalcVolume();
  const auto pose = [&](double x) { return Pose{R_WB, R_WB * Vec3(x, 0, 0)}; };
  Simulation simulation(std::move(bone), BallParams(), pose(-8.1));
  BallSlot slot;
  int count = 0;
  for (double x = -8.1; x < 8.1; x += 0.01) {
    const TickOutput out = simulation.Tick({pose(x), 0.01 / kFeed, 7500});
    slot.removed_mm3 += out.removed_mm3;
    if (std::abs(x) < 2) {
      slot.force_B_N += glm::conjugate(R_WB) * out.f_T_W_N;
      ++count;
    }
  }
  slot.force_B_N /= count;
  slot.end_mm3 = before - simulation.UpdateBone().CalcVolume();
  return slot;
}

TEST(BallClosedForm, SlotOfHalfABallHasItsVolumeOnEveryGrid) {
  // The kerf is half a disc of radius 2 mm, 12 mm long. Between grids, the results may differ by at most 2 %.
  const double exact = 0.5 * std::numbers::pi * 4 * 12;
  for (const double voxel : {0.1, 0.2, 0.3}) {
    for (const Quat& R : {Quat(1, 0, 0, 0), glm::angleAxis(0.5, glm::normalize(Vec3(1, 2, 3)))}) {
      const BallSlot slot = CutSlot(voxel, R);
      EXPECT_NEAR(slot.end_mm3 / exact, 1, 0.01) << voxel;
      EXPECT_NEAR(slot.removed_mm3 / exact, 1, 0.01) << voxel;  // by occupancy
    }
  }
}

TEST(BallClosedForm, ForceInASlotIsTheIntegralOverTheQuarterThatMovesIntoBone) {
  // At colatitude theta and longitude phi there are flutes r / (2 pi w) dtheta dphi teeth, each with the force C (v /
  // f)^(3/2) (sin theta cos phi)^(3/2) along -e. The integrand along the feed is (sin theta cos phi)^(5/2); downwards
  // it is (sin theta cos phi)^(3/2) cos theta.
  const BallBurr ball = std::get<BallBurr>(BallParams().tool);
  const auto power = [](double p) { return std::beta(0.5 * (p + 1), 0.5); };  // integral of cos^p from -pi/2 to pi/2
  const double E_star = CalcReducedModulus(ball.E_MPa, ball.nu, 19300, 0.28);
  const double bite = kFeed / (ball.flutes * 7500.0 / 60);
  const double tooth = MakeToothForce(ForceLaw("hertz_chip"), ball)(bite, Cortical(E_star));
  const double density = ball.flutes * ball.radius_mm() / (2 * std::numbers::pi * ball.tooth_width_mm);
  const double along = density * tooth * 0.5 * power(2.5) * power(2.5);
  const double up = density * tooth * power(1.5) / 2.5;
  const BallSlot slot = CutSlot(0.1, Quat(1, 0, 0, 0));
  // With a look-ahead of a quarter of a voxel and 32 points around the ball, both components are accurate to 2 % of the
  // total force.
  const double whole = std::hypot(along, up);
  EXPECT_NEAR(slot.force_B_N.x, -along, 0.02 * whole);
  EXPECT_NEAR(slot.force_B_N.y, 0, 0.005 * whole);
  EXPECT_NEAR(slot.force_B_N.z, up, 0.02 * whole);
}

}  // namespace
}  // namespace kerf
