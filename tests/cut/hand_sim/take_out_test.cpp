// A piece is taken out of the bone and put back: the remaining bone, the removed volume, and the force.
#include "cut/hand_sim/take_out.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "base/core/heap_guard.h"
#include "kerf/surface.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr double kTakeOutVoxel_mm = 0.1;

/// Returns a pose above a bar of 12 x 5 x 4 mm, with the disc's centre at x_mm and height z_mm and the spindle along x.
Pose PoseAt(double x_mm, double z_mm) {
  Pose X;
  X.R_AB = glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0));
  X.p_AB = {x_mm, 0, z_mm};
  return X;
}
constexpr double kAway_mm = 40;

class TakeOutTest : public testing::Test {
 protected:
  void SetUp() override {
    CoupledParams params;
    params.coupling.stiffness_N_per_mm = 20;
    params.effects.clear();
    Bone bar = test::MakeBox({}, {12, 5, 4}, kTakeOutVoxel_mm);
    finder_.emplace(bar, 0.5);
    simulation_.emplace(std::move(bar), params, PoseAt(1.03, kAway_mm));
    // The tool lags the handle by 1.3 mm as long as it cuts.
    for (double z = 14; z > 7; z -= 0.01) Tick(PoseAt(1.03, z));
    for (double z = 7; z < 14; z += 0.02) Tick(PoseAt(1.03, z));
    GoTo(kAway_mm);
    UpdateFinder();
    ASSERT_EQ(finder_->found().came_off.size(), 1u);
    ASSERT_EQ(finder_->found().pieces.size(), 2u);
  }

  CoupledOutput Tick(const Pose& X_WH) {
    const HeapGuard guard;
    return simulation_->Tick({.X_WH = X_WH});
  }
  void GoTo(double z_mm) { Tick(PoseAt(1.03, z_mm)); }
  void UpdateFinder() {
    for (int i = 0; i < simulation_->changed_count(); ++i) {
      const auto leaf = simulation_->changed(i);
      finder_->Change(leaf.index, std::span<const float, 512>(leaf.values, 512));
    }
    simulation_->ClearChanged();
    finder_->Find();
  }
  /// Calls Step() until it is done; returns the number of steps.
  int Run(TakeOut& out) {
    int steps = 0;
    for (bool done = false; !done && steps < 10'000; ++steps) {
      const HeapGuard guard;
      done = out.Step(*simulation_, 4);
    }
    return steps;
  }
  double Removed() {
    double sum_mm3 = 0;
    for (const double mm3 : simulation_->CalcRemovedByRegion()) sum_mm3 += mm3;
    return sum_mm3;
  }

  std::optional<PieceFinder> finder_;
  std::optional<CoupledSimulation> simulation_;
};

TEST_F(TakeOutTest, LeavesTheRestUnchangedAndIsRestoredBitForBit) {
  const Bone whole = simulation_->UpdateBone();
  const std::uint64_t hash = whole.CalcHash();
  const double removed_mm3 = Removed();
  const Pieces split = SplitPieces(whole, 0.5);
  const PieceRemoval removal = MakePieceRemoval(whole, *finder_, 2);
  // Except for rounding, the piece taken out equals the piece that would be written at the end of a run.
  EXPECT_NEAR(removal.piece.CalcVolume(), split.pieces[1].CalcVolume(), 1e-9);
  EXPECT_EQ(SplitPieces(removal.piece).pieces.size(), 1u);

  TakeOut out(removal);
  EXPECT_EQ(Run(out), 1);  // the piece is in place: nothing to do
  for (const bool settled : {false, true}) {
    out.Leave();
    EXPECT_GE(Run(out), static_cast<int>(removal.leaves.size() / 4));
    EXPECT_EQ(out.place(), PiecePlace::kOut);
    // Taking the piece out does not change the volume counted as cut, except for rounding of the sums.
    EXPECT_NEAR(Removed(), removed_mm3, 1e-9);
    if (settled) {
      EXPECT_NEAR(simulation_->UpdateBone().CalcVolume(), split.pieces[0].CalcVolume() + split.dust_mm3, 1e-9);
      EXPECT_NEAR(whole.CalcVolume() - simulation_->UpdateBone().CalcVolume(), removal.piece.CalcVolume(), 1e-9);
    }
    UpdateFinder();
    EXPECT_EQ(finder_->found().pieces.size(), 1u);
    EXPECT_EQ(finder_->found().At(2), nullptr);
    out.Return();
    Run(out);
    EXPECT_EQ(out.place(), PiecePlace::kHeld);
    EXPECT_NEAR(Removed(), removed_mm3, 1e-9);
    UpdateFinder();
    EXPECT_EQ(finder_->found().pieces.size(), 2u);
  }
  EXPECT_EQ(simulation_->UpdateBone().CalcHash(), hash);
}

TEST_F(TakeOutTest, CanBeReversedHalfWay) {
  const Bone whole = simulation_->UpdateBone();
  const double removed_mm3 = Removed();
  const PieceRemoval removal = MakePieceRemoval(whole, *finder_, 2);
  TakeOut out(removal);
  out.Leave();
  EXPECT_FALSE(out.Step(*simulation_, 3));
  out.Return();
  Run(out);
  EXPECT_NEAR(Removed(), removed_mm3, 1e-9);
  EXPECT_EQ(simulation_->UpdateBone().CalcHash(), whole.CalcHash());
}

TEST_F(TakeOutTest, WaitsWhileTheToolIsNear) {
  const Bone whole = simulation_->UpdateBone();
  const PieceRemoval removal = MakePieceRemoval(whole, *finder_, 2);
  TakeOut out(removal);
  out.Leave();
  // The tool is set down in its kerf and pushed against the wall. The force does not depend on whether taking out the
  // piece was requested.
  CoupledSimulation other(whole, simulation_->params(), PoseAt(1.03, kAway_mm));
  CoupledSimulation plain(whole, simulation_->params(), PoseAt(1.03, kAway_mm));
  double largest_N = 0;
  for (int tick = 0; tick < 500; ++tick) {
    const Pose X = PoseAt(1.03 + 0.1 * std::sin(0.02 * tick), std::max(10.0, 14 - 0.02 * tick));
    const HeapGuard guard;
    const CoupledOutput a = other.Tick({.X_WH = X, .rpm = 0});
    const CoupledOutput b = plain.Tick({.X_WH = X, .rpm = 0});
    EXPECT_FALSE(out.Step(other));
    EXPECT_TRUE(out.waits_for_tool());
    ASSERT_EQ(a.f_H_W_N, b.f_H_W_N) << tick;
    largest_N = std::max(largest_N, glm::length(a.f_H_W_N));
  }
  EXPECT_GT(largest_N, 0.5);
  EXPECT_EQ(other.UpdateBone().CalcHash(), whole.CalcHash());
  // Pulled out of its kerf, the tool follows the handle in steps of half a voxel.
  for (int tick = 0; tick < 200; ++tick) other.Tick({.X_WH = PoseAt(1.03, kAway_mm), .rpm = 0});
  while (!out.Step(other)) ASSERT_FALSE(out.waits_for_tool());
  EXPECT_EQ(out.place(), PiecePlace::kOut);
}

TEST_F(TakeOutTest, NoForceWhereThePieceWas) {
  const Bone whole = simulation_->UpdateBone();
  const PieceRemoval removal = MakePieceRemoval(whole, *finder_, 2);
  TakeOut out(removal);
  out.Leave();
  Run(out);
  const double removed_mm3 = Removed();
  // The tool moves down through the middle of the piece's former place and back up.
  for (double z = 14; z > 8; z -= 0.02) {
    const CoupledOutput felt = Tick(PoseAt(3.5, z));
    EXPECT_EQ(felt.f_H_W_N, Vec3(0)) << z;
    EXPECT_EQ(felt.engaged_teeth, 0) << z;
  }
  for (const double x : {3.5, -2.0}) {
    for (int tick = 0; tick < 200; ++tick) Tick(PoseAt(x, kAway_mm));
  }
  EXPECT_NEAR(Removed(), removed_mm3, 1e-9);
  // The remaining bone is unchanged: cutting it gives bit-identical results to cutting the bone with the piece.
  CoupledSimulation with_piece(whole, simulation_->params(), PoseAt(-2, kAway_mm));
  for (double z = 14; z > 8; z -= 0.01) {
    const CoupledOutput felt = Tick(PoseAt(-2, z));
    ASSERT_EQ(felt.f_H_W_N, with_piece.Tick({.X_WH = PoseAt(-2, z)}).f_H_W_N) << z;
  }
  for (int tick = 0; tick < 200; ++tick) {
    Tick(PoseAt(-2, kAway_mm));
    with_piece.Tick({.X_WH = PoseAt(-2, kAway_mm)});
  }
  out.Return();
  Run(out);
  EXPECT_EQ(simulation_->UpdateBone().CalcHash(), with_piece.UpdateBone().CalcHash());
}

TEST_F(TakeOutTest, AllDustIsTakenOutTogether) {
  const Bone whole = simulation_->UpdateBone();
  const Pieces split = SplitPieces(whole, 110);  // the smaller piece is 4.8 x 5 x 4 mm, the larger one 6.9 x 5 x 4 mm
  ASSERT_EQ(split.pieces.size(), 1u);
  finder_.emplace(whole, 110);
  ASSERT_GE(finder_->found().dust_count, 1u);
  const PieceRemoval removal = MakePieceRemoval(whole, *finder_, kAllDust);
  TakeOut out(removal);
  out.Leave();
  Run(out);
  UpdateFinder();
  EXPECT_EQ(finder_->found().dust_count, 0u);
  EXPECT_EQ(finder_->found().pieces.size(), 1u);
  EXPECT_NEAR(simulation_->UpdateBone().CalcVolume(), split.pieces[0].CalcVolume(), 1e-9);
  EXPECT_THROW(MakePieceRemoval(simulation_->UpdateBone(), *finder_, kAllDust), std::exception);
}

TEST_F(TakeOutTest, UnknownPieceNumberIsRefused) {
  EXPECT_THROW(MakePieceRemoval(simulation_->UpdateBone(), *finder_, 3), std::exception);
}

}  // namespace
}  // namespace kerf
