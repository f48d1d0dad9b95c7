// Tests that colours with a meaning are distinguishable with any colour vision. This is computed, not judged by eye.
#include <gtest/gtest.h>

#include <cmath>

#include "bone/material/region_table.h"
#include "support/colour_vision.h"
#include "view/live/overlay_colours.h"
#include "view/live/overlays.h"
#include "view/live/palette.h"
#include "view/live/piece_mesh.h"

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

TEST(Colours, PiecesAreDistinguishableWithAnyColourVision) {
  std::vector<Rgb8> colours;
  for (int i = 0; i < kPieceColours; ++i) colours.push_back(PieceColour(i));
  test::ExpectApart(colours, 20, "piece");
  // And from the tissues on their cut faces, which are seen side by side.
  for (const Rgb8& colour : colours) {
    test::ExpectApart({colour, CutColour(Tissue::kCortical)}, 10, "cortical face");
    test::ExpectApart({colour, CutColour(Tissue::kCancellous)}, 10, "cancellous face");
    // Muted: a chroma of at most 30, where the earlier colours had up to 90.
    const test::Rgb lab = test::ToLab(colour, test::kNormal);
    EXPECT_LT(std::hypot(lab[1], lab[2]), 30);
  }
}

// WCAG 2 requires a contrast of 4.5 for text, and of 3 for the edges of what carries meaning.
TEST(Colours, ThemesHaveContrast) {
  for (const Theme theme : {Theme::kLight, Theme::kDark}) {
    const SceneColours colours = SceneColoursOf(theme);
    EXPECT_GT(test::CalcContrast(colours.text, colours.ground), 7);
    // The ground is slightly translucent; text remains readable over the background and over bone.
    for (const Rgb8& behind : {colours.top, colours.bottom, kBoneColour}) {
      Rgb8 mixed{};
      for (std::size_t i = 0; i < 3; ++i) {
        mixed[i] = static_cast<std::uint8_t>(0.88 * colours.ground[i] + 0.12 * behind[i]);
      }
      EXPECT_GT(test::CalcContrast(colours.text, mixed), 4.5);
    }
  }
  // On the dark background, bone stands out more than on the light one.
  EXPECT_GT(test::CalcContrast(kBoneColour, SceneColoursOf(Theme::kDark).top), 7);
  EXPECT_GT(test::CalcContrast(kBoneColour, SceneColoursOf(Theme::kDark).bottom), 7);
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
