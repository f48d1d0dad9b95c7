// Means over the teeth of a tick.
#include "cut/path_sim/teeth_sums.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

// Substeps of 1 and 3 ms with 2 and 4 teeth: the mean over the time has 3.5 teeth. Stiffness and bite are means over
// the teeth.
TEST(TeethSums, WeightSubstepsByTheirTimeAndMaterialByTheTeeth) {
  TeethSums first;
  first.thrust_N = 1 * 8.0;
  first.teeth = 1 * 2.0;
  first.E_MPa = first.teeth * 1000;
  first.bite_mm = first.teeth * 0.01;
  first.thrust_by_region_N[3] = first.thrust_N;
  TeethSums second;
  second.thrust_N = 3 * 16.0;
  second.teeth = 3 * 4.0;
  second.E_MPa = second.teeth * 8000;
  second.bite_mm = second.teeth * 0.03;
  second.thrust_by_region_N[7] = second.thrust_N;
  TeethSums sums;
  sums.Add(first);
  sums.Add(second);
  TeethOutput out;
  sums.Report(4, out);
  EXPECT_DOUBLE_EQ(out.thrust_sum_N, 14);
  EXPECT_DOUBLE_EQ(out.engaged_teeth, 3.5);
  EXPECT_DOUBLE_EQ(out.mean_E_MPa, 7000);
  EXPECT_DOUBLE_EQ(out.mean_bite_mm, 0.38 / 14);
  EXPECT_EQ(out.main_region, 7);
}

TEST(TeethSums, WithoutTeethThereIsNoMaterial) {
  TeethOutput out;
  TeethSums().Report(4, out);
  EXPECT_EQ(out.engaged_teeth, 0);
  EXPECT_EQ(out.mean_E_MPa, 0);
  EXPECT_EQ(out.main_region, 0);
}

}  // namespace
}  // namespace kerf
