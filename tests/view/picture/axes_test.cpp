// Tests of the axes around a picture: the lines are at round coordinates, and all parts are within the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "view/picture/mm_grid.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

// Returns two small triangles at opposite corners of a box, so that nothing hides the grid on the faces between them.
TriangleMesh MakeCorners(const Box3& box_W) {
  TriangleMesh mesh;
  for (const Vec3& corner : {box_W.lower, box_W.upper}) {
    const double s = corner == box_W.lower ? 1 : -1;
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), {corner, corner + s * Vec3(1, 0, 1), corner + s * Vec3(1, 1, 0)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

PictureSpec MakeSpec(View view) {
  PictureSpec spec;
  spec.width = 640;
  spec.height = 360;
  Box3 box_W;
  box_W.Include({-33, -120, 340});
  box_W.Include({47, -60, 395});
  spec.shapes.push_back({MakeCorners(box_W), kBoneColour, {}, 1, false});
  spec.camera = MakeCamera(view);
  spec.axes = true;
  return spec;
}

bool IsWhite(const Rgb8& p) {
  return p[0] > 250 && p[1] > 250 && p[2] > 250;
}

// Returns the centres of the runs of coloured pixels of one row within the box.
std::vector<double> FindLines(const Image& image, int row, double from, double to) {
  std::vector<double> middles;
  int begin = -1;
  for (int column = static_cast<int>(std::ceil(from)); column < to; ++column) {
    const bool drawn = !IsWhite(image.At(column, row));
    if (drawn && begin < 0) begin = column;
    if (!drawn && begin >= 0) middles.push_back(0.5 * (begin + column)), begin = -1;
  }
  return middles;
}

TEST(Axes, GridLinesLieAtRoundCoordinates) {
  for (const View view : {View::kFront, View::kBack}) {
    const PictureSpec spec = MakeSpec(view);
    const ViewFrame frame = CalcViewFrame(spec);
    const Image image = RenderPicture(spec);
    const Box3 box_W = CalcShapeBox(spec);
    const MmGrid grid = ChooseMmGrid(frame.pixels_per_mm, 8, 24);  // for a height of 360 pixels, half of 720
    const std::vector<double> expected_mm = ListMultiples(grid.line_mm, box_W.lower.x, box_W.upper.x);
    ASSERT_GT(expected_mm.size(), 5u);
    // The row is half-way between two horizontal lines and within the box's sides.
    const double z_mm = ListMultiples(grid.line_mm, box_W.lower.z + 15, box_W.upper.z).front() + 0.5 * grid.line_mm;
    const double end_a = frame.Project({box_W.lower.x, 0, z_mm}).column;
    const double end_b = frame.Project({box_W.upper.x, 0, z_mm}).column;
    const int row = static_cast<int>(frame.Project({0, 0, z_mm}).row);
    const auto lines = FindLines(image, row, std::min(end_a, end_b) + 4, std::max(end_a, end_b) - 4);
    std::vector<double> found_mm;
    const double sign = end_b > end_a ? 1 : -1;
    for (const double column : lines) found_mm.push_back(box_W.lower.x + sign * (column - end_a) / frame.pixels_per_mm);
    std::sort(found_mm.begin(), found_mm.end());
    ASSERT_EQ(found_mm.size(), expected_mm.size()) << ToString(view);
    for (std::size_t i = 0; i < found_mm.size(); ++i) {
      EXPECT_NEAR(found_mm[i], expected_mm[i], 1 / frame.pixels_per_mm) << ToString(view);  // one pixel
    }
  }
}

// Numbers and names are outside the box and within the picture, in views along an axis and in others.
TEST(Axes, NumbersAreInThePicture) {
  for (const View view : {View::kTop, View::kThreeQuarter}) {
    PictureSpec spec = MakeSpec(view);
    spec.width = 1280;  // letters large enough to have strokes that are dark throughout
    spec.height = 720;
    spec.scale_bar = false;
    spec.orientation = Orientation::kNone;
    const Image image = RenderPicture(spec);
    int dark = 0;
    bool edge_is_white = true;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        const bool edge = row < 2 || column < 2 || row >= image.height - 2 || column >= image.width - 2;
        const Rgb8& p = image.At(column, row);
        edge_is_white = edge_is_white && (!edge || IsWhite(p));
        dark += p[0] < 100 && p[1] < 100 && p[2] < 100;
      }
    }
    EXPECT_TRUE(edge_is_white) << ToString(view);
    EXPECT_GT(dark, 1000) << ToString(view);  // only the letters and the axis lines are dark
  }
}

}  // namespace
}  // namespace kerf
