// Tests of the dust: its number, its motion and its repeatability.
#include "view/live/dust.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace kerf {
namespace {

TEST(Dust, NumberOfGrainsIsThatOfTheVolume) {
  DustCloud cloud(100000);
  // In parts of less than a grain, too: nothing is lost by rounding.
  for (int i = 0; i < 1000; ++i) cloud.Add({0, 0, 0}, {0, 0, 50}, 0.01);
  EXPECT_NEAR(static_cast<double>(cloud.size()), 10 * DustCloud::kGrainsPerMm3, 1);
}

TEST(Dust, NumberIsBoundedAndTheOldestGoFirst) {
  DustCloud cloud(50);
  cloud.Add({0, 0, 0}, {0, 0, 50}, 1e9);
  EXPECT_EQ(cloud.size(), 50u);
  cloud.Add({100, 0, 0}, {0, 0, 50}, 10 / DustCloud::kGrainsPerMm3 + 1e-9);
  EXPECT_EQ(cloud.size(), 50u);
  int fresh = 0;
  for (const DustGrain& grain : cloud.MakeGrains()) fresh += grain.p_W.x > 50 ? 1 : 0;
  EXPECT_EQ(fresh, 10);
  cloud.set_max_grains(5);
  EXPECT_EQ(cloud.size(), 5u);
  for (const DustGrain& grain : cloud.MakeGrains()) EXPECT_GT(grain.p_W.x, 50);
}

TEST(Dust, EqualCallsGiveEqualGrains) {
  const auto make = [](std::uint32_t seed) {
    DustCloud cloud(1000, seed);
    for (int i = 0; i < 20; ++i) {
      cloud.Add({0.1 * i, 0, 0}, {20, 30, 0}, 0.3);
      cloud.Advance(0.016);
    }
    return cloud.MakeGrains();
  };
  const auto a = make(7);
  const auto b = make(7);
  const auto c = make(8);
  ASSERT_EQ(a.size(), b.size());
  bool differs = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p_W, b[i].p_W);
    EXPECT_EQ(a[i].opacity, b[i].opacity);
    differs = differs || i >= c.size() || a[i].p_W != c[i].p_W;
  }
  EXPECT_TRUE(differs);
}

TEST(Dust, MotionDoesNotDependOnTheFrameRate) {
  DustCloud coarse(500), fine(500);
  for (DustCloud* cloud : {&coarse, &fine}) cloud->Add({1, 2, 3}, {0, 80, 0}, 2);
  coarse.Advance(0.32);
  for (int i = 0; i < 64; ++i) fine.Advance(0.005);
  const auto a = coarse.MakeGrains();
  const auto b = fine.MakeGrains();
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 50u);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(glm::length(a[i].p_W - b[i].p_W), 0, 1e-9);
}

TEST(Dust, FliesAlongTheTeethAndVanishes) {
  DustCloud cloud(500);
  cloud.Add({0, 0, 0}, {4000, 0, 0}, 2);
  cloud.Advance(0.1);
  Vec3 mean{0};
  for (const DustGrain& grain : cloud.MakeGrains()) {
    mean += grain.p_W / static_cast<double>(cloud.size());
    EXPECT_GT(grain.opacity, 0);
    EXPECT_LE(grain.opacity, 1);
    // A grain has at most the speed 150 (1 + 0.45 sqrt(3)) mm/s and starts at most 0.6 sqrt(3) mm away.
    EXPECT_LT(glm::length(grain.p_W), 0.1 * 150 * 1.78 + 1.04 + 0.1 * 14);
  }
  EXPECT_GT(mean.x, 3);
  EXPECT_LT(std::abs(mean.y), 1);
  cloud.Advance(DustCloud::kLife_s);
  EXPECT_EQ(cloud.size(), 0u);
}

TEST(Dust, IgnoresInvalidInput) {
  DustCloud cloud(500);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  cloud.Add({0, 0, 0}, {0, 0, 1}, 0);
  cloud.Add({0, 0, 0}, {0, 0, 1}, -5);
  cloud.Add({0, 0, 0}, {0, 0, 1}, nan);
  cloud.Add({nan, 0, 0}, {0, 0, 1}, 1);
  cloud.Add({0, 0, 0}, {0, nan, 1}, 1);
  EXPECT_EQ(cloud.size(), 0u);
  cloud.Add({0, 0, 0}, {0, 0, 0}, 1);
  const std::size_t count = cloud.size();
  cloud.Advance(-1);
  cloud.Advance(nan);
  EXPECT_EQ(cloud.size(), count);
}

}  // namespace
}  // namespace kerf
