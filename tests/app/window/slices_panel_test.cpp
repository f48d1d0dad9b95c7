// Tests of the texts and the scale bar of slices.
#include "app/window/slices_panel.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(SlicesPanel, NamesThePlaceOfASliceByThePatientsSides) {
  EXPECT_EQ(DescribeSliceAt(SliceKind::kSagittal, 0, 25.14), "sagittal, 25.1 mm left");
  EXPECT_EQ(DescribeSliceAt(SliceKind::kCoronal, 1, -74.7), "coronal, 74.7 mm front");
  EXPECT_EQ(DescribeSliceAt(SliceKind::kAxial, 2, 31.8), "axial, 31.8 mm up");
}

TEST(SlicesPanel, AScaleBarHasTheLengthOfTheSlicesMillimetres) {
  EXPECT_EQ(CalcSliceBar(80, 160, 1), 20);  // 10 of 80 mm, 160 pixels
  EXPECT_FALSE(CalcSliceBar(500, 160, 1)) << "too short";
  EXPECT_FALSE(CalcSliceBar(15, 160, 1)) << "too long";
}

}  // namespace
}  // namespace kerf
