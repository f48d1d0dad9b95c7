// Tests that colours with a meaning are distinguishable with any colour vision. This is computed, not judged by eye.
#include <gtest/gtest.h>

#include <cmath>

#include "bone/material/region_table.h"
#include "support/colour_vision.h"
#include "view/live/palette.h"

namespace kerf {
namespace {

// A difference of 2.3 is just noticeable side by side; ten times as much is distinguishable at a glance.
TEST(Colours, TissuesOfACutFaceAreDistinguishableWithAnyColourVision) {
  test::ExpectApart({CutColour(Tissue::kCortical), CutColour(Tissue::kCancellous), CutColour(Tissue::kCanal)}, 25,
                    "tissue");
  test::ExpectApart({CutColour(Tissue::kTooth), CutColour(Tissue::kCancellous), CutColour(Tissue::kCanal)}, 25,
                    "tissue");
  // Compares cut cortex with the outside of the bone and with a tooth: pale colours that are seen side by side.
  test::ExpectApart({CutColour(Tissue::kCortical), kBoneColour, CutColour(Tissue::kTooth)}, 10, "pale");
}

TEST(Palette, PlainBoneShowsTissueOnlyOnCutFaces) {
  const MaterialTable& table = DefaultMandibleTable();
  const BonePalette plain = MakePalette(table, ColourBy::kPlain);
  const auto rgb = [](const std::array<std::uint8_t, 4>& c) { return Rgb8{c[0], c[1], c[2]}; };
  EXPECT_EQ(rgb(plain[24]), kBoneColour);
  EXPECT_EQ(rgb(plain[kCancellousRegion]), kBoneColour);
  EXPECT_EQ(rgb(plain[256 + kCancellousRegion]), CutColour(Tissue::kCancellous));
  EXPECT_EQ(plain[kCancellousRegion][3], 0);
  EXPECT_EQ(plain[256 + kCancellousRegion][3], 255);
  const BonePalette regions = MakePalette(table, ColourBy::kRegion);
  EXPECT_EQ(rgb(regions[24]), RegionColour(24));
  EXPECT_EQ(rgb(regions[256 + 24]), RegionColour(24));
}

TEST(Palette, LegendNamesTheVisibleEntries) {
  const MaterialTable& table = DefaultMandibleTable();
  PaletteCounts counts{};
  counts[24] = 5000;
  EXPECT_TRUE(MakeLegend(table, ColourBy::kPlain, counts).empty());
  counts[256 + kCancellousRegion] = 700;
  counts[256 + 24] = 300;
  const auto cut = MakeLegend(table, ColourBy::kPlain, counts);
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_EQ(cut[0].text, "cortical");
  EXPECT_EQ(cut[1].text, "cancellous");
  const auto regions = MakeLegend(table, ColourBy::kRegion, counts);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[0].text.rfind("24 ", 0), 0u);
  counts[21] = 1;  // of 6001: too few for an entry
  EXPECT_EQ(MakeLegend(table, ColourBy::kRegion, counts).size(), 2u);
}

}  // namespace
}  // namespace kerf
