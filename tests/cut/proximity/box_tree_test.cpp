// The nearest box that Embree finds, compared with a search of all boxes, and the bound for a plate, compared with
// points of the plate.
#include "cut/proximity/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace kerf {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double In(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(engine_); }
  Vec3 Point(double reach) { return {In(-reach, reach), In(-reach, reach), In(-reach, reach)}; }
  Vec3 Direction() {
    for (;;) {
      const Vec3 v = Point(1);
      const double length = glm::length(v);
      if (length > 0.1 && length < 1) return v / length;
    }
  }

 private:
  std::mt19937 engine_;
};

std::vector<Box3> RandomBoxes(Dice& dice, int count, const Vec3& middle) {
  std::vector<Box3> boxes;
  for (int i = 0; i < count; ++i) {
    const Vec3 centre = middle + dice.Point(30);
    const Vec3 half(dice.In(0.1, 2), dice.In(0.1, 2), dice.In(0.1, 2));
    boxes.push_back({centre - half, centre + half});
  }
  return boxes;
}

double BruteForce(const std::vector<Box3>& boxes, const Vec3& p) {
  double best = kInfinity;
  for (const Box3& box : boxes) {
    best = std::min(best, glm::length(glm::max(glm::max(box.lower - p, p - box.upper), Vec3{0})));
  }
  return best;
}

// Boxes are rounded outwards to floats relative to their middle: for a size of 60 mm, to 4e-6 mm.
constexpr double kRounding_mm = 1e-5;

TEST(BoxTree, DistanceMatchesBruteForce) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Dice dice(seed);
    const Vec3 middle = seed % 2 ? Vec3{0} : Vec3{700, -900, 1300};  // also far from the world's origin
    const std::vector<Box3> boxes = RandomBoxes(dice, 1 + static_cast<int>(seed * seed), middle);
    const BoxTree tree(boxes);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = middle + dice.Point(i % 3 ? 40 : 400);
      const double distance = tree.FindNearest(p, kInfinity).distance_mm;
      const double expected = BruteForce(boxes, p);
      EXPECT_LE(distance, expected + 1e-12);
      EXPECT_NEAR(distance, expected, kRounding_mm) << "seed " << seed;
      EXPECT_LE(tree.CalcDistanceToAll(p), expected + 1e-9);
    }
  }
}

TEST(BoxTree, NearestPointLiesOnABoxAndWithinTheLimit) {
  Dice dice(6);
  const std::vector<Box3> boxes = RandomBoxes(dice, 100, {50, 0, 0});
  const BoxTree tree(boxes);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = Vec3(50, 0, 0) + dice.Point(50);
    const double expected = BruteForce(boxes, p);
    const BoxTree::Nearest nearest = tree.FindNearest(p, kInfinity);
    EXPECT_NEAR(glm::length(nearest.p_W - p), expected, kRounding_mm);
    EXPECT_LE(BruteForce(boxes, nearest.p_W), kRounding_mm);
    for (const double limit : {0.5 * expected, expected + 0.1, 3.0}) {
      EXPECT_NEAR(tree.FindNearest(p, limit).distance_mm, std::min(limit, expected), kRounding_mm);
    }
  }
}

TEST(BoxTree, PlateBoundNeverExceedsTheDistanceOfThePlatesPoints) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Dice dice(seed);
    const std::vector<Box3> boxes = RandomBoxes(dice, 60, Vec3{0});
    const BoxTree tree(boxes);
    for (int i = 0; i < 50; ++i) {
      const Plate plate{dice.Point(40), dice.Direction(), dice.In(0.2, 6), dice.In(0, 0.5)};
      const double bound = tree.CalcPlateBound(plate, kInfinity, -kInfinity);
      const Vec3 side =
          glm::normalize(glm::cross(plate.normal_W, std::abs(plate.normal_W.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
      const Vec3 up = glm::cross(plate.normal_W, side);
      double smallest = kInfinity;
      for (int k = 0; k < 400; ++k) {
        // A plate comes nearest with the rim of its flats, except for boxes above its middle.
        const double angle = 2 * std::numbers::pi * (k % 100) / 100;
        const double radius = plate.radius_mm * (k < 200 ? 1 : dice.In(0, 1));
        const double height = plate.half_thickness_mm * (k % 2 ? 1 : -1);
        smallest = std::min(
            smallest, BruteForce(boxes, plate.centre_W + radius * (std::cos(angle) * side + std::sin(angle) * up) +
                                            height * plate.normal_W));
      }
      EXPECT_LE(bound, smallest + kRounding_mm) << "seed " << seed;
    }
  }
}

TEST(BoxTree, PlateBoundIsExactBesideALargeFace) {
  // The box is so large that, for every plate above it, the nearest point is straight below.
  const BoxTree tree({Box3{{-500, -500, -10}, {500, 500, 0}}});
  for (const double degrees : {0.0, 10.0, 45.0, 80.0, 90.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Plate plate{{1, 2, 9}, {std::sin(angle), 0, std::cos(angle)}, 3, 0.25};
    EXPECT_NEAR(tree.CalcPlateBound(plate, kInfinity, -kInfinity), 9 - 3 * std::sin(angle) - 0.25 * std::cos(angle),
                1e-4);
  }
}

TEST(BoxTree, SearchStopsAtASufficientBound) {
  Dice dice(5);
  const std::vector<Box3> boxes = RandomBoxes(dice, 200, Vec3{0});
  const BoxTree tree(boxes);
  for (int i = 0; i < 200; ++i) {
    const Plate plate{dice.Point(40), dice.Direction(), 2, 0.1};
    const double exact = tree.CalcPlateBound(plate, kInfinity, -kInfinity);
    for (const double enough : {-1.0, 0.5, 3.0, 20.0}) {
      const double quick = tree.CalcPlateBound(plate, kInfinity, enough);
      if (exact > enough) {
        EXPECT_EQ(quick, exact);
      } else {
        EXPECT_LE(quick, enough);
      }
    }
  }
}

TEST(BoxTree, WithoutBoxesNothingIsNear) {
  const BoxTree tree({});
  EXPECT_EQ(tree.FindNearest({1, 2, 3}, kInfinity).distance_mm, kInfinity);
  EXPECT_EQ(tree.CalcPlateBound({{1, 2, 3}, {0, 0, 1}, 5, 1}, kInfinity, 0), kInfinity);
  EXPECT_EQ(tree.CalcDistanceToAll({1, 2, 3}), kInfinity);
}

TEST(BoxTree, ReportsItsMemory) {
  Dice dice(1);
  const BoxTree few(RandomBoxes(dice, 100, Vec3{0}));
  const BoxTree many(RandomBoxes(dice, 10000, Vec3{0}));
  EXPECT_GT(many.CalcMemoryBytes(), 10000 * 24u);   // at least the boxes themselves
  EXPECT_LT(many.CalcMemoryBytes(), 10000 * 400u);  // plus a small tree over them
  EXPECT_LT(few.CalcMemoryBytes(), many.CalcMemoryBytes());
}

}  // namespace
}  // namespace kerf
