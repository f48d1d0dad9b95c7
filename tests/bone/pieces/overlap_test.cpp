#include "bone/pieces/overlap.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "kerf/surface.h"
#include "support/solids.h"

namespace kerf {
namespace {

struct Draw {
  explicit Draw(unsigned seed) : random(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 Direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(Vec3(normal(random), normal(random), normal(random)));
  }
  Pose AnyPose(double reach = 30) {
    return {glm::angleAxis(In(0, 3.1), Direction()), {In(-reach, reach), In(-reach, reach), In(-reach, reach)}};
  }
  std::mt19937 random;
};

Pose Inverse(const Pose& X) {
  return {glm::conjugate(X.R_AB), X.InversePoint(Vec3(0))};
}
Pose Compose(const Pose& a, const Pose& b) {
  return {a.R_AB * b.R_AB, a.Point(b.p_AB)};
}

/// Returns the volume common to two balls of radius R and r whose centres are d apart.
double LensVolume(double R, double r, double d) {
  if (d >= R + r) return 0;
  if (d <= std::abs(R - r)) return 4.0 / 3 * std::numbers::pi * std::pow(std::min(R, r), 3);
  return std::numbers::pi * std::pow(R + r - d, 2) * (d * d + 2 * d * (r + R) - 3 * (r - R) * (r - R)) / (12 * d);
}

// Between voxels the surface of a ball lies up to h^2 / (4 R) too deep, here 0.0006 and 0.0008 mm. A lens of thickness
// t loses the fraction 2 (0.0006 + 0.0008) / t of its volume, 1.4 % if it is two voxels thick.
TEST(Overlap, OfTwoBallsIsTheLens) {
  Draw draw(1);
  const double h = 0.1;
  const double R = 4;
  const double r = 3;
  const Bone a = test::MakeSphere({1, 2, 3}, R, h);
  const Bone b = test::MakeSphere({-2, 0.1, 5}, r, h);
  for (int i = 0; i < 15; ++i) {
    const Pose X_WA = draw.AnyPose();
    const double d = i == 0 ? R + r - 2 * h : draw.In(0.2, R + r - 2 * h);
    const Vec3 centre_W = X_WA.Point({1, 2, 3}) + d * draw.Direction();
    Pose X_WB = draw.AnyPose();
    X_WB.p_AB = centre_W - X_WB.Vector({-2, 0.1, 5});
    const double lens = LensVolume(R, r, d);
    EXPECT_NEAR(CalcOverlap(a, X_WA, b, X_WB), lens, 0.02 * lens) << d;
    EXPECT_NEAR(CalcOverlap(b, X_WB, a, X_WA), lens, 0.02 * lens) << d;
  }
}

TEST(Overlap, OfTwoCubesIsTheBoxBetweenThem) {
  Draw draw(2);
  const double h = 0.1;
  const Pose X_PB = draw.AnyPose(5);  // pose of the cube in its bone
  const Vec3 size(6, 5, 4);
  const Bone a = test::MakeBox({}, size, h);
  const Bone b = test::MakeBox(X_PB, size, h);
  for (int i = 0; i < 12; ++i) {
    const Pose X_WA = draw.AnyPose();
    // The cube is shifted along its own axes, so that the faces of the boxes stay parallel.
    const Vec3 shift(draw.In(-5, 5), draw.In(-4, 4), draw.In(-3, 3));
    const Pose X_WC = {X_WA.R_AB, X_WA.Point(shift)};  // of the other cube
    const Pose X_WB = Compose(X_WC, Inverse(X_PB));
    const Vec3 left = size - glm::abs(shift);
    const double mm3 = left.x * left.y * left.z;
    // The edges of a level set are rounded and lose about h^2 / 10 of cross-section along their length, with h the
    // voxel size: 1.2 % of a cube of 1 mm.
    EXPECT_NEAR(CalcOverlap(a, X_WA, b, X_WB), mm3, 0.02 * mm3) << shift.x << " " << shift.y << " " << shift.z;
  }
}

TEST(Overlap, OfTwoCutHalvesIsZero) {
  const Bone bone = test::MakeSphere({0, 0, 0}, 5, 0.2);
  EXPECT_EQ(CalcOverlap(bone, {}, test::MakeSphere({0, 0, 0}, 2, 0.2), Pose{{1, 0, 0, 0}, {30, 0, 0}}), 0);
  EXPECT_EQ(CalcOverlap(bone, {}, Bone(), {}), 0);
  // A bone overlaps completely with itself.
  EXPECT_NEAR(CalcOverlap(bone, {}, bone, {}), bone.CalcVolume(), 1e-3 * bone.CalcVolume());
}

struct Surface {
  explicit Surface(const Bone& bone) : mesh(ExtractSurface(bone)), tree(mesh) {}
  SurfaceWithTree in_tree() const { return {&mesh, &tree}; }
  TriangleMesh mesh;
  SurfaceTree tree;
};

/// Brute force: the distance from every point of each mesh to every triangle of the other.
double CalcGapSlowly(const TriangleMesh& a, const Pose& X_WA, const TriangleMesh& b, const Pose& X_WB) {
  double smallest = 1e300;
  const auto search = [&](const TriangleMesh& from, const Pose& X_from, const TriangleMesh& to, const Pose& X_to) {
    for (const Vec3& p : from.points) {
      const Vec3 at = X_to.InversePoint(X_from.Point(p));
      for (const auto& t : to.triangles) {
        smallest = std::min(
            smallest, glm::length(at - FindNearestInTriangle(at, to.points[t[0]], to.points[t[1]], to.points[t[2]])));
      }
    }
  };
  search(a, X_WA, b, X_WB);
  search(b, X_WB, a, X_WA);
  return smallest;
}

TEST(Gap, MatchesABruteForceSearch) {
  Draw draw(3);
  const Surface a(test::MakeBox({}, {3, 2, 2}, 0.3));
  const Surface b(test::MakeSphere({0, 0, 0}, 1.5, 0.3));
  for (int i = 0; i < 10; ++i) {
    const Pose X_WA = draw.AnyPose();
    Pose X_WB = draw.AnyPose();
    X_WB.p_AB = X_WA.p_AB + draw.In(3.5, 8) * draw.Direction();
    const auto gap = CalcGap(a.in_tree(), X_WA, b.in_tree(), X_WB, 100);
    ASSERT_TRUE(gap);
    EXPECT_NEAR(gap->gap_mm, CalcGapSlowly(a.mesh, X_WA, b.mesh, X_WB), 1e-9);
    EXPECT_NEAR(glm::length(gap->p_WA_mm - gap->p_WB_mm), gap->gap_mm, 1e-9);
    EXPECT_FALSE(CalcGap(a.in_tree(), X_WA, b.in_tree(), X_WB, 0.999 * gap->gap_mm));
  }
}

TEST(Gap, OfTwoBallsMatchesTheClosedForm) {
  Draw draw(4);
  const Surface a(test::MakeSphere({1, 2, 3}, 4, 0.2));
  const Surface b(test::MakeSphere({-2, 0.1, 5}, 3, 0.2));
  for (int i = 0; i < 10; ++i) {
    const Pose X_WA = draw.AnyPose();
    Pose X_WB = draw.AnyPose();
    const Vec3 direction = draw.Direction();
    const double gap = draw.In(0.05, 10);
    const Vec3 centre = X_WA.Point({1, 2, 3});
    X_WB.p_AB = centre + (7 + gap) * direction - X_WB.Vector({-2, 0.1, 5});
    const auto found = CalcGap(a.in_tree(), X_WA, b.in_tree(), X_WB, 100);
    ASSERT_TRUE(found);
    // Facets lie within h^2 / (8 R) of each ball, and the triangulation is accurate to a twentieth of a voxel.
    EXPECT_NEAR(found->gap_mm, gap, 0.02);
    EXPECT_LT(glm::length(found->p_WA_mm - (centre + 4.0 * direction)), 0.6);
  }
}

TEST(Facing, OfTwoPlatesIsTheirDistance) {
  const Surface a(test::MakeBox({}, {10, 8, 2}, 0.2));
  const Surface b(test::MakeBox({}, {10, 8, 2}, 0.2));
  const Facing facing = CalcFacing(a.in_tree(), {}, b.in_tree(), Pose{{1, 0, 0, 0}, {0, 0, 2.6}}, 3, 0.7);
  // The area is the upper face of the first plate without its rounded edge, which is less than a voxel wide all around.
  EXPECT_NEAR(facing.area_mm2, 80, 0.2 * 36);
  EXPECT_NEAR(facing.mean_mm, 0.6, 0.02);
  EXPECT_NEAR(facing.p95_mm, 0.6, 0.1);
  EXPECT_NEAR(facing.contact_mm2, 80, 0.2 * 36);
  EXPECT_EQ(CalcFacing(a.in_tree(), {}, b.in_tree(), Pose{{1, 0, 0, 0}, {0, 0, 20}}, 3, 0.7).area_mm2, 0);
}

TEST(SurfaceTree, RaysHitABallAtTheExpectedPoints) {
  Draw draw(5);
  const Vec3 centre(100, -200, 300);
  const Surface ball(test::MakeSphere(centre, 4, 0.2));
  for (int i = 0; i < 200; ++i) {
    const Vec3 d = draw.Direction();
    const Vec3 side = glm::normalize(glm::cross(d, draw.Direction()));
    const double off = draw.In(0, 5);
    const double from = draw.In(10, 1000);
    const auto hit = ball.tree.Intersect(centre + off * side - from * d, 3.0 * d);
    if (off > 4.05) {
      EXPECT_FALSE(hit);
    } else if (off < 3.8) {
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->distance_mm, from - std::sqrt(16 - off * off), 0.06);
      EXPECT_NEAR(glm::length(hit->p - centre), 4, 0.02);
    }
  }
  EXPECT_FALSE(ball.tree.Intersect(centre + Vec3(10, 0, 0), {1, 0, 0}));
  EXPECT_FALSE(ball.tree.Intersect(centre, {0, 0, 0}));
}

}  // namespace
}  // namespace kerf
