#include "kerf/material.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

Region MakeRegion(int id, double E_MPa, double nu) {
  return {id, "a region", Tissue::kCortical, E_MPa, nu, true, "a test"};
}

std::string MessageOf(const Region& region, MaterialTable table = {}) {
  return test::MessageOf([&] { table.Add(region); }, "accepted");
}

TEST(MaterialTable, AcceptsTheEndsOfEachRangeAndRefusesValuesBeyond) {
  EXPECT_EQ(MessageOf(MakeRegion(1, 1000, 0)), "accepted");
  EXPECT_EQ(MessageOf(MakeRegion(255, 1e7, 0.5)), "accepted");
  EXPECT_EQ(MessageOf(MakeRegion(0, 1000, 0.3)), "region: id = 0 is below 1; valid range 1 to 255");
  EXPECT_EQ(MessageOf(MakeRegion(256, 1000, 0.3)), "region: id = 256 is above 255; valid range 1 to 255");
  EXPECT_EQ(MessageOf(MakeRegion(7, 0, 0.3)), "region 7: E = 0 GPa must be above 0 and at most 1000000");
  EXPECT_EQ(MessageOf(MakeRegion(7, -5000, 0.3)), "region 7: E = -5 GPa must be above 0 and at most 1000000");
  EXPECT_EQ(MessageOf(MakeRegion(7, std::numeric_limits<double>::quiet_NaN(), 0.3)),
            "region 7: E = nan GPa must be above 0 and at most 1000000");
  EXPECT_EQ(MessageOf(MakeRegion(7, 1000, -0.1)), "region 7: nu = -0.1 is below 0; valid range 0 to 0.5");
  EXPECT_EQ(MessageOf(MakeRegion(7, 1000, 0.51)), "region 7: nu = 0.51 is above 0.5; valid range 0 to 0.5");
}

TEST(MaterialTable, RefusesDuplicateIdsAndNamesUnknownOnes) {
  MaterialTable table;
  table.Add(MakeRegion(5, 1000, 0.3));
  EXPECT_EQ(MessageOf(MakeRegion(5, 2000, 0.3), table), "region 5 is given twice");
  EXPECT_TRUE(table.Contains(5));
  EXPECT_FALSE(table.Contains(6));
  EXPECT_THAT([&] { table.At(6); }, testing::ThrowsMessage<Error>("the region table has no region 6"));
}

TEST(Material, TissueNamesRoundTrip) {
  for (const Tissue t : {Tissue::kCortical, Tissue::kCancellous, Tissue::kTooth, Tissue::kCanal, Tissue::kOther}) {
    EXPECT_EQ(TissueFromString(ToString(t)), t);
  }
  EXPECT_EQ(TissueFromString("Cortical"), std::nullopt);
  EXPECT_EQ(TissueFromString(""), std::nullopt);
}

TEST(Material, ReducedModulusHasItsClosedForms) {
  // For equal bodies, E* is E / (2 (1 - nu^2)); against a rigid body, E / (1 - nu^2). It is symmetric in the two
  // bodies.
  EXPECT_DOUBLE_EQ(CalcReducedModulus(18000, 0.3, 18000, 0.3), 18000 / (2 * (1 - 0.09)));
  EXPECT_NEAR(CalcReducedModulus(18000, 0.3, 1e20, 0.3), 18000 / (1 - 0.09), 1e-6);
  EXPECT_DOUBLE_EQ(CalcReducedModulus(18000, 0.3, 205000, 0.28), CalcReducedModulus(205000, 0.28, 18000, 0.3));
  // The paper's K for region 24 against steel, K^3 = 3 d1 / (8 E*) in SI: 7.5539e-5 m N^(-1/3) (docs/physics.md).
  const double E_star_Pa = 1e6 * CalcReducedModulus(19300, 0.28, 205000, 0.28);
  EXPECT_NEAR(std::cbrt(3 * 0.022 / (8 * E_star_Pa)), 7.5539e-5, 5e-10);
}

}  // namespace
}  // namespace kerf
