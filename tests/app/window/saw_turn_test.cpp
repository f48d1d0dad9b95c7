#include "app/window/saw_turn.h"

#include <gtest/gtest.h>

#include <numbers>

namespace kerf {
namespace {

using State = SawTurn::State;

Pose Turned(double angle_rad) {
  return {glm::angleAxis(angle_rad, Vec3{1, 0, 0}), Vec3{0}};
}

TEST(SawTurn, EndsOnceAtTheGoalAndNotBefore) {
  SawTurn turn;
  EXPECT_EQ(turn.Update(0.1, Turned(0), true), State::kNone);
  turn.Begin(Turned(0.5), 10);
  for (double angle = 0; angle < 0.46; angle += 0.02) EXPECT_EQ(turn.Update(0.5, Turned(angle), true), State::kTurning);
  EXPECT_TRUE(turn.is_turning());
  EXPECT_EQ(turn.Update(0.5, Turned(0.49), true), State::kDone) << "0.1 mm at the rim";
  EXPECT_FALSE(turn.is_turning());
  EXPECT_EQ(turn.Update(0.5, Turned(0.49), true), State::kNone);
}

TEST(SawTurn, ASawThatIsHeldBackIsStuckAfterAWhile) {
  SawTurn turn;
  turn.Begin(Turned(0.5), 10);
  EXPECT_EQ(turn.Update(0.1, Turned(0.2), true), State::kTurning);
  EXPECT_EQ(turn.Update(0.9 * SawTurn::kPatience_s, Turned(0.2), true), State::kTurning);
  EXPECT_EQ(turn.Update(0.2 * SawTurn::kPatience_s, Turned(0.2), true), State::kStuck);
  // Friction may stop a saw in air just before its goal.
  turn.Begin(Turned(0.5), 10);
  EXPECT_EQ(turn.Update(0.1, Turned(0.45), true), State::kTurning);
  EXPECT_EQ(turn.Update(1.1 * SawTurn::kPatience_s, Turned(0.45), true), State::kDone);
}

// What counts is the blade's plane: bone may keep the saw from the goal's place in it.
TEST(SawTurn, ASawThatStopsInThePlaneIsDone) {
  const Pose X_goal{{1, 0, 0, 0}, {0, 0, 0}};
  const auto stop_at = [&](const Pose& X_WT) {
    SawTurn turn;
    turn.Begin(X_goal, 10);
    turn.Update(0.1, X_WT, true);
    return turn.Update(1.1 * SawTurn::kPatience_s, X_WT, true);
  };
  EXPECT_EQ(stop_at({X_goal.R_AB, {6, -3, 0.28}}), State::kDone);
  EXPECT_EQ(stop_at({X_goal.R_AB, {6, -3, 1.2}}), State::kStuck) << "beside the plane";
  EXPECT_EQ(stop_at({glm::angleAxis(0.2, Vec3{1, 0, 0}), {6, -3, 0}}), State::kStuck) << "2 mm at the rim";
  EXPECT_NEAR(SawTurn::CalcBeside({glm::angleAxis(std::numbers::pi, Vec3{1, 0, 0}), {6, -3, -0.2}}, X_goal, 10), 0.2,
              1e-6)
      << "either face of the blade";
}

TEST(SawTurn, TheUserInterruptsIt) {
  SawTurn turn;
  turn.Begin(Turned(0.5), 10);
  EXPECT_EQ(turn.Update(0.1, Turned(0.1), false), State::kInterrupted);
  EXPECT_FALSE(turn.is_turning());
}

}  // namespace
}  // namespace kerf
