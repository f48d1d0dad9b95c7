// Regions that a segmentation adds.
#include "bone/material/segment_regions.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

Region Named(const char* name, Tissue tissue = Tissue::kTooth) {
  return {.id = 1, .name = name, .tissue = tissue, .E_MPa = 1, .nu = 0.3, .source = "test"};
}

TEST(SegmentRegions, TheNumberOfAToothIsInItsName) {
  EXPECT_EQ(FindToothNumber(Named("tooth 36")), 36);
  EXPECT_EQ(FindToothNumber(Named("tooth 85")), 85);
  for (const char* name : {"tooth", "tooth ", "tooth 9", "tooth 39", "tooth 361", "tooth 3 6", "molar 36"}) {
    EXPECT_EQ(FindToothNumber(Named(name)), 0) << name;
  }
  EXPECT_EQ(FindToothNumber(Named("tooth 36", Tissue::kCortical)), 0);
}

TEST(SegmentRegions, AreReadAndWrittenWithTheTable) {
  MaterialTable table = DefaultMandibleTable();
  AddTooth(36, "t", table);
  AddTooth(36, "t", table);  // it is there already
  AddMetal("t", table);
  AddLesion("t", table);
  EXPECT_EQ(table.regions().size(), DefaultMandibleTable().regions().size() + 3);
  const MaterialTable read = ParseRegionTable(FormatRegionTable(table), "t.csv");
  EXPECT_EQ(FindToothNumber(read.At(ToothRegion(36))), 36);
  EXPECT_EQ(read.At(kMetalRegion).tissue, Tissue::kMetal);
  EXPECT_EQ(read.At(kLesionRegion).tissue, Tissue::kLesion);
}

}  // namespace
}  // namespace kerf
