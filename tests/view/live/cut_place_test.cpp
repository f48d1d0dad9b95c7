#include "view/live/cut_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "support/solids.h"

namespace kerf {
namespace {

TEST(CutPlace, IsOnTheRimOppositeToTheForce) {
  DiscSaw saw;
  saw.diameter_mm = 20;
  const Pose X_WT{glm::angleAxis(0.4, glm::normalize(Vec3{1, -1, 2})), {3, 4, 5}};
  const auto at = EstimateContact(saw, X_WT, X_WT.Vector({0, 3, 7}));  // the part along the spindle does not count
  ASSERT_TRUE(at);
  EXPECT_NEAR(glm::length(*at - X_WT.Point({0, -10, 0})), 0, 1e-12);
  EXPECT_FALSE(EstimateContact(saw, X_WT, {0, 0, 0}));
  EXPECT_FALSE(EstimateContact(saw, X_WT, X_WT.Vector({0, 0, 5})));
  const auto on_ball = EstimateContact(BallBurr{.diameter_mm = 6}, X_WT, X_WT.Vector({0, 0, 5}));
  ASSERT_TRUE(on_ball);
  EXPECT_NEAR(glm::length(*on_ball - X_WT.Point({0, 0, -3})), 0, 1e-12);
}

TEST(CutPlace, IsAtTheTipOfADrillAndInTheMiddleOfAStraightEdge) {
  const Pose X_WT{glm::angleAxis(0.4, glm::normalize(Vec3{1, -1, 2})), {3, 4, 5}};
  // Pushed back along its axis and a little to the side: the end of a lip on the other side.
  const TwistDrill drill;
  const double tip_mm = drill.radius_mm() / std::tan(0.5 * drill.point_angle_deg * std::numbers::pi / 180);
  const auto at = EstimateContact(drill, X_WT, X_WT.Vector({2, 0, 3}));
  ASSERT_TRUE(at);
  EXPECT_NEAR(glm::length(*at - X_WT.Point({-drill.radius_mm(), 0, tip_mm})), 0, 1e-12);
  const auto on_tip = EstimateContact(drill, X_WT, X_WT.Vector({0, 0, 3}));
  ASSERT_TRUE(on_tip);
  EXPECT_NEAR(glm::length(*on_tip - X_WT.p_AB), 0, 1e-12);
  const auto on_blade = EstimateContact(ReciprocatingBlade{}, X_WT, X_WT.Vector({-3, 1, 0}));
  ASSERT_TRUE(on_blade);
  EXPECT_EQ(*on_blade, X_WT.p_AB);
}

TEST(CutPlace, IsInTheMiddleOfThePartOfAStraightEdgeThatIsInBone) {
  // The edge lies along y from -5 to 25 and is in the bone from -4 to 4.
  const Bone block = test::MakeBox({}, {8, 8, 8}, 0.4);
  const Pose X_WT{{1, 0, 0, 0}, {1, 10, 0}};
  const auto at = EstimateContact(ReciprocatingBlade{}, X_WT, {-3, 0, 0}, &block);
  ASSERT_TRUE(at);
  EXPECT_NEAR(glm::length(*at - Vec3(1, 0, 0)), 0, 0.4);
  EXPECT_EQ(*EstimateContact(ReciprocatingBlade{}, {{1, 0, 0, 0}, {9, 10, 0}}, {-3, 0, 0}, &block), Vec3(9, 10, 0));
  EXPECT_EQ(EstimateContact(DiscSaw{}, X_WT, {-3, 0, 0}, &block), EstimateContact(DiscSaw{}, X_WT, {-3, 0, 0}));
}

TEST(CutPlace, StaysOnTheRimAndIsForgottenAfterAWhile) {
  DiscSaw saw;
  CutPlace place;
  const Pose X_WT{{1, 0, 0, 0}, {1, 1, 1}};
  EXPECT_FALSE(place.p_W());
  place.Update(saw, X_WT, {0, 0, 0}, 0.02);
  EXPECT_FALSE(place.p_W());
  for (int i = 0; i < 100; ++i) {
    place.Update(saw, X_WT, {std::cos(0.05 * i), std::sin(0.05 * i), 0}, 0.02);
    ASSERT_TRUE(place.p_W());
    EXPECT_NEAR(glm::length(*place.p_W() - X_WT.p_AB), saw.radius_mm(), 1e-9);
  }
  // It follows: within a tenth of a second of a steady motion of 2.5 rad/s, it lags 0.15 s behind, which is 0.38 rad.
  const Vec3 wanted = X_WT.p_AB - saw.radius_mm() * Vec3{std::cos(0.05 * 99), std::sin(0.05 * 99), 0};
  EXPECT_LT(glm::length(*place.p_W() - wanted), 0.5 * saw.radius_mm());
  place.Update(saw, X_WT, {0, 0, 0}, 0.9 * CutPlace::kHold_s);
  EXPECT_TRUE(place.p_W());
  place.Update(saw, X_WT, {0, 0, 0}, 0.2 * CutPlace::kHold_s);
  EXPECT_FALSE(place.p_W());
}

}  // namespace
}  // namespace kerf
