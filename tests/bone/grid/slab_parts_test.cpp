// The three parts of a slab cut.
#include "bone/grid/slab_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::MakeBox;
using testing::HasSubstr;

CutPlane PlaneOf(const Vec3& p_W, const Vec3& normal) {
  return {p_W, glm::normalize(normal)};
}

double Along(const CutPlane& plane, const Vec3& p_W) {
  return glm::dot(plane.normal_W, p_W - plane.p_W);
}

double SumOfVolumes(const SlabParts& parts) {
  return parts.left.CalcVolume() + parts.slice.CalcVolume() + parts.right.CalcVolume();
}

/// The flat face of a surface: its triangles whose normal is within one degree of `normal`, except near the rim.
struct Face {
  double area_mm2 = 0;
  double mean_mm = 0;  // distance from the plane along its normal, weighted by area
  double lower_mm = std::numeric_limits<double>::infinity();
  double upper_mm = -std::numeric_limits<double>::infinity();
};

Face MeasureFace(const TriangleMesh& mesh, const CutPlane& plane, const Vec3& normal, const Bone& whole) {
  const double rim_mm = -2 * whole.voxel_mm();  // the surface's points are averages over a voxel

  Face face;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.points[t[0]];
    const Vec3 cross = glm::cross(mesh.points[t[1]] - a, mesh.points[t[2]] - a);
    const double area = 0.5 * glm::length(cross);
    if (area == 0 || glm::dot(cross, normal) < 2 * area * std::cos(std::numbers::pi / 180)) continue;
    if (std::any_of(t.begin(), t.end(), [&](auto id) { return whole.SignedDistance(mesh.points[id]) > rim_mm; }))
      continue;
    face.area_mm2 += area;
    for (const std::uint32_t id : t) {
      const double s = Along(plane, mesh.points[id]);
      face.mean_mm += area * s / 3;
      face.lower_mm = std::min(face.lower_mm, s);
      face.upper_mm = std::max(face.upper_mm, s);
    }
  }
  face.mean_mm /= face.area_mm2;
  return face;
}

void ExpectClosedAndOutward(const Bone& part, const TriangleMesh& mesh, const char* name) {
  EXPECT_EQ(CountOpenEdges(mesh), 0u) << name;
  const double volume = part.CalcVolume();
  // The mesh's points are averages over a cell, which bevels edges by up to a voxel; a thin slice is nearly all edge.
  EXPECT_GT(CalcEnclosedVolume(mesh), 0.97 * volume) << name;
  EXPECT_LT(CalcEnclosedVolume(mesh), 1.001 * volume) << name;
}

// These planes cut only the four long faces of a 30 x 12 x 10 mm block, so the slice is a prism of volume t * 120 /
// |n_x|.
const Vec3 kNormals[] = {{1, 0, 0}, {1, 0.2, 0.1}, {1, 1, 1}, {-1, 0.5, 0.8}, {-1, 0, 1}};
const Vec3 kPoint{0.317, 0.211, -0.093};

class SlabPartsOfABlock : public testing::TestWithParam<double> {
 protected:
  double h() const { return GetParam(); }
  Bone MakeWhole() const {
    Pose X_WB;
    X_WB.p_AB = {0.013, -0.021, 0.057};
    return MakeBox(X_WB, {30, 12, 10}, h());
  }
};

TEST_P(SlabPartsOfABlock, VolumesSumToTheWholeAndSliceVolumeIsAreaTimesThickness) {
  const Bone block = MakeWhole();
  const double whole = block.CalcVolume();
  for (const Vec3& normal : kNormals) {
    for (const double t : {0.25, 0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << "normal " << normal.x << " " << normal.y << " " << normal.z << ", t " << t);
      const CutPlane plane = PlaneOf(kPoint, normal);
      const SlabParts parts = MakeSlabParts(block, {plane, t, false, {}});
      EXPECT_NEAR(SumOfVolumes(parts) / whole, 1, 1e-3);
      // Where the angle is sharp (55 degrees here), an edge loses up to about h^2 / 2 of its cross-section, with h the
      // voxel size. The slice has two rims, each at most twice the block's girth of 44 mm, and a length t / |n_x| of
      // each of the block's four edges.
      const double f = parts.slice.voxel_mm();
      const double stretch = 1 / std::abs(plane.normal_W.x);
      const double lost = 0.5 * f * f * 2 * 44 * stretch + 0.5 * h() * h() * 4 * t * stretch;
      const double prism = t * 120 * stretch;
      EXPECT_GT(parts.slice.CalcVolume(), prism - lost);
      EXPECT_LT(parts.slice.CalcVolume(), prism * (1 + 1e-6));
    }
  }
}

TEST_P(SlabPartsOfABlock, FacesLieAtHalfTheThicknessAndPartsAreClosed) {
  const Bone block = MakeWhole();
  for (const Vec3& normal : {kNormals[0], kNormals[2], kNormals[3]}) {
    for (const double t : {0.25, 0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << "normal " << normal.x << " " << normal.y << " " << normal.z << ", t " << t);
      const CutPlane plane = PlaneOf(kPoint, normal);
      const SlabParts parts = MakeSlabParts(block, {plane, t, false, {}});
      const TriangleMesh& slice = parts.slice_surface_W;
      const TriangleMesh fine = ExtractSurface(parts.slice);
      const TriangleMesh left = ExtractSurface(parts.left);
      const TriangleMesh right = ExtractSurface(parts.right);
      const Face faces[] = {
          MeasureFace(slice, plane, plane.normal_W, block), MeasureFace(slice, plane, -plane.normal_W, block),
          MeasureFace(left, plane, plane.normal_W, block),  MeasureFace(right, plane, -plane.normal_W, block),
          MeasureFace(fine, plane, plane.normal_W, block),  MeasureFace(fine, plane, -plane.normal_W, block)};
      const double at[] = {0.5 * t, -0.5 * t, -0.5 * t, 0.5 * t, 0.5 * t, -0.5 * t};
      for (int i = 0; i < 6; ++i) {
        // Only float rounding, far below the required 0.01 mm.
        EXPECT_NEAR(faces[i].mean_mm, at[i], 2e-6) << i;
        EXPECT_NEAR(faces[i].lower_mm, at[i], 5e-6) << i;
        EXPECT_NEAR(faces[i].upper_mm, at[i], 5e-6) << i;
        EXPECT_GT(faces[i].area_mm2, 0.8 * 120 / std::abs(plane.normal_W.x)) << i;
      }
      ExpectClosedAndOutward(parts.left, ExtractSurface(parts.left), "left");
      ExpectClosedAndOutward(parts.slice, slice, "slice");
      EXPECT_EQ(CountOpenEdges(fine), 0u);
      ExpectClosedAndOutward(parts.right, ExtractSurface(parts.right), "right");
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Voxels, SlabPartsOfABlock, testing::Values(0.2, 0.125));

TEST(SlabParts, ThinnestSliceHasTheRequestedThickness) {
  const Bone block = MakeBox(Pose{}, {6, 2, 2}, 0.2);
  const CutPlane plane = PlaneOf({0.1, 0, 0.03}, {1, 0.4, -0.3});
  const SlabParts parts = MakeSlabParts(block, {plane, 0.02, false, {}});
  const TriangleMesh& mesh = parts.slice_surface_W;
  // The mesh's points are averages over half a voxel, 0.1 mm, so the 8 mm rim of a section of about 4 mm2 shrinks by up
  // to 0.04 mm.
  EXPECT_NEAR(CalcEnclosedVolume(mesh) / parts.slice.CalcVolume(), 1, 0.08);
  EXPECT_LT(mesh.triangles.size(), 4000u);  // does not depend on the thickness
  EXPECT_NEAR(MeasureFace(mesh, plane, plane.normal_W, block).mean_mm, 0.01, 1e-5);
  EXPECT_NEAR(MeasureFace(mesh, plane, -plane.normal_W, block).mean_mm, -0.01, 1e-5);
  // The block's own four edges have lost up to h^2 / 2 each, with h the voxel size.
  EXPECT_NEAR(parts.slice.CalcVolume(), 0.02 * 4 / plane.normal_W.x, 0.02 * 4 * 0.02 / plane.normal_W.x);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
}

TEST(SlabParts, ReversingTheNormalSwapsLeftAndRightBitForBit) {
  const Bone bone = MakeMandible({.voxel_mm = 0.5}, DefaultMandibleTable(), {});
  for (const bool everywhere : {false, true}) {
    CutPlane plane = PlaneOf({22, 31, 2}, {0.3, 1, -0.2});
    const SlabParts there = MakeSlabParts(bone, {plane, 0.5, everywhere, {}});
    plane.normal_W = -plane.normal_W;
    const SlabParts back = MakeSlabParts(bone, {plane, 0.5, everywhere, {}});
    EXPECT_EQ(there.left.CalcHash(), back.right.CalcHash());
    EXPECT_EQ(there.right.CalcHash(), back.left.CalcHash());
    EXPECT_EQ(there.slice.CalcHash(), back.slice.CalcHash());
    EXPECT_NE(there.left.CalcHash(), there.right.CalcHash());
  }
}

TEST(SlabParts, PartsAreDisjointAndInsideTheWhole) {
  const Bone block = MakeBox(Pose{}, {14, 6, 5}, 0.2);
  const CutPlane plane = PlaneOf({0.3, 0.1, -0.2}, {1, 0.6, 0.3});
  const double t = 0.5;
  const SlabParts parts = MakeSlabParts(block, {plane, t, false, {}});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> fraction(-0.5, 0.5);
  int inside[3] = {0, 0, 0};
  int lost = 0;
  for (int n = 0; n < 20000; ++n) {
    const double reach = n % 2 ? 14.4 : 2;  // half the points near the plane
    const Vec3 p(reach * fraction(random), 6.4 * fraction(random), 5.4 * fraction(random));
    const double s = Along(plane, p);
    const double whole = block.SignedDistance(p);
    const bool is[3] = {parts.left.SignedDistance(p) < 0, parts.slice.SignedDistance(p) < 0,
                        parts.right.SignedDistance(p) < 0};
    // Between voxels the interpolated max() is at least each of its terms, so a part never extends beyond its planes.
    // 1e-6 allows for float rounding.
    if (is[0]) {
      EXPECT_LT(s, -0.5 * t + 1e-6);
    }
    if (is[1]) {
      EXPECT_LT(std::abs(s), 0.5 * t + 1e-6);
    }
    if (is[2]) {
      EXPECT_GT(s, 0.5 * t - 1e-6);
    }
    EXPECT_LE(is[0] + is[1] + is[2], 1);
    for (int i = 0; i < 3; ++i) inside[i] += is[i];
    if (is[0] || is[1] || is[2]) {
      EXPECT_LT(whole, 0.01);
    }
    // A point more than a voxel's diagonal inside the whole and away from the planes must be in one of the parts.
    if (whole < -0.35 && std::abs(std::abs(s) - 0.5 * t) > 0.1) lost += !(is[0] || is[1] || is[2]);
  }
  EXPECT_EQ(lost, 0);
  for (const int count : inside) EXPECT_GT(count, 500);
}

TEST(SlabParts, PartsKeepRegionsMaterialsAndNotes) {
  BlockParams params;
  params.size_mm = {20, 12, 10};
  params.layers = {{2, 24}, {3, 32}, {5, 6}};
  Bone block = MakeBlock(params, DefaultMandibleTable());
  block.set_note("patient", "anonymous");
  const CutPlane plane = PlaneOf({0.5, 0.2, -5}, {1, 0.3, 0.2});
  const SlabParts parts = MakeSlabParts(block, {plane, 0.5, false, {}});
  const auto whole = block.CalcRegionVolumes();
  ASSERT_EQ(whole.size(), 3u);
  double slice_layers = 0;
  for (const auto& [id, mm3] : whole) {
    double sum = 0;
    for (const Bone* part : {&parts.left, &parts.slice, &parts.right}) {
      EXPECT_TRUE(part->materials().Contains(id));
      EXPECT_EQ(part->notes().at("patient"), "anonymous");
      EXPECT_EQ(part->CalcRegionVolumes().count(0), 0u);
      sum += part->CalcRegionVolumes().at(id);
    }
    // Where layers meet, cells of the slice may change region, and rims lose a little volume.
    EXPECT_NEAR(sum / mm3, 1, 4e-3) << id;
    slice_layers += parts.slice.CalcRegionVolumes().at(id);
  }
  EXPECT_NEAR(slice_layers, parts.slice.CalcVolume(), 1e-9 * slice_layers);
}

// A coronal plane behind the chin cuts both sides of a mandible.
class SlabPartsOfAMandible : public testing::Test {
 protected:
  static const Bone& Mandible() {
    static const Bone bone = MakeMandible({.voxel_mm = 0.4}, DefaultMandibleTable(), {});
    return bone;
  }
  const CutPlane plane_ = PlaneOf({24, 30, 0}, {0, 1, 0});  // left side of the patient's mandibular body
};

TEST_F(SlabPartsOfAMandible, OnlyTheSideNearThePlanesPointIsCut) {
  const SlabParts parts = MakeSlabParts(Mandible(), {plane_, 0.5, false, {}});
  EXPECT_EQ(parts.places, 2u);
  EXPECT_EQ(parts.cut_places, 1u);
  EXPECT_NEAR(SumOfVolumes(parts) / Mandible().CalcVolume(), 1, 1e-3);
  EXPECT_GT(parts.slice.CalcBounds().lower.x, 5);
  EXPECT_EQ(SplitPieces(parts.left).pieces.size(), 1u);
  EXPECT_EQ(SplitPieces(parts.right).pieces.size(), 1u);
  // The chin keeps the patient's right side, back to its condyle; the other segment is only the patient's left ramus.
  const Box3 whole = Mandible().CalcBounds();
  EXPECT_NEAR(parts.left.CalcBounds().lower.x, whole.lower.x, 1e-9);
  EXPECT_NEAR(parts.left.CalcBounds().upper.y, whole.upper.y, 1e-3);  // because the model is symmetric
  EXPECT_GT(parts.right.CalcBounds().lower.x, 5);
  EXPECT_GT(parts.right.CalcBounds().lower.y, 30.25 - 1e-6);
  // Away from the cut, the part is bit-identical to the bone.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(whole.lower.x, 0), y(26, 34), z(whole.lower.z, whole.upper.z);
  int inside = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vec3 p(x(random), y(random), z(random));
    EXPECT_EQ(parts.left.SignedDistance(p), Mandible().SignedDistance(p));
    inside += Mandible().SignedDistance(p) < 0;
  }
  EXPECT_GT(inside, 200);
  ExpectClosedAndOutward(parts.left, ExtractSurface(parts.left), "left");
  ExpectClosedAndOutward(parts.right, ExtractSurface(parts.right), "right");
  ExpectClosedAndOutward(parts.slice, parts.slice_surface_W, "slice");
}

TEST_F(SlabPartsOfAMandible, EverywhereCutsBothSides) {
  const SlabParts near = MakeSlabParts(Mandible(), {plane_, 0.5, false, {}});
  const SlabParts both = MakeSlabParts(Mandible(), {plane_, 0.5, true, {}});
  EXPECT_EQ(both.cut_places, 2u);
  EXPECT_NEAR(SumOfVolumes(both) / Mandible().CalcVolume(), 1, 1e-3);
  EXPECT_EQ(SplitPieces(both.right, 100).pieces.size(), 2u);
  // The model is mirror-symmetric, but its voxels are not quite.
  EXPECT_NEAR(both.slice.CalcVolume(), 2 * near.slice.CalcVolume(), 0.01 * near.slice.CalcVolume());
  EXPECT_NEAR(near.left.CalcVolume(), both.left.CalcVolume() + both.slice.CalcVolume() / 2 + near.right.CalcVolume(),
              1e-3 * near.left.CalcVolume());
}

TEST_F(SlabPartsOfAMandible, NearPointSelectsThePlace) {
  const SlabParts parts = MakeSlabParts(Mandible(), {plane_, 0.5, false, Vec3(-24, 30, 0)});
  EXPECT_EQ(parts.cut_places, 1u);
  EXPECT_LT(parts.slice.CalcBounds().upper.x, -5);
  EXPECT_LT(parts.right.CalcBounds().upper.x, -5);
}

TEST_F(SlabPartsOfAMandible, EverywhereHasNoEffectIfThePlaneCrossesOneSideOnly) {
  const CutPlane plane = PlaneOf({24, 30, 0}, {1, 0.8, 0});
  const SlabParts near = MakeSlabParts(Mandible(), {plane, 0.5, false, {}});
  const SlabParts all = MakeSlabParts(Mandible(), {plane, 0.5, true, {}});
  EXPECT_EQ(near.places, 1u);
  EXPECT_EQ(near.left.CalcHash(), all.left.CalcHash());
  EXPECT_EQ(near.slice.CalcHash(), all.slice.CalcHash());
  EXPECT_EQ(near.right.CalcHash(), all.right.CalcHash());
}

/// Makes a ring in the xy plane with a separate ball next to it.
Bone MakeRingAndBall() {
  SolidField field;
  field.value = [](const Vec3& p) {
    const double ring = std::hypot(std::hypot(p.x, p.y) - 8, p.z) - 1.5;
    return std::min(ring, glm::length(p - Vec3(1, 14, 0)) - 3);
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{Vec3(-12, -12, -4), Vec3(12, 18, 4)}, {0.2, 0.2, {}}, test::OneRegionTable());
}

TEST(SlabParts, RingIsCutInBothPlacesBecauseOneDoesNotPartIt) {
  const Bone bone = MakeRingAndBall();
  const SlabParts parts = MakeSlabParts(bone, {PlaneOf({0, -8, 0}, {1, 0, 0}), 0.5, false, {}});
  EXPECT_EQ(parts.places, 3u);
  EXPECT_EQ(parts.cut_places, 2u);
  EXPECT_NEAR(parts.distance_mm, 0, 0.2);
  // The ball, most of it on the right, stays whole and belongs to the right part.
  EXPECT_EQ(SplitPieces(parts.left).pieces.size(), 1u);
  EXPECT_EQ(SplitPieces(parts.right).pieces.size(), 2u);
  EXPECT_LT(parts.left.CalcBounds().upper.y, 10);
  EXPECT_LT(parts.right.SignedDistance({-1.5, 14, 0}), 0);
  EXPECT_NEAR(SumOfVolumes(parts) / bone.CalcVolume(), 1, 1e-3);
  EXPECT_EQ(SplitPieces(parts.slice).pieces.size(), 2u);
}

TEST(SlabParts, BallBesideTheRingIsCutAloneAndTheRingStaysWhole) {
  const Bone bone = MakeRingAndBall();
  // The slice passes through the middle of the ball, or leaves a cap of 0.35 mm on one side.
  for (const double x : {1.0, -1.4}) {
    const SlabParts ball = MakeSlabParts(bone, {PlaneOf({x, 14, 0}, {1, 0, 0}), 0.5, false, {}});
    EXPECT_EQ(ball.cut_places, 1u);
    EXPECT_GT(ball.slice.CalcBounds().lower.y, 10);
    EXPECT_EQ(SplitPieces(ball.left).pieces.size() + SplitPieces(ball.right).pieces.size(), 3u);
    EXPECT_NEAR(SumOfVolumes(ball) / bone.CalcVolume(), 1, 1e-3);
  }
}

TEST(SlabParts, SurfaceRoughnessIsNotChosenAsThePlace) {
  // A bar with a bump on its side, next to the plane's point, that barely reaches through the slice.
  SolidField field;
  field.value = [](const Vec3& p) {
    const double bar = test::BoxDistance(p, {10, 3, 3});
    const double arm = test::BoxDistance(p - Vec3(-4, 6, 0), {1, 4, 1});
    const double finger = test::BoxDistance(p - Vec3(-2.3, 9, 0), {2.8, 1, 1});  // extends to x = 0.5
    return std::min({bar, arm, finger});
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone bone = MakeBone(field, Box3{Vec3(-12, -5, -5), Vec3(12, 12, 5)}, {0.2, 0.2, {}}, test::OneRegionTable());
  const SlabParts bar = MakeSlabParts(bone, {PlaneOf({0, 7, 0}, {1, 0, 0}), 0.5, false, {}});
  EXPECT_LT(bar.slice.CalcBounds().upper.y, 3.1);  // although the finger is nearer to the point
  EXPECT_NEAR(bar.left.CalcBounds().upper.x, 0.5, 1e-3);
  const SlabParts tip = MakeSlabParts(bone, {PlaneOf({0, 9, 0}, {1, 0, 0}), 0.5, false, {}});
  EXPECT_GT(tip.slice.CalcBounds().lower.y, 7.9);  // the point lies in the finger
}

TEST(SlabParts, BadCutsAreRefusedInOneSentence) {
  const Bone block = MakeBox(Pose{}, {10, 6, 6}, 0.2);
  const auto message = [&block](const Vec3& p_W, const Vec3& normal, double t) -> std::string {
    return test::MessageOf([&] { MakeSlabParts(block, {{p_W, normal}, t, false, {}}); });
  };
  const Vec3 x(1, 0, 0);
  EXPECT_EQ(message({0, 0, 0}, x, 0.01), "slice: thickness_mm = 0.01 is below 0.02; valid range 0.02 to 50 mm");
  EXPECT_THAT(message({0, 0, 0}, x, std::nan("")), HasSubstr("valid range 0.02 to 50 mm"));
  EXPECT_EQ(message({0, 0, 0}, {1, 1, 0}, 0.25), "the plane must have a normal of unit length");
  EXPECT_EQ(message({0, 0, std::nan("")}, x, 0.25),
            "the plane's point (0, 0, nan) lies outside the world; coordinates go from -1000000 to 1000000 mm");
  EXPECT_EQ(message({0, -1e17, 0}, x, 0.25),
            "the plane's point (0, -1e+17, 0) lies outside the world; coordinates go from -1000000 to 1000000 mm");
  EXPECT_EQ(
      test::MessageOf([&] {
        MakeSlabParts(block, {{{0, 0, 0}, x}, 0.25, false, Vec3(0, 0, 2e6)});
      }),
      "the point at which to cut (0, 0, 2e+06) lies outside the world; coordinates go from -1000000 to 1000000 mm");
  EXPECT_THAT(message({8, 0, 0}, x, 0.25),
              HasSubstr("the plane misses the bone: along its normal the bone lies -12.8"));
  EXPECT_THAT(message({5, 0, 0}, x, 0.5), HasSubstr("the plane leaves no bone on one of its sides"));
  EXPECT_THAT(message({-5, 0, 0}, x, 0.5), HasSubstr("the plane leaves no bone on one of its sides"));
  EXPECT_EQ(message({0, 0, 0}, x, 1), "");
  const Bone two = MakeBone(
      [] {
        SolidField field;
        field.value = [](const Vec3& p) { return std::min(glm::length(p), glm::length(p - Vec3(8, 0, 0))) - 2; };
        field.classify = ClassifyByDistance(field.value);
        field.region = [](const Vec3&) { return 24; };
        return field;
      }(),
      Box3{Vec3(-4), Vec3(12, 4, 4)}, {0.2, 0.2, {}}, test::OneRegionTable());
  for (const bool everywhere : {false, true}) {
    EXPECT_THAT(
        test::MessageOf([&] {
          MakeSlabParts(two, {{{4, 0, 0}, x}, 0.25, everywhere, {}});
        }),
        HasSubstr(everywhere ? "the plane leaves no bone for the slice"
                             : "the plane divides no piece of the bone: it passes between separate pieces, or only "
                               "grazes a face; move it into the bone"));
  }
}

TEST(SlabParts, PlaneThatGrazesAFaceIsReported) {
  SolidField field;
  field.value = [](const Vec3& p) {
    return std::min(test::BoxDistance(p, {4, 3, 3}), test::BoxDistance(p - Vec3(12, 0, 0), {4, 3, 3}));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone two = MakeBone(field, Box3{Vec3(-6, -5, -5), Vec3(18, 5, 5)}, {0.2, 0.2, {}}, test::OneRegionTable());
  for (const double x : {4.0, 8.0}) {
    EXPECT_EQ(test::MessageOf([&] {
                MakeSlabParts(two, {{{x, 0, 0}, {1, 0, 0}}, 0.25, false, {}});
              }),
              "the plane divides no piece of the bone: it passes between separate pieces, or only grazes a face; "
              "move it into the bone");
  }
}

TEST(SlabParts, PlanesPointMayBeFarFromTheBone) {
  const Bone block = MakeBox(Pose{}, {10, 6, 6}, 0.2);
  const CutPlane near = PlaneOf({0.3, 0, 0}, {1, 0.2, 0.1});
  // The same plane, given by a point far away.
  const Vec3 along = glm::normalize(glm::cross(near.normal_W, Vec3(0, 0, 1)));
  const CutPlane far{near.p_W + 4900.0 * along, near.normal_W};
  const TriangleMesh a = MakeSlabParts(block, {near, 0.25, false, {}}).slice_surface_W;
  const TriangleMesh b = MakeSlabParts(block, {far, 0.25, false, {}}).slice_surface_W;
  // The lattice is fixed to the bone, so it is the same except for the rounding of coordinates of 4900 mm.
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) EXPECT_LT(glm::length(a.points[i] - b.points[i]), 1e-5);
}

TEST(SlabParts, SliceBetweenTwoVoxelLayersIsPlacedCorrectly) {
  // Two bars along x. No voxel centre lies within a slice of 0.02 mm at x = 0.1 mm.
  SolidField field;
  field.value = [](const Vec3& p) {
    return std::min(test::BoxDistance(p, {8, 2, 2}), test::BoxDistance(p - Vec3(0, 8, 0), {8, 2, 2}));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone bone = MakeBone(field, Box3{Vec3(-10, -4, -4), Vec3(10, 12, 4)}, {0.2, 0.2, {}}, test::OneRegionTable());
  for (const double y : {0.0, 8.0}) {
    const SlabParts parts = MakeSlabParts(bone, {PlaneOf({0.1, y, 0}, {1, 0, 0}), 0.02, false, {}});
    EXPECT_EQ(parts.places, 2u);
    EXPECT_EQ(parts.cut_places, 1u);
    EXPECT_NEAR(parts.slice.CalcBounds().centre().y, y, 0.01);
    EXPECT_LT(parts.distance_mm, 0.2);  // one voxel
  }
}

TEST(SlabParts, VolumeLostAtRimsIsWithinTheBound) {
  const double h = 0.4;
  Pose X_WB;
  X_WB.p_AB = {0.013, -0.021, 0.057};
  const Bone block = MakeBox(X_WB, {40, 12, 6}, h);
  for (const double degrees : {90.0, 60.0, 30.0, 20.0}) {
    // The plane is rotated about y, so it meets the top and bottom at this angle and the sides at a right angle.
    const double angle = degrees * std::numbers::pi / 180;
    const CutPlane plane = PlaneOf({0.1, 0, 0}, {std::sin(angle), 0, std::cos(angle)});
    const SlabParts parts = MakeSlabParts(block, {plane, 0.5, false, {}});
    const double along_sides_mm = 2 * 6 / std::sin(angle);
    const double bound_mm3 = 2 * 0.5 * h * h * (2 * 12 / std::sin(angle) + along_sides_mm);
    const double lost_mm3 = block.CalcVolume() - SumOfVolumes(parts);
    EXPECT_GT(lost_mm3, 0) << degrees;
    EXPECT_LT(lost_mm3, bound_mm3) << degrees;
  }
}

}  // namespace
}  // namespace kerf
