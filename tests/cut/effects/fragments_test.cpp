// Fragments: when and which pieces come off, compared with splitting the bone after every tick; no effect on force.
#include "cut/effects/fragments/fragments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "kerf/surface.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr double kVoxel_mm = 0.2;
constexpr double kHalf_mm[] = {3, 2, 1.5};

const Bone& Bar() {
  static const Bone kBar = test::MakeBox({}, 2.0 * Vec3(kHalf_mm[0], kHalf_mm[1], kHalf_mm[2]), kVoxel_mm);
  return kBar;
}

/// The spindle is along x. The disc cuts the bar at x = 1 from above; its rim passes the bar's lower side after
/// kThrough ticks.
constexpr int kTicks = 700;
constexpr double kStep_mm = 0.01;
Pose PoseAt(int tick) {
  Pose X;
  X.R_AB = glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0));
  X.p_AB = {1.03, 0, kHalf_mm[2] + 11 + 0.5 - kStep_mm * tick};
  return X;
}

EffectChoices WithFragments(double dust_mm3) {
  EffectChoices choices;
  SetEffect(choices, "fragments", "dust_mm3", dust_mm3);
  return choices;
}

template <typename Sim>
void Tell(Sim& simulation, FragmentsEffect& effect) {
  for (int i = 0; i < simulation.changed_count(); ++i) {
    const auto leaf = simulation.changed(i);
    effect.watch().Change(leaf.index, std::span<const float, 512>(leaf.values, 512));
  }
  simulation.ClearChanged();
}

TEST(Fragments, ReportsThePieceInTheTickThatCutsTheLastBridge) {
  SimulationParams params;
  params.effects = WithFragments(1);
  Simulation simulation(Bar(), params, PoseAt(0));
  auto& effect = dynamic_cast<FragmentsEffect&>(*EffectsOf(simulation).Find("fragments"));
  std::array<double, 2> figures{};
  int found_in = 0, apart_in = 0;
  for (int tick = 1; tick <= kTicks; ++tick) {
    simulation.Tick({PoseAt(tick)});
    EffectsOf(simulation).Report(figures);
    EXPECT_EQ(figures[0], found_in > 0 ? 2 : 1) << tick;
    Tell(simulation, effect);
    if (effect.Look(0.001 * tick) > 0) {
      EXPECT_EQ(found_in, 0) << "again in tick " << tick;
      found_in = tick;
    }
    if (apart_in == 0 && tick > 250 && SplitPieces(simulation.UpdateBone(), 1).pieces.size() == 2) apart_in = tick;
  }
  EXPECT_GT(apart_in, 0);
  EXPECT_EQ(found_in, apart_in);
  ASSERT_EQ(effect.watch().events().size(), 1u);
  const FragmentEvent& event = effect.watch().events()[0];
  EXPECT_EQ(event.time_s, 0.001 * found_in);
  EXPECT_EQ(event.pieces, 2);
  EXPECT_EQ(event.region, 24);
  EXPECT_EQ(event.piece.id, 2);
  EXPECT_EQ(event.piece.from, 1);
  // The smaller part extends from half a kerf beyond 1.03 mm to the end at 3 mm. It consists of whole voxels, so each
  // face may be off by half a voxel.
  const double h = 0.5 * kVoxel_mm;
  const double length_mm = 3 - 1.03 - 0.5 * 0.25;
  EXPECT_NEAR(event.piece.bounds_W.lower.x, 3 - length_mm, h + 1e-9);
  EXPECT_NEAR(event.piece.bounds_W.upper.x, 3, h + 1e-9);
  const double faces_mm2 = 2 * (length_mm * 4 + length_mm * 3 + 12);
  EXPECT_NEAR(event.piece.volume_mm3, length_mm * 12, h * faces_mm2);
  // Pieces and dust add up to the remaining bone.
  const FoundPieces& found = effect.watch().finder().found();
  EXPECT_NEAR(found.pieces[0].volume_mm3 + found.pieces[1].volume_mm3 + found.dust_mm3,
              simulation.UpdateBone().CalcVolume(), h * (faces_mm2 + 100));
}

/// What a hand feels while it lowers the saw through the bar: the force in each tick, and the bone at the end.
struct Felt {
  std::vector<Vec3> force_N;
  std::vector<double> teeth;
  std::uint64_t bone = 0;
  int found_in = 0;
};
Felt LowerThrough(const EffectChoices& choices) {
  CoupledParams params;
  params.coupling.stiffness_N_per_mm = 10;
  params.effects = choices;
  CoupledSimulation simulation(Bar(), params, PoseAt(0));
  auto* effect = dynamic_cast<FragmentsEffect*>(EffectsOf(simulation).Find("fragments"));
  Felt felt;
  for (int tick = 1; tick <= 2 * kTicks; ++tick) {
    CoupledOutput out;
    {
      const HeapGuard guard;
      out = simulation.Tick({.X_WH = PoseAt(tick / 2)});
    }
    felt.force_N.push_back(out.f_H_W_N);
    felt.teeth.push_back(out.engaged_teeth);
    if (effect == nullptr) continue;
    Tell(simulation, *effect);
    if (tick % 20 == 0 && effect->Look(0.001 * tick) > 0) felt.found_in = tick;
  }
  felt.bone = simulation.UpdateBone().CalcHash();
  return felt;
}

// A piece that comes off is held in place and stays part of the bone: the hand's force is bit-identical with and
// without the effect, before, during and after the separation.
TEST(Fragments, SeparationDoesNotChangeTheForce) {
  const Felt with = LowerThrough(WithFragments(1));
  const Felt without = LowerThrough({});
  ASSERT_GT(with.found_in, 0);
  EXPECT_EQ(with.bone, without.bone);
  double largest_N = 0;
  for (std::size_t i = 0; i < with.force_N.size(); ++i) {
    ASSERT_EQ(with.force_N[i], without.force_N[i]) << i;
    largest_N = std::max(largest_N, glm::length(with.force_N[i]));
  }
  // The force is large enough to feel: the coupling releases it at the breakthrough in both runs.
  EXPECT_GT(largest_N, 0.5);
}

TEST(Fragments, SmallerPartsCountAsDust) {
  SimulationParams params;
  params.effects = WithFragments(30);  // mm3: larger than the smaller part, smaller than the larger one
  Simulation simulation(Bar(), params, PoseAt(0));
  auto& effect = dynamic_cast<FragmentsEffect&>(*EffectsOf(simulation).Find("fragments"));
  for (int tick = 1; tick <= kTicks; ++tick) simulation.Tick({PoseAt(tick)});
  Tell(simulation, effect);
  EXPECT_EQ(effect.Look(1), 0u);
  const FoundPieces& found = effect.watch().finder().found();
  EXPECT_EQ(found.pieces.size(), 1u);
  EXPECT_GE(found.dust_count, 1u);
  EXPECT_NEAR(found.dust_mm3, 1.845 * 12, 5);
  EXPECT_TRUE(effect.watch().events().empty());
}

}  // namespace
}  // namespace kerf
