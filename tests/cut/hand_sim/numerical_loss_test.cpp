// What a tick reports as lost to its finite steps, against what an implicit Euler step of a spring is known to lose.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "cut/hand_sim/hands.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

constexpr double kTop = 3;

struct Losses {
  int ticks = 0;            // that were compared
  double worst_mJ = 0;      // difference of a tick
  double numerical_mJ = 0;  // summed over all ticks
  double hand_mJ = 0;
};

/// The disc is pressed straight down into bone by a handle that goes down at 20 mm/s; no friction, no damper.
Losses Plunge(double E_MPa, double tick_s) {
  CoupledParams params = test::DiscParams();
  params.effects = {};
  params.coupling.stiffness_N_per_mm = 2;
  params.max_iterations = 200;
  Bone bone = test::MakeBox(Pose{}, {20, 3, 6}, 0.1);
  bone.set_materials(test::OneRegionTable(24, E_MPa, 0.28));
  const double start = kTop + DiscSaw{}.radius_mm() + 0.3;
  CoupledSimulation simulation(std::move(bone), params, DiscPose(Pose{}, {0, 0, start}));
  Losses losses;
  Vec3 p_W(0, 0, start);
  for (int i = 1; i <= static_cast<int>(std::lround(0.3 / tick_s)); ++i) {
    const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, start - 20 * i * tick_s}), 7500, tick_s));
    losses.numerical_mJ += out.numerical_mJ;
    losses.hand_mJ += out.hand_mJ;
    const Vec3 moved = out.X_WT.p_AB - std::exchange(p_W, out.X_WT.p_AB);
    // The spring alone stores energy, and one step was made: 1/2 K e0^2 - 1/2 K e1^2 - K e1 (e0 - e1).
    const bool alone = out.substeps == 1 && out.cut_mJ > 0 && out.f_face_W_N == Vec3(0);
    if (!alone) continue;
    ++losses.ticks;
    const double known_mJ = 0.5 * params.coupling.stiffness_N_per_mm * glm::dot(moved, moved);
    losses.worst_mJ = std::max(losses.worst_mJ, std::abs(out.numerical_mJ - known_mJ));
  }
  return losses;
}

// An implicit step of a spring K that is drawn by e0 before and e1 after it does K e1 (e0 - e1) of work and loses
// 1/2 K (e0 - e1)^2, half the stiffness times the square of the way. 1e-6 mJ: the solver's residual, 1e-7 of forces of
// newtons, over ways below a millimetre; the ticks lose up to 1e-3 mJ and more.
TEST(NumericalLoss, IsThatOfAnImplicitStepOfTheSpring) {
  for (const double E_MPa : {2000.0, 19300.0, 200000.0}) {
    const Losses losses = Plunge(E_MPa, 0.001);
    EXPECT_GT(losses.ticks, 100) << E_MPa;
    EXPECT_LT(losses.worst_mJ, 1e-6) << E_MPa;
    EXPECT_GT(losses.numerical_mJ, 1e3 * losses.worst_mJ) << E_MPa;
  }
}

// Of first order: the loss of a tick goes with the square of its length, that of the same way with the length itself.
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
