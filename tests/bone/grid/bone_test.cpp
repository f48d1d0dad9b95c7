#include "kerf/bone.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numbers>
#include <random>
#include <regex>

#include "base/core/cancelled.h"
#include "bone/grid/build.h"
#include "bone/grid/cell_volume.h"
#include "bone/grid/coarse_surface.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::MakeBox;
using test::MakeSphere;

double SphereVolume(double r) {
  return 4.0 / 3.0 * std::numbers::pi * r * r * r;
}

TEST(CellVolume, NegativeFractionOfATetrahedronMatchesMonteCarlo) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> corner(-1, 1);
  std::exponential_distribution<double> exponential;
  for (int n = 0; n < 40; ++n) {
    const double f[4] = {corner(random), corner(random), corner(random), corner(random)};
    int inside = 0;
    constexpr int kSamples = 40000;
    for (int i = 0; i < kSamples; ++i) {
      double w[4];
      double sum = 0;
      for (double& x : w) sum += x = exponential(random);  // uniform barycentric coordinates
      double value = 0;
      for (int k = 0; k < 4; ++k) value += w[k] / sum * f[k];
      inside += value < 0 ? 1 : 0;
    }
    // The tolerance is four standard deviations of the estimate: 4 * sqrt(1/4 / 40000) = 0.01.
    EXPECT_NEAR(CalcNegativeFraction(f[0], f[1], f[2], f[3]), static_cast<double>(inside) / kSamples, 0.01);
  }
}

TEST(CellVolume, PlaneThroughACellIsExact) {
  // The plane z = c through the unit cell has the fraction c below it.
  for (const double c : {0.1, 0.25, 0.5, 0.9}) {
    std::array<float, 8> v{};
    for (int i = 0; i < 8; ++i) v[i] = static_cast<float>((i & 1) - c);
    EXPECT_NEAR(CalcCellFraction(v), c, 1e-7);
  }
  // The plane x + y + z = 1 cuts off a corner of volume 1/6.
  std::array<float, 8> v{};
  for (int i = 0; i < 8; ++i) v[i] = static_cast<float>(((i >> 2) & 1) + ((i >> 1) & 1) + (i & 1) - 1);
  EXPECT_NEAR(CalcCellFraction(v), 1.0 / 6, 1e-7);
}

TEST(Bone, VolumeOfASphereConvergesWithSecondOrder) {
  const Vec3 centre(0.03, -0.07, 0.11);
  double error[3];
  const double voxels[3] = {0.8, 0.4, 0.2};
  for (int i = 0; i < 3; ++i) {
    error[i] = std::abs(MakeSphere(centre, 5, voxels[i]).CalcVolume() / SphereVolume(5) - 1);
  }
  EXPECT_LT(error[2], 1e-3);  // h^2 / R^2 = 1.6e-3 is the order of the chord error
  EXPECT_GT(std::log2(error[0] / error[1]), 1.8);
  EXPECT_GT(std::log2(error[1] / error[2]), 1.8);
}

TEST(Bone, BoxVolumeIsExactInAnyPoseUpToItsEdges) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 8; ++n) {
    Pose X_WB;
    if (n > 0) X_WB.R_AB = glm::normalize(Quat(normal(random), normal(random), normal(random), normal(random)));
    X_WB.p_AB = Vec3(normal(random), normal(random), normal(random));
    const Bone bone = MakeBox(X_WB, {10, 8, 6}, 0.2);
    // Faces are exact; each edge (96 mm in all) loses at most about h^2 / 4 of its cross-section: 0.96 mm^3 of 480.
    EXPECT_NEAR(bone.CalcVolume(), 480, 0.96);
  }
}

TEST(Bone, NonDistanceFieldGivesTheSameSurfaceAndADistance) {
  SolidField field = test::SphereField({0, 0, 0}, 5);
  const auto distance = field.value;
  field.value = [distance](const Vec3& p) { return 300 * std::tanh(distance(p)) * (1 + 0.2 * p.x / 5); };
  field.is_distance = false;
  const Bone bone = MakeBone(field, Box3{Vec3(-6.5), Vec3(6.5)}, {0.2, 0.2, {}}, test::OneRegionTable());
  EXPECT_NEAR(bone.CalcVolume() / SphereVolume(5), 1, 2e-3);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 500; ++n) {
    const Vec3 direction = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
    for (const double d : {-0.4, -0.2, 0.0, 0.2, 0.4}) {
      // First-order fast sweeping has an error of up to a fifth of a voxel two voxels from the surface, and of a tenth
      // on it.
      EXPECT_NEAR(bone.SignedDistance((5 + d) * direction), d, d == 0 ? 0.02 : 0.05);
    }
  }
}

TEST(Bone, BoundsAreSubVoxel) {
  const Bone bone = MakeSphere({0.03, -0.07, 0.11}, 5, 0.4);
  const Box3 box = bone.CalcBounds();
  // The nearest line of voxels misses the sphere's pole by up to h / sqrt(2), so it crosses the surface up to h^2 / (4
  // R) = 0.008 mm short of the pole.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box.lower[axis], Vec3(0.03, -0.07, 0.11)[axis] - 5, 0.01);
    EXPECT_NEAR(box.upper[axis], Vec3(0.03, -0.07, 0.11)[axis] + 5, 0.01);
  }
}

TEST(Bone, RegionVolumesSumToTheTotalVolume) {
  SolidField field = test::SphereField({0, 0, 0}, 5);
  field.region = [](const Vec3& p) { return p.z > 0.1 ? 1 : 2; };
  MaterialTable table = test::OneRegionTable(1);
  table.Add({2, "lower", Tissue::kCancellous, 500, 0.3, true, "test"});
  for (const double region_voxel : {0.1, 0.2, 0.4}) {
    const Bone bone = MakeBone(field, Box3{Vec3(-6), Vec3(6)}, {0.2, region_voxel, {}}, table);
    const auto volumes = bone.CalcRegionVolumes();
    EXPECT_EQ(volumes.count(0), 0u) << region_voxel;  // every part of the bone has material
    EXPECT_NEAR(volumes.at(1) + volumes.at(2), bone.CalcVolume(), 1e-9 * bone.CalcVolume());
    // Over the area of the great circle, the border is off by at most half a region voxel plus half a cell.
    const double above = SphereVolume(5) / 2 - std::numbers::pi * 25 * 0.1;
    EXPECT_NEAR(volumes.at(1), above, std::numbers::pi * 25 * (0.5 * region_voxel + 0.5 * 0.2));
  }
}

TEST(Bone, CopyIsDeepAndHashFollowsTheContent) {
  const Bone a = MakeSphere({0, 0, 0}, 3, 0.2);
  Bone b = a;
  EXPECT_EQ(a.CalcHash(), b.CalcHash());
  SetRegions(
      b, [](const Vec3& p) { return p.x > 0 ? 24 : 0; }, 0.2);
  EXPECT_NE(a.CalcHash(), b.CalcHash());
  EXPECT_EQ(a.CalcHash(), MakeSphere({0, 0, 0}, 3, 0.2).CalcHash());
  EXPECT_NE(a.CalcHash(), MakeSphere({0, 0, 1e-4}, 3, 0.2).CalcHash());
}

TEST(Bone, AMirroredSolidIsTheSameFromOneHalf) {
  // Balls across the middle, away from it, touching it, and a small one whose mirror image meets other leaves.
  SolidField solid;
  solid.value = [](const Vec3& p_W) {
    const Vec3 p{std::abs(p_W.x), p_W.y, p_W.z};
    return std::min({glm::length(p) - 4, glm::distance(p, {9.1, 1, 2}) - 3.3, glm::distance(p, {2.5, 9, 0}) - 2.5,
                     glm::distance(p, {7.93, -7, 0}) - 0.45});
  };
  solid.classify = ClassifyByDistance(solid.value);
  solid.leaf_regions = [](const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) {
    for (int n = 0; n < kLeafVoxels; ++n) {
      const Vec3 p = leaf.CalcPosition(n);
      const int by_layer = glm::length(p) < 2 ? 3 : std::abs(p.x) > 8 ? 4 : kRegionByPlace;
      if (wanted[static_cast<std::size_t>(n)]) ids[static_cast<std::size_t>(n)] = by_layer;
    }
  };
  solid.region_at_place = [](const Vec3& p) { return p.x > 0.3 ? 1 : 2; };
  solid.is_distance = false;
  for (const double voxel : {0.1, 0.17, 0.4}) {
    BuildOptions options;
    options.voxel_mm = voxel;
    const Box3 box{Vec3{-14, -12, -6}, Vec3{14, 13, 7}};
    solid.is_mirrored = false;
    const Bone whole = MakeBone(solid, box, options, MaterialTable());
    std::atomic<int> beyond = 0;
    SolidField half = solid;
    half.is_mirrored = true;
    half.value = [&solid, &beyond](const Vec3& p) {
      if (p.x < 0) ++beyond;
      return solid.value(p);
    };
    // Also through near(), for balls that contain a leaf.
    half.near = [&half](const Vec3& centre, double radius_mm) {
      SolidField near = half;
      near.value = [&half, centre, radius_mm](const Vec3& p) {
        EXPECT_LE(glm::distance(p, centre), radius_mm + 1e-9);
        return half.value(p);
      };
      return near;
    };
    const Bone mirrored = MakeBone(half, box, options, MaterialTable());
    EXPECT_EQ(mirrored.CalcHash(), whole.CalcHash()) << voxel;
    EXPECT_EQ(mirrored.CalcRegionVolumes(), whole.CalcRegionVolumes()) << voxel;
    EXPECT_EQ(beyond, 0);
  }
}

TEST(Bone, BoneTooLargeForMemoryIsRefused) {
  SolidField ball;
  ball.value = [](const Vec3& p) { return glm::length(p) - 10; };
  ball.classify = ClassifyByDistance(ball.value);
  ball.region = [](const Vec3&) { return 24; };
  BuildOptions options;
  options.voxel_mm = options.region_voxel_mm = 0.2;
  const Box3 box{Vec3(-12), Vec3(12)};
  EXPECT_FALSE(MakeBone(ball, box, options, MaterialTable()).empty());
  options.max_bytes = 1e6;
  const std::string message = test::MessageOf([&] { MakeBone(ball, box, options, MaterialTable()); });
  // The amount in the message depends on the timing of the threads.
  EXPECT_TRUE(std::regex_search(
      message, std::regex(R"(needs more than [1-9]\.[0-9] MB of memory and 1\.0 MB are free; use larger voxels)")))
      << message;
}

TEST(Bone, NothingInsideIsAnError) {
  EXPECT_THROW(MakeSphere({0, 0, 0}, -1, 0.2), Error);
  EXPECT_THROW(MakeSphere({0, 0, 0}, 1, 0.001), Error);
}

TEST(Surface, IsClosedOutwardAndEnclosesTheVolume) {
  const Bone bone = MakeSphere({1, 2, 3}, 5, 0.2);
  const TriangleMesh mesh = ExtractSurface(bone);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  // Mesh points are averaged crossings, which cuts convex surfaces by the order of h^2 / R^2.
  EXPECT_NEAR(CalcEnclosedVolume(mesh) / SphereVolume(5), 1, 3e-3);
}

TEST(Surface, ACoarseOneIsClosedOutwardAndHasItsCornersOnTheSurface) {
  const Vec3 centre(1, 2, 3);
  const Bone bone = MakeSphere(centre, 5, 0.2);
  const TriangleMesh mesh = ExtractCoarseSurface(bone);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  // Interpolation between voxels is off by h^2 / 8R at most along each of the two curved directions.
  for (const Vec3& p : mesh.points) ASSERT_NEAR(glm::length(p - centre), 5, 2 * 0.2 * 0.2 / (8 * 5));
  // Corners on the sphere, of triangles with edges of about 2 h: smaller by about (2 h)^2 / 2R^2.
  EXPECT_NEAR(CalcEnclosedVolume(mesh) / SphereVolume(5), 1, 3.2e-3);
  const auto count = [](const TriangleMesh& m) { return static_cast<double>(m.triangles.size()); };
  EXPECT_NEAR(count(ExtractSurface(bone)) / count(mesh), 4, 0.2);
}

TEST(Surface, MeshRoundTripThroughABoneKeepsTheSurface) {
  const TriangleMesh mesh = ExtractSurface(MakeSphere({1, 2, 3}, 5, 0.2));
  const Bone bone = MakeBoneFromMesh(
      mesh, [](const Vec3&) { return 24; }, {0.2, 0.2, {}}, test::OneRegionTable());
  EXPECT_NEAR(bone.CalcVolume() / CalcEnclosedVolume(mesh), 1, 2e-3);
  EXPECT_NEAR(bone.SignedDistance({1, 2, 3 + 5.2}), 0.2, 0.02);
  EXPECT_EQ(bone.RegionAt({1, 2, 3}), 24);
}

TEST(Surface, OpenMeshIsRefused) {
  TriangleMesh mesh = ExtractSurface(MakeSphere({0, 0, 0}, 2, 0.4));
  mesh.triangles.pop_back();
  EXPECT_EQ(test::MessageOf([&] {
              MakeBoneFromMesh(
                  mesh, [](const Vec3&) { return 24; }, {0.2, 0.2, {}}, test::OneRegionTable());
            }),
            "the surface is not closed: 3 of its edges do not join exactly two triangles");
}

TEST(Pieces, ThreeSpheresAreThreePiecesWithTheirVolumes) {
  SolidField field;
  const auto sphere = [](const Vec3& p, const Vec3& c, double r) { return glm::length(p - c) - r; };
  field.value = [=](const Vec3& p) {
    return std::min({sphere(p, {0, 0, 0}, 3), sphere(p, {7, 0, 0}, 2), sphere(p, {0, 5, 0}, 1)});
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone bone = MakeBone(field, Box3{Vec3(-5), Vec3(11)}, {0.2, 0.2, {}}, test::OneRegionTable());
  const Pieces split = SplitPieces(bone);
  ASSERT_EQ(split.pieces.size(), 3u);
  const double radii[3] = {3, 2, 1};
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(split.pieces[i].CalcVolume() / SphereVolume(radii[i]), 1,
                0.03);  // chord error, about (h / R)^2 / 2 = 0.02 for the smallest sphere
    EXPECT_EQ(CountOpenEdges(ExtractSurface(split.pieces[i])), 0u);
    sum += split.pieces[i].CalcVolume();
  }
  EXPECT_NEAR(sum, bone.CalcVolume(), 1e-9 * sum);
  const Pieces coarse = SplitPieces(bone, 10);
  EXPECT_EQ(coarse.pieces.size(), 2u);
  EXPECT_EQ(coarse.dust_count, 1u);
  EXPECT_EQ(coarse.dust.CalcHash(), split.pieces[2].CalcHash());
  EXPECT_TRUE(split.dust.empty());
  // All dust is in one bone.
  const Pieces coarser = SplitPieces(bone, 50);
  EXPECT_EQ(coarser.dust_count, 2u);
  EXPECT_NEAR(coarser.dust.CalcVolume(), split.pieces[1].CalcVolume() + split.pieces[2].CalcVolume(), 1e-9);
}

TEST(Pieces, SlotOneVoxelWideSeparatesInAnyOrientation) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 10; ++n) {
    const Vec3 direction = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
    SolidField field;
    field.value = [=](const Vec3& p) {
      return std::max(glm::length(p) - 4, 0.125 - std::abs(glm::dot(p, direction) - 0.02));
    };
    field.classify = [](const Vec3& c, double r) {
      return glm::length(c) - r > 4 ? BlockClass::kOutside : BlockClass::kMixed;
    };
    field.region = [](const Vec3&) { return 24; };
    // A 0.25 mm kerf in 0.2 mm voxels: no two voxels that share a face lie on opposite sides of it.
    const Bone bone = MakeBone(field, Box3{Vec3(-5.5), Vec3(5.5)}, {0.2, 0.2, {}}, test::OneRegionTable());
    EXPECT_EQ(SplitPieces(bone).pieces.size(), 2u);
  }
}

TEST(Bone, ModulusIsInterpolatedBetweenRegionVoxels) {
  // Two regions that meet at x = 0.05, midway between two layers of region voxels 0.1 mm apart.
  SolidField field;
  field.value = [](const Vec3& p) { return test::BoxDistance(p, Vec3(3, 2, 2)); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return p.x < 0.05 ? 24 : 32; };
  MaterialTable table = test::OneRegionTable(24, 20000, 0.2);
  table.Add({32, "soft", Tissue::kCancellous, 1000, 0.4, true, "test"});
  const Bone bone = MakeBone(field, Box3{Vec3(-4, -3, -3), Vec3(4, 3, 3)}, {0.1, 0.1, {}}, table);
  EXPECT_DOUBLE_EQ(bone.ModulusAt({-1, 0.03, 0.02}), 20000);
  EXPECT_DOUBLE_EQ(bone.PoissonRatioAt({-1, 0.03, 0.02}), 0.2);
  EXPECT_DOUBLE_EQ(bone.ModulusAt({1, 0.03, 0.02}), 1000);
  // E is linear from 20000 at x = 0 to 1000 at x = 0.1, and so is nu between its values. The tolerances allow for
  // rounding.
  for (const double t : {0.0, 0.25, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(bone.ModulusAt({0.1 * t, 0.03, 0.02}), 20000 - 19000 * t, 1e-8);
    EXPECT_NEAR(bone.PoissonRatioAt({0.1 * t, 0.03, 0.02}), 0.2 + 0.2 * t, 1e-12);
  }
  // Regions extend slightly beyond the surface, so a point on it has the full modulus; a point far outside has none.
  EXPECT_DOUBLE_EQ(bone.ModulusAt({3, 0.03, 0.02}), 1000);
  EXPECT_EQ(bone.ModulusAt({5, 0, 0}), 0);
  EXPECT_EQ(bone.PoissonRatioAt({5, 0, 0}), 0);
}

// Of a field that is no distance, only the voxels near its zero level count.
TEST(MakeBone, FieldGivesTheSameBoneHoweverLooselyItIsClassified) {
  SolidField field = test::SphereField({0.13, -0.21, 0.07}, 5);
  field.is_distance = false;
  // A thin wall and a hollow, so that leaves with a change of sign are beside leaves without one.
  field.value = [](const Vec3& p) {
    const double wall = std::abs(p.x - 0.81) - 0.1;
    return std::max({glm::length(p - Vec3(0.13, -0.21, 0.07)) - 5, -wall, 1.1 - glm::length(p - Vec3(-2, 0, 0))});
  };
  field.classify = ClassifyByDistance(field.value);
  const Box3 box{Vec3(-7), Vec3(7)};
  const BuildOptions options{.voxel_mm = 0.1, .region_voxel_mm = 0.2, .progress = {}};
  const std::uint64_t tight = MakeBone(field, box, options, test::OneRegionTable()).CalcHash();
  field.classify = [](const Vec3&, double) { return BlockClass::kMixed; };
  EXPECT_EQ(MakeBone(field, box, options, test::OneRegionTable()).CalcHash(), tight);
  // Likewise if leaves are evaluated as a whole.
  field.leaf_values = [value = field.value](const LeafPlace& leaf, LeafValues& values) {
    for (int n = 0; n < kLeafVoxels; ++n) {
      values[static_cast<std::size_t>(n)] = static_cast<float>(value(leaf.CalcPosition(n)));
    }
  };
  field.leaf_regions = [](const LeafPlace&, const WantedVoxels& wanted, LeafRegions& ids) {
    for (std::size_t n = 0; n < ids.size(); ++n) ids[n] = wanted[n] ? 24 : 99;
  };
  EXPECT_EQ(MakeBone(field, box, options, test::OneRegionTable()).CalcHash(), tight);
}

TEST(MakeBone, EndsSoonWhenTheProgressIsCancelled) {
  std::atomic<long> evaluated{0};
  SolidField field = test::SphereField({0, 0, 0}, 12);
  field.value = [value = field.value, &evaluated](const Vec3& p) {
    ++evaluated;
    return value(p);
  };
  field.region = [&evaluated](const Vec3&) {
    ++evaluated;
    return 24;
  };
  const Box3 box = Box3{Vec3(-12), Vec3(12)}.Grown(2);
  BuildOptions options{.voxel_mm = 0.2, .region_voxel_mm = 0.2, .progress = {}};
  const auto make = [&](double until) {
    evaluated = 0;
    options.progress = [until](double fraction) {
      if (fraction >= until) throw Cancelled();
    };
    MakeBone(field, box, options, test::OneRegionTable());
  };
  make(2);
  const long all = evaluated;
  for (const double until : {0.0, 0.2, 0.6, 0.76, 0.9}) {
    EXPECT_THROW(make(until), Cancelled) << until;
    // Evaluating the field takes most of the time. Other threads finish their batches of 16 blocks of 512 voxels.
    EXPECT_LT(static_cast<double>(evaluated) / static_cast<double>(all), until < 0.1 ? 0.1 : 0.97) << until;
  }
}

}  // namespace
}  // namespace kerf
