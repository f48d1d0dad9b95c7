#include "device/devices/played_device.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

Pose At(double x_mm, double turn_rad = 0) {
  return {glm::angleAxis(turn_rad, Vec3{0, 0, 1}), {x_mm, 2, 3}};
}

TEST(PlayedDevice, ReturnsTheTablesPosesBitExactlyAtTheirTimes) {
  std::vector<PlayedPose> poses;
  for (int i = 0; i < 1000; ++i) poses.push_back({0.001 * i, {At(0.1 * i, 0.001 * i), 0}});
  PlayedDevice device({}, poses);
  // A sum of i steps of 0.001 differs from 0.001 i by rounding.
  for (int i = 0; i < 1000; ++i) {
    DeviceSample sample;
    ASSERT_TRUE(device.Read(sample));
    ASSERT_EQ(sample.X_WH.p_AB, poses[static_cast<std::size_t>(i)].sample.X_WH.p_AB) << i;
    ASSERT_EQ(sample.X_WH.R_AB, poses[static_cast<std::size_t>(i)].sample.X_WH.R_AB) << i;
    device.Elapse(0.001);
  }
}

TEST(PlayedDevice, InterpolatesLinearlyBetweenPoses) {
  PlayedDevice device({}, {{0, {At(0), 1}}, {2, {At(8, 1.2), 0}}});
  device.Elapse(0.5);
  DeviceSample sample;
  ASSERT_TRUE(device.Read(sample));
  EXPECT_NEAR(sample.X_WH.p_AB.x, 2, 1e-14);
  EXPECT_NEAR(2 * std::atan2(sample.X_WH.R_AB.z, sample.X_WH.R_AB.w), 0.3, 1e-14);
  EXPECT_EQ(sample.buttons, 1u);
  device.Elapse(100);
  ASSERT_TRUE(device.Read(sample));
  EXPECT_EQ(sample.X_WH.p_AB, At(8).p_AB);
  EXPECT_EQ(sample.buttons, 0u);
}

TEST(PlayedDevice, StaysAtASinglePoseUnderAnyForce) {
  PlayedDevice device({}, {{0, {At(5), 0}}});
  for (int i = 0; i < 10; ++i) {
    device.Elapse(0.001);
    DeviceSample sample;
    ASSERT_TRUE(device.Write({0, 0, -1e3}, Vec3{0}));
    ASSERT_TRUE(device.Read(sample));
    EXPECT_EQ(sample.X_WH.p_AB, At(5).p_AB);
  }
  EXPECT_EQ(device.force_N(), Vec3(0, 0, -1e3));
}

TEST(PlayedDevice, RefusesWhatCannotBePlayed) {
  EXPECT_THROW(PlayedDevice({}, {}), Error);
  EXPECT_THROW(PlayedDevice({}, {{0, {At(std::nan("")), 0}}}), Error);
  EXPECT_THROW(PlayedDevice({}, {{1, {At(0), 0}}, {1, {At(1), 0}}}), Error);
  EXPECT_THROW(PlayedDevice({}, {{std::nan(""), {At(0), 0}}}), Error);
}

}  // namespace
}  // namespace kerf
