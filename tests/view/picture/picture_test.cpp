// Tests of pictures with known pixels: areas, positions and colours. No display is needed.
#include "view/picture/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "cut/tool/looks.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "view/picture/turn_arrow.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

constexpr Rgb8 kGreen{0, 158, 115};
constexpr Rgb8 kBlue{0, 114, 178};

class Picture : public ::testing::Test {
 protected:
  void SetUp() override {
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
  }
};

TriangleMesh MakeSphere(double radius_mm, const Vec3& centre, int rings = 60) {
  TriangleMesh mesh;
  const int sectors = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double polar = std::numbers::pi * i / rings;
      const double azimuth = 2 * std::numbers::pi * j / sectors;
      mesh.points.push_back(centre + radius_mm * Vec3{std::sin(polar) * std::cos(azimuth),
                                                      std::sin(polar) * std::sin(azimuth), std::cos(polar)});
    }
  }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * sectors + j % sectors); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      if (i + 1 < rings) mesh.triangles.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

// Returns the settings for a sphere alone, seen from the front.
PictureSpec MakeBareSpec(const TriangleMesh& mesh, const Rgb8& colour) {
  PictureSpec spec;
  spec.width = 640;
  spec.height = 480;
  spec.shapes.push_back({mesh, colour, {}, 1, false});
  spec.scale_bar = false;
  spec.orientation = Orientation::kNone;
  return spec;
}

// The pixels that `is_meant` accepts.
struct Patch {
  double count = 0;
  double column = 0, row = 0;  // centroid; a pixel's centre is its index plus 0.5
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
};
Patch FindPatch(const Image& image, const std::function<bool(const Rgb8&)>& is_meant) {
  Patch patch;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (!is_meant(image.At(column, row))) continue;
      patch.count += 1;
      patch.column += column + 0.5;
      patch.row += row + 0.5;
      patch.left = std::min(patch.left, column), patch.right = std::max(patch.right, column);
      patch.top = std::min(patch.top, row), patch.bottom = std::max(patch.bottom, row);
    }
  }
  if (patch.count > 0) patch.column /= patch.count, patch.row /= patch.count;
  return patch;
}

bool IsDrawn(const Rgb8& p) {
  return p[0] < 250 || p[1] < 250 || p[2] < 250;
}
// Returns true if the pixel is shaded with the hue of kGreen.
bool IsGreen(const Rgb8& p) {
  return p[1] > 40 && p[1] > 2 * p[0] && p[1] > p[2];
}
bool IsBlue(const Rgb8& p) {
  return p[2] > 60 && p[2] > 2 * p[0] && p[2] > p[1];
}

TEST_F(Picture, SphereCoversItsAreaAtTheStatedScale) {
  const Vec3 centre{5, -30, 12};
  PictureSpec spec = MakeBareSpec(MakeSphere(10, centre), kBoneColour);
  spec.camera = MakeCamera({0.3, -1, 0.4}, {0, 0, 1}, centre, 40);
  const double pixels_per_mm = 480.0 / 40;
  EXPECT_DOUBLE_EQ(CalcViewFrame(spec).pixels_per_mm, pixels_per_mm);
  const Patch patch = FindPatch(RenderPicture(spec), IsDrawn);
  // Half of the partly covered edge pixels may be missing or extra, which is 0.5 x 2 / 120 of the area.
  EXPECT_NEAR(patch.count, std::numbers::pi * std::pow(10 * pixels_per_mm, 2),
              0.01 * std::numbers::pi * std::pow(10 * pixels_per_mm, 2));
  EXPECT_NEAR(patch.column, 320, 0.5);
  EXPECT_NEAR(patch.row, 240, 0.5);
}

TEST_F(Picture, SurfaceHasItsColourWhereItFacesTheEye) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, {0, 0, 0}), kGreen);
  spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 40);
  for (const bool by_point : {false, true}) {
    if (by_point) spec.shapes[0].point_colours.assign(spec.shapes[0].mesh_W.points.size(), kGreen);
    const Rgb8 p = RenderPicture(spec).At(320, 240);
    // Light is white: shading scales all channels equally, and the highlight (at most 10 %) adds the same to each.
    EXPECT_NEAR(p[1] - p[0], 158, 50) << by_point;
    EXPECT_NEAR(p[2] - p[0], 115, 40) << by_point;
  }
}

TEST_F(Picture, PointsMatchTheViewFrameInEveryView) {
  const Vec3 marker{14, -9, 6};
  for (const View view :
       {View::kFront, View::kBack, View::kLeft, View::kRight, View::kTop, View::kBottom, View::kThreeQuarter}) {
    SCOPED_TRACE(ToString(view));
    PictureSpec spec = MakeBareSpec(MakeSphere(2, marker, 30), kGreen);
    spec.shapes.push_back({MakeSphere(1, -marker, 20), kBoneColour, {}, 1, false});
    spec.camera = MakeCamera(view);
    const ViewFrame frame = CalcViewFrame(spec);
    const Patch patch = FindPatch(RenderPicture(spec), IsGreen);
    const ViewFrame::Pixel expected = frame.Project(marker);
    EXPECT_NEAR(patch.column, expected.column, 1);
    EXPECT_NEAR(patch.row, expected.row, 1);
    // The marker is on the patient's left, in front and above.
    const double right = expected.column - 320;
    const double up = 240 - expected.row;
    EXPECT_TRUE(view != View::kFront || (right > 0 && up > 0));  // facing the patient, whose left is on the right
    EXPECT_TRUE(view != View::kBack || (right < 0 && up > 0));
    EXPECT_TRUE(view != View::kLeft || (right < 0 && up > 0));  // the face points to the picture's left
    EXPECT_TRUE(view != View::kRight || (right > 0 && up > 0));
    EXPECT_TRUE(view != View::kTop || (right < 0 && up > 0));  // the face points up
    EXPECT_TRUE(view != View::kBottom || (right > 0 && up > 0));
  }
}

TEST_F(Picture, ViewNamesRoundTrip) {
  for (const char* name : {"front", "back", "left", "right", "top", "bottom", "three-quarter"}) {
    ASSERT_TRUE(ViewFromString(name).has_value()) << name;
    EXPECT_STREQ(ToString(*ViewFromString(name)), name);
  }
  EXPECT_FALSE(ViewFromString("behind").has_value());
}

TEST_F(Picture, FittedShapesFillThePictureAndStayInside) {
  for (const Vec3& size : {Vec3{40, 10, 10}, Vec3{5, 5, 30}}) {
    TriangleMesh ellipsoid = MakeSphere(1, Vec3{0});
    for (Vec3& p : ellipsoid.points) p = p * size + Vec3{100, -50, 700};
    PictureSpec spec = MakeBareSpec(ellipsoid, kBoneColour);
    spec.camera = MakeCamera(View::kFront);
    const Patch patch = FindPatch(RenderPicture(spec), IsDrawn);
    EXPECT_GT(patch.left, 5);
    EXPECT_GT(patch.top, 5);
    EXPECT_LT(patch.right, 640 - 5);
    EXPECT_LT(patch.bottom, 480 - 5);
    // The bone reaches the margins (4 to 5 % per side) in one direction.
    EXPECT_TRUE(patch.right - patch.left > 0.88 * 640 || patch.bottom - patch.top > 0.88 * 480);
    EXPECT_NEAR(patch.column, 320, 2);
    EXPECT_NEAR(patch.row, 240, 2);
  }
}

TEST_F(Picture, ArrowReachesFromTailToTipAndItsHeadIsAtTheTip) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{0}), kBoneColour);
  spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 40);
  // The arrow is behind the sphere, but visible.
  spec.arrows.push_back({{-18, 15, -10}, {12, 15, 8}, {0, 60, 200}, ""});
  const ViewFrame frame = CalcViewFrame(spec);
  const Image image = RenderPicture(spec);
  const Patch patch = FindPatch(image, IsBlue);
  const ViewFrame::Pixel tail = frame.Project(spec.arrows[0].tail_W);
  const ViewFrame::Pixel tip = frame.Project(spec.arrows[0].tip_W);
  EXPECT_NEAR(patch.left, tail.column, 4);
  EXPECT_NEAR(patch.right, tip.column, 4);
  EXPECT_NEAR(patch.bottom, tail.row, 4);
  EXPECT_NEAR(patch.top, tip.row, 4);
  const auto count_near = [&](const ViewFrame::Pixel& end) {
    double count = 0;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        count += std::hypot(column - end.column, row - end.row) < 20 && IsBlue(image.At(column, row));
      }
    }
    return count;
  };
  EXPECT_GT(count_near(tip), 1.2 * count_near(tail));
}

TEST_F(Picture, TextLegendScaleBarAndCubeAreInTheirCorners) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{0}), kBoneColour);
  spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 100);  // the sphere is small and at the centre
  const auto corner_ink = [&](bool right, bool bottom) {
    const Image image = RenderPicture(spec);
    double count = 0;
    for (int row = bottom ? 340 : 0; row < (bottom ? 480 : 140); ++row) {
      for (int column = right ? 400 : 0; column < (right ? 640 : 240); ++column)
        count += IsDrawn(image.At(column, row));
    }
    return count;
  };
  for (const bool right : {false, true}) {
    for (const bool bottom : {false, true}) EXPECT_EQ(corner_ink(right, bottom), 0);
  }
  spec.title = "Title";
  EXPECT_GT(corner_ink(false, false), 100);
  spec.legend = {{"cortical", kGreen}};
  EXPECT_GT(corner_ink(true, false), 100);
  spec.scale_bar = true;
  EXPECT_GT(corner_ink(false, true), 100);
  spec.orientation = Orientation::kPatient;
  EXPECT_GT(corner_ink(true, true), 1000);
}

TEST_F(Picture, TargetIsInTheMiddleOfWhatIsBelowTheTitle) {
  // As high as the visible region, so that neither the title nor the lower edge may hide a part of it.
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{1, 2, 3}), kGreen);
  spec.camera = MakeCamera({0.2, -1, 0.3}, {0, 0, 1}, Vec3{1, 2, 3}, 21);
  spec.title = "Title";
  spec.caption = "and a caption below it,\nof two lines";
  const Patch patch = FindPatch(RenderPicture(spec), IsGreen);
  const ViewFrame frame = CalcViewFrame(spec);
  const double top = 480 - 21 * frame.pixels_per_mm;
  EXPECT_GT(top, 24 / 1.5 + 26 / 1.5 + 2 * 18 / 1.5);  // an edge and three lines, in pixels at a height of 480
  EXPECT_LT(top, 120);
  // A pixel of the outline may be too light to count.
  EXPECT_NEAR(patch.top, top + 0.5 * frame.pixels_per_mm, 2);
  EXPECT_NEAR(patch.bottom, 480 - 0.5 * frame.pixels_per_mm, 2);
}

TEST_F(Picture, LongTitlesAreBrokenIntoLinesBesideTheLegend) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{0}), kGreen);
  spec.legend = {{"cortical bone", kBlue}};
  const Image with_legend = RenderPicture(spec);
  for (int i = 0; i < 40; ++i) spec.title += "word ";  // 200 letters
  for (int i = 0; i < 40; ++i) spec.caption += "more ";
  for (const bool is_one_word : {false, true}) {
    if (is_one_word) spec.title = std::string(60, 'W');
    for (const bool has_target : {false, true}) {
      spec.camera = has_target ? MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 30) : MakeCamera(View::kThreeQuarter);
      const Image image = RenderPicture(spec);
      // The legend and the edges beside it are as without a title.
      const int left = FindPatch(with_legend, IsBlue).left - 10;
      for (int row = 0; row < 40; ++row) {
        for (int column = left; column < 640; ++column) {
          ASSERT_EQ(image.At(column, row), with_legend.At(column, row)) << column << " " << row;
        }
      }
      // All of the sphere is below the text.
      const Patch sphere = FindPatch(image, IsGreen);
      EXPECT_NEAR(sphere.bottom - sphere.top, sphere.right - sphere.left, 3);
      EXPECT_GT(sphere.count, 0.75 * (sphere.right - sphere.left) * (sphere.bottom - sphere.top));
    }
  }
}

TEST_F(Picture, ScaleStaysPositiveInSmallPicturesWithLongTitles) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{0}), kGreen);
  spec.title = spec.caption = "several words that do not fit in one line";
  spec.legend = {{"cortical bone", kBlue}};
  spec.scale_bar = true;
  for (const bool axes : {false, true}) {
    spec.axes = axes;
    for (const auto& [width, height] : {std::pair{64, 64}, std::pair{64, 480}, std::pair{640, 64}}) {
      spec.width = width;
      spec.height = height;
      spec.camera = MakeCamera(View::kFront);
      EXPECT_GT(CalcViewFrame(spec).pixels_per_mm, 0) << width << " " << height;
      RenderPicture(spec);
      if (axes) continue;  // they are for fitted shapes only
      spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 30);
      EXPECT_GT(CalcViewFrame(spec).pixels_per_mm, 0) << width << " " << height;
      RenderPicture(spec);
    }
  }
}

TEST_F(Picture, ScaleBarHasItsStatedLength) {
  PictureSpec spec = MakeBareSpec(MakeSphere(1, Vec3{0}), kBoneColour);
  spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 80);
  spec.scale_bar = true;
  // At 6 pixels per mm, the width of 640 pixels is 106.7 mm. The largest of 1, 2, 5, 10, ... mm below 16 % of that is
  // 10 mm, or 60 pixels.
  const Image image = RenderPicture(spec);
  int longest = 0;
  for (int row = 420; row < 480; ++row) {
    int run = 0;
    for (int column = 0; column < 320; ++column) {
      run = image.At(column, row)[0] < 60 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_NEAR(longest, 60, 1);
}

TEST_F(Picture, SameSpecGivesTheSamePixels) {
  PictureSpec spec = MakeBareSpec(MakeSphere(10, Vec3{0}), kBoneColour);
  spec.tools.push_back({});
  spec.title = "again";
  EXPECT_EQ(RenderPicture(spec).pixels, RenderPicture(spec).pixels);
}

TEST_F(Picture, PngContainsThePixels) {
  Image image{3, 2, {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 2, 3}, {4, 5, 6}, {7, 8, 9}}};
  const test::Folder folder;
  const std::string path = folder.file("pixels.png");
  WritePng(image, path);
  const vtkNew<vtkPNGReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  int size[3];
  reader->GetOutput()->GetDimensions(size);
  ASSERT_EQ(size[0], 3);
  ASSERT_EQ(size[1], 2);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(reader->GetOutput()->GetScalarComponentAsDouble(column, 1 - row, 0, c),
                  image.At(column, row)[static_cast<std::size_t>(c)]);
      }
    }
  }
}

TEST_F(Picture, BadSpecsAreRefusedWithOneSentence) {
  const TriangleMesh sphere = MakeSphere(1, Vec3{0}, 10);
  PictureSpec spec = MakeBareSpec({}, kBoneColour);
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }), HasSubstr("there is nothing to draw"));
  spec = MakeBareSpec(sphere, kBoneColour);
  spec.width = 10;
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }),
              HasSubstr("a picture of 10 x 480 pixels can't be drawn; each side must be 64"));
  spec = MakeBareSpec(sphere, kBoneColour);
  spec.camera = MakeCamera({0, 0, 1}, {0, 0, 2}, Vec3{0}, 10);
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }),
              HasSubstr("up direction must differ from its line of sight"));
  spec.camera = MakeCamera({0, -1, 0}, {0, 0, 1}, Vec3{0}, 0);
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }), HasSubstr("needs a view height above 0 mm, but got 0"));
  spec = MakeBareSpec(sphere, kBoneColour);
  spec.shapes[0].point_colours.resize(3);
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }), HasSubstr("3 colours for"));
  spec = MakeBareSpec(sphere, kBoneColour);
  spec.shapes[0].mesh_W.points[7].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(test::MessageOf([&] { RenderPicture(spec); }), HasSubstr("a point that is not finite"));
  spec = MakeBareSpec(sphere, kBoneColour);
  EXPECT_THAT(test::MessageOf([&] { WritePicture(spec, "/tmp/a.jpg"); }),
              HasSubstr("/tmp/a.jpg: the name of a picture must end in .png"));
}

TEST_F(Picture, MessageWithoutEglNamesThePackagesToInstall) {
  // This runs in a separate process, because EGL searches for drivers only once.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1);
        setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent", 1);
        std::fprintf(stderr, "%s", test::MessageOf([] {
                                     RenderPicture(MakeBareSpec(MakeSphere(1, Vec3{0}, 10), kBoneColour));
                                   }).c_str());
        std::exit(0);
      },
      ::testing::ExitedWithCode(0),
      "can't draw pictures on this machine: .*apt-get install libegl-mesa0 libgl1-mesa-dri");
}

TEST(SawMesh, IsClosedAndHasItsDiameterThicknessAndTeeth) {
  DiscSaw saw;
  saw.diameter_mm = 30;
  saw.thickness_mm = 0.6;
  saw.teeth = 36;
  const TriangleMesh mesh = MakeToolLooks(saw).whole;
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  EXPECT_GT(CalcEnclosedVolume(mesh), 0.6 * std::numbers::pi * 15 * 15 * 0.8);
  std::set<long> tips;
  double largest = 0;
  for (const Vec3& p : mesh.points) {
    const double radius = std::hypot(p.x, p.y);
    largest = std::max(largest, radius);
    if (radius > 15 - 1e-9) {
      EXPECT_NEAR(std::abs(p.z), 0.3, 1e-12);
      tips.insert(std::lround(std::atan2(p.y, p.x) * 1e6));
    }
  }
  EXPECT_NEAR(largest, 15, 1e-9);
  EXPECT_EQ(tips.size(), 36u);
}

// A point of a clockwise tool that is nearest to the eye moves to the left, if the handpiece is above; so the wide head
// of its arrow is on the left. Reversed, the arrow is the mirror image.
TEST_F(Picture, BentArrowShowsTheSenseOfATool) {
  PictureSpec spec = MakeBareSpec({}, kBoneColour);
  spec.camera = MakeCamera({0, -1, 0.5}, {0, 0, 1}, Vec3{0}, 20);
  for (const Tool& tool : {Tool{BallBurr{}}, Tool{TwistDrill{.diameter_mm = 4}}, Tool{DiscSaw{}}}) {
    const auto find = [&](double rpm) {
      spec.tools = {{tool, {}, 1, rpm}};
      return FindPatch(RenderPicture(spec),
                       [](const Rgb8& p) { return p[0] > 60 && p[0] > 2 * p[2] && p[0] > 1.5 * p[1]; });
    };
    EXPECT_EQ(find(0).count, 0);
    const Patch clockwise = find(-1000), reversed = find(1000);
    ASSERT_GT(clockwise.count, 300);
    EXPECT_NEAR(reversed.count, clockwise.count, 0.05 * clockwise.count);  // it is not lit from the middle
    EXPECT_NEAR(0.5 * (clockwise.left + clockwise.right), 320, 8);
    EXPECT_LT(clockwise.column, 319);
    EXPECT_GT(reversed.column, 321);
  }
  spec.tools = {{PiezoInsert{}, {}, 1, 1000}};
  EXPECT_EQ(FindPatch(RenderPicture(spec), [](const Rgb8& p) { return p[0] > 2 * p[2]; }).count, 0);
}

TEST(TurnArrow, IsClosedAndPointsOutwardsInEitherSense) {
  for (const double to_rad : {1.5, -1.5}) {
    const TriangleMesh mesh = MakeTurnArrowMesh(10, 0.5, 0, to_rad);
    // Pappus: the area of the section times the way of its centroid; of a cone, a third. The head spans 4 mm.
    const double volume_mm3 = std::numbers::pi * (0.25 * (10 * 1.5 - 4) + 2.25 * 4 / 3);
    EXPECT_NEAR(CalcEnclosedVolume(mesh), volume_mm3, 0.03 * volume_mm3);  // a section has 24 corners
    double furthest_rad = 0;
    for (const Vec3& p : mesh.points)
      furthest_rad = std::max(furthest_rad, std::copysign(1, to_rad) * std::atan2(p.y, p.x));
    EXPECT_NEAR(furthest_rad, 1.5, 1e-9);
  }
}

TEST(BallMesh, IsClosedAndHasItsDiameterAndAsManyEdgesAsFlutes) {
  BallBurr ball;
  ball.flutes = 6;
  const TriangleMesh mesh = MakeToolLooks(ball).whole;
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  // The grooves reduce the radius by less than an eighth. The shank's end lies beyond the ball.
  const double sphere = 4.0 / 3.0 * std::numbers::pi * 27;
  EXPECT_GT(CalcEnclosedVolume(mesh), sphere * 0.875 * 0.875 * 0.875);
  std::map<double, double> equator;  // radius by angle
  for (const Vec3& p : mesh.points) {
    if (std::abs(p.z) < 1e-9) equator[std::atan2(p.y, p.x)] = glm::length(p);
  }
  int edges = 0;  // steps up from a groove's floor
  double before = equator.rbegin()->second;
  for (const auto& [angle, radius] : equator) {
    EXPECT_LE(radius, 3 + 1e-9);
    edges += radius > before + 0.18 ? 1 : 0;  // half a groove's depth
    before = radius;
  }
  EXPECT_EQ(edges, 6);
}

TEST(CutCamera, LooksIntoTheBoneAlongThePlane) {
  const Vec3 normals[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3& normal : normals) {
    for (const Vec3& out : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, -1}}) {
      if (std::abs(glm::dot(normal, out)) > 0.5) continue;
      PictureSpec spec;
      spec.camera = MakeCutCamera(out, normal, {1, 2, 3}, 10);
      const ViewFrame frame = CalcViewFrame(spec);
      EXPECT_GT(glm::dot(frame.toward_eye_W, out), 0.9) << "from the side where the tool came from";
      EXPECT_NEAR(glm::dot(frame.toward_eye_W, normal), 0, 1e-12) << "the plane appears as a line";
    }
  }
}

}  // namespace
}  // namespace kerf
