#include "bone/material/atlas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <glm/gtc/constants.hpp>
#include <map>
#include <set>
#include <sstream>

#include "kerf/error.h"
#include "test_paths.h"

namespace kerf {
namespace {

constexpr double kBodyHeight_mm = 30;
constexpr double kRamusHeight_mm = 62;

/// Returns points of a mandible made of simple shapes at known places: a U of constant thickness with its base at z =
/// 0, and upright rami. In LPS, the chin is at y = 0 and the back at y = 80; the shape is exactly mirror-symmetric.
std::vector<Vec3> MakePlainMandible() {
  std::vector<Vec3> points;
  const auto add = [&](double x, double y, double z) {
    points.emplace_back(x, y, z);
    points.emplace_back(-x, y, z);
  };
  // Seen from above, the midline of the bone is x = 45 sqrt(y / 80).
  for (double y = 0; y <= 80; y += 0.5) {
    const double x = 45 * std::sqrt(y / 80);
    const Vec3 along = glm::normalize(Vec3{22.5 / 80 / std::sqrt(std::max(y, 0.05) / 80), 1, 0});
    const Vec3 outward{along.y, -along.x, 0};
    const double top = y < 50 ? kBodyHeight_mm : 45;
    const double thickness = y < 50 ? 12 : 8;
    for (double z = 0; z <= top; z += 0.5) {
      for (const double side : {-0.5, 0.5}) add(x + side * thickness * outward.x, y + side * thickness * outward.y, z);
    }
    if (y < 50) continue;
    // The coronoid is in front, the condyle behind, and the notch between them.
    const double process = y < 60 ? 57 : y > 70 ? kRamusHeight_mm : 46;
    for (double z = 45; z <= process; z += 0.5) {
      for (const double side : {-0.5, 0.5}) add(x + side * thickness, y, z);
    }
  }
  return points;
}

std::vector<Vec3> Turned(const std::vector<Vec3>& points, const Pose& X) {
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back(X.Point(p));
  return out;
}

/// Returns the fraction of the points that keep their region when the head is rotated and moved.
double CalcKeptFraction(const std::vector<Vec3>& points, const Pose& X) {
  const MandibleAtlas straight(points);
  const std::vector<Vec3> turned_points = Turned(points, X);
  const MandibleAtlas turned(turned_points);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (straight.RegionAt(points[i]) == turned.RegionAt(turned_points[i])) ++kept;
  }
  return static_cast<double>(kept) / static_cast<double>(points.size());
}

std::vector<Pose> MakeHeadTurns() {
  std::vector<Pose> turns;
  const double angle = glm::radians(15.0);
  for (const Vec3& axis :
       {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, glm::normalize(Vec3{1, 1, 1}), glm::normalize(Vec3{1, -1, 1})}) {
    for (const double sign : {-1.0, 1.0}) turns.push_back({glm::angleAxis(sign * angle, axis), {12, -300, 1450}});
  }
  return turns;
}

std::vector<Vec3> ReadDynjaw() {
  std::ifstream file(KERF_TEST_DATA "/mesh_dynjaw/jaw_smooth.obj");
  std::vector<Vec3> points;
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string key;
    Vec3 p{0};
    if (words >> key >> p.x >> p.y >> p.z && key == "v") points.push_back(p);
  }
  return points;
}

void ExpectAll31(const std::vector<Vec3>& points) {
  const MandibleAtlas atlas(points);
  std::map<int, int> count;
  for (const Vec3& p : points) ++count[atlas.RegionAt(p)];
  for (int id = 1; id <= 31; ++id) EXPECT_GT(count[id], 0) << "no point of region " << id;
  EXPECT_EQ(count.size(), 31u) << "a region outside 1 to 31";
}

/// Walks down the body from crest to base; returns pairs of a region and the depth at which it begins, as a fraction of
/// the body's height.
std::vector<std::pair<int, double>> WalkDown(const MandibleAtlas& atlas, const Vec3& crest, double height) {
  std::vector<std::pair<int, double>> bands;
  for (double depth = 0.05; depth < height; depth += 0.05) {
    const int region = atlas.RegionAt(crest - Vec3{0, 0, depth});
    if (bands.empty() || bands.back().first != region) bands.emplace_back(region, depth / height);
  }
  return bands;
}

TEST(Atlas, APlainMandibleHasAll31Regions) {
  ExpectAll31(MakePlainMandible());
}

TEST(Atlas, CutThroughTheMolarBodyPassesThePapersRegionsInTheirBands) {
  const MandibleAtlas atlas(MakePlainMandible());
  for (const double side : {-1.0, 1.0}) {
    // The arch is 94 mm long from the chin to the back; y = 30 is 42 mm along it.
    for (const double offset : {-5.0, 0.0, 5.0}) {  // from lingual to facial: the bands extend through the full width
      const double x = 45 * std::sqrt(30.0 / 80) + offset;
      const auto bands = WalkDown(atlas, {side * x, 30, kBodyHeight_mm}, kBodyHeight_mm);
      ASSERT_EQ(bands.size(), 4u);
      const int order[] = {24, 21, 13, 6};
      for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(bands[i].first, order[i]);
        // The tolerance is twice the walk's step of 0.05 mm, relative to 30 mm.
        EXPECT_NEAR(bands[i].second, MandibleAtlas::kBodyBands[i], 0.004);
      }
    }
  }
}

TEST(Atlas, BordersAlongTheArchLieAtTheStatedFractionOfItsLength) {
  const MandibleAtlas atlas(MakePlainMandible());
  // Returns the length of x = 45 sqrt(y / 80), summed in small steps.
  const auto length_to = [](double y_end) {
    double length = 0;
    Vec3 last{0};
    for (int i = 1; i <= 20000; ++i) {
      const double y = y_end * i * i / 4e8;  // steps are small near the chin, where the curve is steep
      const Vec3 p{45 * std::sqrt(y / 80), y, 0};
      length += glm::distance(last, p);
      last = p;
    }
    return length;
  };
  const double whole = length_to(80);
  for (const double y : {5.0, 15.0, 30.0, 45.0}) {
    const MandibleCoordinates c = atlas.CalcCoordinates({45 * std::sqrt(y / 80), y, 10});
    // The arch is found from points in sectors of 2.5 degrees and smoothed.
    EXPECT_NEAR(c.along, length_to(y) / whole, 0.03) << y;
    // The bone is 12 mm thick, and near the chin it crosses the sectors obliquely.
    EXPECT_NEAR(c.facial_mm, 0, 2.0) << y;
    EXPECT_NEAR(c.depth, 20 / kBodyHeight_mm, 0.01) << y;
  }
}

TEST(Atlas, FacialAndLingualSidesDiffer) {
  const MandibleAtlas atlas(MakePlainMandible());
  EXPECT_EQ(atlas.RegionAt({0, -6, 2}), 1);
  EXPECT_EQ(atlas.RegionAt({0, 6, 2}), 2);
  EXPECT_EQ(atlas.RegionAt({0, -6, 28}), 17);
  EXPECT_EQ(atlas.RegionAt({0, 6, 28}), 18);
  EXPECT_EQ(atlas.RegionAt({48, 78, 5}), 5);
  EXPECT_EQ(atlas.RegionAt({40, 78, 5}), 7);
  EXPECT_EQ(atlas.RegionAt({42, 74, 61}), 31);
  EXPECT_EQ(atlas.RegionAt({44, 54, 55}), 27);
}

TEST(Atlas, LeftAndRightAreTheSame) {
  const std::vector<Vec3> points = MakePlainMandible();
  const MandibleAtlas atlas(points);
  for (const Vec3& p : points) {
    EXPECT_EQ(atlas.RegionAt(p), atlas.RegionAt({-p.x, p.y, p.z}));
  }
}

TEST(Atlas, ATurnedHeadKeepsItsRegions) {
  // The simple mandible rests exactly on the base plane, so only points at the borders of regions may change their
  // region.
  for (const Pose& X : MakeHeadTurns()) EXPECT_GT(CalcKeptFraction(MakePlainMandible(), X), 0.98);
}

TEST(Atlas, AScannedMandibleHasAll31RegionsAndKeepsThemWhenTurned) {
  const std::vector<Vec3> points = ReadDynjaw();
  if (points.empty()) GTEST_SKIP() << "not found: " << KERF_TEST_DATA << "/mesh_dynjaw/jaw_smooth.obj";
  ExpectAll31(points);
  for (const Pose& X : MakeHeadTurns()) EXPECT_GT(CalcKeptFraction(points, X), 0.97);
}

TEST(Atlas, TooFewAndDegeneratePointsAreRefused) {
  EXPECT_THAT(
      [] {
        MandibleAtlas({{0, 0, 0}, {1, 0, 0}});
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("fewer than 100")));
  EXPECT_THAT(
      [] {
        MandibleAtlas(std::vector<Vec3>(200, Vec3{1, 2, 3}));
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("mandible")));
  std::vector<Vec3> line;
  for (int i = 0; i < 500; ++i) line.emplace_back(0, 0, i);
  EXPECT_THAT([&] { MandibleAtlas{line}; }, testing::ThrowsMessage<Error>(testing::HasSubstr("left-right")));
  for (Vec3& p : line) p = {p.z, 0, 0};
  EXPECT_THAT([&] { MandibleAtlas{line}; }, testing::ThrowsMessage<Error>(testing::HasSubstr("extent")));
}

}  // namespace
}  // namespace kerf
