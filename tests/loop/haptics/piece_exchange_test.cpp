// Tests of passing a piece from a reader to the loop and of its removal from the loop's bone.
#include "loop/haptics/piece_exchange.h"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>

#include "base/core/heap_guard.h"
#include "support/cuts.h"

namespace kerf {
namespace {

Pose PoseAt(double x_mm, double z_mm) {
  Pose X;
  X.R_AB = glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0));
  X.p_AB = {x_mm, 0, z_mm};
  return X;
}

class PieceExchangeTest : public testing::Test {
 protected:
  void SetUp() override {
    CoupledParams params;
    params.coupling.stiffness_N_per_mm = 20;
    params.effects.clear();
    Bone bar = test::MakeBox({}, {12, 5, 4}, 0.2);
    simulation_.emplace(std::move(bar), params, PoseAt(1.03, 40));
    for (double z = 14; z > 7; z -= 0.01) Tick(PoseAt(1.03, z));
    for (double z = 7; z < 14; z += 0.02) Tick(PoseAt(1.03, z));
    for (int i = 0; i < 100; ++i) Tick(PoseAt(1.03, 40));
    const PieceFinder finder(simulation_->UpdateBone(), 0.5);
    ASSERT_EQ(finder.found().pieces.size(), 2u);
    piece_.emplace(MakePieceRemoval(simulation_->UpdateBone(), finder, finder.found().pieces[1].id));
    ASSERT_TRUE(exchange_.Send(&*piece_));
  }
  CoupledOutput Tick(const Pose& X_WH) {
    const HeapGuard guard;
    const CoupledOutput out = simulation_->Tick({.X_WH = X_WH});
    exchange_.Step(*simulation_);
    return out;
  }

  std::optional<CoupledSimulation> simulation_;
  PieceExchange exchange_;
  std::optional<PieceTransfer> piece_;
};

TEST_F(PieceExchangeTest, LeavesOnlyWhenItMay) {
  const std::uint64_t whole = simulation_->UpdateBone().CalcHash();
  Tick(PoseAt(1.03, 40));
  const std::int64_t since = piece_->clear_since;
  EXPECT_GT(since, 0);
  // The tool is near the piece and then clear of it again, so the reader's check is out of date.
  for (int i = 0; i < 10; ++i) Tick(PoseAt(1.03, 14));
  EXPECT_EQ(piece_->clear_since, 0);
  piece_->go = since;
  for (int i = 0; i < 100; ++i) Tick(PoseAt(1.03, 40));
  EXPECT_GT(piece_->clear_since, since);
  EXPECT_FALSE(piece_->leaving);
  EXPECT_EQ(simulation_->UpdateBone().CalcHash(), whole);
  piece_->go = piece_->clear_since.load();
  int ticks = 0;
  for (; piece_->out_at == 0 && ticks < 10'000; ++ticks) Tick(PoseAt(1.03, 40));
  // Eight leaves are removed after each tick.
  EXPECT_EQ(ticks, static_cast<int>((piece_->removal.leaves.size() + 7) / 8));
  for (double z = 14; z > 8; z -= 0.02) EXPECT_EQ(Tick(PoseAt(3.5, z)).engaged_teeth, 0) << z;
}

TEST_F(PieceExchangeTest, IsDroppedWhenItWasCut) {
  const std::uint64_t whole = simulation_->UpdateBone().CalcHash();
  Tick(PoseAt(1.03, 40));
  piece_->drop = true;
  Tick(PoseAt(1.03, 40));
  EXPECT_TRUE(piece_->dropped);
  piece_->go = piece_->clear_since.load();
  Tick(PoseAt(1.03, 40));
  EXPECT_EQ(simulation_->UpdateBone().CalcHash(), whole);
  // The next piece can be sent.
  EXPECT_TRUE(exchange_.Send(&*piece_));
}

TEST_F(PieceExchangeTest, DropAffectsWaitingPiecesButNotLeavingOnes) {
  EXPECT_FALSE(exchange_.leaving());
  exchange_.Drop();  // the loop has not received the piece yet
  EXPECT_TRUE(piece_->dropped);
  piece_->dropped = false;
  EXPECT_TRUE(exchange_.Send(&*piece_));
  Tick(PoseAt(1.03, 40));
  exchange_.Drop();  // the loop has received it
  EXPECT_TRUE(piece_->dropped);
  piece_->dropped = false;
  piece_->clear_since = 0;
  EXPECT_TRUE(exchange_.Send(&*piece_));
  // Ticks in which the piece must not leave count too, because they are compared with the loop's tick numbers.
  for (int i = 0; i < 50; ++i) exchange_.Pass();
  Tick(PoseAt(1.03, 40));
  EXPECT_GT(piece_->clear_since, 50);
  piece_->go = piece_->clear_since.load();
  Tick(PoseAt(1.03, 40));
  EXPECT_TRUE(exchange_.leaving());
  exchange_.Drop();
  EXPECT_FALSE(piece_->dropped);
  for (int i = 0; i < 10'000 && piece_->out_at == 0; ++i) Tick(PoseAt(1.03, 40));
  EXPECT_GT(piece_->out_at, 0);
}

}  // namespace
}  // namespace kerf
