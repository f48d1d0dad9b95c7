// Tests that colours with a meaning are distinguishable with any colour vision. This is computed, not judged by eye.
#include <gtest/gtest.h>

#include <cmath>

#include "bone/material/region_table.h"
#include "view/live/flat_overlays.h"
#include "view/live/hud_draw.h"
#include "view/live/palette.h"
#include "view/live/piece_mesh.h"

namespace kerf {
namespace {

using Rgb = std::array<double, 3>;

Rgb ToLinear(const Rgb8& c) {
  Rgb linear{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double v = c[i] / 255.0;
    linear[i] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  return linear;
}

using Matrix = std::array<Rgb, 3>;
// From Machado, Oliveira and Fernandes 2009, severity 1, for linear RGB.
constexpr Matrix kNormal{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr Matrix kProtan{
    {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix kDeutan{
    {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
constexpr Matrix kTritan{
    {{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}};

// Returns the colour in CIE L*a*b*, D65.
Rgb ToLab(const Rgb8& colour, const Matrix& eye) {
  const Rgb c = ToLinear(colour);
  Rgb s{};
  for (std::size_t i = 0; i < 3; ++i) {
    s[i] = std::clamp(eye[i][0] * c[0] + eye[i][1] * c[1] + eye[i][2] * c[2], 0.0, 1.0);
  }
  const double x = (0.4124564 * s[0] + 0.3575761 * s[1] + 0.1804375 * s[2]) / 0.95047;
  const double y = 0.2126729 * s[0] + 0.7151522 * s[1] + 0.0721750 * s[2];
  const double z = (0.0193339 * s[0] + 0.1191920 * s[1] + 0.9503041 * s[2]) / 1.08883;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(y) - 16, 500 * (f(x) - f(y)), 200 * (f(y) - f(z))};
}

double Difference(const Rgb8& a, const Rgb8& b, const Matrix& eye) {
  const Rgb p = ToLab(a, eye);
  const Rgb q = ToLab(b, eye);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

void ExpectApart(const std::vector<Rgb8>& colours, double least, const std::string& what) {
  for (const Matrix& eye : {kNormal, kProtan, kDeutan, kTritan}) {
    for (std::size_t i = 0; i < colours.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_GT(Difference(colours[i], colours[j], eye), least) << what << " " << i << " " << j;
      }
    }
  }
}

// A difference of 2.3 is just noticeable side by side; ten times as much is distinguishable at a glance.
TEST(Colours, LevelsAreDistinguishableWithAnyColourVision) {
  ExpectApart({LevelColour(HudLevel::kGood), LevelColour(HudLevel::kWarn), LevelColour(HudLevel::kBad)}, 20, "level");
}

TEST(Colours, TissuesOfACutFaceAreDistinguishableWithAnyColourVision) {
  ExpectApart({CutColour(Tissue::kCortical), CutColour(Tissue::kCancellous), CutColour(Tissue::kCanal)}, 25, "tissue");
  ExpectApart({CutColour(Tissue::kTooth), CutColour(Tissue::kCancellous), CutColour(Tissue::kCanal)}, 25, "tissue");
  // Compares cut cortex with the outside of the bone and with a tooth: pale colours that are seen side by side.
  ExpectApart({CutColour(Tissue::kCortical), kBoneColour, CutColour(Tissue::kTooth)}, 10, "pale");
}

TEST(Colours, PiecesAreDistinguishableWithAnyColourVision) {
  std::vector<Rgb8> colours;
  for (int i = 0; i < kPieceColours; ++i) colours.push_back(PieceColour(i));
  ExpectApart(colours, 20, "piece");
  // And from the tissues on their cut faces, which are seen side by side.
  for (const Rgb8& colour : colours) {
    ExpectApart({colour, CutColour(Tissue::kCortical)}, 10, "cortical face");
    ExpectApart({colour, CutColour(Tissue::kCancellous)}, 10, "cancellous face");
    // Muted: a chroma of at most 30, where the earlier colours had up to 90.
    const Rgb lab = ToLab(colour, kNormal);
    EXPECT_LT(std::hypot(lab[1], lab[2]), 30);
  }
}

TEST(Colours, AlarmsAreDistinguishableWithAnyColourVision) {
  ExpectApart({AlarmColour(AlarmLevel::kNotice), AlarmColour(AlarmLevel::kWarning), AlarmColour(AlarmLevel::kDanger)},
              20, "alarm");
}

double Luminance(const Rgb8& c) {
  const Rgb l = ToLinear(c);
  return 0.2126 * l[0] + 0.7152 * l[1] + 0.0722 * l[2];
}
double Contrast(const Rgb8& a, const Rgb8& b) {
  const double la = Luminance(a) + 0.05;
  const double lb = Luminance(b) + 0.05;
  return std::max(la, lb) / std::min(la, lb);
}

// WCAG 2 requires a contrast of 4.5 for text, and of 3 for the edges of what carries meaning.
TEST(Colours, ThemesHaveContrast) {
  for (const Theme theme : {Theme::kLight, Theme::kDark}) {
    const SceneColours colours = ColoursOf(theme);
    EXPECT_GT(Contrast(colours.text, colours.ground), 7);
    // The ground is slightly translucent; text remains readable over the background and over bone.
    for (const Rgb8& behind : {colours.top, colours.bottom, kBoneColour}) {
      Rgb8 mixed{};
      for (std::size_t i = 0; i < 3; ++i) {
        mixed[i] = static_cast<std::uint8_t>(0.88 * colours.ground[i] + 0.12 * behind[i]);
      }
      EXPECT_GT(Contrast(colours.text, mixed), 4.5);
    }
  }
  // On the dark background, bone stands out more than on the light one.
  EXPECT_GT(Contrast(kBoneColour, ColoursOf(Theme::kDark).top), 7);
  EXPECT_GT(Contrast(kBoneColour, ColoursOf(Theme::kDark).bottom), 7);
}

// WCAG 2 requires a contrast of 4.5 for text.
TEST(Colours, TextHasContrastWithItsBackground) {
  const auto luminance = [](const Rgb8& c) {
    const Rgb l = ToLinear(c);
    return 0.2126 * l[0] + 0.7152 * l[1] + 0.0722 * l[2];
  };
  DrawList list;
  const HudState state;
  HudLayout layout = CalcHudLayout(1280, 720, state, {});
  DrawHud(state, layout, {}, {}, std::nullopt, list);
  ASSERT_GT(list.texts().size(), 10u);
  for (const FlatText& text : list.texts()) {
    EXPECT_GT((luminance({236, 239, 243}) + 0.05) / (luminance(text.colour.rgb) + 0.05), 4.5) << text.text;
  }
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
