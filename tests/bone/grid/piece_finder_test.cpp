// The pieces of a bone that is cut leaf by leaf, compared with a flood fill of all voxels.
#include "bone/grid/piece_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <random>
#include <vector>

#include "bone/grid/set_leaf.h"
#include "kerf/surface.h"
#include "support/seeded_check.h"
#include "support/solids.h"

namespace kerf {
namespace {

constexpr int kLeaves = 4;  // number of leaves along each axis, starting at leaf -2
constexpr int kEdge = 8 * kLeaves;
constexpr int kFirst = -2;
constexpr double kVoxel_mm = 0.5;

/// All voxels of the leaves in a plain array.
struct Voxels {
  std::vector<float> phi = std::vector<float>(kEdge * kEdge * kEdge, 1.0F);

  static std::size_t Place(int x, int y, int z) {
    const int at = (x * kEdge + y) * kEdge + z;
    return static_cast<std::size_t>(at);
  }
  float& At(int x, int y, int z) { return phi[Place(x, y, z)]; }
  bool IsIn(int x, int y, int z) const {
    if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= kEdge) return false;
    return phi[Place(x, y, z)] < 0;
  }
  std::array<float, 512> Leaf(const std::array<int, 3>& n) {
    std::array<float, 512> values;
    for (int i = 0; i < 512; ++i) {
      values[static_cast<std::size_t>(i)] = At(8 * n[0] + i / 64, 8 * n[1] + i / 8 % 8, 8 * n[2] + i % 8);
    }
    return values;
  }
};

template <typename Visit>
void ForEachLeafOf(Visit visit) {
  for (int i = 0; i < kLeaves * kLeaves * kLeaves; ++i) {
    const std::array<int, 3> n{i / (kLeaves * kLeaves), i / kLeaves % kLeaves, i % kLeaves};
    visit(n, std::array<int, 3>{kFirst + n[0], kFirst + n[1], kFirst + n[2]});
  }
}

Bone MakeBoneOf(Voxels& voxels) {
  Bone bone = test::MakeBox({}, Vec3(20 * kVoxel_mm), kVoxel_mm);
  ForEachLeafOf([&](const auto& n, const auto& index) { SetLeaf(bone, index, voxels.Leaf(n)); });
  return bone;
}

struct Piece {
  std::size_t voxels = 0;
  std::array<int, 3> low{kEdge, kEdge, kEdge}, high{-1, -1, -1};
  bool operator<(const Piece& other) const {
    return std::tie(other.voxels, low, high) < std::tie(voxels, other.low, other.high);
  }
  bool operator==(const Piece& other) const { return voxels == other.voxels && low == other.low && high == other.high; }
};

/// Returns the pieces found by a flood fill, largest first.
std::vector<Piece> BruteForce(const Voxels& voxels) {
  std::vector<bool> seen(voxels.phi.size());
  std::vector<Piece> pieces;
  for (int seed = 0; seed < kEdge * kEdge * kEdge; ++seed) {
    if (seen[static_cast<std::size_t>(seed)] || !(voxels.phi[static_cast<std::size_t>(seed)] < 0)) continue;
    Piece piece;
    std::vector<int> stack{seed};
    seen[static_cast<std::size_t>(seed)] = true;
    while (!stack.empty()) {
      const int at = stack.back();
      stack.pop_back();
      const std::array<int, 3> p{at / (kEdge * kEdge), at / kEdge % kEdge, at % kEdge};
      ++piece.voxels;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        piece.low[axis] = std::min(piece.low[axis], p[axis]);
        piece.high[axis] = std::max(piece.high[axis], p[axis]);
        for (const int side : {-1, 1}) {
          std::array<int, 3> q = p;
          q[axis] += side;
          if (!voxels.IsIn(q[0], q[1], q[2])) continue;
          const int next = (q[0] * kEdge + q[1]) * kEdge + q[2];
          if (seen[static_cast<std::size_t>(next)]) continue;
          seen[static_cast<std::size_t>(next)] = true;
          stack.push_back(next);
        }
      }
    }
    pieces.push_back(piece);
  }
  std::sort(pieces.begin(), pieces.end());
  return pieces;
}

std::vector<Piece> Found(const FoundPieces& found) {
  std::vector<Piece> pieces;
  for (const FoundPiece& p : found.pieces) {
    Piece piece;
    piece.voxels = p.voxels;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<int>(axis);
      piece.low[axis] = static_cast<int>(std::lround(p.bounds_W.lower[i] / kVoxel_mm + 0.5)) - 8 * kFirst;
      piece.high[axis] = static_cast<int>(std::lround(p.bounds_W.upper[i] / kVoxel_mm - 0.5)) - 8 * kFirst;
    }
    pieces.push_back(piece);
  }
  std::sort(pieces.begin(), pieces.end());
  return pieces;
}

/// Returns random voxels of some density, or a solid block.
Voxels Draw(std::mt19937_64& random) {
  Voxels voxels;
  const double density = std::array{0.25, 0.32, 0.5, 0.85, 1.0}[random() % 5];
  std::uniform_real_distribution<double> dice;
  for (float& phi : voxels.phi) phi = dice(random) < density ? -0.5F : 0.5F;
  return voxels;
}

/// Removes a ball or a slab; returns the leaves that it changed.
std::vector<std::array<int, 3>> Cut(std::mt19937_64& random, Voxels& voxels) {
  std::uniform_real_distribution<double> at(0, kEdge);
  std::normal_distribution<double> n;
  const bool ball = random() % 2 == 0;
  const Vec3 centre(at(random), at(random), at(random));
  const Vec3 normal = glm::normalize(Vec3(n(random), n(random), n(random)));
  const double radius = 1 + 0.2 * at(random);
  std::map<std::array<int, 3>, bool> changed;
  for (int x = 0; x < kEdge; ++x) {
    for (int y = 0; y < kEdge; ++y) {
      for (int z = 0; z < kEdge; ++z) {
        const Vec3 d = Vec3(x, y, z) - centre;
        const bool in = ball ? glm::length(d) < radius : std::abs(glm::dot(d, normal)) < 0.9;
        if (!in || !voxels.IsIn(x, y, z)) continue;
        voxels.At(x, y, z) = 0.25F;
        changed[{x / 8, y / 8, z / 8}] = true;
      }
    }
  }
  std::vector<std::array<int, 3>> leaves;
  for (const auto& [leaf, yes] : changed) leaves.push_back(leaf);
  return leaves;
}

TEST(PieceFinder, MatchesAFloodFillAfterEveryCut) {
  EXPECT_TRUE(test::CheckSeeded(20261120, 25, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Voxels voxels = Draw(random);
    PieceFinder finder(MakeBoneOf(voxels), 0);
    RC_ASSERT(Found(finder.found()) == BruteForce(voxels));
    for (int cut = 0; cut < 6; ++cut) {
      for (const auto& n : Cut(random, voxels)) {
        finder.Change({kFirst + n[0], kFirst + n[1], kFirst + n[2]}, voxels.Leaf(n));
      }
      RC_ASSERT(Found(finder.Find()) == BruteForce(voxels));
      RC_ASSERT(finder.found().dust_count == 0u);
    }
    // The finder's state equals that of a new finder.
    RC_ASSERT(Found(PieceFinder(MakeBoneOf(voxels), 0).found()) == Found(finder.found()));
  }));
}

TEST(PieceFinder, LosesNoVolumeToDustOrPieces) {
  EXPECT_TRUE(test::CheckSeeded(7, 10, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Voxels voxels = Draw(random);
    const double voxel_mm3 = kVoxel_mm * kVoxel_mm * kVoxel_mm;
    const double dust_mm3 = 27 * voxel_mm3;
    PieceFinder finder(MakeBoneOf(voxels), dust_mm3);
    for (int cut = 0; cut < 4; ++cut) {
      for (const auto& n : Cut(random, voxels)) {
        finder.Change({kFirst + n[0], kFirst + n[1], kFirst + n[2]}, voxels.Leaf(n));
      }
      const FoundPieces& found = finder.Find();
      double sum_mm3 = found.dust_mm3;
      for (const FoundPiece& piece : found.pieces) {
        RC_ASSERT(piece.volume_mm3 >= dust_mm3);
        sum_mm3 += piece.volume_mm3;
        // The leaves of a piece contain its voxels and no others.
        std::size_t held = 0;
        finder.ForEachLeaf(piece.id, [&](const auto&, const LeafMask& mask) {
          for (const std::uint64_t word : mask) held += static_cast<std::size_t>(std::popcount(word));
        });
        RC_ASSERT(held == piece.voxels);
      }
      const auto inside = std::count_if(voxels.phi.begin(), voxels.phi.end(), [](float phi) { return phi < 0; });
      // The volumes are integers times an eighth, so the sum is exact.
      RC_ASSERT(sum_mm3 == static_cast<double>(inside) * voxel_mm3);
      const std::vector<Piece> all = BruteForce(voxels);
      const auto dust = static_cast<std::size_t>(
          std::count_if(all.begin(), all.end(), [](const Piece& piece) { return piece.voxels < 27; }));
      RC_ASSERT(found.dust_count == dust);
      RC_ASSERT(found.pieces.size() == all.size() - dust);
      // These are the same pieces as those computed at the end of a run, which knows their exact volumes.
      const Pieces split = SplitPieces(MakeBoneOf(voxels), dust_mm3);
      RC_ASSERT(split.pieces.size() + split.dust_count == all.size());
      for (const Bone& piece : split.pieces) RC_ASSERT(piece.CalcVolume() >= dust_mm3);
    }
  }));
}

TEST(PieceFinder, LargerPartKeepsTheId) {
  Voxels voxels;
  const auto fill = [&](int x0, int x1, float phi) {
    for (int x = x0; x < x1; ++x) {
      for (int y = 10; y < 20; ++y) {
        for (int z = 10; z < 20; ++z) voxels.At(x, y, z) = phi;
      }
    }
  };
  fill(2, 30, -1);
  PieceFinder finder(MakeBoneOf(voxels), 0);
  const auto find_pieces = [&] {
    ForEachLeafOf([&](const auto& n, const auto& index) { finder.Change(index, voxels.Leaf(n)); });
    return finder.Find();
  };
  ASSERT_EQ(finder.found().pieces.size(), 1u);
  EXPECT_EQ(finder.found().pieces[0].id, 1);
  EXPECT_FALSE(finder.changed());
  EXPECT_TRUE(find_pieces().came_off.empty());  // nothing has changed

  fill(20, 21, 1);
  FoundPieces found = find_pieces();
  ASSERT_EQ(found.came_off.size(), 1u);
  EXPECT_EQ(found.came_off[0].id, 2);
  EXPECT_EQ(found.came_off[0].from, 1);
  EXPECT_EQ(found.came_off[0].voxels, 900u);
  EXPECT_EQ(found.At(1)->voxels, 1800u);
  EXPECT_EQ(found.came_off[0].bounds_W.lower.x, kVoxel_mm * (21 + 8 * kFirst - 0.5));
  EXPECT_EQ(found.came_off[0].bounds_W.upper.x, kVoxel_mm * (29 + 8 * kFirst + 0.5));

  fill(22, 24, 1);  // splits piece 2; its smaller part becomes piece 3
  found = find_pieces();
  ASSERT_EQ(found.came_off.size(), 1u);
  EXPECT_EQ(found.came_off[0].id, 3);
  EXPECT_EQ(found.came_off[0].from, 2);
  EXPECT_EQ(found.came_off[0].voxels, 100u);
  EXPECT_EQ(found.At(2)->voxels, 600u);
  EXPECT_EQ(found.At(2)->from, 1);

  fill(21, 22, 1);  // cut away completely: not reported again
  found = find_pieces();
  EXPECT_TRUE(found.came_off.empty());
  EXPECT_EQ(found.At(3), nullptr);
  EXPECT_EQ(found.pieces.size(), 2u);
  EXPECT_EQ(finder.FindMainRegion(1), 24);
  EXPECT_EQ(finder.FindMainRegion(3), 0);
}

// Two voxels are connected if they share a face, but not if they share only an edge or a corner.
TEST(PieceFinder, FacesConnectAndEdgesDoNot) {
  for (const bool across_leaves : {false, true}) {
    Voxels voxels;
    const int x = across_leaves ? 15 : 11;
    voxels.At(x, 10, 10) = voxels.At(x + 1, 11, 10) = -1;
    EXPECT_EQ(PieceFinder(MakeBoneOf(voxels), 0).found().pieces.size(), 2u);
    voxels.At(x, 11, 10) = -1;
    EXPECT_EQ(PieceFinder(MakeBoneOf(voxels), 0).found().pieces.size(), 1u);
  }
}

TEST(PieceFinder, EmptyBoneHasNoPieces) {
  Voxels voxels;
  PieceFinder finder(MakeBoneOf(voxels), 0);
  EXPECT_TRUE(finder.found().pieces.empty());
  EXPECT_FALSE(finder.Change({0, 0, 0}, voxels.Leaf({2, 2, 2})));
  EXPECT_TRUE(finder.Find().pieces.empty());
}

}  // namespace
}  // namespace kerf
