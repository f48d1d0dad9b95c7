// Tests of sheets of pictures with coordinates, in which the positions of the coordinates are known beforehand.
#include "view/picture/panel_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "kerf/error.h"
#include "view/picture/mm_grid.h"

namespace kerf {
namespace {

using testing::ElementsAre;

// Returns a panel that is black except for one red pixel of 1 mm, which contains the coordinates (across, down).
Panel MakeDottedPanel(double left_mm, double right_mm, double top_mm, double bottom_mm, double across, double down) {
  Panel panel;
  panel.left_mm = left_mm, panel.right_mm = right_mm, panel.top_mm = top_mm, panel.bottom_mm = bottom_mm;
  const int width = static_cast<int>(std::abs(right_mm - left_mm));
  const int height = static_cast<int>(std::abs(bottom_mm - top_mm));
  panel.image = {width, height,
                 std::vector<Rgb8>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Rgb8{0, 0, 0})};
  const int column = static_cast<int>(std::abs(across - left_mm));
  const int row = static_cast<int>(std::abs(down - top_mm));
  panel.image
      .pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)] = {
      255, 0, 0};
  return panel;
}

// The centroid of the red pixels.
struct Spot {
  double column = 0, row = 0, count = 0;
};
Spot FindRed(const Image& image, const PanelPlace& place) {
  Spot spot;
  for (int row = static_cast<int>(place.top); row < place.bottom; ++row) {
    for (int column = static_cast<int>(place.left); column < place.right; ++column) {
      const Rgb8& p = image.At(column, row);
      const double red = std::max(0, p[0] - p[1]);
      if (red < 60) continue;
      spot.column += red * (column + 0.5), spot.row += red * (row + 0.5), spot.count += red;
    }
  }
  spot.column /= spot.count, spot.row /= spot.count;
  return spot;
}

TEST(MmGrid, NumbersLieOnLines) {
  const MmGrid grid = ChooseMmGrid(2.5, 13, 44);  // lines from 5.2 mm on, numbers from 17.6 mm on
  EXPECT_EQ(grid.line_mm, 10);
  EXPECT_EQ(grid.number_mm, 20);
  for (double scale = 0.01; scale < 200; scale *= 1.3) {
    const MmGrid g = ChooseMmGrid(scale, 13, 44);
    EXPECT_GE(g.line_mm * scale, 13 * (g.line_mm > 1 ? 1 : 0)) << scale;
    EXPECT_GE(g.number_mm * scale, 44) << scale;
    EXPECT_TRUE(IsMultiple(g.number_mm, g.line_mm)) << scale;
  }
  EXPECT_THAT(ListMultiples(20, -45, 41), ElementsAre(-40, -20, 0, 20, 40));
}

// A coordinate lies where the linear scale between the panel's edges puts it, for either direction of the axes.
TEST(PanelSheet, APixelLiesAtItsCoordinates) {
  SheetSpec spec;
  spec.width = 1200;
  spec.height = 900;
  spec.title = "sheet";
  spec.caption = "caption";
  spec.panels.push_back(MakeDottedPanel(-60, 60, 440, 340, 31, 373));      // z up
  spec.panels.push_back(MakeDottedPanel(-60, 60, -300, -200, -42, -238));  // y down
  spec.panels.push_back(MakeDottedPanel(10, 50, 20, 60, 30, 40));          // smaller, at the same scale
  std::vector<PanelPlace> places;
  const Image image = RenderSheet(spec, &places);
  ASSERT_EQ(places.size(), 3u);
  const double pixels_per_mm = (places[0].right - places[0].left) / 120;
  EXPECT_GT(pixels_per_mm, 2);
  // The sides are whole pixels, so the error is half a pixel in 40 mm.
  EXPECT_NEAR((places[2].right - places[2].left) / 40, pixels_per_mm, 0.5 / 40 * 2);
  struct Place {
    double across, down;
  };
  const Place middles[] = {{31.5, 372.5}, {-41.5, -237.5}, {30.5, 40.5}};  // centres of the 1 mm pixels
  for (std::size_t i = 0; i < 3; ++i) {
    const Panel& panel = spec.panels[i];
    const PanelPlace& place = places[i];
    EXPECT_GE(place.left, 0) << i;
    EXPECT_LE(place.right, spec.width) << i;
    EXPECT_LE(place.bottom, spec.height) << i;
    const Spot spot = FindRed(image, place);
    ASSERT_GT(spot.count, 0) << i;
    const double across_mm =
        panel.left_mm + (spot.column - place.left) / (place.right - place.left) * (panel.right_mm - panel.left_mm);
    const double down_mm =
        panel.top_mm + (spot.row - place.top) / (place.bottom - place.top) * (panel.bottom_mm - panel.top_mm);
    // Grid lines colour the pixels that they cover, so the centroid of 2 to 4 pixels moves by at most half a line.
    EXPECT_NEAR(across_mm, middles[i].across, 0.5) << i;
    EXPECT_NEAR(down_mm, middles[i].down, 0.5) << i;
  }
}

// All of the caption is in the picture: nothing touches its right edge, and the panels begin below the last line.
TEST(PanelSheet, WrapsALongCaption) {
  SheetSpec spec;
  spec.width = 600;
  spec.height = 500;
  spec.panels.push_back(MakeDottedPanel(-60, 60, 440, 340, 31, 373));
  std::vector<PanelPlace> one_line, wrapped;
  spec.caption = "caption";
  RenderSheet(spec, &one_line);
  for (int i = 0; i < 30; ++i) spec.caption += " caption";
  const Image image = RenderSheet(spec, &wrapped);
  EXPECT_GT(wrapped[0].top, one_line[0].top + 20);
  for (int row = 0; row < image.height; ++row) {
    for (int column = image.width - 4; column < image.width; ++column) {
      const Rgb8& pixel = image.At(column, row);
      ASSERT_GT(std::min({pixel[0], pixel[1], pixel[2]}), 250) << column << ' ' << row;
    }
  }
}

TEST(PanelSheet, AMarkLiesAtItsCoordinates) {
  SheetSpec spec;
  spec.width = spec.height = 600;
  spec.panels.push_back(MakeDottedPanel(-60, 60, 440, 340, -59, 439));
  spec.panels[0].image.pixels.assign(spec.panels[0].image.pixels.size(), {0, 0, 0});
  spec.panels[0].marks.push_back({-20, 380, {255, 0, 0}, ""});
  std::vector<PanelPlace> places;
  const Image image = RenderSheet(spec, &places);
  const Spot spot = FindRed(image, places[0]);
  EXPECT_NEAR(spot.column, places[0].left + 40.0 / 120 * (places[0].right - places[0].left), 1);
  EXPECT_NEAR(spot.row, places[0].top + 60.0 / 100 * (places[0].bottom - places[0].top), 1);
}

TEST(PanelSheet, RefusesInvalidSheets) {
  SheetSpec spec;
  EXPECT_THROW(RenderSheet(spec), Error);
  spec.panels.resize(1);
  EXPECT_THROW(RenderSheet(spec), Error);
  spec.panels.assign(60, MakeDottedPanel(0, 10, 0, 10, 5, 5));
  spec.width = spec.height = 300;
  EXPECT_THROW(RenderSheet(spec), Error);
}

}  // namespace
}  // namespace kerf
