// The numerical loss that a tick reports, compared with the known loss of an implicit Euler step of a spring.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "cut/hand_sim/hands.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

constexpr double kNumericalLossTop = 3;

struct Losses {
  int ticks = 0;            // number of ticks compared
  double worst_mJ = 0;      // largest error in a tick
  double numerical_mJ = 0;  // sum over all ticks
  double hand_mJ = 0;
};

/// Presses the disc straight down into bone with a handle that moves at 20 mm/s, without friction or damper.
Losses Plunge(double E_MPa, double tick_s) {
  CoupledParams params = test::DiscParams();
  params.effects = {};
  params.coupling.stiffness_N_per_mm = 2;
  params.max_iterations = 200;
  Bone bone = test::MakeBox(Pose{}, {20, 3, 6}, 0.1);
  bone.set_materials(test::OneRegionTable(24, E_MPa, 0.28));
  const double start = kNumericalLossTop + DiscSaw{}.radius_mm() + 0.3;
  CoupledSimulation simulation(std::move(bone), params, DiscPose(Pose{}, {0, 0, start}));
  Losses losses;
  Vec3 p_W(0, 0, start);
  for (int i = 1; i <= static_cast<int>(std::lround(0.3 / tick_s)); ++i) {
    const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, start - 20 * i * tick_s}), 7500, tick_s));
    losses.numerical_mJ += out.numerical_mJ;
    losses.hand_mJ += out.hand_mJ;
    const Vec3 moved = out.X_WT.p_AB - std::exchange(p_W, out.X_WT.p_AB);
    // If only the spring stores energy and a single step was made, the loss is 1/2 K e0^2 - 1/2 K e1^2 - K e1 (e0 -
    // e1).
    const bool alone = out.substeps == 1 && out.cut_mJ > 0 && out.f_face_W_N == Vec3(0);
    if (!alone) continue;
    ++losses.ticks;
    const double known_mJ = 0.5 * params.coupling.stiffness_N_per_mm * glm::dot(moved, moved);
    losses.worst_mJ = std::max(losses.worst_mJ, std::abs(out.numerical_mJ - known_mJ));
  }
  return losses;
}

// An implicit step of a spring K with a stretch e0 before and e1 after it does the work K e1 (e0 - e1) and loses 1/2 K
// (e0 - e1)^2, half the stiffness times the square of the motion. 1e-6 mJ allows for the solver's residual, 1e-7 of
// forces of a few newtons, over motions below a millimetre; a tick loses 1e-3 mJ or more.
TEST(NumericalLoss, EqualsThatOfAnImplicitSpringStep) {
  for (const double E_MPa : {2000.0, 19300.0, 200000.0}) {
    const Losses losses = Plunge(E_MPa, 0.001);
    EXPECT_GT(losses.ticks, 100) << E_MPa;
    EXPECT_LT(losses.worst_mJ, 1e-6) << E_MPa;
    EXPECT_GT(losses.numerical_mJ, 1e3 * losses.worst_mJ) << E_MPa;
  }
}

// The method is of first order: the loss per tick is proportional to the square of the tick's length, and the loss over
// the same motion to the length.
TEST(NumericalLoss, HalvesWithTheTick) {
  double before_mJ = 0;
  for (const double tick_s : {0.002, 0.001, 0.0005, 0.00025}) {
    const double lost_mJ = Plunge(19300, tick_s).numerical_mJ;
    if (before_mJ > 0) {
      EXPECT_NEAR(before_mJ / lost_mJ, 2, 0.4) << tick_s;
    }
    before_mJ = lost_mJ;
  }
}

}  // namespace
}  // namespace kerf
