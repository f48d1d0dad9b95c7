// A bone and its cut as two fields: volumes of thin walls and sharp edges, samples, and copies by leaves.
#include <gtest/gtest.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "bone/grid/cell_fields.h"
#include "bone/grid/cell_volume.h"
#include "bone/grid/coarse_surface.h"
#include "bone/grid/field.h"
#include "bone/grid/grids.h"
#include "bone/grid/join.h"
#include "bone/grid/parts_reader.h"
#include "bone/grid/piece_finder.h"
#include "bone/grid/piece_removal.h"
#include "bone/grid/removed.h"
#include "bone/grid/set_leaf.h"
#include "kerf/surface.h"
#include "support/cuts.h"
#include "support/solids.h"

namespace kerf {
namespace {

Vec3 DrawDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(Vec3(normal(random), normal(random), normal(random)));
}

/// Returns the volume of the part of a cube of edge 8 with its lowest corner at 0 where n . p < d.
double CalcCubeBelow(const Vec3& n, double d) {
  std::array<float, 8> corners{};
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<std::size_t>(i)] = static_cast<float>(glm::dot(n, 8.0 * Vec3(i >> 2, i >> 1 & 1, i & 1)) - d);
  }
  return 512 * CalcCellFraction(corners);
}

TEST(CellVolume, CommonFractionIsThatOfRandomPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  std::exponential_distribution<double> exponential;
  constexpr int kSamples = 40000;
  for (int trial = 0; trial < 40; ++trial) {
    std::array<double, 4> a{}, b{}, minus_b{};
    for (std::size_t i = 0; i < 4; ++i) {
      a[i] = value(random);
      b[i] = value(random);
      minus_b[i] = -b[i];
    }
    int inside = 0;
    for (int n = 0; n < kSamples; ++n) {
      double w[4], sum = 0, of_a = 0, of_b = 0;
      for (double& x : w) sum += x = exponential(random);
      for (std::size_t k = 0; k < 4; ++k) {
        of_a += w[k] / sum * a[k];
        of_b += w[k] / sum * b[k];
      }
      inside += of_a < 0 && of_b < 0 ? 1 : 0;
    }
    EXPECT_NEAR(CalcCommonFraction(a, b), static_cast<double>(inside) / kSamples, 0.01);
    // The parts on both sides of b make the whole part of a.
    EXPECT_NEAR(CalcCommonFraction(a, b) + CalcCommonFraction(a, minus_b), CalcNegativeFraction(a[0], a[1], a[2], a[3]),
                1e-12);
    EXPECT_NEAR(CalcCommonFraction(a, b), CalcCommonFraction(b, a), 1e-12);
  }
}

/// Returns the sum of the cells' fractions in a leaf of pure bone with the cut min(of a slab, of a half-space): where
/// |n . p - d| < t and m . p < e, in voxels.
double CalcLeft(const Vec3& n, double d, double t, const Vec3& m, double e) {
  CellFields fields(1, 3);
  std::array<float, 512> whole;
  whole.fill(-3);
  std::array<std::array<float, 512>, 27> cuts{};
  for (int leaf = 0; leaf < 27; ++leaf) {
    for (int i = 0; i < 512; ++i) {
      const Vec3 p(8 * (leaf / 9 - 1) + i / 64, 8 * (leaf / 3 % 3 - 1) + i / 8 % 8, 8 * (leaf % 3 - 1) + i % 8);
      const double depth = std::min(t - std::abs(glm::dot(n, p) - d), e - glm::dot(m, p));
      cuts[static_cast<std::size_t>(leaf)][static_cast<std::size_t>(i)] =
          static_cast<float>(std::clamp(depth, -3.0, 3.0));
    }
  }
  fields.Load([&](int x, int y, int z) {
    const int leaf = 9 * (x + 1) + 3 * (y + 1) + z + 1;
    return PhiParts{whole.data(), cuts[static_cast<std::size_t>(leaf)].data()};
  });
  double sum = 0;
  for (int i = 0; i < 512; ++i) sum += fields.CalcFraction(i / 64, i / 8 % 8, i % 8);
  return sum;
}

TEST(CellFields, AKerfHardlyWiderThanAVoxelKeepsItsVolumeInAnyDirection) {
  // Interpolated linearly, a kerf of 1.25 voxels, as a saw of 0.25 mm makes in voxels of 0.2 mm, is 6 to 12 % short.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  double worst = 0, squares = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vec3 n = DrawDirection(random);
    const double d = glm::dot(n, Vec3(4)) + shift(random), t = 0.625;
    const double exact = CalcCubeBelow(n, d + t) - CalcCubeBelow(n, d - t);
    const double error = (512 - CalcLeft(n, d, t, Vec3(0), 9)) / exact - 1;
    worst = std::max(worst, std::abs(error));
    squares += error * error / kTrials;
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_LT(std::sqrt(squares), 0.01);
}

TEST(CellFields, AFloorKeepsItsEdges) {
  // Of each of its two edges, linear interpolation loses 0.16 voxels^2 of cross-section on average.
  std::mt19937 random(6);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  double mean = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vec3 n = DrawDirection(random);
    const Vec3 m = glm::normalize(glm::cross(n, DrawDirection(random)));
    const double d = glm::dot(n, Vec3(4)) + shift(random), e = glm::dot(m, Vec3(4)) + shift(random), t = 1.5;
    // The part of the slab below the floor, by points.
    constexpr int kSteps = 80;
    int inside = 0;
    for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
      const Vec3 p = (Vec3(i / (kSteps * kSteps), i / kSteps % kSteps, i % kSteps) + 0.5) * (8.0 / kSteps);
      inside += std::abs(glm::dot(n, p) - d) < t && glm::dot(m, p) < e ? 1 : 0;
    }
    const double exact = 512.0 * inside / (kSteps * kSteps * kSteps);
    const double edges = 2 * 8;  // voxels, about: those of a floor through the middle
    mean += (512 - CalcLeft(n, d, t, m, e) - exact) / edges / kTrials;
  }
  EXPECT_LT(std::abs(mean), 0.16 / 5);
}

/// A block in which a kerf has been cut through all of its width and height.
struct CutBlock {
  explicit CutBlock(const Pose& the_X_WB, double voxel_mm, double kerf_mm = 0.4, int band_voxels = 3) : X_WB(the_X_WB) {
    before = test::MakeBox(X_WB, {8, 4, 3}, voxel_mm, band_voxels);
    bone = before;
    Box3 all = bone.CalcBounds();
    CutAway(bone, all, [&](const Vec3& p_W) { return 0.5 * kerf_mm - std::abs(X_WB.InversePoint(p_W).x - 0.03); });
  }
  Pose X_WB;
  Bone before, bone;
};

TEST(TwoFields, AKerfThroughABlockHasItsVolumeInAnyPose) {
  for (const double voxel_mm : {0.2, 0.1}) {
    for (const Pose& X_WB : test::BlockPoses(voxel_mm)) {
      const CutBlock cut(X_WB, voxel_mm);
      const double removed = cut.before.CalcVolume() - cut.bone.CalcVolume();
      // The block's own edges, which the kerf shortens, are rounded in the one field of the bone.
      EXPECT_NEAR(removed / (0.4 * 4 * 3), 1, voxel_mm == 0.2 ? 0.01 : 0.004);
    }
  }
}

TEST(TwoFields, TheVolumeIsThatOfAllCells) {
  for (const int band_voxels : {2, 3}) {
    for (const Pose& X_WB : test::BlockPoses(0.2)) {
      const CutBlock cut(X_WB, 0.2, 0.4, band_voxels);
      for (const Bone* bone : {&cut.before, &cut.bone}) {
        const BoneGrids& grids = GridsOf(*bone);
        const PartsReader reader(grids);
        CellFields fields(0.2, bone->band_mm());
        double cells = 0;
        ForEachBlock(grids.phi->tree(), [&](const openvdb::Coord& origin) {
          reader.Load(origin, fields);
          for (int i = 0; i < 512; ++i) cells += fields.CalcFraction(i / 64, i / 8 % 8, i % 8);
        });
        // The order of the sum of about 12000 cells differs.
        EXPECT_NEAR(bone->CalcVolume(), cells * 0.2 * 0.2 * 0.2, 1e-11);
      }
    }
  }
}

TEST(TwoFields, ABoneThatWasCutHasNoCoarseSurface) {
  const CutBlock cut({}, 0.2, 0.4);
  EXPECT_EQ(ExtractCoarseSurface(cut.bone).triangles, ExtractSurface(cut.bone).triangles);
  EXPECT_LT(ExtractCoarseSurface(cut.before).triangles.size(), ExtractSurface(cut.before).triangles.size() / 3);
}

TEST(TwoFields, TheEdgeOfAKerfIsSharpBetweenTheVoxels) {
  const Pose X_WB = test::BlockPoses(0.1)[6];
  const CutBlock cut(X_WB, 0.1);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(-1, 1), near(-0.05, 0.05);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p_B(0.23 + near(random), along(random), 1.5 + near(random));
    const double exact = std::max(p_B.z - 1.5, 0.2 - (p_B.x - 0.03));
    // Both are planes, which an interpolation reproduces up to the rounding of floats.
    EXPECT_NEAR(cut.bone.SignedDistance(X_WB.Point(p_B)), exact, 1e-6);
  }
}

TEST(TwoFields, OnePointAndManyHaveTheSameBits) {
  CutBlock cut(test::BlockPoses(0.1)[4], 0.1);
  const BoneField field(cut.bone, 0);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> x(-4.5, 4.5), y(-2.5, 2.5), z(-2, 2);
  PointList list;
  list.Reserve(5000);
  std::vector<Vec3> points;
  for (int i = 0; i < 5000; ++i) {
    points.push_back(cut.X_WB.Point({i % 2 == 0 ? 0.1 * x(random) : x(random), y(random), z(random)}) / 0.1);
    list.Add(points.back());
  }
  std::vector<double> whole(5000), part(5000), phi(5000);
  field.SampleParts({}, list, whole.data(), part.data());
  field.Sample({}, list, phi.data());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PhiPair pair = field.SampleParts(points[i]);
    EXPECT_EQ(whole[i], pair.whole_mm);
    EXPECT_EQ(part[i], pair.cut_mm);
    EXPECT_EQ(phi[i], pair.phi());
    EXPECT_EQ(phi[i], cut.bone.SignedDistance(0.1 * points[i]));
  }
}

TEST(TwoFields, PiecesAddUpToTheBoneAndOneTakenOutLeavesTheOther) {
  // Errors as a displacement of the wall of the kerf, in voxels. From two voxels on, only the ends of the kerf differ,
  // where its walls meet the block's sides. Without regard to the other wall, the narrowest kerf is off by 0.14 voxels.
  for (const auto& [kerf_mm, most_vox] : {std::pair{0.25, 0.025}, std::pair{0.4, 0.005}, std::pair{0.6, 0.005}}) {
    for (const Pose& X_WB : test::BlockPoses(0.2)) {
      const CutBlock cut(X_WB, 0.2, kerf_mm);
      const double most_mm3 = most_vox * 0.2 * (4 * 3);
      const Pieces split = SplitPieces(cut.bone, 0.5);
      ASSERT_EQ(split.pieces.size(), 2u);
      const double larger = split.pieces[0].CalcVolume(), smaller = split.pieces[1].CalcVolume();
      EXPECT_NEAR(larger + smaller + split.dust_mm3, cut.bone.CalcVolume(), most_mm3);
      const PieceFinder finder(cut.bone, 0.5);
      const PieceRemoval removal = MakePieceRemoval(cut.bone, finder, 2);
      EXPECT_NEAR(removal.piece.CalcVolume(), smaller, 1e-9);
      Bone rest = cut.bone;
      for (const LeafChange& change : removal.leaves) SetCut(rest, change.index, change.without);
      EXPECT_NEAR(rest.CalcVolume(), larger, most_mm3);
    }
  }
}

// A wall of 0.07 x 3 x 3 mm = 0.63 mm3 is left between two cuts, about a layer of voxels with a volume of 1.8 mm3.
TEST(TwoFields, CrumbsAreCountedByTheVolumeThatTheyEncloseAndOldOnesApart) {
  SolidField field;  // the ball is far from the cuts
  field.value = [](const Vec3& p) {
    return std::min(test::BoxDistance(p, {2, 1.5, 1.5}), glm::length(p - Vec3(4, 0, 0)) - 0.5);
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone before = MakeBone(field, Box3{Vec3(-6), Vec3(6)}, {0.2, 0.2, {}}, test::OneRegionTable());
  Bone after = before;
  for (const double side : {-1.0, 1.0}) {
    CutAway(after, after.CalcBounds(), [&](const Vec3& p) { return 0.25 - std::abs(p.x - 0.2 - side * 0.285); });
  }
  const double ball_mm3 = 4.0 / 3 * std::numbers::pi * 0.125;
  const Pieces split = SplitPieces(after, 1, &before);
  ASSERT_EQ(split.pieces.size(), 2u);
  EXPECT_EQ(split.dust_count, 2u);
  EXPECT_EQ(split.old_dust_count, 1u);
  EXPECT_NEAR(split.old_dust_mm3 / ball_mm3, 1, 0.1);  // a ball of 2.5 voxels
  // The block's distance is rounded about its edges, which takes 0.15 % of the wall.
  EXPECT_NEAR((split.dust_mm3 - split.old_dust_mm3) / 0.63, 1, 0.004);
  EXPECT_EQ(split.thin_count, 1u);
  EXPECT_NEAR(split.thin_mm3, split.dust_mm3 - split.old_dust_mm3, 1e-9);
  // What is listed has at least the threshold, and what is counted less.
  for (const double least_mm3 : {0.0, 0.4, 0.6, 0.7, 1.0, 3.0}) {
    const Pieces pieces = SplitPieces(after, least_mm3);
    EXPECT_EQ(pieces.dust_count, (ball_mm3 < least_mm3 ? 1u : 0u) + (0.63 < least_mm3 ? 1u : 0u)) << least_mm3;
    EXPECT_EQ(pieces.pieces.size() + pieces.dust_count, 4u);
    for (const Bone& piece : pieces.pieces) EXPECT_GE(piece.CalcVolume(), least_mm3);
    EXPECT_EQ(pieces.thin_count, 1u);
    EXPECT_FALSE(pieces.old_dust_count.has_value());
  }
}

TEST(TwoFields, APieceThatIsPutBackGivesTheBoneBefore) {
  for (const double kerf_mm : {0.25, 0.4}) {
    for (const Pose& X_WB : test::BlockPoses(0.2)) {
      const CutBlock cut(X_WB, 0.2, kerf_mm);
      const PieceRemoval removal = MakePieceRemoval(cut.bone, PieceFinder(cut.bone, 0.5), 2);
      Bone rest = cut.bone;
      for (const LeafChange& change : removal.leaves) SetCut(rest, change.index, change.without);
      openvdb::FloatTree& phi = GridsOf(rest).phi->tree();
      openvdb::tools::pruneLevelSet(phi, phi.background(), -phi.background());
      const Bone joined = JoinBones(rest, {&removal.piece});
      EXPECT_NEAR(joined.CalcVolume(), cut.bone.CalcVolume(), 1e-9);
      for (const RemovedCell& cell : FindRemoved(cut.bone, joined)) EXPECT_LT(std::abs(cell.mm3), 1e-12);
      // What was cut meanwhile on the other side of the kerf stays cut, but for a quarter of a voxel.
      const double wall = 0.03 + (X_WB.InversePoint(removal.piece.CalcBounds().centre()).x > 0 ? -0.5 : 0.5) * kerf_mm;
      const auto skim = [&](const Vec3& p_W) { return 0.1 - std::abs(X_WB.InversePoint(p_W).x - wall); };
      Bone both = cut.bone;
      CutAway(both, both.CalcBounds(), skim);
      CutAway(rest, rest.CalcBounds(), skim);
      const double back_mm3 = JoinBones(rest, {&removal.piece}).CalcVolume() - both.CalcVolume();
      EXPECT_GE(back_mm3, -1e-9);
      EXPECT_LE(back_mm3, 0.25 * 0.2 * (4 * 3));
    }
  }
}

TEST(TwoFields, PiecesAddUpWithAnyWidthOfTheBand) {
  for (const int band_voxels : {2, 3, 8}) {
    const CutBlock cut(test::BlockPoses(0.1)[6], 0.1, 0.4, band_voxels);
    double sum_mm3 = 0;
    for (const Bone& piece : SplitPieces(cut.bone, 0.5).pieces) {
      EXPECT_EQ(piece.band_mm(), cut.bone.band_mm());
      sum_mm3 += piece.CalcVolume();
    }
    EXPECT_NEAR(sum_mm3, cut.bone.CalcVolume(), 0.005 * 0.1 * (4 * 3));
    EXPECT_EQ(MakePieceRemoval(cut.bone, PieceFinder(cut.bone, 0.5), 2).piece.band_mm(), cut.bone.band_mm());
  }
}

TEST(TwoFields, SettlingKeepsBoneBetweenVoxelsThatAreOutside) {
  // A leaf that was removed entirely, below one in which each voxel is outside by one of the two fields: by the cut up
  // to a face of the block, and by the bone as it was from there on. Between the voxels at the face there is bone.
  Bone bone = test::MakeBox({}, {5, 5, 5}, 0.2);
  std::array<float, 512> cut;
  cut.fill(GridsOf(bone).phi->background());
  SetCut(bone, {1, 0, -1}, cut);
  for (std::size_t i = 0; i < 512; ++i) cut[i] = i / 64 <= 4 ? 0.01f : -0.3f;
  SetCut(bone, {1, 0, 0}, cut);
  const double before_mm3 = bone.CalcVolume();
  BoneField field(bone, 10);
  for (const int z : {-1, 0}) field.Write(field.FromWorld({1, 0, z}));
  field.Settle();
  EXPECT_NEAR(bone.CalcVolume(), before_mm3, 1e-12 * before_mm3);
}

TEST(FindRemoved, HasAllThatABurRemovedAsAWhole) {
  const Bone before = test::MakeBox(test::BlockPoses(0.1)[4], {7, 7, 7}, 0.1);
  Bone after = before;
  const Vec3 centre = before.CalcBounds().centre();
  CutAway(after, after.CalcBounds(), [&](const Vec3& p_W) { return 3 - glm::length(p_W - centre); });
  openvdb::FloatGrid& phi = *GridsOf(after).phi;
  openvdb::tools::pruneLevelSet(phi.tree(), phi.background(), -phi.background());
  double sum_mm3 = 0;
  for (const RemovedCell& cell : FindRemoved(before, after)) sum_mm3 += cell.mm3;
  const double removed_mm3 = before.CalcVolume() - after.CalcVolume();
  EXPECT_NEAR(sum_mm3, removed_mm3, 1e-9 * removed_mm3);
  EXPECT_NEAR(removed_mm3, 4.0 / 3 * std::numbers::pi * std::pow(3, 3), 0.1);
  // In both directions, and among the blocks are some that have no leaf in either bone.
  const auto changed = FindChangedLeaves(before, after);
  EXPECT_EQ(FindChangedLeaves(after, before), changed);
  const auto has_no_leaf = [&](const std::array<int, 3>& index) {
    const openvdb::Coord origin = OriginOf(index);
    return phi.tree().probeConstLeaf(origin) == nullptr &&
           GridsOf(before).phi->tree().probeConstLeaf(origin) == nullptr;
  };
  EXPECT_TRUE(std::any_of(changed.begin(), changed.end(), has_no_leaf));
}

TEST(TwoFields, APieceBesideLeavesThatWereEmptiedIsTakenOut) {
  // The kerf is wider than two leaves of 0.8 mm.
  CutBlock cut(test::BlockPoses(0.1)[6], 0.1, 2.5);
  const double before_mm3 = cut.bone.CalcVolume();
  openvdb::FloatGrid& phi = *GridsOf(cut.bone).phi;
  openvdb::tools::pruneLevelSet(phi.tree(), phi.background(), -phi.background());
  ASSERT_NEAR(cut.bone.CalcVolume(), before_mm3, 1e-9 * before_mm3);  // summed in another order
  const PieceRemoval removal = MakePieceRemoval(cut.bone, PieceFinder(cut.bone, 0.5), 2);
  Bone rest = cut.bone;
  for (const LeafChange& change : removal.leaves) {
    SetCut(rest, change.index, change.without);
    // A simulation can change leaves of bone only.
    const openvdb::Coord origin = OriginOf(change.index);
    EXPECT_TRUE(phi.tree().probeConstLeaf(origin) != nullptr || phi.tree().getValue(origin) < 0);
  }
  double removed_mm3 = 0;
  for (const double mm3 : removal.mm3) removed_mm3 += mm3;
  EXPECT_GT(removed_mm3, 20);
  EXPECT_NEAR(rest.CalcVolume() + removed_mm3, before_mm3, 1e-9 * before_mm3);
}

/// Returns the distance from a point to a triangle.
double CalcDistance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = glm::cross(b - a, c - a);
  const auto to_side = [&](const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    const double t = std::clamp(glm::dot(p - from, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::length(p - from - t * along);
  };
  const auto is_inside = [&](const Vec3& from, const Vec3& to) {
    return glm::dot(glm::cross(to - from, p - from), n) >= 0;
  };
  if (glm::length(n) > 0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a)) {
    return std::abs(glm::dot(p - a, n)) / glm::length(n);
  }
  return std::min({to_side(a, b), to_side(b, c), to_side(c, a)});
}

TEST(TwoFields, TheEdgesOfAnExtractedPieceAreSharp) {
  // The edges between the walls of the kerf and the block's faces, away from the block's own edges.
  constexpr double kClear_mm = 0.3;
  for (const Pose& X_WB : test::BlockPoses(0.1)) {
    const CutBlock cut(X_WB, 0.1);
    double worst_edge = 0, worst_point = 0;
    for (const Bone& piece : SplitPieces(cut.bone, 0.5).pieces) {
      TriangleMesh mesh = ExtractSurface(piece);
      EXPECT_EQ(CountOpenEdges(mesh), 0u);
      const bool is_right = X_WB.InversePoint(piece.CalcBounds().lower + piece.CalcBounds().upper).x > 0;
      const double wall = 0.03 + (is_right ? 0.2 : -0.2);
      for (Vec3& p : mesh.points) p = X_WB.InversePoint(p);
      for (const Vec3& p : mesh.points) {
        if (std::abs(p.x - wall) > 0.3) continue;
        // Of the block's faces, the point must be near one only.
        const double y = 2 - std::abs(p.y), z = 1.5 - std::abs(p.z);
        if (std::max(y, z) < kClear_mm) continue;
        const double outside = std::max({is_right ? wall - p.x : p.x - wall, -y, -z});
        worst_point = std::max(worst_point, std::abs(outside));
      }
      for (int side = 0; side < 4; ++side) {
        for (int i = 0; i <= 200; ++i) {
          const double t = -1 + 0.01 * i;
          const double sign = side % 2 == 0 ? 1 : -1;
          const Vec3 on_edge =
              side < 2 ? Vec3(wall, t * (2 - kClear_mm), sign * 1.5) : Vec3(wall, sign * 2, t * (1.5 - kClear_mm));
          double nearest = 1;
          for (const auto& [a, b, c] : mesh.triangles) {
            if (glm::length(mesh.points[a] - on_edge) > 0.5) continue;
            nearest = std::min(nearest, CalcDistance(on_edge, mesh.points[a], mesh.points[b], mesh.points[c]));
          }
          worst_edge = std::max(worst_edge, nearest);
        }
      }
    }
    // Where no edge of the grid crosses the surface near the edge of the piece, the edge gets vertices of its own.
    EXPECT_LT(worst_edge, 0.02);
    EXPECT_LT(worst_point, 0.01);
  }
}

TEST(TwoFields, TheSurfaceOfAPieceIsManifoldAndFacesOutward) {
  // Vertices at the same place, in the precision of a file, are one: programs that read STL join them.
  for (const Pose& X_WB : test::BlockPoses(0.1)) {
    const CutBlock cut(X_WB, 0.1);
    for (const Bone& piece : SplitPieces(cut.bone, 0.5).pieces) {
      const TriangleMesh mesh = ExtractSurface(piece);
      const bool is_right = X_WB.InversePoint(piece.CalcBounds().lower + piece.CalcBounds().upper).x > 0;
      std::map<std::array<float, 3>, int> places;
      std::vector<int> place_of;
      for (const Vec3& p : mesh.points) {
        const std::array<float, 3> place{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
        place_of.push_back(places.try_emplace(place, static_cast<int>(places.size())).first->second);
      }
      std::map<std::pair<int, int>, int> edges;
      double wrong_mm2 = 0;
      for (const auto& [a, b, c] : mesh.triangles) {
        const int corners[3] = {place_of[a], place_of[b], place_of[c]};
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        for (int k = 0; k < 3; ++k) ++edges[{corners[k], corners[(k + 1) % 3]}];
        const Vec3 p_B[3] = {X_WB.InversePoint(mesh.points[a]), X_WB.InversePoint(mesh.points[b]),
                             X_WB.InversePoint(mesh.points[c])};
        const double wall = 0.03 + (is_right ? 0.2 : -0.2);
        if (!std::all_of(p_B, p_B + 3, [&](const Vec3& p) { return std::abs(p.x - wall) < 2e-3; })) continue;
        const Vec3 area = 0.5 * glm::cross(p_B[1] - p_B[0], p_B[2] - p_B[0]);
        wrong_mm2 += std::max(is_right ? area.x : -area.x, 0.0);
      }
      int several = 0;
      for (const auto& [edge, count] : edges) several += count > 1 ? 1 : 0;
      EXPECT_EQ(several, 0);
      // Beside the edges, triangles of a wall may be folded within it. They must not cover more than 0.015 voxels along
      // the wall's edges of 14 mm.
      EXPECT_LT(wrong_mm2, 0.02);
    }
  }
}

TEST(TwoFields, SurfacesAreClosedAroundMetalThatWasKept) {
  SolidField field;
  field.value = [](const Vec3& p_W) { return test::BoxDistance(p_W, {2, 2, 2}); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p_W) { return p_W.x > 0 ? 25 : 24; };
  MaterialTable materials = test::OneRegionTable();
  materials.Add({25, "metal", Tissue::kMetal, 110000, 0.3, true, "test"});
  Bone bone = MakeBone(field, {{-3, -3, -3}, {3, 3, 3}}, {0.2, 0.2, {}}, materials);
  // A tool takes all of the bone and none of the metal.
  std::array<float, 512> cut;
  for (const BoneLeaf& leaf : ListLeaves(Bone(bone))) {
    GetCut(bone, {leaf.first_voxel[0] >> 3, leaf.first_voxel[1] >> 3, leaf.first_voxel[2] >> 3}, cut);
    for (int i = 0; i < 512; ++i) {
      if (leaf.first_voxel[0] + i / 64 <= 0) cut[static_cast<std::size_t>(i)] = GridsOf(bone).phi->background();
    }
    SetCut(bone, {leaf.first_voxel[0] >> 3, leaf.first_voxel[1] >> 3, leaf.first_voxel[2] >> 3}, cut);
  }
  const TriangleMesh mesh = ExtractSurface(bone);
  EXPECT_GT(mesh.triangles.size(), 100u);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
}

TEST(TwoFields, AFieldReadsLeavesThatWereEmptiedOutsideTheBone) {
  // An end of a rod is cut away wherever it was within the band. Its leaves are empty, and several lie beyond those of
  // the rest. Cells of the rest reach into the first of them.
  Bone bone = test::MakeBox({}, {7.5, 1, 1}, 0.1);
  const float band = GridsOf(bone).phi->background();
  std::array<float, 512> whole, cut;
  for (const BoneLeaf& leaf : ListLeaves(Bone(bone))) {
    const std::array<int, 3> index{leaf.first_voxel[0] >> 3, leaf.first_voxel[1] >> 3, leaf.first_voxel[2] >> 3};
    if (index[0] < 2) continue;
    GetLeaf(bone, index, whole);
    for (std::size_t i = 0; i < 512; ++i) cut[i] = whole[i] < band ? band : -band;
    SetCut(bone, index, cut);
  }
  openvdb::FloatTree& phi = GridsOf(bone).phi->tree();
  openvdb::tools::pruneLevelSet(phi, band, -band);
  const BoneField field(bone, 0);
  for (auto leaf = GridsOf(bone).cut->tree().cbeginLeaf(); leaf; ++leaf) {
    ASSERT_EQ(phi.probeConstLeaf(leaf->origin()), nullptr);
  }
  for (const BoneLeaf& leaf : ListLeaves(bone)) {
    for (int i = 0; i < 512; ++i) {
      const Vec3 p_vox =
          Vec3(leaf.first_voxel[0] + i / 64, leaf.first_voxel[1] + i / 8 % 8, leaf.first_voxel[2] + i % 8) + 0.5;
      ASSERT_NEAR(field.Sample(p_vox), bone.SignedDistance(0.1 * p_vox), 1e-12);
    }
  }
}

TEST(TwoFields, ACutSentLeafByLeafMakesTheSameBone) {
  const CutBlock cut(test::BlockPoses(0.2)[5], 0.2);
  Bone copy = cut.before;
  std::array<float, 512> values;
  for (const BoneLeaf& leaf : ListLeaves(cut.bone)) {
    const std::array<int, 3> index{leaf.first_voxel[0] >> 3, leaf.first_voxel[1] >> 3, leaf.first_voxel[2] >> 3};
    GetCut(cut.bone, index, values);
    SetCut(copy, index, values);
  }
  EXPECT_EQ(copy.CalcHash(), cut.bone.CalcHash());
  EXPECT_EQ(copy.CalcVolume(), cut.bone.CalcVolume());
}

}  // namespace
}  // namespace kerf
