// The fraction of 28 N that each device can output.
#include "device/devices/force_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// Published values for the Omni: 3.3 N of 28 N is a scale of 0.118, and 0.26 N of friction hides 2.2 N.
TEST(ForceTable, OmniHidesTwoNewtonsOfTwentyEight) {
  const ForceTableRow row = CalcForceTable({FindDeviceProfile("omni")}, 28).at(0);
  EXPECT_NEAR(row.scale, 0.118, 5e-4);
  EXPECT_NEAR(row.masked_N, 2.2, 0.05);
  EXPECT_DOUBLE_EQ(row.largest_N, 28);
  EXPECT_NEAR(row.lasting_N, 0.88 / 3.3 * 28, 1e-9);
  EXPECT_NEAR(row.lasting_fraction, 0.88 / 3.3, 1e-12);
}

TEST(ForceTable, NeverScalesUpAndAgreesWithTheProfile) {
  const std::vector<ForceTableRow> table = CalcForceTable(DeviceProfiles(), 28);
  ASSERT_EQ(table.size(), DeviceProfiles().size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    const ForceTableRow& row = table[i];
    const DeviceProfile& profile = DeviceProfiles()[i];
    EXPECT_EQ(row.profile.name, profile.name);
    EXPECT_LE(row.scale, 1);
    EXPECT_GE(row.largest_N, 28 - 1e-9);
    EXPECT_NEAR(row.largest_N * row.scale, profile.peak_force_N, 1e-9);
    EXPECT_NEAR(row.masked_N * row.scale, profile.friction_N, 1e-9);
    EXPECT_LE(row.lasting_fraction, 1);
    EXPECT_EQ(row.lasting_fraction > 0, profile.continuous_force_N > 0) << profile.name;
  }
}

TEST(ForceTable, RefusesInvalidForces) {
  for (const double wrong : {0.0, -1.0, 1e5, std::nan("")}) EXPECT_THROW(CalcForceTable({}, wrong), Error);
}

}  // namespace
}  // namespace kerf
