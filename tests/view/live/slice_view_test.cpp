// Tests of slices of a plate whose CT number and outline are known at each point.
#include "view/live/slice_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <numbers>

#include "bone/grid/ct_modulus.h"
#include "kerf/error.h"
#include "support/chunks.h"
#include "view/live/surface_worker.h"

namespace kerf {
namespace {

// A plate of 16 x 10 x 10 mm with its top at z = 0, whose CT numbers grow by 100 HU per mm along x and 40 along z.
Bone MakeSlicedPlate() {
  Bone bone = test::MakePlate(0.25);
  SetHu(
      bone, [](const Vec3& p) { return 600 + 100 * p.x + 40 * p.z; }, 0.25);
  return bone;
}

SliceSpec MakeSpec(SliceKind kind, const Vec3& centre_W) {
  SliceSpec spec;
  spec.kind = kind;
  spec.centre_W = centre_W;
  spec.width_mm = 24;
  spec.width_px = 160;
  spec.height_px = 120;
  spec.window = {600, 2400};
  // The disc's plane is y = const.
  spec.X_WT = {glm::angleAxis(-0.5 * std::numbers::pi, Vec3{1, 0, 0}), centre_W};
  return spec;
}

const SliceKind kKinds[] = {SliceKind::kAxial, SliceKind::kCoronal, SliceKind::kSagittal, SliceKind::kBlade};

TEST(SliceView, PixelsAndPointsMapToEachOther) {
  for (const SliceKind kind : kKinds) {
    SliceSpec spec = MakeSpec(kind, {1, 2, -3});
    spec.offset_mm = 0.7;
    const SliceFrame frame = CalcSliceFrame(spec);
    for (const OverlayPoint& px : {OverlayPoint{0, 0}, OverlayPoint{160, 120}, OverlayPoint{13.5, 99.25}}) {
      const Vec3 p_W = frame.PointOf(px);
      EXPECT_NEAR(frame.DistanceOf(p_W), 0, 1e-12);
      const OverlayPoint back = frame.PixelOf(p_W + 5.0 * frame.X_WS.Vector({0, 0, 1}));  // projected along the normal
      EXPECT_NEAR(back.column, px.column, 1e-9);
      EXPECT_NEAR(back.row, px.row, 1e-9);
    }
    EXPECT_NEAR(glm::length(frame.PointOf({160, 60}) - frame.PointOf({0, 60})), 24, 1e-12);
    // Right-handed: the viewer's axis is right x up.
    EXPECT_NEAR(glm::length(glm::cross(frame.X_WS.Vector({1, 0, 0}), frame.X_WS.Vector({0, 1, 0})) -
                            frame.X_WS.Vector({0, 0, 1})),
                0, 1e-12);
  }
}

TEST(SliceView, SidesAreThoseOfRadiology) {
  const Bone bone = MakeSlicedPlate();
  const auto sides = [&](SliceKind kind) {
    const SliceImage s = CalcSlice(bone, MakeSpec(kind, {0, 0, -5}));
    return s.left_letter + s.right_letter + s.up_letter + s.down_letter;
  };
  EXPECT_EQ(sides(SliceKind::kAxial), "RLAP");
  EXPECT_EQ(sides(SliceKind::kCoronal), "RLSI");
  EXPECT_EQ(sides(SliceKind::kSagittal), "APSI");
  // Scrolling moves the plane to the head, the back and the left.
  for (const auto& [kind, axis] : {std::pair{SliceKind::kAxial, Vec3{0, 0, 1}},
                                   {SliceKind::kCoronal, Vec3{0, 1, 0}},
                                   {SliceKind::kSagittal, Vec3{1, 0, 0}}}) {
    SliceSpec spec = MakeSpec(kind, {1, 2, 3});
    spec.offset_mm = 4;
    EXPECT_NEAR(glm::length(CalcSliceFrame(spec).X_WS.p_AB - (Vec3{1, 2, 3} + 4.0 * axis)), 0, 1e-12);
  }
}

TEST(SliceView, GreyMatchesTheCtNumber) {
  const Bone bone = MakeSlicedPlate();
  for (const SliceKind kind : kKinds) {
    const SliceImage slice = CalcSlice(bone, MakeSpec(kind, {0, 0, -5}));
    EXPECT_TRUE(slice.has_ct);
    int count = 0;
    for (int row = 0; row < slice.image.height; ++row) {
      for (int column = 0; column < slice.image.width; ++column) {
        const Vec3 p = slice.frame.PointOf({column + 0.5, row + 0.5});
        // Away from the ends of the CT grid.
        if (std::abs(p.x) > 7.4 || std::abs(p.y) > 4.4 || p.z > -0.6 || p.z < -9.4) continue;
        const double hu = 600 + 100 * p.x + 40 * p.z;
        ASSERT_NEAR(slice.image.At(column, row)[0], 255 * ((hu - 600) / 2400 + 0.5), 0.6);  // rounding, and floats
        ++count;
      }
    }
    EXPECT_GT(count, 2000);
  }
}

// Distance of a point from the line, pixels.
double DistanceTo(const std::vector<OverlayPoint>& line, const OverlayPoint& p) {
  double least = 1e9;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double dx = line[i + 1].column - line[i].column;
    const double dy = line[i + 1].row - line[i].row;
    const double along =
        std::clamp(((p.column - line[i].column) * dx + (p.row - line[i].row) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    least = std::min(least, std::hypot(line[i].column + along * dx - p.column, line[i].row + along * dy - p.row));
  }
  return least;
}

TEST(SliceView, OutlineOfTheBoneIsThatOfThePlate) {
  const Bone bone = MakeSlicedPlate();
  for (const SliceKind kind : kKinds) {
    for (const int side : {160, 1000}) {
      SliceSpec spec = MakeSpec(kind, {0, 0, -5});
      spec.width_px = spec.height_px = side;
      const SliceImage slice = CalcSlice(bone, spec);
      ASSERT_EQ(slice.lines.size(), 1u);
      const std::vector<OverlayPoint>& line = slice.lines[0].points;
      // Closed, and all around the plate within a tenth of a voxel; at its edges the level set is rounded by about half
      // a voxel.
      EXPECT_NEAR(line.front().column, line.back().column, 1e-6);
      EXPECT_NEAR(line.front().row, line.back().row, 1e-6);
      double length = 0;
      for (std::size_t i = 0; i < line.size(); ++i) {
        const Vec3 p = slice.frame.PointOf(line[i]);
        const double outside = std::max({std::abs(p.x) - 8, std::abs(p.y) - 5, p.z, -10 - p.z});
        EXPECT_NEAR(outside, 0, 0.1);
        if (i > 0) length += glm::length(p - slice.frame.PointOf(line[i - 1]));
      }
      const double expected = kind == SliceKind::kSagittal ? 40 : 52;
      EXPECT_NEAR(length, expected, 1);
    }
  }
}

TEST(SliceView, BoneWithoutCtShowsItsTissues) {
  const Bone bone = test::MakePlate(0.25);  // 4 mm of cortical bone above cancellous bone
  const SliceImage slice = CalcSlice(bone, MakeSpec(SliceKind::kCoronal, {0, 0, -5}));
  EXPECT_FALSE(slice.has_ct);
  const auto grey = [&](const Vec3& p_W) {
    const OverlayPoint px = slice.frame.PixelOf(p_W);
    return slice.image.At(static_cast<int>(px.column), static_cast<int>(px.row))[0];
  };
  EXPECT_GT(grey({0, 0, -2}), grey({0, 0, -7}) + 40);
  EXPECT_GT(grey({0, 0, -7}), grey({0, 0, 2}) + 40);
  EXPECT_EQ(grey({0, 0, 2}), grey({10, 0, -5}));
}

// The corner points of the outline of a disc in a slice satisfy the disc's own equations.
TEST(SliceView, BladeIsShownWithAllThatItPassesInAStroke) {
  SliceScene scene;
  scene.tool = ReciprocatingBlade{.length_mm = 8, .width_mm = 4, .stroke_mm = 3};
  scene.X_WT = {{1, 0, 0, 0}, {0, 0, -5}};
  scene.displacement_mm = 1.25;
  const SliceFrame frame = CalcSliceFrame(MakeSpec(SliceKind::kAxial, {0, 0, -5}));
  const auto lines = CalcSliceLines(frame, scene);
  ASSERT_EQ(lines.size(), 2u);
  const auto range = [&](const SliceLine& line) {
    double least = 1e9, most = -1e9;
    for (const auto& point : line.points) {
      least = std::min(least, frame.PointOf(point).y);
      most = std::max(most, frame.PointOf(point).y);
    }
    return std::pair(least, most);
  };
  EXPECT_FALSE(lines[0].dashed);
  EXPECT_NEAR(range(lines[0]).first, -4 + 1.25, 1e-9);
  EXPECT_NEAR(range(lines[0]).second, 4 + 1.25, 1e-9);
  EXPECT_TRUE(lines[1].dashed);
  EXPECT_NEAR(range(lines[1]).first, -5.5, 1e-9);
  EXPECT_NEAR(range(lines[1]).second, 5.5, 1e-9);
}

TEST(SliceView, OutlineOfTheDiscIsThatOfTheCylinder) {
  DiscSaw saw;
  saw.diameter_mm = 12;
  saw.thickness_mm = 1.5;
  SliceScene scene;
  scene.tool = saw;
  for (const double tilt : {0.0, 0.02, 0.4, 1.2, 0.5 * std::numbers::pi}) {
    for (const double away : {0.0, 0.5, 3.0}) {
      scene.X_WT = {glm::angleAxis(tilt, glm::normalize(Vec3{1, 0.4, 0})), {0.5, 1, -5 + away}};
      const SliceFrame frame = CalcSliceFrame(MakeSpec(SliceKind::kAxial, {0, 0, -5}));
      const auto lines = CalcSliceLines(frame, scene);
      // Brute force: the area of the section, by pixels.
      double area = 0;
      constexpr double kStep = 0.02;
      for (double x = -8; x < 8; x += kStep) {
        for (double y = -8; y < 8; y += kStep) {
          const Vec3 p = scene.X_WT.InversePoint({x, y, -5});
          if (std::hypot(p.x, p.y) < 6 && std::abs(p.z) < 0.75) area += kStep * kStep;
        }
      }
      if (lines.empty()) {
        EXPECT_LT(area, 0.01);
        continue;
      }
      ASSERT_EQ(lines.size(), 1u);
      EXPECT_EQ(lines[0].kind, SliceLineKind::kTool);
      double shoelace = 0;
      const auto& points = lines[0].points;
      for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 a = frame.PointOf(points[i]);
        const Vec3 b = frame.PointOf(points[i + 1]);
        shoelace += 0.5 * (a.x * b.y - b.x * a.y);
        const Vec3 p = scene.X_WT.InversePoint(a);
        EXPECT_LT(std::hypot(p.x, p.y), 6 + 1e-9);
        EXPECT_LT(std::abs(p.z), 0.75 + 1e-9);
      }
      // Polygons of 96 corners, and the pixels along an outline of at most 40 mm.
      EXPECT_NEAR(std::abs(shoelace), area, 0.005 * area + 0.5 * kStep * 40) << tilt << " " << away;
    }
  }
}

TEST(SliceView, PlanesMarksAndCursorMeetTheSliceWhereTheyShould) {
  const SliceFrame frame = CalcSliceFrame(MakeSpec(SliceKind::kAxial, {0, 0, -5}));
  SliceScene scene;
  scene.planes = {{.name = "cut", .p_W = {2, 0, -5}, .normal_W = {1, 0, 0}, .width_mm = 8, .height_mm = 6},
                  {.name = "elsewhere", .p_W = {2, 0, -15}, .normal_W = {1, 0, 0}, .width_mm = 8, .height_mm = 6},
                  {.name = "parallel", .p_W = {2, 0, -6}, .normal_W = {0, 0, 1}}};
  scene.marks = {{.points_W = {{-3, 1, -9}, {-3, 1, -1}}, .radius_mm = 1.5, .label = "nerve"}};
  scene.cursor_W = Vec3{4, 4, -5};
  const auto lines = CalcSliceLines(frame, scene);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0].kind, SliceLineKind::kMark);
  for (const OverlayPoint& px : lines[0].points) {
    const Vec3 p = frame.PointOf(px);
    // On a polygon of 20 corners with this radius.
    EXPECT_LT(std::hypot(p.x + 3, p.y - 1), 1.5 + 1e-9);
    EXPECT_GT(std::hypot(p.x + 3, p.y - 1), 1.5 * std::cos(std::numbers::pi / 20) - 1e-9);
  }
  EXPECT_EQ(lines[1].name, "cut");
  ASSERT_EQ(lines[1].points.size(), 2u);
  for (const OverlayPoint& px : lines[1].points) {
    EXPECT_NEAR(frame.PointOf(px).x, 2, 1e-9);
    EXPECT_NEAR(std::abs(frame.PointOf(px).y), 4, 1e-9);
  }
  const OverlayPoint at = frame.PixelOf({4, 4, -5});
  for (std::size_t i = 2; i < 6; ++i) {
    EXPECT_EQ(lines[i].kind, SliceLineKind::kCursor);
    EXPECT_FALSE(lines[i].dashed);
    EXPECT_GT(DistanceTo(lines[i].points, at), 4);
    EXPECT_LT(DistanceTo(lines[i].points, at), 6);
  }
  scene.cursor_W = Vec3{4, 4, -8};
  EXPECT_TRUE(CalcSliceLines(frame, scene).back().dashed);
}

TEST(SliceView, PointsAreCirclesInAllSlices) {
  const SliceFrame frame = CalcSliceFrame(MakeSpec(SliceKind::kAxial, {0, 0, -5}));
  SliceScene scene;
  scene.points = {{.p_W = {3, 2, -5}, .label = "1"}, {.p_W = {-4, 1, -9}, .label = "2"}};
  const auto lines = CalcSliceLines(frame, scene);
  ASSERT_EQ(lines.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(lines[i].kind, SliceLineKind::kPoint);
    EXPECT_EQ(lines[i].name, scene.points[i].label);
    const OverlayPoint middle = frame.PixelOf(scene.points[i].p_W);
    for (const OverlayPoint& p : lines[i].points) {
      EXPECT_NEAR(std::hypot(p.column - middle.column, p.row - middle.row), 5, 1e-9);
    }
  }
  EXPECT_FALSE(lines[0].dashed);
  EXPECT_TRUE(lines[1].dashed) << "it lies 4 mm away from the plane";
}

TEST(SliceView, MeshIsCutIntoClosedLines) {
  const auto cube = test::MakeCube({1, 2, 3}, 4);
  const Pose X_WS{glm::angleAxis(0.3, glm::normalize(Vec3{0.2, 1, 0.1})), {1, 2, 3.3}};
  const auto lines = SliceMesh(*cube, X_WS);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(glm::length(lines[0].front() - lines[0].back()), 0, 1e-12);
  for (const Vec3& p : lines[0]) EXPECT_NEAR(X_WS.InversePoint(p).z, 0, 1e-9);
  EXPECT_TRUE(SliceMesh(*cube, {{1, 0, 0, 0}, {0, 0, 9}}).empty());
  EXPECT_TRUE(SliceMesh({}, X_WS).empty());
}

TEST(SliceView, StructuresAreShownWithinTheBoneOnly) {
  const Bone bone = test::MakePlate(0.25);
  InnerSurfaces inner;
  inner.canal_W = *test::MakeCube({0, 0, -5}, 3);  // within the plate
  inner.teeth_W = *test::MakeCube({4, 0, 0}, 3);   // half of it above the plate
  int nerve = 0, teeth = 0;
  const SliceImage slice = CalcSlice(bone, MakeSpec(SliceKind::kCoronal, {0, 0, -5}), &inner);
  for (const SliceLine& line : slice.lines) {
    nerve += line.kind == SliceLineKind::kNerve ? 1 : 0;
    if (line.kind != SliceLineKind::kTooth) continue;
    ++teeth;
    for (const OverlayPoint& px : line.points) EXPECT_LE(slice.frame.PointOf(px).z, 1e-9);
  }
  EXPECT_EQ(nerve, 1);
  EXPECT_GE(teeth, 1);
}

TEST(SliceView, SectionOfAPlaneLiesOnTheSurface) {
  const Bone bone = test::MakePlate(0.25);
  PlaneOverlay plane{.name = "cut", .p_W = {2, 0, -5}, .normal_W = {1, 0.3, 0.1}, .width_mm = 30, .height_mm = 30};
  const auto lines = CalcSectionLines(bone, plane, 0.25);
  ASSERT_EQ(lines.size(), 1u);
  const Vec3 n = glm::normalize(plane.normal_W);
  for (const Vec3& p : lines[0]) {
    EXPECT_NEAR(glm::dot(p - plane.p_W, n), 0, 1e-9);
    EXPECT_NEAR(bone.SignedDistance(p), 0, 0.1);
  }
  // A rectangle that ends within the bone gives an open line.
  plane.height_mm = 10;
  const auto open = CalcSectionLines(bone, plane, 0.25);
  ASSERT_FALSE(open.empty());
  EXPECT_GT(glm::length(open[0].front() - open[0].back()), 1);
  EXPECT_THROW(CalcSectionLines(bone, plane, 0), Error);
}

TEST(SliceView, LinesAreDrawnWithTheirWidth) {
  Image image{100, 60, std::vector<Rgb8>(6000, Rgb8{0, 0, 0})};
  SliceLine line;
  line.points = {{10, 30}, {90, 30}};
  line.colour = {200, 100, 50};
  line.width_points = 3;
  DrawSliceLines({line}, 2, image);
  double sum = 0;
  for (const Rgb8& c : image.pixels) sum += c[0] / 200.0;
  EXPECT_NEAR(sum, 80 * 6 + std::numbers::pi * 9, 6);  // with round ends
  EXPECT_EQ(image.At(50, 30), line.colour);
  EXPECT_EQ(image.At(50, 36), (Rgb8{0, 0, 0}));
}

TEST(SliceView, RefusesInvalidInput) {
  const Bone bone = MakeSlicedPlate();
  const SliceSpec good = MakeSpec(SliceKind::kBlade, {0, 0, -5});
  EXPECT_NO_THROW(CalcSlice(bone, good));
  const auto refused = [&](const auto& change) {
    SliceSpec spec = good;
    change(spec);
    EXPECT_THROW(CalcSlice(bone, spec), Error);
  };
  refused([](SliceSpec& s) { s.width_mm = 0; });
  refused([](SliceSpec& s) { s.width_px = 7; });
  refused([](SliceSpec& s) { s.height_px = 1025; });
  refused([](SliceSpec& s) { s.window.width_HU = 0; });
  refused([](SliceSpec& s) { s.centre_W.x = std::nan(""); });
  refused([](SliceSpec& s) { s.offset_mm = HUGE_VAL; });
  refused([](SliceSpec& s) { s.X_WT.R_AB = {2, 0, 0, 0}; });
}

TEST(SliceView, WorkerServesAllViewsWithTheLatestRequest) {
  const Bone bone = MakeSlicedPlate();
  SurfaceWorker worker(bone, 2);
  for (int i = 0; i < 5; ++i) {
    for (int view = 0; view < 4; ++view) {
      SliceSpec spec = MakeSpec(kKinds[view], {0, 0, -5});
      spec.offset_mm = 0.1 * i;
      worker.RequestSlice(view, spec);
    }
  }
  worker.RequestPlaneLines({{.p_W = {2, 0, -5}, .normal_W = {1, 0, 0}, .colour = {1, 2, 3}, .selected = true}});
  worker.WaitIdle();
  const auto images = worker.FetchSliceImages();
  ASSERT_EQ(images.size(), 4u);
  for (const auto& [view, slice] : images) {
    EXPECT_EQ(slice.spec.kind, kKinds[view]);
    EXPECT_NEAR(slice.spec.offset_mm, 0.4, 1e-12);
    EXPECT_EQ(slice.image.pixels, CalcSlice(bone, slice.spec).image.pixels);
  }
  EXPECT_TRUE(worker.FetchSliceImages().empty());
  const auto lines = worker.FetchPlaneLines();
  ASSERT_TRUE(lines);
  ASSERT_EQ(lines->size(), 1u);
  EXPECT_EQ((*lines)[0].colour, (Rgb8{1, 2, 3}));
  EXPECT_EQ((*lines)[0].lines_W.size(), 1u);
  EXPECT_THROW(worker.RequestSlice(0, {.width_mm = -1}), Error);
}

}  // namespace
}  // namespace kerf
